#!/usr/bin/env python3
"""Measures what parts of a picture cost beside their rendering, and writes the figures and the curve of docs/cluster.md.

    scripts/cluster/figures.py FOLDER     # FOLDER holds bunny_1m.obj (scripts/make_meshes.py)

For scene06, and for scene06 with 1,024,000 triangles, at 1600 x 1600 with -jitter -filter: the processor time of a run of
one pixel, which is what every part pays, and of whole runs in N parts. The efficiency with N parts is the processor time of
one part over that of all. A small simulation carries this on to clusters: WORKERS processors take tasks of equal numbers of
parts, the scheduler starts RATE tasks a second, and part times are drawn from the measured ones. A2 is the program.
"""

import os
import random
import re
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PROJECT / "scripts"))
sys.dont_write_bytecode = True
import log_plot  # noqa: E402

A2 = os.environ.get("A2", str(PROJECT / "target" / "release" / "a2"))
SIZE = int(os.environ.get("SIZE", "1600"))
FLAGS = ["-size", SIZE, SIZE, "-bounces", 4, "-jitter", "-filter", "-threads", 1, "-quiet"]
MEASURED = [int(count) for count in os.environ.get("PARTS", "1 4 16 64").split()]
# Of as many parts as these, every STEP-th is rendered for the spread of their times.
SPREAD = 256
STEP = 8


def seconds(scene, flags, folder):
    """Returns the processor time of a run."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [A2, "-input", scene, "-output", folder / "o.png", *FLAGS, *flags]
    subprocess.run([str(word) for word in command], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def scenes(folder, meshes):
    """Returns scene06, and scene06 with a mesh of a million triangles where there is one."""
    small = PROJECT / "data" / "scene06_bunny_1k.txt"
    found = [("scene06, 1,000 triangles", small)]
    if (meshes / "bunny_1m.obj").exists():
        text = re.sub(r"\bobj_file\s+\S+", f'obj_file "{meshes / "bunny_1m.obj"}"', small.read_text())
        text = re.sub(r"\bcubeMap\s+(\S+)", lambda m: f'cubeMap "{small.parent / m[1]}"', text)
        large = folder / "large.txt"
        large.write_text(text)
        found.append(("scene06, 1,024,000 triangles", large))
    return found


def makespan(work, fixed, spread, tasks, parts_a_task, workers, rate, generator):
    """Returns the seconds until all tasks have ended. `work` is that of the whole picture, `spread` the times of parts over
    their mean."""
    parts = tasks * parts_a_task
    free = [0.0] * workers
    for task in range(tasks):
        # The processor that is free first; the scheduler starts one task after the other.
        index = min(range(workers), key=free.__getitem__)
        times = sum(fixed + work / parts * generator.choice(spread) for _ in range(parts_a_task))
        free[index] = max(free[index], task / rate) + times
    return max(free)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    curves, rows, simulated = [], [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for title, scene in scenes(folder, Path(sys.argv[1]).resolve()):
            fixed = statistics.median(seconds(scene, ["-region", SIZE // 2, 0, 1, 1], folder) for _ in range(5))
            totals = {}
            for count in MEASURED:
                some = range(1, count + 1)
                totals[count] = sum(seconds(scene, ["-tile", f"{part}/{count}"], folder) for part in some)
                print(f"{title}: {count} parts, {totals[count]:.2f} s", flush=True)
            work = totals[1] - fixed
            times = [seconds(scene, ["-tile", f"{part}/{SPREAD}"], folder) - fixed for part in range(1, SPREAD + 1, STEP)]
            spread = [max(0.0, time) / statistics.mean(times) for time in times]
            limit = work / fixed / 9
            rows.append((title, fixed, work, totals, limit, statistics.pstdev(spread)))
            counts = [1, 4, 16, 64, 256, 1024, 4096, 10_000]
            curves.append((title, [(n, (work + fixed) / (work + n * fixed)) for n in counts]))
            generator = random.Random(1)
            for tasks, workers, rate in [(64, 16, 1), (1000, 100, 1), (10_000, 1000, 1), (10_000, 1000, 10)]:
                # A picture of 144 rays a pixel, so large that a task has a minute of work.
                large = 60.0 * tasks
                took = makespan(large, fixed, spread, tasks, 4, workers, rate, generator)
                simulated.append((title, tasks, workers, rate, took, large / workers / took))
    print("\n| scene | beside rendering, s a part | rendering, s | efficiency with " +
          " / ".join(f"{count}" for count in MEASURED) + " parts | below 90% from | spread of part times |")
    print("|---|---|---|---|---|---|")
    for title, fixed, work, totals, limit, spread in rows:
        shares = " / ".join(f"{totals[1] / totals[count]:.2f}" for count in MEASURED)
        print(f"| {title} | {fixed:.3f} | {work:.1f} | {shares} | {limit:.0f} parts | {100 * spread:.0f}% |")
    print("\n| scene | tasks of 4 parts, a minute of work each | processors | starts a second | hours | efficiency |")
    print("|---|---|---|---|---|---|")
    for title, tasks, workers, rate, took, share in simulated:
        print(f"| {title} | {tasks:,} | {workers:,} | {rate} | {took / 3600:.2f} | {share:.2f} |")
    log_plot.write_svg(PROJECT / "docs" / "cluster.svg", f"scene06 at {SIZE} x {SIZE} in parts, 144 rays a pixel",
                       "parts", "efficiency", curves)


if __name__ == "__main__":
    main()

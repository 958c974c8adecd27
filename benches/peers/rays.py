#!/usr/bin/env python3
"""Measures rays a second of Embree, and of a2's own ray bench if it is named, in turn and on the same rays.

    benches/peers/rays.py [--ours PROGRAM] [--data FOLDER] [--meshes NAME,...] [--threads N] [--rounds N] [--build]

PROGRAM is called like embree_rays, `PROGRAM MESH.obj --rays FILE --threads N --repeats N` (and `MESH.obj --build
--repeats N`), and prints lines of the same form, with `closest_hit` and `any_hit` as the names of its queries:

    closest_hit   threads 1  Mrays/s   12.30  (12.1 .. 12.5)  hits 203220 of 640000
    build         threads 1  ms        12.30  (12.1 .. 12.5)

Figures are medians over the rounds. Exit code 0: everything ran; 1: something failed; 3: no Embree to compare with.
"""

import argparse
import re
import shutil
import statistics
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

sys.dont_write_bytecode = True
from jobs import ROOT, make_mesh  # noqa: E402

HERE = Path(__file__).resolve().parent
# For each ray class: our query, and Embree's, for one ray at a time and for eight coherent rays.
CLASSES = {
    "camera": ("closest_hit", "rtcIntersect1", "rtcIntersect8"),
    "shadow": ("any_hit", "rtcOccluded1", "rtcOccluded8"),
    "mirror": ("closest_hit", "rtcIntersect1", "rtcIntersect8"),
    "random": ("closest_hit", "rtcIntersect1", "rtcIntersect8"),
}
LINE = re.compile(r"^(\w+).*? threads (\d+)\s+(?:Mrays/s|ms)\s+([\d.]+)(?:.*hits (\d+) of (\d+))?", re.M)


def output_of(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}\nended with code {done.returncode}: {done.stderr[-500:]}")
    return done.stdout


def in_turn(programs, arguments, rounds):
    """Parses output. For each (name of the query, threads): the figures of all rounds, and the counted hits."""
    figures, hits = defaultdict(list), {}
    for _ in range(rounds):
        for program in programs:
            for name, threads, figure, hit, total in LINE.findall(output_of([program, *arguments])):
                figures[name, int(threads)].append(float(figure))
                hits[name] = f"{hit}/{total}"
    return {key: statistics.median(values) for key, values in figures.items()}, hits


def meshes(args):
    for name in args.meshes.split(","):
        given = args.data / "models" / f"bunny_{name}.obj"
        path = given if given.exists() else make_mesh(name, args.data / "models" / "bunny_1k.obj", args.work)
        if path is None:
            print(f"bunny_{name}: left out, make_meshes.py failed (it needs numpy)", file=sys.stderr)
        else:
            yield name, path


def ray_rows(name, mesh, programs, args):
    for kind, queries in CLASSES.items():
        file = args.work / f"{name}_{kind}.rays"
        view = "scene05" if name == "200" else "scene06"
        output_of([programs[0], mesh, "--make-rays", kind, file, "--view", view])
        arguments = [mesh, "--rays", file, "--threads", args.threads, "--repeats", 5]
        rates, hits = in_turn(programs, arguments, args.rounds)
        cells = [name, kind]
        ours, one, eight = (rates.get((query, args.threads)) for query in queries)
        cells += [f"{one:.2f}", f"{eight:.2f}", hits[queries[1]]]
        if ours:
            cells += [f"{ours:.2f}", f"{ours / one:.2f}", f"{ours / eight:.2f}", hits[queries[0]]]
        yield cells


def build_rows(name, mesh, programs, args):
    times, _ = in_turn(programs, [mesh, "--build", "--repeats", 3], args.rounds)
    for threads in (1, 2):
        row = [name, str(threads), f"{times['embree_build', threads]:.1f}"]
        if ours := times.get(("build", threads)):
            row += [f"{ours:.1f}", f"{times['embree_build', threads] / ours:.2f}"]
        yield row


def print_table(columns, rows):
    print("\n| " + " | ".join(columns) + " |\n|" + "---|" * len(columns))
    for row in rows:
        print("| " + " | ".join(row) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--ours", type=Path)
    parser.add_argument("--data", type=Path, default=ROOT / "data")
    parser.add_argument("--work", type=Path, default=ROOT / "target" / "peers")
    parser.add_argument("--meshes", default="200,1k,64k,1m", help="of 200, 1k, 64k, 1m and 4m (200,1k,64k,1m)")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--build", action="store_true", help="building times as well")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    embree = args.work.resolve() / "embree_rays"
    make = ["make", "-s", "-C", HERE, f"OUT={embree.parent}"]
    if not shutil.which("make") or subprocess.run(make).returncode != 0:
        print("rays.py: embree_rays did not build (Debian: apt-get install g++ make libembree-dev)", file=sys.stderr)
        return 3
    ours = [args.ours.resolve()] if args.ours else []
    try:
        found = list(meshes(args))
        programs = [embree, *ours]
        print(f"M rays/s, {args.threads} thread(s); hits are those of the two programs on the same rays")
        columns = ["mesh", "rays", "Embree 1", "Embree 8", "its hits"]
        columns += ["a2", "against 1", "against 8", "a2's hits"] if ours else []
        print_table(columns, (row for name, mesh in found for row in ray_rows(name, mesh, programs, args)))
        if args.build:
            columns = ["mesh", "threads", "Embree, ms", *(["a2, ms", "ratio"] if ours else [])]
            print_table(columns, (row for name, mesh in found for row in build_rows(name, mesh, programs, args)))
    except (RuntimeError, OSError, KeyError) as error:
        print(f"rays.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

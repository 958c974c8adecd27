#!/usr/bin/env python3
"""Measures how well -time-limit is kept: whole processes, for small and large pictures, PNG and PFM.

Prints a table of the milliseconds between the end of the process and the limit (below 0: before it). The machine must
be quiet. LIMITS, SIZES, FORMATS and SCENES change what is tried; RUNS how often (the median and the worst are shown).
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.dont_write_bytecode = True
import batch  # noqa: E402

A2 = Path(os.environ.get("A2", batch.PROJECT / "target" / "release" / "a2"))


def words(name, default):
    return os.environ.get(name, default).split()


def late(scene, size, limit, kind, folder):
    """Returns the milliseconds from the limit to the end of a process."""
    command = [A2, "-input", batch.PROJECT / "data" / f"{scene.name}.txt", *scene.flags, "-size", size, size,
               "-output", folder / f"o.{kind}", "-time-limit", limit, "-samples", 65536, "-quiet"]
    command = [str(word) for word in command]
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True)
    # 3: some pixels show the preview.
    if done.returncode not in (0, 3):
        sys.exit(done.stderr)
    return 1e3 * (time.perf_counter() - start - limit)


def main():
    scenes = {scene.short_name: scene for scene in batch.read()}
    runs = int(os.environ.get("RUNS", "3"))
    print("| scene | file | pixels | limit, s | median, ms | worst, ms | allowed, ms | kept |\n|---|---|---|---|---|---|---|---|")
    kept = tried = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in words("SCENES", "scene02 scene07"):
            for kind in words("FORMATS", "png pfm"):
                for size in map(int, words("SIZES", "200 800 2000 4000")):
                    for limit in map(float, words("LIMITS", "0.1 0.3 1 3 5")):
                        found = sorted(late(scenes[name], size, limit, kind, Path(folder)) for _ in range(runs))
                        worst, allowed = max(found, key=abs), 50 * limit + 20
                        is_kept = abs(found[runs // 2]) <= allowed
                        kept, tried = kept + is_kept, tried + 1
                        print(f"| {name} | {kind} | {size} x {size} | {limit:g} | {found[runs // 2]:.0f} | {worst:.0f} | "
                              f"{allowed:.0f} | {'yes' if is_kept else 'no'} |", flush=True)
    print(f"\n{kept} of {tried} medians keep the limit.")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Measures what -target-error costs, and writes docs/adaptive-sampling.md. Two minutes on a quiet machine for SIZES=300, and
half an hour with 800.

First the camera rays a pixel for a true error of half a level, then the processor time as a multiple of what the best
fixed number of samples takes for the same true error. SIZES and SEEDS change how much is measured.
"""

import json
import math
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

sys.dont_write_bytecode = True
import batch  # noqa: E402
import error_vs_time_page  # noqa: E402

A2 = Path(os.environ.get("A2", batch.PROJECT / "target" / "release" / "a2"))
SEEDS = range(int(os.environ.get("SEEDS", "3")))
SIZES = [int(size) for size in os.environ.get("SIZES", "300 800").split()]
TARGETS = [4, 2, 1, 0.5, 0.25, 0.125]


def render(folder, scene, size, flags, repeats=1):
    """Returns true RMSE in levels, camera rays a pixel, and the median of the processor time of rendering and writing.

    Of fixed samples the film is made while they are rendered, and counts as writing.
    """
    command = [A2, "-input", batch.PROJECT / "data" / f"{scene.name}.txt", *scene.flags, "-size", size, size,
               "-output", folder / "o.pfm", "-report", folder / "r.json", "-threads", 1, "-quiet", *flags]
    times = []
    for _ in range(repeats):
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode not in (0, 3):
            sys.exit(done.stderr)
        report = json.loads((folder / "r.json").read_text())
        times.append(sum(report["phases"][phase]["cpu_seconds"] for phase in ("render", "filter", "encode")))
    error = report["true_error"]["rmse_levels"] if report["true_error"] else None
    return error, report["rays"]["camera"] / size**2, median(times)


def reference(folder, scene, size):
    """Renders the picture that counts as true, and returns the flags that compare with it."""
    picture = folder / f"{scene.number}-{size}.pfm"
    samples = 4096 if size <= 100 else 1024
    render(folder, scene, size, ["-samples", samples, "-sampler", "sobol", "-seed", 987654321])
    (folder / "o.pfm").rename(picture)
    return ["-reference", picture]


def between(points, error):
    """Returns the cost at an error on a curve of (error, cost); None beyond its ends."""
    cost, sign = error_vs_time_page.between(points, error)
    return None if sign else cost


def rays_for_half_a_level(folder, scene):
    """Returns the camera rays a pixel at 100 x 100 for a true RMSE of 0.5 levels: adaptive, and Sobol samples."""
    compare = reference(folder, scene, 100)
    def mean_square_and_rays(flags):
        runs = [render(folder, scene, 100, [*compare, "-seed", seed, *flags]) for seed in SEEDS]
        return math.sqrt(sum(run[0]**2 for run in runs) / len(runs)), sum(run[1] for run in runs) / len(runs)
    adaptive = [mean_square_and_rays(["-target-error", target]) for target in (1.4, 1.2, 1, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4)]
    fixed = [(mean_square_and_rays(["-samples", n, "-sampler", "sobol"])[0], n) for n in (4, 8, 16, 32, 64, 128, 256)]
    return between(adaptive, 0.5), between(fixed, 0.5)


def costs(folder, scene, size):
    """Returns for each target the true error, and the processor time over that of the best fixed sampler."""
    compare = reference(folder, scene, size)
    fixed = {sampler: [render(folder, scene, size, [*compare, "-samples", n, "-sampler", sampler], 3)
                       for n in (1, 2, 4, 8, 16, 32, 64)] for sampler in ("stratified", "sobol")}
    cells = []
    for target in TARGETS:
        error, _, seconds = render(folder, scene, size, [*compare, "-target-error", target, "-seed", 5], 3)
        best = [cost for curve in fixed.values() if (cost := between([(run[0], run[2]) for run in curve], error))]
        cells.append(f"{error:.2f}, {seconds / min(best):.2f}" if best else f"{error:.2f}, -")
    return cells


def main():
    lines = ["# What adaptive sampling costs", "", "Made by `scripts/adaptive.py`; do not edit. "
             f"One thread on {platform.machine()}, the scenes of `data/` with the flags of the batch.", "",
             "Camera rays a pixel for a true RMSE of 0.5 levels, 100 x 100 pixels, with the pilot's; "
             f"{len(SEEDS)} seeds. Sobol: samples of every pixel, were none left out in empty tiles.", "",
             "| scene | -target-error | Sobol |", "|---|---|---|"]
    shown = lambda number: f"{number:.1f}" if number else "-"
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for scene in batch.read():
            adaptive, fixed = rays_for_half_a_level(folder, scene)
            lines.append(f"| {scene.short_name} | {shown(adaptive)} | {shown(fixed)} |")
        for size in SIZES:
            lines += ["", f"{size} x {size} pixels, for each target in levels: the true error, and the processor time of "
                      "rendering and writing as a multiple of that of the best fixed number of stratified or Sobol samples, with "
                      "their own error estimated, for the same true error (`-`: beyond 1 to 64 samples):", "",
                      "| scene | " + " | ".join(str(target) for target in TARGETS) + " |",
                      "|---" * (len(TARGETS) + 1) + "|"]
            for scene in batch.read():
                lines.append(f"| {scene.short_name} | " + " | ".join(costs(folder, scene, size)) + " |")
    lines += ["", "Adaptive sampling begins with two samples of every pixel. Where few samples are enough, as 3 to 10 for 0.5 levels "
              "at 800 x 800, these alone take up to two thirds of the time of a fixed number."]
    (batch.PROJECT / "docs" / "adaptive-sampling.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

"""Writes docs/error-vs-time.md and its curves from the raw numbers of error_vs_time.py."""

import csv
import math
import os
import platform
import subprocess
from statistics import mean

from log_plot import write_svg

METHODS = ("independent", "stratified", "sobol", "adaptive")
# Two-sided 95% points of Student's t distribution, by degrees of freedom.
STUDENT = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31)


def write(root, size):
    page = Page(root, size)
    sections = [page.head(), page.curves("no"), page.curves("yes"), page.slopes(), page.equal(), page.halves(),
                page.fifth(), page.coverage(), page.bounces(), page.f32(), page.povray()]
    (root / "docs" / "error-vs-time.md").write_text("\n".join(section for section in sections if section))


class Page:
    def __init__(self, root, size):
        self.root, self.size = root, size
        self.folder = root / "docs" / "error-vs-time"
        self.rows = self.read("curves")
        self.scenes = sorted({row["scene"] for row in self.rows})

    def read(self, name):
        path = self.folder / f"{name}.csv"
        if not path.exists():
            return []
        return [{key: number(value) for key, value in row.items()} for row in csv.DictReader(open(path))]

    def points(self, scene, filtered, method, x="cpu_seconds"):
        return [(row[x], row["true"]) for row in self.rows
                if (row["scene"], row["filter"], row["method"]) == (scene, filtered, method)]

    def svg(self, name, title, x_label, y_label, curves):
        write_svg(self.folder / f"{name}.svg", title, x_label, y_label, curves)
        return f"![{title}](error-vs-time/{name}.svg)"

    def head(self):
        commit = subprocess.run(["git", "log", "-1", "--format=%h, %cs", "--", "src"], cwd=self.root, capture_output=True, text=True)
        own = {(row["scene"], row["filter"]): row["reference_error"] for row in self.rows}
        table = [f"| {scene} | {own[scene, 'no']:.3f} | {own[scene, 'yes']:.3f} |" for scene in self.scenes]
        return f"""# Error against run time

Made by `scripts/error_vs_time.sh` from the files in `error-vs-time/`; do not edit. {self.size} x {self.size} pixels,
{os.cpu_count()} threads on {processor()}, {platform.system()}, commit {commit.stdout.strip()}.

*Error* is the root mean square, over all pixels and channels, of the difference from a reference, with colours clamped
to [0, 1], times 255 and not truncated: byte levels. *Time* is CPU time of all threads, because it is steadier than the
clock on a machine that others use too; the clock's is in the raw numbers. Reading the scene, building trees and decoding
the cube map are in no point. The reference is a picture by Sobol samples from another seed, with
sixteen times the samples of the best point of a curve. Its own estimated error, in levels:

| scene | reference, plain | with `-filter` |
|---|---|---|
""" + "\n".join(table) + "\n"

    def curves(self, filtered):
        title, name = ("With `-filter`", "-filter") if filtered == "yes" else ("Without `-filter`", "")
        lines = [f"## {title}\n"]
        if filtered == "no":
            lines.append("Drawn by `a2 -convergence`, the reference as `-reference`.\n")
        lines += [f"![{scene}{name and ', ' + name}](error-vs-time/{scene}{name}.svg)" for scene in self.scenes]
        return "\n".join(lines) + "\n"

    def slopes(self):
        lines = ["""## Slopes

Of log error against log CPU time and against log samples, by least squares over all points, with 95% confidence bands. -0.5 is what independent samples must give; cells that
an edge crosses give -0.75, smooth shading up to -1.5.

| scene | filter | """ + " | ".join(f"{m}, time | {m}, samples" for m in METHODS) + " |",
                 "|---|---|" + "---|---|" * len(METHODS)]
        for scene in self.scenes:
            for filtered in ("no", "yes"):
                cells = []
                for method in METHODS:
                    rows = [row for row in self.rows if
                            (row["scene"], row["filter"], row["method"]) == (scene, filtered, method)]
                    for x in ("cpu_seconds", "samples"):
                        cells.append(slope([(row[x], row["true"]) for row in rows]))
                lines.append(f"| {scene} | {filtered} | " + " | ".join(cells) + " |")
        return "\n".join(lines) + "\n"

    def equal(self):
        lines = ["""## Equal time, equal error, efficiency

Measured by 16 independent samples a pixel (144 with `-filter`): the error of the other methods in the same CPU time, the
CPU time they need for the same error, and their efficiency, 1/(mean squared error x time), at that time, all as multiples of those of the
independent sampler. Between the points of a curve by straight lines on logarithmic axes; `>` and `<` where a curve ends before.

| scene | filter | """ + " | ".join(f"{m}: error | time | efficiency" for m in METHODS[1:]) + " |",
                 "|---|---|" + "---|---|---|" * (len(METHODS) - 1)]
        for scene in self.scenes:
            for filtered in ("no", "yes"):
                samples = 144 if filtered == "yes" else 16
                base = next(row for row in self.rows if row["samples"] == samples and (
                    row["scene"], row["filter"], row["method"]) == (scene, filtered, "independent"))
                time, error = base["cpu_seconds"], base["true"]
                cells = []
                for method in METHODS[1:]:
                    points = self.points(scene, filtered, method)
                    at_time, sign = between(points, time)
                    at_error, other_sign = between([(y, x) for x, y in points], error)
                    cells += [f"{sign}{at_time / error:.2f}", f"{other_sign}{at_error / time:.2f}",
                              f"{(error / at_time) ** 2:.1f}"]
                lines.append(f"| {scene} | {filtered} | " + " | ".join(cells) + " |")
        return "\n".join(lines) + "\n"

    def halves(self):
        rows = self.read("samples")
        if not rows:
            return ""
        errors = {(row["scene"], row["sampler"], row["samples"]): row["true"] for row in rows}
        lines = ["""## Eight even samples against sixteen independent ones

Undivided samples, root mean square error of 8 seeds in levels. The last column: whether 8 stratified or 8 Sobol samples
are at least as good as 16 independent ones.

| scene | independent 16 | stratified 8 | stratified 16 | sobol 8 | sobol 16 | 8 suffice |
|---|---|---|---|---|---|---|"""]
        for scene in self.scenes:
            base = errors[scene, "independent", 16]
            best = min(errors[scene, "stratified", 8], errors[scene, "sobol", 8])
            cells = [base] + [errors[scene, sampler, n] for sampler in ("stratified", "sobol") for n in (8, 16)]
            lines.append(f"| {scene} | " + " | ".join(f"{cell:.3f}" for cell in cells) +
                         f" | {'yes' if best <= base else 'no'} |")
        return "\n".join(lines) + "\n"

    def fifth(self):
        fixed = {row["scene"]: row["true"] for row in self.read("samples") if row["samples"] == 144}
        if not fixed:
            return ""
        lines = ["""## Adaptive sampling against the fixed 144 rays of `-jitter -filter`

Camera rays a pixel. *At 144's error*: what adaptive sampling needs to reach the error of the fixed 144. *Target 0.5*: what
`-target-error 0.5` took (or the largest target below it), and its true error, and the fixed number of rays that gives the same true error (by the fixed
samples' slope of -0.75 in error). The goal was a fifth.

| scene | true error of 144 | rays at 144's error | share | rays at target 0.5 | true error | fixed rays for that | share |
|---|---|---|---|---|---|---|---|"""]
        for scene in self.scenes:
            points = self.points(scene, "yes", "adaptive", "samples")
            needed, sign = between([(y, x) for x, y in points], fixed[scene])
            half = next((row for row in self.rows if row["method"] == "adaptive" and row["filter"] == "yes"
                         and row["scene"] == scene and row["estimated"] <= 0.5), None)
            if half is None:
                # No fixed number of samples of the curve has so small an error.
                lines.append(f"| {scene} | {fixed[scene]:.3f} | {sign}{needed:.1f} | {sign}{needed / 144:.0%} | - | - | - | - |")
                continue
            same = 144 * (half["true"] / fixed[scene]) ** (-1 / 0.75)
            lines.append(f"| {scene} | {fixed[scene]:.3f} | {sign}{needed:.1f} | {sign}{needed / 144:.0%} | "
                         f"{half['samples']:.1f} | {half['true']:.3f} | {same:.1f} | {half['samples'] / same:.0%} |")
        return "\n".join(lines) + "\n"

    def coverage(self):
        inside = [row for row in self.rows if row["low_95"] not in (None, "")]
        hits = mean(row["low_95"] <= row["true"] <= row["high_95"] for row in inside)
        return f"""## Is the estimate right?

Of the {len(inside)} points above that come with an estimate, {hits:.0%} have their true error within the estimated 95%
interval (each scene's are measured against one reference, whose own error is in them).

[error-coverage.md](error-coverage.md) has 100 seeds of every scene and sampler, and of scenes made to deceive.
"""

    def bounces(self):
        rows = self.read("bounces")
        if not rows:
            return ""
        scenes = sorted({row["scene"] for row in rows})
        curves = [(scene, [(row["cpu_seconds"], row["true"]) for row in rows if row["scene"] == scene])
                  for scene in scenes]
        lines = ["""## Bounces

The error of ending the mirrors' recursion early, against 32 bounces, with the same rays: no sampling error.

| scene | """ + " | ".join(str(depth) for depth in range(9)) + " bounces |", "|---|" + "---|" * 9]
        for scene in scenes:
            errors = [row["true"] for row in rows if row["scene"] == scene]
            lines.append(f"| {scene}, levels | " + " | ".join(f"{error:.3g}" for error in errors) + " |")
            rays = [row["rays"] for row in rows if row["scene"] == scene]
            lines.append(f"| {scene}, rays over 0 bounces | " + " | ".join(f"{n / rays[0]:.2f}" for n in rays) + " |")
        lines.append("")
        lines.append(self.svg("bounces", "Bounces 0 to 8", "CPU seconds", "true RMSE, levels", curves))
        return "\n".join(lines) + "\n"

    def f32(self):
        rows = self.read("f32")
        if not rows:
            return ""
        lines = ["""## `f32` against `f64`

The build with the cargo feature `f32` against the usual one: the same rays (`-filter`), so all differences are rounding.

| scene | CPU time, f32 / f64 | RMSE, levels | worst pixel, levels | pixels over 1 level |
|---|---|---|---|---|"""]
        for row in rows:
            lines.append(f"| {row['scene']} | {row['f32_cpu_seconds'] / row['f64_cpu_seconds']:.2f} | {row['true']:.4f} | "
                         f"{row['worst']:.2f} | {row['share_over_1_level']:.3%} |")
        return "\n".join(lines) + "\n"

    def povray(self):
        rows = self.read("povray")
        if not rows:
            return ""
        scene = rows[0]["scene"]
        curves = [(name, [(row["cpu_seconds"], row["true"]) for row in rows
                          if row["program"] == program and part in row["flags"]])
                  for name, program, part in (("POV-Ray +AM1", "povray", "+AM1"), ("+A0.1 +AM2", "povray", "+A0.1 +AM2"),
                                              ("+A0.01 +AM2", "povray", "+A0.01 +AM2"),
                                              ("a2, stratified", "a2", "-samples"), ("a2, adaptive", "a2", "-target"))]
        lines = [f"""## POV-Ray's own antialiasing, {scene}

POV-Ray 3.7 on the scene as `benches/peers/translate.py` writes it, {3 * self.size} x {3 * self.size} pixels, each of its
pictures against a very fine one of its own (`+A0.0 +AM1 +R24 -J`), at 16 bits a channel and linear (`File_Gamma=1.0`); a2's against a fine one of a2. The
times are those of POV-Ray's whole process and of all of a2's phases. POV-Ray's `+AM2` is adaptive.

| program | flags | CPU seconds | RMSE, levels |
|---|---|---|---|"""]
        lines += [f"| {row['program']} | `{row['flags']}` | {row['cpu_seconds']:.3f} | {row['true']:.3f} |" for row in rows]
        lines += ["", self.svg("povray", f"POV-Ray and a2, {scene}", "CPU seconds", "true RMSE, levels", curves)]
        return "\n".join(lines) + "\n"


def number(value):
    try:
        return float(value)
    except ValueError:
        return value


def processor():
    try:
        lines = open("/proc/cpuinfo").read().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or "an unknown processor"


def slope(points):
    """Returns the slope of a line through the logarithms, and the half width of its 95% interval."""
    logs = [(math.log(x), math.log(y)) for x, y in points if x > 0 and y > 0]
    n = len(logs)
    if n < 3:
        return "-"
    x_mean, y_mean = mean(x for x, _ in logs), mean(y for _, y in logs)
    spread = sum((x - x_mean) ** 2 for x, _ in logs)
    if spread == 0:
        return "-"
    rise = sum((x - x_mean) * (y - y_mean) for x, y in logs) / spread
    residual = sum((y - y_mean - rise * (x - x_mean)) ** 2 for x, y in logs)
    band = STUDENT[min(n - 3, len(STUDENT) - 1)] * math.sqrt(residual / (n - 2) / spread)
    return f"{rise:.2f} ± {band:.2f}"


def between(points, x):
    """Returns the y of a curve at an x. If the curve ends before x, it returns its last y with `<` or `>`, as a bound."""
    points = sorted((a, b) for a, b in points if a > 0 and b > 0)
    if x <= points[0][0]:
        return points[0][1], "" if x == points[0][0] else bound(points, rising_x=False)
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        if x0 <= x <= x1:
            share = (math.log(x) - math.log(x0)) / max(math.log(x1) - math.log(x0), 1e-12)
            return math.exp(math.log(y0) + share * (math.log(y1) - math.log(y0))), ""
    return points[-1][1], bound(points, rising_x=True)


def bound(points, rising_x):
    falls = points[-1][1] < points[0][1]
    return "<" if falls == rising_x else ">"

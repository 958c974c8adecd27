#!/usr/bin/env python3
"""Writes one self-contained HTML page about a program: its pictures beside the references, and what they cost.

Usage: scripts/report.py OUT.html [PROGRAM] [--starter FOLDER]

PROGRAM takes the course's flags; without it, a2 is built and reported. a2 also compares the pictures. The page shows each
scene of the course's batch (data/batch.txt) with colour, normal and depth picture, a slider against the reference, the
differences, what anti-aliasing does, the error-against-time curve if PROGRAM knows -convergence, time, memory and
commands. It needs no other file and asks no server for anything. Exit code: 1 if the program failed on a scene of the batch
(it crashed, say); the page is written all the same.
"""

import argparse
import os
import platform
import re
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

sys.dont_write_bytecode = True
import batch  # noqa: E402
import comparing  # noqa: E402
import grade_run  # noqa: E402
import report_page  # noqa: E402

# Limits of one run.
SECONDS, MEGABYTES = 600, 8192
ANTIALIASING = {"off": [], "-jitter": ["-jitter"], "-filter": ["-filter"], "both": ["-jitter", "-filter"]}
# The anti-aliasing pictures, with up to 144 rays a pixel, and those of the curve are smaller by these factors.
SHRINK_SMOOTH, SHRINK_CURVE = 4, 8
CURVE_SAMPLES = 64


@dataclass
class Picture:
    """A picture and how it compares with its reference."""

    name: str
    path: Path
    reference: Path
    # The JSON of -compare; none if a2 could not compare, with the reason in message.
    report: dict = None
    message: str = ""
    # PNG of picture, reference and differences.
    panel: Path = None


@dataclass
class Smooth:
    """A picture with one kind of anti-aliasing."""

    label: str
    path: Path
    run: grade_run.Run


@dataclass
class Scene:
    title: str
    command: str
    run: grade_run.Run
    pictures: list
    smooth: list = field(default_factory=list)
    # Column and row of the pixel that anti-aliasing changes most.
    edge: tuple = (0, 0)
    curve: Path = None
    curve_message: str = ""


class Reporter:
    def __init__(self, program, judge, starter, size, work):
        self.program, self.judge, self.size, self.work = program, judge, size, work
        self.data, self.samples = starter / "data", starter / "sample_out"

    def run(self, command):
        return grade_run.run([str(word) for word in command], self.work, SECONDS, MEGABYTES)

    def compare(self, path, reference, panel=None):
        """Returns the JSON of a2 -compare and no message, or none and a message."""
        report, message = comparing.compare(self.judge, path, reference, panel)
        # Pictures of two sizes have a report without figures.
        return (report, "") if report and "pixels_over_levels" in report else (None, message)

    def picture(self, name):
        picture = Picture(name, self.work / name, self.samples / name, panel=self.work / f"panel_{name}")
        if picture.path.is_file():
            picture.report, picture.message = self.compare(picture.path, picture.reference, picture.panel)
        else:
            picture.message = "the program has not written it"
        return picture

    def scene(self, scene):
        """Renders and compares the pictures of a scene."""
        run = self.run(scene.command(self.program, self.data, self.size, self.work))
        shown = scene.command(self.program.name, self.data.name, self.size, "")
        pictures = [self.picture(name) for name in scene.pictures]
        result = Scene(f"Scene {scene.number}: {scene.shows}", shlex.join(shown), run, pictures)
        self.antialias(scene, result)
        self.converge(scene, result)
        return result

    def start(self, scene, size):
        return [self.program, "-input", self.data / f"{scene.name}.txt", "-size", size, size, *scene.flags]

    def antialias(self, scene, result):
        """Renders a scene with each kind of anti-aliasing, and finds the pixel that it changes most."""
        for label, flags in ANTIALIASING.items():
            path = self.work / f"smooth_{scene.number}_{len(result.smooth)}.png"
            run = self.run([*self.start(scene, self.size // SHRINK_SMOOTH), *flags, "-output", path])
            result.smooth.append(Smooth(label, path, run))
        report, _ = self.compare(result.smooth[0].path, result.smooth[-1].path)
        if report and report.get("worst_pixel"):
            result.edge = (report["worst_pixel"]["x"], report["worst_pixel"]["y"])

    def converge(self, scene, result):
        """Lets the program draw its error against time."""
        curve = self.work / f"curve_{scene.number}.svg"
        command = [*self.start(scene, self.size // SHRINK_CURVE), "-output", self.work / "curve.png"]
        run = self.run([*command, "-samples", CURVE_SAMPLES, "-convergence", curve])
        if curve.is_file():
            result.curve = curve
        else:
            result.curve_message = f"no curve: the program {run.status}, {run.messages or run.detail or 'and wrote none'}"


def version(program):
    """Returns what a program says of its version, in one line; nothing if it fails."""
    try:
        done = subprocess.run([program, "-version"], capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    # A line that begins with spaces goes on with the one before.
    lines = re.sub(r"\n\s+", " ", done.stdout).splitlines() if done.returncode == 0 else []
    return "; ".join(" ".join(line.split()) for line in lines)


def processor():
    """Returns the name of the processor."""
    try:
        found = re.search(r"^model name\s*:\s*(.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    except OSError:
        found = None
    return found[1] if found else platform.processor() or platform.machine()


def versions(program, judge, samples):
    """Returns what made the page, as pairs of a name and a text."""
    return [
        ("program", f"{program.name}: {version(program) or 'says no version'}"),
        ("compared by", version(judge)),
        ("references", str(samples)),
        ("machine", f"{processor()}, {os.cpu_count()} threads, {platform.system()} {platform.machine()}"),
        ("Python", platform.python_version()),
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", metavar="OUT.html", type=Path)
    parser.add_argument("program", metavar="PROGRAM", type=Path, nargs="?")
    parser.add_argument("--starter", metavar="FOLDER", type=Path, default=batch.PROJECT,
                        help="its data/ is rendered, its sample_out/ is the reference [default: this project's]")
    parser.add_argument("--size", metavar="N", type=int, default=800, help="width and height [default: 800]")
    arguments = parser.parse_args()
    judge = comparing.judge()
    program = (arguments.program or judge).resolve()
    if arguments.size < 4 * SHRINK_CURVE:
        parser.error(f"--size is at least {4 * SHRINK_CURVE}")
    if not os.access(program, os.X_OK) or program.is_dir():
        parser.error(f"there is no program '{arguments.program}'")
    starter = arguments.starter.resolve()
    with tempfile.TemporaryDirectory() as work:
        reporter = Reporter(program, judge, starter, arguments.size, Path(work))
        scenes = [reporter.scene(scene) for scene in batch.read()]
        page = report_page.page(scenes, versions(program, judge, reporter.samples), arguments.size // SHRINK_SMOOTH)
    arguments.out.write_text(page, encoding="utf-8")
    print(f"wrote {arguments.out}, {len(page) / 1e6:.1f} MB")
    failed = [scene for scene in scenes if scene.run.status != "finished"]
    for scene in failed:
        print(f"{scene.title}: the program {scene.run.status}, {scene.run.detail}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

"""Judges what a submission renders: picture by picture, against the references, by `a2 -compare`."""

import struct
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path

import batch
import comparing
import grade_antialiasing
import grade_run
from grade_antialiasing import Antialiasing
from grade_features import Variants, spaced

# Credit of the course: scenes by number, and anti-aliasing.
CREDIT = {"01": 0.6, "02": 0.6, "03": 0.6, "04": 0.6, "05": 0.6, "06": 0.5, "07": 0.5}
ANTIALIASING_CREDIT = 1.0
# What a picture may suffer from, the worst first.
ORDER = ["missing", "unreadable", "wrong size", "differs", "ok"]


class CannotGrade(Exception):
    """The references or the judge are not there."""


@dataclass
class Limits:
    """How far two correct programs may be apart."""

    # Percentage of pixels that may differ at all, and by more than one level.
    percent_over_0: float = 1.0
    percent_over_1: float = 0.01
    # Pixels that may differ by more than eight levels.
    pixels_over_8: int = 12

    def allow(self, report):
        """Returns whether two pictures are alike of which a2 said this, or none where it could not compare them."""
        if report is None or report["verdict"] == "sizes differ":
            return False
        over, pixels = report["pixels_over_levels"], report["width"] * report["height"]
        percent_over_0, percent_over_1 = (100 * over[levels] / pixels for levels in ("0", "1"))
        is_near = percent_over_0 <= self.percent_over_0 and percent_over_1 <= self.percent_over_1
        return is_near and over["8"] <= self.pixels_over_8


@dataclass
class Picture:
    """A picture of a submission."""

    name: str
    status: str
    # What a2 found, if the picture could be compared: the JSON of -compare.
    report: dict = None
    # Otherwise why not; or what else there is to say.
    message: str = ""
    # PNG of the picture, the reference and the differences.
    panel: Path = None


@dataclass
class Row:
    """A scene of a submission."""

    scene: str
    status: str
    credit: float
    possible: float
    pictures: list
    notes: list = field(default_factory=list)
    # The run, unless the submission is a folder.
    run: grade_run.Run = None


def png_size(path):
    """Returns width and height of a PNG, or none of what is none."""
    with open(path, "rb") as file:
        head = file.read(24)
    return struct.unpack(">II", head[16:]) if head[:8] == b"\x89PNG\r\n\x1a\n" and len(head) == 24 else None


class Grader:
    """Grades scenes of submissions. Its methods may run in several threads."""

    def __init__(self, a2, arguments, work):
        self.a2, self.work = a2, work
        self.data, self.samples = (arguments.starter.resolve() / name for name in ("data", "sample_out"))
        self.size = arguments.size
        self.limits = Limits(0, 0, 0) if arguments.exact else Limits()
        self.seconds, self.megabytes = arguments.time_limit, arguments.memory_limit
        self.wants_panels = arguments.html is not None
        self.lock, self.panels = threading.Lock(), 0
        scenes = {scene.number: scene for scene in batch.read()}
        self.references, self.rendered = {}, []
        for name in arguments.scenes:
            if name in scenes:
                self.find_references(scenes[name])
        variants = work / "variants"
        variants.mkdir()
        self.variants = Variants(a2, self.data, self.size, variants)
        if set(arguments.scenes) - set(scenes):
            path = self.data / f"{scenes[grade_antialiasing.SCENE].name}.txt"
            self.smooth = Antialiasing(a2, path, spaced(path.read_text()), self.size, work, self.compare)

    def find_references(self, scene):
        """Finds the references of a scene: the given ones, or rendered by a2 where another size is wanted."""
        given = [self.samples / name for name in scene.pictures]
        missing = [path for path in given if not path.is_file()]
        if missing:
            raise CannotGrade(f"the reference {missing[0]} is missing")
        if any(png_size(path) != (self.size, self.size) for path in given):
            comparing.render(scene.command(self.a2, self.data, self.size, self.work))
            given = [self.work / name for name in scene.pictures]
            self.rendered.append(scene.number)
        for path in given:
            # A reference that a2 cannot read would make every submission wrong.
            report, message = self.compare(path, path)
            if report is None:
                raise CannotGrade(message)
            self.references[path.name] = path

    def compare(self, picture, reference, diff=None):
        """Compares two pictures. Returns what a2 found, or none and a message."""
        report, message = comparing.compare(self.a2, picture, reference, diff)
        return report, message.removeprefix("error: ")

    def panel_name(self):
        with self.lock:
            self.panels += 1
            return self.work / f"panel{self.panels}.png"

    def picture(self, path, reference, is_right):
        """Judges a picture; is_right says of a report whether it is right."""
        if not path.is_file():
            return Picture(path.name, "missing")
        report, message = self.compare(path, reference)
        if report is None:
            # The place of the file does not matter, and may be a temporary one.
            return Picture(path.name, "unreadable", message=message.replace(str(path), path.name))
        if report["verdict"] == "sizes differ":
            sizes = [" x ".join(map(str, report[size])) for size in ("size_of_a", "size_of_b")]
            return Picture(path.name, "wrong size", message=f"{path.name} is {sizes[0]} pixels, not {sizes[1]}")
        found = Picture(path.name, "ok" if is_right(report) else "differs", report)
        if self.wants_panels and found.status == "differs":
            found.panel = self.panel_name()
            self.compare(path, reference, found.panel)
        if report["pixels_of_other_alpha"]:
            found.message = f"{path.name}: alpha differs in {report['pixels_of_other_alpha']} pixels, and is not compared"
        return found

    def run_in(self, folder, submission, command):
        """Runs a command of a submission that is a program. Returns none for a folder of pictures."""
        if submission.is_dir():
            return None
        return grade_run.run(command, folder, self.seconds, self.megabytes)

    def row(self, name, run, pictures, credit):
        """Sums up a scene."""
        status = min((picture.status for picture in pictures), key=ORDER.index)
        row = Row(name, status, 0.0, credit, pictures, run=run)
        if run and run.status != "finished":
            row.status = run.status
            row.notes.append(run.detail)
            if status == "ok":
                row.notes.append("its pictures are right")
            if run.messages:
                row.notes.append(f"says: {run.messages}")
        row.notes += [picture.message for picture in pictures if picture.message]
        if row.status == "ok":
            row.credit = credit
        return row

    def scene(self, submission, scene):
        """Grades a scene of the batch."""
        with tempfile.TemporaryDirectory(dir=self.work) as temporary:
            folder = submission if submission.is_dir() else Path(temporary)
            run = self.run_in(folder, submission, scene.command(submission, self.data, self.size, folder))
            pictures = [self.picture(folder / name, self.references[name], self.limits.allow) for name in scene.pictures]
            row = self.row(scene.number, run, pictures, CREDIT[scene.number])
            differing = [picture for picture in pictures if picture.status == "differs"]
            if differing:
                row.notes += self.reasons(scene, folder, differing)
        return row

    def reasons(self, scene, folder, pictures):
        """Returns what explains the differences of some pictures of a scene, if anything does."""
        for features, variant in self.variants.of(scene):
            over = 0
            for picture in pictures:
                report, _ = self.compare(folder / picture.name, variant / picture.name)
                if not self.limits.allow(report):
                    break
                over += report["pixels_over_levels"]["0"]
            else:
                without = f"as if without {' and '.join(features)}" if features else "as a2 renders it"
                return [f"{without}: {over} pixels differ in {', '.join(picture.name for picture in pictures)}"]
        worst = max(picture.report["worst_levels"] for picture in pictures)
        return ["no pixel differs by more than 1 level: are bytes rounded, not truncated?"] if worst == 1 else []

    def antialiasing(self, submission):
        """Grades anti-aliasing by the error against the converged picture."""
        smooth = self.smooth
        with tempfile.TemporaryDirectory(dir=self.work) as temporary:
            folder = submission if submission.is_dir() else Path(temporary)
            path = folder / grade_antialiasing.PICTURE
            run = self.run_in(folder, submission, [*smooth.command(submission, smooth.scene, path), *grade_antialiasing.FLAGS])
            error, converged = smooth.error(path)
            missing = smooth.missing(path, self.limits)
            is_right = missing is None and error <= grade_antialiasing.ALLOWED_SHARE * smooth.aliased_error
            picture = self.picture(path, converged, lambda report: is_right)
            row = self.row("aa", run, [picture], ANTIALIASING_CREDIT)
        if picture.status in ("ok", "differs"):
            row.notes.append(f"error {error:.2f} levels; {smooth.aliased_error:.2f} without anti-aliasing")
            row.notes += [missing] if missing else []
        return row

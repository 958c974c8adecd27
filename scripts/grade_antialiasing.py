"""Judges anti-aliasing by the error against a converged picture: one of so many samples that more would not change it."""

import math
import re

import comparing

# The scene that shows anti-aliasing, its flags, and the name of its picture.
SCENE = "01"
FLAGS = ["-jitter", "-filter"]
PICTURE = "a01aa.png"
# It takes 144 rays a pixel, so it is smaller than the others by this factor.
SHRINK = 4
CONVERGED_FLAGS = [*FLAGS, "-samples", "256", "-sampler", "sobol"]
# The error may be this share of the error without anti-aliasing. Independent samples reach 0.07.
ALLOWED_SHARE = 0.5
NUMBER = r"(\S+)"


def centred(text, side):
    """Returns a scene (with spaces around braces) whose camera looks half a sample's cell to the lower left, at 3 x side pixels.

    The course's offsets are from 0 to 1, so the mean of a pixel's samples lies half a cell to the upper right of the place
    without jitter. Offsets from -1/2 to 1/2 are as good; with this camera the course's offsets give their picture.
    """
    vector = rf"\s+{NUMBER}\s+{NUMBER}\s+{NUMBER}"
    direction, up = ([float(number) for number in re.search(rf"\b{name}{vector}", text).groups()] for name in ("direction", "up"))
    angle = math.radians(float(re.search(rf"\bangle\s+{NUMBER}", text)[1]))
    length = math.hypot(*direction)
    across = [direction[a] * up[b] - direction[b] * up[a] for a, b in ((1, 2), (2, 0), (0, 1))]
    across = [number / math.hypot(*across) for number in across]
    half_cell = 1 / (3 * side - 1)
    middle = [
        number / length / math.tan(angle / 2) - half_cell * (right + above)
        for number, right, above in zip(direction, across, up)
    ]
    angle = math.degrees(2 * math.atan(1 / math.hypot(*middle)))
    camera = " ".join(map(repr, middle))
    text = re.sub(rf"\bdirection{vector}", f"direction {camera}", text, count=1)
    return re.sub(rf"\bangle\s+{NUMBER}", f"angle {angle!r}", text, count=1)


class Antialiasing:
    """The pictures to compare with."""

    def __init__(self, a2, scene, text, size, work, compare):
        """Renders them; scene is the scene's file and text what it says, compare a function of two pictures."""
        self.scene, self.size, self.compare = scene, size // SHRINK, compare
        shifted = work / "centred.txt"
        shifted.write_text(centred(text, self.size))
        self.converged = [
            self.render(a2, path, CONVERGED_FLAGS, work / f"converged_{path.stem}.png") for path in (scene, shifted)
        ]
        self.without = {
            "-jitter and -filter": self.render(a2, scene, [], work / "aliased.png"),
            "-jitter": self.render(a2, scene, ["-filter"], work / "filtered.png"),
        }
        self.aliased_error = self.error(self.without["-jitter and -filter"])[0]

    def command(self, program, scene, path):
        size = str(self.size)
        return [str(program), "-input", str(scene), "-size", size, size, "-output", str(path)]

    def render(self, a2, scene, flags, path):
        comparing.render([*self.command(a2, scene, path), *flags])
        return path

    def error(self, path):
        """Returns the error of a picture in levels, and the converged picture that it is nearer to."""
        errors = []
        for converged in self.converged:
            report, _ = self.compare(path, converged)
            errors.append((report["rmse_levels"] if report and "rmse_levels" in report else math.inf, converged))
        return min(errors)

    def missing(self, path, limits):
        """Returns which flags a picture is without, in words, if it equals such a picture."""
        for flags, variant in self.without.items():
            report, _ = self.compare(path, variant)
            if limits.allow(report):
                return f"as if without {flags}: {report['pixels_over_levels']['0']} pixels differ"
        return None

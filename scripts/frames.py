#!/usr/bin/env python3
"""Renders frames and joins them to an animated PNG (APNG), which browsers play.

  frames.sh OUT.png SCENE.txt SCENE.txt ... [FLAGS]          a frame for each scene file
  frames.sh OUT.png -turntable FRAMES SCENE.txt [FLAGS]      the camera goes once around the vertical axis

FLAGS are those of a2, and begin at the first word with a dash after the scenes; without any, -size 300 300. The frames lie
in OUT.png.frames; those that are done are not rendered again, so the same command goes on where another one ended.
Environment: A2 (the program), RATE (frames a second [default: 20]), PIVOT (a point on the axis [default: "0 0 0"]). Exit
code: 1 if a frame cannot be rendered, 2 if the command is wrong. As an example, a turn of the mirror bunny:

  scripts/frames.sh turn.png -turntable 60 data/scene06_bunny_1k.txt -size 300 300 -bounces 4 -jitter
"""

import math
import os
import re
import struct
import subprocess
import sys
import zlib
from pathlib import Path

USAGE = "\n".join(line for line in __doc__.splitlines() if line.startswith("  frames.sh"))
NUMBER = r"[-+.\deE]+"
SIGNATURE = b"\x89PNG\r\n\x1a\n"


def turned(vector, angle, pivot):
    """Turns a point or a direction around the vertical axis through a point."""
    x, y, z = (v - p for v, p in zip(vector, pivot))
    c, s = math.cos(angle), math.sin(angle)
    return [c * x + s * z + pivot[0], y + pivot[1], c * z - s * x + pivot[2]]


def turntable(scene, frames, folder, pivot):
    """Writes a scene file for each frame, and returns their paths."""
    text = scene.read_text()
    # Names are relative to the scene's folder, and the frames lie in another.
    name = r'\b(obj_file|cubeMap)\s+("[^"]*"|\S+)'
    text = re.sub(name, lambda m: f'{m[1]} "{scene.resolve().parent / m[2].strip(chr(34))}"', text)
    camera = re.search(r"PerspectiveCamera\s*\{[^}]*\}", text)
    if not camera:
        raise WrongUse(f"{scene}: there is no PerspectiveCamera")
    paths = []
    for frame in range(frames):
        angle = 2 * math.pi * frame / frames

        def turn(match):
            about = pivot if match[1] == "center" else (0, 0, 0)
            vector = turned([float(number) for number in match[2].split()], angle, about)
            return f"{match[1]} " + " ".join(f"{number:.9f}" for number in vector)

        block = re.sub(rf"\b(center|direction|up)\s+({NUMBER}\s+{NUMBER}\s+{NUMBER})", turn, camera[0])
        path = folder / f"{frame + 1:05}.txt"
        path.write_text(text[:camera.start()] + block + text[camera.end():])
        paths.append(path)
    return paths


def chunks(path):
    """Yields the types and the contents of a PNG's chunks."""
    data = path.read_bytes()
    at = len(SIGNATURE)
    while at < len(data):
        (length,) = struct.unpack(">I", data[at:at + 4])
        yield data[at + 4:at + 8], data[at + 8:at + 8 + length]
        at += length + 12


def animated(paths, rate):
    """Joins PNG files of equal size to an animated PNG. Nothing is compressed again."""
    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    heads = [dict(chunks(path))[b"IHDR"] for path in paths]
    if len(set(heads)) != 1:
        sys.exit("error: the frames have different sizes")
    joined = [SIGNATURE, chunk(b"IHDR", heads[0]), chunk(b"acTL", struct.pack(">II", len(paths), 0))]
    number = 0
    for index, path in enumerate(paths):
        joined.append(chunk(b"fcTL", struct.pack(">I", number) + heads[0][:8] + struct.pack(">IIHHBB", 0, 0, 1, rate, 0, 0)))
        number += 1
        for content in (content for kind, content in chunks(path) if kind == b"IDAT"):
            if index == 0:
                joined.append(chunk(b"IDAT", content))
            else:
                joined.append(chunk(b"fdAT", struct.pack(">I", number) + content))
                number += 1
    return b"".join(joined) + chunk(b"IEND", b"")


class WrongUse(Exception):
    """The command, a variable or a scene does not say what to render."""


def whole_number(name, text):
    """Returns the number in a text, which must fit into a PNG's field of 16 bits; name says where it stands."""
    if not text.isdecimal() or not 1 <= int(text) < 1 << 16:
        raise WrongUse(f"{name} is '{text}', not a whole number from 1 to 65535")
    return int(text)


def point(name, text):
    """Returns the three numbers in a text."""
    try:
        x, y, z = map(float, text.split())
    except ValueError:
        raise WrongUse(f"{name} is '{text}', not three numbers") from None
    return [x, y, z]


def parsed(words):
    """Returns the file to write, the number of frames of a turntable (or none), the scenes and the flags."""
    if not words or words[0].startswith("-"):
        raise WrongUse("the first word must be the file to write")
    out, *words = words
    frames = None
    if words[:1] == ["-turntable"]:
        frames = whole_number("FRAMES", "".join(words[1:2]))
        words = words[2:]
    count = next((at for at, word in enumerate(words) if word.startswith("-")), len(words))
    scenes, flags = [Path(word) for word in words[:count]], words[count:]
    if not scenes or (frames and len(scenes) > 1):
        raise WrongUse("-turntable needs one scene" if frames else "there is no scene")
    for scene in scenes:
        if not scene.is_file():
            raise WrongUse(f"there is no scene '{scene}'")
    return Path(out), frames, scenes, flags or ["-size", "300", "300"]


def show_progress(text):
    """Writes a line over the one before on a terminal, below it elsewhere."""
    is_terminal = sys.stderr.isatty()
    print(f"\r{text}" if is_terminal else text, end="" if is_terminal else "\n", file=sys.stderr, flush=True)


def render(out, frames, scenes, flags):
    """Renders the frames that are not there, and joins all."""
    rate = whole_number("RATE", os.environ.get("RATE", "20"))
    pivot = point("PIVOT", os.environ.get("PIVOT", "0 0 0"))
    folder = Path(f"{out}.frames")
    folder.mkdir(parents=True, exist_ok=True)
    if frames:
        scenes = turntable(scenes[0], frames, folder, pivot)
    pictures = []
    for frame, scene in enumerate(scenes, 1):
        pictures.append(folder / f"{frame:05}.png")
        command = [os.environ.get("A2", "a2"), "-input", scene, "-output", pictures[-1], "-skip-done", "-quiet", *flags]
        if subprocess.run([str(word) for word in command]).returncode != 0:
            sys.exit(f"error: frame {frame} is not rendered: {scene}")
        show_progress(f"{frame} of {len(scenes)} frames")
    out.write_bytes(animated(pictures, rate))
    show_progress(f"{out}: {len(pictures)} frames")
    if sys.stderr.isatty():
        print(file=sys.stderr)


def main():
    words = sys.argv[1:]
    if words[:1] in (["-h"], ["-help"], ["--help"]):
        print(__doc__.strip())
        return 0
    try:
        render(*parsed(words))
    except WrongUse as wrong:
        print(f"error: {wrong}\n{USAGE}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

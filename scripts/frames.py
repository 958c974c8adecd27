#!/usr/bin/env python3
"""Renders frames and joins them to an animated PNG (APNG), which browsers play.

  frames.sh OUT.png SCENE.txt SCENE.txt ... [-- FLAGS]          a frame for each scene file
  frames.sh OUT.png -turntable FRAMES SCENE.txt [-- FLAGS]      the camera goes once around the vertical axis

FLAGS are those of a2; without any, -size 300 300. The frames lie in OUT.png.frames; those that are done are not rendered
again, so the same command goes on where another one ended. RATE is the number of frames a second [default: 20], PIVOT
the point on the axis [default: "0 0 0"]. As an example, a turn of the mirror bunny:

  scripts/frames.sh turn.png -turntable 60 data/scene06_bunny_1k.txt -- -size 300 300 -bounces 4 -jitter
"""

import math
import os
import re
import struct
import subprocess
import sys
import zlib
from pathlib import Path

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
        sys.exit(f"{scene}: there is no PerspectiveCamera")
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
        sys.exit("the frames have different sizes")
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


def main():
    words = sys.argv[1:]
    flags = words[words.index("--") + 1:] if "--" in words else ["-size", "300", "300"]
    words = words[:words.index("--")] if "--" in words else words
    if len(words) < 2 or (words[1] == "-turntable" and len(words) != 4):
        sys.exit(__doc__)
    out = Path(words[0])
    folder = Path(f"{out}.frames")
    folder.mkdir(parents=True, exist_ok=True)
    if words[1] == "-turntable":
        pivot = [float(number) for number in os.environ.get("PIVOT", "0 0 0").split()]
        scenes = turntable(Path(words[3]), int(words[2]), folder, pivot)
    else:
        scenes = [Path(word) for word in words[1:]]
    pictures = []
    for frame, scene in enumerate(scenes, 1):
        pictures.append(folder / f"{frame:05}.png")
        command = [os.environ.get("A2", "a2"), "-input", scene, "-output", pictures[-1], "-skip-done", "-quiet", *flags]
        if subprocess.run([str(word) for word in command]).returncode != 0:
            sys.exit(f"frame {frame} is not rendered: {scene}")
        print(f"\r{frame} of {len(scenes)} frames", end="", file=sys.stderr, flush=True)
    out.write_bytes(animated(pictures, int(os.environ.get("RATE", "20"))))
    print(f"\r{out}: {len(pictures)} frames", file=sys.stderr)


if __name__ == "__main__":
    main()

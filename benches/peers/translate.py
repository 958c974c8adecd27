#!/usr/bin/env python3
"""Writes an a2 scene as a POV-Ray scene and a Tachyon scene.

    translate.py SCENE.txt FOLDER [--size W H] [--bounces N] [--shadows] [--to povray|tachyon] [--sky images|plain]

Out: FOLDER/NAME.pov and FOLDER/NAME.dat, and the cube map's faces beside them (Tachyon keeps at most 80 characters
of an image's name, POV-Ray reads only below its working folder; `pngtopnm` of netpbm makes Tachyon's copies). The
camera contains the size, so that both trace the same rays as a2. Not translated: coloured specular terms (their mean
is used, except for mirrors in POV-Ray), coloured ambient light in Tachyon (the mean is used), and plane normals that
are not unit vectors (both normalise them). README.md lists the other differences.
"""

import argparse
import math
import shutil
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
import povray  # noqa: E402
import tachyon  # noqa: E402
from scene_file import cross, read_scene, scale, unit  # noqa: E402

WRITERS = {"povray": (povray, "pov"), "tachyon": (tachyon, "dat")}
FACES = ("right", "left", "up", "down", "front", "back")


class View:
    """Returns the camera of a2 as three vectors: a pixel's ray is `forward + x * right + y * up`, x and y in -1 .. 1."""

    def __init__(self, camera, size):
        direction = unit(camera["direction"])
        self.center = camera["center"]
        self.forward = scale(direction, 1.0 / math.tan(math.radians(camera["angle"]) / 2.0))
        self.right = unit(cross(direction, camera["up"]))
        self.up = camera["up"]
        self.width, self.height = size


def copy_face(source, target):
    shutil.copyfile(source, target.with_suffix(".png"))
    # Tachyon's own PNG reader takes the wrong bytes of a row, so its pictures come as PPM.
    ppm = subprocess.run(["pngtopnm", source], check=True, capture_output=True).stdout
    target.with_suffix(".ppm").write_bytes(ppm)


def translate(scene_file, folder, size, bounces=0, shadows=False, peers=tuple(WRITERS), sky="images"):
    scene = read_scene(scene_file)
    folder.mkdir(parents=True, exist_ok=True)
    faces = {}
    if sky == "images" and "cubeMap" in scene.background:
        source = scene_file.parent / scene.background["cubeMap"]
        for face in FACES:
            faces[face] = f"{source.name}_{face}"
            copy_face(source / f"{face}.png", folder / faces[face])
    for peer in peers:
        writer, ending = WRITERS[peer]
        with open(folder / f"{scene_file.stem}.{ending}", "w") as out:
            writer.write(out, scene, View(scene.camera, size), faces, bounces, shadows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scene", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--size", type=int, nargs=2, default=(800, 800))
    parser.add_argument("--bounces", type=int, default=0)
    parser.add_argument("--shadows", action="store_true")
    parser.add_argument("--to", choices=WRITERS, action="append")
    parser.add_argument("--sky", choices=("images", "plain"), default="images")
    args = parser.parse_args()
    peers = args.to or tuple(WRITERS)
    try:
        translate(args.scene, args.folder, args.size, args.bounces, args.shadows, peers, args.sky)
    except (ValueError, OSError, IndexError, KeyError, subprocess.CalledProcessError) as error:
        sys.exit(f"translate.py: {args.scene}: {error!r}")


if __name__ == "__main__":
    main()

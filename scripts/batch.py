"""Reads data/batch.txt, the course's batch, and tables in the same form, and says how a program renders them."""

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent


@dataclass
class Scene:
    number: str
    name: str
    # Nearest and farthest distance of the depth picture, as written.
    depth: list
    # Further flags of a2.
    flags: list
    # Description of the scene.
    shows: str

    @property
    def pictures(self):
        """Returns the file names of the colour, normal and depth picture."""
        return [f"a{self.number}{kind}.png" for kind in ("", "n", "d")]

    @property
    def short_name(self):
        """Returns scene01 of scene01_plane."""
        return self.name.partition("_")[0]

    def command(self, program, data, size, folder):
        """Returns the command line that renders the three pictures into folder; data is the folder of the scenes."""
        color, normals, depth = (str(Path(folder) / name) for name in self.pictures)
        command = [str(program), "-input", str(Path(data) / f"{self.name}.txt"), "-size", str(size), str(size)]
        return [*command, "-output", color, "-normals", normals, "-depth", *self.depth, depth, *self.flags]


def built_program():
    """Builds a2 and returns its path."""
    subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=PROJECT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", PROJECT / "target")).resolve() / "release" / "a2"


def read(table="batch.txt"):
    """Returns the scenes of the batch, or of another table in data/, in order."""
    scenes, comment = [], ""
    for line in (PROJECT / "data" / table).read_text().splitlines():
        if line.startswith("#"):
            comment = line.removeprefix("#").strip()
        elif line.strip():
            number, name, near, far, *flags = line.split()
            scenes.append(Scene(number, name, [near, far], flags, comment))
    return scenes

#!/usr/bin/env python3
"""Renders the gallery, data/gallery.txt, into docs/gallery/, writes docs/gallery.md, and renders the pictures of README.md.

Usage: scripts/gallery.py [PROGRAM]

PROGRAM is a built a2; without it, one is built. Takes a minute and a half of processor time.
"""

import os
import subprocess
import sys

sys.dont_write_bytecode = True
import batch  # noqa: E402

GALLERY = batch.PROJECT / "docs" / "gallery"
SIZE = ["-size", "400", "300"]
SMOOTH = ["-jitter", "-filter"]
COURTYARD = [
    *"-output courtyard.png -size 640 640 -bounces 2 -shadows -jitter".split(),
    *"-depth 5 45 courtyard-depth.png -normals courtyard-normals.png".split(),
]
# The scene that is also shown as a picture of depths and one of normals.
THREE_PICTURES = "bunnies"
HEAD = """# Gallery

Eight scenes, each in a file of less than 60 lines. Together they show every kind of object, transformation and light,
shadows, mirrors and a cube map. Each command writes the picture above it; `scripts/gallery.py` runs them all.

`up 0 0.75 0` in their cameras makes up for the format of 4:3: `a2` stretches a picture that is not square, as the
course's program does, and a shorter `up` undoes this.
"""


def section(scene):
    """Returns the text of a scene and the arguments that render it into the current folder."""
    arguments = ["-input", f"data/gallery/{scene.name}.txt", "-output", f"{scene.name}.png", *SIZE]
    images = [f"![{scene.name}](gallery/{scene.name}.png)"]
    if scene.name == THREE_PICTURES:
        more = {"depth": f"{scene.name}-depth.png", "normals": f"{scene.name}-normals.png"}
        arguments += ["-depth", *scene.depth, more["depth"], "-normals", more["normals"]]
        images += [f"![{kind} of the same](gallery/{name})" for kind, name in more.items()]
    arguments += scene.flags + SMOOTH
    text = [f"## {scene.name.capitalize()}", "", scene.shows, "", *images, "", "```sh"]
    text += [f"a2 {' '.join(arguments)}", "```", ""]
    return "\n".join(text), arguments


def render(program, scene_file, arguments, folder):
    """Renders a scene into a folder."""
    subprocess.run([os.path.abspath(program), "-input", str(scene_file), *arguments, "-quiet"], cwd=folder, check=True)


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else batch.built_program()
    GALLERY.mkdir(exist_ok=True)
    sections = [HEAD]
    for scene in batch.read("gallery.txt"):
        text, arguments = section(scene)
        sections.append(text)
        scene_file = batch.PROJECT / arguments[1]
        render(program, scene_file, arguments[2:], GALLERY)
    render(program, batch.PROJECT / "data" / "courtyard.txt", COURTYARD, GALLERY.parent)
    (GALLERY.parent / "gallery.md").write_text("\n".join(sections).rstrip() + "\n")


if __name__ == "__main__":
    sys.exit(main())

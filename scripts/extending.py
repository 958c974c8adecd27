#!/usr/bin/env python3
"""Makes the changes of docs/extending.md in a copy of the project, builds it, and compares its picture with the page's.

Usage: scripts/extending.py

A test compares the lines that the page quotes with the source. This script finds what else a change needs: a new match
that the page does not know. It takes a build.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
PAGE = (PROJECT / "docs" / "extending.md").read_text(encoding="utf-8")


def side(hunk, sign):
    """Returns the lines of a hunk that begin with a space or with the sign, without it."""
    return "\n" + "".join(line[1:] + "\n" for line in hunk.split("\n") if line[:1] in (" ", sign))


def change(copy):
    """Makes the changes of the page in a copy."""
    name, text = re.search(r"```rust\n// (\S+)\n(.*?\n)```\n", PAGE, re.DOTALL).groups()
    (copy / name).write_text(text, encoding="utf-8")
    for block in PAGE.split("\n```diff\n--- ")[1:]:
        name, *hunks = block.split("\n```\n")[0].split("\n@@\n")
        text, place = (copy / name).read_text(encoding="utf-8"), 0
        for hunk in hunks:
            old, new = side(hunk, "-"), side(hunk, "+")
            at = text.index(old, place)
            text = text[:at] + new + text[at + len(old) :]
            # The last line of a hunk may be the first of the next one.
            place = at + new.rstrip().rindex("\n")
        (copy / name).write_text(text, encoding="utf-8")


def main():
    scene = re.search(r"```text\n(.*?)```\n", PAGE, re.DOTALL)[1]
    command = re.search(r"^a2 -input scene\.txt (-output extending\.png .*)$", PAGE, re.MULTILINE)[1].split()
    target = Path(os.environ.get("CARGO_TARGET_DIR", PROJECT / "target")).resolve() / "extending"
    with tempfile.TemporaryDirectory() as work:
        copy = Path(work) / "a2"
        subprocess.run(["git", "clone", "--quiet", "--shared", PROJECT, copy], check=True)
        change(copy)
        build = ["cargo", "build", "--profile", "ci", "--quiet"]
        subprocess.run(build, cwd=copy, env={**os.environ, "CARGO_TARGET_DIR": str(target)}, check=True)
        program = target / "ci" / "a2"
        (Path(work) / "scene.txt").write_text(scene, encoding="utf-8")
        for flags in ([], ["-plain"]):
            subprocess.run([program, "-input", "scene.txt", *command, *flags, "-quiet"], cwd=work, check=True)
            compare = [program, "-compare", "extending.png", PROJECT / "docs" / "extending.png", "-tolerance", "0", "0"]
            subprocess.run(compare, cwd=work, check=True)


if __name__ == "__main__":
    sys.exit(main())

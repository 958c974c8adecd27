"""Renders and compares pictures by the a2 that judges."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import batch


def judge():
    """Returns the a2 that compares: that of the environment's A2_JUDGE, or else one that is built here."""
    return Path(os.environ.get("A2_JUDGE") or batch.built_program()).resolve()


def render(command):
    """Runs a command of a2 in silence: what it warns of is no matter of the submission. What it says of a failure is shown."""
    done = subprocess.run([*command, "-quiet"], stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        print(done.stderr, end="", file=sys.stderr)
    done.check_returncode()


def compare(a2, picture, reference, panel=None):
    """Returns the report of a2 on two pictures, or none if it cannot compare them, and what it says then.

    The report on pictures of different sizes has no figures. panel is where to draw both and their differences.
    """
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        command = [a2, "-compare", picture, reference, "-report", report]
        command += ["-diff", panel] if panel else []
        done = subprocess.run(command, capture_output=True, text=True)
        # 1: the pictures differ; 3: their sizes do.
        is_compared = done.returncode in (0, 1, 3) and report.is_file()
        found = json.loads(report.read_text()) if is_compared else None
    return found, done.stderr.strip() or f"a2 -compare ended with exit code {done.returncode}"

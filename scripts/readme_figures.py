#!/usr/bin/env python3
"""Measures the table of figures in README.md and writes it between the two marks there, and its figures into README.zh.md.

Usage: scripts/readme_figures.py STARTER_FOLDER [--runs N]

STARTER_FOLDER is the course's starter: its seven scenes are rendered at 800 x 800, compared with its pictures, and timed
as whole processes (medians of N runs). Builds the program first. The ratios to Tachyon and POV-Ray are those of the newest
entry in benches/record/jobs.jsonl, which benches/peers/run.py --record jobs.jsonl makes.
"""

import argparse
import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.dont_write_bytecode = True
import batch  # noqa: E402
import comparing  # noqa: E402

PROJECT = batch.PROJECT
BEGIN, END = "<!-- figures: begin -->", "<!-- figures: end -->"


def differing(a2, picture, reference):
    """Returns the percentage of pixels that differ, and the number that differ by more than eight levels."""
    report, message = comparing.compare(a2, picture, reference)
    if report is None or report["verdict"] == "sizes differ":
        sys.exit(message)
    over = report["pixels_over_levels"]
    return 100 * over["0"] / (report["width"] * report["height"]), over["8"]


def measure(a2, starter, work, runs):
    """Measures the rows of the table, one for each scene."""
    for scene in batch.read():
        names = scene.pictures
        command = scene.command(a2, starter / "data", 800, work)
        seconds = []
        for _ in range(runs):
            start = time.perf_counter()
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            seconds.append(time.perf_counter() - start)
        off = [differing(a2, work / name, starter / "sample_out" / name) for name in names]
        percent, far = max(value[0] for value in off), max(value[1] for value in off)
        milliseconds = 1000 * statistics.median(seconds)
        yield f"| {scene.number} | {scene.shows} | {percent:.3f}% | {far} | {milliseconds:.0f} ms |"


def ratios():
    """Reads from the newest record how many times as long the peers take, and returns this in English and in Chinese."""
    entry = json.loads((PROJECT / "benches" / "record" / "jobs.jsonl").read_text().splitlines()[-1])
    found = {peer: [] for peer in ("Tachyon", "POV-Ray")}
    for job, seconds in entry["seconds"].items():
        medians = {program: statistics.median(times) for program, times in seconds.items()}
        for peer in set(found) & set(medians):
            found[peer].append((medians[peer] / medians["a2"], job))
    ends = [(peer, *min(all_jobs), *max(all_jobs)) for peer, all_jobs in found.items()]
    link, date = "[benches/peers](benches/peers/README.md)", entry["date"][:10]
    texts = [
        f"{peer} takes {least:.1f} ({job}) to {most:.1f} times as long ({other})" for peer, least, job, most, other in ends
    ]
    english = f"The same scenes, whole processes ({link}, {date}): {'; '.join(texts)}."
    texts = [
        f"{peer} 的用时是本程序的 {least:.1f} 倍（{in_chinese(job)}）到 {most:.1f} 倍（{in_chinese(other)}）"
        for peer, least, job, most, other in ends
    ]
    return english, f"同样的场景，比较整个进程（{link}，{date}）：{'；'.join(texts)}。"


def in_chinese(job):
    """Returns the name of a job of benches/peers/run.py in Chinese."""
    job = re.sub(r", ([\d,]+) rays a pixel", r"，每像素 \1 条光线", job)
    return re.sub(r", ([\d,]+) triangles", r"，\1 个三角形", job)


def with_figures(text, rows, ratios_to_peers):
    """Returns the text with the figures of the rows in its own table, whose descriptions stay, and the ratios below it."""
    for row in rows:
        number, _, figures = row.removeprefix("| ").split(" | ", 2)
        text, count = re.subn(rf"^(\| {number} \| [^|]* \| ).*$", lambda found: found[1] + figures, text, flags=re.MULTILINE)
        assert count == 1, number
    return re.sub(rf".*\n{END}", lambda found: f"{ratios_to_peers}\n{END}", text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("starter", type=Path)
    parser.add_argument("--runs", type=int, default=7)
    arguments = parser.parse_args()
    a2 = str(batch.built_program())
    with tempfile.TemporaryDirectory() as work:
        rows = list(measure(a2, arguments.starter, Path(work), arguments.runs))
    english, chinese = ratios()
    table = [
        BEGIN,
        "| scene | shows | pixels that differ from the course's | by more than 8 levels | three pictures in |",
        "|---|---|---|---|---|",
        *rows,
        "",
        f"(The worst of colour, normal and depth picture, of 640,000 pixels each. Whole processes, medians of "
        f"{arguments.runs} runs, {os.cpu_count()} threads, {platform.machine()}.)",
        "",
        english,
        END,
    ]
    readme = PROJECT / "README.md"
    text = readme.read_text(encoding="utf-8")
    start, end = text.index(BEGIN), text.index(END) + len(END)
    readme.write_text(text[:start] + "\n".join(table) + text[end:], encoding="utf-8")
    readme = PROJECT / "README.zh.md"
    readme.write_text(with_figures(readme.read_text(encoding="utf-8"), rows, chinese), encoding="utf-8")
    print("\n".join(table[1:-1]))


if __name__ == "__main__":
    sys.exit(main())

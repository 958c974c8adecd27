#!/usr/bin/env python3
"""Grades programs and folders of pictures by the course's batch (data/batch.txt) and by anti-aliasing.

A submission is a program that takes the course's flags, or a folder that holds a01.png, a01n.png, a01d.png, ... and
a01aa.png. It only renders: a2 compares. docs/grading.md says what each status means, and how credit is given.

Environment: A2 (the submission if none is given; default: a2, built here), A2_JUDGE (the a2 that compares; default: built
here). Exit code: 0 if every submission has full credit, otherwise 1; 2 if nothing could be graded.
"""

import argparse
import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
import batch  # noqa: E402
import comparing  # noqa: E402
import grade_judge  # noqa: E402
import grade_page  # noqa: E402
import grade_run  # noqa: E402

ANTIALIASING = "aa"
STANDARD_OUTPUT = Path("-")


def parsed_arguments():
    shape = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=shape)
    known = [scene.number for scene in batch.read()] + [ANTIALIASING]
    parser.add_argument("submissions", metavar="SUBMISSION", nargs="*", type=Path, help="program or folder of pictures")
    parser.add_argument("--starter", metavar="FOLDER", type=Path, default=batch.PROJECT,
                        help="its data/ is rendered, its sample_out/ is the reference [default: this project's]")
    parser.add_argument("--scenes", metavar="LIST", default=",".join(known),
                        help=f"which of {','.join(known)} [default: all]")
    parser.add_argument("--size", metavar="N", type=int, default=800,
                        help="width and height [default: 800]; references of another size are rendered by a2")
    parser.add_argument("--time-limit", metavar="S", type=float, default=60.0, help="seconds a scene [default: 60]")
    parser.add_argument("--memory-limit", metavar="MB", type=float, default=2048.0, help="[default: 2048]")
    parser.add_argument("--jobs", metavar="N", type=int, default=os.cpu_count(),
                        help="runs at a time [default: one for each processor]")
    parser.add_argument("--exact", action="store_true", help="not one pixel may differ by one level")
    parser.add_argument("--pictures", action="store_true", help="print a line for each picture, not for each scene")
    for kind in ("json", "csv", "html"):
        parser.add_argument(f"--{kind}", metavar="FILE", type=Path,
                            help=f"write the results as {kind.upper()}; - is standard output, without the table")
    arguments = parser.parse_args()
    if os.name != "posix":
        parser.error("limits of time and memory need Linux or macOS")
    arguments.scenes = [name.strip() for name in arguments.scenes.split(",")]
    for name in arguments.scenes:
        if name not in known:
            parser.error(f"--scenes: there is no scene '{name}', only {', '.join(known)}")
    if arguments.size < 4 or arguments.jobs < 1 or arguments.time_limit <= 0 or arguments.memory_limit <= 0:
        parser.error("--size is at least 4, --jobs at least 1, and limits are above 0")
    for folder in (arguments.starter / "data", arguments.starter / "sample_out"):
        if not folder.is_dir():
            parser.error(f"there is no folder {folder}")
    files = [path for path in (arguments.json, arguments.csv, arguments.html) if path]
    if files.count(STANDARD_OUTPUT) > 1:
        parser.error("only one kind of results can be written to standard output")
    for path in files:
        if not path.resolve().parent.is_dir():
            parser.error(f"there is no folder for '{path}'")
    for submission in arguments.submissions:
        if not submission.exists():
            parser.error(f"there is no program or folder '{submission}'")
        if submission.is_file() and not os.access(submission, os.X_OK):
            parser.error(f"'{submission}' is no folder, and cannot be executed")
    return arguments


def short_names(paths):
    """Returns for each path its last parts: as many as make all names different, if they are."""
    parts = [path.resolve().parts for path in paths]
    for count in range(1, max(map(len, parts)) + 1):
        names = ["/".join(some[-count:]) for some in parts]
        if len(set(names)) == len(names):
            break
    return names


def graded(grader, submissions, arguments):
    """Returns the results of all submissions in order: for each a list of one for each scene."""
    scenes = {scene.number: scene for scene in batch.read()}
    tasks = [(path, name) for path in submissions for name in arguments.scenes]
    executor = ThreadPoolExecutor(arguments.jobs)
    try:
        futures = [
            executor.submit(grader.antialiasing, path)
            if name == ANTIALIASING
            else executor.submit(grader.scene, path, scenes[name])
            for path, name in tasks
        ]
        results = []
        for future in futures:
            results.append(future.result())
            if sys.stderr.isatty():
                end = "\n" if len(results) == len(tasks) else ""
                print(f"\r{len(results)} of {len(tasks)}", end=end, file=sys.stderr, flush=True)
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        grade_run.end_all()
        raise
    finally:
        executor.shutdown()
    count = len(arguments.scenes)
    return [results[at : at + count] for at in range(0, len(results), count)]


def opened(path):
    """Opens a file to write; it is closed by `with`, unless it is standard output."""
    return contextlib.nullcontext(sys.stdout) if path == STANDARD_OUTPUT else open(path, "w", encoding="utf-8")


def grade(arguments):
    """Grades, prints and writes all. Returns whether every submission has full credit."""
    judge = comparing.judge()
    submissions = arguments.submissions or [Path(os.environ.get("A2") or judge)]
    submissions = [path.resolve() for path in submissions]
    with tempfile.TemporaryDirectory() as work:
        grader = grade_judge.Grader(judge, arguments, Path(work))
        results = graded(grader, submissions, arguments)
        found = [
            grade_page.Submission(name, path, rows)
            for name, path, rows in zip(short_names(submissions), submissions, results)
        ]
        if STANDARD_OUTPUT not in (arguments.json, arguments.csv, arguments.html):
            print(grade_page.picture_table(found) if arguments.pictures else grade_page.table(found))
        if arguments.json:
            with opened(arguments.json) as file:
                file.write(grade_page.json_text(found, grader))
        if arguments.csv:
            with opened(arguments.csv) as file:
                file.write(grade_page.csv_text(found))
        if arguments.html:
            with opened(arguments.html) as file:
                grade_page.write_html(file, found, grader)
    return all(row.status == "ok" for submission in found for row in submission.rows)


def main():
    # Ends as Ctrl-C does: with all programs that run.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        return 0 if grade(parsed_arguments()) else 1
    except KeyboardInterrupt:
        print("error: interrupted", file=sys.stderr)
    except (grade_judge.CannotGrade, subprocess.CalledProcessError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())

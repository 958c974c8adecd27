#!/usr/bin/env python3
"""Times a2 against Tachyon and POV-Ray, whole processes in turn, and prints a Markdown table of ratios.

    benches/peers/run.py [--a2 PATH] [--also PATH]... [--data FOLDER] [--repeats N] [--only WORD] [--quick]
                         [--record FILE]

Every round runs each program once, in turn, so that a slow phase of the machine affects all of them. Figures are
medians (least .. most) in seconds; a ratio above 1 says how many times faster a2 is. A peer that is not installed is
left out with a message. Exit code 0: everything ran and wrote its pictures; 1: something failed.
"""

import argparse
import datetime
import json
import os
import platform
import shutil
import statistics
import struct
import subprocess
import sys
import time
from pathlib import Path

sys.dont_write_bytecode = True
from jobs import ROOT, Planner  # noqa: E402

PACKAGES = {"tachyon": "tachyon-bin-nox", "povray": "povray", "pngtopnm": "netpbm"}


class Failed(Exception):
    pass


def run_once(commands, folder):
    start = time.perf_counter()
    for command in commands:
        done = subprocess.run(
            command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        if done.returncode != 0:
            tail = done.stdout.decode(errors="replace")[-500:]
            raise Failed(f"{' '.join(command)}\nended with code {done.returncode}: {tail}")
    return time.perf_counter() - start


def check_pictures(job):
    for path, size in job.pictures:
        head = path.read_bytes()[:24] if path.exists() else b""
        if head[:8] != b"\x89PNG\r\n\x1a\n" or struct.unpack(">II", head[16:24]) != (size, size):
            raise Failed(f"{job.name}: {path.name} is not a PNG of {size} x {size}")


def measure(job, folder, repeats):
    for path, _ in job.pictures:
        path.unlink(missing_ok=True)
    seconds = {label: [] for label in job.programs}
    for _ in range(repeats):
        for label, commands in job.programs.items():
            seconds[label].append(run_once(commands, folder))
    check_pictures(job)
    return seconds


def shown(values):
    digits = 3 if statistics.median(values) < 10 else 1
    text = f"{statistics.median(values):.{digits}f}"
    return text if len(values) == 1 else f"{text} ({min(values):.{digits}f} .. {max(values):.{digits}f})"


def table_rows(job, seconds):
    labels = list(seconds)
    first, others = labels[0], labels[1:]
    for other in others or [None]:
        row = [job.name, shown(seconds[first])]
        if other:
            ratio = statistics.median(seconds[other]) / statistics.median(seconds[first])
            row += [other, shown(seconds[other]), f"{ratio:.2f}"]
        yield "| " + " | ".join(row + ["", "", ""][: 5 - len(row)]) + " |"


def machine():
    model = platform.machine()
    if Path("/proc/cpuinfo").exists():
        names = [line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
        model = names[0] if names else model
    try:
        system = platform.freedesktop_os_release()["PRETTY_NAME"]
    except OSError:
        system = platform.system()
    return {"processor": model, "cores": os.cpu_count(), "system": system}


def commit():
    git = lambda *words: subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True).stdout.strip()
    changed = "+changes" if git("status", "--porcelain", "--untracked-files=no") else ""
    return (git("rev-parse", "--short", "HEAD") or "none") + changed


def package_versions(peers):
    if not shutil.which("dpkg-query"):
        return {}
    found = {}
    for peer in peers:
        query = ["dpkg-query", "-W", "-f", "${Version}", PACKAGES[peer]]
        found[peer] = subprocess.run(query, capture_output=True, text=True).stdout or "not a Debian package"
    return found


def record(file, args, peers, results):
    target = file if file.parent != Path(".") else ROOT / "benches" / "record" / file
    target.parent.mkdir(parents=True, exist_ok=True)
    # Records are committed, so they contain no folder names of the machine.
    words = [Path(word).name if "/" in word else word for word in sys.argv[1:]]
    entry = {
        "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        "commit": commit(),
        "command": " ".join(["benches/peers/run.py", *words]),
        "machine": machine(),
        "versions": package_versions(peers),
        "size": args.size,
        "threads": args.threads,
        "seconds": results,
    }
    with open(target, "a") as out:
        out.write(json.dumps(entry) + "\n")
    print(f"recorded in {target}", file=sys.stderr)


def installed_peers():
    peers = []
    for peer in ("tachyon", "povray"):
        missing = [tool for tool in (peer, "pngtopnm") if not shutil.which(tool)]
        for tool in missing:
            print(f"{peer}: left out, no `{tool}` (Debian: apt-get install {PACKAGES[tool]})", file=sys.stderr)
        if not missing:
            peers.append(peer)
    return peers


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--a2", type=Path, default=ROOT / "target" / "release" / "a2")
    parser.add_argument("--also", type=Path, action="append", default=[], help="another a2 that joins the table")
    parser.add_argument("--data", type=Path, default=ROOT / "data", help="folder of scene01*.txt .. scene07*.txt")
    parser.add_argument("--work", type=Path, default=ROOT / "target" / "peers", help="folder for scenes and pictures")
    parser.add_argument("--size", type=int, help="width and height of the pictures (800)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, help="rounds (7; at most 3 of the jobs with 144 rays a pixel)")
    parser.add_argument("--only", default="", help="only the jobs whose name contains this")
    parser.add_argument("--quick", action="store_true", help="one round, 200 x 200, 64,000 triangles for 1,024,000")
    parser.add_argument("--record", type=Path, help="append to this file (in benches/record/)")
    args = parser.parse_args()
    args.size = args.size or (200 if args.quick else 800)
    args.repeats = args.repeats or (1 if args.quick else 7)
    return args


def main():
    args = arguments()
    ours = {"a2": str(args.a2.resolve())}
    for path in args.also:
        label = path.name if path.name not in ours else f"a2 ({path.resolve().parent.name})"
        ours[label if label not in ours else f"{label} {len(ours)}"] = str(path.resolve())
    for path in ours.values():
        if not os.access(path, os.X_OK):
            print(f"run.py: no program at {path} (build it: cargo build --release)", file=sys.stderr)
            return 1
    peers = installed_peers()
    try:
        planner = Planner(ours, peers, args.data.resolve(), args.work.resolve(), args.size, args.threads)
        print(f"{args.size} x {args.size}, {args.threads} threads, seconds a process: median (least .. most)\n")
        print("| work | a2 | against | its time | ratio |\n|---|---|---|---|---|")
        results = {}
        for job in planner.jobs("64k" if args.quick else "1m", args.only):
            rounds = min(args.repeats, 3) if job.is_long else args.repeats
            results[job.name] = measure(job, planner.work, rounds)
            print("\n".join(table_rows(job, results[job.name])), flush=True)
        if not results:
            raise Failed(f"no job's name contains {args.only!r}, or all were left out")
    except (Failed, OSError, ValueError, KeyError, IndexError, subprocess.CalledProcessError) as error:
        print(f"run.py: {error}", file=sys.stderr)
        return 1
    if args.record:
        record(args.record, args, peers, results)
    return 0


if __name__ == "__main__":
    sys.exit(main())

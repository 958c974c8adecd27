"""Runs programs that nobody vouches for: with limits of time and memory, and none of their processes survives."""

import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

# Runs the program within limits, writes its exit code, and becomes a Python that writes what it has cost. A shell does
# this, because the system counts as memory of a process what it took before it became the program: that of this small
# shell, and not of the grader. `ulimit` counts memory in KiB and files in 512 bytes; a system that has no such limit (macOS
# has none of memory) runs the program without it. SIGTERM ends the program, and this shell goes on.
LIMITED = """
trap : TERM
errors=$1 memory=$2 file=$3 python=$4 cost=$5
shift 5
(ulimit -c 0; ulimit -f "$file" 2>/dev/null; ulimit -v "$memory" 2>/dev/null; exec "$@") >/dev/null 2>"$errors"
echo $?
exec "$python" -I -S -c "$cost"
"""
COST = """
import resource, sys
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
# Linux counts KiB, macOS bytes.
print(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / (1 << 20 if sys.platform == "darwin" else 1 << 10))
"""
# Seconds between SIGTERM and SIGKILL for a program that is late.
GRACE = 1
# The largest file that a program may write, in bytes.
LARGEST_FILE = 1 << 30
# Characters of a program's error messages that are kept.
KEPT_OUTPUT = 400
# A shell script ends with 128 and the number of the signal that ended the program in it.
SIGNAL_BASE = 128

# The processes of all runs, or none when no more may run.
RUNNING = set()
RUNNING_LOCK = threading.Lock()


@dataclass
class Run:
    """How a run ended."""

    # finished, failed (an exit code other than 0), crashed (a signal) or timed out.
    status: str
    # Exit code, signal or time.
    detail: str
    seconds: float
    # Of all processors, and the most memory at a time; None where the whole group was killed, so nobody could measure it.
    cpu_seconds: float | None
    megabytes: float | None
    # The end of what the program wrote to standard error.
    messages: str

    def costs(self):
        """Returns wall seconds, processor seconds and megabytes as texts, empty where they are not known."""
        known = [(self.seconds, ".2f"), (self.cpu_seconds, ".2f"), (self.megabytes, ".0f")]
        return ["" if number is None else f"{number:{form}}" for number, form in known]


def kill_group(pid, number=signal.SIGKILL):
    """Ends a process and all that it started."""
    try:
        os.killpg(pid, number)
    except (ProcessLookupError, PermissionError):
        # Nobody is left; macOS calls that a lack of permission.
        pass


def end_all():
    """Ends all runs, and lets no other begin."""
    global RUNNING
    with RUNNING_LOCK:
        for pid in RUNNING or ():
            kill_group(pid)
        RUNNING = None


class Ended(Exception):
    """No more programs may run."""


def run(command, folder, seconds, megabytes):
    """Runs a command in a folder, in a process group of its own, which is ended after so many seconds of time."""
    errors = Path(folder) / ".stderr"
    limits = [str(int(megabytes * 1024)), str(LARGEST_FILE // 512)]
    start = time.monotonic()
    with RUNNING_LOCK:
        if RUNNING is None:
            raise Ended
        process = subprocess.Popen(
            ["sh", "-c", LIMITED, "sh", str(errors.resolve()), *limits, sys.executable, COST, *command],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        RUNNING.add(process.pid)
    is_late = threading.Event()
    timers = [
        threading.Timer(seconds, lambda: (is_late.set(), kill_group(process.pid, signal.SIGTERM))),
        threading.Timer(seconds + GRACE, lambda: kill_group(process.pid)),
    ]
    for timer in timers:
        timer.start()
    code = process.stdout.readline()
    elapsed = time.monotonic() - start
    timers[0].cancel()
    cost = process.stdout.read().split()
    process.wait()
    timers[1].cancel()
    process.stdout.close()
    # What it has left behind.
    kill_group(process.pid)
    with RUNNING_LOCK:
        if RUNNING is not None:
            RUNNING.discard(process.pid)
    name, detail = ending(int(code or process.returncode), is_late.is_set(), seconds)
    cpu_seconds, memory = map(float, cost) if cost else (None, None)
    text = errors.read_bytes()[-KEPT_OUTPUT:].decode(errors="replace").strip() if errors.is_file() else ""
    return Run(name, detail, elapsed, cpu_seconds, memory, text)


def ending(code, is_late, seconds):
    """Returns the status of a run and its detail, from an exit code or a negative signal."""
    if is_late:
        return "timed out", f"after {seconds:g} s"
    if code == 0:
        return "finished", ""
    number = -code if code < 0 else code - SIGNAL_BASE
    if code < 0 or number in set(signal.Signals):
        return "crashed", signal.Signals(number).name
    return "failed", f"exit code {code}"

"""Runs programs that nobody vouches for: with limits of time and memory, and none of their processes survives."""

import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

# Sets the limits and becomes the program. A shell does this, because Python may not run code of its own between fork and
# exec while other threads run. `ulimit` counts memory in KiB and files in 512 bytes; a system that has no such limit
# (macOS has none of memory) runs the program without it.
LIMITED = 'ulimit -c 0; ulimit -f "$2" 2>/dev/null; ulimit -v "$1" 2>/dev/null; shift 2; exec "$@"'
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
    cpu_seconds: float
    # The most memory at a time.
    megabytes: float
    # The end of what the program wrote to standard error.
    messages: str


def kill_group(pid):
    """Ends a process and all that it started."""
    try:
        os.killpg(pid, signal.SIGKILL)
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
    limits = [str(int(megabytes * 1024)), str(LARGEST_FILE // 512)]
    errors = Path(folder) / ".stderr"
    start = time.monotonic()
    with RUNNING_LOCK, open(errors, "wb") as stderr:
        if RUNNING is None:
            raise Ended
        process = subprocess.Popen(
            ["sh", "-c", LIMITED, "sh", *limits, *command],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=stderr,
            start_new_session=True,
        )
        RUNNING.add(process.pid)
    is_late = threading.Event()
    timer = threading.Timer(seconds, lambda: (is_late.set(), kill_group(process.pid)))
    timer.start()
    _, status, usage = os.wait4(process.pid, 0)
    elapsed = time.monotonic() - start
    timer.cancel()
    process.returncode = os.waitstatus_to_exitcode(status)
    # What it has left behind.
    kill_group(process.pid)
    with RUNNING_LOCK:
        if RUNNING is not None:
            RUNNING.discard(process.pid)
    name, detail = ending(process.returncode, is_late.is_set(), seconds)
    # Linux counts KiB, macOS bytes.
    memory = usage.ru_maxrss / (1 << 20 if sys.platform == "darwin" else 1 << 10)
    text = errors.read_bytes()[-KEPT_OUTPUT:].decode(errors="replace").strip()
    return Run(name, detail, elapsed, usage.ru_utime + usage.ru_stime, memory, text)


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

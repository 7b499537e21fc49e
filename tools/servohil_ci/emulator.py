"""`servohil run` as a process: started, ready, ended, judged."""

import ctypes
import functools
import re
import shutil
import signal
import subprocess
import threading
from dataclasses import dataclass
from pathlib import Path

from .failure import INVALID, NOTHING, OK, USAGE, Failure

__tracebackhide__ = True  # pytest: a failure is shown where the test called

_C = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1  # <linux/prctl.h>
PATIENCE_S = 20.0  # for what comes within milliseconds unless something is broken


def find_program():
    """The program of this installation or repository, else the one in PATH; None: there is none."""
    home = Path(__file__).resolve().parent.parent.parent  # PREFIX/share/servohil, or the repository
    for program in ("../../bin/servohil", "build/release/bin/servohil"):
        if (home / program).is_file():
            return (home / program).resolve()
    found = shutil.which("servohil")
    return Path(found) if found else None


@functools.cache
def run_help(program):
    """What `servohil run --help` says: which options this version has."""
    try:
        return subprocess.run([program, "run", "--help"], capture_output=True, text=True, timeout=PATIENCE_S).stdout
    except (OSError, subprocess.SubprocessError) as error:
        raise Failure(NOTHING, f"{program}: cannot be run: {getattr(error, 'strerror', None) or error}") from None


@dataclass(frozen=True)
class Outcome:
    """What a run left: its summary and what it says of itself. verdict: "VALID" or "INVALID: reasons"."""

    status: int
    summary: str
    verdict: str
    hash: str

    @property
    def valid(self):
        return self.status == OK


class Emulator:
    """A running `servohil run`; url: where to connect; process: its subprocess.Popen."""

    def __init__(self, program, arguments, log, on_end):
        """Returns when the program is ready. log: file for its standard error; on_end(): called from a thread when the
        program ends."""
        self._log = Path(log)
        self._output = []
        with open(self._log, "w", encoding="utf-8") as errors:
            self.process = subprocess.Popen([program, "run", *map(str, arguments)], stdout=subprocess.PIPE,
                                            stderr=errors, stdin=subprocess.DEVNULL, text=True,
                                            preexec_fn=_end_with_parent)
        self.ready = self._first_line()
        if not self.ready.startswith("ready: "):
            raise self._why_not_ready()
        self.url = self.ready[len("ready: "):].split(";")[0].split(", ")[0]
        self._reader = threading.Thread(target=self._read, args=(on_end,), daemon=True)
        self._reader.start()

    def _first_line(self):
        watchdog = threading.Timer(PATIENCE_S, self.process.kill)
        watchdog.start()
        try:
            return self.process.stdout.readline()
        except BaseException:
            self.process.kill()
            raise
        finally:
            watchdog.cancel()

    def _read(self, on_end):
        self._output.append(self.process.stdout.read())
        on_end()

    def _why_not_ready(self):
        self.process.kill()
        status = self.process.wait()
        self.process.stdout.close()
        lines = [line for line in self.log().splitlines() if ": info: " not in line]
        if status in (USAGE, NOTHING) and lines:
            return Failure(status, lines[-1])
        return Failure(NOTHING, f"servohil did not get ready: {_told(status)}\n{self.log()}")

    def log(self):
        """Standard error so far."""
        return self._log.read_text(encoding="utf-8", errors="replace")

    def end(self):
        """SIGTERM, then its outcome. Raises a Failure with its standard error if it crashed or does not end."""
        for how in (signal.SIGTERM, signal.SIGCONT):  # a stopped process would not hear
            self.process.send_signal(how)
        return self.outcome()

    def outcome(self):
        """Waits for the end of a program that is ending."""
        try:
            status = self.process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise Failure(NOTHING, f"servohil did not end within {PATIENCE_S:g} s of SIGTERM, and was killed\n"
                                   f"{self.log()}") from None
        self._reader.join()
        self.process.stdout.close()
        summary = "".join(self._output)
        said = dict(re.findall(r"^(\w+) +(.*)$", summary, re.M))
        expected = {OK: "VALID", INVALID: "INVALID"}.get(status)
        if expected is None or not said.get("verdict", "").startswith(expected):
            raise Failure(NOTHING, f"servohil crashed: {_told(status)}\n{self.log()}")
        return Outcome(status, summary, said["verdict"], said.get("hash", ""))

    def kill(self):
        """Whatever state it is in, it is gone."""
        self.process.kill()
        self.process.wait()


def _end_with_parent():
    """In the new process: an emulator left behind on vcan0 would answer to the next run's commands."""
    _C.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def _told(status):
    if status >= 0:
        return f"exit status {status}"
    try:
        return f"killed by {signal.Signals(-status).name}"
    except ValueError:
        return f"killed by signal {-status}"

"""Latencies [us] of one `servohil run` and of one cyclictest, and what surrounds them: a client, load."""
import contextlib
import json
import os
import re
import select
import signal
import subprocess
import tempfile
import threading
import time
import tty

from bench_rounds import PROGRAM, REPOSITORY, fail, finished
from governor_bus import Contract

PRIORITY = 80
PERIOD_US = 100
QUANTILES = {"p50": "p50_ns", "p99": "p99_ns", "p99.9": "p99_9_ns", "max": "max_ns"}
COMMAND_S = 0.01  # cycle time of the client's commands


def require_real_time():
    """Both measure a SCHED_FIFO thread; without the permission there is nothing to measure."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    except PermissionError:
        user = os.environ.get("USER", "USER")
        fail(f"this user may not use SCHED_FIFO {PRIORITY}, so that wake-ups cannot be measured: run it as root, or "
             f"put '{user} - rtprio {PRIORITY}' and '{user} - memlock unlimited' into /etc/security/limits.conf and "
             "log in again")


class Client:
    """A governor on the emulator's pseudo-terminal, as light as can be: a command every 10 ms; reads all frames."""

    def __init__(self, terminal):
        contract = Contract(REPOSITORY / "config" / "servohil.dbc")
        frames = [contract.encode(30.263 + 0.3 * (-1) ** (count // 50), count) for count in range(400)]
        self._commands = [f"t{f.arbitration_id:03X}{f.dlc}{f.data.hex().upper()}\r".encode() for f in frames]
        self._fd = os.open(terminal, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self._fd)
        os.write(self._fd, b"S8\rO\r")
        self._thread = threading.Thread(target=self._talk, daemon=True)
        self._thread.start()

    def _talk(self):
        """Until the emulator is gone."""
        next_s, count = time.monotonic(), 0
        with contextlib.suppress(OSError):
            while True:
                if select.select([self._fd], [], [], max(0.0, next_s - time.monotonic()))[0]:
                    if not os.read(self._fd, 65536):
                        break
                if time.monotonic() >= next_s:
                    os.write(self._fd, self._commands[count % len(self._commands)])
                    next_s, count = next_s + COMMAND_S, count + 1

    def close(self):
        self._thread.join()
        os.close(self._fd)


def run_servohil(arguments, seconds, cpu, with_client):
    """Statistics of a run in real time, one tick a wake-up; status 1: it had late ticks, which are told."""
    with tempfile.NamedTemporaryFile(suffix=".json") as statistics, tempfile.TemporaryFile("w+") as errors:
        command = [PROGRAM, "run", "--can", "slcan:pty", "--rt", "require", "--duration", seconds, "--control", "none",
                   "--stats", statistics.name, "--set", "loop.wake_ticks=1", "--set", f"loop.priority={PRIORITY}",
                   "--set", f"loop.cpu={cpu}", "--set", "can.bit_rate_bit_s=1000000", *arguments]
        process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=errors, text=True,
                                   cwd=REPOSITORY)
        try:
            ready = re.match(r"ready: slcan:([^;,]+)", process.stdout.readline())
            client = Client(ready[1]) if ready and with_client else None
            summary = process.stdout.read()
            status = process.wait()
            if client:
                client.close()
        finally:
            process.kill()
            process.wait()
        if status not in (0, 1):
            errors.seek(0)
            fail(f"servohil ended with {status}: {errors.read().strip().splitlines()[-1]}")
        if "--record" in arguments and not re.search(r"^recorded .*; complete$", summary, re.MULTILINE):
            print("NOTE: the recording is not complete, its cost too low: the disk of --record-dir is too slow or full")
        return json.load(open(statistics.name, encoding="utf-8"))


def quantiles_us(histogram):
    return {name: histogram[key] / 1e3 for name, key in QUANTILES.items()}


def traffic_of(statistics, seconds):
    """What a run did, as numbers of a table."""
    traffic = statistics["traffic"]
    return {"late": statistics["late"]["ticks"], "sent": traffic["published"] / seconds,
            "not_sent": traffic["not_sent"] / seconds, "commands": traffic["commands"] / seconds}


def cyclictest_us(seconds, cpu):
    """Its wake-ups, from its 1 ns histogram; quantiles past 1 ms are its maximum."""
    text = finished(["cyclictest", "-q", "-m", "-N", "-t1", "-a", cpu, "-p", PRIORITY, "-i", PERIOD_US, "-D", seconds,
                     "-h", 1000000]).stdout
    counts = [(int(line[:6]), int(line[7:])) for line in text.splitlines()
              if line[:1].isdigit() and not line.endswith(" 000000")]
    worst = int(re.search(r"# Max Latencies: (\d+)", text)[1])
    total = sum(count for _, count in counts) + int(re.search(r"# Histogram Overflows: (\d+)", text)[1])

    def quantile_us(fraction):
        below = 0
        for ns, count in counts:
            below += count
            if below >= fraction * total:
                return ns / 1e3
        return worst / 1e3

    return {"p50": quantile_us(0.5), "p99": quantile_us(0.99), "p99.9": quantile_us(0.999), "max": worst / 1e3}


@contextlib.contextmanager
def load(limit_s):
    """stress-ng on every CPU while the context lasts; it ends itself after `limit_s`, whatever becomes of us."""
    command = ["stress-ng", "--cpu", len(os.sched_getaffinity(0)), "--vm", 1, "--vm-bytes", "128M", "--io", 1,
               "--temp-path", tempfile.gettempdir(), "--timeout", limit_s]
    try:
        process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    except FileNotFoundError:
        fail("stress-ng is missing; tools/deps.sh test installs it")
    try:
        while "dispatching hogs" not in (line := process.stdout.readline()):
            if not line:
                fail(f"stress-ng ended with {process.wait()}")
        yield
        if process.poll() is not None:
            print("NOTE: the load ended before the last round")
    finally:
        process.send_signal(signal.SIGINT)  # it ends its children
        process.communicate()

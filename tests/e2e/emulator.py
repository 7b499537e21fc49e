"""Runs `servohil run` for the bus tests, and a client of it: python-can, with canmatrix for the DBC file.

Nothing here sleeps: every wait is for a line, a frame or the end of a process, and has a deadline.
"""

import contextlib
import logging
import os
import re
import signal
import subprocess
import tempfile
import threading
import time
from pathlib import Path

import can

REPOSITORY = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("SERVOHIL_BUILD", REPOSITORY / "build" / "release")).resolve()
PROGRAM = BUILD / "bin" / "servohil"
CONFIGURATION = REPOSITORY / "config" / "servohil.toml"
DBC = REPOSITORY / "config" / "servohil.dbc"

OK, NOT_VALID, USAGE, ENVIRONMENT = 0, 1, 2, 3  # exit statuses of the program
WAITING, RUNNING, STOPPED, FROZEN = 0, 1, 3, 4  # signal Mode
DEGRADED, TRIPPED = 5, 6
TICKS_PER_MS = 10
MOST_AGE_TICKS = 200  # of a frame that waits: 20 ms
PATIENCE_S = 20.0  # for anything that should come within milliseconds: the machine may be busy
IN_GUEST = bool(os.environ.get("SERVOHIL_GUEST"))  # virtual time: no tick is ever late


def run(*arguments, status=OK, **more):
    """The program to its end."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=60, cwd=REPOSITORY,
                          **more)
    assert done.returncode == status, f"exit status {done.returncode}, expected {status}: {done.args}\n{done.stderr}"
    return done


def settings(**keys):
    """settings(publish__position_ms=1) → --set publish.position_ms=1"""
    return [word for key, value in keys.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


# Tests send a command when they have something to say, and the machine may stall for seconds.
UNSUPERVISED = settings(safety__timeout_ms=0, safety__max_age_ms=0)


class Emulator:
    """A running `servohil run`. As a context: killed at the end if it still runs. Commands count for ever, however old
    they are, unless the arguments say otherwise."""

    def __init__(self, buses, *arguments, program=PROGRAM, lives_s=120.0, **more):
        self._errors = tempfile.TemporaryFile("w+")
        self._process = subprocess.Popen(
            [program, "run", *(word for bus in buses for word in ("--can", bus)), *UNSUPERVISED, *map(str, arguments)],
            stdout=subprocess.PIPE, stderr=self._errors, text=True, cwd=REPOSITORY, **more)
        self.process_id = self._process.pid
        self._watchdog = threading.Timer(lives_s, self._process.kill)  # no test may hang
        self._watchdog.start()
        self.ready = self._process.stdout.readline()
        if not self.ready.startswith("ready: "):
            status = self._finish()
            raise AssertionError(f"no ready line but {self.ready!r}, exit status {status}:\n{self.log()}")
        self.urls = self.ready[len("ready: "):].split(";")[0].split(", ")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._finish()
        self._errors.close()

    def _finish(self):
        status = self._process.wait()
        self._watchdog.cancel()
        return status

    def log(self):
        """Standard error so far."""
        self._errors.seek(0)
        return self._errors.read()

    def signal(self, how):
        self._process.send_signal(how)

    @contextlib.contextmanager
    def stopped(self):
        """It stands still inside the context."""
        self.signal(signal.SIGSTOP)
        while Path(f"/proc/{self.process_id}/stat").read_text().rpartition(")")[2].split()[0] != "T":
            pass
        yield
        self.signal(signal.SIGCONT)

    def pause(self, seconds):
        """Stops it for at least this long; @return how long it certainly stood [s]"""
        with self.stopped():
            begin = time.monotonic()
            let_time_pass(seconds)
            return time.monotonic() - begin

    def continue_after(self, seconds):
        """SIGCONT, later and from elsewhere."""
        threading.Timer(seconds, self.signal, (signal.SIGCONT,)).start()

    def stop(self, may_be_late=not IN_GUEST):
        """Ends it; exit status and summary."""
        self.signal(signal.SIGTERM)
        return self.wait(may_be_late)

    def wait(self, may_be_late=not IN_GUEST):
        text = self._process.stdout.read()
        return Result(self._finish(), text, self.log(), may_be_late)


    def end(self):
        """Waits for its end; exit status and all that it has said."""
        text = self._process.stdout.read()
        return self._finish(), text


class Result:
    """What a run left: its exit status and its summary in numbers."""

    def __init__(self, status, text, log, may_be_late):
        self.status, self.text, self.log = status, text, log
        assert status in (OK, NOT_VALID), f"exit status {status}\n{text}\n{log}"
        lines = dict(re.findall(r"^(\w[\w-]*) +(.*)$", text, re.M))
        assert lines.keys() >= {"ran", "hash", "in", "out", "bus", "verdict"}, text
        self.real_time = "wake-up" in lines
        self.ticks = int(re.match(r"(\d+) ticks", lines["ran"])[1])
        self.x3_in = float(re.search(r"x3 ([\d.]+) in", lines["ran"])[1])
        self.hash = lines["hash"]
        self.late_ticks = int(re.search(r"late ticks (\d+)", lines["wake-up"])[1]) if self.real_time else 0
        self.count = {name: int(n) for key in ("in", "out") for n, name in re.findall(r"(\d+) ([a-z ]+)", lines[key])}
        self.buses = [{name: int(n) for n, name in re.findall(r"(\d+) ([a-z() ]+)", line)}
                      for line in re.findall(r"^bus +[^:]+:[^:]+: (.*)$", text, re.M)]
        self.verdict = lines["verdict"]
        # Exit status, verdict and late ticks tell the same.
        valid = status == OK
        self.modelled_bus_failed = "bus: this schedule fails on a real one" in self.verdict
        assert self.verdict.startswith("VALID" if valid else "INVALID: "), text
        assert ("timing: " in self.verdict) == (self.late_ticks > 0), text
        assert valid == (self.late_ticks == 0 and not self.modelled_bus_failed), text
        assert self.late_ticks == 0 or may_be_late, text


def wait_for(condition, patience_s=30.0):
    """Looks each 10 ms; fails after a while."""
    end = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < end, "it did not come"
        time.sleep(0.01)


def let_time_pass(seconds):
    """As long as another emulator runs, on a terminal of its own."""
    with Emulator(["slcan:pty"], "--rt", "off", "--duration", seconds) as clock:
        clock.wait(may_be_late=True)


def load_dbc(path):
    logging.getLogger("canmatrix").setLevel(logging.CRITICAL)  # "xlsx is not supported"
    import canmatrix.formats  # seconds where a processor is emulated, and not every test has a client

    return canmatrix.formats.loadp_flat(str(path))


class Frame:
    """A frame of the emulator: message's name, its physical values, and what came over the wire."""

    def __init__(self, name, values, raw):
        self.name, self.values, self.raw = name, values, raw

    def __getitem__(self, signal_name):
        return self.values[signal_name]


class Client:
    """A governor on the bus."""

    def __init__(self, url, dbc=DBC, fd=False):
        """@param fd  with CAN FD, which a serial adapter does not have"""
        interface, _, channel = url.partition(":")
        self._more = {"sleep_after_open": 0.0, "bitrate": 500000} if interface == "slcan" else {}
        self._more |= {"fd": True} if fd else {}
        self._where = {"interface": interface, "channel": channel}
        database = load_dbc(dbc)
        self.messages = {m.name: m for m in database.frames}
        self._by_id = {m.arbitration_id.id: m for m in database.frames}
        self._count = 0
        self.open()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.close()
        except (can.CanError, OSError):
            pass  # the emulator went first

    def open(self):
        self.bus = can.Bus(**self._where, **self._more)

    def close(self):
        self.bus.shutdown()

    def resolution(self, message, name):
        return float(self.messages[message].signal_by_name(name).factor)

    def command(self, p1_psi, **more):
        """GOV_Command; canmatrix takes raw integers."""
        message = self.messages["GOV_Command"]
        p1 = message.signal_by_name("P1_Demand")
        raw = round((p1_psi - float(p1.offset)) / float(p1.factor))
        self._count += 1
        data = message.encode({"P1_Demand": raw, "Counter": self._count % 16})
        return can.Message(**{"arbitration_id": message.arbitration_id.id, "is_extended_id": False, "data": data, **more})

    def send(self, *frames):
        for frame in frames:
            self.bus.send(frame)

    def send_p1(self, p1_psi):
        self.send(self.command(p1_psi))

    def receive(self, timeout_s=PATIENCE_S):
        """Next frame, decoded; fails when none comes."""
        raw = self.bus.recv(timeout_s)
        assert raw is not None, f"no frame within {timeout_s} s"
        return self.decode(raw)

    def decode(self, raw):
        message = self._by_id.get(raw.arbitration_id)
        if message is None or raw.is_extended_id or raw.is_remote_frame:
            return Frame(None, {}, raw)
        return Frame(message.name, {n: float(s.phys_value) for n, s in message.decode(raw.data).items()}, raw)

    def until(self, condition, timeout_s=PATIENCE_S):
        """Frames up to and with the first that fulfils the condition."""
        frames, deadline = [], time.monotonic() + timeout_s
        while not frames or not condition(frames[-1]):
            frames.append(self.receive(max(0.0, deadline - time.monotonic())))
        return frames

    def newest(self, name, where=lambda frame: True):
        """Next frame of this message that fulfils the condition."""
        return self.until(lambda frame: frame.name == name and where(frame))[-1]

    def for_ticks(self, ticks):
        """Frames of this long a simulated time, from one SERVO_Position to another."""
        first = self.newest("SERVO_Position")
        return [first, *self.until(lambda frame: frame.name == "SERVO_Position"
                                   and frame["Tick"] >= first["Tick"] + ticks)]

    def frames_so_far(self):
        """What has arrived and was not received yet."""
        frames = []
        while (raw := self.bus.recv(0.0)) is not None:
            frames.append(self.decode(raw))
        return frames

    def until_ended(self):
        """All frames until the emulator is gone: the line breaks, or nothing comes any more."""
        frames = []
        while True:
            try:
                raw = self.bus.recv(1.0)
            except (can.CanError, OSError):
                return frames
            if raw is None:
                return frames
            frames.append(self.decode(raw))


def ticks_of(frames):
    return [int(frame["Tick"]) for frame in frames if frame.name == "SERVO_Position"]


def rounding(resolution):
    """How far a rounded value may be from the one that was rounded."""
    return 0.5 * resolution + 1e-9

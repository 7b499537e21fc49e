#!/usr/bin/python3
"""`servohil run` in real time, one tick a wake-up, with a python-can governor on a real SocketCAN stack, each run in a
guest of tools/vcan-guest, where time is virtual. Are the runs the same, tick for tick?

Of each kind of run it prints: state hashes, late ticks, commands, and how many times faster than real time it was: the
simulated time over the real time from the guest's start to its end, Python's start included, and over the CPU time,
which other programs on the machine change less.

  answering  the governor sends a command for each SERVO_Position
  clocked    the governor sends a command every 10 ms of its own clock, whatever comes back
  recorded   as answering, and every tick is recorded

Exit status: 0 each kind has one hash and no late tick; 1 not so; 2 usage; 3 no guest.
"""
import argparse
import collections
import json
import os
import resource
import signal
import statistics
import subprocess
import sys
import time

from emulator import IN_GUEST, PROGRAM, REPOSITORY, STOPPED, Client, Emulator, settings

KINDS = ("answering", "clocked", "recorded")
BUS = "socketcan:vcan0"
RUN = {"loop__wake_ticks": 1, "friction__coulomb_psi": 3}
CYCLE_S = 0.01
REST_P1_PSI = 30.263


class Governor:
    """Pushes P1 by where the piston is: a command that is lost, doubled or a tick late changes all that follows."""

    def __init__(self, client):
        self._client = client
        self._x3_in = 4.0
        self.commands = 0

    def send(self):
        target_in = 4.0 + (0.5 if self.commands // 100 % 2 else -0.3)
        self._client.send_p1(REST_P1_PSI + 2.0 * (target_in - self._x3_in))
        self.commands += 1

    def read(self, timeout_s):
        """Name of the next frame, None when none came; StopIteration when it was the emulator's last."""
        raw = self._client.bus.recv(timeout_s)
        if raw is None:
            return None
        frame = self._client.decode(raw)
        if frame.name == "SERVO_Position":
            self._x3_in = frame["X3"]
        if frame.name == "SERVO_Status" and frame["Mode"] == STOPPED:
            raise StopIteration
        return frame.name


def answer(governor):
    while True:
        name = governor.read(10.0)
        assert name is not None, "the emulator fell silent"
        if name == "SERVO_Position":
            governor.send()


def send_by_the_clock(governor):
    next_s = time.monotonic()
    while True:
        governor.send()
        next_s += CYCLE_S
        while (left_s := next_s - time.monotonic()) > 0:
            governor.read(left_s)


def run_here(kind, duration_s, phase_s):
    """One run, in this guest; what it was as JSON."""
    record = ["--record", f"{os.environ['GUEST_OUT']}/recording"] if kind == "recorded" else []
    with Emulator([BUS], *settings(**RUN), "--duration", duration_s, *record) as emulator:
        time.sleep(phase_s)
        with Client(emulator.urls[0]) as client:
            governor = Governor(client)
            try:
                (send_by_the_clock if kind == "clocked" else answer)(governor)
            except StopIteration:
                pass
        result = emulator.wait(may_be_late=True)
    print(json.dumps({"hash": result.hash, "ticks": result.ticks, "late": result.late_ticks,
                      "sent": governor.commands, "commands": result.count["commands"]}))


def cpu_s():
    """Of all processes that this one has started and that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_in_a_guest(kind, arguments):
    """One run in a guest of its own, and the real time that it took."""
    begin_s, begin_cpu_s = time.monotonic(), cpu_s()
    guest = [REPOSITORY / "tools" / "vcan-guest", "--timeout", arguments.timeout,
             "--env", f"SERVOHIL_BUILD={PROGRAM.parents[1]}", "--"]
    itself = ["/usr/bin/python3", __file__, "--kinds", kind, "--duration", arguments.duration,
              "--phase", arguments.phase]
    done = subprocess.run(list(map(str, guest + itself)), capture_output=True, text=True)
    if done.returncode == 125:
        print(done.stderr.strip(), file=sys.stderr)
        sys.exit(3)
    if done.returncode != 0:
        sys.exit(f"guest_determinism: {kind}: {done.stderr.strip()}")
    return {**json.loads(done.stdout), "took_s": time.monotonic() - begin_s, "cpu_s": cpu_s() - begin_cpu_s}


def report(kind, runs, duration_s):
    """True if the runs are one."""
    hashes = collections.Counter(run["hash"] for run in runs)
    late = sum(run["late"] for run in runs)
    speeds = [duration_s / run["took_s"] for run in runs]
    cpu_speed = statistics.median(duration_s / run["cpu_s"] for run in runs)
    commands = sorted({run["commands"] for run in runs})
    whole = all(run["ticks"] == round(duration_s * 1e4) and run["commands"] > 0 for run in runs)
    same = whole and len(hashes) == 1 and late == 0
    print(f"{kind}: {len(runs)} runs of {duration_s:g} s, {'all the same' if same else 'NOT THE SAME'}")
    print(f"  hashes {', '.join(f'{number} x {name}' for name, number in hashes.most_common())}; late ticks {late}; "
          f"commands {', '.join(map(str, commands))}")
    print(f"  {statistics.median(speeds):.2f} ({min(speeds):.2f}..{max(speeds):.2f}) times real time; {cpu_speed:.2f} "
          "s simulated per second of CPU time", flush=True)
    return same


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=10, help="of each kind; default 10")
    parser.add_argument("--duration", type=float, default=60.0, metavar="S", help="simulated time of each; default 60")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS, help="default: all")
    parser.add_argument("--phase", type=float, default=0.0, metavar="S",
                        help="the governor starts this much later; a clocked one is another run then, an answering "
                        "one only from 0.01 s on; default 0")
    parser.add_argument("--timeout", type=int, default=1800, metavar="S", help="real time of a guest at most; "
                        "default 1800")
    arguments = parser.parse_args()
    if IN_GUEST:
        run_here(arguments.kinds[0], arguments.duration, arguments.phase)
        return
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))  # so that the guest is ended, too
    same = [report(kind, [run_in_a_guest(kind, arguments) for _ in range(arguments.runs)], arguments.duration)
            for kind in arguments.kinds]
    sys.exit(0 if all(same) else 1)


if __name__ == "__main__":
    main()

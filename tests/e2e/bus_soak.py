#!/usr/bin/python3
"""Hours on a bad bus, compressed into minutes: a protected governor on vcan9, an adapter beside it, and one disturbance
after the other, in random order. In virtual time, on the real SocketCAN stack:

  tools/vcan-guest --timeout 0 -- tests/e2e/bus_soak.py                 one hour of the bus' time
  tools/vcan-guest --timeout 0 -- tests/e2e/bus_soak.py --hours 4 --seed 7

Every disturbance must be seen and named, and be over for the governor three frames after it is over on the bus; no
frame may be older than 20 ms; at the end every counter must be what was done, and no tick late.
Exit status: 0 so it is; 1 it is not; 2 usage.
"""
import argparse
import collections
import contextlib
import random
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import can

from control_socket import Control
from emulator import IN_GUEST, MOST_AGE_TICKS, OK, Emulator, settings, wait_for
from serial_interface import SerialInterface, ticks_on_line
from test_safety import REST_P1_PSI, Governor

CYCLE_S = 0.010
LOST_AFTER_S = 0.030  # three cycles
PROTECTED = settings(can__command__e2e="crc8_j1850", can__command__counter="Counter",
                     can__command__checksum="Checksum", can__command__max_counter_jump=2, safety__timeout_ms=-1)
ADAPTER = settings(can__allow_physical="true", can__configure="true", can__restart_ms=0)


class GovernorOnBus(threading.Thread):
    """A good frame each cycle, from go_on() to pause(); what comes back is young and in order."""

    def __init__(self):
        super().__init__(daemon=True)
        self.frames = Governor(client=None)  # only its frames: the cycle is real time's
        self.sent = 0
        self.wrong = None  # what was seen that must not be
        self._bus = None
        self._newest_tick = 0
        self._lock = threading.Lock()

    def go_on(self, newest_tick):
        """With a new connection. No frame older than this tick may come."""
        with self._lock:
            self._bus = can.Bus(interface="socketcan", channel="vcan9", receive_own_messages=False,
                                can_filters=[{"can_id": 0x200, "can_mask": 0x7FF, "extended": False}])
            self._newest_tick = newest_tick

    def pause(self):
        with self._lock:
            self._bus.shutdown()
            self._bus = None

    def send(self, frame):
        with self._lock:
            self._bus.send(frame)

    def lose_one(self):
        with self._lock:
            self.frames.count += 1

    def run(self):
        while self.wrong is None:
            with self._lock:
                if self._bus is not None:
                    self._cycle()
            time.sleep(CYCLE_S)

    def _cycle(self):
        self._bus.send(self.frames.frame(REST_P1_PSI))
        self.frames.count += 1
        self.sent += 1
        while (frame := self._bus.recv(0.0)) is not None:
            tick = int.from_bytes(frame.data[4:8], "little")
            if tick <= self._newest_tick:
                self.wrong = f"tick {tick} after {self._newest_tick}: old, or twice"
            self._newest_tick = tick


class Bench:
    """The governor, the two buses and the emulator; what was done to them, counted."""

    def __init__(self, chance):
        self.chance = chance
        self.done = collections.Counter()
        self._interfaces = subprocess.Popen(["ip", "-batch", "-"], stdin=subprocess.PIPE, text=True)
        self.links("add dev vcan9 type vcan", "set vcan9 up")
        wait_for(lambda: Path("/sys/class/net/vcan9").exists())
        self.adapter = SerialInterface()
        self.governor = GovernorOnBus()
        self.governor.start()

    def links(self, *lines):
        self._interfaces.stdin.write("".join(f"link {line}\n" for line in lines))
        self._interfaces.stdin.flush()

    def end(self):
        self.adapter.pull_out()
        self.links("del vcan9")
        self._interfaces.stdin.close()
        self._interfaces.wait()

    def start_governing(self, control):
        """It must be followed from the third frame on."""
        self.governor.go_on(control.ask("status")["tick"] - MOST_AGE_TICKS)
        time.sleep(4 * CYCLE_S)
        assert control.ask("status")["mode"] == "RUNNING", control.ask("status")

    def look(self, control, after):
        """That the governor is followed and gets what it should."""
        assert self.governor.wrong is None, f"after {after}: {self.governor.wrong}"
        assert control.ask("status")["mode"] == "RUNNING", f"after {after}"

    # What befalls the governor's bus. Each begins and ends with a governor that is followed.

    def nothing(self, control):
        time.sleep(self.chance.uniform(1.0, 20.0))

    def governor_vanishes(self, control):
        self.governor.pause()
        time.sleep(self.chance.uniform(2.0, 50.0) * LOST_AFTER_S)
        assert control.ask("status")["mode"] == "DEGRADED"
        self.done["losses"] += 1
        self.start_governing(control)

    def interface_removed(self, control):
        self.governor.pause()
        self.links("del vcan9")
        wait_for(lambda: state_of(control, 0) == "gone")
        time.sleep(self.chance.uniform(0.1, 3.0))
        self.done["losses"] += 1
        self.links("add dev vcan9 type vcan", "set vcan9 up")
        wait_for(lambda: state_of(control, 0) == "error-active")
        self.start_governing(control)

    def foreign_flood(self, control):
        flood("-I", "3i", "-L", "8")

    def flood_with_our_ids(self, control):
        """So many at once that the kernel drops some, and commands among them: the governor is silent meanwhile."""
        self.governor.pause()
        self.done["flood"] += flood("-I", self.chance.choice(("200", "203")), "-L", "8")
        wait_for(lambda: control.ask("status")["mode"] == "DEGRADED")
        self.done["losses"] += 1
        self.start_governing(control)

    def error_frames(self, control):
        number = self.chance.randrange(1, 200)
        for _ in range(number):
            self.governor.send(can.Message(is_error_frame=True, is_extended_id=False, arbitration_id=0x88,
                                           data=bytes([0, 0, 4, 10, 0, 0, 0, 0])))
        self.done["error frames"] += number

    def corrupted(self, control):
        for _ in range(self.chance.randrange(1, 4)):
            frame = self.governor.frames.frame(99.0)
            frame.data[self.chance.randrange(4)] ^= 1 << self.chance.randrange(8)
            self.governor.send(frame)
            self.done["corrupted"] += 1

    def repeated(self, control):
        self.governor.send(self.governor.frames.frame(99.0, self.governor.frames.count - 1))
        self.done["repeated"] += 1

    def lost(self, control):
        self.governor.lose_one()
        self.done["lost"] += 1

    # What befalls the adapter; the governor on the other bus is followed all the time.

    def adapter_bus_off(self, control):
        self.adapter.set_state("bus-off", 0, 255)
        self.done["bus-offs"] += 1
        wait_for(lambda: state_of(control, 1) == "bus-off")
        wait_for(lambda: state_of(control, 1) == "error-active")

    def adapter_pulled_out(self, control):
        self.adapter.pull_out()
        wait_for(lambda: state_of(control, 1) == "gone")
        gone_tick = control.ask("status")["tick"]
        self.adapter = SerialInterface()
        wait_for(lambda: any(line.startswith("t200") for line in self.adapter.lines))
        assert min(ticks_on_line(self.adapter)) > gone_tick - MOST_AGE_TICKS

    def adapter_stands_still(self, control):
        wait_for(lambda: not control.ask("status")["buses"][1]["faults"])  # what was before is over
        self.adapter.stop_reading()
        wait_for(lambda: control.ask("status")["buses"][1]["faults"] == ["transmit queue full"])
        full_tick = control.ask("status")["tick"]
        time.sleep(self.chance.uniform(0.5, 2.0))
        resume_tick = control.ask("status")["tick"]
        self.adapter.go_on_reading()
        wait_for(lambda: ticks_on_line(self.adapter)[-1] > resume_tick + 2000)
        old = [tick for tick in ticks_on_line(self.adapter) if full_tick < tick < resume_tick - MOST_AGE_TICKS]
        assert not old, f"frames of ticks {old} after tick {resume_tick}"

    DISTURBANCES = (nothing, governor_vanishes, interface_removed, foreign_flood, flood_with_our_ids, error_frames,
                    corrupted, repeated, lost, adapter_bus_off, adapter_pulled_out, adapter_stands_still)


def state_of(control, bus):
    return control.ask("status")["buses"][bus]["state"]


def flood(*arguments):
    """As fast as the kernel takes them; @return how many"""
    frames = 5000
    subprocess.run(["cangen", "vcan9", "-g", "0", "-n", str(frames), "-i", *arguments], check=True, timeout=600)
    return frames


def differences(done, frames, result):
    """What the emulator's counters say otherwise."""
    vcan, adapter = result.buses
    is_ = {"commands": frames["commands"], "corrupted": frames["corrupted"], "repeated": frames["repeated"],
           "lost": frames["lost"], "flood": result.count["with our ids"] + vcan["receive overflows"],
           "error frames": vcan["error frames"], "losses": result.log.count(" from tick "),
           "bus-offs": result.log.count("bus-off, was "), "late ticks": result.late_ticks,
           "reordered, jumped or stuck": frames["reordered"] + frames["jumped"] + frames["stuck"]}
    expected = {**dict.fromkeys(is_, 0), **done}
    expected["losses"] = 2 * done["losses"]  # the log: each loss; running before each of them
    return [f"{name}: {is_[name]}, done {expected[name]}" for name in is_ if is_[name] != expected[name]]


def soak(seconds, seed):
    """Rounds of all disturbances, each in an order of its own, for at least this long."""
    bench = Bench(random.Random(seed))
    times = collections.Counter()
    with contextlib.ExitStack() as ending, tempfile.TemporaryDirectory() as folder:
        socket = Path(folder) / "control"
        emulator = ending.enter_context(Emulator(
            ["socketcan:vcan9", f"socketcan:{bench.adapter.name}"], "--rt", "off", "--control", socket, *PROTECTED,
            *ADAPTER, lives_s=seconds + 600.0))
        control = ending.enter_context(Control(socket))
        ending.callback(bench.end)
        begin_s = told_s = time.monotonic()
        bench.start_governing(control)
        while times.total() == 0 or time.monotonic() - begin_s < seconds:
            for disturbance in bench.chance.sample(bench.DISTURBANCES, len(bench.DISTURBANCES)):
                disturbance(bench, control)
                times[disturbance.__name__] += 1
                time.sleep(bench.chance.uniform(0.1, 2.0))
                bench.look(control, disturbance.__name__)
            if time.monotonic() - told_s > 600.0:
                told_s += 600.0
                print(f"{(time.monotonic() - begin_s) / 60:.0f} min, {times.total()} disturbances", flush=True)
        bench.governor.pause()
        time.sleep(2 * LOST_AFTER_S)
        bench.done["commands"] = bench.governor.sent
        bench.done["losses"] += 1
        frames = control.ask("status")["safety"]["frames"]
        result = emulator.stop()
    print("\n".join(f"{number:6} x {name.replace('_', ' ')}" for name, number in sorted(times.items())))
    print(f"{result.ticks / 36e6:.2f} h simulated; {result.text.rstrip()}")
    wrong = differences(bench.done, frames, result)
    assert result.status == OK and not wrong, "; ".join(wrong) or result.text
    print("every counter is what was done: " + ", ".join(f"{n} {name}" for name, n in sorted(bench.done.items())))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=1.0, help="of the bus' time; default 1")
    parser.add_argument("--seed", type=int, default=1, help="of the disturbances; default 1")
    arguments = parser.parse_args()
    if not IN_GUEST:
        parser.error("it makes and removes interfaces: tools/vcan-guest --timeout 0 -- tests/e2e/bus_soak.py")
    try:
        soak(arguments.hours * 3600.0, arguments.seed)
    except AssertionError as error:
        sys.exit(f"bus_soak: {error}")


if __name__ == "__main__":
    main()

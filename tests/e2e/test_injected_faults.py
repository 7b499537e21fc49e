"""Faults of bus, sensors and emulator as a client on the bus sees them. In lockstep: what a fault makes of a frame does
not depend on the machine, and the frames of an unfaulted run are what they are compared with."""

import math

import h5py
import pytest

from control_socket import Control
from emulator import NOT_VALID, OK, Client, Emulator
from scripted_governor import LOCKSTEP, REST_P1_PSI, TICKS

STEPS = 40
STEP_MS = TICKS // 10
ON_ITS_WAY = 6  # after so many steps everything late has come
POSITION = "SERVO_Position"


class Bench:
    """A lockstep run; SERVO_Status, which no fault here hits, ends each answer."""

    def __init__(self, url, path):
        self.emulator = Emulator([url], *LOCKSTEP, "--control", path)
        self.client = Client(self.emulator.urls[0])
        self.control = Control(path)
        self.count = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.control.close()
        self.client.__exit__()
        self.emulator.__exit__()

    def step(self):
        """One command; all frames of its answer. P1 is another one each time."""
        self.client.send_p1(REST_P1_PSI + 0.1 * (self.count % 7))
        self.count += 1
        return self.client.until(lambda f: f.name == "SERVO_Status")

    def positions(self, steps=STEPS):
        """SERVO_Position frames of each step."""
        return [[f for f in self.step() if f.name == POSITION] for _ in range(steps)]


@pytest.fixture
def bench(url, tmp_path):
    with Bench(url, tmp_path / "control.sock") as bench:
        yield bench


@pytest.fixture(scope="module")
def unfaulted(url, tmp_path_factory):
    """The one position frame of each step, as bytes, by its tick."""
    with Bench(url, tmp_path_factory.mktemp("unfaulted") / "control.sock") as bench:
        steps = bench.positions(2 * STEPS + ON_ITS_WAY + 1)
        return {(n + 1) * TICKS: bytes(frames[0].raw.data) for n, frames in enumerate(steps)}


def ticks(frames):
    return [int(f["Tick"]) for f in frames]


def flat(steps):
    return [f for frames in steps for f in frames]


def own(unfaulted, frames):
    """Each of them is what an unfaulted run says at its tick."""
    for frame in frames:
        assert bytes(frame.raw.data) == unfaulted[int(frame["Tick"])]


# --- What is sent ----------------------------------------------------------------------------------------------------

def silent(steps, unfaulted):
    assert flat(steps) == []


def lost(steps, unfaulted):
    """Of n frames n p come, within 4 sqrt(n p (1 - p))."""
    frames = flat(steps)
    own(unfaulted, frames)
    assert abs(len(frames) - 0.5 * STEPS) <= 4 * math.sqrt(0.25 * STEPS)
    assert ticks(frames) == sorted(set(ticks(frames)))


def delayed(steps, unfaulted):
    """By 50 ms: five steps."""
    own(unfaulted, flat(steps))
    first = STEPS + 1
    assert [ticks(f) for f in steps] == [[(first + n - 5) * TICKS] if n >= 5 else [] for n in range(STEPS)]


def jittered(steps, unfaulted):
    """By up to 30 ms: one to three steps, not all alike."""
    own(unfaulted, flat(steps))
    late = [(STEPS + 1 + n) - t // TICKS for n, frames in enumerate(steps) for t in ticks(frames)]
    assert set(late) == {1, 2, 3}


def duplicated(steps, unfaulted):
    own(unfaulted, flat(steps))
    assert [ticks(f) for f in steps] == [[(STEPS + 1 + n) * TICKS] * 2 for n in range(STEPS)]


def reordered(steps, unfaulted):
    """Each first one after the second."""
    own(unfaulted, flat(steps))
    assert ticks(flat(steps)) == [(STEPS + 1 + n + (1 if n % 2 == 0 else -1)) * TICKS for n in range(STEPS)]


def flipped(steps, unfaulted):
    """Two bits of each, not always the same ones."""
    differences = set()
    for n, frames in enumerate(steps):
        said, true = (int.from_bytes(d, "big") for d in (frames[0].raw.data, unfaulted[(STEPS + 1 + n) * TICKS]))
        assert len(frames) == 1 and bin(said ^ true).count("1") == 2
        differences.add(said ^ true)
    assert len(differences) > STEPS / 2


@pytest.mark.parametrize("fault, parameters, seen", [
    ("tx_silent", {}, silent),
    ("tx_lost", {"probability": 0.5, "seed": 3}, lost),
    ("tx_delayed", {"delay_ms": 5 * STEP_MS}, delayed),
    ("tx_jittered", {"most_ms": 3 * STEP_MS}, jittered),
    ("tx_duplicated", {}, duplicated),
    ("tx_reordered", {"probability": 1.0}, reordered),
    ("bits_flipped", {"bits": 2}, flipped),
])
def test_published_frames(bench, unfaulted, fault, parameters, seen):
    before = bench.positions()
    assert [ticks(f) for f in before] == [[(n + 1) * TICKS] for n in range(STEPS)]
    assert bench.control.inject(fault, message=POSITION, **parameters) == STEPS * TICKS + 1
    seen(bench.positions(), unfaulted)
    bench.control.clear(fault)
    bench.positions(ON_ITS_WAY)
    [(last,)] = bench.positions(1)
    assert int(last["Tick"]) == (2 * STEPS + ON_ITS_WAY + 1) * TICKS
    own(unfaulted, [last])


def test_the_same_seed_gives_the_same_run(url, tmp_path):
    def run(name, seed):
        with Bench(url, tmp_path / name) as bench:
            bench.control.inject("tx_lost", message=POSITION, seed=seed)
            return [ticks(f) for f in bench.positions()]

    assert run("a", 5) == run("b", 5) != run("c", 6)


def test_babbling(bench):
    """1,000 a second: ten in each step."""
    bench.step()
    bench.control.inject("babbling", id=7, rate_hz=1000)
    steps = [bench.step() for _ in range(STEPS)]
    bench.control.clear()
    frames = [f.raw for f in [*flat(steps), *bench.step(), *bench.step()] if f.name is None]
    assert {(f.arbitration_id, bytes(f.data)) for f in frames} == {(7, bytes(8))}
    assert abs(len(frames) - 10 * STEPS) <= 10


def test_counter_and_checksum_need_protection(bench):
    for fault, what in (("counter_stuck", "counter"), ("checksum_wrong", "checksum")):
        answer = bench.control.ask("inject", fault=fault)
        assert (answer["result"], answer["reason"]) == (
            "UNSUPPORTED", f"{fault}: no published message has a {what}: set e2e in [[can.publish]]")


@pytest.mark.only("slcan")
def test_serial_adapters_have_no_error_frames(bench):
    answer = bench.control.ask("inject", fault="error_frames")
    assert answer["result"] == "UNSUPPORTED" and "slcan" in answer["reason"]


@pytest.mark.only("socketcan")
def test_error_frames(bench):
    bench.step()
    bench.control.inject("error_frames", rate_hz=100)
    frames = [f.raw for f in flat([bench.step() for _ in range(STEPS)]) if f.raw.is_error_frame]
    assert abs(len(frames) - STEPS) <= 1, "one in each step"


# --- What arrives ----------------------------------------------------------------------------------------------------

def p1(frames):
    return next(f["P1_Applied"] for f in frames if f.name == "SERVO_Pressures")


def test_lost_commands_do_nothing(bench):
    before = p1(bench.step())
    bench.control.inject("rx_lost", probability=1.0)
    assert {p1(bench.step()) for _ in range(10)} == {before}
    bench.control.clear()
    assert p1(bench.step()) != before


def test_delayed_commands_act_later(bench):
    """By 30 ms: that of three steps ago."""
    sent = [p1(bench.step()) for _ in range(7)]
    bench.control.inject("rx_delayed", delay_ms=3 * STEP_MS)
    assert [p1(bench.step()) for _ in range(17)] == [sent[6]] * 3 + [sent[n % 7] for n in range(14)]


def test_interface_down(bench):
    """As if unplugged: commands are not answered, the status says why; then all is as before."""
    bench.step()
    bench.control.inject("interface_down")
    for _ in range(3):
        bench.client.send_p1(REST_P1_PSI)
    while bench.control.ask("status")["tick"] < 4 * TICKS:
        pass
    status = bench.control.ask("status")
    assert status["interface_down"] is True
    assert [f for f in bench.client.frames_so_far() if f.name == POSITION] == []
    bench.control.clear("interface_down")
    assert ticks(f for f in bench.step() if f.name == POSITION) == [5 * TICKS]
    assert bench.control.ask("status")["interface_down"] is False


def test_a_frame_starts_a_fault(bench):
    bench.step()
    bench.control.inject("hot_oil", when_frame=0x100, for_s=0.01)
    [one] = bench.control.ask("faults")["faults"]
    assert one["waits"] is True and one["trigger"] == "frame 0x100"
    assert next(f["ActiveFaults"] for f in bench.step() if f.name == "SERVO_Status") == 1
    bench.step()
    assert bench.control.ask("faults")["faults"] == []


# --- Sensors ---------------------------------------------------------------------------------------------------------

def test_sensors(bench, unfaulted):
    """A frozen position and an open wire at P3: the truth goes on."""
    bench.positions()
    bench.control.inject("sensor_frozen", signal="x3")
    bench.control.inject("sensor_open_wire", signal="p3_psi")
    frozen = [bench.step() for _ in range(STEPS)]
    said = {f["X3"] for f in flat(frozen) if f.name == POSITION}
    assert len(said) == 1
    assert {bytes(f.raw.data[2:4]) for f in flat(frozen) if f.name == "SERVO_Pressures"} == {b"\xff\xff"}
    assert abs(bench.control.ask("status")["x3_in"] - said.pop()) > 0.01
    bench.control.clear()
    bench.step()
    own(unfaulted, flat(bench.positions(1)))


# --- The emulator ----------------------------------------------------------------------------------------------------

def test_missed_ticks(url, tmp_path, bench):
    """In real time a bench notices; in lockstep there is nothing to miss."""
    assert bench.control.ask("inject", fault="missed_ticks")["result"] == "UNSUPPORTED"
    path = tmp_path / "real.sock"
    with Emulator(["slcan:pty"], "--control", path) as emulator, Control(path) as control:
        control.inject("missed_ticks", ms=60)
        while control.ask("status")["worst_lateness_ms"] < 50:
            pass
        assert control.ask("status")["timing_valid"] is False
        result = emulator.stop(may_be_late=True)
        assert result.status == NOT_VALID and "fault missed_ticks starts at tick" in result.log


# --- Log and recording -----------------------------------------------------------------------------------------------

def test_log_and_recording_tell_each_start_and_end(start, connect, tmp_path):
    path = tmp_path / "control.sock"
    emulator = start(*LOCKSTEP, "--control", path, "--record", tmp_path / "run")
    client = connect(emulator)
    with Control(path) as control:
        control.inject("sensor_offset", signal="x3", by=0.5, at_s=0.02, for_s=0.03)
        for _ in range(10):
            client.send_p1(REST_P1_PSI)
            client.until(lambda f: f.name == "SERVO_Status")
    result = emulator.stop()
    assert result.status == OK
    for text in ("sensor_offset of x3_in waits from tick 1 ", "sensor_offset of x3_in starts at tick 201 ",
                 "sensor_offset of x3_in ends at tick 501 "):
        assert text in result.log
    with h5py.File(tmp_path / "run" / "servohil.h5", swmr=True) as file:
        events = file["fault_events"]
        assert list(events["tick"]) == [1, 201, 501] and list(events["kind"]) == [0, 1, 2]
        said = dict(zip(file["published/SERVO_Position/tick"], file["published/SERVO_Position/X3"]))
        truth = dict(zip(file["samples/tick"], file["samples/x3_in"]))
        for tick, x3 in said.items():
            assert x3 - truth[tick] == pytest.approx(0.5 if 201 <= tick <= 500 else 0.0, abs=2e-4)

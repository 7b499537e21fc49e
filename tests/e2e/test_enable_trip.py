"""The governor's enable and trip signals, seen from the bus: what each does, at once, to P1 and to what is published,
and how the command is followed again. Enable is beside P1, trip in a message of its own."""

import re

import can
import pytest
from control_socket import Control
from emulator import DBC, DEGRADED, RUNNING, TRIPPED, WAITING, run, settings
from recordings import Recording

SYNC_ID, COMMAND_ID, MODE_ID = 0x80, 0x120, 0x121
TICKS = 100  # per sync frame: the governor's cycle of 10 ms
REST_P1_PSI = 30.263
RECOVER_AFTER = 3  # the default
TRIP_FACTOR = (1 + 1e-4 / 0.05) ** -TICKS  # of P1 in a cycle: implicit Euler with safety.trip_time_constant_s
RUNS, LOST, TRIPS = 1, 2, 3  # signal SafetyState
NOT_ENABLED, TRIP, RECOVERED = 5, 6, 7  # signal SafetyCause

GOVERNOR_DBC = f"""BO_ {COMMAND_ID} TGC_Demand: 4 TGC
 SG_ P1 : 7|20@0+ (0.001,0) [0|300] "psi" VDU
 SG_ Release : 24|2@1+ (1,0) [0|3] "" VDU
BO_ {MODE_ID} TGC_Mode: 2 TGC
 SG_ State : 8|4@1+ (1,0) [0|15] "" VDU
VAL_ {COMMAND_ID} Release 0 "Blocked" 1 "Released" ;
VAL_ {MODE_ID} State 1 "Loaded" 4 "Tripped" ;
"""


@pytest.fixture
def arguments(tmp_path):
    governor = tmp_path / "tgc.dbc"
    governor.write_text(GOVERNOR_DBC)
    return settings(can__dbc=f'["{governor}", "{DBC}"]', can__command__p1="TGC_Demand.P1",
                    can__command__enable="TGC_Demand.Release = Released",
                    can__command__trip="TGC_Mode.State = Tripped")


def demand(p1_psi=REST_P1_PSI, enabled=True):
    return can.Message(arbitration_id=COMMAND_ID, is_extended_id=False,
                       data=(round(p1_psi / 0.001) << 4).to_bytes(3, "big") + bytes([int(enabled)]))


def mode_frame(tripped):
    return can.Message(arbitration_id=MODE_ID, is_extended_id=False, data=[0, 4 if tripped else 1])


class Governor:
    """In lockstep: some frames, then the sync frame and its answer."""

    def __init__(self, client):
        self.client = client

    def cycle(self, *frames):
        """@return state, cause, P1 [psi], x3 [in]"""
        self.client.send(*frames, can.Message(arbitration_id=SYNC_ID, is_extended_id=False, data=b""))
        answer = {frame.name: frame for frame in self.client.until(lambda f: f.name == "SERVO_Status")}
        self.mode, safety = answer["SERVO_Status"]["Mode"], answer["SERVO_Safety"]
        self.p1_psi, self.x3_in = answer["SERVO_Pressures"]["P1_Applied"], answer["SERVO_Position"]["X3"]
        return safety["SafetyState"], safety["SafetyCause"], self.p1_psi


@pytest.fixture
def begin(start, connect, arguments):
    def begin_one(*more):
        emulator = start("--clock", "lockstep", *settings(lockstep__sync_id=SYNC_ID, lockstep__ticks=TICKS), *arguments,
                         *more)
        governor = Governor(connect(emulator))
        governor.emulator = emulator
        return governor

    return begin_one


def test_what_is_not_enabled_does_not_begin(begin):
    governor = begin()
    for _ in range(5):
        governor.cycle(demand(35.0, enabled=False))
        assert governor.mode == WAITING and governor.p1_psi == pytest.approx(REST_P1_PSI, abs=0.01)
    governor.cycle(demand(35.0))
    assert governor.mode == RUNNING and governor.p1_psi == pytest.approx(35.0, abs=0.005)


@pytest.mark.parametrize("on_loss", ["drain", "hold", "freeze"])
def test_not_enabled_is_a_loss_at_once(begin, on_loss):
    """Its demand, valid as it is, is not followed; recovery takes as many enabled frames in a row as after a silence."""
    governor = begin(*settings(safety__on_loss=on_loss))
    for _ in range(4):
        governor.cycle(demand(32.0))
    assert governor.mode == RUNNING
    p1_psi, x3_in = governor.p1_psi, governor.x3_in
    for cycle in range(1, 6):
        assert governor.cycle(demand(40.0, enabled=False))[:2] == (LOST, NOT_ENABLED)
        assert governor.mode == DEGRADED
        # safety.drain_time_constant_s is 0.5 s
        expected_psi = p1_psi * (1 + 1e-4 / 0.5) ** (-TICKS * cycle) if on_loss == "drain" else p1_psi
        assert governor.p1_psi == pytest.approx(expected_psi, abs=0.01)
    if on_loss == "freeze":
        assert governor.x3_in == x3_in
    states = [governor.cycle(demand(32.5))[:2] for _ in range(RECOVER_AFTER)]
    assert states == [(LOST, NOT_ENABLED), (LOST, NOT_ENABLED), (RUNS, RECOVERED)]
    assert governor.p1_psi == pytest.approx(32.5, abs=0.005)


def test_enabled_for_less_than_it_takes_is_not_enabled(begin):
    governor = begin()
    governor.cycle(demand())
    governor.cycle(demand(enabled=False))
    for _ in range(3):
        for _ in range(RECOVER_AFTER - 1):
            governor.cycle(demand())
        assert governor.cycle(demand(enabled=False))[0] == LOST
    for _ in range(RECOVER_AFTER):
        governor.cycle(demand())
    assert governor.mode == RUNNING


def test_a_trip_drains_at_once_whatever_is_demanded(begin):
    governor = begin()
    for _ in range(3):
        governor.cycle(demand())
    p1_psi = governor.p1_psi
    for cycle in range(1, 6):  # the governor goes on demanding, with a trip, then without repeating it
        frames = [mode_frame(tripped=True)] if cycle < 3 else []
        assert governor.cycle(*frames, demand(60.0))[:2] == (TRIPS, TRIP)
        assert governor.mode == TRIPPED
        assert governor.p1_psi == pytest.approx(p1_psi * TRIP_FACTOR**cycle, abs=0.01)
    assert governor.cycle(mode_frame(tripped=False))[0] == TRIPS
    states = [governor.cycle(demand())[0] for _ in range(RECOVER_AFTER)]
    assert states == [TRIPS, TRIPS, RUNS] and governor.mode == RUNNING


def test_one_trip_frame_is_enough_even_when_taken_back_before_a_tick(begin):
    governor = begin()
    governor.cycle(demand())
    assert governor.cycle(mode_frame(tripped=True), mode_frame(tripped=False), demand(60.0))[:2] == (TRIPS, TRIP)


def test_disabled_and_enabled_again_before_a_tick_is_a_loss(begin):
    governor = begin()
    governor.cycle(demand())
    assert governor.cycle(demand(enabled=False), demand())[:2] == (LOST, NOT_ENABLED)


def test_a_trip_before_the_first_command_drains_too(begin):
    governor = begin()
    assert governor.cycle(mode_frame(tripped=True))[:2] == (TRIPS, TRIP)
    assert governor.p1_psi == pytest.approx(REST_P1_PSI * TRIP_FACTOR, abs=0.01)


def test_a_trip_while_not_enabled_trips(begin):
    governor = begin()
    governor.cycle(demand())
    governor.cycle(demand(enabled=False))
    assert governor.cycle(mode_frame(tripped=True), demand(enabled=False))[:2] == (TRIPS, TRIP)
    governor.cycle(mode_frame(tripped=False))
    for _ in range(5):
        assert governor.cycle(demand(enabled=False))[0] == TRIPS
    for _ in range(RECOVER_AFTER):
        governor.cycle(demand())
    assert governor.mode == RUNNING


def test_a_mode_frame_that_is_too_short_says_nothing(begin, tmp_path):
    path = tmp_path / "control.sock"
    governor = begin("--control", path)
    governor.cycle(demand())
    short = can.Message(arbitration_id=MODE_ID, is_extended_id=False, data=[4])
    assert governor.cycle(short, demand())[0] == RUNS
    governor.client.close()
    assert governor.emulator.stop().count["malformed"] == 1


def test_enable_in_another_message_is_off_until_that_has_come(begin):
    governor = begin(*settings(can__command__enable="TGC_Mode.State = Loaded", can__command__trip=""))
    for _ in range(3):
        governor.cycle(demand(35.0))
        assert governor.mode == WAITING
    governor.cycle(mode_frame(tripped=False))
    assert governor.mode == WAITING, "enabled, but nothing newly demanded"
    governor.cycle(demand(35.0))
    assert governor.mode == RUNNING


def changes(log):
    return re.findall(r"command: (\w+) from tick \d+ on, (\w+) before: ([^;\n]*)", log)


ALL_CHANGES = [("running", "waiting", "first command"), ("degraded", "running", "not enabled"),
               ("running", "degraded", "valid commands again"), ("tripped", "running", "trip"),
               ("running", "tripped", "valid commands again")]


def test_in_lockstep_it_is_logged_recorded_and_replayed(begin, tmp_path):
    governor = begin("--record", tmp_path / "run")
    eventful_run(lambda *frames: governor.cycle(*frames)[:2])
    governor.client.close()
    result = governor.emulator.stop()
    assert changes(result.log) == ALL_CHANGES
    assert "identical: " in run("replay", tmp_path / "run").stdout


def test_in_real_time_it_is_logged_recorded_and_replayed(start, connect, arguments, tmp_path):
    """The same governor, which waits for SERVO_Safety to tell: nothing is said of when."""
    emulator = start("--rt", "off", "--record", tmp_path / "run", "--control", tmp_path / "sock", *arguments,
                     *settings(publish__safety_ms=10))
    client = connect(emulator)

    def cycle(*frames):
        client.send(*frames)
        client.newest("SERVO_Safety")
        safety = client.newest("SERVO_Safety")  # of after the frames were sent
        return safety["SafetyState"], safety["SafetyCause"]

    eventful_run(cycle)
    with Control(tmp_path / "sock") as control:
        status = control.ask("status")
    assert (status["mode"], status["safety"]["trips"], status["safety"]["losses"]) == ("RUNNING", 1, 1)
    client.close()
    result = emulator.stop()
    assert changes(result.log) == ALL_CHANGES
    assert "identical: " in run("replay", tmp_path / "run").stdout
    assert set(Recording(tmp_path / "run").published["SERVO_Safety"]["SafetyState"]) >= {RUNS, LOST, TRIPS}


def eventful_run(cycle):
    """Until the emulator tells what is expected: in lockstep that is at once."""

    def until(expected, frames):
        for _ in range(1000):
            if cycle(*frames) == expected:
                return
        raise AssertionError(f"never {expected}")

    until((RUNS, 1), [demand(31.0)])
    until((LOST, NOT_ENABLED), [demand(40.0, enabled=False)])
    until((RUNS, RECOVERED), [demand(31.5)])
    until((TRIPS, TRIP), [mode_frame(tripped=True), demand(50.0)])
    for _ in range(5):
        assert cycle(demand(50.0)) == (TRIPS, TRIP)
    until((RUNS, RECOVERED), [mode_frame(tripped=False), demand(30.0)])

"""Protected commands and their supervision, seen from the bus: a python-can governor that does wrong what governors do
wrong. In lockstep with a sync frame, so that each count and each change has its tick."""

import re

import can
import pytest
from control_socket import Control
from e2e_profiles import crc8_autosar, crc8_j1850
from emulator import DEGRADED, REPOSITORY, RUNNING, WAITING, let_time_pass, settings
from recordings import Recording
from thread_pause import paused

SYNC_ID = 0x80
TICKS = 100  # per sync frame: the governor's cycle of 10 ms
REST_P1_PSI = 30.263
TRAP_P1_PSI = 99.0  # of frames that must not be followed
PROTECTED = ("--clock", "lockstep",
             *settings(lockstep__sync_id=SYNC_ID, lockstep__ticks=TICKS, safety__timeout_ms=-1,
                       can__command__e2e="crc8_j1850", can__command__counter="Counter",
                       can__command__checksum="Checksum", can__command__max_counter_jump=2))


class Governor:
    """Each cycle: some frames, then the sync frame and its answer."""

    def __init__(self, client):
        self.client = client
        self.count = 0

    def frame(self, p1_psi=REST_P1_PSI, count=None):
        raw = round(p1_psi / 0.001)
        counter = (self.count if count is None else count) % 16
        body = [counter | (raw & 0xF) << 4, raw >> 4 & 0xFF, raw >> 12 & 0xFF]
        return can.Message(arbitration_id=0x100, is_extended_id=False, data=[crc8_j1850(bytes(body)), *body])

    def cycle(self, *frames):
        """@return the answer, by message"""
        self.client.send(*frames, can.Message(arbitration_id=SYNC_ID, is_extended_id=False, data=b""))
        return {frame.name: frame for frame in self.client.until(lambda f: f.name == "SERVO_Status")}

    def good(self, p1_psi=REST_P1_PSI):
        answer = self.cycle(self.frame(p1_psi))
        self.count += 1
        return answer


def mode(answer):
    return answer["SERVO_Status"]["Mode"]


@pytest.fixture
def governor(start, connect, tmp_path):
    emulator = start("--control", tmp_path / "control", *PROTECTED)
    governor = Governor(connect(emulator))
    governor.emulator, governor.control = emulator, tmp_path / "control"
    return governor


def frames_of(governor):
    with Control(governor.control) as control:
        return control.ask("status")["safety"]["frames"]


def test_each_kind_of_wrong_frame_is_counted_as_what_it_is(governor):
    assert mode(governor.cycle()) == WAITING
    for _ in range(20):  # once round
        assert mode(governor.good()) == RUNNING
    sent = governor.count  # the newest has the counter sent - 1
    corrupted = governor.frame(99.0)
    corrupted.data[2] ^= 0x40
    governor.cycle(corrupted, governor.frame())
    governor.count += 1
    governor.cycle(governor.frame(99.0, sent), governor.frame())  # repeated, then the next
    governor.count += 1
    governor.cycle(governor.frame(99.0, governor.count - 3), governor.frame())  # late
    governor.count += 1
    for _ in range(2):
        governor.cycle(governor.frame(99.0, governor.count - 1))  # stands still: repeated twice
    governor.cycle(governor.frame(99.0, governor.count - 1), governor.frame(count=governor.count))  # stuck
    governor.count += 2  # one lost, tolerated
    governor.good()
    governor.count += 4  # four lost: not valid, but the next one is
    jumped = governor.good(99.0)
    assert jumped["SERVO_Pressures"]["P1_Applied"] == pytest.approx(REST_P1_PSI, abs=0.005)
    answer = governor.good()
    assert mode(answer) == RUNNING, "no silence of three cycles in all this"
    assert answer["SERVO_Pressures"]["P1_Applied"] == pytest.approx(REST_P1_PSI, abs=0.005), "none of them was followed"
    frames = frames_of(governor)
    assert frames == {"commands": 20 + 3 + 1 + 2, "corrupted": 1, "repeated": 3, "stuck": 1, "reordered": 1, "jumped": 1,
                      "lost": 1 + 4, "malformed": 0, "out_of_range": 0, "stale": 0, "too_fast": 0, "not_available": 0,
                      "error_indicator": 0}
    safety = answer["SERVO_Safety"]
    assert [safety[name] for name in ("SafetyState", "RejectedFrames", "CorruptedFrames", "FramesOutOfSequence",
                                      "LostFrames", "CommandLosses")] == [1, 7, 1, 6, 5, 0]


def test_silence_drains_and_three_good_frames_recover(governor):
    for _ in range(5):
        governor.good()
    modes = [mode(governor.cycle()) for _ in range(5)]
    # The newest frame is used at the first tick of its cycle: 300 ticks later it is lost.
    assert modes == [RUNNING, RUNNING, DEGRADED, DEGRADED, DEGRADED]
    drained = governor.cycle()
    assert drained["SERVO_Pressures"]["P1_Applied"] < REST_P1_PSI - 1.0
    assert (drained["SERVO_Safety"]["SafetyState"], drained["SERVO_Safety"]["SafetyCause"]) == (2, 3)
    recovering = [governor.good(35.0) for _ in range(3)]
    assert [mode(answer) for answer in recovering] == [DEGRADED, DEGRADED, RUNNING]
    assert [answer["SERVO_Pressures"]["P1_Applied"] > 34.0 for answer in recovering] == [False, False, True]
    assert recovering[-1]["SERVO_Safety"]["SafetyCause"] == 7
    governor.client.close()
    log = governor.emulator.stop().log
    told = re.findall(r"command: (\w+) from tick (\d+) on, (\w+) before: ([^;\n]*)", log)
    lost = "no command frame for 30 ms (three cycles of 10 ms: the default)"
    assert told == [("running", "1", "waiting", "first command"), ("degraded", "701", "running", lost),
                    ("running", "1301", "degraded", "valid commands again")]


def test_invalid_frames_do_not_keep_it_running(governor):
    governor.good()
    bad = governor.frame()
    bad.data[0] ^= 1
    answers = [governor.cycle(bad) for _ in range(3)]
    assert [mode(answer) for answer in answers] == [RUNNING, RUNNING, DEGRADED]
    assert answers[-1]["SERVO_Safety"]["SafetyCause"] == 4
    answer = governor.cycle(governor.frame(), bad, governor.frame(count=2), governor.frame(count=3))
    assert mode(answer) == DEGRADED, "three good frames, but not in a row"


def protected_answers(start, connect, tmp_path, *arguments):
    """An emulator that publishes SERVO_Position with AUTOSAR profile 11; what comes back of it, step by step."""
    dbc = tmp_path / "bench.dbc"
    dbc.write_text('BO_ 256 GOV_Command: 8 G\n SG_ P1_Demand : 16|20@1+ (0.001,0) [0|300] "psi" S\n'
                   'BO_ 512 SERVO_Position: 8 S\n SG_ CRC : 0|8@1+ (1,0) [0|255] "" G\n'
                   ' SG_ Count : 8|4@1+ (1,0) [0|14] "" G\n SG_ Tick : 32|32@1+ (1,0) [0|4294967295] "" G\n')
    configuration = tmp_path / "bench.toml"
    configuration.write_text('[load]\nfile = "%s"\n[can]\ndbc = ["%s"]\n[[can.publish]]\nmessage = "SERVO_Position"\n'
                             'cycle_ms = 10\ne2e = "autosar_p11"\ndata_id = 291\ncounter = "Count"\nchecksum = "CRC"\n'
                             % (REPOSITORY / "config" / "load_curve.csv", dbc))
    emulator = start("-c", configuration, "--clock", "lockstep", *settings(lockstep__sync_id=SYNC_ID), *arguments)
    client = connect(emulator)
    while True:
        client.send(can.Message(arbitration_id=SYNC_ID, is_extended_id=False, data=b""))
        yield bytes(client.bus.recv(20.0).data)


def p11_checksum(data):
    """Data ID 0x0123, low byte first."""
    return crc8_autosar(bytes([0x23, 0x01]) + data[1:])


def test_protected_frames_come_back(start, connect, tmp_path):
    counters = []
    for data, _ in zip(protected_answers(start, connect, tmp_path), range(20)):
        assert data[0] == p11_checksum(data)
        counters.append(data[1] & 0xF)
    assert counters == [i % 15 for i in range(20)]


def test_faults_of_the_protection_are_seen(start, connect, tmp_path):
    """A lost frame leaves a gap, a stuck counter has a right checksum, a wrong checksum a right counter."""
    path = tmp_path / "control.sock"
    answers = protected_answers(start, connect, tmp_path, "--control", path)
    assert next(answers)[1] & 0xF == 0
    with Control(path) as control:
        control.inject("counter_stuck", for_s=0.05)
        stuck = [next(answers) for _ in range(5)]
        assert [d[1] & 0xF for d in stuck] == [0] * 5 and all(d[0] == p11_checksum(d) for d in stuck)
        assert next(answers)[1] & 0xF == 1
        control.inject("checksum_wrong", for_s=0.05)
        wrong = [next(answers) for _ in range(5)]
        assert [d[1] & 0xF for d in wrong] == [2, 3, 4, 5, 6]
        assert all(d[0] == p11_checksum(d) ^ 0xFF for d in wrong)
        right = next(answers)
        assert right[0] == p11_checksum(right) and right[1] & 0xF == 7


@pytest.mark.only("socketcan")
@pytest.mark.parametrize("what", ["its receiver", "all of it"])
def test_what_came_during_an_outage_is_not_replayed(start, connect, tmp_path, what):
    """In real time, with the kernel's receive stamps: 20 frames wait in the socket for 20 ms and longer, one is fresh."""
    emulator = start("--rt", "off", "--record", tmp_path / "run", "--control", tmp_path / "sock",
                     *settings(safety__max_age_ms=20, can__command__e2e="crc8_j1850", can__command__counter="Counter",
                               can__command__checksum="Checksum"))
    client = connect(emulator)
    governor = Governor(client)
    client.send(governor.frame(31.0))
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    with paused(emulator.process_id, "can_rx") if what == "its receiver" else emulator.stopped():
        for governor.count in range(1, 21):
            client.send(governor.frame(TRAP_P1_PSI))
        let_time_pass(0.1)
        governor.count += 1
        client.send(governor.frame(32.0))
    client.newest("SERVO_Pressures", lambda f: f["P1_Applied"] > 31.9)
    with Control(tmp_path / "sock") as control:
        frames = control.ask("status")["safety"]["frames"]
    assert {name: count for name, count in frames.items() if count} == {"commands": 2, "stale": 20}
    result = emulator.stop(may_be_late=True)
    assert "command frames refused: 20 stale" in result.log
    applied = Recording(tmp_path / "run").samples["p1_psi"]
    assert applied[-1] == pytest.approx(32.0, abs=0.001) and max(applied) == applied[-1], "none of them was followed"


@pytest.mark.only("socketcan")
def test_a_governor_that_is_not_there_is_told_once(start, connect):
    """With another identifier, which the kernel's filter holds back. Virtual time: five seconds cost nothing."""
    emulator = start("--rt", "off")
    client = connect(emulator)
    while client.newest("SERVO_Position")["Tick"] < 60000:
        client.send(can.Message(arbitration_id=0x99, is_extended_id=False, data=bytes(4)))
    log = emulator.stop().log
    assert log.count("no GOV_Command (0x100) so far: does the governor send it with this identifier?") == 1

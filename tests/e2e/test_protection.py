"""Every end-to-end protection over a bus, in both directions, against e2e_profiles.py: what is right is followed and
comes back right, and each kind of wrong frame is counted as what it is. In lockstep with a sync frame."""

import json
import re
from dataclasses import dataclass, replace

import can
import pytest
from control_socket import Control
from e2e_profiles import Profile, crc8_autosar, crc8_j1850
from emulator import DBC, RUNNING, Client, run, settings

SYNC_ID = 0x80
REST_P1_PSI = 30.0
TRAP_P1_PSI = 99.0  # in frames that must not be followed
COMMAND, ANSWER = 0x0CF00421, 0x0CF00533  # 29 bits
MOST_JUMP = 2
P1_FACTOR, X3_FACTOR = 0.005, 0.0002


@dataclass(frozen=True)
class Case:
    """What `can.command` and `[[can.publish]]` are given, and the same for this side."""

    label: str
    profile: Profile
    bytes: int = 8
    extended: bool = False
    fd: bool = False
    where: str = "big"  # names of counter and checksum are given and lie elsewhere; "": where the profile has them
    answer_id: int = 0x0BEE
    on_change: bool = False  # VDU_Out carries the mode

    @property
    def ids(self):
        return (COMMAND, ANSWER) if self.extended else (0x120, 0x220)

    def mirrored(self):
        """The protection of what comes back: another Data ID, to be told apart."""
        return self.profile if self.profile.data_id is None else replace(self.profile, data_id=self.answer_id)


def autosar(name, mode, **more):
    return Profile(name, 15, 0x123, mode, **more)


CASES = [
    Case("p1_both", autosar("autosar_p1", "both"), where=""),
    Case("p1_alt", autosar("autosar_p1", "alt"), where=""),
    Case("p1_low", autosar("autosar_p1", "low"), where=""),
    Case("p1_nibble", autosar("autosar_p1", "nibble"), where=""),
    Case("p11_both", autosar("autosar_p11", "both"), where=""),
    Case("p11_nibble_elsewhere", autosar("autosar_p11", "nibble", counter=(6, 4), checksum=(5, 0))),
    Case("p1_alt_extended", autosar("autosar_p1", "alt", counter=(7, 0), checksum=(6, 0)), extended=True),
    Case("j1850_id", Profile("crc8_j1850", 16, 0x123, counter=(6, 4), checksum=(7, 0))),
    Case("j1939", Profile("j1939_counter_checksum", 8, counter=(7, 0), checksum=(7, 4)), extended=True, where=""),
    Case("j1939_elsewhere", Profile("j1939_counter_checksum", 8, counter=(5, 4), checksum=(5, 0)), extended=True),
]
FD_CASES = [
    Case("fd_p11", autosar("autosar_p11", "both", counter=(62, 0), checksum=(63, 0)), bytes=64, fd=True),
    Case("fd_j1850_extended", Profile("crc8_j1850", 16, counter=(62, 4), checksum=(63, 0)), bytes=64, fd=True, extended=True),
    Case("fd_p1_nibble", autosar("autosar_p1", "nibble"), bytes=32, fd=True, where=""),
]


def dbc_of(case):
    """P1 and x3 in bytes 2 and 3, Motorola; so are counter and checksum where they have names."""
    def named(place, bits, name):
        return f' SG_ {name} : {place[0] * 8 + place[1] + bits - 1}|{bits}@0+ (1,0) [0|0] "" X\n'

    checksum_bits = 4 if case.profile.name.startswith("j1939") else 8
    protection = "" if not case.where else (named(case.profile.counter, 4, "Alive")
                                            + named(case.profile.checksum, checksum_bits, "Crc"))
    text = ""
    for can_id, name, signal in ((case.ids[0], "TGC_Out", f'P1 : 23|16@0+ ({P1_FACTOR},0) [0|300] "psi"'),
                                 (case.ids[1], "VDU_Out", f'X3 : 23|16@0+ ({X3_FACTOR},-1) [0|0] "in"')):
        text += f"BO_ {can_id | case.extended << 31} {name}: {case.bytes} X\n SG_ {signal} X\n{protection}\n"
    if not case.fd:
        return text
    names = ",".join(f'"{name}"' for name in ["StandardCAN", "ExtendedCAN", *["reserved"] * 12, "StandardCAN_FD",
                                              "ExtendedCAN_FD"])
    text += f'BA_DEF_ BO_ "VFrameFormat" ENUM {names};\nBA_DEF_ BO_ "CANFD_BRS" ENUM "0","1";\n'
    for can_id in case.ids:
        text += f'BA_ "VFrameFormat" BO_ {can_id | case.extended << 31} {14 + case.extended};\n'
        text += f'BA_ "CANFD_BRS" BO_ {can_id | case.extended << 31} 1;\n'
    return text


def keys_of(case, profile):
    keys = {"e2e": profile.name, "data_id_mode": profile.mode}
    if profile.data_id is not None:
        keys["data_id"] = profile.data_id
    if case.where:
        keys |= {"counter": "Alive", "checksum": "Crc"}
    return keys


def toml(value):
    return f'"{value}"' if isinstance(value, str) else str(value)


class Governor:
    def __init__(self, client, case):
        self.client, self.case = client, case
        self.count = 0

    def frame(self, p1_psi=REST_P1_PSI, count=None):
        case = self.case
        data = bytearray(range(1, case.bytes + 1))  # what is in no signal counts all the same
        data[2:4] = round(p1_psi / P1_FACTOR).to_bytes(2, "big")
        count = (self.count if count is None else count) % case.profile.round
        return can.Message(arbitration_id=case.ids[0], is_extended_id=case.extended, is_fd=case.fd, bitrate_switch=case.fd,
                           data=case.profile.protect(case.ids[0], count, data))

    def next(self, p1_psi=REST_P1_PSI):
        frame = self.frame(p1_psi)
        self.count += 1
        return frame

    def answer(self, *frames):
        """@return the frames VDU_Out, SERVO_Status"""
        self.client.send(*frames, can.Message(arbitration_id=SYNC_ID, is_extended_id=False, data=b""))
        answer = self.client.until(lambda f: f.name == "SERVO_Status")
        return [f.raw for f in answer if f.raw.arbitration_id == self.case.ids[1]], answer[-1]

    def cycle(self, *frames):
        [out], status = self.answer(*frames)
        return out, status


def configured(case, directory):
    """Arguments of the program."""
    dbc = directory / "protected.dbc"
    dbc.write_text(dbc_of(case))
    published = keys_of(case, case.mirrored()) | {"message": "VDU_Out", "cycle_ms": 10}
    keys = ", ".join(f"{k} = {toml(v)}" for k, v in published.items())
    signal = '"x3_in"'
    if case.on_change:
        keys += ", on_change = true"
        signal = '{ quantity = "mode", scale = [[0.0, 0.0], [1.0, 1.0]] }'
    publish = f'[{{{keys}, signals = {{ X3 = {signal} }}}}, {{message = "SERVO_Status", cycle_ms = 10}}]'
    return settings(lockstep__sync_id=SYNC_ID, can__dbc=f'["{dbc}", "{DBC}"]', can__command__p1="TGC_Out.P1",
                    can__command__max_counter_jump=MOST_JUMP, can__publish=publish, safety__timeout_ms=-1,
                    **{f"can__command__{k}": v for k, v in keys_of(case, case.profile).items()})


@pytest.fixture
def governor_of(start, tmp_path):
    clients = []

    def begin(case, *more):
        emulator = start("--clock", "lockstep", "--control", tmp_path / "sock", *more, *configured(case, tmp_path))
        client = Client(emulator.urls[0], fd=case.fd)
        clients.append(client)
        governor = Governor(client, case)
        governor.emulator, governor.control = emulator, tmp_path / "sock"
        return governor

    yield begin
    for client in clients:
        client.__exit__()


def frames_of(governor):
    with Control(governor.control) as control:
        return control.ask("status")["safety"]["frames"]


def p1_of(governor):
    with Control(governor.control) as control:
        return control.ask("status")["p1_psi"]


def test_the_other_implementation_has_the_published_values():
    """CRC-8 by Greg Cook's catalogue; profiles 1 and 11 by the examples of AUTOSAR's specification (Data ID 0x123, data
    0, counters 0 and 1); J1939's by hand: 0x47C folds to 4."""
    assert crc8_j1850(b"123456789") == 0x4B and crc8_autosar(b"") == 0
    published = {"both": ("cc00", "9101"), "alt": ("ce00", "0201"), "low": ("ce00", "9301"), "nibble": ("2a10", "7711")}
    for mode, starts in published.items():
        for count, head in enumerate(starts):
            assert autosar("autosar_p1", mode).protect(0, count, bytes(8)).hex() == head + 6 * "00", (mode, count)
    shifted = autosar("autosar_p11", "nibble", counter=(9, 0), checksum=(8, 0))
    assert shifted.protect(0, 0, bytes(16))[8:10].hex() == "7d10"
    tsc1 = Profile("j1939_counter_checksum", 8, counter=(7, 0), checksum=(7, 4))
    assert tsc1.protect(0x0C000011, 3, bytes.fromhex("01401fffffffff00"))[7] == 0x43


def check_both_directions(governor):
    """Two rounds; then each single wrong bit; then the wrong order of frames. Nothing of it is followed."""
    case, theirs = governor.case, governor.case.mirrored()
    for cycle in range(2 * case.profile.round):
        out, status = governor.cycle(governor.next(31.0))
        assert status["Mode"] == RUNNING
        assert (out.is_fd, out.bitrate_switch, len(out.data)) == (case.fd, case.fd, case.bytes)
        assert bytes(out.data) == theirs.protect(case.ids[1], cycle % theirs.round, out.data)
        assert int.from_bytes(out.data[2:4], "big") * X3_FACTOR - 1 == pytest.approx(4.0, abs=1.0)
    sent = governor.count
    assert p1_of(governor) == pytest.approx(31.0, abs=P1_FACTOR)

    bits = range(8 * case.bytes)
    for first in bits[::64]:
        wrong = []
        for bit in bits[first:first + 64]:
            frame = governor.frame(TRAP_P1_PSI)
            frame.data[bit // 8] ^= 1 << bit % 8
            wrong.append(frame)
        governor.cycle(*wrong, governor.next())
    sent += len(bits[::64])

    order = [governor.frame(TRAP_P1_PSI, governor.count - 1)] * 3  # repeated, repeated, stuck
    order += [governor.frame(TRAP_P1_PSI, governor.count - 3)]     # reordered
    governor.count += 1                                            # one lost: tolerated
    order += [governor.next()]
    governor.count += MOST_JUMP                                    # one more than that: not valid
    order += [governor.next(TRAP_P1_PSI), governor.next()]
    _, status = governor.cycle(*order)
    assert status["Mode"] == RUNNING and p1_of(governor) == pytest.approx(REST_P1_PSI, abs=P1_FACTOR)
    counts = {"commands": sent + 2, "corrupted": len(bits), "repeated": 2, "stuck": 1, "reordered": 1, "jumped": 1,
              "lost": 1 + MOST_JUMP, "malformed": 0, "out_of_range": 0, "stale": 0, "too_fast": 0, "not_available": 0,
              "error_indicator": 0}
    assert frames_of(governor) == counts
    return counts


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
def test_protection_in_both_directions(governor_of, case):
    check_both_directions(governor_of(case))


@pytest.mark.only("socketcan")
@pytest.mark.parametrize("case", FD_CASES, ids=lambda case: case.label)
def test_protection_of_can_fd_frames(governor_of, case):
    """With bit-rate switch, up to 64 bytes; a serial adapter (slcan) has no CAN FD."""
    check_both_directions(governor_of(case))


def test_status_log_and_summary_tell_them_apart(governor_of):
    governor = governor_of(CASES[0])
    counts = check_both_directions(governor)
    shown = run("status", "--control", governor.control).stdout
    assert re.search(r"^frames +\d+ valid, 64 corrupted, 1 jumped, 3 lost, 1 reordered, 2 repeated,\n +1 stuck$", shown,
                     re.M), shown
    governor.client.close()
    result = governor.emulator.stop()
    told = re.findall(r"(\d+) (corrupted|repeated|stuck|reordered|jumped|never came)", "".join(
        line for line in result.log.splitlines(keepends=True) if "command frames" in line))
    sums = {}
    for count, name in told:
        sums[name] = sums.get(name, 0) + int(count)
    assert sums == {"corrupted": 64, "repeated": 2, "stuck": 1, "reordered": 1, "jumped": 1, "never came": 3}, result.log
    assert result.count["commands"] == counts["commands"]


@pytest.mark.parametrize("wrong", [{"data_id": 0x124}, {"mode": "low"}, {"name": "autosar_p11", "mode": "nibble"}],
                         ids=["data id", "mode", "profile"])
def test_another_protection_than_the_governors_is_none_of_its_frames(governor_of, wrong):
    """Not one counts, nothing moves, and the log asks what is to be looked at."""
    governor = governor_of(CASES[0])
    governor.case = replace(governor.case, profile=replace(governor.case.profile, **wrong))
    for _ in range(20):
        _, status = governor.cycle(governor.next(40.0))
        assert status["Mode"] == 0
    frames = frames_of(governor)
    assert (frames["commands"], frames["corrupted"]) == (0, 20)
    governor.client.close()
    assert "corrupted; do can.command.e2e, data_id, data_id_mode, counter and checksum fit" in governor.emulator.stop().log



def test_on_change_the_counter_counts_what_is_sent(governor_of):
    """WAITING, RUNNING, DEGRADED, RUNNING are four frames, none missing by their counter."""
    case = replace(CASES[0], on_change=True)
    governor = governor_of(case)
    sent = []
    for demanded in [False] * 4 + [True] * 5 + [False] * 6 + [True] * 5:
        frames, _ = governor.answer(*([governor.next()] if demanded else []))
        sent += [bytes(frame.data) for frame in frames]
    assert [round(int.from_bytes(data[2:4], "big") * X3_FACTOR - 1) for data in sent] == [0, 1, 5, 1]
    assert [data[1] & 0xF for data in sent] == [0, 1, 2, 3]
    assert all(data == case.mirrored().protect(case.ids[1], count, data) for count, data in enumerate(sent))


def test_the_protection_is_shown_and_a_log_is_judged_by_it(tmp_path):
    case = next(case for case in CASES if case.label == "p1_alt_extended")
    arguments = configured(case, tmp_path)
    shown = run("dbc", *arguments).stdout
    for line in (r"    e2e autosar_p1, Data ID 0x123 alt: counter 0 to 14 in bits 56 to 59, checksum in bits 48 to 55",
                 r"    e2e autosar_p1, Data ID 0xBEE alt: counter 0 to 14 in bits 56 to 59, checksum in bits 48 to 55"):
        assert len(re.findall(f"^{line}$", shown, re.M)) == 1, shown
    assert len(re.findall(r"^    Alive .* counter of e2e$", shown, re.M)) == 2
    assert len(re.findall(r"^    Crc .* checksum of e2e$", shown, re.M)) == 2
    log = tmp_path / "bus.log"
    governor = Governor(None, case)
    right, wrong = bytes(governor.frame(31.0, 3).data), bytearray(governor.frame(31.0, 4).data)
    wrong[0] ^= 1
    answer = case.mirrored().protect(case.ids[1], 5, bytes(8))
    damaged = answer[:-1] + bytes([answer[-1] ^ 0x80])
    log.write_text("".join(f"({i}.000000) can0 {can_id:08X}#{data.hex()}\n" for i, (can_id, data) in enumerate(
        [(case.ids[0], right), (case.ids[0], wrong), (case.ids[1], answer), (case.ids[1], damaged)])))
    objects = [json.loads(line) for line in run("dbc", *arguments, "--decode", log, "--json").stdout.splitlines()]
    assert [(o.get("refused"), o.get("p1_psi")) for o in objects] == [
        (None, pytest.approx(31.0)), ("corrupted", None), (None, None), ("corrupted", None)]
    for message, data_id in zip(("received", "sent"), (0x123, 0xBEE)):
        protection = json.loads(run("dbc", *arguments, "--json").stdout)[message][0]["protection"]
        assert protection == {"e2e": "autosar_p1", "counter_maximum": 14, "data_id": data_id, "data_id_mode": "alt"}
    lines = run("dbc", *arguments, "--decode", log).stdout.splitlines()
    assert [line.partition("  => ")[2] for line in lines[:4]] == [
        "P1 31 psi", "wrong counter or checksum: not a command", "x3_in -1", "wrong counter or checksum, x3_in -1"]

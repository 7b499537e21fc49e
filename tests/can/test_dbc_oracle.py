"""Reader and codec against python3-canmatrix, an independent implementation.

The program `dbc_probe` answers for ours. Data: our own DBC, two foreign ones (tests/data/dbc: big and
little endian, signed, odd lengths, extended ids, CAN FD, Latin-1 with CR LF), and random layouts with IEEE 754
numbers, multiplexers and CAN FD as well.
"""

import functools
import json
import logging
import math
import os
import struct
import subprocess
import tempfile
from fractions import Fraction
from pathlib import Path

import canmatrix.formats
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

ROOT = Path(__file__).resolve().parents[2]
PROBE = Path(os.environ.get("SERVOHIL_BUILD", ROOT / "build" / "release")) / "bin" / "dbc_probe"
FILES = [ROOT / "config" / "servohil.dbc",
         ROOT / "tests" / "data" / "dbc" / "turbine_bench.dbc",
         ROOT / "tests" / "data" / "dbc" / "oelstand_latin1_crlf.dbc"]
INDEPENDENT = "VECTOR__INDEPENDENT_SIG_MSG"
# Physical values are doubles here and decimals there: a product and a sum, each rounded once.
RELATIVE = 4 * 2.0**-52
# Doubles resolve a step of raw values up to here.
LARGEST_EXACT_RAW = 2**50

logging.getLogger("canmatrix").setLevel(logging.ERROR)
runs = settings(max_examples=500, deadline=None, derandomize=True,
                suppress_health_check=[HealthCheck.too_slow])


class Probe:
    """A dbc_probe that stays: its database, and one answer for each line."""

    def __init__(self, file):
        self.process = subprocess.Popen([PROBE, file], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        encoding="utf-8")
        self.messages = {m["name"]: m for m in json.loads(self.process.stdout.readline())}

    def ask(self, *words):
        self.process.stdin.write(" ".join(words) + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline().split()

    def raw_and_physical(self, message, signal, data):
        """None where the multiplexer selects others."""
        answer = self.ask("d", message, signal, data.hex())
        return None if answer == ["absent"] else (int(answer[0]), float(answer[1]))

    def insert(self, message, values, size):
        data = bytes(size).hex()
        for name, raw in values.items():
            data, = self.ask("r", message, name, str(raw), data)
        return bytes.fromhex(data)

    def encode(self, message, signal, physical, size):
        data, inside = self.ask("e", message, signal, repr(physical), bytes(size).hex())
        return bytes.fromhex(data), inside == "1"

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        assert self.process.wait() == 0


@functools.lru_cache(maxsize=None)
def opened(file):
    return Probe(file), canmatrix.formats.loadp_flat(str(file))


def frames_with_signals(matrix):
    return [f for f in matrix.frames if f.name != INDEPENDENT and f.signals]


def float_format(signal):
    return {32: ">f", 64: ">d"}[signal.size]


def bits_of(signal, value):
    """What canmatrix calls the raw value, as the integer that the bits are."""
    if not signal.is_float:
        return value
    bits = int.from_bytes(struct.pack(float_format(signal), value), "big")
    return bits - 2**signal.size if signal.is_signed and bits >= 2**(signal.size - 1) else bits


def compare_database(probe, matrix):
    frames = [f for f in matrix.frames if f.name != INDEPENDENT]
    assert sorted(probe.messages) == sorted(f.name for f in frames)
    for frame in frames:
        ours = probe.messages[frame.name]
        assert ours["id"] == frame.arbitration_id.id
        assert ours["extended"] == frame.arbitration_id.extended
        assert ours["size_bytes"] == frame.size
        assert ours["fd"] == (frame.is_fd or frame.size > 8)
        assert ours["bit_rate_switch"] == (ours["fd"] and frame.attribute("CANFD_BRS", matrix) == "1")
        assert ours["cycle_ms"] == int(frame.attribute("GenMsgCycleTime", matrix, default=0))
        assert ours["sender"] in frame.transmitters or not frame.transmitters
        assert ours["comment"] == (frame.comment or "")
        assert [s["name"] for s in ours["signals"]] == [s.name for s in frame.signals]
        for mine, theirs in zip(ours["signals"], frame.signals):
            compare_signal(mine, theirs)


def compare_signal(mine, theirs):
    assert mine["start_bit"] == theirs.get_startbit(bit_numbering=1)
    assert mine["length_bits"] == theirs.size
    assert mine["little_endian"] == theirs.is_little_endian
    assert mine["is_signed"] == theirs.is_signed
    assert mine["factor"] == float(theirs.factor)
    assert mine["offset"] == float(theirs.offset)
    assert mine["minimum"] == float(theirs.min)
    assert mine["maximum"] == float(theirs.max)
    assert mine["unit"] == (theirs.unit or "")
    assert mine["comment"] == (theirs.comment or "")
    assert mine["values"] == {str(k): v for k, v in theirs.values.items()}
    assert mine["is_float"] == theirs.is_float
    assert mine["multiplexing"] == (1 if theirs.is_multiplexer else 0 if theirs.mux_val is None else 2)
    assert mine["selected_by"] == (theirs.mux_val or 0)


def raw_values(signal):
    if signal.is_float:
        return st.floats(width=signal.size, allow_nan=False, allow_infinity=False)
    low = -2**(signal.size - 1) if signal.is_signed else 0
    high = 2**(signal.size - 1) - 1 if signal.is_signed else 2**signal.size - 1
    return st.one_of(st.integers(low, high), st.sampled_from([low, high, max(low, -1), min(high, 1), 0]))


def draw_values(choice, frame):
    """Raw values of what one frame can carry together."""
    selector = next((s for s in frame.signals if s.is_multiplexer), None)
    selected = None
    if selector is not None:
        selected = choice.draw(st.sampled_from(sorted({s.mux_val for s in frame.signals} - {None}) or [0]))
    values = {s.name: choice.draw(raw_values(s), s.name) for s in frame.signals
              if not s.is_multiplexer and s.mux_val in (None, selected)}
    return values if selector is None else {selector.name: selected, **values}


def physical(signal, raw):
    return Fraction(raw) * Fraction(signal.factor) + Fraction(signal.offset)


def compare_decoding(probe, frame, data):
    there = frame.decode(data)
    for signal in frame.signals:
        ours = probe.raw_and_physical(frame.name, signal.name, data)
        assert (ours is None) == (signal.name not in there), (signal.name, data.hex())
        if ours is None:
            continue
        raw, value = ours
        theirs = float(there[signal.name].raw_value) if signal.is_float else there[signal.name].raw_value
        if signal.is_float and not math.isfinite(theirs):
            assert math.isnan(value) if math.isnan(theirs) else math.isinf(value)
            continue
        bits = raw if signal.is_signed or not signal.is_float else raw % 2**signal.size
        assert bits == bits_of(signal, theirs), (signal.name, data.hex())
        exact = physical(signal, theirs)
        largest = max(abs(exact), abs(Fraction(theirs) * Fraction(signal.factor)))
        if largest < 2**1023:
            assert abs(Fraction(value) - exact) <= Fraction(RELATIVE) * largest + Fraction(2)**-1074


def compare_encoding(probe, frame, values):
    theirs = bytes(frame.encode(values))
    bits = {s.name: bits_of(s, values[s.name]) for s in frame.signals if s.name in values}
    assert probe.insert(frame.name, bits, frame.size) == theirs, values
    for signal in frame.signals:
        if signal.name not in values:
            continue
        raw = values[signal.name]
        if signal.is_float:
            compare_float_encoding(probe, frame, signal, raw)
            continue
        if abs(raw) > LARGEST_EXACT_RAW:
            continue
        exact = physical(signal, raw)
        stated = signal.min != 0 or signal.max != 0
        inside = not stated or Fraction(signal.min) <= exact <= Fraction(signal.max)
        ours, unsaturated = probe.encode(frame.name, signal.name, float(exact), frame.size)
        assert unsaturated == inside, (signal.name, raw)
        if inside:
            assert ours == probe.insert(frame.name, {signal.name: raw}, frame.size), (signal.name, raw)


def compare_float_encoding(probe, frame, signal, raw):
    """Factor 1 and offset 0: the very bits. Else a round trip, once rounded there and once back."""
    if signal.factor == 1 and signal.offset == 0:
        ours, unsaturated = probe.encode(frame.name, signal.name, raw, frame.size)
        assert unsaturated and ours == probe.insert(frame.name, {signal.name: bits_of(signal, raw)}, frame.size)
    elif abs(raw) < 1e30:
        wanted = float(physical(signal, raw))
        ours, unsaturated = probe.encode(frame.name, signal.name, wanted, frame.size)
        back = probe.raw_and_physical(frame.name, signal.name, ours)
        if back is not None:
            step = 2.0**-23 if signal.size == 32 else RELATIVE
            assert unsaturated
            assert abs(back[1] - wanted) <= step * (abs(wanted) + abs(float(signal.offset))) + 1e-37


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.name)
def test_reads_the_same(file):
    compare_database(*opened(file))


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.name)
@runs
@given(choice=st.data())
def test_decodes_any_data_alike(file, choice):
    probe, matrix = opened(file)
    frame = choice.draw(st.sampled_from(frames_with_signals(matrix)), "frame")
    compare_decoding(probe, frame, choice.draw(st.binary(min_size=frame.size, max_size=frame.size), "data"))


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.name)
@runs
@given(choice=st.data())
def test_encodes_any_values_alike(file, choice):
    probe, matrix = opened(file)
    frame = choice.draw(st.sampled_from(frames_with_signals(matrix)), "frame")
    compare_encoding(probe, frame, draw_values(choice, frame))


def taken(first, length, little):
    """The bits of a signal, and its start bit. `first` counts from the most significant bit of byte 0 for big
    endian, from the least significant one for little endian."""
    bits = set(range(first, first + length))
    if little:
        return bits, first
    return {b // 8 * 8 + 7 - b % 8 for b in bits}, first // 8 * 8 + 7 - first % 8


@st.composite
def signals(draw, size, number):
    """One signal anywhere: its bits, and how it is written (%s: its multiplexing)."""
    little = draw(st.booleans())
    kind = draw(st.sampled_from([0, 0, 1, 2]))
    length = {0: draw(st.integers(1, min(64, 8 * size))), 1: 32, 2: 64}[kind]
    if length > 8 * size:
        kind, length = 0, 8 * size
    bits, start = taken(draw(st.integers(0, 8 * size - length)), length, little)
    sign = draw(st.sampled_from("+-"))
    factor = draw(st.sampled_from(["1", "0.5", "-0.25", "0.001", "1E-005", "12.5", "3"]))
    offset = draw(st.sampled_from(["0", "-40", "273.15", "1E+3"]))
    text = f' SG_ S{number} %s: {start}|{length}@{int(little)}{sign} ({factor},{offset}) [0|0] "u{number}" B'
    return bits, kind, text


ATTRIBUTES = """BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","StandardCAN_FD","ExtendedCAN_FD";
BA_DEF_ BO_ "CANFD_BRS" ENUM "0","1";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_DEF_DEF_ "CANFD_BRS" "1";
BA_DEF_DEF_ "GenMsgCycleTime" 0;
"""


@st.composite
def layouts(draw):
    """A message of any size, its signals side by side with gaps between them, all of them always there or some
    selected by a multiplexer (then those of different values may lie on one another)."""
    size = draw(st.sampled_from([1, 2, 3, 5, 7, 8, 12, 48, 64]))
    always, lines, types = set(), [], []
    if draw(st.booleans()) and size > 1:
        selector = draw(st.integers(0, 8 * size - 3))
        always = set(range(selector, selector + 3))
        lines.append(f' SG_ Page M : {selector}|3@1+ (1,0) [0|7] "" B')
    groups = {value: set() for value in range(4)}
    multiplexed = bool(lines)
    for number in range(draw(st.integers(1, 8))):
        bits, kind, text = draw(signals(size, number))
        value = draw(st.sampled_from([None, 0, 1, 3])) if multiplexed else None
        others = set().union(always, *groups.values()) if value is None else always | groups[value]
        if bits & others:
            continue
        (always if value is None else groups[value]).update(bits)
        lines.append(text % ("" if value is None else f"m{value} "))
        if kind:
            types.append(f"S{number} : {kind};")
    extended = draw(st.booleans())
    number = draw(st.integers(0, 2**29 - 1)) | 2**31 if extended else draw(st.integers(0, 2**11 - 1))
    text = f'VERSION ""\n\nBU_: A B\n\nBO_ {number} Random: {size} A\n' + "\n".join(lines) + "\n\n" + ATTRIBUTES
    text += f'BA_ "GenMsgCycleTime" BO_ {number} {draw(st.integers(0, 5000))};\n'
    if draw(st.booleans()):
        text += f'BA_ "VFrameFormat" BO_ {number} {3 if extended else 2};\n'
        text += f'BA_ "CANFD_BRS" BO_ {number} {draw(st.integers(0, 1))};\n'
    return text + "".join(f"SIG_VALTYPE_ {number} {line}\n" for line in types)


@runs
@given(text=layouts(), choice=st.data())
def test_random_layouts(text, choice):
    with tempfile.NamedTemporaryFile("w", suffix=".dbc") as file:
        file.write(text)
        file.flush()
        probe, matrix = Probe(file.name), canmatrix.formats.loadp_flat(file.name)
    compare_database(probe, matrix)
    for frame in frames_with_signals(matrix):
        compare_decoding(probe, frame, choice.draw(st.binary(min_size=frame.size, max_size=frame.size), "data"))
        compare_encoding(probe, frame, draw_values(choice, frame))
    probe.close()

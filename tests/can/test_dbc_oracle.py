"""Reader and codec against python3-canmatrix, an independent implementation.

The program `dbc_probe` answers for ours. Data: our own DBC, two foreign ones (tests/data/dbc: big and
little endian, signed, odd lengths, extended ids, CAN FD, Latin-1 with CR LF), and random layouts.
"""

import functools
import json
import logging
import os
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
        raw, physical = self.ask("d", message, signal, data.hex())
        return int(raw), float(physical)

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


def plain_frames(matrix):
    """Those that both may use: no multiplexing."""
    return [f for f in matrix.frames
            if f.name != INDEPENDENT and f.signals and all(s.multiplex is None for s in f.signals)]


def compare_database(probe, matrix):
    frames = [f for f in matrix.frames if f.name != INDEPENDENT]
    assert sorted(probe.messages) == sorted(f.name for f in frames)
    for frame in frames:
        ours = probe.messages[frame.name]
        assert ours["id"] == frame.arbitration_id.id
        assert ours["extended"] == frame.arbitration_id.extended
        assert ours["size_bytes"] == frame.size
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
    assert mine["multiplexed"] == (theirs.multiplex is not None)


def raw_values(signal):
    low = -2**(signal.size - 1) if signal.is_signed else 0
    high = 2**(signal.size - 1) - 1 if signal.is_signed else 2**signal.size - 1
    return st.one_of(st.integers(low, high), st.sampled_from([low, high, max(low, -1), min(high, 1), 0]))


def physical(signal, raw):
    return Fraction(raw) * Fraction(signal.factor) + Fraction(signal.offset)


def compare_decoding(probe, frame, data):
    for name, theirs in frame.decode(data).items():
        raw, value = probe.raw_and_physical(frame.name, name, data)
        assert raw == theirs.raw_value, (name, data.hex())
        exact = physical(theirs.signal, raw)
        largest = max(abs(exact), abs(Fraction(raw) * Fraction(theirs.signal.factor)))
        assert abs(Fraction(value) - exact) <= Fraction(RELATIVE) * largest, (name, data.hex())


def compare_encoding(probe, frame, values):
    theirs = bytes(frame.encode(values))
    assert probe.insert(frame.name, values, frame.size) == theirs, values
    for signal in frame.signals:
        raw = values[signal.name]
        if abs(raw) > LARGEST_EXACT_RAW:
            continue
        exact = physical(signal, raw)
        stated = signal.min != 0 or signal.max != 0
        inside = not stated or Fraction(signal.min) <= exact <= Fraction(signal.max)
        ours, unsaturated = probe.encode(frame.name, signal.name, float(exact), frame.size)
        assert unsaturated == inside, (signal.name, raw)
        if inside:
            assert ours == probe.insert(frame.name, {signal.name: raw}, frame.size), (signal.name, raw)


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.name)
def test_reads_the_same(file):
    compare_database(*opened(file))


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.name)
@runs
@given(choice=st.data())
def test_decodes_any_data_alike(file, choice):
    probe, matrix = opened(file)
    frame = choice.draw(st.sampled_from(plain_frames(matrix)), "frame")
    compare_decoding(probe, frame, choice.draw(st.binary(min_size=frame.size, max_size=frame.size), "data"))


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.name)
@runs
@given(choice=st.data())
def test_encodes_any_values_alike(file, choice):
    probe, matrix = opened(file)
    frame = choice.draw(st.sampled_from(plain_frames(matrix)), "frame")
    values = {s.name: choice.draw(raw_values(s), s.name) for s in frame.signals}
    compare_encoding(probe, frame, values)


@st.composite
def layouts(draw):
    """A message of any size with signals side by side, gaps between them; positions are counted from the most
    significant bit of byte 0 for big endian, from the least significant one for little endian."""
    size = draw(st.sampled_from([1, 2, 3, 5, 7, 8, 12, 48, 64]))
    free = set(range(8 * size))
    lines = []
    for i in range(draw(st.integers(1, 8))):
        little = draw(st.booleans())
        length = draw(st.integers(1, min(64, 8 * size)))
        first = draw(st.integers(0, 8 * size - length))
        bits = set(range(first, first + length))
        if not little:
            bits = {b // 8 * 8 + 7 - b % 8 for b in bits}
            first = first // 8 * 8 + 7 - first % 8
        if bits <= free:
            free -= bits
            sign = draw(st.sampled_from("+-"))
            factor = draw(st.sampled_from(["1", "0.5", "-0.25", "0.001", "1E-005", "12.5", "3"]))
            offset = draw(st.sampled_from(["0", "-40", "273.15", "1E+3"]))
            lines.append(f' SG_ S{i} : {first}|{length}@{int(little)}{sign} ({factor},{offset}) [0|0] "u{i}" B')
    extended = draw(st.booleans())
    number = draw(st.integers(0, 2**29 - 1)) | 2**31 if extended else draw(st.integers(0, 2**11 - 1))
    return f'VERSION ""\n\nBU_: A B\n\nBO_ {number} Random: {size} A\n' + "\n".join(lines) + "\n\n"


@runs
@given(text=layouts(), choice=st.data())
def test_random_layouts(text, choice):
    with tempfile.NamedTemporaryFile("w", suffix=".dbc") as file:
        file.write(text)
        file.flush()
        probe, matrix = Probe(file.name), canmatrix.formats.loadp_flat(file.name)
    compare_database(probe, matrix)
    for frame in plain_frames(matrix):
        compare_decoding(probe, frame, choice.draw(st.binary(min_size=frame.size, max_size=frame.size), "data"))
        compare_encoding(probe, frame, {s.name: choice.draw(raw_values(s), s.name) for s in frame.signals})
    probe.close()

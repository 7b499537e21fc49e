"""`--record`: what is in servohil.h5 and bus.log is what happened, and whatever happens to run or disk, both can be
opened afterwards by those who do not know servohil: h5py and python-can."""

import csv
import os
import random
import re
import shutil
import signal
import subprocess

import h5py
import numpy
import pytest

from emulator import ENVIRONMENT, RUNNING, USAGE, Emulator, let_time_pass, run, settings, ticks_of
from recordings import FILE, LOG, Recording, as_tuple, is_subsequence, log_frames, same_bits
from thread_pause import paused

REST_P1_PSI = 30.263
SCRIPT = [(0.0, 30.6), (0.05, 29.0), (0.11, 34.0), (0.2, 30.0)]
MOVED = settings(friction__coulomb_psi=2, stabilizer__enabled="true", oil__air_fraction=0.005)


@pytest.fixture
def script(tmp_path):
    file = tmp_path / "script.csv"
    file.write_text("t_s,p1_psi\n" + "".join(f"{t},{p1}\n" for t, p1 in SCRIPT))
    return file


# --- What is in it ---------------------------------------------------------------------------------------------------

def test_the_columns_are_those_of_simulate(tmp_path, script):
    """To the last bit; and those of `run --clock fast`."""
    text = run("simulate", *MOVED, "--p1-file", script, "--duration", 0.3, "--record", tmp_path / "s", "-o", "-").stdout
    rows = list(csv.DictReader(text.splitlines()))[1:]  # the first one is the steady state, of no tick
    simulated = Recording(tmp_path / "s")
    assert list(simulated.ticks) == list(range(1, 3001)) and len(rows) == 3000
    for name in ("p1_psi", "x3_in", "v3_in_s", "p3_psi", "p4_psi", "p8_psi"):
        assert same_bits(simulated.samples[name], numpy.array([float(row[name]) for row in rows])), name
    stuck = simulated.samples["motion"] == 1
    assert simulated.samples["x3_in"].std() > 0.01 and stuck.any() and not stuck.all(), "else it shows nothing"

    run("run", "--clock", "fast", *MOVED, "--script", script, "--duration", 0.3, "--record", tmp_path / "f")
    fast = Recording(tmp_path / "f")
    repeatable = [name for name in simulated.samples if not re.search("late|mode|command", name)]
    assert len(repeatable) > 10
    for name in repeatable:
        assert same_bits(simulated.samples[name], fast.samples[name]), name


def test_every_nth_tick(tmp_path, script):
    fast = ("run", "--clock", "fast", *MOVED, "--script", script, "--duration", 0.3, "--record")
    run(*fast, tmp_path / "all")
    run(*fast, tmp_path / "some", "--record-every", 10)
    every, tenth = Recording(tmp_path / "all"), Recording(tmp_path / "some")
    assert list(tenth.ticks) == list(range(10, 3001, 10)) and tenth.attributes["every_ticks"] == 10
    for name, values in tenth.samples.items():
        assert same_bits(values, every.samples[name][9::10]), name
    assert len(tenth.influences["tick"]) == len(every.influences["tick"]) == len(SCRIPT)
    assert "identical: 300 samples to tick 3000" in run("replay", tmp_path / "some").stdout


def test_units_and_circumstances(tmp_path, start, connect):
    emulator = start("--record", tmp_path / "r", *settings(friction__coulomb_psi=1.25))
    client = connect(emulator)
    client.newest("SERVO_Status")
    result = emulator.stop()
    recording = Recording(tmp_path / "r")
    units = {"x3_in": "in", "v3_in_s": "in/s", "p3_psi": "psi", "p1_psi": "psi", "tick": "0.1 ms", "state_hash": ""}
    assert {name: recording.units[f"samples/{name}"] for name in units} == units
    for name, message in client.messages.items():
        for signal_ in message.signals if name.startswith("SERVO") else []:
            assert recording.units[f"published/{name}/{signal_.name}"] == (signal_.unit or "")
    a = recording.attributes
    assert "coulomb_psi = 1.25" in a["configuration"] and "BO_ 512 SERVO_Position" in a["dbc"]
    assert a["clock"] == "real time" and a["tick_s"] == 1e-4 and a["every_ticks"] == 1
    assert a["verdict"] == result.verdict and f"{a['final_state_hash']:016x}" == result.hash
    assert (a["complete"], a["problem"]) == (1, "") and len(recording.gaps["tick"]) == 0
    assert list(recording.ticks) == list(range(1, result.ticks + 1))
    assert recording.samples["woke_late_ticks"][-1] <= result.late_ticks


def published_frames(client, recording, name):
    """The rows of published/NAME as raw values of the signals, in the order of the DBC."""
    return list(zip(*(raw_values(client, name, s.name, recording.published[name][s.name])
                      for s in client.messages[name].signals)))


def raw_values(client, message, name, values):
    s = client.messages[message].signal_by_name(name)
    return [round((value - float(s.offset)) / float(s.factor)) for value in values]


def received_frames(client, frames, name):
    return [tuple(raw_values(client, name, s.name, [f[s.name]])[0] for s in client.messages[name].signals)
            for f in frames if f.name == name]


def test_published_is_what_came_over_the_bus(tmp_path, start, connect):
    """In lockstep, where nothing is dropped: all of it."""
    emulator = start("--clock", "lockstep", "--record", tmp_path / "r")
    client = connect(emulator)
    frames, sent = [], []
    for step in range(50):
        sent.append(client.command(REST_P1_PSI + 0.1 * (step % 7)))
        client.send(sent[-1])
        frames += client.until(lambda f: f.name == "SERVO_Status")
    emulator.signal(signal.SIGTERM)
    frames += client.until(lambda f: f.name == "SERVO_Status")  # STOPPED
    emulator.wait()
    recording = Recording(tmp_path / "r")
    names = set(recording.published)
    assert names == {"SERVO_Position", "SERVO_Pressures", "SERVO_Relay", "SERVO_Bus", "SERVO_Safety", "SERVO_Status"}
    for name in names:
        assert published_frames(client, recording, name) == received_frames(client, frames, name)
        assert len(recording.published[name]["tick"]) == 50 + (name == "SERVO_Status")
    assert list(recording.published["SERVO_Position"]["tick"]) == [100 * step for step in range(1, 51)]
    log = log_frames(tmp_path / "r")
    assert [f for f in log if f[0] == 0x100] == [as_tuple(f) for f in sent]
    assert [f for f in log if f[0] != 0x100] == [as_tuple(f.raw) for f in frames]


def test_recorded_in_real_time_is_what_came_over_the_bus(tmp_path, start, connect):
    """A bus that is full, or a client that has no time, loses frames; what has come is recorded, in its order."""
    emulator = start("--record", tmp_path / "r", *settings(publish__position_ms=1))
    client = connect(emulator)
    client.newest("SERVO_Position")
    frames, sent = [], []
    for number in range(20):
        sent.append(client.command(REST_P1_PSI + 0.2 * (number % 3)))
        client.send(sent[-1])
        frames += client.for_ticks(500)
    emulator.signal(signal.SIGTERM)
    frames += client.until_ended()
    result = emulator.wait()
    recording = Recording(tmp_path / "r")
    for name in recording.published:
        assert is_subsequence(received_frames(client, frames, name), published_frames(client, recording, name)), name
    log = log_frames(tmp_path / "r")
    assert is_subsequence([as_tuple(f.raw) for f in frames], log)
    assert [f for f in log if f[0] == 0x100] == [as_tuple(f) for f in sent]
    assert len(log) == result.count["published"] + 20 + 1 or len(log) == result.count["published"] + 20
    # What the model used: each command from one tick on, that of the samples.
    commands = recording.influences
    assert list(commands["kind"])[:2] == [6, 7] and set(commands["kind"][2:]) == {6}, "the first one changes the state"
    assert list(commands["tick"]) == sorted(commands["tick"])
    for tick, p1_psi in zip(commands["tick"][commands["kind"] == 6], commands["p1_psi"][commands["kind"] == 6]):
        assert recording.samples["p1_psi"][int(tick) - 1] == p1_psi
    # The wire's values are the truth's, rounded.
    position = recording.published["SERVO_Position"]
    truth = recording.samples["x3_in"][position["tick"].astype(int) - 1]
    assert numpy.abs(position["X3"] - truth).max() <= 0.0001 + 1e-9
    stamps = [float(t) for t in re.findall(r"^\(([\d.]+)\) pts/\d+ |^\(([\d.]+)\) vcan0 ",
                                           (tmp_path / "r" / LOG).read_text(), re.M) for t in t if t]
    assert stamps == sorted(stamps) and len(stamps) == len(log)


def test_growing_file_is_open_to_readers(tmp_path, start, connect):
    """Single writer, multiple readers: rows appear while the run goes on, and those that are there stay."""
    emulator = start("--record", tmp_path / "r")
    client = connect(emulator)
    client.send_p1(REST_P1_PSI + 0.5)
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    with h5py.File(tmp_path / "r" / FILE, "r", swmr=True) as file:
        tick, x3 = file["samples/tick"], file["samples/x3_in"]
        seen, values = [0], []
        while len(seen) < 4:
            client.for_ticks(500)
            tick.refresh()
            x3.refresh()
            if len(tick) > seen[-1]:
                seen.append(len(tick))
                values = x3[:min(seen[-1], len(x3))]
                assert list(tick[:seen[-1]]) == list(range(1, seen[-1] + 1))
    emulator.stop()
    assert same_bits(Recording(tmp_path / "r").samples["x3_in"][:len(values)], values)


# --- Places ----------------------------------------------------------------------------------------------------------

def mistake(*arguments, status):
    done = run("run", "--can", "slcan:pty", "--duration", 0.05, *arguments, status=status)
    lines = [line for line in done.stderr.splitlines() if not line.startswith("servohil: info: ")]
    assert len(lines) == 1 and lines[0].startswith("servohil: ") and done.stdout == "", done
    return lines[0]


def test_a_directory_takes_one_recording(tmp_path, script):
    there = tmp_path / "made" / "on" / "the" / "way"
    run("run", "--clock", "fast", "--script", script, "--duration", 0.1, "--record", there)
    before = {file.name: file.read_bytes() for file in there.iterdir()}
    assert before.keys() == {FILE, LOG}
    assert f"{there}: holds a recording already" in mistake("--record", there, status=USAGE)
    assert {file.name: file.read_bytes() for file in there.iterdir()} == before


def test_a_place_that_is_a_file(tmp_path):
    (tmp_path / "file").write_text("somebody's")
    assert str(tmp_path / "file") in mistake("--record", tmp_path / "file", status=ENVIRONMENT)


@pytest.fixture
def disk(tmp_path):
    """A small disk of its own: disk("size=8m") → where it is mounted"""
    mounted = []

    def mount(options):
        where = tmp_path / f"disk{len(mounted)}"
        where.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "servohil-test", where], capture_output=True,
                              text=True)
        if done.returncode != 0:
            pytest.fail(f"no tmpfs can be mounted here: run as root: {done.stderr}")
        mounted.append(where)
        return where

    yield mount
    for where in mounted:
        subprocess.run(["umount", "-l", where], check=True)


def test_a_disk_that_is_read_only(disk):
    where = disk("ro,size=8m")
    for directory in (where, where / "new"):
        line = mistake("--record", directory, status=ENVIRONMENT)
        assert str(where) in line


def test_a_disk_that_is_too_small_from_the_start(disk):
    assert "disk full" in mistake("--record", disk("size=2m") / "r", status=ENVIRONMENT)


# --- Kill, full disk, slow disk --------------------------------------------------------------------------------------

def kill_at(tick, directory, connect):
    """Starts a recorded run, and gives how to go on with it: kill() → the newest tick that its bus has told."""
    emulator = Emulator(["slcan:pty"], "--record", directory, "--control", "none")
    client = connect(emulator)
    client.send_p1(REST_P1_PSI + 0.2)

    def kill():
        client.newest("SERVO_Position", lambda f: f["Tick"] >= tick)
        ticks = ticks_of(client.frames_so_far())
        emulator.signal(signal.SIGKILL)
        emulator.__exit__()
        return max([tick, *ticks])

    return kill


def test_kill_costs_less_than_a_second(tmp_path, connect):
    """At twenty random moments, five runs at a time."""
    chance = random.Random(20)
    for group in range(4):
        ends = sorted(chance.randrange(300, 13000) for _ in range(5))
        directories = [tmp_path / f"{group}-{end}" for end in ends]
        kills = [kill_at(end, directory, connect) for end, directory in zip(ends, directories)]
        told = [kill() for kill in kills]
        for tick, directory in zip(told, directories):
            check_killed(directory, tick)


def check_killed(directory, told_tick):
    recording = Recording(directory)
    rows = len(recording.ticks)
    assert list(recording.ticks) == list(range(1, rows + 1)), "a hole"
    assert rows >= told_tick - 10000, f"{told_tick - rows} ticks are missing"
    assert "verdict" not in recording.attributes and "BO_ 512" in recording.attributes["dbc"]
    log_frames(directory)
    if rows == 0:
        assert "not one tick was recorded" in run("replay", directory, status=USAGE).stderr
    else:
        told = run("replay", directory).stdout
        assert "it has no end: killed, or still being written" in told
        assert f"identical: {rows} samples to tick {rows} " in told


@pytest.mark.parametrize("left_bytes", [3_000_000, 0])
def test_a_full_disk_ends_the_recording_not_the_run(disk, tmp_path, start, connect, left_bytes):
    """Somebody else fills the disk, up to the last byte or nearly so."""
    where = disk("size=8m")
    emulator = start("--record", where / "r")
    client = connect(emulator)
    client.send_p1(REST_P1_PSI + 0.2)
    client.newest("SERVO_Position", lambda f: f["Tick"] >= 12000)
    fill(where / "somebody's", left_bytes)
    client.send_p1(REST_P1_PSI + 0.4)
    frames = client.for_ticks(10000)
    assert frames[-1]["Tick"] > 20000
    result = emulator.stop()  # which judges: status and verdict are those of the timing alone
    assert result.ticks >= 22000
    summary = re.search(rf"^recorded \d+ samples, \d+ influences, \d+ frames in {where}/r; INCOMPLETE: (.*)$",
                        result.text, re.M)
    assert re.search(r"disk full|No space left|cannot be written", summary[1])
    lost = int(re.search(r"lost: (\d+) samples", summary[1])[1])
    assert lost > 5000
    (where / "somebody's").unlink()
    shutil.copytree(where / "r", tmp_path / "copy")
    recording = Recording(tmp_path / "copy")
    rows = len(recording.ticks)
    assert list(recording.ticks) == list(range(1, rows + 1)) and rows >= 2000
    log_frames(tmp_path / "copy")
    if left_bytes > 0:
        assert rows + lost == result.ticks
        a = recording.attributes
        assert a["complete"] == 0 and a["samples_lost"] == lost and a["verdict"] == result.verdict
        assert "disk full" in a["problem"]
        gap = recording.gaps["stream"] == 0
        assert list(recording.gaps["tick"][gap]) == [rows + 1] and list(recording.gaps["lost"][gap]) == [lost]
    assert f"identical: {rows} samples" in run("replay", tmp_path / "copy").stdout


def fill(file, left_bytes):
    """Takes the disk's free space but for this."""
    disk = os.statvfs(file.parent)
    take = disk.f_bavail * disk.f_frsize - left_bytes
    with file.open("wb", buffering=0) as out:
        try:
            while take > 0:
                take -= out.write(bytes(min(take, 65536)))
            while left_bytes == 0:
                out.write(b"0")
        except OSError:
            pass


def assert_gaps_are_exact(recording):
    """Samples and gaps together are every tick of the run, from its first to its last, each once."""
    gap = recording.gaps["stream"] == 0
    missing = [numpy.arange(tick, tick + lost) for tick, lost in
               zip(recording.gaps["tick"][gap], recording.gaps["lost"][gap])]
    ticks = numpy.sort(numpy.concatenate([recording.ticks, *missing]).astype(int))
    assert numpy.array_equal(ticks, numpy.arange(1, int(recording.attributes["final_tick"]) + 1))
    assert sum(map(len, missing)) == int(recording.attributes["samples_lost"])


def test_a_disk_that_hangs_costs_samples_not_ticks(tmp_path, start, connect):
    """The recorder's thread stands still for longer than its ring holds; the simulation does not wait for it."""
    emulator = start("--record", tmp_path / "r", *settings(publish__position_ms=1))
    client = connect(emulator)
    client.send_p1(REST_P1_PSI + 0.2)
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    with paused(emulator.process_id, "recorder"):
        client.for_ticks(36000)
        let_time_pass(0.1)
    client.for_ticks(5000)
    result = emulator.stop()
    assert re.search(r"; INCOMPLETE: .*: the disk was too slow; lost: \d+ samples", result.text)
    recording = Recording(tmp_path / "r")
    lost = int(recording.attributes["samples_lost"])
    assert recording.attributes["complete"] == 0 and lost > 0
    assert recording.attributes["final_tick"] == result.ticks
    assert_gaps_are_exact(recording)
    told = run("replay", tmp_path / "r").stdout
    assert "INCOMPLETE" in told and f"identical: {len(recording.ticks)} samples to tick {result.ticks} " in told

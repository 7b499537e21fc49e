"""`servohil replay`: a recorded run is run again, bit for bit; what was changed in a recording is found; `--set` asks
what would have been."""

import random
import re
import shutil
import subprocess

import h5py
import numpy
import pytest

from control_socket import Control
from emulator import NOT_VALID, OK, PROGRAM, REPOSITORY, RUNNING, USAGE, Client, Emulator, run, settings
from recordings import FILE, LOG, Recording, same_bits

REST_P1_PSI = 30.263
MODEL = settings(friction__coulomb_psi=2, stabilizer__enabled="true", oil__air_fraction=0.005)
FAULTS = [("air_entrainment", {"fraction": 0.05, "ramp_s": 0.1}), ("coulomb_friction", {"psi": 8}),
          ("load_oscillation", {"amplitude_psi": 6, "frequency_hz": 9, "for_s": 0.2}),
          ("piston_jammed", {"for_s": 0.1}),
          ("supply_ripple", {"amplitude_psi": 20}), ("hot_oil", {"ramp_s": 0.3}), ("load_step", {"psi": 15}),
          ("gas_charge_lost", {}), ("cam_slipped", {"offset_in": 0.2, "ramp_s": 0.05, "for_s": 0.1})]


def replay(*arguments, status=OK):
    done = run("replay", *arguments, status=status)
    assert done.stderr == "" or (status == USAGE and done.stderr.count("\n") == 1), done.stderr
    return done.stdout if status != USAGE else done.stderr


def random_run(emulator, client, control, ticks, seed):
    """A governor that does anything, and somebody at the control socket who does, too."""
    chance = random.Random(seed)
    begin = now = client.newest("SERVO_Position")["Tick"]
    injected = 0
    while now < begin + ticks:
        if chance.random() < 0.7:
            client.send_p1(round(REST_P1_PSI + chance.gauss(0.0, 1.5), 3))
        if chance.random() < 0.15:
            name, parameters = chance.choice(FAULTS)
            control.inject(name, **parameters)
            injected += 1
        if chance.random() < 0.05:
            control.clear()
        if chance.random() < 0.1:
            control.apply("command", p1_psi=round(REST_P1_PSI + chance.random(), 3))
        now = client.until(lambda f: f.name == "SERVO_Position")[-1]["Tick"]
    return injected


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run in real time, commands and interventions at random: its directory, which no test changes, and result."""
    place = tmp_path_factory.mktemp("recorded")
    with Emulator(["slcan:pty"], *MODEL, "--record", place / "r", "--control", place / "sock") as emulator:
        with Client(emulator.urls[0]) as client, Control(place / "sock") as control:
            injected = random_run(emulator, client, control, 30000, seed=1)
        result = emulator.stop()
    assert injected > 20
    return place / "r", result


@pytest.fixture
def copy(recorded, tmp_path):
    """Its directory, to change."""
    return shutil.copytree(recorded[0], tmp_path / "r")


# --- Identical -------------------------------------------------------------------------------------------------------

def test_a_run_in_real_time_is_repeated(recorded):
    directory, result = recorded
    told = replay(directory)
    assert f"verdict {result.verdict}" in told
    assert told.endswith(f"identical: {result.ticks} samples to tick {result.ticks} ({result.ticks * 1e-4:.4f} s), "
                         f"state hash {result.hash}\n")
    kinds = Recording(directory).influences["kind"]
    assert {0, 2, 6, 7} <= set(kinds) and len(kinds) > 100, "else it shows little"


def test_the_file_may_be_named_itself(recorded):
    assert replay(recorded[0] / FILE).splitlines()[-1].startswith("identical: ")


def test_until(recorded):
    directory, result = recorded
    assert "identical: 10000 samples to tick 10000 (1.0000 s)" in replay(directory, "--until", 1)
    assert f"to tick {result.ticks} " in replay(directory, "--until", 1000)
    final = Recording(directory).samples["state_hash"][9999]
    assert f"state hash {final:016x}" in replay(directory, "--until", 1)


def test_a_simulation_is_repeated(tmp_path):
    run("simulate", *MODEL, "--duration", 0.5, "--p1-step", 2, "--record", tmp_path / "r")
    assert "identical: 5000 samples" in replay(tmp_path / "r")


def test_a_lockstep_run_is_repeated(tmp_path, start, connect):
    emulator = start("--clock", "lockstep", *MODEL, "--record", tmp_path / "r", "--control", tmp_path / "sock")
    client = connect(emulator)
    with Control(tmp_path / "sock") as control:
        for step in range(60):
            if step == 20:
                control.inject("air_entrainment", fraction=0.1, ramp_s=0.05)
            client.send_p1(REST_P1_PSI + 0.3 * (step % 4))
            client.newest("SERVO_Status")
    result = emulator.stop()
    assert f"identical: 6000 samples to tick 6000 (0.6000 s), state hash {result.hash}" in replay(tmp_path / "r")


def test_a_run_from_a_snapshot_is_repeated(tmp_path, start, connect):
    """The recording begins in the middle, with a fault in its ramp."""
    emulator = start(*MODEL, "--control", tmp_path / "sock", "--snapshot-dir", tmp_path)
    client = connect(emulator)
    client.send_p1(REST_P1_PSI + 0.5)
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    with Control(tmp_path / "sock") as control:
        control.inject("air_entrainment", fraction=0.05, ramp_s=1)
        client.for_ticks(1000)
        tick = control.snapshot()
    emulator.stop()
    emulator = start("--from", tmp_path / f"snapshot-{tick}.json", "--record", tmp_path / "r")
    client = connect(emulator)
    client.newest("SERVO_Position")
    client.send_p1(REST_P1_PSI)
    client.for_ticks(5000)
    result = emulator.stop()
    recording = Recording(tmp_path / "r")
    assert recording.ticks[0] == tick + 1 and recording.samples["active_faults"][0] == 1
    assert f"to tick {result.ticks} ({result.ticks * 1e-4:.4f} s), state hash {result.hash}" in replay(tmp_path / "r")


def test_a_replay_that_is_recorded_is_the_recording(recorded, tmp_path):
    directory, _ = recorded
    replay(directory, "--record", tmp_path / "again")
    one, other = Recording(directory), Recording(tmp_path / "again")
    for name in one.samples:
        if not any(word in name for word in ("late", "long", "command")):
            assert same_bits(one.samples[name], other.samples[name]), name
    assert "identical: " in replay(tmp_path / "again")


# --- A changed recording ---------------------------------------------------------------------------------------------

@pytest.mark.parametrize("column, tick", [("x3_in", 12345), ("p3_psi", 1), ("p1_psi", 4097), ("state_hash", 20000),
                                          ("sub_steps", 8000), ("p8_psi", -1)])
def test_one_bit_of_a_value_is_found(copy, column, tick):
    """Written by HDF5 itself, so that all its checksums are right."""
    with h5py.File(copy / FILE, "r+") as file:
        dataset = file[f"samples/{column}"]
        row = tick - 1 if tick > 0 else len(dataset) - 1
        one = dataset[row:row + 1]
        one.view("u1")[0] ^= 1
        dataset[row:row + 1] = one
    told = replay(copy, status=NOT_VALID).splitlines()[-1]
    assert re.match(rf"differs from tick {row + 1} \({(row + 1) * 1e-4:.4f} s\) on: {column} recorded \S+, replayed "
                    r"\S+$", told), told


def test_one_bit_of_a_command_is_found(copy):
    """What the run was given was another one: the first tick that felt it differs."""
    with h5py.File(copy / FILE, "r+") as file:
        kinds = file["influences/kind"][:]
        row = [i for i, kind in enumerate(kinds) if kind == 6][40]
        tick = int(file["influences/tick"][row])
        file["influences/p1_psi"][row] += 0.001
    told = replay(copy, status=NOT_VALID).splitlines()[-1]
    assert told.startswith(f"differs from tick {tick} ") and "p1_psi" in told


def chunks(path, name):
    with h5py.File(path, "r") as file:
        dataset = file[name]
        infos = [dataset.id.get_chunk_info(i) for i in range(dataset.id.get_num_chunks())]
        return [(info.chunk_offset[0], info.byte_offset, info.size) for info in infos], dataset.chunks[0], len(dataset)


def flip(path, at, bit=0):
    with path.open("r+b") as file:
        file.seek(at)
        byte = file.read(1)[0]
        file.seek(at)
        file.write(bytes([byte ^ 1 << bit]))


@pytest.mark.parametrize("name", ["samples/x3_in", "samples/state_hash", "samples/tick", "samples/motion",
                                  "influences/p1_psi", "influences/tick"])
def test_one_flipped_bit_of_the_data_is_found_and_located(copy, name):
    """Of the file itself, as a bad disk does it: the column and its rows are named."""
    chance = random.Random(name)
    infos, chunk_rows, rows = chunks(copy / FILE, name)
    for first_row, offset, size in chance.sample(infos, min(3, len(infos))):
        at, bit = offset + chance.randrange(size), chance.randrange(8)
        flip(copy / FILE, at, bit)
        told = replay(copy, status=USAGE)
        last = min(rows, first_row + chunk_rows) - 1
        assert f"{name}: rows {first_row} to {last} are damaged" in told
        flip(copy / FILE, at, bit)
    assert "identical" in replay(copy)


def test_flipped_bits_anywhere_are_no_more_than_an_error(copy):
    """Structure, attributes, data that replay does not need: never a crash, never a difference that is not there."""
    chance = random.Random(3)
    size = (copy / FILE).stat().st_size
    places = [chance.randrange(4096) for _ in range(10)] + [chance.randrange(size) for _ in range(10)]
    for at in places:
        flip(copy / FILE, at, at % 8)
        done = run_any("replay", copy, "--until", 0.5)
        assert done.returncode in (OK, NOT_VALID, USAGE), f"byte {at}: {done}"
        assert done.stderr.count("\n") == (done.returncode == USAGE), f"byte {at}: {done.stderr}"
        flip(copy / FILE, at, at % 8)
    assert "identical" in replay(copy)


def run_any(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=60, cwd=REPOSITORY)


def test_a_changed_configuration_is_found(copy):
    with h5py.File(copy / FILE, "r+") as file:
        text = file.attrs["configuration"]
        changed = text.replace(b"coulomb_psi = 2", b"coulomb_psi = 3")
        assert changed != text
        attribute = file.attrs.get_id("configuration")
        attribute.write(numpy.array(changed, dtype=attribute.dtype))
    assert "damaged: their hash is" in replay(copy, status=USAGE)


# --- What if ---------------------------------------------------------------------------------------------------------

def test_what_if(copy):
    """Beside the recording appears another one, of the same inputs and another servomotor."""
    before = (copy / FILE).read_bytes()
    told = replay(copy, *settings(servo__bulk_modulus_psi=90000))
    assert re.search(r"^deviates from tick \d+ \(\d+\.\d{4} s\) on, first in \w+; largest deviations:$", told, re.M)
    beside = copy.parent / "r-what-if"
    assert f"{beside}; complete" in told and (copy / FILE).read_bytes() == before
    was, is_ = Recording(copy), Recording(beside)
    assert same_bits(was.ticks, is_.ticks) and same_bits(was.samples["p1_psi"], is_.samples["p1_psi"])
    assert "bulk_modulus_psi = 90000" in is_.attributes["configuration"]
    deviations = {name: (float(largest), float(t)) for name, largest, t in
                  re.findall(r"^  (\w+) +(\S+) \S+ at ([\d.]+) s$", told, re.M)}
    assert {"x3_in", "v3_in_s", "p3_psi", "p4_psi"} <= deviations.keys() and "p1_psi" not in deviations
    for name, (largest, t_s) in deviations.items():
        difference = abs(is_.samples[name] - was.samples[name])
        assert largest == pytest.approx(difference.max(), rel=1e-5), name
        assert difference[round(t_s * 1e4) - 1] == difference.max()
    assert replay(beside).splitlines()[-1].startswith("identical: ")
    replay(copy, *settings(servo__bulk_modulus_psi=80000))
    assert (copy.parent / "r-what-if-2" / FILE).exists()


def test_what_if_nothing_changes(copy):
    told = replay(copy, *settings(friction__coulomb_psi=2), "--until", 0.5)
    assert "the changes change nothing: identical" in told


# --- A log of frames -------------------------------------------------------------------------------------------------

def test_a_log_drives_the_model(tmp_path, start, connect):
    """Of a bus that servohil was on, or anybody: the commands count. The same motion within the jitter of their time
    stamps, and the same rest in the end."""
    emulator = start("--record", tmp_path / "r")
    client = connect(emulator)
    client.newest("SERVO_Position")
    for p1_psi in (30.6, 31.2, 30.0):
        client.send_p1(p1_psi)
        client.for_ticks(4000)
    result = emulator.stop(may_be_late=True)
    done = run("replay", tmp_path / "r" / LOG, *settings(safety__timeout_ms=0))
    assert re.search(rf"^log {tmp_path}/r/{LOG}: \d+ frames of \S+, ", done.stdout, re.M)
    assert re.search("^in       3 commands followed$", done.stdout, re.M)
    x3_in = float(re.search(r"; x3 ([\d.]+) in, P1 30\.000 psi", done.stdout)[1])
    assert x3_in == pytest.approx(result.x3_in, abs=0.0002)
    silent = run("replay", tmp_path / "r" / LOG).stdout  # by the time-out of a run
    assert re.search(r"mode DEGRADED$", silent, re.M) and "no command frame" in silent
    run("replay", tmp_path / "r" / LOG, "--record", tmp_path / "again", "--until", 0.5)
    assert len(Recording(tmp_path / "again").ticks) == 5000


def test_a_log_of_another_tool(tmp_path):
    """Names of interfaces, extended and remote frames, CAN FD, error frames are read; what is no command is passed
    over."""
    log = tmp_path / "any.log"
    log.write_text("(1436509052.249713) vcan0 044#2A366C2BBA\n(1436509052.250000) can1 100#00557407\n"
                   "(1436509052.350000) can1 1ABCDEF0#R\n(1436509052.350001) can1 123##1AABB\n"
                   "(1436509052.350002) can1 20000004#0000000000000000\n(1436509053.250000) can1 100#00557407 R\n")
    done = run("replay", log, *settings(safety__timeout_ms=0))
    assert "4 frames of can1, 1.0000 s" in done.stdout and "2 commands followed" in done.stdout
    assert "P1 30.533 psi" in done.stdout


def test_a_log_with_a_jump_in_time_is_refused_at_its_line(tmp_path):
    log = tmp_path / "bad.log"
    log.write_text("(1000.0) can0 100#00557407\n(1006.0) can0 100#00557407\n(1000.01) can0 100#00557407\n")
    refused = run("replay", log, status=2)
    assert refused.stderr.startswith(f"servohil: {log}:3: time steps back by 5.990000 s") and refused.stderr.count("\n") == 1


def test_a_log_of_two_buses_needs_a_choice(tmp_path):
    log = tmp_path / "two.log"
    log.write_text("".join(f"({t / 100:.6f}) can{t % 2} 100#0055740{7 if t % 2 else 0}\n" for t in range(100, 110)))
    refused = run("replay", log, status=2)
    assert "can0 (5 frames), can1 (5 frames); choose one with --interface" in refused.stderr
    assert "5 frames of can1" in run("replay", log, "--interface", "can1").stdout
    assert "there is no frame of interface can7" in run("replay", log, "--interface", "can7", status=2).stderr


def test_a_log_of_which_nothing_is_followed_supports_no_verdict(tmp_path):
    log = tmp_path / "empty.log"
    log.write_text("(1000.0) can0 100#FFFFFFFFFFFFFFFF\n(1000.01) can0 100#FFFFFFFFFFFFFFFF\n")
    done = run("replay", log, status=1)
    assert "INVALID: no command was followed" in done.stdout and "2 out_of_range" in done.stdout


# --- Not a recording -------------------------------------------------------------------------------------------------

def foreign(path):
    with h5py.File(path, "w") as file:
        file["x"] = [1, 2, 3]


def test_what_is_no_recording_is_refused_in_one_line(tmp_path, recorded):
    text = tmp_path / "notes.txt"
    text.write_text("hello\n")
    text_h5 = tmp_path / "text.h5"
    text_h5.write_text("hello\n")
    empty = tmp_path / "empty.log"
    empty.write_text("")
    other = tmp_path / "other.h5"
    foreign(other)
    directory = tmp_path / "directory"
    directory.mkdir()
    of_a_future = tmp_path / "future.h5"
    shutil.copy(recorded[0] / FILE, of_a_future)
    with h5py.File(of_a_future, "r+") as file:
        file.attrs["servohil_recording"] = 99
    cut = tmp_path / "cut.h5"
    cut.write_bytes((recorded[0] / FILE).read_bytes()[:5000])
    no_command = tmp_path / "no-command.log"
    no_command.write_text("(1.0) vcan0 200#A8616AFF04030201\n")
    for path, says in ((tmp_path / "gone", "no such file"), (text, "notes.txt:1: "), (text_h5, "is no HDF5 file"),
                       (empty, "no frame"), (other, "is no recording of servohil"), (directory, "no such file"),
                       (of_a_future, "format 99, expected 2 to 3"), (cut, ""), (no_command, "no command frame")):
        done = run("replay", path, status=USAGE)
        assert done.stderr.count("\n") == 1 and str(path) in done.stderr and says in done.stderr, done


def test_a_recording_without_a_column_is_refused(copy):
    with h5py.File(copy / FILE, "r+") as file:
        del file["samples/p4_psi"]
    assert "samples/p4_psi: is missing" in replay(copy, status=USAGE)


def test_a_configuration_is_for_logs(recorded):
    assert "-c is for logs" in replay(recorded[0], "-c", "config/servohil.toml", status=USAGE)

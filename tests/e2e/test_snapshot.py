"""Snapshots: a run that goes on from one is, bit for bit, the run that was never interrupted: its state hash, which is
over the states of all ticks since the start, says so."""

import json
import re
import signal

import pytest

from control_socket import Control
from emulator import NOT_VALID, OK, USAGE, run, settings

LOCKSTEP = ("--clock", "lockstep")
TICKS = 100  # per command in lockstep
REST_P1_PSI = 30.263
MODEL = settings(friction__coulomb_psi=3, friction__breakaway_psi=5, stabilizer__enabled="true", oil__air_fraction=0.01,
                 supply__pump_flow_in3_s=150)


@pytest.fixture
def script(tmp_path):
    """P1 pushes the piston against friction, through standstills, into the upper stop and back."""
    steps = [(0.0, 30.6), (0.05, 29.0), (0.1, 34.0), (0.15, 33.9), (0.25, 60.0), (0.4, 25.0), (0.47, 31.0)]
    file = tmp_path / "script.csv"
    file.write_text("t_s,p1_psi\n" + "".join(f"{t},{p1}\n" for t, p1 in steps))
    return file


def fast(script, *arguments, duration_s, status=OK):
    done = run("run", "--clock", "fast", "--script", script, "--duration", duration_s, *arguments, status=status)
    return dict(re.findall(r"^(ran|hash|verdict) +(.*)$", done.stdout, re.M))


def test_restored_runs_go_on_bit_for_bit(tmp_path, script):
    """From moments in motion, at a stop, at rest by friction; and from a snapshot of a restored run."""
    at_s = [0.0001, 0.0437, 0.1502, 0.2999, 0.35, 0.4321, 0.55]
    whole = fast(script, *MODEL, *(word for t in at_s for word in ("--snapshot-at", t)), "--snapshot-dir", tmp_path,
                 duration_s=0.6)
    assert whole["ran"].startswith("6000 ticks")
    files = [tmp_path / f"snapshot-{round(t * 10000)}.json" for t in at_s]
    motions = [json.loads(file.read_text())["content"]["state"]["motion"] for file in files]
    assert len(set(motions)) >= 3, f"only motions {motions}: else it shows little"
    for t, file in zip(at_s, files):
        assert fast(script, "--from", file, duration_s=round(0.6 - t, 4)) == whole
    second = tmp_path / "second"
    second.mkdir()
    fast(script, "--from", files[1], "--snapshot-at", 0.2, "--snapshot-dir", second, duration_s=0.3)
    assert fast(script, "--from", second / "snapshot-2000.json", duration_s=0.4) == whole


def test_a_snapshot_disturbs_nothing(tmp_path, script):
    assert fast(script, *MODEL, "--snapshot-at", 0.1, "--snapshot-dir", tmp_path, duration_s=0.2) == fast(
        script, *MODEL, duration_s=0.2)


def test_a_changed_key_makes_another_run(tmp_path, script):
    whole = fast(script, *MODEL, "--snapshot-at", 0.1, "--snapshot-dir", tmp_path, duration_s=0.2)
    changed = fast(script, "--from", tmp_path / "snapshot-1000.json", *settings(friction__coulomb_psi=2),
                   duration_s=0.1)
    assert changed["hash"] != whole["hash"]


def commands(client, numbers):
    for number in numbers:
        client.send_p1(REST_P1_PSI + 0.1 * (number % 5))
        answer = client.until(lambda f: f.name == "SERVO_Status")
    return {f.name: f for f in answer}


def test_an_active_fault_goes_on_where_it_was(tmp_path, start, connect):
    """In its ramp, one that is still to come, an oscillation in its phase; by request, in lockstep."""
    path = tmp_path / "control.sock"
    emulator = start(*LOCKSTEP, *MODEL, "--control", path, "--snapshot-dir", tmp_path)
    client = connect(emulator)
    commands(client, range(5))
    with Control(path) as control:
        control.inject("air_entrainment", fraction=0.05, ramp_s=0.2, for_s=0.25)
        control.inject("load_oscillation", amplitude_psi=5, frequency_hz=7)
        control.inject("hot_oil", at_s=0.3, ramp_s=0.01)
        commands(client, range(5, 17))
        tick = control.snapshot()
        assert tick == 17 * TICKS
    last = commands(client, range(17, 60))
    client.close()
    whole = emulator.stop()
    assert last["SERVO_Status"]["ActiveFaults"] == 2, "the ramp is over, the later one acts"

    restored = start(*LOCKSTEP, "--from", tmp_path / f"snapshot-{tick}.json")
    assert "goes on at x3 " in restored.ready
    client = connect(restored)
    again = commands(client, range(17, 60))
    client.close()
    result = restored.stop()
    assert (result.ticks, result.hash) == (whole.ticks, whole.hash) == (60 * TICKS, whole.hash)
    assert {name: frame.values for name, frame in again.items()} == {name: frame.values for name, frame in last.items()}


def test_a_signal_takes_one_of_a_run_in_real_time(tmp_path, start, connect):
    """As it is on the bus: the tick of the file is one of the run, and its run goes on."""
    emulator = start("--snapshot-dir", tmp_path)
    client = connect(emulator)
    client.send_p1(31.0)
    before = client.newest("SERVO_Position", lambda f: f["Tick"] > 1000)["Tick"]
    emulator.signal(signal.SIGUSR1)
    wait_for_file(client, tmp_path)
    after = client.newest("SERVO_Position")["Tick"]
    emulator.stop()
    file, = tmp_path.glob("snapshot-*.json")
    tick = int(file.stem.split("-")[1])
    assert before <= tick <= after and f"snapshot: {file}" in emulator.log()

    restored = start("--from", file)
    client = connect(restored)
    first = client.newest("SERVO_Position")
    assert tick < first["Tick"] and first["X3"] > 4.0
    restored.pause(0.06)
    client.for_ticks(1000)
    result = restored.stop(may_be_late=True)
    assert result.status == NOT_VALID and result.ticks > tick
    late = [int(n) for n in re.findall(r"^late +at tick (\d+) ", result.text, re.M)]
    assert late and all(tick < n <= result.ticks for n in late), "ticks of the whole run"


def wait_for_file(client, directory):
    """Sees the files that are whole: each appears under its name when it is."""
    while not list(directory.glob("snapshot-*.json")):
        client.newest("SERVO_Position")


def test_a_snapshot_that_cannot_be_written_ends_no_run(tmp_path, start, connect):
    path, gone = tmp_path / "control.sock", tmp_path / "gone"
    gone.mkdir()
    emulator = start("--snapshot-dir", gone, "--control", path)
    client = connect(emulator)
    client.newest("SERVO_Position")
    gone.rmdir()
    with Control(path) as control:
        control.snapshot()
        client.for_ticks(3000)
        assert control.ask("status")["result"] == "OK"
    result = emulator.stop()
    assert f"{gone}/snapshot-" in result.log and "cannot be written" in result.log


# --- What is refused -------------------------------------------------------------------------------------------------

@pytest.fixture
def snapshot(tmp_path, script):
    fast(script, *MODEL, "--snapshot-at", 0.1, "--snapshot-dir", tmp_path, duration_s=0.1)
    return tmp_path / "snapshot-1000.json"


def refusal(file):
    done = run("run", "--can", "slcan:pty", "--from", file, "--duration", 0.01, status=USAGE)
    assert done.stdout == "" and done.stderr.count("\n") == 1 and done.stderr.startswith(f"servohil: {file}: ")
    return done.stderr


def test_one_changed_digit_is_damage(snapshot):
    text = snapshot.read_text()
    numbers = [m.start() for m in re.finditer(r'(?<="state": ){', text)]
    state = numbers[0]
    digits = [i for i in range(state, text.index('"texts"')) if text[i].isdigit()]
    assert len(digits) > 100
    for i in digits[::20]:
        snapshot.write_text(text[:i] + str((int(text[i]) + 1) % 10) + text[i + 1:])
        assert "damaged" in refusal(snapshot)
    in_dbc = text.index("0.0002")
    snapshot.write_text(text[:in_dbc] + "0.0003" + text[in_dbc + 6:])
    assert "damaged" in refusal(snapshot)


@pytest.mark.parametrize("damage, says", [
    (lambda text: text[:len(text) // 2], "not JSON"),
    (lambda text: "", "not JSON"),
    (lambda text: "\x00" * 100, "not JSON"),
    (lambda text: "[]", "no servohil snapshot"),
    (lambda text: "{}", "no servohil snapshot"),
    (lambda text: '{"format": 7}', "no servohil snapshot"),
    (lambda text: text.replace('"servohil snapshot"', '"another snapshot"'), "no servohil snapshot"),
    (lambda text: text.replace('"version": 3', '"version": 4'), "of version 4, this program reads 2 to 3"),
    (lambda text: text.replace('"version": 3', '"version": "1"'), "damaged"),
    (lambda text: text.replace('"version": 3', '"versoin": 1'), "damaged"),
    (lambda text: text.replace('"checksum"', '"checksun"'), "damaged"),
    (lambda text: text.replace('"content"', '"contents"'), "damaged"),
])
def test_foreign_and_damaged_files_are_refused(snapshot, damage, says):
    text = snapshot.read_text()
    damaged = damage(text)
    assert damaged != text
    snapshot.write_text(damaged)
    assert says in refusal(snapshot)


def test_places_without_a_snapshot(tmp_path):
    assert "no such file" in refusal(tmp_path / "gone.json")
    assert "is a directory" in refusal(tmp_path)


def test_a_snapshot_has_its_configuration(snapshot):
    done = run("run", "--can", "slcan:pty", "--from", snapshot, "-c", "config/servohil.toml", "--duration", 0.01,
               status=USAGE)
    assert "--config" in done.stderr

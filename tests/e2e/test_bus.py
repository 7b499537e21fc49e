"""`servohil run` as its clients see it: python-can and can-utils on the bus, canmatrix for the DBC file.

Each test runs over every selected transport (conftest.py). Times are counted in ticks of the emulator, not in time of
this machine: a busy machine makes frames late, not wrong.
"""

import csv
import io
import json
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import can
import pytest

from emulator import (DBC, ENVIRONMENT, NOT_VALID, REPOSITORY, RUNNING, STOPPED, TICKS_PER_MS, USAGE, WAITING, Client,
                      Emulator, let_time_pass, rounding, run, settings, ticks_of)
from recordings import Recording

REST_P1_PSI = 30.2632  # steady state at x3 = 4 in (expected.md: 30.26320)
STEP_P1_PSI = 30.533   # 0.27 psi more
EVERY_MS = settings(publish__position_ms=1, publish__pressures_ms=1)
CYCLE_MS = {"SERVO_Position": 10, "SERVO_Pressures": 10, "SERVO_Relay": 100, "SERVO_Bus": 1000, "SERVO_Safety": 100,
            "SERVO_Status": 100}


def p1_of(frames):
    return [frame["P1_Applied"] for frame in frames if frame.name == "SERVO_Pressures"]


# --- Steady state and response ---------------------------------------------------------------------------------------

def test_ready_line_says_where_to_connect(start, transport):
    emulator = start()
    assert re.fullmatch(r"ready: \S+; at rest at x3 4\.0000 in, P1 30\.2632 psi, until the first command; "
                        r"wake-up every 1\.0 ms\n", emulator.ready)
    if transport == "slcan":
        assert f'channel="{emulator.urls[0].partition(":")[2]}"' in emulator.log()


def test_rests_until_the_first_command(start, connect):
    emulator = start()
    client = connect(emulator)
    frames = client.for_ticks(3000)
    assert {frame["X3"] for frame in frames if frame.name == "SERVO_Position"} == {4.0}
    assert {frame["V3"] for frame in frames if frame.name == "SERVO_Position"} == {0.0}
    for p1_psi in p1_of(frames):
        assert abs(p1_psi - REST_P1_PSI) < rounding(client.resolution("SERVO_Pressures", "P1_Applied"))
    status = client.newest("SERVO_Status")
    assert (status["Mode"], status["ModelFault"], status["Stuck"], status["ActiveFaults"]) == (WAITING, 0, 0, 0)
    result = emulator.stop()
    assert result.count["commands"] == 0 and result.x3_in == 4.0


def test_step_leads_to_the_steady_state(start, connect):
    steady = json.loads(run("steady", "--p1", STEP_P1_PSI, "--json").stdout)
    emulator = start()
    client = connect(emulator)
    client.newest("SERVO_Position")
    client.send_p1(STEP_P1_PSI)
    begin = client.newest("SERVO_Pressures", lambda f: f["P1_Applied"] > 30.5)
    frames = client.for_ticks(10000)
    position = [frame for frame in frames if frame.name == "SERVO_Position"][-1]
    pressures = [frame for frame in frames if frame.name == "SERVO_Pressures"][-1]
    relay = [frame for frame in frames if frame.name == "SERVO_Relay"][-1]
    assert begin["P1_Applied"] == pytest.approx(STEP_P1_PSI, abs=rounding(0.005))
    # After 1 s the slowest mode of the step (66 1/s) is gone; the oscillation has decayed to 1e-5 of its 7 in/s.
    for frame, name, key in ((position, "X3", "x3_in"), (pressures, "P3", "p3_psi"), (pressures, "P4", "p4_psi"),
                             (relay, "X1", "x1_in"), (relay, "X2", "x2_in"), (relay, "X4", "x4_in")):
        resolution = client.resolution(frame.name, name)
        assert abs(frame[name] - steady[key]) < resolution, f"{name} {frame[name]}, steady state {steady[key]}"


def simulate(changes, until_tick, tmp_path):
    """Rows of `servohil simulate` by tick for P1 values from given ticks on."""
    file = tmp_path / "p1.csv"
    file.write_text("t_s,p1_psi\n" + "".join(f"{tick * 1e-4:.4f},{p1_psi!r}\n" for tick, p1_psi in changes))
    text = run("simulate", "--p1-file", file, "--duration", f"{until_tick * 1e-4:.4f}").stdout
    return {round(float(row["t_s"]) / 1e-4): row for row in csv.DictReader(io.StringIO(text))}


SIMULATED = {"SERVO_Position": {"X3": "x3_in", "V3": "v3_in_s"},
             "SERVO_Pressures": {"P1_Applied": "p1_psi", "P3": "p3_psi", "P4": "p4_psi", "P8": "p8_psi"}}


def test_trajectory_is_that_of_simulate(start, connect, tmp_path):
    """The frames of a live run are those of an offline simulation with the same P1 from the same ticks on, to the last
    digit that the signals carry. The recording tells the ticks (test_recording.py compares it with the bus)."""
    emulator = start(*EVERY_MS, "--record", tmp_path / "run")
    client = connect(emulator)
    client.newest("SERVO_Position")
    for p1_psi in (STEP_P1_PSI, REST_P1_PSI + 2.0):
        client.send_p1(p1_psi)
        client.until(lambda f, p1=p1_psi: f.name == "SERVO_Pressures" and abs(f["P1_Applied"] - p1) < 0.005)
        client.for_ticks(1500)
    emulator.stop()
    run_ = Recording(tmp_path / "run")
    changes = [(int(tick) - 1, float(p1)) for tick, p1 in zip(run_.influences["tick"], run_.influences["p1_psi"])
               if p1 > 0.0]  # the supervision's have none
    assert len(changes) == 2
    rows = simulate(changes, int(run_.ticks[-1]), tmp_path)
    compared = 0
    for message, signals in SIMULATED.items():
        published = run_.published[message]
        for name, column in signals.items():
            half = rounding(client.resolution(message, name))
            for tick, value in zip(published["tick"], published[name]):
                assert abs(value - float(rows[int(tick)][column])) <= half, (message, name, tick)
                compared += 1
    assert compared > 1000


# --- What is on the bus ----------------------------------------------------------------------------------------------

def test_frames_are_those_of_the_dbc_at_their_cycle_times(start, connect):
    emulator = start()
    client = connect(emulator)
    frames = client.for_ticks(10000)
    assert {frame.name for frame in frames} == set(CYCLE_MS)  # and none of unknown id
    for frame in frames:
        assert frame.raw.dlc == client.messages[frame.name].size
    span = ticks_of(frames)[-1] - ticks_of(frames)[0]
    result = emulator.stop()

    missing = 0
    for name, cycle_ms in CYCLE_MS.items():
        count = sum(frame.name == name for frame in frames)
        expected = span / (cycle_ms * TICKS_PER_MS)
        # Between two SERVO_Position; each of the others comes with one, so one more or less at the ends.
        assert count <= expected + 1
        missing += max(0, int(expected) - count)
    # A frame that is not there was overtaken by a newer one in the program, on a machine that came late.
    assert missing <= result.count["superseded"]
    assert {tick % (10 * TICKS_PER_MS) for tick in ticks_of(frames)} == {0}
    if result.count["superseded"] == 0:
        assert {b - a for a, b in zip(ticks_of(frames), ticks_of(frames)[1:])} == {10 * TICKS_PER_MS}


def test_published_with_another_layout(start, connect, tmp_path):
    """Nothing of the contract is compiled in: other ids (29 bits), byte order, scaling, a signal fewer."""
    text = DBC.read_text()
    for old, new in (("BO_ 256 GOV", f"BO_ {0x1ABCDE | 1 << 31} GOV"), ("BO_ 512 ", "BO_ 700 "),
                     ("X3 : 0|16@1+ (0.0002,-1)", "X3 : 7|16@0+ (0.0005,-2)"),
                     (" SG_ V3 : 16|16@1- (0.01,0) [-327.68|327.67] \"in/s\" GOVERNOR\n", ""),
                     ("P1_Demand : 12|20@1+ (0.001,0) [0|300]", "P1_Demand : 23|16@0+ (0.002,10) [10|140]")):
        assert old in text
        text = text.replace(old, new)
    dbc = tmp_path / "other.dbc"
    dbc.write_text("\n".join(line for line in text.splitlines() if not line.startswith(("CM_", "VAL_"))) + "\n")
    emulator = start(*settings(can__dbc=dbc))
    with Client(emulator.urls[0], dbc) as client:
        first = client.newest("SERVO_Position")
        assert first.raw.arbitration_id == 700 and "V3" not in first.values
        assert first["X3"] == pytest.approx(4.0, abs=rounding(0.0005))
        client.send(client.command(31.0, arbitration_id=0x1ABCDE, is_extended_id=True))
        client.newest("SERVO_Pressures", lambda f: f["P1_Applied"] == 31.0)
    assert emulator.stop().count["commands"] == 1


def test_foreign_and_wrong_frames_change_nothing(start, connect, transport):
    """Counted in the summary. On socketcan the kernel's filter keeps what is not GOV_Command from the program."""
    emulator = start()
    client = connect(emulator)
    client.newest("SERVO_Position")
    good = client.command(STEP_P1_PSI)
    foreign = [can.Message(arbitration_id=id_, data=good.data, is_extended_id=False) for id_ in (0, 0xFF, 0x101, 0x7FF)]
    foreign += [can.Message(arbitration_id=0x100, data=good.data, is_extended_id=True),
                can.Message(arbitration_id=0x1FFFFFFF, data=bytes(8), is_extended_id=True)]
    remote = can.Message(arbitration_id=0x100, is_remote_frame=True, dlc=4, is_extended_id=False)
    short = [client.command(STEP_P1_PSI, data=good.data[:size]) for size in range(4)]
    out_of_range = [client.command(p1_psi) for p1_psi in (300.001, 500.0, 1048.575)]
    client.send(*foreign, remote, *short, *out_of_range)
    frames = client.for_ticks(2000)  # far longer than a command takes
    assert {frame["X3"] for frame in frames if frame.name == "SERVO_Position"} == {4.0}
    assert {frame["Mode"] for frame in frames if frame.name == "SERVO_Status"} == {WAITING}
    client.send_p1(STEP_P1_PSI)  # and a good one still counts
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    count = emulator.stop().count
    sent = {"commands": 1, "of other ids": len(foreign), "malformed": len(short) + 1, "out of range": len(out_of_range)}
    if transport == "socketcan":
        sent.update({"of other ids": 0, "malformed": len(short)})
    assert {name: count[name] for name in sent} == sent


def test_extremes_of_the_command_are_in_range(start, connect):
    """0 and 300 psi, the ends of the range in the DBC file, are commands; longer frames are, too."""
    emulator = start()
    client = connect(emulator)
    client.newest("SERVO_Position")
    client.send_p1(300.0)
    client.newest("SERVO_Pressures", lambda f: f["P1_Applied"] == 300.0)
    client.send_p1(0.0)
    client.newest("SERVO_Pressures", lambda f: f["P1_Applied"] == 0.0)
    longer = client.command(30.0)
    client.send(client.command(30.0, data=bytes(longer.data) + b"\xff" * 4))
    client.newest("SERVO_Pressures", lambda f: f["P1_Applied"] == 30.0)
    assert emulator.stop().count["commands"] == 3


def test_mode_and_age_of_the_command(start, connect):
    emulator = start()
    client = connect(emulator)
    status = client.newest("SERVO_Status")
    assert (status["Mode"], status["CommandAge"]) == (WAITING, 4095)
    client.send_p1(STEP_P1_PSI)
    first = client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    assert first["CommandAge"] <= 100  # of a status every 100 ms
    frames = client.for_ticks(5000)
    tick = None
    ages = []
    for frame in frames:  # a status comes after the position of its tick
        if frame.name == "SERVO_Position":
            tick = int(frame["Tick"])
        elif frame.name == "SERVO_Status" and tick is not None:
            ages.append((tick, frame["CommandAge"]))
    assert len(ages) >= 2
    for (tick, age), (next_tick, next_age) in zip(ages, ages[1:]):
        assert abs((next_age - age) - (next_tick - tick) / TICKS_PER_MS) <= 1  # whole milliseconds
    client.send_p1(STEP_P1_PSI)
    assert client.newest("SERVO_Status", lambda f: f["CommandAge"] < ages[-1][1])["CommandAge"] <= 100


# --- Clients come and go ---------------------------------------------------------------------------------------------

def test_clients_see_each_other(start, connect):
    """Two connections of one emulator are one cable."""
    emulator = start(buses=2)
    one, other = connect(emulator, 0), connect(emulator, 1)
    one.newest("SERVO_Position")
    other.newest("SERVO_Position")
    for sender, receiver, id_ in ((one, other, 0x321), (other, one, 0x18FF1234)):
        hello = can.Message(arbitration_id=id_, data=b"\x01\x02\x03", is_extended_id=id_ > 0x7FF)
        sender.send(hello)
        heard = receiver.until(lambda f, i=id_: f.raw.arbitration_id == i)[-1].raw
        assert heard.data == hello.data and heard.is_extended_id == hello.is_extended_id
    one.send_p1(STEP_P1_PSI)
    assert other.until(lambda f: f.name == "GOV_Command")[-1]["P1_Demand"] == pytest.approx(STEP_P1_PSI)
    other.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    assert emulator.stop().count["commands"] == 1


def test_reconnected_client_gets_fresh_frames_only(start, connect):
    """What was published while the client was away is gone: nothing old bursts out."""
    emulator = start(buses=2)
    client, witness = connect(emulator, 0), connect(emulator, 1)
    client.newest("SERVO_Position")
    client.close()
    witness.for_ticks(3000)
    seen = int(witness.newest("SERVO_Position")["Tick"])
    client.open()
    frames = client.for_ticks(1000)
    assert ticks_of(frames)[0] >= seen
    assert ticks_of(frames) == sorted(set(ticks_of(frames)))
    emulator.stop()


@pytest.mark.only("slcan")
def test_client_that_does_not_read_gets_the_present(start, connect):
    """A terminal holds little. A client that wakes up finds newer frames, whole, not the oldest of a long queue; the
    rest is counted."""
    emulator = start(*EVERY_MS, buses=2)
    sleeper, witness = connect(emulator, 0), connect(emulator, 1)
    sleeper.newest("SERVO_Position")
    witness.for_ticks(20000)
    now = int(witness.newest("SERVO_Position")["Tick"])
    sleeper.newest("SERVO_Position", lambda f: f["Tick"] >= now)
    frames = sleeper.for_ticks(500)
    assert all(frame.name in CYCLE_MS for frame in frames)
    result = emulator.stop()
    dropped = sum(bus["dropped (queue full)"] for bus in result.buses)
    assert 0 < dropped


@pytest.mark.only("slcan")
def test_terminal_under_a_name_of_its_own(tmp_path, connect):
    link = tmp_path / "governor-bus"
    with Emulator([f"slcan:pty:{link}"]) as emulator:
        assert emulator.urls == [f"slcan:{link}"] and link.resolve().parent.name == "pts"
        connect(emulator).newest("SERVO_Position")
        emulator.stop()
    assert not link.is_symlink()
    link.write_text("somebody's file")
    assert f"{link} exists" in run("run", "--can", f"slcan:pty:{link}", status=USAGE).stderr
    assert link.read_text() == "somebody's file"


@pytest.mark.only("slcan")
def test_serial_adapter(start, connect):
    """The emulator as the host of an adapter: another emulator's terminal plays it, itself silent."""
    silent = settings(publish__position_ms=0, publish__pressures_ms=0, publish__relay_ms=0, publish__status_ms=0,
                      publish__bus_ms=0, publish__safety_ms=0)
    adapter = start(*silent, buses=2)
    with Emulator([adapter.urls[0]]) as emulator:
        client = connect(adapter, 1)
        client.newest("SERVO_Position")
        client.send_p1(STEP_P1_PSI)
        client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
        emulator.signal(signal.SIGTERM)
        assert client.newest("SERVO_Status", lambda f: f["Mode"] == STOPPED)
        assert emulator.wait().count["commands"] == 1
    assert adapter.stop().count["commands"] == 1


@pytest.mark.only("slcan")
def test_garbage_on_the_line_is_survived(start, connect):
    emulator = start()
    client = connect(emulator)
    client.newest("SERVO_Position")
    port = client.bus.serialPortOrig
    noise = [b"t100", b"t1004", b"t10041", b"t1009" + b"0" * 18, b"tXYZ40000\r", b"T100400000000", b"\x00\xff\xfe\x80",
             b"\a\a\a", b"\n\n", b"t" * 5000, b"hello, world", bytes(range(14, 256)), b"S9", b"Z7", b"t8001FF", b"x"]
    for line in noise:
        port.write(line + b"\r")
    client.send_p1(STEP_P1_PSI)
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    result = emulator.stop()
    assert result.count["commands"] == 1
    assert result.buses[0]["malformed"] >= len(noise) - 2  # of the bells and newlines none needs to be


# --- Begin and end ---------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT])
def test_last_frame_says_stopped(start, connect, how):
    emulator = start()
    client = connect(emulator)
    client.newest("SERVO_Position")
    client.send_p1(STEP_P1_PSI)
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    emulator.signal(how)
    frames = client.until_ended()
    result = emulator.wait()  # exit status and verdict are judged there
    assert frames and frames[-1].name == "SERVO_Status" and frames[-1]["Mode"] == STOPPED
    assert frames[-1]["LateTicks"] == result.late_ticks


def test_late_ticks_make_the_run_invalid(start, connect):
    """An emulator that was held up says so for good, and has lost neither simulated time nor phase."""
    emulator = start()
    client = connect(emulator)
    before = int(client.newest("SERVO_Position")["Tick"])
    emulator.signal(signal.SIGSTOP)
    let_time_pass(0.3)
    emulator.signal(signal.SIGCONT)
    client.newest("SERVO_Position", lambda f: f["Tick"] > before + 3000)
    frames = [*client.for_ticks(2000), client.newest("SERVO_Status"), client.newest("SERVO_Status")]
    assert {tick % (10 * TICKS_PER_MS) for tick in ticks_of(frames)} == {0}
    statuses = [frame for frame in frames if frame.name == "SERVO_Status"]
    assert {frame["TimingValid"] for frame in statuses} == {0}
    assert statuses[-1]["LateTicks"] >= 2900
    result = emulator.stop(may_be_late=True)
    assert result.status == NOT_VALID and result.late_ticks >= statuses[-1]["LateTicks"]


def test_no_burst_of_the_past_after_a_hold_up(start, connect):
    """After a delay the bus gets the present: of 30 positions that fell due meanwhile, the last ones."""
    emulator = start()
    client = connect(emulator)
    client.newest("SERVO_Position")
    emulator.signal(signal.SIGSTOP)
    let_time_pass(0.3)
    before = ticks_of(client.frames_so_far())[-1:] or [0]
    emulator.signal(signal.SIGCONT)
    frames = client.until(lambda f: f.name == "SERVO_Position" and f["Tick"] > before[0] + 3000)
    assert len(ticks_of(frames)) <= 5
    emulator.stop(may_be_late=True)


def test_duration_ends_the_run(start):
    result = start("--duration", "0.5").wait()
    assert result.ticks == 5000 and "0.5000 s simulated" in result.text


def test_missing_interface():
    try:
        socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
        helps = "sudo ip link add dev vcan7 type vcan"
    except OSError:
        helps = "--can slcan:pty"
    done = run("run", "--can", "socketcan:vcan7", "--duration", "0.1", status=ENVIRONMENT)
    errors = [line for line in done.stderr.splitlines() if not line.startswith("servohil: info: ")]
    assert len(errors) == 1 and done.stdout == ""
    assert helps in errors[0]


def test_auto_takes_the_kernels_interface_or_a_terminal():
    with Emulator(["auto"], *settings(can__interfaces='["vcan0"]')) as emulator:
        there = Path("/sys/class/net/vcan0").exists()
        assert emulator.urls[0] == "socketcan:vcan0" if there else emulator.urls[0].startswith("slcan:/dev/pts/")
        assert "looked for vcan0" in emulator.log()
        emulator.stop()


def test_missing_device():
    done = run("run", "--can", "slcan:/dev/ttyNONE", "--duration", "0.1", status=ENVIRONMENT)
    errors = [line for line in done.stderr.splitlines() if not line.startswith("servohil: info: ")]
    assert len(errors) == 1 and "/dev/ttyNONE" in errors[0]


def test_stand_in_governor(start, tmp_path):
    """tools/governor.py, an independent client with its own reading of the DBC file."""
    steady = json.loads(run("steady", "--p1", STEP_P1_PSI, "--json").stdout)
    emulator = start()
    out = tmp_path / "out.csv"
    done = subprocess.run([sys.executable, REPOSITORY / "tools" / "governor.py", "--can", emulator.urls[0], "--duration",
                           "1.2", "-o", out, "step", str(REST_P1_PSI), str(STEP_P1_PSI), "--at", "0.2", "--last", "0.2"],
                          capture_output=True, text=True, timeout=60)
    result = emulator.stop()
    assert done.returncode in (0, result.status) and not done.stderr, done
    assert "RUNNING" in done.stdout
    rows = list(csv.DictReader(out.open()))
    assert float(rows[0]["x3_in"]) == 4.0
    assert float(rows[-2]["x3_in"]) == pytest.approx(steady["x3_in"], abs=0.0002)
    assert float(rows[-2]["p3_psi"]) == pytest.approx(steady["p3_psi"], abs=0.02)
    assert 20 < result.count["commands"] <= 121  # one every 10 ms; fewer on a machine that has no time


def test_stand_in_governor_alone(start, connect):
    """Nobody answers: one line, exit status 3."""
    emulator = start(*settings(publish__position_ms=0, publish__pressures_ms=0, publish__relay_ms=0,
                               publish__status_ms=0, publish__bus_ms=0, publish__safety_ms=0))
    done = subprocess.run([sys.executable, REPOSITORY / "tools" / "governor.py", "--can", emulator.urls[0], "hold", "30"],
                          capture_output=True, text=True, timeout=60)
    assert done.returncode == 3
    assert re.fullmatch(r"governor\.py: nothing came back for 2 s: does servohil run on this bus.*\n", done.stderr)


@pytest.mark.parametrize("arguments, status, says", [
    (["hold", "30"], 2, "which bus? --can URL"),
    (["--can", "slcan:pty", "hold", "30"], 2, "is for the emulator"),
    (["--can", "telepathy:0", "hold", "30"], 2, "no interface 'telepathy'"),
    (["--can", "slcan:/dev/ttyNONE", "hold", "30"], 3, "/dev/ttyNONE"),
    (["--can", "socketcan:vcan7", "hold", "30"], 3, "sudo ip link add dev vcan0 type vcan"),
    (["--can", "slcan:/dev/ttyNONE", "hold", "301"], 2, "0 to 300 psi"),
    (["--can", "slcan:/dev/ttyNONE", "step", "30"], 2, "required: TO"),
    (["--can", "slcan:/dev/ttyNONE", "hold", "30", "--dbc", "/gone.dbc"], 2, "/gone.dbc: No such file"),
    (["--can", "slcan:/dev/ttyNONE", "hold", "30", "--dbc", __file__], 2, "no message GOV_Command"),
])
def test_stand_in_governor_mistakes(arguments, status, says):
    done = subprocess.run([sys.executable, REPOSITORY / "tools" / "governor.py", *arguments], capture_output=True,
                          text=True, timeout=60)
    assert done.returncode == status and done.stdout == ""
    assert done.stderr.startswith("governor.py: ") and done.stderr.count("\n") == 1 and says in done.stderr


# --- What the kernel's CAN has alone ---------------------------------------------------------------------------------

def ip(*arguments):
    subprocess.run(["ip", "link", "set", "vcan0", *arguments], check=True)


@pytest.fixture
def interface_up_again():
    yield
    ip("up")


@pytest.mark.only("socketcan")
def test_interface_goes_down_and_up(start, connect, interface_up_again):
    emulator = start()
    client = connect(emulator)
    before = int(client.newest("SERVO_Position")["Tick"])
    client.close()
    ip("down")
    let_time_pass(0.5)
    ip("up")
    client.open()
    frames = client.for_ticks(1000)
    assert ticks_of(frames)[0] >= before + 5000
    client.send_p1(STEP_P1_PSI)
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    result = emulator.stop()
    assert result.buses[0]["dropped (not connected)"] > 0
    assert result.count["commands"] == 1


@pytest.mark.only("socketcan")
def test_can_utils_as_peers(start, connect):
    emulator = start()
    dump = subprocess.run(["candump", "-L", "-n", "50", "vcan0"], capture_output=True, text=True, check=True, timeout=60)
    assert {re.fullmatch(r"\(\d+\.\d+\) vcan0 (\w{3})#\w{16}", line)[1] for line in dump.stdout.splitlines()} <= {
        "200", "201", "202", "203", "204", "205"}
    client = connect(emulator)
    # 30.533 psi = 30533 x 0.001 = 0x7745, bits 12 to 31; counter 5; checksum 0: 00 55 74 07
    subprocess.run(["cansend", "vcan0", "100#00557407"], check=True, timeout=60)
    pressures = client.newest("SERVO_Pressures", lambda f: f["P1_Applied"] > 30.5)
    assert pressures["P1_Applied"] == pytest.approx(STEP_P1_PSI, abs=rounding(0.005))
    assert emulator.stop().count["commands"] == 1


@pytest.mark.only("socketcan")
def test_flood_of_foreign_frames(start, connect):
    """The kernel's filter keeps them out: nothing overflows, and commands still count."""
    emulator = start()
    client = connect(emulator)
    client.newest("SERVO_Position")
    client.close()
    for flood in (["-I", "123"], ["-e"], ["-I", "101", "-R"]):
        subprocess.run(["cangen", "vcan0", "-g", "0", "-n", "5000", "-i", *flood], check=True, timeout=60)
    client.open()
    client.send_p1(STEP_P1_PSI)
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    result = emulator.stop()
    assert result.count["commands"] == 1 and result.count["of other ids"] == 0
    assert result.buses[0]["receive overflows"] == 0
    assert result.buses[0]["dropped (queue full)"] == 0

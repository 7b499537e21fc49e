"""The control socket: whoever misbehaves there, the run goes on and the others are answered; and `servohil fault`,
`servohil status` over it."""

import json
import os
import random
import re
import signal
import socket
import stat
import subprocess

import pytest

from control_socket import Control
from emulator import (CONFIGURATION, ENVIRONMENT, NOT_VALID, OK, PROGRAM, RUNNING, USAGE, Emulator, run,
                      settings)

LOCKSTEP = ("--clock", "lockstep")
TICKS = 100  # per command in lockstep
REST_P1_PSI = 30.263


@pytest.fixture
def path(tmp_path):
    return tmp_path / "control.sock"


@pytest.fixture
def emulator(start, path):
    """Runs in real time with a control socket of its own."""
    return start("--control", path)


def goes_on(path):
    """Somebody else's questions and requests are answered, by the watching thread and by the simulation."""
    with Control(path) as other:
        before = other.ask("status", id=7)
        assert before["result"] == "OK" and before["id"] == 7
        assert other.inject("hot_oil") > 0 and other.clear("hot_oil") > 0
        assert other.ask("faults")["faults"] == []


def fault(*arguments, path, status=OK):
    """`servohil fault`: its output; what it complains of in one line."""
    done = run("fault", *arguments, "--control", path, status=status)
    if status == OK:
        assert done.stderr == ""
        return done.stdout
    assert done.stdout == "" and done.stderr.count("\n") == 1 and done.stderr.startswith("servohil: ")
    return done.stderr


# --- Clients that misbehave ------------------------------------------------------------------------------------------

def test_the_socket_is_for_user_and_group_and_goes_with_the_run(emulator, path):
    mode = path.lstat().st_mode
    assert stat.S_ISSOCK(mode) and stat.S_IMODE(mode) == 0o660
    emulator.stop()
    assert not path.exists()


@pytest.mark.parametrize("line", [
    b"hello", b"{", b"\x00\xff\xfe", b"[]", b"null", b"7", b'"status"', b"{}", b'{"request": 7}',
    b'{"request": "state"}',
    b'{"request": "inject"}', b'{"request": "inject", "fault": null}', b'{"request": "inject", "fault": {"a": []}}',
    b'{"request": "inject", "fault": "stiction", "parameters": [1]}',
    b'{"request": "inject", "fault": "stiction", "parameters": {"psi": "5"}}',
    b'{"request": "inject", "fault": "stiction", "parameters": {"psi": 1e999}}',
    b'{"request": "inject", "fault": "stiction", "parameters": {"psi": -1}}',
    b'{"request": "inject", "fault": "stiction", "parameters": {"for_s": 1e300}}',
    b'{"request": "clear", "fault": 3}', b'{"request": "clear", "fault": "stiction"}',
    b'{"request": "command"}', b'{"request": "command", "p1_psi": 301}', b'{"request": "command", "p1_psi": null}',
    b'{"request": "subscribe"}', b'{"request": "subscribe", "every_ms": 0}', b'{"request": "subscribe", "every_ms": 1e9}',
    b'{"request": "subscribe", "every_ms": 10, "quantities": "x3_in"}',
    b'{"request": "subscribe", "every_ms": 10, "quantities": ["x3"]}',
    b'{"request": "subscribe", "every_ms": 10, "quantities": [null]}',
    b"[" * 4000, b'{"a":' * 800, b'{"id": "' + b"x" * 4000 + b'"}', b"x" * 4096,
])
def test_each_line_is_answered_with_a_reason(emulator_for_lines, line):
    with Control(emulator_for_lines) as client:
        client.write(line + b"\n")
        answer = client.answer()
        assert answer["result"] == "REJECTED" and 0 < len(answer["reason"]) < 300
        assert client.ask("status")["result"] == "OK", "the connection goes on"


@pytest.fixture(scope="module")
def emulator_for_lines(tmp_path_factory):
    path = tmp_path_factory.mktemp("control") / "control.sock"
    with Emulator(["slcan:pty"], "--control", path) as emulator:
        yield path
        emulator.stop()


def test_a_reason_names_what_is_wrong_and_what_would_be_right(emulator_for_lines):
    with Control(emulator_for_lines) as client:
        for request, says in (
                ({"request": "statsu"}, "did you mean status?"),
                ({"request": "inject", "fault": "stictoin"}, "did you mean stiction?"),
                ({"request": "inject", "fault": "stiction", "parameters": {"pis": 5}}, "did you mean psi?"),
                ({"request": "inject", "fault": "stiction", "parameters": {"psi": 401}}, "from 0 to 400 psi"),
                ({"request": "inject", "fault": "gas_charge_lost"}, "stabilizer.enabled is false"),
                ({"request": "command", "p1_psi": -0.1}, "from 0 to 300 psi")):
            answer = client.ask(**request)
            assert answer["result"] == ("UNSUPPORTED" if "stabilizer" in says else "REJECTED"), answer
            assert says in answer["reason"]


@pytest.mark.parametrize("size", [5000, 100_000])
def test_an_endless_line_ends_its_client_alone(emulator, path, size):
    with Control(path) as client:
        try:
            client.write(b"x" * size + b"\n" + b'{"request": "status"}\n')
        except (BrokenPipeError, ConnectionResetError):
            pass  # closed already
        answer = client.answer()
        assert answer["result"] == "REJECTED" and "4096" in answer["reason"]
        assert client.answer() is None
    goes_on(path)
    emulator.stop()


def test_a_line_may_end_with_the_connection(emulator, path):
    """As `printf '{"request":"status"}' | nc -NU` sends it: without a line end."""
    for request in ({"id": 1, "request": "status"}, {"id": 1, "request": "command", "p1_psi": 30.0}):
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(str(path))
            client.sendall(json.dumps(request).encode())
            client.shutdown(socket.SHUT_WR)
            answer = b"".join(iter(lambda: client.recv(4096), b""))
        assert json.loads(answer)["result"] in ("OK", "APPLIED")


def test_half_lines_wait_for_their_end(emulator, path):
    with Control(path) as client:
        client.write(b'{"request": "sta')
        goes_on(path)
        client.write(b'tus", "id": 1}\n{"request": "faults", "id": 2}\n\n{"request": "ca')
        assert [client.answer()["id"] for _ in range(2)] == [1, 2]
        client.write(b'talogue", "id": [3, {"a": null}]}\n')
        answer = client.answer()
        assert answer["id"] == [3, {"a": None}] and len(answer["catalogue"]) > 20
    emulator.stop()


def test_requests_without_an_id_are_answered_in_order(emulator, path):
    with Control(path) as client:
        client.write(b'{"request": "inject", "fault": "hot_oil"}\n{"request": "clear"}\n')
        ticks = [client.answer()["tick"] for _ in range(2)]
        assert ticks == sorted(ticks)
    emulator.stop()


def test_who_ends_its_requests_still_gets_its_answers(emulator, path):
    """As `printf ... | nc -NU` does: half of the connection is closed before the simulation has answered."""
    with Control(path) as client:
        client.write(b'{"request": "inject", "fault": "hot_oil", "id": 1}\n{"request": "clear", "id": 2}\n')
        client.socket.shutdown(socket.SHUT_WR)
        assert [client.answer()["id"] for _ in range(2)] == [1, 2]
        assert client.answer() is None
    emulator.stop()


def test_twenty_clients(emulator, path):
    """Sixteen are served; the others are told so, and find room once one has gone."""
    clients = [Control(path) for _ in range(20)]
    served = []
    for number, client in enumerate(clients):
        try:
            answer = client.ask("status", id=number)
        except (BrokenPipeError, ConnectionResetError):
            answer = None
        if answer and answer["result"] == "REJECTED":
            assert answer["reason"] == "16 clients are connected already"
        elif answer:
            assert answer["id"] == number
            served.append(client)
    assert served == clients[:16]
    for client in served[:2]:
        client.close()
    goes_on(path)
    assert all(client.ask("status")["result"] == "OK" for client in served[2:])
    for client in clients:
        client.close()
    emulator.stop()


def test_a_client_that_never_reads(emulator, path):
    """It is cut off once too much waits for it; nobody else notices."""
    with Control(path) as deaf:
        deaf.socket.settimeout(0.5)
        request = b'{"request": "catalogue"}\n' * 100
        try:
            while True:  # until cut off: one answer is longer than 8 KB
                deaf.write(request)
                goes_on(path)
        except (BrokenPipeError, ConnectionResetError):
            pass
    goes_on(path)
    emulator.stop()


def test_a_client_that_half_closes_and_never_reads(start, connect, path):
    """Waits for nothing but room: the watching thread sleeps meanwhile, as the CPU time of the process shows."""
    emulator = start("--control", path, *LOCKSTEP)  # nothing else computes
    with Control(path) as deaf:
        deaf.write(b'{"request": "catalogue"}\n' * 30)
        deaf.socket.shutdown(socket.SHUT_WR)
        goes_on(path)
        before = cpu_time_s(emulator.process_id)
        with Emulator(["slcan:pty"], "--rt", "off", "--control", "none", "--duration", "1") as clock:
            clock.wait(may_be_late=True)
        assert cpu_time_s(emulator.process_id) - before < 0.5
    emulator.stop()


def cpu_time_s(process):
    with open(f"/proc/{process}/stat") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100


def test_clients_that_vanish(emulator, connect, path):
    """In the middle of a line, of an answer, with a request that the simulation has still to answer; at random."""
    chance = random.Random(5)
    for _ in range(200):
        client = Control(path)
        client.write(chance.choice([b"", b'{"request": "sta', b'{"request": "catalogue"}\n' * 5,
                                    b'{"request": "inject", "fault": "hot_oil"}\n' * 3, b'{"request": "clear"}\n',
                                    bytes(chance.randrange(256) for _ in range(50))]))
        if chance.random() < 0.2:
            client.socket.shutdown(chance.choice([socket.SHUT_RD, socket.SHUT_WR, socket.SHUT_RDWR]))
        client.close()
    connect(emulator).for_ticks(1000)  # until their last requests are served
    with Control(path) as client:
        client.clear()
    goes_on(path)
    emulator.stop()


def test_many_requests_at_once_are_all_answered(emulator, path):
    """More than the simulation takes at once: the rest is refused, not lost."""
    with Control(path) as client:
        client.write(b'{"request": "inject", "fault": "hot_oil"}\n' * 300)
        answers = [client.answer() for _ in range(300)]
        assert {a["result"] for a in answers} <= {"APPLIED", "REJECTED"}
        assert {a["reason"] for a in answers if a["result"] == "REJECTED"} <= {"too many requests wait already"}
        assert sum(a["result"] == "APPLIED" for a in answers) >= 60
    goes_on(path)
    emulator.stop()


# --- Whose socket it is ----------------------------------------------------------------------------------------------

def test_the_socket_of_a_killed_run_is_replaced(start, path):
    killed = start("--control", path)
    killed.signal(signal.SIGKILL)
    killed.__exit__()
    assert path.is_socket()
    emulator = start("--control", path)
    goes_on(path)
    emulator.stop()


def test_a_second_run_goes_without_or_refuses(start, path, tmp_path):
    """The default one is a convenience, one that is asked for a promise."""
    environment = {"XDG_RUNTIME_DIR": str(tmp_path), "PATH": "/usr/bin:/bin"}
    default = tmp_path / "servohil.sock"
    with Emulator(["slcan:pty"], env=environment) as first, Emulator(["slcan:pty"], env=environment) as second:
        assert f"control socket: {default}" in first.log()
        assert "no control socket: " in second.log() and f"{default}: another servohil has this" in second.log()
        goes_on(default)
        second.stop()
        goes_on(default)
        done = run("run", "--can", "slcan:pty", "--control", default, "--duration", 0.1, status=ENVIRONMENT)
        errors = [line for line in done.stderr.splitlines() if not line.startswith("servohil: info: ")]
        assert len(errors) == 1 and str(default) in errors[0] and "--control" in errors[0]
        first.stop()


def test_a_place_where_no_socket_can_be(tmp_path):
    file = tmp_path / "a-file"
    file.write_text("somebody's")
    for path, status in ((tmp_path / "gone" / "control.sock", ENVIRONMENT), (file, ENVIRONMENT),
                         (tmp_path / ("x" * 120), USAGE)):
        done = run("run", "--can", "slcan:pty", "--control", path, "--duration", 0.1, status=status)
        errors = [line for line in done.stderr.splitlines() if not line.startswith("servohil: info: ")]
        assert len(errors) == 1 and str(path) in errors[0]
    assert file.read_text() == "somebody's"


def test_nobody_there(tmp_path):
    path = tmp_path / "nobody.sock"
    for words in (("fault", "inject", "stiction"), ("fault", "clear", "--all"), ("status",), ("fault", "list")):
        done = run(*words, "--control", path, status=ENVIRONMENT)
        assert done.stderr.count("\n") == 1 and str(path) in done.stderr and "servohil run" in done.stderr


# --- servohil fault, servohil status ---------------------------------------------------------------------------------

def test_inject_list_clear(emulator, connect, path):
    client = connect(emulator)
    client.newest("SERVO_Status", lambda f: f["ActiveFaults"] == 0)
    told = fault("inject", "stiction", "psi=12.5", path=path)
    assert re.fullmatch(r"APPLIED: stiction from tick \d+ \(\d+\.\d{4} s\) on\n", told)
    client.newest("SERVO_Status", lambda f: f["ActiveFaults"] == 1)
    fault("inject", "hot_oil", path=path)
    fault("inject", "stiction", "psi=5", path=path)  # takes the place of the first
    client.newest("SERVO_Status", lambda f: f["ActiveFaults"] == 2)
    listed = fault("list", path=path)
    assert re.findall(r"^  (\w+) .*\*\* injected, 100 % \*\*$", listed, re.M) == ["hot_oil", "stiction"]
    with Control(path) as control:
        assert {f["fault"]: f["parameters"] for f in control.ask("faults")["faults"]} == {
            "hot_oil": {"temperature_c": 80.0}, "stiction": {"psi": 5.0}}
    assert fault("clear", "hot_oil", path=path).startswith("APPLIED: cleared from tick ")
    client.newest("SERVO_Status", lambda f: f["ActiveFaults"] == 1)
    assert "not injected" in fault("clear", "hot_oil", path=path, status=USAGE)
    fault("clear", "--all", path=path)
    client.newest("SERVO_Status", lambda f: f["ActiveFaults"] == 0)
    assert "injected" not in fault("list", path=path)
    emulator.stop()


def test_every_fault_is_shown_as_the_run_knows_it(emulator_for_lines):
    with Control(emulator_for_lines) as control:
        catalogue = control.ask("catalogue")["catalogue"]
    listed = run("fault", "list", "--control", emulator_for_lines).stdout
    assert re.findall(r"^  (\w+)", listed, re.M) == [one["fault"] for one in catalogue]
    for one in catalogue[::4]:  # some of each part
        shown = run("fault", "show", one["fault"]).stdout
        assert shown.startswith(f"{one['fault']} ({one['part']})\n  {one['effect']}\n")
        for p in one["parameters"]:
            told = re.escape(f"{p['meaning']}; {p['minimum']:g} to {p['maximum']:g}")
            assert re.search(rf"^  {p['name']} +{told}.*default {p['default']:g}$", shown, re.M), p


def test_status_agrees_with_the_bus(start, connect, path):
    emulator = start("--control", path, *LOCKSTEP)
    client = connect(emulator)
    client.send_p1(31.0)
    answer = client.until(lambda f: f.name == "SERVO_Status")
    told = json.loads(run("status", "--json", "--control", path).stdout)
    assert told["tick"] == answer[0]["Tick"] == TICKS
    assert told["mode"] == "RUNNING" and answer[-1]["Mode"] == RUNNING
    assert told["x3_in"] == pytest.approx(answer[0]["X3"], abs=0.0001)
    assert told["p3_psi"] == pytest.approx(answer[1]["P3"], abs=0.005)
    assert told["p1_psi"] == 31.0 and told["timing_valid"] is True and told["active_faults"] == 0
    emulator.stop()


@pytest.mark.parametrize("words, says", [
    (("inject", "stictoin"), "did you mean stiction?"),
    (("inject", "stiction", "psj=5"), "did you mean psi?"),
    (("inject", "stiction", "psi=401"), "psi = 401: must be a number from 0 to 400 psi"),
    (("inject", "stiction", "psi=-1"), "from 0 to 400 psi"),
    (("inject", "stiction", "psi"), "NAME=VALUE"),
    (("inject", "stiction", "psi=5psi"), "psi = 5psi: must be a number from 0 to 400 psi"),
    (("inject", "stiction", "psi=nan"), "psi"),
    (("inject", "stiction", "ramp_s=-1"), "ramp_s"),
    (("inject", "stiction", "fraction=0.1"), "stiction has no parameter fraction; there are psi, at_s, ramp_s"),
    (("inject", "stabilizer_isolated"), "UNSUPPORTED: stabilizer_isolated: stabilizer.enabled is false"),
    (("inject", "sensor_offset"), "signal is missing"),
    (("inject", "sensor_offset", "signal=x4_inch"), "there is no quantity x4_inch; did you mean x4_in?"),
    (("inject", "tx_lost", "message=SERVO_Positon"), "did you mean SERVO_Position?"),
    (("inject", "tx_lost", "signal=x3"), "tx_lost has no parameter signal; there are probability, message, seed"),
    (("inject", "stiction", "--when", "x3 >"), "expected QUANTITY > NUMBER"),
    (("inject", "stiction", "--when", "x3_im > 5"), "there is no quantity x3_im; did you mean x3_in?"),
    (("inject", "stiction", "--when", "late_ticks > 5"), "late_ticks is the machine's doing"),
    (("inject", "stiction", "--when-frame", "0x20000000"), "from 0 to 0x1FFFFFFF"),
    (("inject", "stiction", "--when-fault", "coldoil"), "did you mean cold_oil?"),
    (("inject", "stiction", "--when", "x3 > 5", "--when-frame", "1"), "only one of when, when_frame and when_fault"),
    (("inject", "stiction", "--duty", "0.5"), "duty: needs every_s"),
    (("inject", "stiction", "--every", "1", "--duty", "1.5"), "duty = 1.5: must be a number from 0 to 1"),
    (("inject", "stiction", "--every", "1", "ramp_out_s=0.6"), "each pulse and its ramp out must fit into it"),
    (("inject", "stiction", "--times", "3"), "times: needs every_s"),
    (("inject", "counter_stuck"), "UNSUPPORTED: counter_stuck: no published message has a counter: set e2e in [[can.publish]]"),
    (("clear", "sensor_offset", "signal=x9"), "there is no quantity x9"),
    (("clear", "stictoin"), "did you mean stiction?"),
    (("clear",), "--all"),
    (("clear", "stiction", "--all"), "--all"),
])
def test_mistakes_of_the_command_line(emulator_for_lines, words, says):
    assert says in fault(*words, path=emulator_for_lines, status=USAGE)


def test_show_knows_the_nearest_name():
    done = run("fault", "show", "air_entrainmnet", status=USAGE)
    assert done.stderr.count("\n") == 1 and "did you mean air_entrainment?" in done.stderr


def test_what_the_thesis_model_does_not_have_is_unsupported(start, path):
    emulator = start("--control", path, *settings(model__physics="thesis"))
    for name in ("air_entrainment", "stiction", "drain_back_pressure"):
        told = fault("inject", name, path=path, status=USAGE)
        assert f'UNSUPPORTED: {name}: model.physics = "thesis"' in told
    with Control(path) as control:
        unsupported = [one["fault"] for one in control.ask("catalogue")["catalogue"] if one["unsupported"]]
        assert {"air_entrainment", "stiction", "drain_back_pressure"} < set(unsupported)
    fault("inject", "bulk_modulus", path=path)
    emulator.stop()


def test_faults_that_are_not_armed(start, path):
    """A bus that may lead to a real machine is refused before: test_bus.py, can.allow_physical."""
    emulator = start("--control", path, *settings(fault__armed="no"))
    told = fault("inject", "stiction", path=path, status=USAGE)
    assert "REJECTED: faults are not armed: " in told and ("fault.armed" in told)
    emulator.stop()


# --- What people see of a run -----------------------------------------------------------------------------------------

def test_the_view_has_values_bars_faults_and_fits_80_columns(start, connect, path):
    emulator = start("--control", path, *LOCKSTEP)
    client = connect(emulator)
    client.send_p1(REST_P1_PSI)
    client.until(lambda f: f.name == "SERVO_Status")
    fault("inject", "stiction", "psi=5", path=path)
    view = run("status", "--control", path).stdout
    assert "\033" not in view and max(map(len, view.splitlines())) <= 80
    assert re.search(r"^servohil +RUNNING +t 0\.0 s \(tick 100\)$", view, re.M)
    assert re.search(r"^x3 +4(\.\d+)? in +\[#{20}-{20}\] 8$", view, re.M), "half of its stroke"
    assert re.search(r"^P3 +\d+(\.\d+)? psi +\[#+-+\] 300$", view, re.M)
    assert re.search(r"^fault +stiction +\d+ % psi=5", view, re.M) and "stroke_in" not in view
    emulator.stop()


def test_the_view_warns_of_late_ticks(emulator, path):
    emulator.pause(0.05)
    with Control(path) as control:
        while control.ask("status")["timing_valid"]:
            pass
    assert "warning    timing INVALID: " in run("status", "--control", path).stdout
    emulator.stop(may_be_late=True)


@pytest.mark.parametrize("terminal, redraws", [("xterm", True), ("dumb", False), (None, False)])
def test_watch_redraws_where_the_cursor_can_move(emulator, path, terminal, redraws):
    ours, theirs = os.openpty()
    watching = subprocess.Popen([PROGRAM, "status", "--watch", "--control", path],
                                stdout=theirs if terminal else subprocess.PIPE, env=dict(os.environ, TERM=terminal or "xterm"))
    os.close(theirs)
    source = ours if terminal else watching.stdout.fileno()
    seen = b""
    while seen.count(b"servohil ") < 3:
        seen += os.read(source, 4096)
    watching.send_signal(signal.SIGINT)
    watching.wait(20)
    os.close(ours)
    assert (b"\033[H" in seen) == redraws == (b"\033" in seen)


def test_watch_ends_with_the_run(emulator, path):
    watching = subprocess.Popen([PROGRAM, "status", "--watch", "--json", "--control", path], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)
    assert json.loads(watching.stdout.readline())["result"] == "OK"
    emulator.stop()
    assert watching.wait(20) == ENVIRONMENT and watching.stderr.read().count("\n") == 1


# --- Samples ---------------------------------------------------------------------------------------------------------

def test_samples_come_at_exactly_the_ticks_that_are_asked_for(start, connect, path):
    emulator = start("--control", path, *LOCKSTEP)
    client = connect(emulator)
    with Control(path) as fast, Control(path) as slow:
        assert fast.ask("subscribe", id="f", every_ms=2, quantities=["x3_in", "tick"])["result"] == "OK"
        assert slow.ask("subscribe", every_ms=7, quantities=["command_age_ms"])["result"] == "OK"
        for _ in range(3):  # 300 ticks
            step(client, 31.0)
        samples = [fast.answer() for _ in range(15)]
        assert [s["tick"] for s in samples] == list(range(20, 301, 20))
        assert all(s["id"] == "f" and s["result"] == "SAMPLE" and s["dropped"] == 0 for s in samples)
        assert samples[-1].keys() == {"id", "result", "tick", "time_s", "dropped", "x3_in"}
        assert samples[-1]["x3_in"] == fast.ask("status")["x3_in"]
        assert [slow.answer()["tick"] for _ in range(4)] == [70, 140, 210, 280]
        assert fast.ask("unsubscribe")["result"] == "OK"
        step(client)
        assert fast.ask("status")["tick"] == 400, "no sample before the answer"
    emulator.stop()


def test_a_subscriber_that_does_not_read_loses_samples_and_is_told(start, connect, path):
    emulator = start("--control", path, *LOCKSTEP, *settings(lockstep__ticks=2000))
    client = connect(emulator)
    with Control(path) as deaf:
        assert deaf.ask("subscribe", every_ms=1)["result"] == "OK"
        for _ in range(40):  # 8 s of simulated time: 8000 samples of some 500 bytes
            step(client)
        goes_on(path)
        sample = deaf.answer()
        while sample["dropped"] == 0:
            step(client)  # adds more than are read here, as far as there is room again
            for _ in range(20):
                last, sample = sample, deaf.answer()
                assert sample["dropped"] - last["dropped"] == (sample["tick"] - last["tick"]) // 10 - 1
    emulator.stop()


def test_statistics_are_those_of_the_file(emulator, path):
    with Control(path) as control:
        while (statistics := control.ask("statistics")["statistics"])["compute"]["count"] == 0:
            pass
    assert statistics["finished"] is False and statistics["wake_ticks"] == 10
    emulator.stop()


# --- Reload ----------------------------------------------------------------------------------------------------------

def test_hangup_reloads_what_may_change_and_tells_the_rest(start, path, tmp_path):
    for file in CONFIGURATION.parent.glob("*.*"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    configuration = tmp_path / "servohil.toml"
    emulator = start("--control", path, "--config", configuration)
    fault("inject", "hot_oil", path=path)
    text = configuration.read_text()

    def reload(text):
        """What is logged of it."""
        configuration.write_text(text)
        before = emulator.log().count("reload: ")
        emulator.signal(signal.SIGHUP)
        with Control(path) as control:
            while emulator.log().count("reload: ") == before:
                assert control.ask("status")["result"] == "OK", "the run goes on"
        return emulator.log()

    assert "reload: nothing has changed" in reload(text)
    assert "reload: nothing is changed: " in reload(text + "\n[broken\n")
    told = reload(text.replace('armed = "auto"', 'armed = "no"').replace("stroke_in = 8.0", "stroke_in = 9.0"))
    assert 'reload: fault.armed = "no" from now on, was "auto"' in told
    with Control(path) as control:  # asked after the whole reload
        assert control.ask("status")["stroke_in"] == 8.0
    assert "reload: servo.stroke_in = 9 in: needs a restart; it runs with 8 in" in emulator.log()
    assert "faults are not armed" in fault("inject", "stiction", path=path, status=USAGE)
    emulator.stop()


# --- What a fault does, tick by tick ---------------------------------------------------------------------------------

def step(client, p1_psi=REST_P1_PSI):
    """One command in lockstep; the answer's frames by name."""
    client.send_p1(p1_psi)
    return {f.name: f for f in client.until(lambda f: f.name == "SERVO_Status")}


def test_a_fault_begins_ramps_and_ends_at_its_ticks(start, connect, path):
    emulator = start("--control", path, *LOCKSTEP)
    client = connect(emulator)
    step(client)
    told = fault("inject", "supply_sag", "depth_psi=100", "ramp_s=0.02", "for_s=0.03", "--at", "0.02", path=path)
    assert told == "APPLIED: supply_sag from tick 201 (0.0201 s) on\n"
    active, shares, supply = [], [], []
    with Control(path) as control:
        for _ in range(8):
            active.append(int(step(client)["SERVO_Status"]["ActiveFaults"]))
            shares.append([f["share"] for f in control.ask("faults")["faults"]])
            supply.append(control.ask("status")["p2_psi"])
    #                ticks: 200   300    400    500    600    700  800  900; begins to fall at 501, over at 701
    assert active == [0, 1, 1, 1, 1, 0, 0, 0]
    assert shares == [[0.0], [0.5], [1.0], [1.0], [0.5], [0.0], [], []]
    assert supply == [300.0, 250.0, 200.0, 200.0, 250.0, 300.0, 300.0, 300.0]
    emulator.stop()


def test_a_fault_in_the_past_begins_now(start, connect, path):
    emulator = start("--control", path, *LOCKSTEP)
    client = connect(emulator)
    step(client)
    assert "from tick 101 " in fault("inject", "hot_oil", "--at", "0", path=path)
    assert step(client)["SERVO_Status"]["ActiveFaults"] == 1
    emulator.stop()


def hash_of(start, connect, path, disturb=lambda control: None, steps=30):
    """Of a lockstep run with friction, at rest in its first half, then moved; `disturb` acts after the first step."""
    emulator = start("--control", path, *LOCKSTEP, *settings(friction__coulomb_psi=3))
    client = connect(emulator)
    step(client)
    with Control(path) as control:
        disturb(control)
    for number in range(1, steps):
        last = step(client, REST_P1_PSI if number < steps // 2 else REST_P1_PSI + 0.1 * (number % 5))
    assert last["SERVO_Status"]["ActiveFaults"] == 0
    client.close()
    result = emulator.stop()
    assert result.ticks == steps * TICKS and result.status == OK
    return result.hash


def test_cleared_faults_leave_no_trace(start, connect, path):
    """Injected and cleared between two ticks, each fault that there is: to the last bit the run that never had one. One
    that acts for a while does leave a trace, or else this would show nothing."""
    unfaulted = hash_of(start, connect, path)

    def inject_and_clear_all(control):
        for one in control.ask("catalogue")["catalogue"]:
            if not one["unsupported"]:
                control.inject(one["fault"], **({"signal": "x3"} if "signal" in one["common"] else {}))
                if len(control.ask("faults")["faults"]) == 8:
                    control.clear()
        control.clear()

    def inject_for_a_while(control):
        control.inject("load_step", psi=20.0, for_s=0.01)

    assert hash_of(start, connect, path, inject_and_clear_all) == unfaulted
    assert hash_of(start, connect, path, inject_for_a_while) != unfaulted


def test_a_cleared_fault_that_acted_gives_the_unfaulted_parameters_back(start, connect, path):
    """A jam while P1 rests: the piston, held by friction anyhow, does not move; once the jam is over, the run is that
    which never had one."""
    def jam(control):
        control.inject("piston_jammed", for_s=0.05)

    assert hash_of(start, connect, path, jam) == hash_of(start, connect, path)


# --- Frozen ----------------------------------------------------------------------------------------------------------

def test_requests_to_a_frozen_run_are_answered(start, connect, path, tmp_path):
    emulator = start("--control", path, "--snapshot-dir", tmp_path,
                     *settings(loop__overrun="freeze", loop__max_catch_up_ticks=300))
    client = connect(emulator)
    client.newest("SERVO_Position")
    emulator.pause(0.06)
    client.newest("SERVO_Status", lambda f: f["Mode"] == 4)
    with Control(path) as control:
        assert control.ask("status")["mode"] == "FROZEN"
        for request in ({"request": "inject", "fault": "hot_oil"}, {"request": "command", "p1_psi": 40.0},
                        {"request": "clear"}):
            answer = control.ask(**request)
            assert answer["result"] == "REJECTED" and "frozen" in answer["reason"]
        tick = control.snapshot()
    result = emulator.stop(may_be_late=True)
    assert result.status == NOT_VALID and result.ticks == tick
    assert json.loads((tmp_path / f"snapshot-{tick}.json").read_text())["content"]["state"]["tick"] == tick

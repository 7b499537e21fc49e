"""tools/servohil_ci, as its user sees it: pytest runs of small projects, judged by their JUnit file, exit status and
what the terminal says. Over every selected transport (conftest.py).

A run is made INVALID by stopping the emulator for 50 ms, and kept VALID on any machine by lockstep or by a start-up
grace of 60 s; so nothing here depends on how busy the machine is.
"""

import os
import re
import signal
import socket
import subprocess
import sys
import textwrap
import threading
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from emulator import CONFIGURATION, DBC, IN_GUEST, PATIENCE_S, PROGRAM, REPOSITORY, run
from hypothesis import given
from hypothesis import strategies as st

TOOLS = REPOSITORY / "tools"
EXAMPLE = TOOLS / "examples" / "ci"
sys.path.insert(0, str(TOOLS))

from servohil_ci.contract import TICK_MODULUS, Contract, attribute, unwrapped  # noqa: E402
from servohil_ci.control import Control  # noqa: E402
from servohil_ci.failure import Failure  # noqa: E402

PASSED, FAILED, USAGE_ERROR = 0, 1, 4  # exit statuses of pytest
INVALID_HELPERS = '''
    import os, signal, time
    import pytest

    GRACE = {"loop.grace_ms": 60000}

    def be_late(servohil):
        os.kill(servohil.process.pid, signal.SIGSTOP)
        os.waitid(os.P_PID, servohil.process.pid, os.WSTOPPED)
        time.sleep(0.05)  # how late; the machine can only make it more
        os.kill(servohil.process.pid, signal.SIGCONT)
        servohil.run_for(0.02)
'''


class Result:
    """A pytest run: exit status, output, and what the JUnit file says of each test."""

    def __init__(self, done, report):
        self.status, self.text = done.returncode, done.stdout + done.stderr
        self.cases = {}
        if report.exists():
            self.cases = {case.get("name"): case for case in ElementTree.parse(report).iter("testcase")}

    def kind(self, test):
        """passed, failure, error or skipped."""
        told = [child.tag for child in self.cases[test] if child.tag != "properties"]
        return told[0] if told else "passed"

    def message(self, test):
        return next(child.get("message") for child in self.cases[test] if child.tag != "properties")

    def full(self, test):
        return "\n".join(child.text for child in self.cases[test] if child.tag != "properties")

    def properties(self, test, name):
        return [p.get("value") for p in self.cases[test].iter("property") if p.get("name") == name]


@pytest.fixture
def project(url, tmp_path):
    """Runs pytest on a project of one file: project(source, options...) → Result."""

    def run_pytest(source, *options, program=PROGRAM, **files):
        folder = tmp_path / "project"
        folder.mkdir()
        (folder / "test_it.py").write_text(textwrap.dedent(source))
        for name, text in files.items():
            (folder / name.replace("__", ".")).write_text(text)
        return pytest_in(folder, tmp_path, f"--servohil-program={program}", f"--servohil-bus={url}",
                         *options)

    return run_pytest


def pytest_in(folder, tmp_path, *options, **environment):
    report = tmp_path / "report.xml"
    done = subprocess.run(
        ["/usr/bin/python3", "-m", "pytest", "-p", "servohil_ci.plugin", "-p", "no:cacheprovider", "-rA",
         f"--junitxml={report}", f"--basetemp={tmp_path / 'kept'}", *map(str, options)],
        cwd=folder, capture_output=True, text=True, timeout=120,
        env={**os.environ, "PYTHONPATH": str(TOOLS), "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "200", **environment})
    return Result(done, report)


def kept(tmp_path):
    return sorted(path.name for path in (tmp_path / "kept" / "servohil").glob("*"))


# --- The bench -------------------------------------------------------------------------------------------------------

def test_lockstep(project, tmp_path):
    result = project('''
        import pytest
        from servohil_ci.bench import Unmet
        from servohil_ci.failure import Failure

        HASHES = set()

        def test_state_is_the_answer(servohil):
            with pytest.raises(Failure, match="no state yet"):
                servohil.state()
            with pytest.raises(Failure, match="send_p1 first"):
                servohil.run_for(1)
            for cycle in range(1, 4):
                servohil.send_p1(30.263)
                state = servohil.state()
                assert state.tick == 100 * cycle and state["x3_in"] == state.x3_in == 4.0
                assert state.t_s == pytest.approx(0.01 * cycle)
            assert {"v3_in_s", "p1_applied_psi", "p8_psi", "x4_in", "sub_steps", "mode", "timing_valid",
                    "worst_lateness_ms", "command_age_ms"} < set(dict(state))
            assert type(state.mode) is int
            with pytest.raises(AttributeError, match="no signal x9_in; there are x3_in, "):
                state.x9_in

        def test_time_is_simulated(servohil):
            servohil.send_p1(30.533)
            trace = servohil.run_for(0.5)
            assert [state.tick for state in trace] == list(range(200, 5101, 100))
            assert trace[-1].x3_in > 4.1 and abs(trace[-1].v3_in_s) < 0.05
            assert servohil.wait_until(lambda state: state.x3_in > 4.1, timeout_s=0.0).tick == 5100
            with pytest.raises(Unmet, match="not met within 0.1 s of simulated time; last state: x3_in=4.1"):
                servohil.wait_until(lambda state: state.x3_in > 7, timeout_s=0.1)
            assert servohil.state().tick == 6100
            assert servohil.cycle(30.533).tick == 6200
            assert servohil.verdict is None
            outcome = servohil.stop()
            assert outcome.valid and servohil.verdict == "VALID" and servohil.state().tick == 6200
            assert servohil.stop() is outcome

        @pytest.mark.parametrize("again", [1, 2])
        def test_every_run_is_the_same(servohil, again):
            for cycle in range(50):
                servohil.send_p1(30.263 + 0.01 * (cycle % 7))
            HASHES.add(servohil.stop().hash)
            assert len(HASHES) == 1

        @pytest.mark.servohil(settings={"lockstep.sync_id": 0x80, "lockstep.ticks": 25})
        def test_sync_frames(servohil):
            servohil.send_p1(30.5)
            servohil.send_p1(30.6)
            assert servohil.state().tick == 50
            assert servohil.run_for(0.005)[-1].tick == 100

        @pytest.mark.servohil(settings={"publish.status_ms": 0, "publish.relay_ms": 0, "publish.safety_ms": 0})
        def test_answers_end_with_what_is_published(servohil):
            assert servohil.cycle(30.263).tick == 100
            assert servohil.cycle(30.533).p1_applied_psi == 30.535  # 0.005 psi or so
    ''')
    assert result.status == PASSED, result.text
    assert len(result.cases) == 6 and "6 passed" in result.text
    assert kept(tmp_path) == []


def test_real_time(project):
    result = project('''
        import pytest
        pytestmark = pytest.mark.servohil(clock="real", settings={"loop.grace_ms": 60000, "publish.position_ms": 5})

        def test_time_passes_by_itself(servohil):
            begin = servohil.state()
            assert begin.mode == 0 and begin.x3_in == 4.0 and begin.active_faults == 0
            ticks = [state.tick for state in servohil.run_for(0.1)]  # a busy machine leaves frames out
            assert ticks == sorted(set(ticks)) and all(tick % 50 == 0 for tick in ticks)
            assert begin.tick < ticks[0] and ticks[-1] >= begin.tick + 1000
            servohil.send_p1(30.533)
            state = servohil.wait_until(lambda state: state.x3_in > 4.1, timeout_s=10.0)
            assert state.p1_applied_psi == pytest.approx(30.533, abs=0.003)
            assert servohil.cycle(30.533).tick > state.tick

        @pytest.mark.servohil(settings={"start.x3_in": 5.0})
        def test_settings_of_module_and_function_add_up(servohil):
            assert servohil.state().x3_in == 5.0
            assert servohil.run_for(0.01)[0].tick % 50 == 0
    ''')
    assert result.status == PASSED, result.text


def test_where_options_come_from(project, url):
    """The marker beats the command line, which beats the ini file; files count from where they are named."""
    dbc = DBC.read_text().replace("BO_ 512 ", "BO_ 768 ").replace(" 512 ", " 768 ")
    ini = "[pytest]\nservohil_config = own.toml\nservohil_clock = real\nservohil_bus = nonsense\n"
    result = project(
        '''
        import pytest

        def test_ini_and_command_line(servohil):
            assert servohil.options.clock == "lockstep" and servohil.options.config.name == "own.toml"
            assert servohil.cycle(30.0).tick == 70

        @pytest.mark.servohil(clock="real", dbc="own.dbc", settings={"loop.grace_ms": 60000})
        def test_marker(servohil):
            assert servohil.options.clock == "real"
            assert servohil.contract.messages["SERVO_Position"].arbitration_id.id == 768
            assert servohil.state().x3_in == 4.0
        ''', "--servohil-clock=lockstep", own__dbc=dbc, pytest__ini=ini,
        own__toml=f'[lockstep]\nticks = 70\n[can]\ndbc = "{DBC}"\n[load]\nfile = "{DBC.parent}/load_curve.csv"\n')
    assert result.status == PASSED, result.text
    assert f"servohil: {PROGRAM}, {url}, clock lockstep" in result.text


# --- Failures and recordings -----------------------------------------------------------------------------------------

def test_recording_stays_with_a_failure_only(project, tmp_path):
    result = project('''
        def test_bad(servohil):
            servohil.send_p1(30.533)
            assert servohil.recording.is_dir()
            servohil.wait_until(lambda state: state.x3_in > 7, timeout_s=0.05)

        def test_good(servohil):
            servohil.send_p1(30.533)
    ''')
    assert result.status == FAILED and "1 failed, 1 passed" in result.text
    recording = Path(*result.properties("test_bad", "servohil_recording"))
    assert kept(tmp_path) == ["test_it-test_bad-1"]
    assert recording.parent == tmp_path / "kept" / "servohil" / "test_it-test_bad-1"
    assert f"recording: {recording}\n" in result.text and "verdict: VALID" in result.text
    assert "100#" in (recording / "bus.log").read_text() and (recording / "servohil.h5").is_file()
    assert "Unmet: not met within 0.05 s of simulated time; last state: x3_in=4.1" in result.message("test_bad")
    assert "bench.py" not in result.full("test_bad"), "the failure is shown where the test called"
    assert result.properties("test_good", "servohil_recording") == []


def test_crash_is_an_error_with_its_stderr(project):
    result = project('''
        import os, signal

        def test_while_it_waits(servohil):
            os.kill(servohil.process.pid, signal.SIGABRT)
            servohil.send_p1(30.0)
            servohil.run_for(1.0)

        def test_unnoticed(servohil):
            os.kill(servohil.process.pid, signal.SIGSEGV)

        def test_next_one_is_not_affected(servohil):
            servohil.send_p1(30.0)
    ''')
    assert result.status == FAILED and "1 failed, 2 passed, 2 errors" in result.text, result.text
    assert "servohil crashed: killed by SIGABRT" in result.message("test_while_it_waits")
    assert result.kind("test_unnoticed") == "error"
    assert "servohil crashed: killed by SIGSEGV\nservohil: info: bus load" in result.full("test_unnoticed")


def test_emulator_ends_with_a_killed_pytest(project):
    """Else it would answer on vcan0 to the next run's commands."""
    result = project('''
        import os, signal

        def test_it(servohil):
            print("emulator", servohil.process.pid, flush=True)
            os.kill(os.getpid(), signal.SIGKILL)
    ''', "-s")
    assert result.status == -signal.SIGKILL
    process = Path("/proc", re.search(r"emulator (\d+)", result.text)[1])
    deadline = time.monotonic() + PATIENCE_S
    while process.exists() and "(zombie)" not in (process / "status").read_text():
        assert time.monotonic() < deadline, "the emulator goes on"
        time.sleep(0.002)


MISTAKES = {
    "marker": ('@pytest.mark.servohil(clok="real")',
               "pytest.mark.servohil: 'clok' is none of config, settings, clock, dbc"),
    "settings": ("@pytest.mark.servohil(settings=3)", "pytest.mark.servohil: settings 3: expected a dictionary, e.g. "
                                                      '{"servo.underlap_in": 0.001}'),
    "clock": ('@pytest.mark.servohil(clock="fast")', "clock 'fast': expected lockstep or real"),
    "config": ('@pytest.mark.servohil(config="gone.toml")', "{project}/gone.toml: No such file or directory"),
    "dbc": ('@pytest.mark.servohil(dbc="gone.dbc")', "{project}/gone.dbc: No such file or directory"),
    "key": ('@pytest.mark.servohil(settings={"servo.gap": 1})',
            "servohil: --set servo.gap=1: unknown key servo.gap; `servohil run --help-keys` lists all"),
    "value": ('@pytest.mark.servohil(settings={"oil.air_fraction": 2})', "servohil: --set oil.air_fraction=2: "),
    "silence": ('@pytest.mark.servohil(settings={"publish.position_ms": 0})',
                "publish.position_ms = 0: without SERVO_Position there is no Tick to tell the time"),
}


def test_mistakes_in_a_test_are_told_in_one_line(project, tmp_path):
    tests = "\n".join(f"{marker}\ndef test_{name}(servohil): pass" for name, (marker, _) in MISTAKES.items())
    result = project("import pytest\n" + tests)
    assert result.status == FAILED
    for name, (_, says) in MISTAKES.items():
        text = result.full(f"test_{name}")
        assert text.startswith(says.replace("{project}", str(tmp_path / "project"))) and "\n" not in text, text


@pytest.mark.parametrize("options, says", [
    (("--servohil-program=/gone/servohil",), "--servohil-program /gone/servohil: there is no such file"),
    ((f"--servohil-program={DBC}",), f"{DBC}: cannot be run: Permission denied"),
    (("--servohil-bus=can0",), "bus 'can0': expected auto, socketcan:IFACE or slcan:pty"),
    (("--servohil-bus=socketcan:gone0",), "servohil: "),
])
def test_mistakes_on_the_command_line_are_told_in_one_line(project, options, says):
    result = project("def test_it(servohil): pass", *options)
    assert result.status == FAILED and result.kind("test_it") == "error"
    assert result.full("test_it").startswith(says) and "\n" not in result.full("test_it")


def test_missing_package_is_told_in_one_line(project, tmp_path):
    (tmp_path / "canmatrix.py").write_text("raise ImportError('No module named canmatrix')")
    result = pytest_in(tmp_path, tmp_path, PYTHONPATH=f"{tmp_path}:{TOOLS}")
    assert result.status == USAGE_ERROR and "Traceback" not in result.text
    assert "ERROR: servohil_ci: No module named canmatrix; it needs Python 3.11 and Debian's python3-can" in result.text


# --- INVALID ---------------------------------------------------------------------------------------------------------

def test_invalid_twice_is_neither_passed_nor_failed(project, tmp_path):
    result = project(INVALID_HELPERS + '''
    pytestmark = pytest.mark.servohil(clock="real")

    def test_that_would_pass(servohil, request):
        request.node.user_properties.append(("once", 1))
        be_late(servohil)

    def test_that_would_fail(servohil):
        be_late(servohil)
        assert servohil.state().x3_in > 7

    @pytest.mark.xfail
    def test_that_would_fail_as_expected(servohil):
        be_late(servohil)
        assert servohil.state().x3_in > 7

    def test_that_stops_it(servohil):
        be_late(servohil)
        assert not servohil.stop().valid and servohil.verdict.startswith("INVALID: ")

    @pytest.mark.servohil(settings={"loop.overrun": "stop", "loop.max_catch_up_ticks": 100})
    def test_whose_emulator_stops(servohil):
        be_late(servohil)
    ''')
    assert result.status == FAILED and "5 invalid" in result.text, result.text
    assert "passed" not in result.text.splitlines()[-1] and "failed" not in result.text.splitlines()[-1]
    for test in result.cases:
        assert result.kind(test) == "failure" and result.message(test).startswith("INVALID: timing: late ticks ")
        assert result.properties(test, "servohil_verdict") == ["INVALID"]
        assert f"test_it.py::{test}: INVALID: timing: " in result.text
        assert [Path(p).is_dir() for p in result.properties(test, "servohil_recording")] == [True, True]
    assert len(kept(tmp_path)) == 10
    assert result.properties("test_that_would_pass", "once") == ["1"]


def test_invalid_once_is_run_again(project, tmp_path):
    result = project(INVALID_HELPERS + '''
    pytestmark = pytest.mark.servohil(clock="real")
    ATTEMPTS = {}

    @pytest.fixture(autouse=True)
    def attempt(request):
        """1 for the first run of a test, 2 for its second, which has a grace."""
        number = ATTEMPTS[request.node.name] = ATTEMPTS.get(request.node.name, 0) + 1
        if number == 2:
            request.node.add_marker(pytest.mark.servohil(settings=GRACE))
        return number

    @pytest.fixture(scope="module")
    def module_wide():
        return []

    def test_then_passes(attempt, module_wide, servohil, tmp_path):
        assert not list(tmp_path.iterdir())
        (tmp_path / "left behind").touch()
        if attempt == 1:
            be_late(servohil)
            assert False, "says nothing"

    def test_then_fails(attempt, servohil):
        if attempt == 1:
            be_late(servohil)
        else:
            assert servohil.state().x3_in > 7

    @pytest.mark.servohil(settings=GRACE)
    def test_valid_at_once(attempt, servohil):
        assert attempt == 1
    ''')
    assert result.status == FAILED and "1 failed, 2 passed in" in result.text, result.text
    assert result.kind("test_then_passes") == "passed" and result.kind("test_then_fails") == "failure"
    assert "INVALID" not in result.message("test_then_fails")
    for test, outcome in (("test_then_passes", "passed"), ("test_then_fails", "failed")):
        assert result.properties(test, "servohil_rerun")[0].startswith("INVALID: timing: ")
        assert result.properties(test, "servohil_verdict") == []
        assert f"test_it.py::{test}: {outcome} when run again; the first run: INVALID: timing: " in result.text
    assert result.properties("test_valid_at_once", "servohil_rerun") == []
    assert kept(tmp_path) == ["test_it-test_then_fails-1", "test_it-test_then_fails-2"]


def test_lockstep_is_never_invalid(project):
    result = project(INVALID_HELPERS + '''
    def test_it(servohil):
        servohil.send_p1(30.533)
        be_late(servohil)
        assert servohil.stop().valid
    ''')
    assert result.status == PASSED and result.properties("test_it", "servohil_rerun") == [], result.text


def test_invalid_never_passes_unseen(project):
    """A fixture that is asked for by getfixturevalue is not known beforehand."""
    result = project(INVALID_HELPERS + '''
    @pytest.mark.servohil(clock="real")
    def test_it(request):
        be_late(request.getfixturevalue("servohil"))
    ''')
    assert result.status == FAILED and result.kind("test_it") == "error"
    assert result.full("test_it").startswith("INVALID: timing: ")


# --- Faults ----------------------------------------------------------------------------------------------------------

# servohil with a control socket that knows one fault: a stand-in.
STAND_IN = '''#!/usr/bin/python3
import ctypes, json, os, signal, socket, sys

program, arguments = {program!r}, sys.argv[1:]

def answer(request):
    if request["request"] == "inject" and request["fault"] == "plugged_orifice":
        return {{"result": "UNSUPPORTED"}}
    if request.get("fault", "air_entrainment") != "air_entrainment":
        return {{"result": "REJECTED", "reason": "no fault " + request["fault"] + "; there is air_entrainment"}}
    return {{"result": "APPLIED", "tick": 1234, "seen": request}}

if "--help" in arguments:
    print("  --control PATH  control socket", flush=True)
elif "--control" in arguments:
    at = arguments.index("--control")
    path = arguments[at + 1]
    del arguments[at:at + 2]
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(path)
    listener.listen()
    if os.fork() == 0:
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # ends with the program
        os.close(1)
        stream = listener.accept()[0].makefile("rw")
        for line in stream:
            request = json.loads(line)
            print(json.dumps({{"id": request["id"], **answer(request)}}), file=stream, flush=True)
        os._exit(0)
os.execv(program, [program, *arguments])
'''


def test_inject_and_clear(project, tmp_path):
    program = tmp_path / "stand-in"
    program.write_text(STAND_IN.format(program=str(PROGRAM)))
    program.chmod(0o755)
    result = project('''
        import pytest
        from servohil_ci.failure import Failure

        def test_it(servohil):
            assert servohil.can_inject
            answer = servohil.inject("air_entrainment", fraction=0.02, ramp_s=0.5, for_s=3)
            assert answer["tick"] == 1234
            assert answer["seen"] == {"id": 1, "request": "inject", "fault": "air_entrainment",
                                      "parameters": {"fraction": 0.02, "ramp_s": 0.5, "for_s": 3}}
            assert servohil.clear("air_entrainment")["seen"] == {"id": 2, "request": "clear",
                                                                 "fault": "air_entrainment"}
            assert servohil.clear()["seen"] == {"id": 3, "request": "clear"}
            with pytest.raises(Failure, match="^inject plugged_orifice: UNSUPPORTED$"):
                servohil.inject("plugged_orifice")
            servohil.send_p1(30.0)

        def test_bad_name(servohil):
            servohil.inject("air")
    ''', f"--servohil-config={CONFIGURATION}", program=program)
    assert result.kind("test_it") == "passed", result.text
    assert result.message("test_bad_name").endswith("inject air: REJECTED: no fault air; there is air_entrainment")


@pytest.mark.skipif("--control " not in run("run", "--help").stdout, reason="no `servohil run --control` yet")
def test_inject_for_real(project):
    result = project('''
        import pytest
        from servohil_ci.failure import Failure

        def fastest_in_s(servohil, active_faults):
            """Once the step is over: 0.3 s after it."""
            states = servohil.run_for(1.0)[30:]
            assert {state.active_faults for state in states} == {active_faults}
            return max(abs(state.v3_in_s) for state in states)

        def test_it(servohil):
            """Air makes the servomotor ring (some 10 in/s at 4 in) until it is gone."""
            servohil.send_p1(30.533)
            assert fastest_in_s(servohil, active_faults=0) < 0.1
            assert servohil.inject("air_entrainment", fraction=0.02, ramp_s=0.1)["tick"] >= servohil.state().tick
            servohil.send_p1(30.263)
            assert fastest_in_s(servohil, active_faults=1) > 1.0
            servohil.clear("air_entrainment")
            assert fastest_in_s(servohil, active_faults=0) < 0.1

        def test_bad_name(servohil):
            with pytest.raises(Failure, match="inject no_such_fault: REJECTED: .*no_such_fault"):
                servohil.inject("no_such_fault")
    ''')
    assert result.status == PASSED, result.text


@pytest.mark.parametrize("answers, says", [
    (b"", "inject: the emulator closed {path}"),
    (b"nonsense\n", "inject: {path}: Expecting value"),
    (b"[]\n", "inject: {path}: "),
    (b'{"id": 0, "result": "APPLIED"}\n{"id": 1, "result": "REJECTED"}\n', "inject air: REJECTED"),
    (b'{"id": 1}\n', "inject air: not applied"),
])
def test_control_tells_what_went_wrong(tmp_path, answers, says):
    path = tmp_path / "control"
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(str(path))
    listener.listen()

    def serve():
        connection = listener.accept()[0]
        connection.recv(1000)
        connection.sendall(answers)
        connection.close()

    server = threading.Thread(target=serve)
    server.start()
    control = Control(path, timeout_s=20.0)
    with pytest.raises(Failure) as failure:
        control.apply("inject", fault="air", parameters={})
    assert str(failure.value).startswith(says.format(path=path))
    control.close()
    server.join()
    listener.close()


def test_control_that_is_not_there(tmp_path):
    with pytest.raises(Failure, match=f"^control socket {tmp_path}/gone: No such file or directory$"):
        Control(tmp_path / "gone", timeout_s=1.0)


# --- Names and numbers -----------------------------------------------------------------------------------------------

@pytest.mark.parametrize("name, unit, expected", [
    ("X3", "in", "x3_in"), ("V3", "in/s", "v3_in_s"), ("P1_Applied", "psi", "p1_applied_psi"), ("Tick", "", "tick"),
    ("TimingValid", "", "timing_valid"), ("Load", "%", "load_percent"), ("OilTemp", "°C", "oil_temp_deg_c"),
    ("WorstLateness", "ms", "worst_lateness_ms"),
])
def test_attribute_names_carry_the_unit(name, unit, expected):
    assert attribute(name, unit) == expected


def test_signals_of_one_name_carry_their_message_too(tmp_path):
    dbc = tmp_path / "two.dbc"
    dbc.write_text(DBC.read_text().replace("SG_ SubSteps ", "SG_ Mode "))
    names = Contract(dbc).attributes()
    assert names["SERVO_Relay", "Mode"] == "servo_relay_mode" and names["SERVO_Status", "Mode"] == "servo_status_mode"
    assert len(set(names.values())) == len(names)


@given(last=st.integers(0, 10**12), step=st.integers(-TICK_MODULUS // 2, TICK_MODULUS // 2 - 1))
def test_ticks_do_not_wrap(last, step):
    assert unwrapped((last + step) % TICK_MODULUS, last) == last + step
    assert unwrapped(step % TICK_MODULUS, None) == step % TICK_MODULUS


# --- The example -----------------------------------------------------------------------------------------------------

def test_example(url, tmp_path):
    """As its user would run it. The test in real time is INVALID on a busy machine: never so in a guest."""
    options = () if IN_GUEST else ("-k", "not real_time")
    result = pytest_in(EXAMPLE, tmp_path, f"--servohil-program={PROGRAM}", f"--servohil-bus={url}", *options)
    assert result.status == PASSED, result.text


def test_example_shows_invalid(url, tmp_path):
    result = pytest_in(EXAMPLE, tmp_path, f"--servohil-program={PROGRAM}", f"--servohil-bus={url}", "-k", "real_time",
                       SHOW_INVALID="1")
    assert result.status == FAILED and "1 invalid" in result.text, result.text

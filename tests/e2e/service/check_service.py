"""The installed units under systemd, inside container.sh: pytest runs this file there (test_service.py starts it)."""

import grp
import json
import os
import re
import shutil
import stat
import subprocess
import sys
import time
from pathlib import Path

import can
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from thread_pause import paused, thread_of  # noqa: E402

UNIT, VCAN = "servohil@bench.service", "servohil-vcan@vcan1.service"
CONFIGURATION = Path("/etc/servohil/bench.toml")
SOCKET = Path("/run/servohil/bench.sock")
PATIENCE_S = 120.0  # virtual: it passes only while all wait


def run(*command, status=0):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    assert done.returncode == status, f"{command}: exit status {done.returncode}\n{done.stdout}{done.stderr}" + \
        subprocess.run(["journalctl", "--no-pager", "--lines", "30"], capture_output=True, text=True).stdout
    return done.stdout


def show(name, unit=UNIT):
    return run("systemctl", "show", "--property", name, "--value", unit).strip()


def until(condition, what):
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, f"{what}: not within {PATIENCE_S} s\n{journal_text()}"
        time.sleep(1.0)  # of virtual time, which costs nothing: the commands above do


def journal(unit=UNIT):
    run("journalctl", "--sync")
    return [json.loads(line) for line in run("journalctl", "--unit", unit, "--output", "json").splitlines()]


def journal_text(unit=UNIT):
    return "\n".join(str(entry["MESSAGE"]) for entry in journal(unit))


def main_process():
    return int(show("MainPID"))


def write_configuration(**values):
    text = (Path("/usr/local/share/servohil/servohil.toml").read_text()
            .replace('buses = ["auto"]', 'buses = ["socketcan:vcan1"]'))
    for key, value in values.items():
        text, count = re.subn(rf"(?m)^{key} = [^#\n]*", f"{key} = {value} ", text)
        assert count == 1, key
    CONFIGURATION.write_text(text)


@pytest.fixture(scope="module", autouse=True)
def machine():
    """As after installation: groups and folders made, units known, a configuration."""
    run("systemd-sysusers")
    run("systemd-tmpfiles", "--create", "servohil.conf")
    run("systemctl", "daemon-reload")
    CONFIGURATION.parent.mkdir()
    for name in ("servohil.dbc", "load_curve.csv"):
        shutil.copy(f"/usr/local/share/servohil/{name}", CONFIGURATION.parent)
    write_configuration()
    run("systemctl", "start", VCAN)


@pytest.fixture
def service():
    """Running; afterwards stopped."""
    write_configuration()
    run("systemctl", "reset-failed")
    run("systemctl", "start", UNIT)
    yield
    run("systemctl", "stop", UNIT)


def test_the_virtual_interface_comes_and_goes():
    assert "mtu 72" in run("ip", "link", "show", "vcan1") and "UP" in run("ip", "link", "show", "vcan1")
    run("systemctl", "start", "servohil-vcan@vcan7.service")
    assert Path("/sys/class/net/vcan7").exists()
    run("systemctl", "stop", "servohil-vcan@vcan7.service")
    assert not Path("/sys/class/net/vcan7").exists()


def test_it_starts_and_is_real_time_without_any_privilege(service):
    assert show("ActiveState") == "active"
    with can.Bus(interface="socketcan", channel="vcan1") as bus:
        assert bus.recv(PATIENCE_S) is not None
    process = Path(f"/proc/{main_process()}")
    status = dict(line.split(":\t", 1) for line in (process / "status").read_text().splitlines())
    assert int(status["Uid"].split()[1]) >= 61184, "a dynamic user"
    assert int(status["CapEff"], 16) == 0 and int(status["Seccomp"]) == 2 and int(status["NoNewPrivs"]) == 1
    assert int(status["VmLck"].split()[0]) > 10_000, "memory is locked"
    assert os.sched_getscheduler(thread_of(process.name, "sim")) == os.SCHED_FIFO
    assert "not fully real-time" not in journal_text()


def test_its_socket_is_for_the_group(service):
    about = SOCKET.stat()
    assert stat.S_IMODE(about.st_mode) == 0o660 and about.st_gid == grp.getgrnam("servohil").gr_gid
    assert "WAITING" in run("servohil", "status", "--control", SOCKET)


def test_the_status_line_is_told(service):
    until(lambda: "WAITING" in show("StatusText"), "a status line")
    with can.Bus(interface="socketcan", channel="vcan1") as bus:
        bus.send(can.Message(arbitration_id=0x100, is_extended_id=False, data=bytes.fromhex("00706307")))
    until(lambda: show("StatusText").startswith(("RUNNING", "DEGRADED")), "a status line that follows")


def test_the_watchdog_bites_when_the_loop_stands_still(service):
    first = main_process()
    with paused(first, "sim"):
        until(lambda: "Watchdog timeout" in journal_text(), "the watchdog")
    until(lambda: show("ActiveState") == "active" and main_process() not in (0, first), "the restart")
    assert show("NRestarts") == "1"
    assert SOCKET.exists() and "WAITING" in run("servohil", "status", "--control", SOCKET)


def test_the_watchdog_lets_a_loop_live_that_has_nothing_to_do(service):
    first = main_process()
    time.sleep(60.0)
    assert main_process() == first and show("NRestarts") == "0"


def test_killed_it_is_started_again(service):
    first = main_process()
    run("systemctl", "kill", "--signal", "KILL", UNIT)
    until(lambda: show("ActiveState") == "active" and main_process() not in (0, first), "the restart")


def test_stopped_it_says_so_on_the_bus_and_has_not_failed():
    run("systemctl", "start", UNIT)
    with can.Bus(interface="socketcan", channel="vcan1") as bus:
        run("systemctl", "stop", UNIT)
        last = None
        while (frame := bus.recv(0.0)) is not None:
            last = frame if frame.arbitration_id == 0x203 else last
    assert last is not None and last.data[0] & 0x0F == 3, "Mode STOPPED"
    assert show("Result") == "success" and show("ActiveState") == "inactive"
    assert "verdict  VALID" in journal_text()


def test_reload_changes_what_may_change_and_tells_the_rest(service):
    first = main_process()
    write_configuration(armed='"no"', underlap_in="0.001")
    run("systemctl", "reload", UNIT)
    until(lambda: "needs a restart" in journal_text(), "the lines of the reload")
    text = journal_text()
    assert 'reload: fault.armed = "no" from now on, was "auto"' in text
    assert "reload: servo.underlap_in = 0.001 in: needs a restart; it runs with 0.002 in" in text
    assert main_process() == first and show("ActiveState") == "active"
    assert "faults are not armed" in subprocess.run(
        ["servohil", "fault", "inject", "hot_oil", "--control", SOCKET], capture_output=True, text=True).stderr


def test_a_mistake_is_told_before_it_starts_and_is_not_tried_again():
    write_configuration(underlap_in="7", wake_ticks='"ten"')
    run("systemctl", "start", UNIT, status=1)
    assert show("ActiveState") == "failed" and show("NRestarts") == "0"
    told = [entry for entry in journal() if "/etc/servohil/bench.toml:" in str(entry["MESSAGE"])]
    assert len(told) == 2 and {entry["PRIORITY"] for entry in told} == {"3"}
    assert any("servo.underlap_in = 7" in entry["MESSAGE"] for entry in told)


def test_the_journal_is_readable():
    """How urgent a line is stands in its priority, when it was in its time: not in its text."""
    own = [entry for entry in journal() if entry.get("_COMM") == "servohil"]
    assert {entry["PRIORITY"] for entry in own} >= {"3", "4", "6"}
    for entry in own:
        assert isinstance(entry["MESSAGE"], str), "text, not bytes"
        assert not re.match(r"servohil|<\d>|\[?\d{4}-\d\d-\d\d|info|warning", entry["MESSAGE"]), entry["MESSAGE"]

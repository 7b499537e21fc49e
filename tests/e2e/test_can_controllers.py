"""On CAN controllers, by the kernel's driver for them: set up by netlink, the main job between two of them, taken down,
pulled out, overrun, stuck.

They are QEMU's: two SJA1000 on one cable, can0 the emulator's and can1 the governor's (tools/vcan-guest --controllers).
That model has no bit errors, so that no bit rate is wrong and no controller becomes error-passive or bus-off: test_bus_faults.py
has those. In the guest time is the host's and a processor is emulated: every run is late, and none is judged by it.
"""

import os
import subprocess
import time
from pathlib import Path

import can
import pytest

from control_socket import Control
from emulator import ENVIRONMENT, PATIENCE_S, PROGRAM, REPOSITORY, USAGE, Emulator, run, settings

pytestmark = pytest.mark.only("controllers")

HERE, THERE = "can0", "can1"
P1_STEP_PSI = 30.533
MOST_AGE_TICKS = 200  # of a frame that waits: 20 ms
CONFIGURED = settings(can__allow_physical="true", can__configure="true")
NO_ANSWER, NO_INTERRUPT = 0x001, 0x400  # bits of an adapter's PCI command register that make it a defective one


def ip(*arguments):
    subprocess.run(["ip", "link", *map(str, arguments)], check=True)


def write(path, text):
    Path(path).write_text(text)


def toggle(bit):
    """Of the emulator's adapter."""
    file = os.open(f"/sys/class/net/{HERE}/device/config", os.O_RDWR)
    command = int.from_bytes(os.pread(file, 2, 4), "little") ^ bit
    os.pwrite(file, command.to_bytes(2, "little"), 4)
    os.close(file)


def wait_for(condition):
    end = time.monotonic() + PATIENCE_S
    while not (found := condition()):
        assert time.monotonic() < end, "it did not come"
        time.sleep(0.02)
    return found


def command(p1_psi):
    """GOV_Command: P1_Demand from bit 12 on."""
    data = (round(p1_psi * 1000) << 12).to_bytes(4, "little")
    return can.Message(arbitration_id=0x100, is_extended_id=False, data=data)


@pytest.fixture
def governor(url):
    """The governor's adapter."""
    ip("set", HERE, "down")
    ip("set", THERE, "down")
    ip("set", THERE, "up", "type", "can", "bitrate", 500000)
    with can.Bus(interface="socketcan", channel=THERE) as bus:
        yield bus


@pytest.fixture
def start(governor, url, tmp_path):
    """start(...) → an emulator that has set up its controller, and a connection to its control socket"""
    running = []

    def start_one(*arguments):
        running.append(Emulator([url], "--rt", "off", "--control", tmp_path / "control", *CONFIGURED, *arguments))
        return running[-1], Control(tmp_path / "control")

    yield start_one
    for emulator in running:
        emulator.__exit__()


def bus_of(control):
    [bus] = control.ask("status")["buses"]
    return bus


def next_tick(governor, at_least=0):
    """Of the next SERVO_Position from there on; the frames before it are those that waited."""
    while True:
        frame = governor.recv(PATIENCE_S)
        assert frame is not None, "no SERVO_Position"
        if frame.arbitration_id == 0x200:
            tick = int.from_bytes(frame.data[4:], "little")
            if tick >= at_least:
                return tick


def forget(governor):
    while governor.recv(0.0) is not None:
        pass


# --- The main job ----------------------------------------------------------------------------------------------------

def test_governor_and_emulator_on_two_controllers(start, governor, tmp_path):
    """Each command arrives, each published frame is on the cable, once, and the valve moves."""
    log = tmp_path / "can1.log"
    with log.open("w") as file:
        witness = subprocess.Popen(["candump", "-L", "-r", "4000000", THERE], stdout=file)
        wait_for(lambda: THERE in Path("/proc/net/can/rcvlist_all").read_text())
        emulator, control = start()
        assert " 500000 bit/s, error-active" in emulator.log()
        foreign = subprocess.Popen(["cangen", THERE, "-I", "300", "-L", "8", "-g", "5", "-n", "100"])
        for _ in range(50):
            governor.send(command(P1_STEP_PSI))
            time.sleep(0.01)
        wait_for(lambda: control.ask("status")["x3_in"] > 4.1)  # 4.116 in when it is there
        wait_for(lambda: " can1 205" in log.read_text())  # comes once a second
        assert foreign.wait(timeout=60) == 0
        bus = bus_of(control)
        result = emulator.stop(may_be_late=True)
        wait_for(lambda: log.read_text().count(" can1 2") >= result.count["published"])
        witness.terminate()
        witness.wait()
    assert (bus["state"], bus["tx_errors"], bus["rx_errors"], bus["error_frames"]) == ("error-active", 0, 0, 0)
    assert result.count["commands"] == 50 and result.count["not sent"] == 0
    assert result.buses[0]["out"] == result.count["published"]
    frames = [line.split()[2].split("#") for line in log.read_text().splitlines()]
    ours = [name for name, _ in frames if name.startswith("2")]
    assert len(ours) == result.count["published"] and set(ours) == {"200", "201", "202", "203", "204", "205"}
    assert [name for name, _ in frames].count("300") == 100
    ticks = [int.from_bytes(bytes.fromhex(data[8:]), "little") for name, data in frames if name == "200"]
    assert ticks == sorted(set(ticks)) and {tick % 100 for tick in ticks} == {0}


def answers(bus, p1_psi):
    """Frames up to SERVO_Status, in lockstep."""
    bus.send(command(p1_psi))
    frames = []
    while not frames or frames[-1].arbitration_id != 0x203:
        frames.append(bus.recv(PATIENCE_S))
        assert frames[-1] is not None
    return [(frame.arbitration_id, bytes(frame.data)) for frame in frames]


def test_lockstep_gives_the_same_bits_as_on_a_terminal(start, governor):
    script = [30.263 + 0.02 * step for step in range(20)]
    emulator, _ = start("--clock", "lockstep")
    over_controllers = [answers(governor, p1_psi) for p1_psi in script]
    hashed = emulator.stop(may_be_late=True).hash
    with Emulator(["slcan:pty"], "--clock", "lockstep") as emulator:
        channel = emulator.urls[0].removeprefix("slcan:")
        with can.Bus(interface="slcan", channel=channel, bitrate=500000, sleep_after_open=0.0) as bus:
            assert [answers(bus, p1_psi) for p1_psi in script] == over_controllers
        assert emulator.stop(may_be_late=True).hash == hashed


# --- Set-up ----------------------------------------------------------------------------------------------------------

def test_used_only_when_allowed_and_set_up_only_as_asked(governor, url):
    assert f"{url} is a physical bus" in run("run", "--can", url, status=USAGE).stderr
    down = run("run", "--can", url, *settings(can__allow_physical="true"), status=ENVIRONMENT).stderr
    assert "can0 is down; set it up: sudo ip link set can0 up type can bitrate 500000" in down
    wrong = run("run", "--can", url, *CONFIGURED, *settings(can__bit_rate_bit_s=600000), status=ENVIRONMENT).stderr
    assert "can.bit_rate_bit_s = 600000: the nearest that the controller of can0 can do is 615384" in wrong


def test_the_commands_that_are_told_set_it_up(governor, url):
    asked = settings(can__bit_rate_bit_s=250000, can__sample_point=0.75, can__restart_ms=20, can__queue_length=5)
    done = subprocess.run(["setpriv", "--bounding-set=-net_admin", PROGRAM, "run", "--can", url, *CONFIGURED, *asked],
                          capture_output=True, text=True, cwd=REPOSITORY, timeout=60)
    assert done.returncode == ENVIRONMENT
    told = done.stderr.partition("this does it: ")[2].strip()
    subprocess.run(["sh", "-ec", told.replace("sudo ", "")], check=True)
    details = subprocess.run(["ip", "-details", "link", "show", HERE], capture_output=True, text=True).stdout
    for text in ("UP", "qlen 5", "bitrate 250000 sample-point 0.750", "restart-ms 20"):
        assert text in details
    allowed = settings(can__allow_physical="true", can__bit_rate_bit_s=250000)
    with Emulator([url], "--rt", "off", "--control", "none", *allowed) as emulator:  # without configure: left as it is
        assert "up, 250000 bit/s, error-active" in emulator.log()
        next_tick(governor)


# --- What goes wrong -------------------------------------------------------------------------------------------------

def goes_on(governor, control, since_tick):
    """Frames of now, a command is received, and nothing is wrong any more."""
    assert next_tick(governor) > since_tick - MOST_AGE_TICKS
    governor.send(command(30.263))
    wait_for(lambda: control.ask("status")["mode"] == "RUNNING")
    wait_for(lambda: (bus_of(control)["state"], bus_of(control)["faults"]) == ("error-active", []))


def test_down_and_up_again(start, governor):
    emulator, control = start()
    next_tick(governor)
    ip("set", HERE, "down")
    wait_for(lambda: bus_of(control)["state"] == "down")
    forget(governor)
    up_tick = control.ask("status")["tick"]
    ip("set", HERE, "up")
    goes_on(governor, control, up_tick)
    result = emulator.stop(may_be_late=True)
    assert result.count["not sent"] == result.buses[0]["dropped (not connected)"] > 0
    assert result.log.count("can0: down, was error-active") == result.log.count("can0: error-active, was down") == 1


def test_pulled_out_and_plugged_in(start, governor):
    """The device is removed from the kernel, and found again by it: as new, until it is set up anew."""
    emulator, control = start(*settings(can__bit_rate_bit_s=1000000, can__sample_point=0.75))
    next_tick(governor)
    device = Path(f"/sys/class/net/{HERE}/device").resolve()
    write(device / "remove", "1")
    wait_for(lambda: bus_of(control)["state"] == "gone")
    forget(governor)
    plug_tick = control.ask("status")["tick"]
    write("/sys/bus/pci/rescan", "1")
    goes_on(governor, control, plug_tick)
    details = subprocess.run(["ip", "-details", "link", "show", HERE], capture_output=True, text=True).stdout
    assert "bitrate 1000000 sample-point 0.750" in details and "qlen 16" in details
    log = emulator.stop(may_be_late=True).log
    assert log.count("can0: gone, was error-active") == log.count("can0: set up anew") == 1


def test_controller_that_raises_no_interrupts(start, governor):
    """It neither finishes a frame nor hands one over: its queue is full, its receive buffer of 64 bytes has room for 9
    commands of 3 + 4."""
    emulator, control = start()
    next_tick(governor)
    toggle(NO_INTERRUPT)
    wait_for(lambda: bus_of(control)["faults"] == ["transmit queue full"])
    for _ in range(12):
        governor.send(command(30.263))
        time.sleep(0.01)
    forget(governor)
    status = control.ask("status")
    assert status["mode"] == "WAITING" and status["buses"][0]["overruns"] == 0
    toggle(NO_INTERRUPT)
    wait_for(lambda: bus_of(control)["overruns"] == 1)
    waited = wait_for(lambda: governor.recv(PATIENCE_S))  # was in the controller
    assert waited.arbitration_id in range(0x200, 0x206)
    next_tick(governor, status["tick"])
    goes_on(governor, control, status["tick"])
    result = emulator.stop(may_be_late=True)
    assert result.count["commands"] == 9 + 1
    assert result.buses[0]["error frames"] == 1
    assert result.count["not sent"] == result.buses[0]["dropped (queue full)"] > 0
    for text in ("transmit queue full: ", "no more transmit queue full", "receive overrun: 1 frame lost"):
        assert result.log.count(text) == 1, result.log


def test_adapter_that_does_not_answer(start, governor):
    """A loose card: all that the driver reads are ones. Named as that; the frame that is lost in it would block it for
    ever, so that it is taken down and up."""
    emulator, control = start()
    next_tick(governor)
    toggle(NO_ANSWER)
    wait_for(lambda: "the adapter does not answer" in emulator.log())
    wait_for(lambda: bus_of(control)["faults"] == ["transmit queue full"])
    toggle(NO_ANSWER)
    wait_for(lambda: "the adapter answers again" in emulator.log())
    forget(governor)
    answers_tick = control.ask("status")["tick"]
    goes_on(governor, control, answers_tick)
    log = emulator.stop(may_be_late=True).log
    assert "frames are stuck in the controller though the bus is well: taken down and up" in log
    assert "bit-rate mismatch" not in log

"""What goes wrong on a bench's bus: seen, named, survived, recovered from without a restart, every counter exact.

On the real SocketCAN stack: vcan, and kernel interfaces with error states and bus-off (serial_interface.py). It needs
root in a namespace of its own: tools/vcan-guest, where time is virtual, so that no late tick is excused."""

import re
import subprocess
import time

import bus_soak
import can
import pytest

from control_socket import Control
from emulator import (ENVIRONMENT, MOST_AGE_TICKS, PATIENCE_S, PROGRAM, REPOSITORY, RUNNING, USAGE, Emulator, run,
                      settings, wait_for)
from serial_interface import SerialInterface, ip, ticks_on_line

pytestmark = pytest.mark.only("socketcan")

REST_P1_PSI = 30.263
ACTIVE, WARNING, PASSIVE, BUS_OFF, DOWN, GONE = range(6)  # signal BusState
# linux/can/error.h
ACK, CONTROLLER, PROTOCOL, BUS_ERROR = 0x20, 0x04, 0x08, 0x80
RX_OVERFLOW, TX_WARNING, TX_PASSIVE, BACK_TO_ACTIVE = 0x01, 0x08, 0x20, 0x40
STUFF, IN_DATA = 0x04, 0x0A


def error_frame(classes, data=bytes(8)):
    return can.Message(is_error_frame=True, is_extended_id=False, arbitration_id=classes, data=data)


@pytest.fixture
def run_on(transport, tmp_path):
    """run_on(url, ...) → an emulator and a connection to its control socket"""
    running = []

    def start(url, *arguments):
        socket = tmp_path / f"control{len(running)}"
        emulator = Emulator([url], "--rt", "off", "--control", socket, *arguments)
        running.append(emulator)
        return emulator, Control(socket)

    yield start
    for emulator in running:
        emulator.__exit__()


@pytest.fixture
def adapter(transport):
    with SerialInterface() as one:
        yield one


def bus_of(control):
    [bus] = control.ask("status")["buses"]
    return bus


def wait_for_state(control, state):
    wait_for(lambda: bus_of(control)["state"] == state)


# --- Error frames ----------------------------------------------------------------------------------------------------

def test_states_and_counters_of_error_frames(run_on, connect):
    """Each change is told once in the log, at once in SERVO_Bus; each frame is counted; the log has it in words."""
    emulator, control = run_on("socketcan:vcan0")
    client = connect(emulator)
    assert client.newest("SERVO_Bus")["BusState"] == ACTIVE
    for bits, tx_errors, state in ((TX_WARNING, 96, WARNING), (TX_PASSIVE, 135, PASSIVE), (BACK_TO_ACTIVE, 3, ACTIVE)):
        for _ in range(7):
            client.bus.send(error_frame(CONTROLLER | 0x200, bytes([0, bits, 0, 0, 0, 0, tx_errors, 1])))
        frame = client.newest("SERVO_Bus", lambda f, s=state: f["BusState"] == s)
        assert (frame["TxErrors"], frame["RxErrors"]) == (tx_errors, 1)
    wait_for(lambda: bus_of(control)["error_frames"] == 21)
    result = emulator.stop()
    assert result.buses[0]["error frames"] == 21
    for text in ("error-warning, was error-active", "controller-problem{tx-error-passive}; error counters: transmit 135",
                 "error-active, was error-passive"):
        assert result.log.count(text) == 1, result.log


def test_nothing_but_error_frames_is_named(run_on, connect):
    emulator, control = run_on("socketcan:vcan0")
    client = connect(emulator)
    client.newest("SERVO_Bus")
    for _ in range(5):
        for _ in range(100):
            client.bus.send(error_frame(PROTOCOL | BUS_ERROR, bytes([0, 0, STUFF, IN_DATA, 0, 0, 0, 0])))
        time.sleep(0.001)  # a socket holds some 250 frames
    client.newest("SERVO_Bus", lambda f: f["BitRateMismatch"] == 1)
    wait_for(lambda: bus_of(control)["error_frames"] == 500)
    assert bus_of(control)["faults"] == ["bit-rate mismatch"]
    client.send_p1(REST_P1_PSI)  # one good frame: the bit rate is right after all
    client.newest("SERVO_Bus", lambda f: f["BitRateMismatch"] == 0)
    client.bus.send(error_frame(ACK))
    client.newest("SERVO_Bus", lambda f: f["NoAcknowledge"] == 1)
    client.bus.send(error_frame(CONTROLLER, bytes([0, RX_OVERFLOW, 0, 0, 0, 0, 0, 0])))
    client.newest("SERVO_Bus", lambda f: f["ReceiveOverrun"] == 1)
    client.newest("SERVO_Bus", lambda f: not (f["NoAcknowledge"] or f["ReceiveOverrun"]))
    result = emulator.stop()
    assert result.buses[0]["error frames"] == 502
    begin, end = re.findall("bit-rate mismatch.*", result.log)
    assert re.fullmatch(r"bit-rate mismatch\? nothing but error frames \(\d+; protocol-violation\{bit-stuffing\}"
                        r"\{data\}, bus-error\): do all nodes run at 500000 bit/s\? else wires or termination", begin)
    assert end == "bit-rate mismatch; it was 500 frames"


# --- Floods ----------------------------------------------------------------------------------------------------------

def test_another_node_sends_our_ids(run_on, connect):
    emulator, control = run_on("socketcan:vcan0")
    client = connect(emulator)
    client.newest("SERVO_Position")
    client.close()
    for id_ in ("200", "203"):
        subprocess.run(["cangen", "vcan0", "-g", "0", "-n", "5000", "-i", "-I", id_, "-L", "8"], check=True, timeout=60)
    subprocess.run(["cangen", "vcan0", "-g", "0", "-n", "5000", "-i", "-I", "200", "-e"], check=True, timeout=60)
    wait_for(lambda: "id conflict" in bus_of(control)["faults"])
    client.open()
    client.send_p1(REST_P1_PSI)  # the kernel tells what it dropped along with a frame
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    wait_for(lambda: bus_of(control)["faults"] == [])
    result = emulator.stop()
    assert result.count["with our ids"] + result.buses[0]["receive overflows"] == 10000
    assert result.count["with our ids"] > 0 and result.count["commands"] == 1
    assert result.log.count("id conflict: another node sends identifiers that are ours") == 1


def test_canplayer_as_governor(run_on, tmp_path, connect):
    """100 commands of a log, in its own time; candump sees what the emulator sent, none twice."""
    log = tmp_path / "governor.log"
    log.write_text("".join(f"({100 + step / 100:.6f}) vcan0 100#00707607\n" for step in range(100)))
    emulator, _ = run_on("socketcan:vcan0")
    client = connect(emulator)
    client.newest("SERVO_Position")
    dump = subprocess.Popen(["candump", "-L", "-n", "200", "vcan0,200:7FF"], stdout=subprocess.PIPE, text=True)
    subprocess.run(["canplayer", "-I", log], check=True, timeout=60)
    text, _ = dump.communicate(timeout=60)
    ticks = [int.from_bytes(bytes.fromhex(line.split("#")[1])[4:], "little") for line in text.splitlines()]
    assert ticks == list(range(ticks[0], ticks[0] + 200 * 100, 100))
    assert emulator.stop().count["commands"] == 100


# --- Interfaces that come and go -------------------------------------------------------------------------------------

def next_tick(bus):
    while True:
        frame = bus.recv(PATIENCE_S)
        assert frame is not None
        if frame.arbitration_id == 0x200 and not frame.is_error_frame:
            return int.from_bytes(frame.data[4:], "little")


def commanded_at(status):
    return status["time_s"] - status["command_age_s"]


def test_interface_removed_and_made_anew_200_times(run_on, connect):
    """Each time: frames again, none that is old, and a command is received."""
    batch = subprocess.Popen(["ip", "-batch", "-"], stdin=subprocess.PIPE, text=True)

    def interface(*lines):
        batch.stdin.write("".join(f"link {line}\n" for line in lines))
        batch.stdin.flush()

    interface("add dev vcan9 type vcan", "set vcan9 up")
    wait_for(lambda: subprocess.run(["ip", "link", "show", "vcan9", "up"], capture_output=True).stdout)
    emulator, control = run_on("socketcan:vcan9")
    for _ in range(200):
        interface("del vcan9")
        wait_for_state(control, "gone")
        gone_tick = control.ask("status")["tick"]
        interface("add dev vcan9 type vcan", "set vcan9 up")
        wait_for_state(control, "error-active")
        with can.Bus(interface="socketcan", channel="vcan9") as bus:
            assert next_tick(bus) > gone_tick
            sent_s = control.ask("status")["time_s"]
            bus.send(can.Message(arbitration_id=0x100, is_extended_id=False, data=bytes.fromhex("00707607")))
            wait_for(lambda since=sent_s: commanded_at(control.ask("status")) >= since)
    result = emulator.stop()
    assert result.count["commands"] == 200
    assert result.count["not sent"] == result.buses[0]["dropped (not connected)"]
    assert result.log.count("vcan9: gone, was ") == result.log.count("vcan9: error-active, was ") == 200
    interface("del vcan9")
    batch.stdin.close()
    assert batch.wait(timeout=60) == 0


def configured(adapter, **more):
    return settings(can__allow_physical="true", can__configure="true", **more)


def test_adapter_pulled_out_and_plugged_in(run_on, adapter):
    """It is set up anew: bit rate, queue, up."""
    emulator, control = run_on(f"socketcan:{adapter.name}", *configured(adapter))
    adapter.wait_for_line(lambda line: line.startswith("t200"))
    assert adapter.lines[:3] == ["C", "S6", "O"]  # channel closed, 500 kbit/s, opened
    adapter.pull_out()
    wait_for_state(control, "gone")
    gone_tick = control.ask("status")["tick"]
    with SerialInterface() as again:
        assert again.name == adapter.name
        again.wait_for_line(lambda line: line.startswith("t200"))
        assert again.lines[:3] == ["C", "S6", "O"]
        assert min(ticks_on_line(again)) > gone_tick - MOST_AGE_TICKS
        wait_for_state(control, "error-active")
        again.send_frame(0x100, bytes.fromhex("00707607"))
        wait_for(lambda: control.ask("status")["mode"] == "RUNNING")
    assert emulator.stop().count["commands"] == 1


# --- Controllers -----------------------------------------------------------------------------------------------------

def test_bus_off_is_restarted_with_growing_waits(run_on, adapter):
    emulator, control = run_on(f"socketcan:{adapter.name}",
                               *configured(adapter, can__restart_ms=0, can__most_backoff_ms=400))
    for state, rx_errors, tx_errors in (("error-warning", 3, 100), ("error-passive", 3, 140)):
        adapter.set_state(state, rx_errors, tx_errors)
        told = [state, rx_errors, tx_errors]
        wait_for(lambda told=told: [bus_of(control)[key] for key in ("state", "rx_errors", "tx_errors")] == told)
    for times in range(1, 5):
        before = adapter.lines.count("O")
        adapter.set_state("bus-off", 0, 255)
        wait_for(lambda n=times: bus_of(control)["bus_offs"] == n)
        off_tick = control.ask("status")["tick"]
        seen = len(ticks_on_line(adapter))
        wait_for(lambda n=before: adapter.lines.count("O") == n + 1)
        wait_for_state(control, "error-active")
        wait_for(lambda n=seen: len(ticks_on_line(adapter)) > n + 5)
        assert min(ticks_on_line(adapter)[seen:]) > off_tick - MOST_AGE_TICKS
    result = emulator.stop()
    assert re.findall(r"restart in (\d+) ms", result.log) == ["100", "200", "400", "400"]
    assert result.log.count("bus-off, was ") == 4


def test_full_queue(run_on, adapter):
    """An adapter that stands still for 3 s: what is sent when it goes on is of now, not of then."""
    emulator, control = run_on(f"socketcan:{adapter.name}", *configured(adapter, can__queue_length=1))
    adapter.wait_for_line(lambda line: line.startswith("t200"))
    adapter.stop_reading()
    wait_for(lambda: bus_of(control)["faults"] == ["transmit queue full"])
    full_tick = control.ask("status")["tick"]
    time.sleep(3.0)
    resume_tick = control.ask("status")["tick"]
    adapter.go_on_reading()
    wait_for(lambda: not bus_of(control)["faults"])
    wait_for(lambda: ticks_on_line(adapter)[-1] > resume_tick + 2000)
    ticks = ticks_on_line(adapter)
    assert ticks == sorted(set(ticks))
    assert not [tick for tick in ticks if full_tick < tick < resume_tick - MOST_AGE_TICKS]
    result = emulator.stop()
    assert result.count["not sent"] == result.buses[0]["dropped (queue full)"] > 500
    assert result.log.count("transmit queue full: ") == 1
    assert result.log.count("no more transmit queue full; it was") == 1


# --- What may be used, and who may set it up --------------------------------------------------------------------------

def test_a_physical_bus_is_not_used_unasked(transport, adapter):
    url = f"socketcan:{adapter.name}"
    refused = run("run", "--can", url, status=USAGE).stderr
    assert f"{url} is a physical bus" in refused and "can.allow_physical=true" in refused
    interfaces = settings(can__interfaces=f'["{adapter.name}"]')
    with Emulator(["auto"], *interfaces) as emulator:  # it takes what it may
        assert emulator.urls[0].startswith("slcan:/dev/pts/")
        assert "can.allow_physical" in emulator.log()
    modelled = settings(can__allow_physical="true", can__configure="true", can__emulate_bitrate=500000)
    assert "can.emulate_bitrate is for virtual buses" in run("run", "--can", url, *modelled, status=USAGE).stderr
    ip("link", "set", adapter.name, "down")
    down = run("run", "--can", url, *settings(can__allow_physical="true"), status=ENVIRONMENT).stderr
    assert f"sudo ip link set {adapter.name} up type can bitrate 500000" in down


def test_without_permission_the_commands_are_told(transport, adapter):
    done = subprocess.run(["setpriv", "--bounding-set=-net_admin", PROGRAM, "run", "--can", f"socketcan:{adapter.name}",
                           *configured(adapter)], capture_output=True, text=True, cwd=REPOSITORY, timeout=60)
    assert done.returncode == ENVIRONMENT
    commands = done.stderr.partition("this does it: ")[2].strip()
    set_ = f"sudo ip link set {adapter.name}"
    assert commands == (f"{set_} down; {set_} type can bitrate 500000 sample-point 0.875 restart-ms 100; "
                        f"{set_} txqueuelen 16 up")


def test_faults_are_not_armed_on_a_physical_bus(run_on, adapter):
    emulator, control = run_on(f"socketcan:{adapter.name}", *configured(adapter))
    answer = control.ask("inject", fault="air_entrainment")
    assert answer["result"] == "REJECTED" and "may be physical" in answer["reason"]


# --- One after the other ----------------------------------------------------------------------------------------------

def test_a_round_of_all_disturbances(transport):
    """Hours of it: tests/e2e/bus_soak.py."""
    bus_soak.soak(seconds=0, seed=3)

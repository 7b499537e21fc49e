"""Faults over CAN: FAULT_Request and FAULT_Response, encoded and decoded by python-can and canmatrix."""

import signal
import struct

import can
import pytest
from emulator import CONFIGURATION, OK, Client, run, settings
from scripted_governor import LOCKSTEP, REST_P1_PSI, TICKS

ALLOWED = settings(fault__allow_can="true")
SET, START, CLEAR, CLEAR_ALL = range(4)
RAMP_S, FOR_S = 3, 4
ALL = 255


class Faults:
    """Asks for faults over the bus; names are those of the DBC's value tables."""

    def __init__(self, client):
        self.client = client
        self.number = 0
        names = client.messages["FAULT_Request"].signal_by_name("Fault").values
        self.ids = {name: int(raw) for raw, name in names.items()}

    def ask(self, action, fault="", field=0, target=ALL, value=0.0, number_of=None):
        """The response, with its values' names."""
        self.number = (self.number + 1) % 16
        fault_id = number_of if number_of is not None else self.ids.get(fault, 0)
        data = struct.pack("<BBBBf", action | self.number << 4, fault_id, field, target, value)
        self.client.send(can.Message(arbitration_id=0x101, is_extended_id=False, data=data))
        response = self.client.newest("FAULT_Response")
        assert (response["Action"], response["Number"], response["Fault"]) == (action, self.number, fault_id)
        name = {s: self.client.messages["FAULT_Response"].signal_by_name(s).values for s in ("Result", "Reason")}
        return (name["Result"][int(response["Result"])], name["Reason"][int(response["Reason"])], int(response["Tick"]))


@pytest.fixture
def faults(start, connect):
    def begin(*arguments):
        emulator = start(*arguments, "--control", "none")
        return emulator, Faults(connect(emulator))
    return begin


def step(client, p1_psi=REST_P1_PSI):
    """Lets 10 ms pass; SERVO_Position."""
    client.send_p1(p1_psi)
    position = client.newest("SERVO_Position")
    client.newest("SERVO_Status")
    return position


def test_a_fault_is_set_started_and_cleared_at_its_ticks(faults, tmp_path):
    """Lockstep: 20 psi of load push the piston down by about 0.0012 in, from the tick that the response names."""
    emulator, bus = faults(*LOCKSTEP, *ALLOWED, "--record", tmp_path / "rec")
    for _ in range(3):
        rest = step(bus.client)
    assert bus.ask(SET, "load_step", 0, value=20.0) == ("SET", "NONE", 0)
    assert bus.ask(SET, "load_step", FOR_S, value=0.5) == ("SET", "NONE", 0)
    assert bus.ask(START, "load_step") == ("APPLIED", "NONE", 3 * TICKS + 1)
    for _ in range(40):
        pushed = step(bus.client)
    assert rest["X3"] - pushed["X3"] == pytest.approx(0.0012, abs=0.0003)
    for _ in range(40):
        after = step(bus.client)
    assert after["X3"] == pytest.approx(rest["X3"], abs=0.0003)  # over, after its 0.5 s
    assert bus.ask(START, "load_step") == ("APPLIED", "NONE", 83 * TICKS + 1)  # its default again, until cleared
    for _ in range(60):
        pushed = step(bus.client)
    assert after["X3"] - pushed["X3"] == pytest.approx(0.0012, abs=0.0003)
    assert bus.ask(CLEAR, "load_step")[:2] == ("APPLIED", "NONE")
    assert bus.ask(CLEAR, "load_step")[:2] == ("REJECTED", "NOT_INJECTED")
    assert bus.ask(CLEAR_ALL)[:2] == ("APPLIED", "NONE")
    assert emulator.stop().status == OK
    assert "identical" in run("replay", tmp_path / "rec").stdout
    log = (tmp_path / "rec" / "bus.log").read_text()
    assert log.count(" 101#") == log.count(" 208#") == 7


def test_what_is_wrong_is_named(faults):
    emulator, bus = faults(*LOCKSTEP, *ALLOWED)
    step(bus.client)
    assert bus.ask(START, number_of=200)[:2] == ("REJECTED", "UNKNOWN_FAULT")
    assert bus.ask(SET, "load_step", 0, value=301.0)[:2] == ("REJECTED", "OUT_OF_RANGE")
    assert bus.ask(SET, "load_step", 0, value=float("nan"))[:2] == ("REJECTED", "OUT_OF_RANGE")
    assert bus.ask(SET, "load_step", 1)[:2] == ("REJECTED", "UNKNOWN_FIELD")
    assert bus.ask(SET, "load_step", RAMP_S, value=-1.0)[:2] == ("REJECTED", "OUT_OF_RANGE")
    assert bus.ask(9, "load_step")[:2] == ("REJECTED", "UNKNOWN_FIELD")
    assert bus.ask(START, "gas_charge_lost")[:2] == ("UNSUPPORTED", "NOT_IN_THIS_RUN")
    assert bus.ask(START, "load_step", target=3)[:2] == ("REJECTED", "UNKNOWN_TARGET")
    assert bus.ask(START, "sensor_offset")[:2] == ("REJECTED", "UNKNOWN_TARGET")  # which one?
    bus.client.send(can.Message(arbitration_id=0x101, is_extended_id=False, data=b"\x01"))  # too short: not one
    assert bus.ask(CLEAR_ALL)[0] == "APPLIED"
    emulator.stop()


def test_a_sensor_is_named_by_its_number(faults):
    """An offset of x3's sensor of 0.1 in: the frames are off, the piston is not."""
    emulator, bus = faults(*LOCKSTEP, *ALLOWED)
    before = step(bus.client)
    assert bus.ask(SET, "sensor_offset", 0, value=0.1)[0] == "SET"
    assert bus.ask(START, "sensor_offset", target=0)[0] == "APPLIED"
    assert step(bus.client)["X3"] - before["X3"] == pytest.approx(0.1, abs=0.0002)
    assert bus.ask(CLEAR, "sensor_offset", target=0)[0] == "APPLIED"
    assert step(bus.client)["X3"] == before["X3"]
    emulator.stop()


def test_in_real_time_the_tick_is_near_the_frames_around_it(faults):
    """The response names a tick that is not before the last position sent before the request."""
    emulator, bus = faults(*ALLOWED, "--rt", "off")
    position = bus.client.newest("SERVO_Position")
    result, reason, tick = bus.ask(START, "load_step")
    assert (result, reason) == ("APPLIED", "NONE") and tick > position["Tick"]
    bus.client.newest("SERVO_Status", lambda frame: frame["ActiveFaults"] == 1)
    assert bus.ask(CLEAR_ALL)[0] == "APPLIED"
    emulator.stop()


def test_not_armed_is_rejected_but_clearing_works(faults):
    emulator, bus = faults(*LOCKSTEP, *ALLOWED, *settings(fault__armed="no"))
    step(bus.client)
    assert bus.ask(START, "load_step")[:2] == ("REJECTED", "NOT_ARMED")
    assert bus.ask(CLEAR_ALL)[0] == "APPLIED"
    emulator.stop()


def test_leave_can_be_given_while_it_runs(start, connect, tmp_path):
    """SIGHUP reads fault.armed again: FAULT_Request obeys from then on."""
    for file in CONFIGURATION.parent.glob("*.*"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    configuration = tmp_path / CONFIGURATION.name
    configuration.write_text(configuration.read_text().replace('armed = "auto"', 'armed = "no"'))
    emulator = start(*LOCKSTEP, *ALLOWED, "--config", configuration, "--control", "none")
    bus = Faults(connect(emulator))
    step(bus.client)
    assert bus.ask(START, "load_step")[:2] == ("REJECTED", "NOT_ARMED")
    configuration.write_text(configuration.read_text().replace('armed = "no"', 'armed = "yes"'))
    emulator.signal(signal.SIGHUP)
    while "reload: fault.armed" not in emulator.log():
        assert bus.ask(CLEAR_ALL)[0] == "APPLIED"
    assert bus.ask(START, "load_step")[:2] == ("APPLIED", "NONE")
    emulator.stop()


def test_on_a_modelled_bus_each_request_has_one_response(faults):
    """A START that were taken twice would inject the fault anew and answer twice."""
    emulator, bus = faults(*LOCKSTEP, *ALLOWED, *settings(can__emulate_bitrate="500000"))
    step(bus.client)
    assert bus.ask(START, "load_step")[:2] == ("APPLIED", "NONE")
    bus.client.send_p1(REST_P1_PSI)  # what waited for the bus has passed it with this
    frames = bus.client.until(lambda frame: frame.name == "SERVO_Status")
    bus.client.send_p1(REST_P1_PSI)
    frames += bus.client.until(lambda frame: frame.name == "SERVO_Status")
    assert [frame.name for frame in frames].count("FAULT_Response") == 0
    assert bus.ask(CLEAR_ALL)[:2] == ("APPLIED", "NONE")
    emulator.stop()


def test_without_leave_there_is_no_answer(start, connect):
    """The identifier is then anybody's."""
    emulator = start(*LOCKSTEP, "--control", "none")
    client = connect(emulator)
    client.send(can.Message(arbitration_id=0x101, is_extended_id=False, data=bytes(8)))
    client.send_p1(REST_P1_PSI)
    frames = client.until(lambda frame: frame.name == "SERVO_Status")
    assert all(frame.name != "FAULT_Response" for frame in frames)
    emulator.stop()


def test_the_frames_of_the_protocol_document(start, connect):
    """PROTOCOL.md's requests, byte by byte, are answered as it says (but for the ticks)."""
    emulator = start(*LOCKSTEP, *ALLOWED, "--control", "none")
    client: Client = connect(emulator)
    step(client)
    for request, answer in (("300100FF0AD7A33C", "3001030000000000"), ("400103FF0000003F", "4001030000000000"),
                            ("510100FF00000000", "51010000"), ("620100FF00000000", "62010000")):
        client.send(can.Message(arbitration_id=0x101, is_extended_id=False, data=bytes.fromhex(request)))
        assert bytes(client.newest("FAULT_Response").raw.data).hex().upper().startswith(answer)
    emulator.stop()

"""A governor that is not ours: config/examples/foreign, with canmatrix and python-can as that governor.

J1939 identifiers, Motorola byte order, bar, mm and %, IEEE 754 numbers, a multiplexer, two DBC files.
"""

import json
import math
import re

import can
import canmatrix.formats
import pytest
from emulator import OK, REPOSITORY, STOPPED, TICKS_PER_MS, Emulator, run
from recordings import Recording

FOREIGN = REPOSITORY / "config" / "examples" / "foreign"
CONFIGURATION = FOREIGN / "servohil.toml"
PSI_PER_BAR = 1e5 / 6894.757293168
LOCKSTEP = ("--clock", "lockstep", "-c", CONFIGURATION)
OTHER_SOURCE, OTHER_PRIORITY = 0x44, 6  # the second of two redundant governors
STROKE_IN = 8.0


def steady(**what):
    (name, value), = what.items()
    return json.loads(run("steady", f"--{name}", value, "--json").stdout)


class ForeignGovernor:
    def __init__(self, url, source=OTHER_SOURCE):
        self.files = [canmatrix.formats.loadp_flat(str(FOREIGN / name)) for name in ("governor.dbc", "valve_drive.dbc")]
        self.messages = {m.name: m for file in self.files for m in file.frames}
        self.by_id = {m.arbitration_id.id: m for m in self.messages.values()}
        self.source = source
        self.alive = 0
        self.bus = can.Bus(interface="slcan", channel=url.partition(":")[2], sleep_after_open=0.0, bitrate=250000)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.bus.shutdown()
        except (can.CanError, OSError):
            pass  # the emulator went first

    def send(self, name, **physical):
        message = self.messages[name]
        raw = {n: round((v - float(message.signal_by_name(n).offset)) / float(message.signal_by_name(n).factor))
               for n, v in physical.items()}
        group = message.arbitration_id.id & 0x03FFFF00
        self.bus.send(can.Message(arbitration_id=OTHER_PRIORITY << 26 | group | self.source, is_extended_id=True,
                                  data=message.encode(raw)))

    def demand(self, p1_psi, enable=1):
        self.alive = (self.alive + 1) % 16
        self.send("TGC_ValveCommand", OilPressureDemand=p1_psi / PSI_PER_BAR, ValveEnable=enable, AliveCounter=self.alive)

    def receive(self):
        raw = self.bus.recv(20.0)
        assert raw is not None, "no frame within 20 s"
        assert raw.is_extended_id
        message = self.by_id[raw.arbitration_id]
        assert raw.dlc == message.size
        return message.name, {n: float(s.phys_value) for n, s in message.decode(raw.data).items()}, bytes(raw.data)

    def answer(self):
        """In lockstep: one frame of each message."""
        frames = [self.receive() for _ in range(3)]
        assert [name for name, _, _ in frames] == ["VDU_Feedback", "VDU_OilPressure", "VDU_Diagnosis"]
        return [values for _, values, _ in frames]


@pytest.fixture
def emulator(request):
    with Emulator(["slcan:pty"], *getattr(request, "param", LOCKSTEP)) as running:
        yield running


def test_the_governor_moves_the_valve_and_sees_it_move(emulator):
    """From rest at 4 in to where P1 for 4.4 in puts it: demanded in bar, answered in %, mm/s, mA and kPa."""
    target = steady(x3=4.4)
    with ForeignGovernor(emulator.urls[0]) as governor:
        for _ in range(60):  # 0.6 s
            governor.demand(target["p1_psi"])
            feedback, pressure, _ = governor.answer()
    # The demand has steps of 0.0005 bar: x3 follows P1 with dx3/dP1 = 0.43 in/psi.
    step_in = 0.5 * 0.0005 * PSI_PER_BAR * 0.43
    x3_in = target["x3_in"]
    assert feedback["Lift"] == pytest.approx(100 * x3_in / STROKE_IN, abs=100 * (step_in + 0.002) / STROKE_IN)
    assert feedback["LiftCurrent"] == pytest.approx(4 + 16 * feedback["Lift"] / 100, abs=0.001)
    assert abs(feedback["LiftVelocity"]) < 0.5
    assert feedback["DriveState"] == 1 and feedback["FeedbackOk"] == 1
    assert pressure["ControlPressure"] == pytest.approx(target["p1_psi"] / PSI_PER_BAR * 100, abs=0.5 * 0.05 + 1e-3)
    assert pressure["PressureUnderPiston"] == pytest.approx(target["p3_psi"] / PSI_PER_BAR * 100, rel=0.01)
    result = emulator.stop()
    assert result.ticks == 6000 and result.status == OK and result.count["commands"] == 60


def test_multiplexed_pages_come_in_turn(emulator):
    rest = steady(x3=4.0)
    with ForeignGovernor(emulator.urls[0]) as governor:
        pages = []
        for _ in range(6):
            governor.demand(rest["p1_psi"])
            pages.append(governor.answer()[2])
    assert [page["Page"] for page in pages] == [0, 1, 7, 0, 1, 7]
    assert pages[0]["RelayPiston"] == pytest.approx(25.4 * rest["x1_in"], abs=0.005 + 0.02)
    assert "CommandAge" not in pages[0] and "RelayPiston" not in pages[1]
    assert pages[1]["ActiveFaults"] == 0 and pages[1]["CommandAge"] < 20
    assert pages[2]["SerialNumber"] == 240117 and pages[2]["SoftwareVersion"] == pytest.approx(2.5)


def test_bits_of_no_signal_are_ones_in_j1939(emulator):
    with ForeignGovernor(emulator.urls[0]) as governor:
        governor.demand(steady(x3=4.0)["p1_psi"])
        name, _, data = governor.receive()
    assert name == "VDU_Feedback" and data[7] == 0xFF and data[4] >> 4 & 0b11 == 0b11


def test_only_its_own_parameter_groups_count(emulator):
    with ForeignGovernor(emulator.urls[0]) as governor:
        governor.send("TGC_Heartbeat", UpTime=1.0)
        governor.send("TGC_Mode", TurbineState=3, Speed=3000)  # no P1 in it: no time passes
        governor.demand(steady(x3=4.0)["p1_psi"])
        governor.answer()
    count = emulator.stop().count
    assert (count["commands"], count["of other ids"], count["malformed"], count["out of range"]) == (1, 1, 0, 0)


ON_CHANGE = """can.publish=[{message="VDU_Feedback", on_change=true, signals={DriveState="mode"}},
 {message="VDU_OilPressure", signals={PressureUnderPiston="p3_psi"}}]"""


@pytest.mark.parametrize("emulator", [(*LOCKSTEP, "--set", ON_CHANGE.replace("\n", ""))], indirect=True)
def test_on_change_means_only_then(emulator):
    with ForeignGovernor(emulator.urls[0]) as governor:
        names = []
        for step in range(1, 4):
            governor.demand(steady(x3=4.0)["p1_psi"])
            while names.count("VDU_OilPressure") < step:
                names.append(governor.receive()[0])
    assert names == ["VDU_Feedback", *3 * ["VDU_OilPressure"]]


def test_what_does_not_fit_into_a_signal_is_told():
    """Narrowed to 0 to 50 %: rest at 4 in is the edge, above it the frames saturate."""
    narrow = """can.publish=[{message="VDU_Feedback", signals={Lift={quantity="x3_in", scale=[[0.0, 0.0], [1.0, 45.0]],
 may_clip=true}}}]""".replace("\n", "")
    with Emulator(["slcan:pty"], *LOCKSTEP, "--set", narrow) as emulator:
        with ForeignGovernor(emulator.urls[0]) as governor:
            for _ in range(3):
                governor.demand(steady(x3=4.0)["p1_psi"])
                name, values, _ = governor.receive()
                assert name == "VDU_Feedback" and values["Lift"] == pytest.approx(155.6375)
        result = emulator.stop()
    assert "clipped  3 frames of VDU_Feedback.Lift: x3_in leaves -5 to 155.637 %, the frame saturates" in result.text
    assert result.log.count("VDU_Feedback.Lift: x3_in leaves") == 1


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run in real time, half a second of it commanded."""
    directory = tmp_path_factory.mktemp("foreign") / "run"
    with Emulator(["slcan:pty"], "-c", CONFIGURATION, "--rt", "off", "--record", directory) as running:
        with ForeignGovernor(running.urls[0]) as governor:
            names = []
            p1_psi = steady(x3=4.2)["p1_psi"]
            while names.count("VDU_Feedback") < 50:
                name, _, _ = governor.receive()
                names.append(name)
                if name == "VDU_Feedback":
                    governor.demand(p1_psi)
        running.stop(may_be_late=True)
    return directory, names


@pytest.mark.parametrize("message, cycle_ms", [("VDU_Feedback", 10), ("VDU_OilPressure", 20), ("VDU_Diagnosis", 50)])
def test_cycle_times_are_those_of_the_dbc_and_of_the_configuration(recorded, message, cycle_ms):
    """However late the machine comes: a frame carries the state of a tick that its cycle divides."""
    directory, names = recorded
    assert names.count(message) > 1
    published = Recording(directory).published[message]
    ticks = [int(tick) for tick, state in zip(published["tick"], published.get("DriveState", published["tick"] * 0))
             if state != STOPPED]
    assert {tick % (cycle_ms * TICKS_PER_MS) for tick in ticks} == {0}
    assert all(b > a for a, b in zip(ticks, ticks[1:]))


def test_the_recording_has_it_all_and_replays(recorded):
    directory, _ = recorded
    recording = Recording(directory)
    assert "BO_ 2365530401 TGC_ValveCommand" in recording.attributes["dbc"]
    assert "BO_ 2365534259 VDU_Feedback" in recording.attributes["dbc_2"]
    assert "[[can.publish]]" in recording.attributes["configuration"]
    diagnosis = recording.published["VDU_Diagnosis"]
    pages = [int(page) for page in diagnosis["Page"]]
    assert set(pages) <= {0, 1, 7} and len(pages) > 3
    assert [math.isnan(x) for x in diagnosis["RelayPiston"]] == [page != 0 for page in pages]
    lift = dict(zip(recording.published["VDU_Feedback"]["tick"], recording.published["VDU_Feedback"]["Lift"]))
    truth = dict(zip(recording.ticks, recording.samples["x3_in"]))
    for tick, percent in lift.items():
        assert percent == pytest.approx(100 * truth[tick] / STROKE_IN, abs=0.5 * 0.0025 + 1e-9)
    assert "identical: " in run("replay", directory).stdout


def test_the_log_is_decoded_through_the_mapping(recorded):
    directory, names = recorded
    text = run("dbc", "-c", CONFIGURATION, "--decode", directory / "bus.log").stdout
    commands = re.findall(r"TGC_ValveCommand: OilPressureDemand (\S+) bar, .*ValveEnable 1 \"Released\", .*"
                          r"  => P1 (\S+) psi, enabled", text)
    assert len(commands) > 40
    for bar, psi in commands:
        assert float(psi) == pytest.approx(float(bar) * PSI_PER_BAR, rel=1e-5)
    assert re.search(r"VDU_Feedback: Lift \S+ %, .*  => x3_in \S+, v3_in_s ", text)
    assert re.search(r"VDU_Diagnosis: Page 7, SerialNumber 240117, SoftwareVersion 2.5$", text, re.M)
    assert re.search(r"^frames  .*VDU_Feedback \d+, .*0 of 0 unknown identifiers$", text, re.M)


def test_unknown_identifiers_and_damaged_frames_are_told(tmp_path):
    log = tmp_path / "bus.log"
    log.write_text("(1.000000) can0 0CFF2144#1000FF7FFFFFFFFF\n(1.500000) can0 123#00\n(1.600000) can0 123#00\n"
                   "(1.700000) can0 0CFF2144#10\n(1.800000) can0 18FF2144#FFFF007FFFFFFFFF\n")
    text = run("dbc", "-c", CONFIGURATION, "--decode", log).stdout
    assert "    0.000000  TGC_ValveCommand: OilPressureDemand 2.048 bar" in text
    assert "TGC_ValveCommand: 1 of its 8 bytes" in text
    assert "=> P1 not available (J1939): not a command" in text
    assert "2 of 1 unknown identifiers\nunknown 0x123: 2\n" in text


def test_what_will_be_received_and_sent_is_shown():
    text = run("dbc", "-c", CONFIGURATION).stdout
    for line in (r"  TGC_ValveCommand  0x0CFF2121, PGN 65313 of any source, 8 bytes, every 10 ms, 160 bits, 6.4 % of the bus; "
                 r".*governor.dbc:\d+",
                 r"    OilPressureDemand +7\|16@0\+, 0 to 32.1275 bar +P1 = value x 14.5038: 0 to 465.97 psi",
                 r"    ValveEnable .* enabled while 1 \"Released\"",
                 r"    TurbineState .* tripped while 4 \"Tripped\"",
                 r"    Lift +7\|16@0\+, -5 to 155.637 % +x3_in x 12.5",
                 r"    LiftCurrent .* x3_in x 2 \+ 4",
                 r"    FeedbackOk .* always 1 \"Ok\"",
                 r"    PressureUnderPiston +7\|32@0-, float kPa +p3_psi x 6.89476",
                 r"   with Page = 7:",
                 r"    SerialNumber .* always 240117",
                 r"load +\d+\.\d % of 250000 bit/s at worst-case stuffing"):
        assert re.search(f"^{line}$", text, re.M), f"{line}\n{text}"


def test_what_will_be_received_and_sent_for_pipelines():
    contract = json.loads(run("dbc", "-c", CONFIGURATION, "--json").stdout)
    demand, mode = contract["received"]
    assert (demand["message"], demand["id"], demand["extended"], demand["pgn"]) == ("TGC_ValveCommand", 0x0CFF2121, True, 65313)
    p1, enable = demand["signals"]
    assert (p1["carries"], p1["unit"], p1["to_psi"]["factor"]) == ("p1_psi", "bar", pytest.approx(PSI_PER_BAR))
    assert (enable["carries"], enable["raw"]) == ("enable", 1)
    assert [(s["carries"], s["raw"]) for s in mode["signals"]] == [("trip", 4)]
    assert [(m["message"], m["cycle_ms"], m["on_change"]) for m in contract["sent"]] == [
        ("VDU_Feedback", 10, False), ("VDU_OilPressure", 20, False), ("VDU_Diagnosis", 50, False)]
    carried = {s["signal"]: (s["carries"], s.get("multiplexer")) for s in contract["sent"][2]["signals"]}
    assert carried == {"RelayPiston": ("x1_in", 0), "Plunger": ("x2_in", 0), "CommandAge": ("command_age_ms", 1),
                       "ActiveFaults": ("active_faults", 1)}
    shown = run("dbc", "-c", CONFIGURATION).stdout
    assert f"{100 * contract['load']['share']:.1f} % of {contract['load']['bit_rate_bit_s']} bit/s" in shown


def test_the_log_is_decoded_for_pipelines(recorded):
    """Signal by signal as canmatrix has it."""
    directory, _ = recorded
    lines = [json.loads(line) for line in
             run("dbc", "-c", CONFIGURATION, "--decode", directory / "bus.log", "--json").stdout.splitlines()]
    files = [canmatrix.formats.loadp_flat(str(FOREIGN / name)) for name in ("governor.dbc", "valve_drive.dbc")]
    messages = {m.name: m for file in files for m in file.frames}
    with can.CanutilsLogReader(str(directory / "bus.log")) as log:
        frames = list(log)
    assert len(frames) == len(lines) > 100
    for line, frame in zip(lines, frames):
        assert line["time_s"] == pytest.approx(frame.timestamp, abs=1e-6) and line["id"] == frame.arbitration_id
        expected = {n: float(s.phys_value) for n, s in messages[line["message"]].decode(frame.data).items()}
        assert line["signals"] == pytest.approx(expected, rel=1e-6), line
        if line["message"] == "TGC_ValveCommand":
            assert line["p1_psi"] == pytest.approx(expected["OilPressureDemand"] * PSI_PER_BAR) and line["enabled"]
        if line["message"] == "VDU_Feedback":
            assert line["quantities"]["Lift"] == {"quantity": "x3_in",
                                                  "value": pytest.approx(expected["Lift"] * STROKE_IN / 100)}


# --- The command's cycle ---------------------------------------------------------------------------------------------

SLOW_DBC = """VERSION ""
BU_: GOV VDU
BO_ 256 EHG_Demand: 8 GOV
 SG_ P1 : 0|16@1+ (0.01,0) [0|300] "psi" VDU
BO_ 512 Pos: 8 VDU
 SG_ X3 : 0|16@1+ (0.001,0) [0|10] "in" GOV
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_ "GenMsgCycleTime" BO_ 256 50;
"""


def slow_governor(folder, keys=""):
    (folder / "slow.dbc").write_text(SLOW_DBC)
    (folder / "slow.toml").write_text(
        f'[load]\nfile = "{FOREIGN.parents[1] / "load_curve.csv"}"\n[can]\ndbc = ["slow.dbc"]\n[can.command]\n'
        f'p1 = "EHG_Demand.P1"\n{keys}[[can.publish]]\nmessage = "Pos"\ncycle_ms = 10\nsignals = {{ X3 = "x3_in" }}\n')
    return folder / "slow.toml"


def test_a_cycle_of_the_dbc_is_the_governors(tmp_path):
    """Commands every 50 ms, as the DBC says: never lost while they come, lost three cycles after the last."""
    log = tmp_path / "bus.log"
    log.write_text("".join(f"({1000 + k * 0.05:.6f}) can0 100#1C0C000000000000\n" for k in range(40)))
    configuration = slow_governor(tmp_path)
    assert "EHG_Demand" in run("dbc", "-c", configuration).stdout
    assert "every 50 ms" in run("dbc", "-c", configuration).stdout
    assert "running (first command), 0 times lost" in run("replay", "-c", configuration, log).stdout
    told = run("dbc", "-c", slow_governor(tmp_path, "cycle_ms = 20\n")).stdout
    assert "warning" in told and "can.command.cycle_ms = 20" in told and "GenMsgCycleTime 50" in told


def test_more_than_the_bus_carries_is_no_mapping(tmp_path):
    refused = run("dbc", "-c", slow_governor(tmp_path), "--set", "can.bit_rate_bit_s=10000", status=2)
    assert "more than the bus carries" in refused.stderr and refused.stderr.count("\n") == 1

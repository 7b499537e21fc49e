"""The DBC file: which frames there are, and what their bits mean. canmatrix knows the layout."""

import re

from .failure import USAGE, Failure
from .libraries import can, canmatrix

__tracebackhide__ = True  # pytest: a failure is shown where the test called

COMMAND = ("GOV_Command", "P1_Demand")
TICK = ("SERVO_Position", "Tick")
TICK_S = 1e-4
TICK_MODULUS = 2**32
# What servohil publishes, in the order of an answer in lockstep, and the cycle times that turn it off when 0.
PUBLISHED = {"SERVO_Position": "position_ms", "SERVO_Pressures": "pressures_ms", "SERVO_Relay": "relay_ms",
             "SERVO_Bus": "bus_ms", "SERVO_Safety": "safety_ms", "SERVO_Status": "status_ms"}
MODE_STOPPED, MODE_FROZEN = 3, 4


def unwrapped(tick, last):
    """The tick that a frame carries modulo 2^32, near the one before it (None: there was none)."""
    if last is None:
        return tick
    half = TICK_MODULUS // 2
    return last + (tick - last + half) % TICK_MODULUS - half


def attribute(name, unit):
    """A signal's name in Python, with its unit: X3 in → x3_in, TimingValid → timing_valid, V3 in/s → v3_in_s."""
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)
    unit = unit.replace("%", "percent").replace("°", "deg_")
    return "_".join(filter(None, re.split(r"\W+|_", f"{words}_{unit}"))).lower()


class Contract:
    """The DBC file. canmatrix takes and gives raw integers, so scaling is done here."""

    def __init__(self, file):
        try:
            database = canmatrix.formats.loadp_flat(str(file), import_type="dbc")
        except OSError as error:
            raise Failure(USAGE, f"{file}: {error.strerror}") from None
        except Exception as error:  # canmatrix raises whatever its parser stumbles over
            raise Failure(USAGE, f"{file}: not a DBC file that canmatrix reads: {error}") from None
        self.file = file
        self.messages = {m.name: m for m in database.frames}
        self.by_id = {(m.arbitration_id.id, m.arbitration_id.extended): m for m in database.frames}
        self.p1 = self.require(*COMMAND)
        self.require(*TICK)
        self.command = self.messages[COMMAND[0]]
        self.counter = self.command.signal_by_name("Counter")

    def require(self, message, name):
        if message not in self.messages:
            there = ", ".join(self.messages) or "none"
            raise Failure(USAGE, f"{self.file}: no message {message}; there are {there}")
        found = self.messages[message].signal_by_name(name)
        if found is None:
            raise Failure(USAGE, f"{self.file}: {message} has no signal {name}")
        return found

    def p1_range(self):
        """What the signal's bits can hold, within the range that the file states [psi]."""
        ends = [float(self.p1.offset) + float(self.p1.factor) * raw for raw in self.p1.calculate_raw_range()]
        low, high = min(ends), max(ends)
        if self.p1.min is not None and self.p1.max is not None and self.p1.min < self.p1.max:
            low, high = max(low, float(self.p1.min)), min(high, float(self.p1.max))
        return low, high

    def check_p1(self, p1_psi):
        """Raises a Failure for what no command can carry."""
        low, high = self.p1_range()
        if not low <= p1_psi <= high:
            raise Failure(USAGE, f"P1 {p1_psi:g} psi: {self.file} carries {low:g} to {high:g} psi")

    def encode(self, p1_psi, count):
        """The count-th GOV_Command, for python-can."""
        raw = {COMMAND[1]: round((p1_psi - float(self.p1.offset)) / float(self.p1.factor))}
        if self.counter is not None:
            raw["Counter"] = count % (1 << self.counter.size)
        return can.Message(arbitration_id=self.command.arbitration_id.id, data=self.command.encode(raw),
                           is_extended_id=self.command.arbitration_id.extended)

    def decode(self, frame):
        """(message's name, physical values by signal), or nothing for somebody else's frame."""
        message = self.by_id.get((frame.arbitration_id, frame.is_extended_id))
        if message is None or frame.is_remote_frame or len(frame.data) < message.size:
            return None, {}
        return message.name, {name: float(s.phys_value) for name, s in message.decode(frame.data).items()}

    def attributes(self):
        """Names in Python by (message, signal) of all but the command; the message is named where a signal is not
        enough."""
        signals = [(m, s) for m in self.messages.values() if m is not self.command for s in m.signals]
        names = [attribute(s.name, s.unit or "") for _, s in signals]
        return {(m.name, s.name): name if names.count(name) == 1 else f"{attribute(m.name, '')}_{name}"
                for (m, s), name in zip(signals, names)}

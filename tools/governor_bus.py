"""The bus as the stand-in governor sees it: the DBC file, what came back, and how to connect."""

import csv
import logging
import math
import os
import sys

logging.disable(logging.CRITICAL)  # python-can and canmatrix log what the governor says itself
try:
    import can
    import canmatrix.formats
except ImportError as missing:
    print(f"governor.py: {missing}; it needs Debian's python3-can, python3-serial and python3-canmatrix "
          "(tools/deps.sh demo)", file=sys.stderr)
    sys.exit(3)

COMMAND = ("GOV_Command", "P1_Demand")
TICK = ("SERVO_Position", "Tick")
TICK_S = 1e-4
TICK_MODULUS = 2**32
# Columns of the CSV file, named as those of `servohil simulate`, and the signals that fill them.
COLUMNS = {
    "x3_in": ("SERVO_Position", "X3"), "v3_in_s": ("SERVO_Position", "V3"),
    "p1_psi": ("SERVO_Pressures", "P1_Applied"), "p3_psi": ("SERVO_Pressures", "P3"),
    "p4_psi": ("SERVO_Pressures", "P4"), "p8_psi": ("SERVO_Pressures", "P8"),
    "x1_in": ("SERVO_Relay", "X1"), "x2_in": ("SERVO_Relay", "X2"), "x4_in": ("SERVO_Relay", "X4"),
    "mode": ("SERVO_Status", "Mode"), "timing_valid": ("SERVO_Status", "TimingValid"),
    "model_fault": ("SERVO_Status", "ModelFault"), "late_ticks": ("SERVO_Status", "LateTicks"),
}
MODE_STOPPED = 3
OK, INVALID, USAGE, NOTHING = 0, 1, 2, 3


class Failure(Exception):
    """Ends the program: exit status and one line."""

    def __init__(self, status, text):
        super().__init__(text)
        self.status = status


class Contract:
    """The DBC file. canmatrix knows the layout; it takes and gives raw integers, so scaling is done here."""

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
        """What the signal's bits can hold, within the range that the file states."""
        ends = [float(self.p1.offset) + float(self.p1.factor) * raw for raw in self.p1.calculate_raw_range()]
        low, high = min(ends), max(ends)
        if self.p1.min is not None and self.p1.max is not None and self.p1.min < self.p1.max:
            low, high = max(low, float(self.p1.min)), min(high, float(self.p1.max))
        return low, high

    def encode(self, p1_psi, count):
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


class Record:
    """What came back: a row for every SERVO_Position, completed by the frames that follow it."""

    def __init__(self, contract):
        self.contract = contract
        self.rows = []
        self.count = {}      # frames by message
        self.newest = {}     # values by (message, signal)
        self.last_host_s = None
        self.longest_gap_s = 0.0
        self.restarts = 0    # the tick went back
        self.foreign = 0
        self._tick = None    # as on the bus

    def add(self, frame, host_s, p1_psi):
        name, values = self.contract.decode(frame)
        if name is None or name == COMMAND[0]:
            self.foreign += 1
            return
        if self.last_host_s is not None:
            self.longest_gap_s = max(self.longest_gap_s, host_s - self.last_host_s)
        self.last_host_s = host_s
        self.count[name] = self.count.get(name, 0) + 1
        self.newest.update({(name, s): value for s, value in values.items()})
        if name == TICK[0]:
            self.rows.append({"host_s": host_s, "tick": self._unwrap(int(values[TICK[1]])), "p1_demand_psi": p1_psi})
        if self.rows:
            self.rows[-1].update({c: values[s] for c, (m, s) in COLUMNS.items() if m == name and s in values})

    def _unwrap(self, tick):
        last, self._tick = self._tick, tick
        if last is None:
            return tick
        step = (tick - last) % TICK_MODULUS
        if step >= TICK_MODULUS // 2:
            self.restarts += 1
            step -= TICK_MODULUS
        return self.rows[-1]["tick"] + step

    def status(self, name):
        return self.newest.get(("SERVO_Status", name))

    def series(self):
        """Columns by name; NaN where a frame did not come with this row's tick."""
        columns = {"host_s": [r["host_s"] for r in self.rows], "t_s": [r["tick"] * TICK_S for r in self.rows]}
        for name in ("p1_demand_psi", *COLUMNS):
            columns[name] = [math.nan if r.get(name) is None else r[name] for r in self.rows]
        return columns

    def write(self, file):
        try:
            with open(file, "w", newline="", encoding="utf-8") as stream:
                columns = self.series()
                writer = csv.writer(stream)
                writer.writerow(columns)
                for row in zip(*columns.values()):
                    writer.writerow(["" if value != value else f"{value:.10g}" for value in row])
        except OSError as error:
            raise Failure(NOTHING, f"{file}: {error.strerror}") from None


def connect(args):
    """The bus, or one line about what is missing."""
    if args.can:
        args.interface, _, args.channel = args.can.partition(":")
        if args.can in ("slcan:pty", "auto") or args.can.startswith("slcan:pty:"):
            raise Failure(USAGE, f"--can {args.can} is for the emulator; its line 'ready: ...' says where to connect, "
                                 "e.g. slcan:/dev/pts/3")
    if not args.interface or not args.channel:
        raise Failure(USAGE, "which bus? --can URL (slcan:/dev/pts/3, socketcan:vcan0), or --interface and --channel")
    options = {}
    if args.interface == "slcan":
        options["bitrate"] = args.bitrate
        if os.path.realpath(args.channel).startswith("/dev/pts/"):
            options["sleep_after_open"] = 0.0  # the 2 s are for boards that reset when they are opened
    try:
        return can.Bus(interface=args.interface, channel=args.channel, **options)
    except can.CanInterfaceNotImplementedError:
        raise Failure(USAGE, f"python-can has no interface '{args.interface}'; common ones: slcan, socketcan, pcan, "
                             "kvaser, ixxat") from None
    except Exception as error:  # a driver raises whatever it stumbles over
        hint = ""
        if args.interface == "socketcan":
            hint = ("; is it there and up? sudo ip link add dev vcan0 type vcan && sudo ip link set up vcan0"
                    if args.channel.startswith("vcan") else "; is it there and up? ip -br link show type can")
        elif args.interface == "slcan":
            hint = "; the emulator's line 'ready: ...' names its pseudo-terminal"
        elif not isinstance(error, (can.CanError, OSError, ValueError)):
            hint = "; is the driver of this interface installed?"
        reason = " ".join(str(error).split())
        raise Failure(NOTHING, f"{args.interface} {args.channel}: {reason}{hint}") from None

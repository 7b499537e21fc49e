"""The bus as the stand-in governor sees it: what came back, and how to connect."""

import csv
import logging
import math
import sys

logging.disable(logging.CRITICAL)  # python-can and canmatrix log what the governor says itself
try:
    from servohil_ci import bus
    from servohil_ci.contract import COMMAND, MODE_STOPPED, TICK, TICK_S, Contract, unwrapped
    from servohil_ci.failure import INVALID, NOTHING, OK, USAGE, Failure
    from servohil_ci.libraries import can
except ImportError as missing:
    print(f"governor.py: {missing}; it needs Debian's python3-can, python3-serial and python3-canmatrix "
          "(tools/deps.sh demo)", file=sys.stderr)
    sys.exit(3)

__all__ = ["COLUMNS", "INVALID", "MODE_STOPPED", "NOTHING", "OK", "TICK_S", "USAGE", "Contract", "Failure", "Record",
           "can", "connect"]
# Columns of the CSV file, named as those of `servohil simulate`, and the signals that fill them.
COLUMNS = {
    "x3_in": ("SERVO_Position", "X3"), "v3_in_s": ("SERVO_Position", "V3"),
    "p1_psi": ("SERVO_Pressures", "P1_Applied"), "p3_psi": ("SERVO_Pressures", "P3"),
    "p4_psi": ("SERVO_Pressures", "P4"), "p8_psi": ("SERVO_Pressures", "P8"),
    "x1_in": ("SERVO_Relay", "X1"), "x2_in": ("SERVO_Relay", "X2"), "x4_in": ("SERVO_Relay", "X4"),
    "mode": ("SERVO_Status", "Mode"), "timing_valid": ("SERVO_Status", "TimingValid"),
    "model_fault": ("SERVO_Status", "ModelFault"), "late_ticks": ("SERVO_Status", "LateTicks"),
}


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
            last = self.rows[-1]["tick"] if self.rows else None
            tick = unwrapped(int(values[TICK[1]]), last)
            self.restarts += last is not None and tick < last
            self.rows.append({"host_s": host_s, "tick": tick, "p1_demand_psi": p1_psi})
        if self.rows:
            self.rows[-1].update({c: values[s] for c, (m, s) in COLUMNS.items() if m == name and s in values})

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
    return bus.connect(args.interface, args.channel, args.bitrate)

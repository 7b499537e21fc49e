#!/usr/bin/python3
"""Stand-in governor: sends the control pressure P1 to servohil on CAN and records what comes back.

It shares nothing with the emulator but the DBC file: what both agree on, the bus carries as the file says.
"""

import argparse
import math
import signal
import sys
import time
from pathlib import Path

from governor_bus import (COLUMNS, INVALID, MODE_STOPPED, NOTHING, OK, TICK_S, USAGE, Contract, Failure, Record,
                          can, connect)

SILENCE_S = 2.0  # longer than any cycle time that is of use


class Governor:
    """Sends P1 every cycle, receives in between."""

    def __init__(self, bus, contract, args):
        self.bus, self.contract, self.args = bus, contract, args
        self.record = Record(contract)
        self.stop = False
        self.sent = self.not_sent = 0
        self.trouble = ""
        self.p1_psi = math.nan
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._stop)

    def _stop(self, *_):
        self.stop = True

    def _receive(self, until_s):
        """Frames until then; raises when nothing has come for too long."""
        while not self.stop:
            now = time.monotonic()
            try:
                frame = self.bus.recv(max(0.0, until_s - now))
                if frame is not None:
                    self.record.add(frame, time.monotonic() - self.begin_s, self.p1_psi)
            except (can.CanError, OSError, ValueError) as error:  # interface down, terminal gone, line noise
                self.trouble = f" ({' '.join(str(error).split())})"
                time.sleep(0.01)
            heard_s = self.record.last_host_s
            if time.monotonic() - self.begin_s - (heard_s or 0.0) > SILENCE_S:
                what = "nothing came back" if heard_s is None else "nothing came any more"
                raise Failure(NOTHING, f"{what} for {SILENCE_S:g} s{self.trouble}: does servohil run on this bus, with "
                                       f"the same DBC file ({self.contract.file}) and bit rate?")
            if self.record.status("Mode") == MODE_STOPPED:
                self.stop = True
            if time.monotonic() >= until_s:
                return

    def _send(self, p1_psi):
        self.p1_psi = p1_psi
        try:
            self.bus.send(self.contract.encode(p1_psi, self.sent), timeout=0.1)
            self.sent += 1
        except (can.CanError, OSError) as error:
            self.trouble = f" ({' '.join(str(error).split())})"
            self.not_sent += 1

    def run(self):
        self.begin_s = time.monotonic()
        while self.record.last_host_s is None and not self.stop:
            self._receive(time.monotonic() + 0.02)
        cycle_s = self.args.cycle_ms / 1000.0
        first_s = send_s = report_s = time.monotonic()
        while not self.stop:
            t_s = time.monotonic() - first_s
            if self.args.duration is not None and t_s >= self.args.duration:
                break
            self._send(self.args.profile(t_s))
            if time.monotonic() >= report_s:
                print(self._line(t_s), flush=True)
                report_s += 1.0
            send_s = max(send_s + cycle_s, time.monotonic())  # late: go on from here, no burst
            self._receive(send_s)

    def _line(self, t_s):
        newest = {c: self.record.newest.get(s, math.nan) for c, s in COLUMNS.items()}
        return (f"{t_s:6.1f} s  P1 {self.p1_psi:.3f} psi (applied {newest['p1_psi']:.3f})  x3 {newest['x3_in']:.4f} in  "
                f"v3 {newest['v3_in_s']:+.2f} in/s  P3 {newest['p3_psi']:.2f} psi  {self._verdict()[1]}")

    def _verdict(self):
        """(valid, in words), as the emulator's newest status says."""
        status = self.record.status
        if status("Mode") is None:
            return True, "no SERVO_Status received"
        mode = self.contract.require("SERVO_Status", "Mode").values.get(int(status("Mode")), status("Mode"))
        reasons = []
        if status("TimingValid") == 0:
            reasons.append(f"timing INVALID, {status('LateTicks') or 0:.0f} late ticks")
        if status("ModelFault") == 1:
            reasons.append("MODEL FAULT")
        return not reasons, f"{mode}, " + (" and ".join(reasons) or "timing valid, model ok")

    def summary(self):
        record, args = self.record, self.args
        print(f"sent      {self.sent} commands" + (f", {self.not_sent} not sent{self.trouble}" if self.not_sent else ""))
        series = record.series()
        t_s = series["t_s"]
        span_s = t_s[-1] - t_s[0] if t_s else 0.0
        rates = ", ".join(f"{name} {n} ({(n - 1) / span_s:.1f} a second)" if span_s > 0 and n > 1 else f"{name} {n}"
                          for name, n in record.count.items())
        print(f"received  {rates}; {record.foreign} frames of others; per second of simulated time")
        steps = [round((b - a) / TICK_S) for a, b in zip(t_s, t_s[1:])]
        if steps and record.restarts == 0:
            usual = sorted(steps)[len(steps) // 2]
            missing = sum(step // usual - 1 for step in steps) if usual > 0 else 0
            print(f"gaps      SERVO_Position every {usual / 10:g} ms of simulated time, longest gap "
                  f"{max(steps) / 10:g} ms, {missing} missing; longest silence here {1e3 * record.longest_gap_s:.1f} ms")
        if record.restarts:
            print(f"NOTE      the tick went back {record.restarts} times: the emulator was restarted, or two of them "
                  "are on this bus")
        parts = []
        for column, label, unit in (("x3_in", "x3", "in"), ("v3_in_s", "v3", "in/s"), ("p3_psi", "P3", "psi")):
            part = [y for t, y in zip(t_s, series[column]) if y == y and t >= t_s[-1] - args.last]
            if part:
                parts.append(f"{label} {max(part) - min(part):.4f} {unit} around {sum(part) / len(part):.4f}")
        print(f"ripple    peak to peak in the last {min(args.last, span_s):.2f} s: {', '.join(parts) or 'nothing came'}")
        valid, words = self._verdict()
        print(f"status    {words}")
        return OK if valid or args.accept_invalid else INVALID


class Parser(argparse.ArgumentParser):
    def error(self, message):  # one line, instead of the whole usage before it
        raise Failure(USAGE, f"{message}; --help tells more")


def positive(text):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number above 0")
    return value


def profile(a):
    """P1 over the time since the first command, and its extremes."""
    if a.command == "hold":
        return (lambda t: a.p1), (a.p1, a.p1)
    if a.command == "chirp":  # the frequency rises by the same factor in every second
        rate = math.log(a.f1 / a.f0) / a.over

        def chirp(t):
            t = min(t, a.over)
            cycles = a.f0 * (math.expm1(rate * t) / rate if rate else t)
            return a.p1 + a.amplitude * math.sin(2 * math.pi * cycles)
        return chirp, (a.p1 - a.amplitude, a.p1 + a.amplitude)
    share = {"step": lambda t: float(t >= a.at),
             "ramp": lambda t: min(max((t - a.at) / a.over, 0.0), 1.0),
             "sweep": lambda t: 1.0 - abs(1.0 - 2.0 * (t / a.period % 1.0))}[a.command]
    return (lambda t: a.first + (a.to - a.first) * share(t)), (a.first, a.to)


def add_common(parser, of_command):
    """The options that may stand before or after the command; there, no default covers what stood before."""
    def add(*names, default=None, **more):
        parser.add_argument(*names, default=argparse.SUPPRESS if of_command else default, **more)

    beside = Path(__file__).resolve().parent.parent
    places = [beside / "config", beside / "share" / "servohil", beside]
    dbc = next((p / "servohil.dbc" for p in places if (p / "servohil.dbc").exists()), Path("servohil.dbc"))
    add("--can", metavar="URL", help="slcan:/dev/pts/3, slcan:/dev/ttyACM0, socketcan:vcan0, or any "
        "INTERFACE:CHANNEL of python-can")
    add("--interface", help="python-can's name of the interface, instead of --can")
    add("--channel", help="e.g. /dev/pts/3, vcan0")
    add("--bitrate", type=int, default=500000, metavar="BIT/S", help="of a serial adapter [bit/s]; default: 500000")
    add("--dbc", type=Path, default=dbc, metavar="FILE", help=f"default: {dbc}")
    add("--duration", type=positive, metavar="S", help="ends after this time [s]; default: at Ctrl-C, or when the "
        "emulator says that it stops; chirp: --over")
    add("--cycle-ms", type=positive, default=10.0, metavar="MS", help="sends P1 this often [ms]; default: 10")
    add("--last", type=positive, default=1.0, metavar="S", help="the summary's peak-to-peak is that of the last S "
        "seconds of simulated time [s]; default: 1")
    add("-o", "--output", metavar="CSV", help="what came back: host_s [s] since the first frame was waited for, t_s [s] "
        "simulated, then values with the unit in the name; empty: not sent with this tick")
    add("--plot", metavar="PNG", help="P1, x3, v3 and P3 over simulated time")
    add("--accept-invalid", action="store_true",
        help="exit status 0 even when the status says timing invalid or model fault")


def arguments():
    parser = Parser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 ok; 1 the emulator's last status says that the run is not valid (late ticks: timing\n"
               "INVALID; or a model fault); 2 usage or DBC file; 3 no bus, or nothing came back for 2 s.\n\n"
               "Example: governor.py --can slcan:/dev/pts/3 step 30.263 30.533 --duration 3 -o out.csv")
    add_common(parser, of_command=False)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    values = {"P1": "p1", "FROM": "first", "TO": "to"}
    for name, about, positional, options in (
            ("hold", "constant P1", ["P1"], []),
            ("step", "P1 jumps", ["FROM", "TO"], [("at", "S", "time of the step [s]; default: 1")]),
            ("ramp", "P1 goes straight from one value to another", ["FROM", "TO"],
             [("over", "S", "how long it takes [s]"), ("at", "S", "when it begins [s]; default: 1")]),
            ("sweep", "P1 goes to and fro along a triangle", ["FROM", "TO"],
             [("period", "S", "there and back again [s]")]),
            ("chirp", "P1 is a sine of rising frequency", ["P1"],
             [("amplitude", "PSI", "half of peak to peak [psi]"), ("f0", "HZ", "frequency at the start [Hz]"),
              ("f1", "HZ", "frequency at the end [Hz]"), ("over", "S", "from f0 to f1 [s]")])):
        command = commands.add_parser(name, help=about, description=about + "; time from the first command on")
        for value in positional:
            command.add_argument(values[value], type=float, metavar=value, help="P1 [psi gauge]")
        for option, unit, text in options:
            command.add_argument(f"--{option}", type=positive, metavar=unit, help=text,
                                 **({"default": 1.0} if option == "at" else {"required": True}))
        add_common(command, of_command=True)
    args = parser.parse_args()
    if args.command == "chirp":
        if args.f1 > 500.0 / args.cycle_ms:
            parser.error(f"--f1 {args.f1:g} Hz: commands every {args.cycle_ms:g} ms carry at most "
                         f"{500.0 / args.cycle_ms:g} Hz")
        args.duration = args.duration or args.over
    return args


def main():
    args = arguments()
    contract = Contract(args.dbc)
    args.profile, extremes = profile(args)
    for p1_psi in extremes:
        contract.check_p1(p1_psi)
    bus = connect(args)
    governor = Governor(bus, contract, args)
    failure = None
    try:
        governor.run()
    except Failure as error:
        failure = error
    finally:
        try:
            bus.shutdown()
        except (can.CanError, OSError):
            pass  # the emulator went first
    if failure and not governor.record.rows:
        raise failure
    if args.output:
        governor.record.write(args.output)
    status = governor.summary()
    if args.plot:
        import plot
        try:
            plot.draw(args.plot, [("servohil", governor.record.series())],
                      ["p1_psi", "x3_in", "v3_in_s", "p3_psi"])
        except (plot.Mistake, ImportError) as error:
            raise Failure(NOTHING, str(error)) from None
    if failure:
        raise failure
    return status


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failure as failure:
        print(f"governor.py: {failure}", file=sys.stderr)
        sys.exit(failure.status)

#!/usr/bin/python3
"""Plots time series of `servohil simulate` and of governor.py: one panel a quantity, one curve a file. Or a recording
(`--record`): command, position as it was and as the frames said, pressures, friction, and faults as shaded bands."""

import argparse
import csv
import sys
from pathlib import Path

# Column of the CSV files → what a panel's axis says.
QUANTITIES = {
    "p1_demand_psi": "Demanded control\npressure P1 [psi]",
    "p1_psi": "Control oil\npressure P1 [psi]",
    "x3_in": "Piston\nposition x3 [in]",
    "v3_in_s": "Piston\nvelocity v3 [in/s]",
    "p3_psi": "Pressure under\nthe piston P3 [psi]",
    "p4_psi": "Pressure above the\nrelay plunger P4 [psi]",
    "p8_psi": "Pressure in the\nstabilizer P8 [psi]",
    "x1_in": "Relay piston x1 [in]",
    "x2_in": "Relay plunger x2 [in]",
    "x4_in": "Relay bushing x4 [in]",
    "friction_psi": "Coulomb\nfriction [psi]",
}
COLOURS = ("#c0392b", "#1f5fa8", "#2e8b57", "#8e6bbf", "#7f7f7f")
STEP_PSI = 0.02  # a change of P1 this large is a step, not the resolution of the frame (0.005 psi)


class Mistake(Exception):
    """One line for the user."""


def read(file):
    """Columns of a CSV file with a header; an empty field is NaN."""
    try:
        with open(file, newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        if not rows:
            raise Mistake(f"{file}: no rows")
        return {name: [float(row[name] or "nan") for row in rows] for name in rows[0]}
    except OSError as error:
        raise Mistake(f"{file}: {error.strerror}") from None
    except (ValueError, TypeError):
        raise Mistake(f"{file}: not a table of numbers with a header") from None


def step_time(run, name):
    """Time of the last sample before P1 first changes."""
    known = [(t, p1) for t, p1 in zip(run["t_s"], run["p1_psi"]) if p1 == p1]
    for (t, _), (_, p1) in zip(known, known[1:]):
        if abs(p1 - known[0][1]) > STEP_PSI:
            return t
    raise Mistake(f"{name}: P1 has no step of more than {STEP_PSI} psi")


def swing(run, column, window):
    """Peak to peak of a column between two times, in words."""
    part = [y for t, y in zip(run["t_s"], run[column]) if window[0] <= t <= window[1] and y == y]
    value = max(part) - min(part) if part else float("nan")
    name, unit = QUANTITIES.get(column, f"{column} []").split()[-2:]
    return f"{name} {value:.4g} {unit.strip('[]')}"


def draw(output, runs, columns, title="", window=None, time_label="Simulated time [s]"):
    """PNG (or what the name's ending says) of `runs`, [(label, columns by name)]; window in s."""
    import matplotlib  # takes a second: only when there is something to draw

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(len(columns), 1, sharex=True, squeeze=False,
                                  figsize=(10, 1.4 + 2.3 * len(columns)))
    for column, (axes,) in zip(columns, panels):
        for (label, run), colour in zip(runs, COLOURS):
            points = [(t, y) for t, y in zip(run["t_s"], run.get(column, ())) if y == y]
            if window:
                points = [(t, y) for t, y in points if window[0] <= t <= window[1]]
            axes.plot(*zip(*points) if points else ((), ()), color=colour, linewidth=1.2, label=label)
        axes.set_ylabel(QUANTITIES.get(column, column))
        axes.ticklabel_format(useOffset=False)
        axes.grid(True, alpha=0.3)
        if window:
            axes.set_xlim(*window)
    panels[-1][0].set_xlabel(time_label)
    figure.align_ylabels()
    if len(runs) > 1:
        panels[0][0].legend(loc="best", fontsize=11)
    headline, _, details = title.partition("\n")
    figure.suptitle(headline, fontsize=14, fontweight="bold")
    panels[0][0].set_title(details, fontsize=10)
    figure.tight_layout()
    try:
        Path(output).parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(output, dpi=120)
    except (OSError, ValueError) as error:
        raise Mistake(f"{output}: cannot be written: {error}") from None
    finally:
        plt.close(figure)


class Parser(argparse.ArgumentParser):
    def error(self, message):  # one line, instead of the whole usage before it
        raise Mistake(f"{message}; --help tells more")


def arguments():
    parser = Parser(description=__doc__)
    parser.add_argument("files", nargs="+", metavar="CSV|RECORDING",
                        help="files with the column t_s [s], or the directory of one recording")
    parser.add_argument("--columns", default="p1_psi,x3_in,v3_in_s,p3_psi", metavar="NAME,...",
                        help="a panel each, from the top; default: %(default)s; units are in the names")
    parser.add_argument("--label", action="append", default=[], metavar="TEXT",
                        help="of each file in turn; default: its name")
    parser.add_argument("--title", default="", help="above the panels; a second line is set smaller")
    parser.add_argument("--from-step", action="store_true",
                        help=f"t = 0 at the first step of p1_psi (more than {STEP_PSI} psi) of each file")
    parser.add_argument("--window", nargs=2, type=float, metavar=("FROM", "TO"), help="shown time [s]")
    parser.add_argument("--swing", nargs=2, type=float, metavar=("FROM", "TO"),
                        help="prints the peak to peak of the --swing-columns between these times [s]")
    parser.add_argument("--swing-columns", default="v3_in_s,p3_psi", metavar="NAME,...", help="default: %(default)s")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="e.g. response.png")
    return parser.parse_args()


def draw_recording(args):
    from plot_recording import Recording, draw as draw_it
    try:
        recording = Recording(args.files[0])
    except (OSError, KeyError) as error:
        raise Mistake(f"{args.files[0]}: not a recording that can be read: {error}") from None
    draw_it(recording, args.output, tuple(args.window) if args.window else None, args.title)


def main():
    args = arguments()
    if Path(args.files[0]).is_dir() or args.files[0].endswith(".h5"):
        if len(args.files) > 1:
            raise Mistake("one recording at a time")
        return draw_recording(args)
    if len(args.files) > len(COLOURS):
        raise Mistake(f"{len(args.files)} files: at most {len(COLOURS)} can be told apart")
    columns = args.columns.split(",")
    swing_columns = args.swing_columns.split(",") if args.swing else []
    runs = []
    for i, file in enumerate(args.files):
        run = read(file)
        for column in ["t_s", *columns, *swing_columns, *(["p1_psi"] if args.from_step else [])]:
            if column not in run:
                raise Mistake(f"{file}: no column {column}; there are {', '.join(run)}")
        if args.from_step:
            zero = step_time(run, file)
            run["t_s"] = [t - zero for t in run["t_s"]]
        runs.append((args.label[i] if i < len(args.label) else Path(file).stem, run))
    if args.swing:
        for label, run in runs:
            print(f"{label}: " + ", ".join(swing(run, c, args.swing) for c in swing_columns))
    draw(args.output, runs, columns, args.title, args.window,
         "Simulated time after the step of P1 [s]" if args.from_step else "Simulated time [s]")


if __name__ == "__main__":
    try:
        main()
    except Mistake as mistake:
        print(f"plot.py: {mistake}", file=sys.stderr)
        sys.exit(2)

#!/usr/bin/python3
"""Draws the stability map of `servohil linear --map ... -o map.csv`: damping of the least damped mode in colour, the
stability boundary as a line.

Exit status: 0 drawn; 2 wrong usage or file; 3 matplotlib is missing.
"""

import argparse
import csv
import math
import sys

COLUMNS = ["largest_real_1_s", "damping", "frequency_rad_s", "status"]


class Mistake(Exception):
    """One line for the user."""


def read(file):
    """(names of the two axes, their values, {column: rows over the second axis, columns over the first})."""
    try:
        with open(file, newline="", encoding="utf-8") as stream:
            table = csv.reader(stream)
            header = next(table, [])
            rows = list(table)
    except OSError as error:
        raise Mistake(f"{file}: {error.strerror}") from None
    if header[2:] != COLUMNS or not rows:
        raise Mistake(f"{file}: not a map of `servohil linear --map`")
    try:
        xs, ys = (sorted({float(row[i]) for row in rows}) for i in (0, 1))
        grid = {name: [[math.nan] * len(xs) for _ in ys] for name in COLUMNS[:3]}
        for row in rows:
            i, j = xs.index(float(row[0])), ys.index(float(row[1]))
            for name, text in zip(COLUMNS[:3], row[2:]):
                grid[name][j][i] = float(text or "nan")
    except (ValueError, IndexError):
        raise Mistake(f"{file}: a row is not a row of numbers") from None
    if len(rows) != len(xs) * len(ys):
        raise Mistake(f"{file}: {len(rows)} rows, a full grid has {len(xs) * len(ys)}")
    return header[:2], xs, ys, grid


def label(key):
    """servo.underlap_in → servo.underlap [in]"""
    for ending, unit in (("_lbf_s2_in4", "lbf s²/in⁴"), ("_lbf_s_in2", "lbf s/in²"), ("_lbf_s2_in", "lbf s²/in"),
                         ("_lbf_in", "lbf/in"), ("_in2", "in²"), ("_in3", "in³"), ("_psi", "psi"), ("_lbf", "lbf"),
                         ("_in", "in")):
        if key.endswith(ending):
            return f"{key[:-len(ending)]} [{unit}]"
    return key


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", metavar="CSV")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="e.g. map.png")
    parser.add_argument("--title", default="Stability of the linear model")
    args = parser.parse_args()
    names, xs, ys, grid = read(args.map)
    try:
        import matplotlib
    except ImportError:
        print("plot_map.py: matplotlib is missing: sudo apt install python3-matplotlib", file=sys.stderr)
        return 3
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.colors import TwoSlopeNorm
    from matplotlib.lines import Line2D

    known = [d for row in grid["damping"] for d in row if not math.isnan(d)]
    if not known:
        raise Mistake(f"{args.map}: no point has a steady state")
    largest = max(max(map(abs, known)), 1e-6)
    figure, axes = plt.subplots(figsize=(8.5, 6))
    axes.set_facecolor("#dddddd")  # no steady state
    colours = axes.pcolormesh(xs, ys, grid["damping"], cmap="RdBu", shading="nearest",
                              norm=TwoSlopeNorm(0.0, -largest, largest))
    figure.colorbar(colours, label="damping of the least damped mode (negative: unstable)")
    real = [r for row in grid["largest_real_1_s"] for r in row if not math.isnan(r)]
    if min(real) < 0.0 < max(real):
        axes.contour(xs, ys, grid["largest_real_1_s"], levels=[0.0], colors="black", linewidths=2.0)
        axes.legend(handles=[Line2D([], [], color="black", linewidth=2.0, label="stability boundary")], loc="best")
    else:
        axes.text(0.5, 0.97, "stable everywhere" if max(real) < 0.0 else "unstable everywhere",
                  transform=axes.transAxes, ha="center", va="top")
    axes.set_xlabel(label(names[0]))
    axes.set_ylabel(label(names[1]))
    axes.set_title(args.title)
    figure.tight_layout()
    try:
        figure.savefig(args.output, dpi=110)
    except (OSError, ValueError) as error:
        raise Mistake(f"{args.output}: cannot be written: {error}") from None
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Mistake as mistake:
        print(f"plot_map.py: {mistake}", file=sys.stderr)
        sys.exit(2)

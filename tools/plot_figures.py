#!/usr/bin/python3
"""Draws what `servohil thesis --plots DIR` wrote: DIR/figures.json and a CSV file per figure → a PNG per figure.

Exit status: 0 drawn; 2 wrong usage or files; 3 matplotlib is missing.
"""

import argparse
import csv
import json
import sys
import textwrap
from pathlib import Path

COLOURS = ("#1f5fa8", "#c0392b")


class Mistake(Exception):
    """One line for the user."""


def read(file):
    """Columns of a CSV file with a header."""
    try:
        with open(file, newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        return {name: [float(row[name]) for row in rows] for name in rows[0]}
    except OSError as error:
        raise Mistake(f"{file}: {error.strerror}") from None
    except (ValueError, TypeError, IndexError):
        raise Mistake(f"{file}: not a table of numbers with a header") from None


def draw(figure, folder, plt):
    columns = read(folder / f"{figure['name']}.csv")
    canvas, axes = plt.subplots(figsize=(8, 5.2))
    for curve, colour in zip(figure["curves"], COLOURS):
        axes.plot(columns[curve["x"]], columns[curve["y"]], color=colour, linewidth=1.2, label=curve["label"])
    if len(figure["curves"]) > 1:
        axes.legend(loc="best")
    axes.set_xlabel(figure["x_label"])
    axes.set_ylabel(figure["y_label"])
    axes.ticklabel_format(useOffset=False)
    axes.grid(True, alpha=0.3)
    axes.margins(x=0)
    # As in the source, the caption stands below.
    canvas.text(0.5, 0.02, textwrap.fill(figure["caption"], 100), ha="center", va="bottom", fontsize=9)
    canvas.tight_layout(rect=(0, 0.11, 1, 1))
    target = folder / f"{figure['name']}.png"
    try:
        canvas.savefig(target, dpi=100)
    except OSError as error:
        raise Mistake(f"{target}: {error.strerror}") from None
    finally:
        plt.close(canvas)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="DIR")
    folder = parser.parse_args().folder
    try:
        figures = json.loads((folder / "figures.json").read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError) as error:
        raise Mistake(f"{folder / 'figures.json'}: {error}") from None
    try:
        import matplotlib
    except ImportError:
        print("plot_figures.py: matplotlib is missing: sudo apt install python3-matplotlib", file=sys.stderr)
        return 3
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    for figure in figures:
        draw(figure, folder, plt)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Mistake as mistake:
        print(f"plot_figures.py: {mistake}", file=sys.stderr)
        sys.exit(2)

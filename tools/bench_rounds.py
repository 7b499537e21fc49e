"""What the benchmarks share: measurements by turns, so that each meets the same machine, and their table.

A measurement is a function that returns numbers by name. Of each number the table shows the median over the rounds and
its range (min..max). Ratios are taken within a round: what disturbs all of it cancels.
"""
import os
import signal
import statistics
import subprocess
import sys
from pathlib import Path

ENVIRONMENT = 3  # exit status: the machine lacks something
REPOSITORY = Path(__file__).resolve().parent.parent
PROGRAM = Path(os.environ.get("SERVOHIL_BUILD", REPOSITORY / "build" / "release")).resolve() / "bin" / "servohil"


def fail(text):
    print(f"{Path(sys.argv[0]).name}: {text}", file=sys.stderr)
    sys.exit(ENVIRONMENT)


def end_children_on_sigterm():
    """As an exception, so that what was started is ended."""
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))


def finished(command, accepted=(0,)):
    """A command that has run to its end; else one line that says what it said."""
    try:
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, cwd=REPOSITORY)
    except FileNotFoundError:
        fail(f"{command[0]} is missing; tools/bench.sh builds or installs it")
    if done.returncode not in accepted:
        fail(f"{command[0]} ended with {done.returncode}: {(done.stderr or done.stdout).strip().splitlines()[-1]}")
    return done


def alternate(measurements, rounds):
    """{name: [numbers of each round]}, one of each a round; the order turns, so that none is always the first."""
    results = {name: [] for name in measurements}
    order = list(measurements)
    for number in range(rounds):
        for name in order[number % len(order):] + order[:number % len(order)]:
            results[name].append(measurements[name]())
    return results


def ratios(results, of, to):
    """Of each round: the numbers of `of` over those of `to`."""
    return [{key: over(mine[key], theirs[key]) for key in mine if key in theirs}
            for mine, theirs in zip(results[of], results[to])]


def over(mine, theirs):
    return mine / theirs if theirs else float("nan")


def spread(rounds, key, digits=1):
    values = [numbers[key] for numbers in rounds]
    return f"{statistics.median(values):.{digits}f} ({min(values):.{digits}f}..{max(values):.{digits}f})"


def print_row(name, cells):
    print(f"{name:<22}" + "".join(f"{cell:>28}" for cell in cells), flush=True)


def print_table(columns, rows, goals=None):
    """columns: {key: heading}; rows: [(name, numbers of each round, digits)]; goals: {key: text}."""
    print_row("", columns.values())
    for name, rounds, digits in rows:
        print_row(name, [spread(rounds, key, digits) for key in columns])
    if goals:
        print_row("goal of the ratio", [goals.get(key, "") for key in columns])

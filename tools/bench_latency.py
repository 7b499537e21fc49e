#!/usr/bin/python3
"""Wake-up latency of servohil's loop beside cyclictest's: same priority, period and CPU, alternating in one run.

Prints median, 99.9 % and maximum of each round, then the medians over the rounds and their ratios
(servohil / cyclictest). Goal: 99.9 % at most 1.2 times cyclictest's. Needs real-time privilege (root).
"""
import argparse
import os
import pathlib
import re
import statistics
import subprocess
import sys

PROGRAM = pathlib.Path(__file__).resolve().parent.parent / "build/release/bin/servohil"
PRIORITY = 80
PERIOD_US = 100


def servohil_us(cpu: int, seconds: int) -> tuple[float, float, float]:
    """Median, 99.9 % and worst wake-up latency [us] of `servohil run` at one tick a wake-up."""
    run = subprocess.run(
        [PROGRAM, "run", "--can", "slcan:pty", "--rt", "require", "--duration", str(seconds), "--set", "loop.wake_ticks=1",
         "--set", f"loop.priority={PRIORITY}", "--set", f"loop.cpu={cpu}"], capture_output=True, text=True)
    found = re.search(r"latency median ([\d.]+) us, 99.9 % ([\d.]+) us, worst ([\d.]+) us", run.stdout)
    if not found:
        sys.exit(f"bench: servohil did not run: {run.stderr.strip()}")
    return float(found[1]), float(found[2]), float(found[3])


def cyclictest_us(cpu: int, seconds: int) -> tuple[float, float, float]:
    """The same of cyclictest, from its 1 us histogram."""
    run = subprocess.run(
        ["cyclictest", "-q", "-m", "-t1", "-a", str(cpu), "-p", str(PRIORITY), "-i", str(PERIOD_US), "-D", str(seconds),
         "-h", "20000"], capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"bench: cyclictest did not run: {run.stderr.strip()}")
    counts = {int(us): int(n) for us, n in re.findall(r"^(\d{6}) (\d+)$", run.stdout, re.MULTILINE)}
    worst = float(re.search(r"# Max Latencies: (\d+)", run.stdout)[1])
    total = sum(counts.values())
    if total == 0:
        sys.exit("bench: cyclictest recorded nothing")

    def quantile(fraction: float) -> float:
        below = 0
        for us in sorted(counts):
            below += counts[us]
            if below >= fraction * total:
                return float(us)
        return worst

    return quantile(0.5), quantile(0.999), worst


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="how often each runs (default 5)")
    parser.add_argument("--seconds", type=int, default=10, help="length of each run [s] (default 10)")
    parser.add_argument("--cpu", type=int, default=max(os.sched_getaffinity(0)), help="CPU of both (default: the last)")
    arguments = parser.parse_args()

    runs = {"cyclictest": (cyclictest_us, []), "servohil": (servohil_us, [])}
    print(f"priority {PRIORITY}, period {PERIOD_US} us, CPU {arguments.cpu}; all in us")
    print(f"{'round':<6}{'':<12}{'median':>9}{'99.9 %':>9}{'max':>10}")
    for number in range(1, arguments.rounds + 1):
        for name, (measure, results) in runs.items():
            results.append(measure(arguments.cpu, arguments.seconds))
            print(f"{number:<6}{name:<12}" + "".join(f"{us:>9.1f}" for us in results[-1]), flush=True)
    medians = {name: [statistics.median(column) for column in zip(*results)] for name, (_, results) in runs.items()}
    for name, values in medians.items():
        print(f"{'all':<6}{name:<12}" + "".join(f"{us:>9.1f}" for us in values))
    ratios = [ours / theirs if theirs else float("inf") for ours, theirs in zip(medians["servohil"], medians["cyclictest"])]
    print(f"{'ratio':<6}{'':<12}" + "".join(f"{ratio:>9.2f}" for ratio in ratios))


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Latencies of `servohil run` at 0.1 ms, one tick a wake-up, as ratios within one run of this program:

 - wake-ups beside cyclictest's, same priority, period and CPU, on the machine as it is and under stress-ng
 - wake-ups while every tick is recorded and every message published each 1 ms ("both"), and while only the latter is so
   ("published"), beside a run that does neither; in all, a client reads all frames and sends a command every 10 ms

Each number is the median over the rounds and (min..max). Needs real-time privilege. Nothing is asserted.
"""
import argparse
import os
import subprocess
import tempfile

from bench_rounds import alternate, end_children_on_sigterm, print_table, ratios
from bench_runs import (PERIOD_US, PRIORITY, QUANTILES, cyclictest_us, load, quantiles_us, require_real_time,
                        run_servohil, traffic_of)

COLUMNS = {name: f"{name} [us]" for name in QUANTILES}
EVERY_MS = [word for message in ("position", "pressures", "relay", "status")
            for word in ("--set", f"publish.{message}_ms=1")]
TRAFFIC = {"late": "late ticks", "sent": "frames sent [1/s]", "not_sent": "not sent [1/s]",
           "commands": "commands [1/s]"}
LOAD = "stress-ng"


def beside_cyclictest(arguments):
    measurements = {"cyclictest": lambda: cyclictest_us(arguments.seconds, arguments.cpu),
                    "servohil": lambda: plain_us(arguments)}
    results = alternate(measurements, arguments.rounds)
    print_table(COLUMNS, [("cyclictest", results["cyclictest"], 1), ("servohil", results["servohil"], 1),
                          ("servohil/cyclictest", ratios(results, "servohil", "cyclictest"), 2)],
                {"p99.9": "at most 1.10"})


def plain_us(arguments):
    return quantiles_us(run_servohil([], arguments.seconds, arguments.cpu, with_client=False)["wake_latency"])


def recorded(arguments):
    """Statistics of a run that records and publishes all there is."""
    with tempfile.TemporaryDirectory(prefix="servohil-bench-", dir=arguments.record_dir) as folder:
        recording = ["--record", os.path.join(folder, "recording")]
        return run_servohil([*EVERY_MS, *recording], arguments.seconds, arguments.cpu, with_client=True)


def cost_of_recording(arguments):
    measurements = {"neither": lambda: run_servohil([], arguments.seconds, arguments.cpu, with_client=True),
                    "published": lambda: run_servohil(EVERY_MS, arguments.seconds, arguments.cpu, with_client=True),
                    "both": lambda: recorded(arguments)}
    results = alternate(measurements, arguments.rounds)
    print("-- what they did")
    print_table(TRAFFIC, [(name, [traffic_of(run, arguments.seconds) for run in rounds], 0)
                          for name, rounds in results.items()])
    goals = dict.fromkeys(("p50", "p99", "p99.9"), "at most 1.05")
    for what, with_ratio, goal in [("wake_latency", True, goals), ("compute", True, None),
                                   ("arrival_to_tick", False, None), ("arrival_to_frame", False, None)]:
        us = {name: [quantiles_us(statistics[what]) for statistics in rounds] for name, rounds in results.items()}
        print(f"-- {what}")
        rows = [(name, us[name], 1) for name in measurements]
        if with_ratio:
            rows += [(f"{name}/neither", ratios(us, name, "neither"), 2) for name in ("published", "both")]
        print_table(COLUMNS, rows, goal)


def file_system(folder):
    found = subprocess.run(["findmnt", "-no", "FSTYPE", "-T", folder], capture_output=True, text=True)
    return found.stdout.strip() or "?"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="how often each runs; default 5")
    parser.add_argument("--seconds", type=int, default=4, help="length of each run [s]; default 4")
    parser.add_argument("--cpu", type=int, default=max(os.sched_getaffinity(0)), help="CPU of both; default: the last")
    parser.add_argument("--record-dir", default=tempfile.gettempdir(), metavar="DIR",
                        help="where to record, for a moment; default: $TMPDIR or /tmp")
    arguments = parser.parse_args()
    end_children_on_sigterm()
    require_real_time()

    of_each = f"{arguments.rounds} rounds by turns, {arguments.seconds} s each"
    print(f"== wake-ups, machine as it is: SCHED_FIFO {PRIORITY}, period {PERIOD_US} us, CPU {arguments.cpu}; "
          f"{of_each}")
    beside_cyclictest(arguments)
    print(f"== wake-ups under {LOAD} (CPU, memory, disk); {of_each}")
    with load(limit_s=4 * arguments.rounds * arguments.seconds + 60):
        beside_cyclictest(arguments)
    print(f"== recording every tick ({file_system(arguments.record_dir)}) and publishing every message each 1 ms, "
          f"beside neither; {of_each}")
    cost_of_recording(arguments)


if __name__ == "__main__":
    main()

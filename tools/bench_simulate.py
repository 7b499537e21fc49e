#!/usr/bin/python3
"""`servohil simulate` of 60 s with stabilizer and friction, in motion, without and with a recording: against real
time, and its CPU time against that of as many ticks (tick_benchmark, MeanTick/stabilizer_and_friction), by turns.

Each number is the median over the rounds and (min..max), start of the process included. Nothing is asserted.
"""
import argparse
import json
import os
import resource
import tempfile
import time

from bench_rounds import PROGRAM, alternate, end_children_on_sigterm, finished, print_row, spread

SIMULATED_S = 60
TICKS = SIMULATED_S * 10_000
START_X3_IN = 4
MODEL = ["--set", "friction.coulomb_psi=5", "--set", "stabilizer.enabled=true"]  # as tick_benchmark
GOAL_S = {"simulated": 0.3, "recorded": 1.5}


def write_motion(file):
    """A triangle of 2 s and +-0.5 psi about rest, as tick_benchmark's, a value every 10 ms: seldom at rest."""
    rest_psi = json.loads(finished([PROGRAM, "steady", *MODEL, "--x3", START_X3_IN, "--json"]).stdout)["p1_psi"]
    with open(file, "w", encoding="utf-8") as stream:
        stream.write("t_s,p1_psi\n")
        for k in range(100 * SIMULATED_S):
            stream.write(f"{k / 100:.2f},{rest_psi + abs(k / 100 % 2 - 1) - 0.5:.4f}\n")


def tick_ns():
    """CPU time of one tick."""
    done = finished([PROGRAM.with_name("tick_benchmark"), "--benchmark_filter=^MeanTick/stabilizer_and_friction$",
                     "--benchmark_min_time=0.2", "--benchmark_format=json"])
    return json.loads(done.stdout)["benchmarks"][0]["cpu_time"]


def cpu_s():
    """Of all processes that this one has started and that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def simulate_s(*arguments):
    """Time by the clock, and of all threads on a CPU."""
    begin_s, begin_cpu_s = time.monotonic(), cpu_s()
    finished([PROGRAM, "simulate", *MODEL, "--x3", START_X3_IN, "--duration", SIMULATED_S, *arguments])
    return {"s": time.monotonic() - begin_s, "cpu_s": cpu_s() - begin_cpu_s}


def record_s(motion, record_dir):
    with tempfile.TemporaryDirectory(prefix="servohil-bench-", dir=record_dir) as folder:
        return simulate_s("--p1-file", motion, "--record", os.path.join(folder, "recording"))


def measure(arguments, motion):
    return alternate({
        "tick": lambda: {"ns": tick_ns()},
        "simulated": lambda: simulate_s("--p1-file", motion, "--every", TICKS, "-o", "/dev/null"),
        "recorded": lambda: record_s(motion, arguments.record_dir),
    }, arguments.rounds)


def report(results):
    print(f"one tick: {spread(results['tick'], 'ns', 0)} ns of CPU time; goal at most 250")
    print_row("", ["time [s]", "goal", "times real time", "goal", "CPU time [s]", "CPU time / ticks' CPU time"])
    for name, goal_s in GOAL_S.items():
        rows = [{**r, "speed": SIMULATED_S / r["s"], "of_ticks": r["cpu_s"] / (TICKS * 1e-9 * tick["ns"])}
                for r, tick in zip(results[name], results["tick"])]
        print_row(name, [spread(rows, "s", 3), f"at most {goal_s:g}", spread(rows, "speed", 0),
                         f"at least {SIMULATED_S / goal_s:.0f}", spread(rows, "cpu_s", 3), spread(rows, "of_ticks", 2)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="how often each runs; default 5")
    parser.add_argument("--record-dir", default=tempfile.gettempdir(), metavar="DIR",
                        help="where to record, for a moment; default: $TMPDIR or /tmp")
    arguments = parser.parse_args()
    end_children_on_sigterm()
    print(f"== simulate of {SIMULATED_S} s with stabilizer and friction; {arguments.rounds} rounds by turns")
    with tempfile.NamedTemporaryFile("w", suffix=".csv") as motion:
        write_motion(motion.name)
        report(measure(arguments, motion.name))


if __name__ == "__main__":
    main()

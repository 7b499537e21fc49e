#!/usr/bin/python3
"""Golden data of the nonlinear model: see README.md.

generate.py             solve every case and write cases.json
generate.py --check     solve again and compare with the stored file (1e-7)
generate.py --expected  the exact figures of the reference's expected.md
generate.py --dead-band steady P1 and the change that friction holds, as stored in definitions.py
generate.py --verdicts  Tables IV and VII with the criterion of definitions.py
generate.py --accuracy  agreement of methods, tolerances, perturbed starts (some 20 minutes)
generate.py --rk4       error of plain RK4 at 0.1 ms, naive at every kink: what a fixed step costs
CASE ...                only the cases whose name contains one of these words
"""

import argparse
import json
import math
import platform
import sys
import time

import numpy as np
import scipy
from scipy.optimize import brentq

import definitions as d
from servomotor import HERE, Servomotor, Settings, eigenvalues, parameters, simulate

GOLDEN = HERE / "cases.json"
COLUMNS = ("x3_in", "v3_in_s", "p3_psi", "p4_psi", "p8_psi")
CHECK_TOLERANCE = 1e-7
REST_S = 1e-3      # stick phases at least this long ...
REST_DEPTH_PSI = 0.1  # ... in which the drive gets this far from breakaway are stored

# expected.md: x3 at 0.02, 0.05, 0.10 s after 0.27 psi from 4.0 in
EXPECTED_X3_IN = {
    "IV-1": (4.0735363, 4.1102289, 4.1155441), "IV-3": (4.0691111, 4.1054777, 4.1152091),
    "IV-4": (4.0709549, 4.1074674, 4.1157198), "IV-5": (4.0697885, 4.1057099, 4.1148690),
    "VII-2": (4.0717491, 4.1086575, 4.1160298), "VII-4": (4.0733113, 4.1143974, 4.1184183),
    "VII-5": (4.0746805, 4.1114794, 4.1156197)}


def at(tick):
    return round(tick * d.TICK_S, 4)


def schedule(case, steady):
    if case["p1"]["kind"] == "step":
        return [(0.0, steady["P1"] + case["p1"]["delta_psi"])]
    return [(at(n), p) for n, p in d.p1_rows(case["p1"], case["duration_s"])]


def solve(case, settings=None, perturb=0.0):
    servo = Servomotor(parameters(case["set"]))
    steady = servo.steady(case["start_x3_in"])
    y0 = steady["y"].copy()
    y0[0] += perturb
    times = [at(n) for n in d.sample_ticks(case["duration_s"])]
    return servo, simulate(servo, y0, schedule(case, steady), times, settings)


def golden(case, result):
    stored = dict(case)
    for j, name in enumerate(COLUMNS):
        if name != "p8_psi" or case["set"].get("stabilizer.enabled"):
            stored[name] = [float(f"{c:.12g}") for c in result.samples[:, j]]
    stored["stuck"] = result.stuck
    stored["rest_s"] = [[round(a, 7), round(b, 7)] for a, b, depth in result.rest if b - a >= REST_S and depth >= REST_DEPTH_PSI]
    return stored


def deviation(stored, samples):
    """Largest |difference| of any column, in units of max(1, largest magnitude of the column)."""
    worst = 0.0
    for j, name in enumerate(COLUMNS):
        if name in stored:
            a = np.array(stored[name])
            worst = max(worst, np.max(np.abs(samples[:, j] - a)) / max(1.0, np.max(np.abs(a))))
    return worst


def write(cases):
    """One line per case property: readable, and small."""
    head = {"generator": "tests/data/reference/generate.py", "python": platform.python_version(),
            "numpy": np.__version__, "scipy": scipy.__version__,
            "ticks": {str(s): d.sample_ticks(s) for s in sorted({c["duration_s"] for c in cases})}}
    lines = ["{"]
    lines += [f'"{k}": {json.dumps(v)},' for k, v in head.items()]
    blocks = ["{" + ",\n ".join(f"{json.dumps(k)}: {json.dumps(v, separators=(',', ':'))}" for k, v in c.items()) + "}"
              for c in cases]
    lines += ['"cases": [', ",\n".join(blocks), "]", "}"]
    GOLDEN.write_text("\n".join(lines) + "\n")


def generate(cases):
    out = []
    for case in cases:
        begun = time.time()
        _, r = solve(case)
        out.append(golden(case, r))
        if min(r.low[2:]) <= 0:
            sys.exit(f"{case['name']}: a pressure is not positive: {r.low}")
        crossed = {n: sum(e == n for _, e in r.events) for n in sorted({e for _, e in r.events})}
        print(f"{case['name']:26} x3 {r.low[0]:.3f}..{r.high[0]:.3f}  v3 {r.low[1]:6.1f}..{r.high[1]:5.1f}"
              f"  P3 {r.low[2]:5.1f}..{r.high[2]:5.1f}  P4 {r.low[3]:6.3f}..{r.high[3]:5.2f}"
              f"  {time.time() - begun:.1f} s  {crossed}", flush=True)
    return out


def check(cases):
    stored = {c["name"]: c for c in json.loads(GOLDEN.read_text())["cases"]}
    worst = 0.0
    for case in cases:
        old = stored.get(case["name"])
        if old is None or any(old[k] != json.loads(json.dumps(case[k])) for k in case):
            sys.exit(f"{case['name']}: the stored case is not the defined one; run generate.py")
        _, r = solve(case)
        deviated = deviation(old, r.samples)
        flags = sum(a != b for a, b in zip(old["stuck"], r.stuck))
        worst = max(worst, deviated)
        print(f"{case['name']:26} {deviated:.1e}  stuck flags that differ: {flags}", flush=True)
    print(f"worst {worst:.1e}, allowed {CHECK_TOLERANCE:.0e}")
    return worst <= CHECK_TOLERANCE


def expected():
    s = Servomotor(parameters()).steady(4.0)
    print("steady", *(f"{k} {s[k]:.8g}" for k in ("x1", "x2", "x4", "P1", "P3", "P4", "Q4")))
    good = True
    for v in d.VERDICTS:
        if v["name"] in EXPECTED_X3_IN:
            servo = Servomotor(parameters(v["set"]))
            s = servo.steady(d.VERDICT_X3_IN)
            r = simulate(servo, s["y"], [(0.0, s["P1"] + d.VERDICT_STEP_PSI)], [0.0, 0.02, 0.05, 0.10])
            x3 = r.samples[1:, 0]
            error = max(abs(x3 - EXPECTED_X3_IN[v["name"]]))
            good &= error < 0.52e-7  # half the last digit; VII-2 is printed 1e-9 beyond its rounding
            print(f"{v['name']:6}", *(f"{x:.11f}" for x in x3), f"  largest difference {error:.2e}")
    return good


def dead_band():
    good = True
    for x3, overrides, *stored in d.HELD:
        servo = Servomotor(parameters(overrides))
        p1, down, up = (servo.steady(x3, b)["P1"] for b in (0.0, -servo.p.B, servo.p.B))
        found = (p1, down - p1, up - p1)
        good &= max(abs(a - b) for a, b in zip(found, stored)) < 1e-8
        print(x3, overrides, *(f"{f:+.8f}" for f in found))
    start, overrides, p1, _, up = d.HELD[0]
    servo = Servomotor(parameters(overrides))
    end = brentq(lambda x3: servo.steady(x3, servo.p.B)["P1"] - p1 - d.BREAKAWAY_STEP_PSI, start, start + 0.1)
    good &= abs(end - d.BREAKAWAY_REST_IN) < 1e-8
    print(f"after {d.BREAKAWAY_STEP_PSI} psi rests at {end:.8f} in")
    r = simulate(servo, servo.steady(start)["y"], [(0.0, p1 + d.BREAKAWAY_STEP_PSI)], [0.0, 0.5])
    print(f"simulated, 0.5 s: {r.samples[-1, 0]:.8f} in")
    return good


def verdicts():
    good = True
    for v in d.VERDICTS:
        servo = Servomotor(parameters(v["set"]))
        s = servo.steady(d.VERDICT_X3_IN)
        times = [at(n) for n in range(0, 10001)]
        r = simulate(servo, s["y"], [(0.0, s["P1"] + d.VERDICT_STEP_PSI)], times)
        v3 = r.samples[:, 1]
        found = d.verdict(times, v3)
        good &= found == v["stated"]
        swings = " ".join(f"{d.swing(times, v3, a / 100, b / 100):.2g}" for a, b in ((2, 4), (8, 10), (10, 20), (50, 60), (90, 100)))
        print(f"{v['name']:22} {str(found):9} stated {v['stated']:9} swing 20-40, 80-100, 100-200, 500-600, 900-1000 ms: {swings}"
              f"  eigenvalue {max(eigenvalues(servo, s['y'], s['P1']).real):+.2f} 1/s"
              f"  x3(1 s) {r.samples[-1, 0]:.6f}  stick phases {len(r.rest)}", flush=True)
    return good


def rk4(case, step_s):
    """Plain RK4, every law evaluated as it stands, friction decided once per step: no event location.

    Shares the laws with Servomotor but none of the mode and event machinery.
    """
    servo = Servomotor(parameters(case["set"]))
    p = servo.p
    steady = servo.steady(case["start_x3_in"])
    rows = dict(schedule(case, steady))
    per_tick = round(d.TICK_S / step_s)
    wanted = set(d.sample_ticks(case["duration_s"]))
    y, slide, out, x1 = steady["y"].copy(), 0, [], None

    def f(y, slide):
        m = servo.mode(y, x1, slide)
        return np.array(servo.rhs(m, x1)(0.0, y))

    for n in range(round(case["duration_s"] / d.TICK_S) + 1):
        if n in wanted:
            out.append(y.copy())
        if at(n) in rows:
            x1 = servo.x1(rows[at(n)])
        for _ in range(per_tick):
            if p.B > 0 and slide == 0:
                drive = y[2] - servo.load_psi(y[0])
                if abs(drive) > p.B:
                    slide = 1 if drive > 0 else -1
            h = step_s
            k1 = f(y, slide)
            k2 = f(y + h / 2 * k1, slide)
            k3 = f(y + h / 2 * k2, slide)
            k4 = f(y + h * k3, slide)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if p.B > 0 and slide * y[1] < 0:
                y[1] = 0.0
                slide = 0
    return np.array(out)


def accuracy(cases):
    stored = {c["name"]: c for c in json.loads(GOLDEN.read_text())["cases"]}
    runs = {
        "DOP853 1e-12, 50 us": dict(settings=Settings(rtol=1e-12, atol=(1e-14, 1e-11, 1e-11, 1e-12, 1e-11), max_step=5e-5, probes=8)),
        "LSODA 1e-11": dict(settings=Settings("LSODA", rtol=1e-11)),
        "Radau 1e-9": dict(settings=Settings("Radau", rtol=1e-9, atol=(1e-11, 1e-8, 1e-8, 1e-9, 1e-8))),
        "x3(0) + 1e-9": dict(perturb=1e-9),
    }
    print("| case | " + " | ".join(runs) + " |")
    for case in cases:
        row = []
        for name, options in runs.items():
            try:
                row.append(f"{deviation(stored[case['name']], solve(case, **options)[1].samples):.0e}")
            except RuntimeError as failure:
                row.append(str(failure))
        print(f"| {case['name']} | " + " | ".join(row) + " |", flush=True)


def fixed_step(cases, step_s):
    stored = {c["name"]: c for c in json.loads(GOLDEN.read_text())["cases"]}
    for case in cases:
        c = stored[case["name"]]
        y = rk4(case, step_s)
        parts = []
        for j, name in enumerate(COLUMNS):
            if name in c:
                e = y[:, j] - np.array(c[name])
                parts.append(f"{name} max {np.max(np.abs(e)):.1e} rms {math.sqrt(np.mean(e * e)):.1e}")
        print(f"{case['name']:26}", "  ".join(parts), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for option in ("check", "expected", "dead-band", "verdicts", "accuracy"):
        parser.add_argument(f"--{option}", action="store_true")
    parser.add_argument("--rk4", type=float, nargs="?", const=1e-4, metavar="STEP_S")
    parser.add_argument("case", nargs="*")
    a = parser.parse_args()
    cases = [c for c in d.CASES if not a.case or any(w in c["name"] for w in a.case)]
    if a.check:
        sys.exit(not check(cases))
    if a.expected:
        sys.exit(not expected())
    if a.dead_band:
        sys.exit(not dead_band())
    if a.verdicts:
        sys.exit(not verdicts())
    if a.accuracy:
        accuracy(cases)
    elif a.rk4:
        fixed_step(cases, a.rk4)
    else:
        out = generate(cases)
        if len(cases) == len(d.CASES):
            write(out)


if __name__ == "__main__":
    main()

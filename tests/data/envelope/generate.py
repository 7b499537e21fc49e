#!/usr/bin/python3
"""Golden data of the envelope: see README.md.

generate.py             solve every scenario and write cases.json
generate.py --check     solve again and compare with the stored file
generate.py --thesis    in the limit of the thesis' laws: against ../reference/cases.json
generate.py --laws      single laws against known figures
generate.py --rk4       plain RK4 at 2 us against the stored file
generate.py --accuracy  agreement of methods, tolerances and state variables
CASE ...                only the scenarios whose name contains one of these words
"""

import argparse
import json
import platform
import sys
import time
from dataclasses import replace

import numpy as np
import scipy

import scenarios as d
from full_servomotor import HERE, OILS, P_ATM_PSI, PSI_PA, FullServomotor, oil_properties, parameters
from solver import Settings, simulate

GOLDEN = HERE / "cases.json"
COLUMNS = ("x3_in", "v3_in_s", "p3_psi", "p4_psi", "p8_psi", "p2_psi")
CHECK_TOLERANCE = 2e-6

# A rest (at a stop, or held by friction) is robust, and its times are compared, if it lasts ...
REST_S = 1e-3
REST_DEPTH_PSI = 0.1   # ... its drive gets this far from breakaway ...
MOVE_S = 3e-4          # (motions shorter than this between two rests do not count) ...
NUDGE_PSI = 1e-4       # ... and P1 changed by this much ...
NUDGE_SHIFT_S = 2e-5   # ... shifts its begin, or end, by less than this.


def at(tick):
    return round(tick * d.TICK_S, 4)


def solve(case, settings=None, nudge_psi=0.0):
    settings = settings or Settings()
    servo = FullServomotor(parameters({k: v for k, v in case["set"].items() if k != "model.physics"},
                                      case.get("closing_curve", ())), settings.log_pressure)
    steady = servo.steady(case["start_x3_in"])
    if case["p1"]["kind"] == "step":
        rows = [(0.0, steady["P1"] + case["p1"]["delta_psi"])]
    else:
        rows = [(at(n), p) for n, p in d.p1_rows(case["p1"], case["duration_s"])]
    times = [at(n) for n in d.sample_ticks(case["duration_s"])]
    return servo, simulate(servo, steady["y"], [(t, p + nudge_psi) for t, p in rows], times, settings)


def merged(rests):
    """A motion of less than MOVE_S between two rests is not looked for."""
    out = []
    for rest in rests:
        if out and rest[0] - out[-1][1] < MOVE_S:
            out[-1] = [out[-1][0], rest[1], rest[2], max(out[-1][3], rest[3])]
        else:
            out.append(list(rest))
    return out


def robust(rest, nudged, end):
    """[from, to, motion, can the begin be compared, can the end be compared]."""
    rest, nudged = merged(rest), merged(nudged)
    out = []
    for a, b, motion, depth in rest:
        if b - a < REST_S or depth < REST_DEPTH_PSI:
            continue
        twins = [n for n in nudged if n[2] == motion and n[0] < b and a < n[1]]
        begin = a > 0 and any(abs(n[0] - a) < NUDGE_SHIFT_S for n in twins)
        finish = b < end and any(abs(n[1] - b) < NUDGE_SHIFT_S for n in twins)
        out.append([round(a, 7), round(b, 7), motion, begin, finish])
    return out


def columns(case):
    for j, name in enumerate(COLUMNS):
        if name == "p8_psi" and not case["set"].get("stabilizer.enabled"):
            continue
        if name == "p2_psi" and not case["set"].get("supply.pump_flow_in3_s"):
            continue
        yield j, name


def golden(case):
    begun = time.time()
    servo, r = solve(case)
    _, nudged = solve(case, nudge_psi=NUDGE_PSI)
    stored = dict(case)
    for j, name in columns(case):
        stored[name] = [float(f"{c:.8g}") for c in r.samples[:, j]]
    stored["stuck"] = "".join(map(str, r.stuck))
    stored["rest"] = robust(r.rest, nudged.rest, case["duration_s"])
    sensitivity = np.max(np.abs(r.samples - nudged.samples), axis=0)
    names = {}
    for _, (kind, to), _ in r.events:
        key = kind if kind == "segment" else f"{kind}:{to}"
        names[key] = names.get(key, 0) + 1
    print(f"{case['name']:20} x3 {r.low[0]:.2f}..{r.high[0]:.2f} v3 {r.low[1]:6.1f}..{r.high[1]:5.1f}"
          f" P3 {r.low[2]:7.3f}..{r.high[2]:5.1f} P4 {r.low[3]:7.3f}..{r.high[3]:5.1f} P8 {r.low[4]:5.1f}"
          f" P2 {r.low[5]:5.1f}..{r.high[5]:5.1f}  nudge x3 {sensitivity[0]:.0e} P3 {sensitivity[2]:.0e}"
          f"  rests {len(r.rest)}/{sum(x[3] for x in stored['rest'])}/{sum(x[4] for x in stored['rest'])}"
          f"  {r.steps} steps {time.time() - begun:.1f} s {names}", flush=True)
    return stored


def deviation(stored, samples):
    """Largest |difference| of any column, in units of max(1, largest magnitude of the column)."""
    return max(np.max(np.abs(samples[:, j] - stored[name])) / max(1.0, np.max(np.abs(stored[name])))
               for j, name in enumerate(COLUMNS) if name in stored)


def write(cases):
    """One line per case property: readable, and small."""
    head = {"generator": "tests/data/envelope/generate.py", "python": platform.python_version(),
            "numpy": np.__version__, "scipy": scipy.__version__,
            "ticks": {str(s): d.sample_ticks(s) for s in sorted({c["duration_s"] for c in cases})}}
    lines = ["{"]
    lines += [f'"{k}": {json.dumps(v, separators=(",", ":"))},' for k, v in head.items()]
    blocks = ["{" + ",\n ".join(f"{json.dumps(k)}: {json.dumps(v, separators=(',', ':'))}" for k, v in c.items()) + "}"
              for c in cases]
    lines += ['"cases": [', ",\n".join(blocks), "]", "}"]
    GOLDEN.write_text("\n".join(lines) + "\n")


def check(cases):
    stored = {c["name"]: c for c in json.loads(GOLDEN.read_text())["cases"]}
    worst = 0.0
    for case in cases:
        old = stored.get(case["name"])
        if old is None or any(old[k] != json.loads(json.dumps(case[k])) for k in case):
            sys.exit(f"{case['name']}: the stored case is not the defined one; run generate.py")
        _, r = solve(case)
        deviated = deviation(old, r.samples)
        worst = max(worst, deviated)
        print(f"{case['name']:20} {deviated:.1e}", flush=True)
    print(f"worst {worst:.1e}, allowed {CHECK_TOLERANCE:.0e}")
    return worst <= CHECK_TOLERANCE


def rest_shift(stored, result):
    """Largest difference [s] of the rest times that are marked robust."""
    worst = 0.0
    for a, b, motion, begin, end in stored["rest"]:
        twins = [r for r in result.rest if r[2] == motion and r[0] < b and a < r[1]]
        for time_s, wanted, column in ((a, begin, 0), (b, end, 1)):
            if wanted:
                worst = max(worst, min((abs(r[column] - time_s) for r in twins), default=float("inf")))
    return worst


ACCURACY = {
    "Radau 1e-10, pressures as state": dict(settings=Settings(
        rtol=1e-10, atol=(1e-12, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9), max_step=2e-4, probes=6, log_pressure=False)),
    "LSODA 1e-10": dict(settings=Settings("LSODA", rtol=1e-10, atol=(1e-12, 1e-9, 1e-11, 1e-11, 1e-11, 1e-9))),
    "BDF 1e-8": dict(settings=Settings("BDF", rtol=1e-8)),
}


def accuracy(cases):
    """x3 [in], worst RMS of a pressure [psi], shift of a rest [s], by method."""
    stored = {c["name"]: c for c in json.loads(GOLDEN.read_text())["cases"]}
    print("| scenario | " + " | ".join(ACCURACY) + " |")
    for case in cases:
        old, row = stored[case["name"]], []
        for options in ACCURACY.values():
            try:
                _, r = solve(case, **options)
                e = [r.samples[:, j] - old[name] for j, name in columns(case)]
                row.append(f"{np.max(np.abs(e[0])):.0e} {max(np.sqrt(np.mean(x * x)) for x in e[2:]):.0e}"
                           f" {rest_shift(old, r):.0e}")
            except RuntimeError as failure:
                row.append(str(failure)[:60])
        print(f"| {case['name']} | " + " | ".join(row) + " |", flush=True)


class ThesisStabilizer(FullServomotor):
    """Everything else in its limit; the gas spring in the thesis' form (5.13), the capillary laminar (5.2)."""

    def C8(self, P8, seated):
        return self.p.V8 / self.modulus(P8) + self.p.Va / (self.p.k * P8)


def thesis(words):
    """The limit of the full physics against the solution of the thesis' equations in ../reference."""
    reference = json.loads((HERE.parent / "reference" / "cases.json").read_text())
    limit = dict(nuclei=0.0, p_t=0.0, stroke=1e6, x1_max=1e6, travel=1e6, h5=1e6, h36=1e6, p_pre=-14.0)
    worst = 0.0
    for case in reference["cases"]:
        if case["p1"]["kind"] not in ("step", "table") or words and not any(w in case["name"] for w in words):
            continue
        servo = ThesisStabilizer(replace(parameters(case["set"]), **limit))
        servo.b7 = 1e-12
        steady = servo.steady(case["start_x3_in"])
        rows = ([(0.0, steady["P1"] + case["p1"]["delta_psi"])] if case["p1"]["kind"] == "step"
                else [tuple(row) for row in case["p1"]["rows"]])
        times = [at(n) for n in reference["ticks"][str(case["duration_s"])]]
        r = simulate(servo, steady["y"], rows, times)
        deviated = deviation(case, r.samples)
        worst = max(worst, deviated)
        print(f"{case['name']:26} {deviated:.1e}", flush=True)
    print(f"worst {worst:.1e}, allowed {CHECK_TOLERANCE:.0e}")
    return worst <= CHECK_TOLERANCE


def laws():
    """Single laws against figures that are known, or against their own differences."""
    good = True

    def show(what, found, wanted, tolerance):
        nonlocal good
        good &= abs(found - wanted) <= tolerance
        print(f"{what}: {found:.8g}, wanted {wanted:.8g} within {tolerance:g}")

    liquid = 1.4e9 / PSI_PA
    mpa = 1e6 / PSI_PA  # gauge
    for fraction, ratio in ((0.005, 0.631), (0.05, 0.147)):  # issue 3
        servo = FullServomotor(replace(parameters(), Kl=liquid, air=fraction, p_v=0.0))
        show(f"mixture to liquid modulus, {fraction:.1%} of air, 1 MPa", servo.modulus(mpa) / liquid, ratio, 5e-4)
    servo = FullServomotor(replace(parameters(), air=0.02, n=1.2, p_d=200.0))
    for P in (-14.6, -10.0, 0.5, 30.0, 120.0, 184.0, 250.0):
        h = 1e-5 * (P + P_ATM_PSI)
        slope = (servo.gas(P + h)[0] - servo.gas(P - h)[0]) / (2 * h)
        show(f"dV_g/dP at {P} psi", servo.gas(P)[1], slope, 1e-5 * abs(slope))
    for name, (nu40, nu100, rho15) in OILS.items():
        for celsius, nu in ((40.0, nu40), (100.0, nu100)):
            mu, rho = oil_properties(name, celsius)
            show(f"{name} at {celsius} C, cSt", mu / rho * 0.0254**2 * 1e6, nu, 1e-9 * nu)
    h = 1e-3  # C8 is what the volumes of oil and gas give: dV/dP of V_a (P_charge/P)^(1/k)
    gas = [servo.p.Va * ((103 + P_ATM_PSI) / (P + P_ATM_PSI))**(1 / 1.4) for P in (60 - h, 60 + h)]
    show("gas compliance at 60 psi", servo.C8(60.0, False) - servo.C8(60.0, True), (gas[0] - gas[1]) / (2 * h), 1e-6)
    steady = FullServomotor(replace(parameters(), nuclei=0.0, p_t=0.0)).steady(4.0)  # expected.md
    for key, value, tolerance in (("P1", 30.26320, 5e-6), ("P4", 5.70702, 5e-6), ("Q4", 48.4026, 5e-5)):
        show(f"steady {key}", steady[key], value, tolerance)
    return good


def rk4(case, step_s):
    """Plain RK4, every law evaluated as it stands: shares the laws with the solution, no mode, event or solver."""
    servo = FullServomotor(parameters({k: v for k, v in case["set"].items() if k != "model.physics"},
                                      case.get("closing_curve", ())))
    steady = servo.steady(case["start_x3_in"])
    rows = ({0: steady["P1"] + case["p1"]["delta_psi"]} if case["p1"]["kind"] == "step"
            else dict(d.p1_rows(case["p1"], case["duration_s"])))
    wanted = set(d.sample_ticks(case["duration_s"]))
    y, motion, out, x1 = steady["y"].copy(), servo.start_motion(case["start_x3_in"]), [], None
    for n in range(round(case["duration_s"] / d.TICK_S) + 1):
        if n in wanted:
            out.append(servo.decode(y))
        x1 = servo.x1(rows[n]) if n in rows else x1

        def f(y):
            return np.array(servo.rhs(servo.mode(y, x1, motion), x1)(0.0, y))  # noqa: B023

        for _ in range(round(d.TICK_S / step_s)):
            if motion in ("stuck", "lower", "upper"):
                low, high = servo.hold_psi(y[0], servo.segment(y[0]))
                P3 = servo.decode(y)[2]
                if P3 > high and motion != "upper":
                    motion = servo.moving("up")
                elif P3 < low and motion != "lower":
                    motion = servo.moving("down")
            k1 = f(y)
            k2 = f(y + step_s / 2 * k1)
            k3 = f(y + step_s / 2 * k2)
            y = y + step_s / 6 * (k1 + 2 * k2 + 2 * k3 + f(y + step_s * k3))
            if y[0] < 0 or y[0] > servo.p.stroke:
                motion = "lower" if y[0] < 0 else "upper"
                y[0], y[1] = (0.0 if motion == "lower" else servo.p.stroke), 0.0
            elif motion == "up" and y[1] < 0 or motion == "down" and y[1] > 0:
                y[1], motion = 0.0, "stuck"
    return np.array(out)


def fixed_step(cases, step_s):
    stored = {c["name"]: c for c in json.loads(GOLDEN.read_text())["cases"]}
    for case in cases:
        y, old = rk4(case, step_s), stored[case["name"]]
        parts = [f"{name} {np.max(np.abs(y[:, j] - old[name])):.0e} rms {np.sqrt(np.mean((y[:, j] - old[name])**2)):.0e}"
                 for j, name in columns(case)]
        print(f"{case['name']:20}", "  ".join(parts), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for option in ("check", "thesis", "laws", "accuracy"):
        parser.add_argument(f"--{option}", action="store_true")
    parser.add_argument("--rk4", type=float, nargs="?", const=2e-6, metavar="STEP_S")
    parser.add_argument("case", nargs="*")
    a = parser.parse_args()
    cases = [c for c in d.SCENARIOS if not a.case or any(w in c["name"] for w in a.case)]
    if a.check:
        sys.exit(not check(cases))
    if a.thesis:
        sys.exit(not thesis(a.case))
    if a.laws:
        sys.exit(not laws())
    if a.accuracy:
        accuracy(cases)
    elif a.rk4:
        fixed_step(cases, a.rk4)
    else:
        out = [golden(case) for case in cases]
        if len(cases) == len(d.SCENARIOS):
            write(out)


if __name__ == "__main__":
    main()

"""`servohil simulate` and `servohil steady` against the independent scipy solution.

The golden data and where their accuracy comes from: tests/data/reference/README.md. They are good
to 1e-8, so every deviation found here is the program's: its 0.1 ms RK4 step, or an error.
"""

import json
import math
import sys
from pathlib import Path

import pytest

REFERENCE = Path(__file__).resolve().parents[1] / "data" / "reference"
sys.path.insert(0, str(REFERENCE))

import definitions as d  # noqa: E402
import program  # noqa: E402

GOLDEN = json.loads((REFERENCE / "cases.json").read_text())

# The accuracy asked of the product over large steps.
X3_IN = 0.001          # everywhere
PRESSURE_RMS_PSI = 0.5

# Reference: P4 0.1 ms after 0.27 psi from the steady state at 4.0 in.
P4_AFTER_ONE_TICK_PSI = 0.17431769

# A friction state is compared only where it is not a matter of a tick (README.md, Method).
REST_S = 1.5e-3        # stick phases at least this long are found ...
REST_EDGE_S = 0.5e-3   # ... but for this much at either end
SLIDING_IN_S = 0.1     # faster than this, the piston is not stuck

# expected.md, "Nonlinear model": x3 at 0.02, 0.05, 0.10 s, exact to the digits shown.
EXPECTED_X3_IN = {
    "IV-1": (4.0735363, 4.1102289, 4.1155441),
    "IV-3": (4.0691111, 4.1054777, 4.1152091),
    "IV-4": (4.0709549, 4.1074674, 4.1157198),
    "IV-5": (4.0697885, 4.1057099, 4.1148690),
    "VII-2": (4.0717491, 4.1086575, 4.1160298),
    "VII-4": (4.0733113, 4.1143974, 4.1184183),
    "VII-5": (4.0746805, 4.1114794, 4.1156197),
}
EXPECTED_TOLERANCE_IN = 2e-6  # "RK4 at 0.1 ms is within 1e-6 in of every one of them"

# expected.md, "Steady state", row "exact": value and one half of the last digit shown.
STEADY = {
    "x1_in": (4.142101, 0.5e-6), "x2_in": (4.179340, 0.5e-6), "x4_in": (4.180000, 0.5e-6),
    "p1_psi": (30.26320, 0.5e-5), "p3_psi": (103.000, 0.5e-3), "p4_psi": (5.70702, 0.5e-5),
    "q4_in3_s": (48.4026, 0.5e-4),
}


def rms(errors):
    return math.sqrt(sum(e * e for e in errors) / len(errors))


@pytest.mark.parametrize("golden", GOLDEN["cases"], ids=lambda c: c["name"])
def test_large_signal_response(golden, tmp_path):
    friction = golden["set"].get("friction.coulomb_psi", 0.0) > 0
    every = 1 if friction else 50  # samples are at multiples of 50 ticks
    out = program.simulate(golden["set"], golden["start_x3_in"], golden["duration_s"], golden["p1"], every, tmp_path)
    ticks = GOLDEN["ticks"][str(golden["duration_s"])]
    at = [n // every for n in ticks]
    assert [round(out["t_s"][i] / d.TICK_S) for i in at] == ticks

    errors = {column: [out[column][i] - g for i, g in zip(at, golden[column])]
              for column in ("x3_in", "p3_psi", "p4_psi", "p8_psi") if column in golden}
    worst_x3 = max(map(abs, errors["x3_in"]))
    pressures = {column: rms(e) for column, e in errors.items() if column != "x3_in"}
    print(f"{golden['name']}: x3 {worst_x3:.2e} in; "
          + ", ".join(f"{c} rms {e:.2e} max {max(map(abs, errors[c])):.2e}" for c, e in pressures.items()))
    assert worst_x3 <= X3_IN
    assert max(pressures.values()) <= PRESSURE_RMS_PSI, pressures

    for i, v3 in zip(at, golden["v3_in_s"]):
        if abs(v3) > SLIDING_IN_S:
            assert out["stuck"][i] == 0, f"stuck at {out['t_s'][i]} s, reference slides at {v3} in/s"
    for begin, end in golden["rest_s"]:
        if end - begin >= REST_S:
            for t, v3, stuck in zip(out["t_s"], out["v3_in_s"], out["stuck"]):
                if begin + REST_EDGE_S <= t <= end - REST_EDGE_S:
                    assert stuck == 1 and v3 == 0.0, f"slides at {t} s, reference is at rest {begin} .. {end} s"


@pytest.mark.parametrize("name", EXPECTED_X3_IN)
def test_small_step_of_expected_md(name):
    overrides = next(v["set"] for v in d.VERDICTS if v["name"] == name)
    out = program.simulate(overrides, d.VERDICT_X3_IN, 0.1, d.step(d.VERDICT_STEP_PSI), 100)
    errors = [out["x3_in"][i] - x3 for i, x3 in zip((2, 5, 10), EXPECTED_X3_IN[name])]
    print(f"{name}: {[f'{e:.1e}' for e in errors]} in")
    assert max(map(abs, errors)) <= EXPECTED_TOLERANCE_IN, errors


def test_steady_state_of_expected_md():
    out = program.steady(4)
    for key, (value, half_digit) in STEADY.items():
        assert abs(out[key] - value) <= half_digit, f"{key}: {out[key]!r}, expected {value}"


def test_starts_in_the_steady_state_and_stays():
    """Row 0 is the steady state, before the step; with no step nothing moves: 1e-6 in in 0.1 s
    would already be a wrong balance of Q3, Q6 and the leakage (the piston's rate is their error / A3)."""
    steady = program.steady(4)
    out = program.simulate({}, 4.0, 0.1, d.step(0.0), 10)
    for key in ("x1_in", "x2_in", "x4_in", "p1_psi", "p3_psi", "p4_psi", "q4_in3_s"):
        assert out[key][0] == pytest.approx(steady[key], rel=1e-9), key
    assert max(out["x3_in"]) - min(out["x3_in"]) < 1e-6
    assert max(map(abs, out["v3_in_s"])) < 1e-6


def test_step_is_applied_from_the_first_tick():
    """The step acts on tick 0: after one tick P4 has moved, x3 (three integrators behind) has not yet."""
    out = program.simulate({}, 4.0, 0.001, d.step(0.27))
    assert out["t_s"][:2] == pytest.approx([0.0, d.TICK_S], abs=1e-12)
    assert out["x3_in"][0] == 4.0 and out["v3_in_s"][0] == 0.0
    # dP4/dt = (Q4 - Q5)/(V4/beta + A2^2/k2) right after the step; the figure is the reference solution's
    assert out["p4_psi"][1] - out["p4_psi"][0] == pytest.approx(P4_AFTER_ONE_TICK_PSI, rel=1e-4)

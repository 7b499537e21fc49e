"""Coulomb friction at rest: below breakaway the piston does not creep, not even numerically.

The valve's pressure gain is large, so friction of 10 psi holds only against about 0.0015 psi of
control pressure; the figures are the independent solution's (`generate.py --dead-band`).
"""

import math
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "data" / "reference"))

import definitions as d  # noqa: E402
import program  # noqa: E402

LONG_S = 10.0
HELD_IN = 1e-9


def moved(out):
    return max(out["x3_in"]) - min(out["x3_in"])


@pytest.mark.parametrize("x3_in, overrides, p1_psi, down_psi, up_psi", d.HELD)
@pytest.mark.parametrize("share", [-0.8, 0.0, 0.8])
def test_held_at_constant_pressure(x3_in, overrides, p1_psi, down_psi, up_psi, share):
    """A constant P1 at 80 % of breakaway, either way: the pressure P3 settles, the piston stays."""
    change = share * (up_psi if share > 0 else -down_psi)
    out = program.simulate(overrides, x3_in, LONG_S, d.step(change), 100)
    assert moved(out) < HELD_IN
    assert all(s == 1 for s in out["stuck"][1:])
    b = overrides["friction.coulomb_psi"]
    drive = out["p3_psi"][-1] - out["p3_psi"][0]
    assert abs(drive) < b and (share == 0.0 or drive * share > 0)


@pytest.mark.parametrize("frequency_hz", [1.0, 50.0])
def test_held_under_a_wiggle(frequency_hz, tmp_path):
    """80 % of breakaway as a sine: P3 swings by psi, the piston stays."""
    x3_in, overrides, p1_psi, _, up_psi = d.HELD[0]
    rows = [(n * 1e-3, round(p1_psi + 0.8 * up_psi * math.sin(2 * math.pi * frequency_hz * n * 1e-3), 9))
            for n in range(round(LONG_S * 1000))]
    out = program.simulate(overrides, x3_in, LONG_S, rows, 10, tmp_path)
    assert moved(out) < HELD_IN
    assert all(s == 1 for s in out["stuck"][1:])
    assert max(out["p3_psi"]) - min(out["p3_psi"]) > 1.0


def test_breaks_away_and_rests_again():
    """Twice the breakaway pressure: slides until friction carries its full 10 psi, and no further."""
    x3_in, overrides, *_ = d.HELD[0]
    out = program.simulate(overrides, x3_in, 0.5, d.step(d.BREAKAWAY_STEP_PSI))
    assert out["stuck"][1] == 1  # P3 needs some milliseconds to build up
    assert not all(out["stuck"])
    assert out["x3_in"][-1] == pytest.approx(d.BREAKAWAY_REST_IN, abs=1e-6)


def test_without_friction_the_same_change_moves_it():
    """The counter-test: the hold above is friction's doing."""
    x3_in, _, _, _, up_psi = d.HELD[0]
    assert moved(program.simulate({}, x3_in, 1.0, d.step(0.8 * up_psi), 10)) > 1e-4

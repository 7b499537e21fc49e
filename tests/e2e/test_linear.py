"""`servohil linear`: against numpy on the independent oracle's equations, expected.md, and itself."""

import csv
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

REFERENCE = Path(__file__).resolve().parents[1] / "data" / "reference"
TOOLS = Path(__file__).resolve().parents[2] / "tools"
sys.path.insert(0, str(REFERENCE))

import definitions as d  # noqa: E402
import program  # noqa: E402
import servomotor as oracle  # noqa: E402


def linear(*arguments, overrides=None):
    return json.loads(program.run("linear", *program.settings(overrides or {}), "--json", *arguments))


def refused(*arguments):
    done = subprocess.run([str(program.PROGRAM), "linear", *map(str, arguments)], capture_output=True, text=True,
                          timeout=60)
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    return done.returncode, done.stderr


def oracle_matrices(overrides, x3_in):
    """A and B of the oracle's right-hand side: differences of sixth order, friction left out."""
    p = oracle.parameters({**overrides, "friction.coulomb_psi": 0.0})
    servo = oracle.Servomotor(p)
    rest = servo.steady(x3_in)
    n = 5 if p.stabilizer else 4
    mode = servo.mode(rest["y"], rest["x1"], 0)

    def rates(y, p1):
        return np.array(servo.rhs(mode, servo.x1(p1))(0.0, y))[:n]

    def derivative(f, h):
        return sum(c * (f(k * h) - f(-k * h)) for k, c in ((1, 45), (2, -9), (3, 1))) / (60 * h)

    unit = np.eye(5)
    a = np.column_stack([derivative(lambda e, j=j: rates(rest["y"] + e * unit[j], rest["P1"]), h)
                         for j, h in enumerate((1e-4, 1e-2, 1e-2, 1e-4, 1e-2)[:n])])
    return a, derivative(lambda e: rates(rest["y"], rest["P1"] + e), 1e-4)


SETS = {
    "nominal": {},
    "IV-1": {**d.NO_CLEARANCE, "servo.bulk_modulus_psi": 230e3},
    "IV-2": {**d.SMALL_UNDERLAP, "servo.bulk_modulus_psi": 230e3},
    "friction": d.friction(5),
    "two slopes": d.TWO_SLOPE,
    "low supply": d.supply(180),
    **{f"VII-{row}": {**d.SMALL_UNDERLAP, **settings} for row, settings in d.TABLE_VII.items()},
}


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("x3_in", [0.6, 3.1, 3.38, 4.0, 6.9])
def test_matrices_and_poles_are_the_oracles(name, x3_in):
    ours = linear("--x3", x3_in, overrides=SETS[name])
    a, b = oracle_matrices(SETS[name], x3_in)
    assert np.array(ours["a"]).shape == a.shape
    # Entries differ by 1e9 in size: compared as the model weighs them, each against the largest of its row.
    assert np.all(np.abs(ours["a"] - a) <= 1e-6 * np.abs(a).max(axis=1, keepdims=True))
    assert np.allclose(ours["b"], b, rtol=1e-6, atol=1e-9)

    def order(poles):
        return np.array(sorted(poles, key=lambda s: (round(abs(s), 3), s.imag)))

    poles = order(p["real_1_s"] + 1j * p["imaginary_1_s"] for p in ours["poles"])
    assert np.abs(poles - order(np.linalg.eigvals(a))).max() <= 1e-6 * np.abs(poles).max()
    largest = max(p.real for p in poles)
    assert ours["stable"] == (largest < 0)
    assert ours["routh"]["sign_changes"] == sum(p.real > 0 for p in poles)
    assert ours["jacobian_relative_error"] < 1e-8


def test_static_gain_is_the_steady_states():
    """The final value of the step response is dx3/dP1 of `servohil steady`, both ways."""
    ours = linear("--x3", 4.1)
    rise = program.steady(4.1005)["p1_psi"] - program.steady(4.0995)["p1_psi"]
    assert ours["step_response"]["final_in_psi"] == pytest.approx(0.001 / rise, rel=1e-5)
    t = ours["transfer_function"]
    assert t["numerator_in_psi"][-1] / t["denominator"][-1] == pytest.approx(0.001 / rise, rel=1e-5)


def test_at_a_control_pressure():
    p1_psi = program.steady(4.1)["p1_psi"]
    by_p1, by_x3 = linear("--p1", repr(p1_psi)), linear("--x3", 4.1)
    assert by_p1["operating_point"]["x3_in"] == pytest.approx(4.1, abs=1e-9)
    assert by_p1["poles"][0]["real_1_s"] == pytest.approx(by_x3["poles"][0]["real_1_s"], rel=1e-6)


# expected.md, "Linear model": poles to one decimal.
EXPECTED_POLES = {110e3: [-66.6, -876.1, 14.5 + 1094.1j, 14.5 - 1094.1j],
                  230e3: [-66.6, -883.0, -15.9 + 1575.1j, -15.9 - 1575.1j]}


@pytest.mark.parametrize("beta_psi", EXPECTED_POLES)
def test_thesis_model_is_that_of_expected_md(beta_psi):
    ours = linear("--x3", 4, "--model", "thesis", overrides=d.bulk_modulus(beta_psi))
    for pole, exact in zip(ours["poles"], EXPECTED_POLES[beta_psi]):
        assert abs(pole["real_1_s"] + 1j * pole["imaginary_1_s"] - exact) < 0.08
    assert ours["routh"]["sign_changes"] == (2 if beta_psi == 110e3 else 0)
    if beta_psi == 110e3:
        exact = [155.847e-6, 142.393e-3, 191.412, 175.624e3, 10.8817e6]
        assert ours["transfer_function"]["denominator"] == pytest.approx(exact, rel=1e-5)
        assert ours["transfer_function"]["numerator_in_psi"] == pytest.approx([4.66159e6], rel=1e-6)
        assert ours["step_response"]["rise_95_s"] is None, "unstable: there is none"
    else:
        assert ours["step_response"]["rise_95_s"] == pytest.approx(0.0434, abs=0.5e-4)
        full = linear("--x3", 4, "--model", "thesis", "--a4", "full", overrides=d.bulk_modulus(beta_psi))
        assert full["step_response"]["rise_95_s"] == pytest.approx(0.0388, abs=0.5e-4)


def test_linear_rise_time_is_the_simulated_one():
    """A step of 1e-4 psi is small against what closes the relay port (0.27 psi)."""
    overrides = SETS["IV-1"]
    ours = linear("--x3", 4.1, overrides=overrides)["step_response"]
    out = program.simulate(overrides, 4.1, 1.0, d.step(1e-4))
    final = 1e-4 * ours["final_in_psi"]
    assert out["x3_in"][-1] - 4.1 == pytest.approx(final, rel=1e-3)
    rise = next(t for t, x in zip(out["t_s"], out["x3_in"]) if x - 4.1 >= 0.95 * final)
    assert rise == pytest.approx(ours["rise_95_s"], rel=0.01)


def test_gain_limit_is_where_it_becomes_unstable():
    """Cam slope times the upper gain limit: undamped. The operating point is kept by x3*."""
    ours = linear("--x3", 4)
    upper = min(limit["factor"] for limit in ours["position_loop"]["gain_limits"] if limit["factor"] > 1)
    alpha = 0.32 * upper
    at_limit = linear("--x3", 4, overrides={"cam.alpha": alpha, "cam.x3_star_in": 2.9 + 4 * (0.32 - alpha)})
    assert at_limit["operating_point"]["p1_psi"] == pytest.approx(ours["operating_point"]["p1_psi"])
    assert abs(min(p["damping"] for p in at_limit["poles"])) < 1e-8
    assert ours["position_loop"]["phase_margin_deg"] > 0


def test_friction_is_said_to_be_left_out():
    with_friction, free = linear("--x3", 4, overrides=d.friction(5)), linear("--x3", 4)
    assert with_friction["a"] == free["a"]
    assert any("friction.coulomb_psi = 5 psi is left out" in note for note in with_friction["notes"])
    assert not free["notes"]
    full = {"model.physics": "full", **d.friction(5), "friction.breakaway_psi": 12, "friction.closing_ratio": 0.5}
    (note,) = linear("--x3", 4, overrides=full)["notes"]
    assert "breakaway_psi = 12 psi and the Stribeck curve" in note
    assert "risen by 12 or fallen by 6 psi" in note
    (note,) = linear("--x3", 4, overrides={"model.physics": "full", "friction.breakaway_psi": 12})["notes"]
    assert "breakaway_psi = 12 psi" in note, "without Coulomb friction, too"


def test_a_kink_is_said():
    assert any("kink in x3_in" in note for note in linear("--x3", 2.0)["notes"])


def test_text_has_every_section():
    text = program.run("linear", "--x3", 4)
    for part in ("state matrix", "transfer function", "poles", "Routh first column", "0 sign changes: stable",
                 "gain limit", "phase margin", "rise to 95 %", "overshoot", "settling"):
        assert part in text, part


@pytest.mark.parametrize("arguments, says", [
    ([], "--x3 IN or --p1 PSI"),
    (["--x3", 4, "--map", "servo.underlap_in=0:0.004", "cam.alpha=0.3:0.5"], "go together"),
    (["--x3", 4, "-o", "map.csv"], "go together"),
    (["--x3", 4, "--map", "servo.underlap_in=0.004:0", "cam.alpha=0.3:0.5", "-o", "-"], "LOW below HIGH"),
    (["--x3", 4, "--map", "servo.underlap_in=0:1", "cam.alpha=0.3:0.5", "-o", "-"], "servo.underlap_in"),
    (["--x3", 4, "--map", "servo.underlap=0:1", "cam.alpha=0.3:0.5", "-o", "-"], "did you mean"),
    (["--x3", 4, "--map", "cam.alpha=0.3:0.4", "cam.alpha=0.3:0.5", "-o", "-"], "both axes"),
    (["--p1", 200], "no steady state"),
])
def test_mistakes(arguments, says):
    status, text = refused(*arguments)
    assert status == 2 and says in text, text


def map_rows(path):
    with open(path, newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_map_is_the_single_points(tmp_path):
    target = tmp_path / "map.csv"
    program.run("linear", *program.settings({}), "--x3", 4, "--map", "servo.bulk_modulus_psi=60e3:230e3:5", "servo.underlap_in=0:0.004:3",
                "-o", target)
    rows = map_rows(target)
    assert len(rows) == 15
    assert {r["status"] for r in rows} == {"stable", "unstable"}
    for row in rows[::4]:
        keys = list(row)[:2]
        poles = linear("--x3", 4, overrides={key: float(row[key]) for key in keys})["poles"]
        assert float(row["largest_real_1_s"]) == pytest.approx(max(p["real_1_s"] for p in poles), rel=1e-6)
        assert float(row["damping"]) == pytest.approx(min(p["damping"] for p in poles), rel=1e-6)


def test_map_marks_points_without_a_steady_state(tmp_path):
    target = tmp_path / "map.csv"
    program.run("linear", *program.settings({}), "--x3", 4, "--map", "supply.pressure_psi=90:300:2", "cam.alpha=0.3:0.4:2", "-o", target)
    assert [r["status"] for r in map_rows(target)] == ["no steady state"] * 2 + ["stable"] * 2


def test_map_plot(tmp_path):
    target, picture = tmp_path / "map.csv", tmp_path / "map.png"
    program.run("linear", *program.settings({}), "--x3", 4, "--map", "servo.bulk_modulus_psi=60e3:230e3:5", "servo.underlap_in=0:0.004:5",
                "-o", target)
    subprocess.run([str(TOOLS / "plot_map.py"), str(target), "-o", str(picture)], check=True, timeout=60)
    assert picture.read_bytes().startswith(b"\x89PNG")
    target.write_text("x\n")
    done = subprocess.run([str(TOOLS / "plot_map.py"), str(target), "-o", str(picture)], capture_output=True, text=True,
                          timeout=60)
    assert done.returncode == 2 and "not a map" in done.stderr


def test_decibels_and_hertz():
    ours = linear("--x3", 4)
    for limit in ours["position_loop"]["gain_limits"]:
        assert limit["db"] == pytest.approx(20 * math.log10(limit["factor"]))
    for pole in ours["poles"]:
        assert pole["frequency_hz"] * 2 * math.pi == pytest.approx(pole["frequency_rad_s"])
        assert pole["frequency_rad_s"] == pytest.approx(math.hypot(pole["real_1_s"], pole["imaginary_1_s"]))

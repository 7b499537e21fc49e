"""`servohil thesis`: every printed number of the source, and that nothing can deviate unnoticed."""

import functools
import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "data" / "reference"))

import definitions as d  # noqa: E402
import program  # noqa: E402

FIGURES = [3, 4, *range(6, 13), *range(14, 32), *range(33, 43)]


def thesis(*arguments, environment=None):
    return subprocess.run([str(program.PROGRAM), "thesis", *map(str, arguments)], capture_output=True, text=True,
                          timeout=300, env={**os.environ, **(environment or {})})


@functools.cache
def report():
    done = thesis("--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def groups(prefix):
    return [g for g in report()["groups"] if g["where"].startswith(prefix)]


def entry(prefix, quantity):
    return next(e for g in groups(prefix) for e in g["entries"] if e["quantity"] == quantity)


def test_everything_agrees_or_is_explained():
    assert report()["summary"]["unexplained"] == 0
    assert report()["summary"]["agree"] > 100
    for group in report()["groups"]:
        for e in group["entries"]:
            assert e["status"] in ("agrees", "explained")
            if e["status"] == "explained":
                assert e["reason"] and (e["errata"] == "new" or re.fullmatch(r"\d+(, \d+)*", e["errata"])), e


def test_the_numbers_of_expected_md():
    """Against expected.md, not against what the program takes for right."""
    steady = {e["quantity"]: e["ours"] for e in groups("Appendix B, steady")[0]["entries"]}
    assert steady["x1"] == pytest.approx(4.142101, abs=0.5e-6)
    assert steady["P4"] == pytest.approx(5.70702, abs=0.5e-5)
    exact = {"K": 4.66159e6, "a0": 155.847e-6, "a1": 142.393e-3, "a2": 191.412, "a3": 175.624e3, "a4": 10.8817e6}
    for name, value in exact.items():
        assert entry("(3.18)", name)["ours"] == pytest.approx(value, rel=5e-6), name
    rise = {e["quantity"]: e["ours"] for e in groups("Section 3.5")[0]["entries"]}
    assert sorted(rise.values())[0] == pytest.approx(0.0388, abs=0.5e-4)
    assert sorted(rise.values())[-1] == pytest.approx(0.0434, abs=0.5e-4)


def test_every_table_is_there():
    rows = {"Table III": 4, "Table IV": 7, "Table V,": 3, "Table VI,": 3, "Table VII": 10}  # VII: values and verdicts
    for table, count in rows.items():
        assert len(groups(f"{table}")) == count, table


def test_verdicts_are_those_of_the_reference_solution():
    """tests/data/reference/definitions.py, where an independent solver was asked."""
    stated = {v["name"]: v["stated"] for v in d.VERDICTS}
    for table, rows in (("IV", 7), ("VII", 5)):
        for row in range(1, rows + 1):
            verdict = next(e for g in groups(f"Table {table}, row {row}") for e in g["entries"]
                           if e["quantity"] == "over 1 s")
            assert verdict["ours"] == stated[f"{table}-{row}"]


def test_erratum_19_is_named_where_it_applies_and_only_there():
    named = [(g["where"], e["quantity"]) for g in report()["groups"] for e in g["entries"] if e.get("errata") == "19"]
    assert named == [("Table IV, row 2", "over 1 s")]
    row = groups("Table IV, row 2")[0]["entries"]
    assert [e["ours"] for e in row] == ["stable", "unstable"]


def test_each_row_states_its_full_parameter_set():
    """Its parameters are those of `servohil simulate` with the same settings: Table IV row 5 by hand."""
    group = groups("Table IV, row 5")[0]
    parameters = dict(p.split("=", 1) for p in group["parameters"])
    keys = {line.split()[0] for line in program.run("steady", "--help-keys").splitlines() if re.match(r"  [a-z]+\.", line)}
    sections = ("model.", "oil.", "orifice.", "servo.", "supply.", "cam.", "friction.", "stabilizer.", "load.")
    assert {k for k in keys if k.startswith(sections)} <= set(parameters)
    assert float(parameters["servo.bulk_modulus_psi"]) == 90e3
    settings = [a for s in group["settings"] for a in ("--set", s)]
    out = json.loads(program.run("steady", *settings, "--x3", 4, "--json"))
    assert math.isclose(out["p1_psi"], program.steady(4, {"servo.bulk_modulus_psi": 90e3})["p1_psi"])


@pytest.mark.parametrize("change", ["servo.piston_diameter_in=10", "servo.load_mass_lbf_s2_in=1.3",
                                    "oil.viscosity_lbf_s_in2=2.3e-6", "servo.relay_plunger_area_in2=2.348",
                                    "stabilizer.polytropic_index=1.0"])
def test_a_deviation_without_a_reason_fails(change):
    """Also where a reason stands beside the number: a reason explains one deviation, not every one."""
    done = thesis("--json", "--set", change)
    assert done.returncode == 1
    out = json.loads(done.stdout)
    assert out["summary"]["unexplained"] > 5
    unexplained = [e for g in out["groups"] for e in g["entries"] if e["status"] == "unexplained"]
    assert any("reason" in e for e in unexplained) or change.startswith("stabilizer")


def test_text_and_markdown_say_the_same():
    summary = report()["summary"]
    line = (f"{sum(summary.values())} numbers and verdicts: {summary['agree']} agree, {summary['explained']} deviate "
            "for a known reason, 0 deviate without")
    text, markdown = thesis(), thesis("--markdown")
    assert text.returncode == markdown.returncode == 0
    assert line in text.stdout and line in markdown.stdout
    assert "errata 19" in text.stdout and "errata 19" in markdown.stdout
    tables = [row for row in markdown.stdout.splitlines() if row.startswith("|")]
    assert all(row.count("|") == 8 for row in tables)
    assert thesis("--json", "--markdown").returncode == 2


def test_the_tables_of_model_md_are_what_the_program_gives():
    tool = Path(__file__).resolve().parents[2] / "tools" / "model_tables.py"
    done = subprocess.run([sys.executable, str(tool), "--check"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def plots(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plots") / "new"
    done = thesis("--plots", folder)
    assert done.returncode == 0, done.stderr
    return folder


def test_every_figure_is_drawn(plots):
    index = json.loads((plots / "figures.json").read_text())
    assert {f["name"] for f in index} == {f"figure_{n:02d}" for n in FIGURES} | {"figure_18_1s"}
    for figure in index:
        assert (plots / f"{figure['name']}.png").read_bytes().startswith(b"\x89PNG")
        number = int(figure["name"].split("_")[1])
        assert figure["caption"].startswith(f"Figure {number}. ")


def test_figures_hold_the_simulated_response(plots):
    rows = (plots / "figure_19.csv").read_text().splitlines()
    assert rows[0] == "t_s,x3_in" and len(rows) == 1002
    out = program.simulate({}, 4.0, 0.1, d.step(0.27))
    for row, t, x3 in zip(rows[1:], out["t_s"], out["x3_in"]):
        assert [float(v) for v in row.split(",")] == pytest.approx([t, x3], abs=1e-8)


def test_without_matplotlib_it_says_what_to_install(tmp_path):
    (tmp_path / "matplotlib").mkdir()
    (tmp_path / "matplotlib" / "__init__.py").write_text("raise ImportError('not here')\n")
    done = thesis("--plots", tmp_path / "plots", environment={"PYTHONPATH": str(tmp_path)})
    assert done.returncode == 3
    assert "apt install python3-matplotlib" in done.stderr
    assert (tmp_path / "plots" / "figure_06.csv").exists()


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    done = thesis("--plots", tmp_path / "file" / "plots")
    assert done.returncode == 3 and "file/plots" in done.stderr

"""Runs the program under test for the end-to-end comparisons. Standard library only."""

import json
import os
import subprocess
from pathlib import Path

import definitions as d

REPOSITORY = Path(__file__).resolve().parents[3]
BUILD = Path(os.environ.get("SERVOHIL_BUILD", REPOSITORY / "build" / "release"))
PROGRAM = BUILD / "bin" / "servohil"
HEADER = ("t_s,p1_psi,x3_in,v3_in_s,p3_psi,p4_psi,p8_psi,x1_in,x2_in,x4_in,"
          "q3_in3_s,q4_in3_s,q5_in3_s,q6_in3_s,friction_psi,stuck").split(",")


def toml(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value)


def settings(overrides):
    """Arguments for these keys; the thesis' physics, which this reference is of, unless they say otherwise."""
    keys = {"model.physics": "thesis", **overrides}
    return [a for key, value in keys.items() for a in ("--set", f"{key}={toml(value)}")]


def run(*arguments):
    if not PROGRAM.exists():
        raise FileNotFoundError(f"{PROGRAM}: build it first, or set SERVOHIL_BUILD")
    done = subprocess.run([str(PROGRAM), *map(str, arguments)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, f"{done.args}\n{done.stderr}"
    return done.stdout


def simulate(overrides, x3_in, duration_s, p1, every=1, directory=None):
    """Columns of `servohil simulate` by name; p1 as in definitions.py, or [(t s, p1 psi)] rows."""
    arguments = ["simulate", *settings(overrides), "--x3", x3_in, "--duration", duration_s, "--every", every]
    if isinstance(p1, dict) and p1["kind"] == "step":
        arguments += ["--p1-step", p1["delta_psi"]]
    else:
        rows = [(n * d.TICK_S, p) for n, p in d.p1_rows(p1, duration_s)] if isinstance(p1, dict) else p1
        file = Path(directory) / "p1.csv"
        file.write_text("t_s,p1_psi\n" + "".join(f"{t:.4f},{p!r}\n" for t, p in rows))
        arguments += ["--p1-file", file]
    lines = run(*arguments, "-o", "-").splitlines()
    assert lines[0].split(",") == HEADER
    columns = zip(*(map(float, line.split(",")) for line in lines[1:]))
    return dict(zip(HEADER, map(list, columns)))


def steady(x3_in, *overrides):
    merged = {key: value for o in overrides for key, value in o.items()}
    return json.loads(run("steady", *settings(merged), "--x3", x3_in, "--json"))

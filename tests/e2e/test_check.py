"""`servohil check`: text, JSON and exit status tell the same. What it finds is this machine's; nothing is asserted of it,
nor of time."""

import json
import re
import subprocess

import pytest

from emulator import NOT_VALID, OK, PROGRAM, REPOSITORY, USAGE, run, settings

FINDINGS = ["kernel", "timers", "clock", "throttling", "machine", "load", "priority", "memory", "isolation", "governor",
            "idle states", "interrupts", "CAN"]


class Checked:
    """A check to its end."""

    def __init__(self, tmp_path, *arguments):
        file = tmp_path / "check.json"
        self.done = subprocess.run([PROGRAM, "check", "--duration", "2", "--json", file, *arguments],
                                   capture_output=True, text=True, timeout=120, cwd=REPOSITORY)
        assert self.done.returncode in (OK, NOT_VALID) and self.done.stderr == "", self.done
        self.text, self.json = self.done.stdout, json.loads(file.read_text())


def agree(checked):
    text, report = checked.text, checked.json
    # Findings, each with its fix; "real time" only where the kernel refuses what the limits promise.
    lines = re.findall(r"^(OK|WARN|BAD) +([a-zA-Z]+(?: [a-z]+)?)  +(.*)$(?:\n +fix: (.*))?", text.split("the loop, ")[0], re.M)
    assert [tuple(finding[key] for key in ("verdict", "name", "value", "fix")) for finding in report["findings"]] == lines
    assert [name for _, name, _, _ in lines if name != "real time"] == FINDINGS
    # Levels.
    levels = report["measurement"]["levels"]
    shown = re.findall(r"^(OK|NEAR|LATE) +(\d+) ticks? per wake: worst ([\d.]+) ms .*?, (\d+) of (\d+) wakes late", text, re.M)
    assert [(level["verdict"], level["wake_ticks"], level["late_wakes"], level["wakes"]) for level in levels] == [
        (verdict, int(ticks), int(late), int(wakes)) for verdict, ticks, _, late, wakes in shown]
    for level, (*_, worst, _, _) in zip(levels, shown):
        assert abs(level["worst_lateness_ns"] / 1e6 - float(worst)) <= 0.0006
        fits = level["worst_lateness_ns"] + level["compute_worst_ns"] <= level["wake_ticks"] * 50_000
        assert level["verdict"] == ("LATE" if level["late_wakes"] else "OK" if fits else "NEAR")
    assert all(level["verdict"] != "OK" for level in levels[:-1])
    # Verdict.
    verdict = report["verdict"]
    assert re.search(r"^verdict  (.*)$", text, re.M)[1] == verdict["text"]
    bad = any(finding["verdict"] == "BAD" for finding in report["findings"])
    fit = levels[-1]["wake_ticks"] if levels[-1]["verdict"] == "OK" and not bad else None
    assert verdict["fit_wake_ticks"] == fit
    assert verdict["text"].startswith("UNFIT" if fit is None else
                                      "FIT at 0.1 ms" if fit == 1 else f"FIT at {fit} ticks per wake")
    assert verdict["as_configured"] == (fit is not None and fit <= verdict["configured_wake_ticks"])
    assert checked.done.returncode == (OK if verdict["as_configured"] else NOT_VALID)


def test_text_json_and_exit_status_agree(tmp_path):
    agree(Checked(tmp_path))


def test_a_bad_finding_makes_it_unfit(tmp_path):
    checked = Checked(tmp_path, *settings(can__buses='["socketcan:nowhere0"]', loop__wake_ticks=50))
    agree(checked)
    assert checked.done.returncode == NOT_VALID
    assert "UNFIT: " in checked.text and "nowhere0 is not there" in checked.text


def test_a_cpu_that_is_not_there_is_refused_and_named(tmp_path):
    checked = Checked(tmp_path, *settings(loop__cpu=1000))
    agree(checked)
    isolation = next(finding for finding in checked.json["findings"] if finding["name"] == "isolation")
    assert isolation["verdict"] == "BAD" and isolation["fix"].startswith("--set loop.cpu=")


def test_json_alone():
    done = subprocess.run([PROGRAM, "check", "--duration", "1", "--json", "-"], capture_output=True, text=True, timeout=120,
                          cwd=REPOSITORY)
    assert json.loads(done.stdout).keys() == {"findings", "measurement", "verdict"}
    assert done.returncode in (OK, NOT_VALID)


@pytest.mark.parametrize("arguments, said", [
    (("--duration", "0"), "--duration"),
    (("--duration", "soon"), "--duration"),
    (("--json", "/nowhere/check.json"), "/nowhere/check.json"),
    (("--set", "loop.wake_ticks=0"), "loop.wake_ticks"),
    (("-c", "/nowhere.toml"), "/nowhere.toml"),
    (("now",), "now"),
], ids=" ".join)
def test_mistakes(arguments, said):
    done = run("check", *arguments, status=USAGE)
    assert done.stdout == "" and len(done.stderr.splitlines()) == 1 and said in done.stderr, done


def test_help():
    text = run("check", "--help").stdout
    for part in ("[s]", "BAD", "half the wake period", "--json"):
        assert part in text

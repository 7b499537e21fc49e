"""Scenario files: the ready ones hold, and can fail; the same verdict in `simulate`, lockstep and replay."""

import json
import re
import signal
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from emulator import OK, REPOSITORY, USAGE, Emulator, run, settings

FAIL, INVALID = 1, 4
READY = sorted((REPOSITORY / "config" / "scenarios").glob("*.toml"))
LOCKSTEP_TICKS = 100


def simulate(file, *arguments, status):
    return run("simulate", "--scenario", file, *arguments, status=status).stdout


def verdicts(report):
    """[(PASS, expectation and what was found)], in the file's order."""
    return re.findall(r"^(PASS|FAIL|INVALID) +(?!the whole run)(.*)$", report, re.M)


def total(report):
    return re.search(r"^verdict +(PASS|FAIL|INVALID): ", report, re.M)[1]


def blocks(text):
    """The file's tables, as text."""
    return re.split(r"(?m)^(?=\[)", text)


def without(text, *heads):
    return "".join(block for block in blocks(text) if not block.startswith(heads))


def turned_round(text):
    """Every expectation made into one that cannot hold where the file's own does."""
    text = re.sub(r"(?m)^of = (\S+)", lambda m: f"of = {float(m[1]) + 1e4}", text)
    text = re.sub(r"(?m)^above = \S+\nbelow = \S+", "above = 1e5", text)
    text = re.sub(r"(?m)^above = \S+", "above = 1e5", text)
    text = re.sub(r"(?m)^below = \S+", "below = -1e5", text)
    text = re.sub(r"(?m)^oscillation_below = \S+", "oscillation_below = 1e-30", text)
    text = re.sub(r"(?m)^oscillation_above = \S+", "oscillation_above = 1e5", text)
    return re.sub(r"(?m)^never = \S+", 'never = "RUNNING"', text)


@pytest.mark.parametrize("file", READY, ids=lambda file: file.stem)
def test_a_ready_scenario_holds(file):
    report = simulate(file, status=OK)
    assert total(report) == "PASS"
    assert len(verdicts(report)) == file.read_text().count("[[expect]]") >= 4
    assert file.read_text().startswith("# "), "its story stands at its top"
    assert 1.0 < float(re.search(r"hold; ([\d.]+) s", report)[1]) <= 30.0


@pytest.mark.parametrize("file", READY, ids=lambda file: file.stem)
def test_a_ready_scenario_fails_without_its_faults(file, tmp_path):
    harmless = tmp_path / "harmless.toml"
    harmless.write_text(without(file.read_text(), "[[fault]]", "[[clear]]"))
    assert total(simulate(harmless, status=FAIL)) == "FAIL"


@pytest.mark.parametrize("file", READY, ids=lambda file: file.stem)
def test_each_expectation_of_a_ready_scenario_can_fail(file, tmp_path):
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(turned_round(file.read_text()))
    found = verdicts(simulate(wrong, status=FAIL))
    assert len(found) == file.read_text().count("[[expect]]")
    for verdict, text in found:
        # Exactly at rest nothing swings, however little is allowed: the sole limit that cannot be turned round.
        assert verdict == "FAIL" or ": 0 in peak to peak" in text, text


def test_there_are_at_least_eight_and_the_readme_lists_them():
    readme = (READY[0].parent / "README.md").read_text()
    assert len(READY) >= 8
    assert set(re.findall(r"(?m)^\| `(\w+)` \| [^=]", readme.split("## Ready ones")[1])) == {f.stem for f in READY}


SMALL = """
duration_s = 0.5
[[command]]
at_s = 0.1
p1_psi = 30.5
[[fault]]
name = "piston_jammed"
at_s = 0.3
[[command]]
at_s = 0.4
p1_psi = 32.0
[[expect]]
quantity = "x3_in"
within = 0.02
of = 4.1
by_s = 0.2
[[expect]]
quantity = "x3_in"
oscillation_below = 1e-9
from_s = 0.31
[[expect]]
quantity = "p3_psi"
below = 200
[[expect]]
never = "MODEL_FAULT"
"""


@pytest.fixture
def small(tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return file


def test_a_failure_says_what_was_measured_when_and_the_limit(small, tmp_path):
    """The jammed piston stands, but under 32 psi of P1 its P3 goes to the supply's 300 psi."""
    report = simulate(small, "--report-json", tmp_path / "r.json", "--report-junit", tmp_path / "r.xml", status=FAIL)
    assert [verdict for verdict, _ in verdicts(report)] == ["PASS", "PASS", "FAIL", "PASS"]
    line = verdicts(report)[2][1]
    assert re.fullmatch(r"p3 below 200 psi from 0 s to 0.5 s: 299\.\d+ psi at 0\.4\d+ s; first outside at 0\.4\d+ s; "
                        rf"limit below 200 psi \({re.escape(str(small))}:21\)", line), line

    found = json.loads((tmp_path / "r.json").read_text())
    assert found["verdict"] == "FAIL" and found["invalid_because"] == []
    worst = found["expectations"][2]
    assert worst["verdict"] == "FAIL" and worst["line"] == 21
    assert 299.0 < worst["measured"] < 301.0 and 0.4 < worst["at_s"] < 0.42

    suite = ElementTree.parse(tmp_path / "r.xml").getroot()[0]
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("4", "1", "0")
    assert suite[2].find("failure") is not None and "299." in suite[2][0].get("message")
    assert all(suite[i].find("failure") is None for i in (0, 1, 3))


MISTAKES = [
    ('name = "piston_jammed"', 'name = "piston_jamed"', ":6: [[fault]]: there is no fault piston_jamed; did you mean piston_jammed?"),
    ('name = "piston_jammed"', 'name = "load_step"\npsi = 999', ":8: [[fault]] psi = 999: must be a number from -300 to 300 psi"),
    ('name = "piston_jammed"', 'name = "gas_charge_lost"', ":6: [[fault]]: gas_charge_lost: stabilizer.enabled is false"),
    ("at_s = 0.3", "at_s = 3", ":8: [[fault]] at_s = 3: must be a number from 0 to 0.5 s"),
    ("at_s = 0.4", "at_s = 0.1", ":10: [[command]] at_s = 0.1: must rise from command to command"),
    ("p1_psi = 32.0", "p1_psi = 320", ":11: [[command]] p1_psi = 320: must be a number from 0 to 300 psi"),
    ("p1_psi = 32.0", "", ":9: [[command]]: it commands nothing: give p1_psi, p1_change_psi or amplitude_psi"),
    ('"x3_in"', '"x3"', ':13: [[expect]] quantity = \'x3\': did you mean x3_in?'),
    ("within = 0.02", "wihtin = 0.02", ":14: [[expect]] has no key wihtin; did you mean within?"),
    ("of = 4.1", "", ":12: [[expect]] has no of: it must be a number of in"),
    ("by_s = 0.2", "by_s = 0.5", ":16: [[expect]] by_s = 0.5: must be before the end of its time"),
    ('never = "MODEL_FAULT"', 'never = "MODELFAULT"', ':25: [[expect]] never = \'MODELFAULT\': did you mean MODEL_FAULT?'),
    ('never = "MODEL_FAULT"', 'mode = "STOPPED"\nafter = "piston"\nwithin_ms = 50',
     ':26: [[expect]] after = \'piston\': did you mean piston_jammed?'),
    ("duration_s = 0.5", "duration = 0.5", ":2: scenario has no key duration; did you mean duration_s?"),
    ("duration_s = 0.5", "duration_s = 0.5\n[configuration]\nservo.underlap_in = 3",
     ":4: servo.underlap_in = 3: must be a number from -0.05 to 0.05 in"),
    ("duration_s = 0.5", "duration_s = 0.5\n[configuration]\nservo.underlap_in = 566666666666666666666.0",
     ":4: servo.underlap_in = 566666666666666688512: must be a number from -0.05 to 0.05 in"),
    ("[[fault]]", "[fault]", ":6: fault: must be tables: [[fault]]"),
    ("duration_s = 0.5", "duration_s = = 0.5", ":2: "),
]


@pytest.mark.parametrize("right, wrong, message", MISTAKES, ids=[m[1][:30] for m in MISTAKES])
def test_a_mistake_is_one_line_with_its_place(right, wrong, message, tmp_path):
    file = tmp_path / "wrong.toml"
    assert right in SMALL
    file.write_text(SMALL.replace(right, wrong, 1))
    errors = run("simulate", "--scenario", file, status=USAGE).stderr
    assert errors.startswith(f"servohil: {file}{message}") and errors.count("\n") == 1, errors


def test_the_command_line_counts_more_than_the_file(tmp_path):
    file = tmp_path / "own.toml"
    (tmp_path / "own_configuration.toml").write_text("supply.pressure_psi = 250\n")
    file.write_text('duration_s = 0.01\n[configuration]\nfile = "own_configuration.toml"\nsupply.drain_pressure_psi = 2\n'
                    '[[expect]]\nquantity = "p2_psi"\nwithin = 0\nof = 250\n')
    more = settings(load__file=REPOSITORY / "config/load_curve.csv", can__dbc=REPOSITORY / "config/servohil.dbc")
    simulate(file, *more, status=OK)
    assert "280 psi" in simulate(file, *more, *settings(supply__pressure_psi=280), status=FAIL)
    errors = run("simulate", "--scenario", file, *settings(fault__armd="no"), status=USAGE).stderr
    assert "fault.armed" in errors


def lockstep_governor(emulator, connect, p1_at):
    """Commands p1_at(tick) for every 10 ms, each answered, until the emulator has ended by itself."""
    client, tick = connect(emulator), 0
    while tick < 5_000:
        client.send_p1(p1_at(tick))
        client.newest("SERVO_Status")
        tick += LOCKSTEP_TICKS
    client.until_ended()


def small_p1(tick):
    return 32.0 if tick >= 4_000 else 30.5 if tick >= 1_000 else 30.263


def test_lockstep_and_replay_give_the_verdict_of_simulate(start, connect, tmp_path):
    """With the same commands at the same ticks: word by word, and the same state hash."""
    file = tmp_path / "same.toml"
    file.write_text(SMALL.replace("[[command]]", "[[command]]\nat_s = 0\np1_psi = 30.263\n[[command]]", 1)
                    .replace("30.263", repr(30263 * 0.001)).replace("30.5", repr(30500 * 0.001)))
    simulated = simulate(file, status=FAIL)

    emulator = start("--clock", "lockstep", "--scenario", file, "--record", tmp_path / "rec", "--control", "none")
    lockstep_governor(emulator, connect, small_p1)
    status, text = emulator.end()
    assert status == FAIL and total(text) == "FAIL"
    report = text[text.index("scenario "):]
    assert report == simulated[simulated.index("scenario "):]

    replayed = run("replay", tmp_path / "rec", "--scenario", file, status=FAIL).stdout
    assert report in replayed
    what_if = run("replay", tmp_path / "rec", "--scenario", file, *settings(supply__pressure_psi=190),
                  "--record", tmp_path / "what-if", status=FAIL).stdout
    assert verdicts(what_if)[2][0] == "PASS"  # with less supply than the limit P3 stays below it


def test_in_real_time_scenario_time_begins_with_the_governor(start, connect, small):
    """However late it comes. Late ticks, as on a busy machine, make it INVALID, and nothing else does."""
    emulator = start("--scenario", small, "--control", "none", "--rt", "off")
    client = connect(emulator)
    waited = int(client.newest("SERVO_Position", lambda f: f["Tick"] > 2_000)["Tick"])
    client.send_p1(30.5)
    client.until_ended()
    status, text = emulator.end()
    reasons = re.findall(r"^INVALID  the whole run: (\w+)", text, re.M)
    assert int(re.search(r"^ran +(\d+) ticks", text, re.M)[1]) >= waited + 5_000
    if reasons:
        assert status == INVALID and total(text) == "INVALID" and set(reasons) == {"timing"}
        assert all(verdict == "INVALID" for verdict, _ in verdicts(text))
    else:
        # Under 30.5 psi for good, the jammed piston's P3 stays where it was.
        assert status == OK and total(text) == "PASS", text


def test_a_governor_that_never_comes_is_invalid(start, tmp_path):
    file = tmp_path / "alone.toml"
    file.write_text("wait_s = 0.2\n" + SMALL)
    emulator = start("--scenario", file, "--control", "none", "--rt", "off")
    status, text = emulator.end()
    assert status == INVALID and total(text) == "INVALID"
    assert "no command ever came: the governor was not there" in text


def test_a_run_that_ends_early_has_decided_what_it_has_seen(start, connect, tmp_path):
    file = tmp_path / "early.toml"
    file.write_text('duration_s = 10\n[[expect]]\nquantity = "p1_psi"\nbelow = 31\n[[expect]]\nquantity = "x3_in"\n'
                    'above = 1\n[[expect]]\nquantity = "x3_in"\nabove = 1\nto_s = 0.005\n')
    emulator = start("--clock", "lockstep", "--scenario", file, "--control", "none")
    client = connect(emulator)
    client.send_p1(32.0)
    client.newest("SERVO_Status")
    emulator.signal(signal.SIGTERM)
    status, text = emulator.end()
    assert [verdict for verdict, _ in verdicts(text)] == ["FAIL", "INVALID", "PASS"]
    assert "the run ended at 0.0100 s of the scenario, before that" in text
    assert status == FAIL and total(text) == "FAIL"


def test_faults_that_are_not_armed_are_refused_before_the_start(small):
    with pytest.raises(AssertionError, match="faults are not armed: fault.armed = \"no\""):
        Emulator(["slcan:pty"], "--scenario", small, *settings(fault__armed="no"))


def test_options_that_contradict_a_scenario_are_refused(small):
    for command in (["simulate", "--duration", "1"], ["simulate", "--p1-step", "1"], ["run", "--duration", "1"],
                    ["run", "--clock", "fast"]):
        run(*command, "--scenario", small, status=USAGE)
    assert "--scenario FILE is required" in run("simulate", status=USAGE).stderr
    assert "none.toml: there is no such file" in run("simulate", "--scenario", "none.toml", status=USAGE).stderr
    run("simulate", "--duration", "1", "--report-json", "x", status=USAGE)

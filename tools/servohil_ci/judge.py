"""What an INVALID run does to a test: it is run once more; INVALID again, it has neither passed nor failed.

A verdict about a governor from a run whose timing or model was not valid is worth nothing, whatever the test's
assertions said.
"""

import shutil

import pytest
from _pytest.runner import runtestprotocol  # what every plugin that runs a test again uses

RUNS = pytest.StashKey()  # of an item: the emulators that its present attempt started
LOG_LINES = 30            # of the emulator's warnings and errors, in a failure report


def run(item, nextitem):
    """Runs the test, again if INVALID; the reports that count, with what is to be known of the emulator."""
    properties = list(item.user_properties)
    reports, runs = _attempt(item, nextitem)
    first = _invalid(runs)
    if first:
        item.user_properties[:] = properties
        reports, again = _attempt(item, nextitem)
        runs += again
        _note(reports, "servohil_rerun", first)
        if verdict := _invalid(again):
            _make_invalid(reports, verdict)
    if any(report.failed for report in reports):
        _attach(reports, runs)
    else:
        for bench in runs:
            shutil.rmtree(bench.folder, ignore_errors=True)
    return reports


def _attempt(item, nextitem):
    """Its reports and its emulators."""
    runs = item.stash[RUNS] = []
    return runtestprotocol(item, nextitem=nextitem, log=False), runs


def _invalid(runs):
    """The verdict of a run that was not valid; None: all were, or crashed."""
    return next((bench.verdict for bench in runs if bench.outcome and not bench.outcome.valid), None)


def _note(reports, name, value):
    """A property in the JUnit file, and an attribute for the terminal."""
    for report in reports:
        report.user_properties.append((name, value))
        setattr(report, name, value)


def _make_invalid(reports, verdict):
    """The test neither passed nor failed: it is INVALID."""
    _note(reports, "servohil_verdict", "INVALID")
    for report in reports:
        if report.when == "call" and (not report.skipped or hasattr(report, "wasxfail")):
            said = f"\n\nWhat the test said is worth nothing:\n{report.longreprtext}" if report.failed else ""
            report.outcome, report.longrepr = "failed", f"{verdict}\n(twice: the test was run again){said}"
            report.servohil_invalid = verdict
            report.__dict__.pop("wasxfail", None)


def _attach(reports, runs):
    """What the emulators left, to every report that failed."""
    for number, bench in enumerate(runs, 1):
        which = f" {number} of {len(runs)}" if len(runs) > 1 else ""
        log = [line for line in bench.log().splitlines() if ": info: " not in line][-LOG_LINES:]
        lines = [f"verdict: {bench.verdict or 'none, it crashed'}", f"files: {bench.folder}"]
        if bench.recording:
            lines.append(f"recording: {bench.recording}")
            for report in reports:
                report.user_properties.append(("servohil_recording", str(bench.recording)))
        for report in reports:
            if report.failed:
                report.sections.append((f"servohil{which}", "\n".join([*lines, *log])))

"""The pytest plugin: fixture `servohil`, its options, and INVALID as an outcome of its own.

    @pytest.mark.servohil(clock="real", settings={"oil.air_fraction": 0.02})
    def test_holds(servohil):
        servohil.send_p1(30.5)
        servohil.wait_until(lambda state: abs(state.v3_in_s) < 0.05, timeout_s=2.0)

Options come from the command line, else the ini file; the marker, of the function before that of its module, is the
test's own need and beats both. Names of files count from the current folder, the ini file's, or the test file's.
"""

import itertools
import re
from pathlib import Path

import pytest

try:
    from . import bus, judge
    from .bench import Servohil
    from .emulator import find_program
    from .failure import NOTHING, USAGE, Failure
    from .options import CLOCKS, LOCKSTEP, Options
except ImportError as missing:
    raise pytest.UsageError(f"servohil_ci: {missing}; it needs Python 3.11 and Debian's python3-can, python3-serial "
                            "and python3-canmatrix") from None

__tracebackhide__ = True
OPTIONS = {
    "program": "the emulator; default: the one beside this package, else in PATH",
    "config": "its configuration (TOML); default: ./config/servohil.toml, else the one installed with it",
    "bus": "auto (default: vcan0 if this kernel has it, else slcan:pty), socketcan:IFACE, slcan:pty",
    "clock": "lockstep (default: time passes by commands only), real",
}
FILES = ("program", "config", "dbc")  # options that name one
MARKER = ("config", "settings", "clock", "dbc")


def pytest_addoption(parser):
    group = parser.getgroup("servohil", "servohil: the emulated servomotor")
    for name, text in OPTIONS.items():
        group.addoption(f"--servohil-{name}", metavar=name.upper(), help=text)
        parser.addini(f"servohil_{name}", text)


def pytest_configure(config):
    config.addinivalue_line("markers", f"servohil({', '.join(f'{name}=...' for name in MARKER)}): how this test wants "
                                       "its emulator; settings: {key: value}, clock: " + " or ".join(CLOCKS))


def pytest_report_header(config):
    chosen = _chosen(config)
    where = chosen.get("bus", "auto")
    where = bus.best_url() if where == "auto" else where
    return f"servohil: {chosen.get('program') or 'not found'}, {where}, clock {chosen.get('clock', LOCKSTEP)}"


def _chosen(config):
    """Options of the command line and the ini file."""
    of_ini = {name: config.getini(f"servohil_{name}") for name in OPTIONS}
    of_command_line = {name: config.getoption(f"servohil_{name}") for name in OPTIONS}
    chosen = (_named(of_ini, config.inipath.parent if config.inipath else config.rootpath)
              | _named(of_command_line, config.invocation_params.dir))
    if "program" not in chosen and (found := find_program()):
        chosen["program"] = found
    return chosen


def _named(options, folder):
    """Those that are given; files count from this folder."""
    return {name: (folder / Path(value).expanduser()).resolve() if name in FILES else value
            for name, value in options.items() if value}


def _options(node):
    """How this test wants its emulator."""
    chosen, settings = _chosen(node.config), {}
    for marker in reversed(list(node.iter_markers("servohil"))):  # the closest last
        unknown = [*map(str, marker.args), *(name for name in marker.kwargs if name not in MARKER)]
        if unknown:
            raise Failure(USAGE, f"pytest.mark.servohil: '{unknown[0]}' is none of {', '.join(MARKER)}")
        own = dict(marker.kwargs)
        own_settings = own.pop("settings", {})
        if not isinstance(own_settings, dict):
            raise Failure(USAGE, f"pytest.mark.servohil: settings {own_settings!r}: expected a dictionary, e.g. "
                                 '{"servo.underlap_in": 0.001}')
        settings |= own_settings
        chosen |= _named(own, node.path.parent)
    if "program" not in chosen:
        raise Failure(NOTHING,
                      "no program servohil beside this package or in PATH: build it, or --servohil-program=FILE")
    if not chosen["program"].is_file():
        raise Failure(NOTHING, f"--servohil-program {chosen['program']}: there is no such file")
    return Options(**chosen, settings=settings)


def _folder(node, base):
    """A new one: servohil/TEST-1 for the first run, servohil/TEST-2 for the second."""
    name = re.sub(r"[^\w.-]", "_", f"{node.path.stem}-{node.name}")[:200]
    for number in itertools.count(1):
        folder = base / "servohil" / f"{name}-{number}"
        try:
            folder.mkdir(parents=True)
            return folder
        except FileExistsError:
            continue


@pytest.fixture
def servohil(request, tmp_path_factory):
    """A running emulator, connected: servohil_ci.bench.Servohil."""
    try:
        bench = Servohil(_options(request.node), _folder(request.node, tmp_path_factory.getbasetemp()))
    except Failure as failure:
        raise pytest.fail.Exception(str(failure), pytrace=False) from None
    request.node.stash.setdefault(judge.RUNS, []).append(bench)
    yield bench
    try:
        outcome = bench.stop()
    except Failure as failure:
        raise pytest.fail.Exception(str(failure), pytrace=False) from None
    if not outcome.valid and "servohil" not in request.node.fixturenames:  # by getfixturevalue: not run again
        pytest.fail(f"{outcome.verdict} (not run again: name the fixture as an argument)", pytrace=False)


def pytest_runtest_protocol(item, nextitem):
    """Runs the tests that have an emulator."""
    if "servohil" not in getattr(item, "fixturenames", ()):
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in judge.run(item, nextitem):
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def pytest_report_teststatus(report):
    if hasattr(report, "servohil_invalid"):
        return "invalid", "I", ("INVALID", {"red": True})
    return None


def pytest_terminal_summary(terminalreporter):
    """The INVALID ones, and those that became valid when they were run again."""
    invalid = terminalreporter.stats.get("invalid", [])
    if invalid:
        terminalreporter.section("INVALID: no verdict, run twice", red=True)
    for report in invalid:
        terminalreporter.line(f"{report.nodeid}: {report.servohil_invalid}", red=True)
        for title, content in report.sections:
            terminalreporter.line(f"--- {title} ---\n{content}")
    rerun = [report for reports in terminalreporter.stats.values() for report in reports
             if getattr(report, "when", "") == "call" and hasattr(report, "servohil_rerun")
             and not hasattr(report, "servohil_invalid")]
    if rerun:
        terminalreporter.section("servohil: run again, as the first run was INVALID")
    for report in rerun:
        terminalreporter.line(f"{report.nodeid}: {report.outcome} when run again; the first run: "
                              f"{report.servohil_rerun}")

"""The bus tests run over the transports of SERVOHIL_BUS: slcan, socketcan, or both with a comma between; those of
test_can_controllers.py over controllers.

Default: slcan, and socketcan where the kernel has vcan0 or SERVOHIL_GUEST is set (tools/vcan-guest sets it). A
transport that is asked for and missing is a failure, never a skip.
"""

import os
import signal
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))

from emulator import PROGRAM, Client, Emulator  # noqa: E402

# A shell's background job ignores SIGINT, and so would every program that it tests.
signal.signal(signal.SIGINT, signal.default_int_handler)

VCAN = "vcan0"
URLS = {"slcan": "slcan:pty", "socketcan": f"socketcan:{VCAN}", "controllers": "socketcan:can0"}


def exists(interface):
    return Path("/sys/class/net", interface).exists()


def transports():
    wanted = os.environ.get("SERVOHIL_BUS", "")
    if not wanted:
        return ["slcan", "socketcan"] if exists(VCAN) or os.environ.get("SERVOHIL_GUEST") else ["slcan"]
    names = wanted.split(",")
    for name in names:
        if name not in URLS:
            raise pytest.UsageError(f"SERVOHIL_BUS={wanted}: expected slcan, socketcan, slcan,socketcan or controllers")
    return names


def pytest_report_header():
    missing = "" if "socketcan" in transports() else f"; no {VCAN} here: tools/vcan-guest runs the socketcan ones"
    return f"bus tests over: {', '.join(transports())}{missing}"


def pytest_generate_tests(metafunc):
    if "transport" in metafunc.fixturenames:
        only = metafunc.definition.get_closest_marker("only")
        names = [name for name in transports() if (name in only.args if only else name != "controllers")]
        metafunc.parametrize("transport", names or ["not selected"], scope="module")


def pytest_configure(config):
    config.addinivalue_line("markers", "only(transport): a test of what this transport alone has")


def pytest_collection_modifyitems(config, items):
    """A test of a transport that is not selected does not exist, rather than being skipped."""
    gone = [i for i in items if getattr(i, "callspec", None) and i.callspec.params.get("transport") == "not selected"]
    if gone:
        config.hook.pytest_deselected(items=gone)
        items[:] = [i for i in items if i not in gone]


@pytest.fixture(scope="module")
def url(transport):
    """What --can takes for this transport."""
    if not PROGRAM.exists():
        pytest.fail(f"{PROGRAM}: build it first, or set SERVOHIL_BUILD")
    if transport == "controllers" and not (exists("can0") and exists("can1")):
        pytest.fail("there are no controllers can0 and can1: run through tools/vcan-guest --controllers")
    if transport == "socketcan" and not exists(VCAN):
        pytest.fail(f"socketcan is asked for, but there is no {VCAN}: sudo ip link add dev {VCAN} type vcan && sudo ip "
                    f"link set up {VCAN}, or run through tools/vcan-guest")
    return URLS[transport]


@pytest.fixture
def start(url):
    """Starts an emulator on this transport: start("--set", ...) → Emulator; buses=2: with two connections."""
    running = []

    def start_one(*arguments, buses=1):
        many = [url] * buses if url == URLS["slcan"] else [url]
        running.append(Emulator(many, *arguments))
        return running[-1]

    yield start_one
    for emulator in running:
        emulator.__exit__()


@pytest.fixture
def connect():
    """Connects a client to an emulator: connect(emulator) → Client; which=1: to its second connection."""
    connected = []

    def connect_one(emulator, which=0):
        connected.append(Client(emulator.urls[which % len(emulator.urls)]))
        return connected[-1]

    yield connect_one
    for client in connected:
        client.__exit__()

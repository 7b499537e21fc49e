"""PROTOCOL.md is true: its requests are sent to a running emulator, whose answers are those that stand there, but for
the numbers of the moment; and the control socket keeps the limits that the document states."""

import json
import re
import socket
import stat

import pytest
from emulator import PATIENCE_S, REPOSITORY, settings

DOCUMENT = (REPOSITORY / "PROTOCOL.md").read_text()
SESSION = re.findall(r"^    > (.*)\n    < (.*)$", DOCUMENT, re.MULTILINE)


class Connection:
    def __init__(self, path):
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(PATIENCE_S)
        self._socket.connect(str(path))
        self._lines = self._socket.makefile("r")

    def ask(self, line):
        self._socket.sendall(line.encode() + b"\n")
        return self._lines.readline()

    def closed(self):
        """Whether the other end closes the connection, whatever it still sends."""
        try:
            while self._lines.readline():
                pass
        except ConnectionResetError:
            pass
        return True  # a socket that stays open times out


@pytest.fixture
def path(start, tmp_path):
    control = tmp_path / "control"
    start("--control", control, "--snapshot-dir", tmp_path, *settings(fault__armed="yes"))
    return control


def shape(answer):
    """What is the same in every run: all but the values of the moment."""
    return {k: v if k in ("id", "result", "reason") else type(v) for k, v in answer.items()}


def test_each_request_has_the_answer_that_stands_there(path):
    assert len(SESSION) >= 12
    connection = Connection(path)
    for request, documented in SESSION:
        answer = connection.ask(request)
        if documented.endswith("..."):
            assert answer.startswith(documented.removesuffix(" ...").rstrip(", "))
            continue
        assert shape(json.loads(answer)) == shape(json.loads(documented)), request


def test_the_socket_has_mode_0660(path):
    assert stat.S_IMODE(path.stat().st_mode) == 0o660


@pytest.mark.parametrize("size", [4097, 5000, 8000, 200_000])
def test_a_line_that_is_too_long_ends_the_connection(path, size):
    connection = Connection(path)
    try:
        answer = connection.ask("x" * size)
    except (BrokenPipeError, ConnectionResetError):  # closed while it was still being sent
        return
    if answer:
        assert json.loads(answer)["result"] == "REJECTED" and "4096" in json.loads(answer)["reason"]
    assert connection.closed()


def test_a_line_of_4096_bytes_is_understood(path):
    request = '{"request":"status"}'
    assert json.loads(Connection(path).ask(request + " " * (4096 - len(request))))["result"] == "OK"


def test_one_client_more_than_16_is_closed(path):
    clients = [Connection(path) for _ in range(16)]
    for client in clients:
        assert json.loads(client.ask('{"request":"status"}'))["result"] == "OK"
    assert Connection(path).closed()
    assert json.loads(clients[0].ask('{"request":"status"}'))["result"] == "OK"


def test_a_client_that_does_not_read_is_closed_and_delays_nobody(path):
    deaf = Connection(path)
    with pytest.raises((BrokenPipeError, ConnectionResetError)):
        while True:  # until its unread answers are too many
            deaf._socket.sendall(b'{"request":"catalogue"}\n' * 20)
    assert json.loads(Connection(path).ask('{"request":"status"}'))["result"] == "OK"


def test_sixteen_faults_are_as_many_as_there_can_be(path):
    connection = Connection(path)
    catalogue = json.loads(connection.ask('{"request":"catalogue"}'))["catalogue"]
    supported = [one["fault"] for one in catalogue if one["unsupported"] is None]
    asked = [json.loads(connection.ask(json.dumps({"request": "inject", "fault": name})))
             for name in supported[:17] + supported[:1]]
    assert [one["result"] for one in asked] == ["APPLIED"] * 16 + ["REJECTED"] + ["APPLIED"]
    assert "16 faults" in asked[16]["reason"]

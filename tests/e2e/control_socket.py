"""A client of the emulator's control socket, without the program: lines of JSON over a Unix socket."""

import json
import socket

from emulator import PATIENCE_S


class Control:
    """A connection. Usable as a context."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.connect(str(path))  # waits while too many others do
        self.socket.settimeout(PATIENCE_S)
        self._input = b""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.socket.close()

    def write(self, data):
        self.socket.sendall(data)

    def answer(self):
        """The next answer; None once the emulator has closed the connection."""
        while b"\n" not in self._input:
            try:
                data = self.socket.recv(65536)
            except ConnectionResetError:
                data = b""
            if not data:
                return None
            self._input += data
        line, self._input = self._input.split(b"\n", 1)
        return json.loads(line)

    def ask(self, request, **more):
        """ask("inject", fault="stiction", parameters={"psi": 5}) → the answer"""
        self.write(json.dumps({"request": request, **more}).encode() + b"\n")
        return self.answer()

    def apply(self, request, **more):
        """The tick from which on it acts."""
        answer = self.ask(request, **more)
        assert answer["result"] == "APPLIED", answer
        return answer["tick"]

    def inject(self, fault, **parameters):
        return self.apply("inject", fault=fault, parameters=parameters)

    def clear(self, fault=None):
        return self.apply("clear", fault=fault)

    def snapshot(self):
        return self.apply("snapshot")

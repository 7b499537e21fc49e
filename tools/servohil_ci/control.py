"""The control socket of `servohil run --control PATH`: one JSON object a line, a request and its answer."""

import json
import socket

from .failure import NOTHING, USAGE, Failure

__tracebackhide__ = True  # pytest: a failure is shown where the test called


class Control:
    """A connection. Every request waits for its answer."""

    def __init__(self, path, timeout_s):
        self._path, self._timeout_s = path, timeout_s
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(timeout_s)
        try:
            self._socket.connect(str(path))
        except OSError as error:
            self._socket.close()
            raise Failure(NOTHING, f"control socket {path}: {error.strerror or error}") from None
        self._stream = self._socket.makefile("rw", encoding="utf-8", newline="\n")
        self._id = 0

    def request(self, request, **more):
        """The answer, a dictionary. Raises a Failure unless it is one."""
        self._id += 1
        try:
            self._stream.write(json.dumps({"id": self._id, "request": request, **more}) + "\n")
            self._stream.flush()
            while line := self._stream.readline():
                answer = json.loads(line)
                if answer.get("id") == self._id:
                    return answer
        except TimeoutError:
            raise Failure(NOTHING, f"{request}: no answer on {self._path} within {self._timeout_s:g} s") from None
        except (OSError, ValueError, AttributeError) as error:
            raise Failure(NOTHING, f"{request}: {self._path}: {error}") from None
        raise Failure(NOTHING, f"{request}: the emulator closed {self._path}")

    def apply(self, request, **more):
        """A request that is to be applied; its answer. Raises a Failure with the emulator's reason if it is not."""
        answer = self.request(request, **more)
        if answer.get("result") == "APPLIED":
            return answer
        what = " ".join(filter(None, (request, more.get("fault"))))
        reason = answer.get("reason") or answer.get("error")
        raise Failure(USAGE, f"{what}: {answer.get('result', 'not applied')}" + (f": {reason}" if reason else ""))

    def close(self):
        self._stream.close()
        self._socket.close()

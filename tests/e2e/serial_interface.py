"""A kernel CAN interface with bit rate, error states and bus-off, without hardware: the line discipline N_SLCAN on a
pseudo-terminal whose other side is played here. It needs root and a kernel with slcan: tools/vcan-guest has both.

What the kernel sends comes out as frames; frames, states and errors of the adapter go in as its serial lines do:
t1232AABB, sb256256 (bus-off, receive counter, transmit counter), e1s (one stuff error).
"""

import fcntl
import os
import re
import struct
import subprocess
import termios
import threading
import tty

N_SLCAN = 17
STATES = {"error-active": "a", "error-warning": "w", "error-passive": "p", "bus-off": "b"}


def interfaces():
    return set(os.listdir("/sys/class/net"))


class SerialInterface:
    """`name` is the kernel's: can0, can1, ... Down until set up. As a context: gone at the end, as an adapter that is
    pulled out."""

    def __init__(self):
        self.lines = []  # that the kernel has written
        self._reads = threading.Event()
        self._reads.set()
        self._new = threading.Condition()
        before = interfaces()
        self._master, self._terminal = os.openpty()
        tty.setraw(self._terminal)
        fcntl.ioctl(self._terminal, termios.TIOCSETD, struct.pack("i", N_SLCAN))
        [self.name] = interfaces() - before
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.pull_out()

    def _read(self):
        rest = ""
        while True:
            self._reads.wait()
            try:
                text = os.read(self._master, 4096).decode()
            except OSError:
                return
            *lines, rest = re.split("[\r\a]", rest + text)
            with self._new:
                self.lines += lines
                self._new.notify_all()

    def wait_for_line(self, is_wanted, timeout_s=20.0):
        with self._new:
            assert self._new.wait_for(lambda: any(map(is_wanted, self.lines)), timeout_s), self.lines[-10:]

    def stop_reading(self):
        """The adapter stands still: after some frames the kernel's queue fills."""
        self._reads.clear()

    def go_on_reading(self):
        self._reads.set()

    def write(self, text):
        os.write(self._master, text.encode() + b"\r")

    def set_state(self, state, rx_errors, tx_errors):
        self.write(f"s{STATES[state]}{rx_errors:03d}{tx_errors:03d}")

    def disturb(self, kinds):
        """Errors on the bus: s stuffing, f form, c CRC, a no acknowledgement, b and B bits."""
        self.write(f"e{len(kinds)}{kinds}")

    def send_frame(self, id_, data):
        self.write(f"t{id_:03X}{len(data)}{data.hex().upper()}")

    def pull_out(self):
        if self._terminal is None:
            return
        terminal, self._terminal = self._terminal, None
        self._reads.set()
        os.close(terminal)  # ends the thread's read
        self._thread.join()
        os.close(self._master)


def ticks_on_line(adapter):
    """Of the SERVO_Position frames that the kernel has given to the adapter."""
    return [int.from_bytes(bytes.fromhex(line[5:])[4:], "little") for line in adapter.lines if line.startswith("t200")]


def ip(*arguments):
    subprocess.run(["ip", *map(str, arguments)], check=True)

"""The CAN bus by python-can: which one this machine has, how to connect, and what has come."""

import os
import queue
import threading
from pathlib import Path

from .failure import NOTHING, USAGE, Failure
from .libraries import can

VCAN = "vcan0"
POLL_S = 0.02  # how soon the inbox's thread sees that it is to end; frames wake it at once


def best_url():
    """For `servohil run --can`: vcan0 if this kernel has it, else a serial adapter that the emulator plays."""
    return f"socketcan:{VCAN}" if Path("/sys/class/net", VCAN).exists() else "slcan:pty"


def connect(interface, channel, bit_rate_bit_s=500000):
    """The bus, or one line about what is missing."""
    options = {}
    if interface == "slcan":
        options["bitrate"] = bit_rate_bit_s
        if os.path.realpath(channel).startswith("/dev/pts/"):
            options["sleep_after_open"] = 0.0  # the 2 s are for boards that reset when they are opened
    try:
        return can.Bus(interface=interface, channel=channel, **options)
    except can.CanInterfaceNotImplementedError:
        raise Failure(USAGE, f"python-can has no interface '{interface}'; common ones: slcan, socketcan, pcan, "
                             "kvaser, ixxat") from None
    except Exception as error:  # a driver raises whatever it stumbles over
        hint = ""
        if interface == "socketcan":
            hint = ("; is it there and up? sudo ip link add dev vcan0 type vcan && sudo ip link set up vcan0"
                    if channel.startswith("vcan") else "; is it there and up? ip -br link show type can")
        elif interface == "slcan":
            hint = "; the emulator's line 'ready: ...' names its pseudo-terminal"
        elif not isinstance(error, (can.CanError, OSError, ValueError)):
            hint = "; is the driver of this interface installed?"
        reason = " ".join(str(error).split())
        raise Failure(NOTHING, f"{interface} {channel}: {reason}{hint}") from None


class Inbox:
    """Every frame in the order of its arrival, however long nobody asks."""

    def __init__(self, bus):
        self._bus = bus
        self._items = queue.SimpleQueue()  # can.Message; None: no more will come
        self._ended = threading.Event()
        self._over = False  # that no more will come, was taken
        self._thread = threading.Thread(target=self._receive, daemon=True)
        self._thread.start()

    def _receive(self):
        try:
            while not self._ended.is_set():
                frame = self._bus.recv(POLL_S)
                if frame is not None:
                    self._items.put(frame)
        except (can.CanError, OSError, ValueError):  # the line broke: the emulator is gone
            self._items.put(None)

    def no_more(self):
        """Wakes who waits: the emulator has ended. Any thread."""
        self._items.put(None)

    def take(self, timeout_s):
        """The next frame; None: no more will come. Raises queue.Empty."""
        if self._over:
            return None
        frame = self._items.get(timeout=timeout_s) if timeout_s > 0.0 else self._items.get_nowait()
        self._over = frame is None
        return frame

    def close(self):
        if self._ended.is_set():
            return
        self._ended.set()
        self._thread.join()
        try:
            self._bus.shutdown()
        except (can.CanError, OSError):
            pass  # the emulator went first

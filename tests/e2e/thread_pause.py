"""Holds one thread of a process, as a debugger does that stops at a breakpoint: the others go on."""

import contextlib
import ctypes
import os
from pathlib import Path

_ATTACH, _DETACH, _ALL_THREADS = 16, 17, 0x40000000  # PTRACE_ATTACH, PTRACE_DETACH, __WALL
_libc = ctypes.CDLL(None, use_errno=True)
_libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]


def _ptrace(what, thread):
    if _libc.ptrace(what, thread, None, None) != 0:
        raise OSError(ctypes.get_errno(), f"ptrace {what} of thread {thread}: {os.strerror(ctypes.get_errno())}")


def thread_of(process, name):
    """Its thread of this name."""
    for task in Path(f"/proc/{process}/task").iterdir():
        if (task / "comm").read_text().strip() == name:
            return int(task.name)
    raise AssertionError(f"process {process} has no thread {name}")


def _stop(thread):
    _ptrace(_ATTACH, thread)
    os.waitpid(thread, _ALL_THREADS)


@contextlib.contextmanager
def paused(process, name):
    """The thread stands still inside the context."""
    thread = thread_of(process, name)
    _stop(thread)
    try:
        yield
    finally:
        try:
            _ptrace(_DETACH, thread)
        except ProcessLookupError:
            os.waitpid(thread, _ALL_THREADS)  # killed meanwhile: its process ends when this is known

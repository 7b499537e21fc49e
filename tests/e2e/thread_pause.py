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


def _is_in_the_kernel(thread):
    """Sleeps, as a rule: what was interrupted is no instruction of its own."""
    return not Path(f"/proc/{thread}/syscall").read_text().startswith("-1 ")


@contextlib.contextmanager
def paused(process, name, at_work=False):
    """The thread stands still inside the context. at_work: in the middle of its work, not of its sleep."""
    thread = thread_of(process, name)
    _stop(thread)
    while at_work and _is_in_the_kernel(thread):
        _ptrace(_DETACH, thread)
        _stop(thread)
    try:
        yield
    finally:
        try:
            _ptrace(_DETACH, thread)
        except ProcessLookupError:
            os.waitpid(thread, _ALL_THREADS)  # killed meanwhile: its process ends when this is known

"""The fixture's object: an emulator, a governor's connection to it, and its control socket."""

import queue
import shutil
import subprocess
import tempfile
from pathlib import Path

from . import bus as buses
from .contract import MODE_FROZEN, TICK_S, Contract
from .control import Control
from .emulator import PATIENCE_S, Emulator, run_help
from .failure import NOTHING, USAGE, Failure
from .libraries import can
from .options import LOCKSTEP, Configuration, written
from .state import Newest

__tracebackhide__ = True  # pytest: a failure is shown where the test called


# A test commands when it has something to say, not in a cycle: its silence is no loss, unless it says so.
SETTINGS = {"safety.timeout_ms": 0}


class Unmet(AssertionError):
    """What a test waited for did not come."""


class Servohil:
    """An emulator under a test's control.

    Time is simulated time, in s, as the emulator's Tick tells it. In lockstep it passes only by send_p1, cycle,
    wait_until and run_for; in real time it passes by itself.

    process: the emulator's subprocess.Popen; log(): its standard error; url: its bus, for a governor that is a program
    of its own; bus: python-can's connection; contract: the DBC file; recording: the folder into which the run is
    recorded, None if this version of the program does not record.
    """

    def __init__(self, options, folder):
        """Returns when the emulator is ready and connected. folder: an empty one for its files. Raises a Failure."""
        self.options = options
        self.folder = Path(folder)
        self.recording = self.folder / "recording" if has_option(options, "--record") else None
        self.outcome = None
        self._sockets = Path(tempfile.mkdtemp(prefix="servohil-"))  # a socket's path has at most 107 bytes
        self._inbox = self._control = self._emulator = self._ended = None
        try:
            self._start()
        except BaseException:
            self._let_go()
            raise

    def _start(self):
        configuration = Configuration(self.options)
        self.contract = Contract(self.options.dbc or configuration.dbc())
        self._published = configuration.published()
        if "SERVO_Position" not in self._published:
            raise Failure(USAGE, "publish.position_ms = 0: without SERVO_Position there is no Tick to tell the time")
        self._lockstep = self.options.clock == LOCKSTEP
        self._newest = Newest(self.contract)
        self._sent = 0
        self._lets_pass = None  # the frame that lets time pass in lockstep
        self._emulator = Emulator(self.options.program, self._arguments(configuration), self.folder / "servohil.log",
                                  self._has_ended)
        self.process, self.log, self.url = self._emulator.process, self._emulator.log, self._emulator.url
        self.bus = buses.connect(*self.url.split(":", 1), int(configuration.get("can.bit_rate_bit_s", 500000)))
        self._inbox = buses.Inbox(self.bus)
        if self._ended:
            self._inbox.no_more()
        self._sync_id = configuration.lets_time_pass()
        if self._lockstep and self._sync_id is not None:
            self._lets_pass = can.Message(arbitration_id=self._sync_id, is_extended_id=False, data=b"")
        while not self._lockstep and not self._newest.seen.issuperset(self._published):
            self._take()

    def _arguments(self, configuration):
        options = self.options
        yield from ("-c", configuration.file, "--clock", options.clock)
        yield from ("--can", buses.best_url() if options.bus == "auto" else options.bus)
        settings = SETTINGS | dict(options.settings) | ({"can.dbc": options.dbc} if options.dbc else {})
        for key, value in settings.items():
            yield from ("--set", f"{key}={written(value)}")
        if self.recording:
            yield from ("--record", self.recording)
        if self.can_inject:
            yield from ("--control", self._sockets / "control")

    def _has_ended(self):
        self._ended = True
        if self._inbox:
            self._inbox.no_more()

    # --- commands and what comes back ---------------------------------------------------------------------------------

    def send_p1(self, p1_psi):
        """Sends the command [psi gauge]. In lockstep one cycle passes, and its answer is state()."""
        self.contract.check_p1(p1_psi)
        command = self.contract.encode(p1_psi, self._sent)
        self._sent += 1
        if self._lockstep and self._sync_id is None:
            self._lets_pass = command
        else:
            self._send(command)
        if self._lockstep:
            self._step()

    def cycle(self, p1_psi):
        """One cycle of a governor, on either clock: sends the command; the next state: in lockstep its answer, in real
        time what is published next."""
        if not self._lockstep:
            self._drain()
        self.send_p1(p1_psi)
        while not self._lockstep and self._take() != self._published[0]:
            pass
        return self.state()

    def state(self):
        """The newest value of every signal. In lockstep: the answer to the last command."""
        self._drain()
        if not self._newest.seen:
            raise Failure(USAGE, "no state yet: in lockstep time begins with the first send_p1")
        return self._newest.state()

    def wait_until(self, predicate, timeout_s):
        """The first state, from now on, for which predicate(state) holds. Raises Unmet when none comes within timeout_s
        of simulated time. In lockstep the last command is repeated, so that time passes."""
        for state in self._states(timeout_s):
            if predicate(state):
                return state
        raise Unmet(f"not met within {timeout_s:g} s of simulated time; last state: {state}")

    def run_for(self, duration_s):
        """Lets at least this long of simulated time pass; the states that came, one for each published tick."""
        return list({state.tick: state for state in self._states(duration_s)}.values())[1:]

    def _states(self, duration_s):
        """The state now, then each newer one, for so long."""
        if self._lockstep and not self._newest.seen:
            self._step()
        state = self.state()
        end = state.tick + round(duration_s / TICK_S)
        yield state
        while state.tick < end:
            if self._lockstep:
                self._step()
            else:
                self._take()
            state = self._newest.state()
            if getattr(state, "mode", None) == MODE_FROZEN:
                raise Failure(NOTHING, 'time stands still: the emulator is FROZEN (loop.overrun = "freeze")')
            yield state

    def _step(self):
        """Lockstep: one cycle passes, and is answered."""
        if self._lets_pass is None:
            raise Failure(USAGE, "send_p1 first: in lockstep time passes by the commands")
        self._drain()
        self._send(self._lets_pass)
        while self._take() != self._published[-1]:
            pass

    def _send(self, frame):
        trouble = None
        try:
            self.bus.send(frame)
        except (can.CanError, OSError) as error:
            trouble = " ".join(str(error).split())
        if trouble:
            raise self._why_nothing_comes(trouble)

    def _take(self):
        """The name of the next frame's message, which is then part of the state."""
        try:
            frame = self._inbox.take(PATIENCE_S)
        except queue.Empty:
            raise Failure(NOTHING, f"servohil runs, but nothing came for {PATIENCE_S:g} s on {self.url}: is it "
                                   "stopped, or was its frame lost?") from None
        if frame is None:
            raise self._why_nothing_comes("its bus is gone")
        return self._newest.add(frame)

    def _drain(self):
        """What has come already. Once stopped, the last state stays."""
        try:
            while frame := self._inbox.take(0.0):
                self._newest.add(frame)
        except queue.Empty:
            return
        if self.outcome is None:
            raise self._why_nothing_comes("its bus is gone")

    def _why_nothing_comes(self, how):
        """The emulator has ended; or how the bus broke."""
        if self.outcome is None:
            try:
                self.process.wait(PATIENCE_S)
            except subprocess.TimeoutExpired:
                return Failure(NOTHING, f"servohil runs, but {how}")
            self.stop()
        return Failure(NOTHING, f"the emulator has ended: verdict {self.verdict}")

    # --- faults -------------------------------------------------------------------------------------------------------

    @property
    def can_inject(self):
        """Whether this version of the program has a control socket."""
        return has_option(self.options, "--control")

    def inject(self, fault, **parameters):
        """Injects a fault, e.g. inject("air_entrainment", fraction=0.02, ramp_s=0.5, for_s=3); the emulator's answer,
        with the tick at which it was applied. Raises a Failure with the reason if it is rejected."""
        return self._control_socket().apply("inject", fault=fault, parameters=parameters)

    def clear(self, fault=None):
        """Ends a fault, or all."""
        return self._control_socket().apply("clear", **({"fault": fault} if fault else {}))

    def _control_socket(self):
        if not self.can_inject:
            raise Failure(USAGE, f"{self.options.program}: this version has no control socket: inject needs "
                                 "`servohil run --control`")
        if self._control is None:
            self._control = Control(self._sockets / "control", PATIENCE_S)
        return self._control

    # --- the end ------------------------------------------------------------------------------------------------------

    @property
    def verdict(self):
        """ "VALID" or "INVALID: reasons", once the emulator has ended; None before."""
        return self.outcome.verdict if self.outcome else None

    def stop(self):
        """Ends the emulator; its outcome. Raises a Failure with its standard error if it crashed. Again: the same."""
        if self.outcome is None:
            try:
                self._inbox.close()  # while there is a line to close
                self.outcome = self._emulator.end()
            finally:
                self._let_go()
        return self.outcome

    def _let_go(self):
        if self._control:
            self._control.close()
        if self._emulator:
            self._emulator.kill()
        if self._inbox:
            self._inbox.close()
        shutil.rmtree(self._sockets, ignore_errors=True)


def has_option(options, name):
    """Whether `servohil run` of this version has this option."""
    return f"{name} " in run_help(options.program)

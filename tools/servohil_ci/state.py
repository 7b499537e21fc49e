"""What the emulator published: the newest value of every signal."""

from .contract import TICK, TICK_S, unwrapped


class State:
    """Values by name, as attributes (state.x3_in) and as a mapping (state["x3_in"], dict(state)); never changes.

    Names are the DBC's with their unit. tick counts 0.1 ms of simulated time without wrapping; t_s is the same in s.
    """

    def __init__(self, values):
        self.__dict__.update(values)

    def __getattr__(self, name):  # only what is not there
        raise AttributeError(f"no signal {name}; there are {', '.join(self.__dict__)}")

    def __setattr__(self, name, value):
        raise AttributeError(f"{name}: a state does not change")

    def __getitem__(self, name):
        return self.__dict__[name]

    def keys(self):
        return self.__dict__.keys()

    def __repr__(self):
        return " ".join(f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}"
                        for name, value in self.__dict__.items())


class Newest:
    """Collects frames to states."""

    def __init__(self, contract):
        self._contract = contract
        self._attributes = contract.attributes()
        self._values = {}
        self._tick = None
        self.seen = set()  # messages

    def add(self, frame):
        """The name of the frame's message; None: somebody else's."""
        message, signals = self._contract.decode(frame)
        for signal, value in signals.items():
            if name := self._attributes.get((message, signal)):
                self._values[name] = self._typed(message, signal, value)
        if message == TICK[0]:
            self._tick = unwrapped(int(signals[TICK[1]]), self._tick)
            self._values |= {"tick": self._tick, "t_s": self._tick * TICK_S}
        if message:
            self.seen.add(message)
        return message

    def _typed(self, message, signal, value):
        layout = self._contract.require(message, signal)
        whole = layout.factor == 1 and layout.offset == int(layout.offset) and not layout.is_float
        return int(value) if whole else value

    def state(self):
        return State(self._values)

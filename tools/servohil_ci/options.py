"""How a test wants its emulator: the program, its configuration, clock and bus."""

import json
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from .contract import PUBLISHED
from .failure import USAGE, Failure

CLOCKS = ("lockstep", "real")
REAL_TIME, LOCKSTEP = "real", "lockstep"


@dataclass(frozen=True)
class Options:
    """config, dbc: files; None: the program's own. bus: for --can; auto: this machine's best. settings: for --set."""

    program: Path
    config: Path | None = None
    dbc: Path | None = None
    bus: str = "auto"
    clock: str = LOCKSTEP
    settings: dict = field(default_factory=dict)

    def __post_init__(self):
        if self.clock not in CLOCKS:
            raise Failure(USAGE, f"clock '{self.clock}': expected {' or '.join(CLOCKS)}")
        if self.bus not in ("auto", "slcan:pty") and not self.bus.startswith("socketcan:"):
            raise Failure(USAGE, f"bus '{self.bus}': expected auto, socketcan:IFACE or slcan:pty")


def written(value):
    """A setting's value as --set takes it: true, 0.001, word, [1, 2]."""
    return value if isinstance(value, str) else str(value) if isinstance(value, Path) else json.dumps(value)


class Configuration:
    """What the tests must know of the emulator's configuration."""

    def __init__(self, options):
        self.file = options.config or _default_file(options.program)
        try:
            self._keys = tomllib.loads(self.file.read_text(encoding="utf-8"))
        except OSError as error:
            raise Failure(USAGE, f"{self.file}: {error.strerror}") from None
        except ValueError as error:
            raise Failure(USAGE, f"{self.file}: {error}") from None
        self._settings = options.settings

    def get(self, key, default):
        """The value of section.name, after --set."""
        section, _, name = key.partition(".")
        return self._settings.get(key, self._keys.get(section, {}).get(name, default))

    def dbc(self):
        """A relative name counts from the configuration's folder, as the program has it; of several the first."""
        files = self.get("can.dbc", "servohil.dbc")
        return (self.file.parent / (files[0] if isinstance(files, list) else files)).resolve()

    def published(self):
        """Names of the messages that are sent, in the order of an answer in lockstep."""
        return [name for name, key in PUBLISHED.items() if float(self.get(f"publish.{key}", 1)) > 0]

    def lets_time_pass(self):
        """Identifier of the frame that lets time pass in lockstep; None: the command does."""
        sync_id = int(self.get("lockstep.sync_id", -1))
        return sync_id if sync_id >= 0 else None


def _default_file(program):
    """The configuration that the program would take: ./config, else the one installed with it."""
    here = Path("config/servohil.toml").resolve()
    return here if here.is_file() else (program.parent.parent / "share/servohil/servohil.toml").resolve()

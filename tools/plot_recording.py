"""Draws a recording of servohil: what was commanded, what the piston did and what the frames said of it, pressures,
friction, and the faults as shaded bands. Finished, killed and growing recordings alike."""

import logging
from pathlib import Path

logging.getLogger("canmatrix").setLevel(logging.CRITICAL)  # "xlsx is not supported"

FILE, LOG = "servohil.h5", "bus.log"
BAND_COLOURS = ("#e4572e", "#3d7ab5", "#76b041", "#a06cd5", "#e3a008", "#17a2a2")
MOTIONS = ("free", "stuck", "sliding up", "sliding down", "at lower stop", "at upper stop")
STARTS, ENDS, CLEARED = 1, 2, 4  # of fault_events
# Quantity of the truth → the signal of servohil's own DBC that carries it.
SIGNALS = {"p1_psi": "P1_Applied", "x3_in": "X3", "v3_in_s": "V3", "p3_psi": "P3", "p4_psi": "P4", "p8_psi": "P8"}


class Recording:
    """One recording, read at once: columns over simulated time."""

    def __init__(self, path):
        import h5py
        path = Path(path)
        self.directory = path.parent if path.is_file() else path
        with h5py.File(self.directory / FILE, "r", swmr=True) as file:
            self.attributes = {name: value.decode() if isinstance(value, bytes) else value
                               for name, value in file.attrs.items()}
            self.tick_s = float(self.attributes["tick_s"])
            self.samples = _columns(file["samples"])
            self.events = _columns(file["fault_events"]) if "fault_events" in file else None
            self.published_ticks = {name: group["tick"][:] for name, group in file["published"].items()}
        self.t_s = self.samples["tick"] * self.tick_s
        self.begin_s = None  # of the log: when the first command came

    def begin_with_the_first_command(self):
        """Time counts from there on."""
        import numpy
        self.begin_s = next((f.timestamp for f in _frames(self.directory / LOG) if f.is_rx), None)
        first = int(numpy.argmax(self.samples["commanded"] != 0))
        begin = int(self.samples["tick"][first]) - 1 if len(self.samples["tick"]) else 0
        self.t_s = self.t_s - begin * self.tick_s
        if self.events is not None:
            self.events["tick"] = self.events["tick"].astype(float) - begin
        self.published_ticks = {name: ticks.astype(float) - begin for name, ticks in self.published_ticks.items()}

    def published(self, signals, as_on_the_bus=False):
        """{signal: (times, values)} as the frames carried them: bus.log, decoded with the recorded DBC. Times are those
        for which the values were true, or (after begin_with_the_first_command) those of the frames on the bus."""
        messages = self._messages(signals)
        points = {signal: ([], []) for signal in messages}
        if not points:
            return {}
        by_id = {(m.arbitration_id.id, bool(m.arbitration_id.extended)): m for m in messages.values()}
        count = dict.fromkeys(self.published_ticks, 0)
        for frame in _frames(self.directory / LOG):
            message = by_id.get((frame.arbitration_id, frame.is_extended_id))
            if message is None or count[message.name] >= len(self.published_ticks[message.name]):
                continue
            tick = self.published_ticks[message.name][count[message.name]]
            count[message.name] += 1
            values = message.decode(bytes(frame.data))
            time_s = frame.timestamp - self.begin_s if as_on_the_bus else tick * self.tick_s
            for signal, its in messages.items():
                if its is message and signal in values:
                    points[signal][0].append(time_s)
                    points[signal][1].append(float(values[signal].phys_value))
        return points

    def _messages(self, signals):
        """{signal: message that was published with it}"""
        import canmatrix.formats
        texts = [text for name, text in self.attributes.items() if name == "dbc" or name.startswith("dbc_")]
        messages = [m for text in texts for m in canmatrix.formats.loads_flat(text, import_type="dbc", key="").frames
                    if len(self.published_ticks.get(m.name, ())) > 0]
        return {s: m for m in messages for s in signals if m.signal_by_name(s) is not None}

    def bands(self):
        """[(name, from, to)] of each time that a fault acted; s."""
        names = dict(line.split(" ", 1) for line in self.attributes.get("faults", "").splitlines() if " " in line)
        acting, bands = {}, []
        if self.events is None:  # of a program older than they are
            return bands
        for tick, kind, fault, target in zip(*(self.events[c] for c in ("tick", "kind", "fault", "target"))):
            t_s, which = float(tick) * self.tick_s, (int(fault), int(target))
            if kind in (ENDS, CLEARED) and which in acting:
                bands.append((names.get(str(fault), f"fault {fault}"), acting.pop(which), t_s))
            if kind == STARTS:
                acting.setdefault(which, t_s)
        end_s = float(self.t_s[-1]) if len(self.t_s) else 0.0
        bands += [(names.get(str(fault), f"fault {fault}"), begin, end_s) for (fault, _), begin in acting.items()]
        return sorted(bands, key=lambda band: band[1])


def is_recording(path):
    return Path(path).is_dir() or str(path).endswith(".h5")


def draw(recording, output, window=None, title="", panels=("p1_psi", "x3_in", "pressures", "friction"), size=None,
         dots=True, as_on_the_bus=False):
    """A picture of a recording; `window` in s. @return the figure's path"""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    window = window or (0.0, float(recording.t_s[-1]) if len(recording.t_s) else 1.0)
    heights = [0.35 if name == "friction" else 1.3 if name == "x3_in" else 1.0 for name in panels]
    figure, axes = plt.subplots(len(panels), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights},
                                figsize=size or (10, 1.2 + 1.9 * sum(heights)))
    published = recording.published({SIGNALS[p] for p in panels if p in SIGNALS}, as_on_the_bus) if dots else {}
    for name, (panel,) in zip(panels, axes):
        _panel(panel, name, recording, published, window)
        panel.set_xlim(*window)
        panel.grid(True, alpha=0.25)
    _shade([panel for (panel,) in axes], recording.bands(), window)
    axes[-1][0].set_xlabel("simulated time [s]")
    if title:
        figure.suptitle(title, fontsize=11)
    figure.align_ylabels()
    figure.tight_layout()
    Path(output).parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=90)
    plt.close(figure)


def _panel(panel, name, recording, published, window):
    if name == "pressures":
        for column, colour in zip(("p2_psi", "p3_psi", "p4_psi", "p8_psi"), ("#888888", "#1f5fa8", "#b8860b", "#2e8b57")):
            if column == "p8_psi" and (recording.samples[column] == recording.samples["p3_psi"]).all():
                continue  # no stabilizer
            _line(panel, recording, column, window, colour, column[:2].upper())
        panel.set_ylabel("pressure [psi]")
        _legend(panel, 4)
    elif name == "friction":
        _strip(panel, recording, window)
    else:
        unit = name.split("_", 1)[1].replace("_s", "/s")
        _line(panel, recording, name, window, "#333333", "true")
        times, values = published.get(SIGNALS.get(name), ((), ()))
        if times:
            panel.plot(times, values, ".", markersize=3, color="#c0392b", label="in the frames")
            _legend(panel, 2)
        panel.set_ylabel(f"{name.split('_', 1)[0]} [{unit}]")
        panel.ticklabel_format(useOffset=False)
        low, high = panel.get_ylim()
        if high - low < 0.004:  # at rest: not the last digits
            panel.set_ylim(0.5 * (low + high) - 0.002, 0.5 * (low + high) + 0.002)


def _legend(panel, columns):
    """Above the panel, at the right: it hides no curve."""
    panel.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), borderaxespad=0.0, frameon=False, fontsize=7,
                 ncol=columns, handlelength=1.2, columnspacing=1.0)


def _line(panel, recording, column, window, colour, label):
    """At most some thousand points: of each piece its least and its most, so that no swing is lost."""
    import numpy
    inside = (recording.t_s >= window[0]) & (recording.t_s <= window[1])
    t, y = recording.t_s[inside], recording.samples[column][inside]
    piece = max(1, len(t) // 1500)
    if piece > 1:
        rows = len(t) // piece
        y2 = y[:rows * piece].reshape(rows, piece)
        at = numpy.sort(numpy.stack([y2.argmin(axis=1), y2.argmax(axis=1)], axis=1), axis=1)
        at = (at + numpy.arange(rows)[:, None] * piece).ravel()
        t, y = t[at], y[at]
    panel.plot(t, y, color=colour, linewidth=0.9, label=label)


def _strip(panel, recording, window):
    """The piston's motion as a coloured strip."""
    import numpy
    motion = numpy.asarray(recording.samples["motion"])
    edges = numpy.flatnonzero(numpy.diff(motion)) + 1
    colours = ("#d9d9d9", "#c0392b", "#9bc1e0", "#f0d9a8", "#6b4e9e", "#6b4e9e")
    shown = []
    begins, ends = [0, *edges], [*edges, len(motion) - 1]
    if len(begins) > 2000:  # a rattle: not each stroke of it
        keep = numpy.linspace(0, len(begins) - 1, 2000).astype(int)
        begins = [begins[i] for i in keep]
        ends = [*begins[1:], len(motion) - 1]
    for begin, end in zip(begins, ends):
        state = int(motion[begin])
        panel.axvspan(recording.t_s[begin], recording.t_s[end], color=colours[state], linewidth=0,
                      label=None if state in shown else MOTIONS[state])
        shown.append(state)
    panel.set_yticks([])
    panel.set_ylabel("piston")
    _legend(panel, len(MOTIONS))
    panel.set_xlim(*window)


def _shade(panels, bands, window):
    """Faults as bands over all panels, their names above the first."""
    names = list(dict.fromkeys(name for name, *_ in bands))
    for name, begin, end in bands:
        colour = BAND_COLOURS[names.index(name) % len(BAND_COLOURS)]
        for panel in panels:
            panel.axvspan(begin, end, color=colour, alpha=0.13, linewidth=0, zorder=0)
        row = names.index(name)
        left = max(begin, window[0]) + 0.004 * (window[1] - window[0])
        if window[0] <= end and begin <= window[1]:
            panels[0].annotate(name, (left, 1.03 + 0.12 * (row % 4)), xycoords=("data", "axes fraction"), fontsize=8,
                               color=colour, fontweight="bold", va="bottom", annotation_clip=False)


def _columns(group):
    """Of equal length: of a killed run the last rows may not be in every column."""
    columns = {name: dataset[:] for name, dataset in group.items()}
    rows = min(len(values) for values in columns.values())
    return {name: values[:rows] for name, values in columns.items()}


def _frames(log):
    import can
    if log.exists():
        with can.CanutilsLogReader(str(log)) as frames:
            yield from frames

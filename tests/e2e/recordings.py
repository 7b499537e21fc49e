"""Reads what `--record` has written, with h5py and python-can: never with the program itself."""

import can
import h5py

FILE, LOG = "servohil.h5", "bus.log"


class Recording:
    """A recording, finished or not. All of it is read at once."""

    def __init__(self, directory):
        with h5py.File(directory / FILE, "r", swmr=True) as file:
            self.attributes = {name: value.decode() if isinstance(value, bytes) else value
                               for name, value in file.attrs.items()}
            self.samples = columns_of(file["samples"])
            self.influences = columns_of(file["influences"])
            self.gaps = columns_of(file["gaps"])
            self.published = {name: columns_of(group) for name, group in file["published"].items()}
            self.units = {}
            file.visititems(self._note_unit)

    def _note_unit(self, name, item):
        if isinstance(item, h5py.Dataset):
            self.units[name] = item.attrs["unit"].decode()
            assert "description" in item.attrs, name

    @property
    def ticks(self):
        return self.samples["tick"]


def columns_of(group):
    """Of equal length: of a killed run the last rows may not be in every column."""
    columns = {name: dataset[:] for name, dataset in group.items()}
    rows = min(len(values) for values in columns.values())
    return {name: values[:rows] for name, values in columns.items()}


def log_frames(directory):
    """The frames of bus.log as python-can reads them, comparable: (identifier, extended, data)."""
    with can.CanutilsLogReader(str(directory / LOG)) as log:
        return [as_tuple(frame) for frame in log]


def as_tuple(raw):
    return raw.arbitration_id, raw.is_extended_id, bytes(raw.data)


def is_subsequence(some, all_of_them):
    """Whether `some` are among `all_of_them`, in this order."""
    rest = iter(all_of_them)
    return all(item in rest for item in some)


def same_bits(one, other):
    return one.dtype == other.dtype and one.tobytes() == other.tobytes()

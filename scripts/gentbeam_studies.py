"""Reads the results of studies: parameters and summaries of all members, and the histories of single ones.

with open_study("fit.h5") as study:
    study.names, study.values               # parameters, (members, parameters)
    peak = study.summary("tip_max")         # .values with nan where a member has none, .unit, .name, ...
    study.summary("modal_frequency:2")      # of the second mode
    for number, group in study.members():   # complete ones, as Group of gentbeam_results
        group.history("tip")
"""

from dataclasses import dataclass

import h5py
import numpy as np

from gentbeam_results import Group, ResultsError, open_results, text, unit_of

COMPLETE = 1


@dataclass
class Summary:
    """One number a member."""

    name: str
    values: np.ndarray
    unit: str
    description: str


class Study:
    def __init__(self, results):
        self.results = results
        self.path = results.path
        if "sweep" not in results._file:
            raise ResultsError(f"{self.path}: not the results of a SWEEP (no /sweep)")
        self._sweep = results._file["sweep"]
        for name in ("number", "parameters", "status", "summary"):
            if name not in self._sweep:
                raise ResultsError(f"{self.path}: has no /sweep/{name}")
        self.names = [text(name) for name in self._sweep["parameters"].attrs["names"]]
        self.numbers = self._sweep["number"][:]
        self.values = self._sweep["parameters"][:]
        self.complete = self._sweep["status"][:] == COMPLETE
        if not self.complete.any():
            raise ResultsError(f"{self.path}: no member is complete")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.results.__exit__()

    def column(self, name):
        """Index of a parameter that varies."""
        for i, known in enumerate(self.names):
            if known.lower() == name.lower():
                return i
        raise ResultsError(f"{self.path}: no parameter '{name}' varies (there are: {', '.join(self.names)})")

    @property
    def summaries(self):
        """Summaries of one number a member, those of probes before frequencies, which end with their mode."""
        items = self._sweep["summary"].items()
        return [name for name, item in items if item.ndim == 1] + [
            f"{name}:{mode}" for name, modes in self._frequencies.items() for mode in range(1, modes + 1)
        ]

    @property
    def _frequencies(self):
        """Of every MODAL its summary's name and how many modes it has."""
        return {name: item.shape[1] for name, item in self._sweep["summary"].items() if item.ndim == 2}

    def summary(self, name):
        """The summary of that name; of frequencies without a mode the first one."""
        known = {one.lower(): one for one in self.summaries}
        found = known.get(name.lower()) or known.get(f"{name.lower()}:1")
        if found is None:
            raise ResultsError(f"{self.path}: no summary '{name}' (there are: {self._choices() or 'none'})")
        stored, _, mode = found.partition(":")
        data = self._sweep["summary"][stored]
        values = np.where(self.complete, data[:, int(mode) - 1] if mode else data[:], np.nan)
        return Summary(found, values, unit_of(data), text(data.attrs.get("description", "")))

    def _choices(self):
        """All summaries in a line, the modes of a command from the first to the last."""
        names = [name for name in self.summaries if ":" not in name]
        for name, modes in self._frequencies.items():
            names.append(f"{name}:1 to :{modes}" if modes > 1 else name)
        return ", ".join(names)

    def members(self, group=None):
        """Number and solution of every complete member, in their order."""
        if "members" not in self._sweep:
            raise ResultsError(f"{self.path}: keeps no histories of its members (OUTPUT fields=none)")
        groups = self._sweep["members"]
        width = max(6, len(str(int(self._sweep.attrs["members"]))))
        for number in self.numbers[self.complete]:
            member = groups[f"{number:0{width}d}"]
            yield int(number), self._solution(member, group)

    def _solution(self, member, wanted):
        found = sorted(
            (
                Group(self.results, name, item)
                for name, item in member.items()
                if isinstance(item, h5py.Group) and "kind" in item.attrs
            ),
            key=lambda one: one.order,
        )
        for one in found:
            if one.name.lower() == (wanted or one.name).lower() and (wanted or one.probes):
                return one
        available = ", ".join(one.name for one in found) or "none"
        raise ResultsError(f"{self.path}: no solution '{wanted or 'with probes'}' (there are: {available})")


def open_study(path):
    """The study at `path`, to be used in a `with` statement."""
    results = open_results(path)
    try:
        return Study(results)
    except ResultsError:
        results.__exit__()
        raise

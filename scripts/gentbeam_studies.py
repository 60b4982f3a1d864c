"""Reads the results of studies: parameters and summaries of all members, and the histories of single ones.

with open_study("fit.h5") as study:
    study.names, study.values               # parameters, (members, parameters)
    peak = study.summary("tip_max")         # .values with nan where a member has none, .unit, .description
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
        """Summaries of one number a member."""
        return [name for name, item in self._sweep["summary"].items() if item.ndim == 1]

    def summary(self, name):
        known = {one.lower(): one for one in self.summaries}
        if name.lower() not in known:
            raise ResultsError(
                f"{self.path}: no summary '{name}' (there are: {', '.join(self.summaries) or 'none'})"
            )
        data = self._sweep["summary"][known[name.lower()]]
        values = np.where(self.complete, data[:], np.nan)
        return Summary(values, unit_of(data), text(data.attrs.get("description", "")))

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

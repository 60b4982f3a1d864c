"""Runs gentbeam on decks made by a script, and hands back what it computed as arrays.

    beam = solve(deck, jm=2, dt=1e-4)          # parameters as `--set` takes them
    time, tip = beam["transient"].probe("tip")
    beam["modal"].frequency

The program is the one the environment variable GENTBEAM names, else build/release/gentbeam.
"""

import os
import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
FIELDS = ("u1", "u3", "y1", "y3", "xi")
COMPLETE = 0
SOLUTION_FAILED = 2


class RunError(Exception):
    """gentbeam did not do what was asked; the text is what it said."""


@dataclass
class Solution:
    """One solution command: empty arrays where the command has no such result."""

    kind: str
    time: np.ndarray
    u: np.ndarray  # (rows, nodes, fields); v likewise
    v: np.ndarray
    probes: dict
    energy: dict
    iterations: np.ndarray
    frequency: np.ndarray
    modes: np.ndarray

    def probe(self, name):
        return self.probes["time"], self.probes[name]

    def at(self, node, name):
        """The history of one field at one node."""
        return self.u[:, node, FIELDS.index(name)]


@dataclass
class Beam:
    x: np.ndarray
    elements: list
    complete: bool
    message: str
    solutions: dict = field(default_factory=dict)

    def __getitem__(self, name):
        return self.solutions[name]


def program():
    return os.environ.get("GENTBEAM", str(ROOT / "build" / "release" / "gentbeam"))


def solve(deck, may_fail=False, **parameters):
    """The results of a deck. A solution that fails is an error unless the caller expects it."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program(), "-q", "-o", "beam"]
        for name, value in parameters.items():
            command += ["--set", f"{name}={value if isinstance(value, str) else repr(float(value))}"]
        done = subprocess.run(command, input=deck, cwd=folder, text=True, capture_output=True, check=False)
        if done.returncode not in ((COMPLETE, SOLUTION_FAILED) if may_fail else (COMPLETE,)):
            raise RunError(f"{' '.join(command)}: exit status {done.returncode}\n{done.stderr}\n{deck}")
        return read(Path(folder) / "beam.h5", done.returncode == COMPLETE, done.stderr)


def read(path, complete, message):
    with h5py.File(path, "r") as file:
        elements = [row[row >= 0] for row in file["mesh/elements"][()]]
        beam = Beam(file["mesh/x"][()], elements, complete, message)
        for name, group in file.items():
            if isinstance(group, h5py.Group) and "kind" in group.attrs:
                beam.solutions[name] = read_solution(group)
    return beam


def read_solution(group):
    def array(name):
        return group[name][()] if name in group else np.empty(0)

    def arrays(name):
        return {key: item[()] for key, item in group[name].items()} if name in group else {}

    kind = group.attrs["kind"]
    return Solution(
        kind if isinstance(kind, str) else kind.decode(),
        array("time"),
        array("u"),
        array("v"),
        arrays("probes"),
        arrays("energy"),
        array("solver/iterations"),
        array("frequency"),
        array("modes"),
    )

"""The runs of a work-precision chart: a deck's variants, and how far a history is from another.

    scene = Scene.read("input/cantilever.inp", probe=None, parameters=())
    scene.deck(Setting("newmark", "gauss 3", nodes=3, elements=10, steps=100))
    error = distance(history, reference)
"""

import math
import re
from dataclasses import dataclass

import numpy as np

from gentbeam_results import ResultsError

VALUE = r"(?:\([^)]*\)|\[[^\]]*\]|\"[^\"]*\"|[^\s,])+"


@dataclass(frozen=True)
class Setting:
    """What one run is computed with; `elements` counts those of the whole beam."""

    scheme: str
    rule: str  # as "gauss 3" or "linear"
    nodes: int
    elements: int
    steps: int = 0  # 0: the program chooses them by
    accuracy: float = 0.0

    @property
    def words(self):
        steps = f"{self.steps} steps" if self.steps else f"accuracy {self.accuracy:g}"
        return f"{self.scheme}, {self.elements} elements of {self.nodes} nodes, {self.rule}, {steps}"


@dataclass(frozen=True)
class History:
    time: np.ndarray
    values: np.ndarray

    def until(self, end):
        keep = self.time <= end * (1.0 + 1e-9)
        return History(self.time[keep], self.values[keep])

    def at(self, time):
        """Values between the rows, by the cubic through the four nearest ones."""
        if len(self.time) < 4:
            return np.interp(time, self.time, self.values)
        first = np.clip(np.searchsorted(self.time, time) - 2, 0, len(self.time) - 4)
        nodes = [self.time[first + k] for k in range(4)]
        values = np.zeros_like(time)
        for k in range(4):
            others = [j for j in range(4) if j != k]
            weight = np.prod([(time - nodes[j]) / (nodes[k] - nodes[j]) for j in others], axis=0)
            values += weight * self.values[first + k]
        return values


def distance(history, reference):
    """Relative difference in the L2 norm over time, taken at the history's own instants.

    The reference has to be the one with the closer rows: only it is interpolated.
    """
    end = min(history.time[-1], reference.time[-1])
    history = history.until(end)
    exact = reference.at(history.time)
    weights = np.gradient(history.time)
    off, size = (weights * (history.values - exact) ** 2).sum(), (weights * exact**2).sum()
    return math.sqrt(off / size)


def extrapolated(coarse, fine):
    """Richardson's limit of two runs of second order, the second with half the steps' length."""
    return History(coarse.time, (4.0 * fine.values[::2] - coarse.values) / 3.0)


class Scene:
    """A deck with one TRANSIENT, whose mesh, section rule and steps can be replaced."""

    def __init__(self, path, text, probe, parameters):
        self.path = path
        self.name = path.stem
        self.parameters = tuple(parameters)
        self._lines = logical_lines(text)
        self._counts = [self._count(line) for line in self._commands("LINE")]
        if not self._counts or not self._commands("TRANSIENT"):
            raise ResultsError(f"{path}: a chart needs a deck with LINE and TRANSIENT")
        self.elements = sum(self._counts)
        self.nodes = int(key_of(self._commands("LINE")[0], "nodes", "3"))
        self.probe = probe or self._first_probe()
        self.title = self._lines[0].partition(" ")[2].strip()

    @classmethod
    def read(cls, path, probe=None, parameters=()):
        try:
            return cls(path, path.read_text(encoding="utf-8-sig"), probe, parameters)
        except OSError as error:
            raise ResultsError(f"{path}: {error.strerror}") from error

    def _commands(self, keyword):
        return [line for line in self._lines if is_command(line, keyword)]

    def _count(self, line):
        words = key_of(line, "elements", "")
        if not words.isdigit():
            raise ResultsError(f"{self.path}: elements= of LINE must be a plain number here, not '{words}'")
        return int(words)

    def _first_probe(self):
        probes = self._commands("PROBE")
        if not probes:
            raise ResultsError(f"{self.path}: a chart needs a PROBE")
        return probes[0].split()[1]

    def rule(self):
        """The section rule of the deck's first SECTION."""
        section = self._commands("SECTION")[0]
        rule = key_of(section, "rule", "gauss").lower()
        return rule if rule == "linear" else f"gauss {key_of(section, 'points', '3')}"

    def deck(self, setting, first_step_only=False):
        """The deck with a setting; nothing but probes and energies goes to the results."""
        return "".join(self._changed(line, setting, first_step_only) + "\n" for line in self._lines)

    def _changed(self, line, setting, first_step_only):
        if is_command(line, "LINE"):
            count = max(1, round(self._count(line) * setting.elements / self.elements))
            return with_keys(line, elements=count, nodes=setting.nodes)
        if is_command(line, "SECTION"):
            rule, _, points = setting.rule.partition(" ")
            return with_keys(line, rule=rule, points=points or None)
        if is_command(line, "OUTPUT"):
            return "OUTPUT fields=none"
        if is_command(line, "TRANSIENT"):
            end = key_of(line, "end", "1")
            step = f"step=({end})/{setting.steps}" if setting.steps else f"accuracy={setting.accuracy:g}"
            if first_step_only:
                end = f"({end})/{setting.steps or 100}"
                step = f"step={end}"
            return f"TRANSIENT {setting.scheme} {step} end={end}"
        return line


def logical_lines(text):
    """Lines without comments, continuations joined, up to STOP."""
    lines, begun = [], ""
    for line in text.splitlines():
        line = begun + re.sub(r"[!#].*", "", line).strip()
        if line.endswith("&"):
            begun = line[:-1] + " "
            continue
        begun = ""
        if line:
            lines.append(line)
        if is_command(line, "STOP"):
            break
    return lines


def is_command(line, keyword):
    word = line.split()[0].upper() if line else ""
    return word == keyword or (len(word) >= 4 and keyword.startswith(word))


def key_of(line, key, default):
    found = re.search(rf"(?<!\S){key}\s*=\s*({VALUE})", line, re.IGNORECASE)
    return found.group(1) if found else default


def with_keys(line, **keys):
    """The command with its keys replaced or added; None takes one away."""
    for key, value in keys.items():
        line = re.sub(rf"(?<!\S){key}\s*=\s*{VALUE}", "", line, flags=re.IGNORECASE)
        if value is not None:
            line += f" {key}={value}"
    return line

"""The paper's three examples: their decks, what is followed on them, and the same strips as 2D continua."""

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gentbeam_results import ResultsError
from paper_continuum import Strip

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "scripts" / "data"

# The paper's "1e20" is a material without limit of its chains.
UNLIMITED = 1e20


@dataclass(frozen=True)
class Quantity:
    """A displacement that is followed: a component at a place of the mid-line."""

    field: str
    x: float
    figure: int = 0  # of the paper; 0: followed for the comparison only

    @property
    def name(self):
        return f"{self.field}_{self.x:g}"


@dataclass(frozen=True)
class Example:
    number: int
    title: str
    deck: str  # file in input/
    e: float
    nu: float
    quantities: tuple
    family: tuple  # values of jm, from the softest to the stiffest
    strip: dict  # for paper_continuum.Strip, without its jm
    length: float  # what displacements are compared with on the axes; 1: not divided
    elements: int  # converged mesh and step, beside those of the deck
    step: float
    end: float  # of the converged run: that of the continuum's histories
    interval: float  # between the rows of the continuum's histories

    @property
    def mu(self):
        return self.e / (2.0 * (1.0 + self.nu))

    @property
    def c(self):
        return self.e * self.nu / (1.0 - self.nu**2)

    def modulus(self, jm):
        """Small-strain fibre modulus with the thickness free."""
        lame = self.c + 2.0 * self.mu / jm
        return 4.0 * self.mu * (lame + self.mu) / (lame + 2.0 * self.mu)

    def continuum_strip(self, jm):
        return Strip(mu=self.mu, c=self.c, jm=jm, **self.strip)

    def continuum_file(self, jm):
        return DATA / f"continuum_case{self.number}_Jm{jm_text(jm)}.csv"


EXAMPLES = (
    Example(
        number=1,
        title="Cantilever under a sudden uniform load",
        deck="cantilever.inp",
        e=12000.0,
        nu=0.2,
        quantities=(Quantity("u3", 10.0, 3), Quantity("u1", 10.0)),
        family=(UNLIMITED, 10.0, 5.0, 2.0, 1.0, 0.5),
        strip={"length": 10.0, "rho": 1e-6, "clamped": (0.0,), "spread": ((0.0, 10.0, 2.85),)},
        length=10.0,
        elements=40,
        step=1.35e-5,
        end=1.35e-2,
        interval=5.4e-5,
    ),
    Example(
        number=2,
        title="Beam on two supports and a clamp",
        deck="two_span.inp",
        e=14000.0,
        nu=0.3,
        quantities=(
            Quantity("u3", 3.0, 6),
            Quantity("u3", 9.0, 7),
            Quantity("u1", 3.0, 8),
            Quantity("u3", 2.0),
            Quantity("u3", 4.0),
        ),
        family=(UNLIMITED, 3.0, 2.0, 1.0, 0.5),
        strip={
            "length": 12.0,
            "rho": 1e-4,
            "clamped": (12.0,),
            "held": ((0.0, 0), (0.0, 1), (6.0, 0), (6.0, 1)),
            "spread": ((0.0, 4.0, -20.0),),
            "points": ((9.0, -6.67),),
        },
        length=1.0,
        elements=48,
        step=1e-5,
        end=0.03,
        interval=6e-5,
    ),
    Example(
        number=3,
        title="Beam with a sliding end and three loads",
        deck="sliding.inp",
        e=14000.0,
        nu=0.3,
        quantities=(
            Quantity("u3", 2.0, 10),
            Quantity("u3", 6.0, 11),
            Quantity("u3", 12.0, 12),
            Quantity("u1", 8.0, 13),
        ),
        family=(UNLIMITED, 5.0, 2.0, 0.5),
        strip={
            "length": 12.0,
            "rho": 4e-4,
            "clamped": (0.0,),
            "slides": (12.0,),
            "held": ((4.0, 0), (4.0, 1), (8.0, 1)),
            "spread": ((0.0, 4.0, -50.0),),
            "points": ((6.0, -50.0), (12.0, -16.67)),
        },
        length=1.0,
        elements=48,
        step=2e-5,
        end=0.06,
        interval=1.2e-4,
    ),
)


def jm_text(jm):
    """As in the names of files: 0.5, 10, 1e20."""
    return f"{jm:g}".replace("e+", "e")


def deck_text(example, rule=None, load=1.0, static=False, **numbers):
    """The example's deck in input/ with a probe for every quantity that is followed.

    `numbers` replace those of the deck: elements, nodes, step, end, every. `load` multiplies all loads, and
    `static` asks for the equilibrium under them in place of the motion.
    """
    path = ROOT / "input" / example.deck
    try:
        deck = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror}") from error
    for key, value in numbers.items():
        deck = replace(deck, rf"\b{key}=\S+", f"{key}={value:.12g}", path)
    if rule is not None:
        deck = replace(deck, r"\brule=\S+(\s+points=\S+)?", f"rule={rule}", path)
    if load != 1.0:
        deck = replace(deck, r"\b([qf]3)=(\S+)", rf"\1=(\2)*{load!r}", path)
    if static:
        deck = replace(deck, r"^TRANSIENT\b.*$", "STATIC       steps=10", path)
    probes = "".join(f"PROBE        {q.name}  {q.field}  x={q.x:g}\n" for q in example.quantities)
    return replace(deck, r"^(?=OUTPUT\b)", probes, path)


def deck_number(example, key):
    """As a text, as the deck has it."""
    return re.search(rf"\b{key}=(\S+)", deck_text(example)).group(1)


def replace(deck, pattern, text, path):
    changed, count = re.subn(pattern, text, deck, flags=re.MULTILINE)
    if count == 0:
        raise ResultsError(f"{path}: nothing in it matches {pattern}")
    return changed


@dataclass
class Curve:
    """A history on the mid-line."""

    time: np.ndarray
    values: np.ndarray

    def until(self, end):
        keep = self.time <= end * (1.0 + 1e-9)
        return Curve(self.time[keep], self.values[keep])

    def extreme(self, sign=0):
        """The largest value (by size, or on the side of `sign`) and its time, between the rows as well."""
        sizes = np.abs(self.values) if sign == 0 else sign * self.values
        row = int(sizes.argmax())
        if not 0 < row < len(sizes) - 1:
            return float(self.values[row]), float(self.time[row])
        # The parabola through three rows about the largest; they are evenly spaced but at a run's end.
        before, at, after = self.values[row - 1 : row + 2]
        curvature = before - 2.0 * at + after
        shift = 0.5 * (before - after) / curvature if curvature else 0.0
        value = at - 0.25 * (before - after) * shift
        return float(value), float(self.time[row] + shift * (self.time[row + 1] - self.time[row]))

    def distance(self, reference):
        """Relative L2 difference from the reference, at its rows."""
        values = np.interp(reference.time, self.time, self.values)
        return math.sqrt(((values - reference.values) ** 2).sum() / (reference.values**2).sum())


def read_continuum(example, jm):
    """The 2D continuum's history of every quantity, by its name."""
    path = example.continuum_file(jm)
    try:
        with open(path, newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(line for line in stream if not line.startswith("#")))
        numbers = np.array(rows[1:], dtype=float)
        return {name: Curve(numbers[:, 0], numbers[:, i]) for i, name in enumerate(rows[0]) if i}
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror}") from error
    except (ValueError, IndexError) as error:
        raise ResultsError(f"{path}: not a table of histories: {error}") from error


def write_continuum(example, jm, histories, comments):
    """The histories as a table: one row an interval, seven digits."""
    names = [q.name for q in example.quantities]
    with open(example.continuum_file(jm), "w", encoding="utf-8") as stream:
        stream.writelines(f"# {comment}\n" for comment in comments)
        stream.write(",".join(("t", *names)) + "\n")
        for row in zip(histories[names[0]].time, *(histories[name].values for name in names)):
            stream.write(",".join(f"{number:.7g}" for number in row) + "\n")

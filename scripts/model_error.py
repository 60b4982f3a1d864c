#!/usr/bin/env python3
"""Measures the beam against the two-dimensional continuum: what the beam's kinematics cost.

Runs the paper's three examples with the section rules gauss 2, gauss 3 and linear, and compares with the
histories, statics and frequencies in tests/verification/data. Writes docs/model-error.md and, in
docs/pictures, model_error.csv, model_error.png and model_error_histories.png.

    scripts/model_error.py [--output FOLDER]      the program is GENTBEAM, else build/release/gentbeam
"""

import csv
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from gentbeam_pictures import COLOURS, DASHES, MILLIMETRES, STYLE, UNLIMITED_JM, plt, save_picture
from gentbeam_results import Parser, run_script
from gentbeam_runs import ROOT, solve

DATA = ROOT / "tests" / "verification" / "data"
PAGE = 160.0 * MILLIMETRES
RULES = {"gauss 2": "rule=gauss points=2", "gauss 3": "rule=gauss points=3", "linear": "rule=linear"}


INTRODUCTION = """\
# What the beam's kinematics cost

The beam lets a section's fibres follow five fields: its line, a director that may stretch, and one
quadratic term through the thickness. A two-dimensional continuum of the same Gent material knows no such
limit. This page states the difference for the paper's three examples, L/h = 10 to 12, on fine meshes
(elements of four nodes, fully integrated). It is written by `scripts/model_error.py`; the continuum's
numbers stand in tests/verification/data.

`gauss` with three points or more is the rule to trust. `linear`, the paper's resultants, bends as well but
is up to 3 % off in the frequencies of the first six modes, a phase that adds up. `gauss` with two points is
no rule for beams on inner supports: it sees shear only as (u3 + h^2/12 xi)', so that u3 may jump next to a
point held, at no more cost than xi over one element. Its answers to examples 2 and 3 drift with the mesh,
slowly with full integration as here, and without bound with reduced integration, where xi has sawtooth
shapes free of energy.

## Motions

![Relative error of the motion, by example and Jm](pictures/model_error.png)

Relative difference of the history in the L2 norm over time, in percent, and of the largest deflection, for
the section rules. An error in the L2 norm is mostly one of phase, and grows with the time looked at: here
two and a half periods of example 1, about five of example 2, and four of example 3. The last columns are
what the beam's own mesh and step still change in the L2 norm when both are halved, in percent. The
continuum's own error is 0.001 % in example 1, 0.01 to 0.03 % in example 2, 0.1 % and more in example 3.
"""


@dataclass(frozen=True)
class Example:
    number: int
    length: float
    material: str
    scene: str  # supports and loads
    elements: int
    jms: tuple
    columns: tuple  # of the reference, the one that stands for the example first

    def deck(self, rule, solution, refine=1):
        """Cubic elements do not lock under full integration, which leaves no shape of xi without energy."""
        probes = [f"PROBE {name} {name.split('_')[0]} x={self.place(name)}" for name in self.columns]
        return "\n".join(
            [
                f"GENTBEAM example {self.number} of the paper",
                "PARAMETER jm=1e20",
                self.material,
                f"SECTION s rectangle b=1 h=1 {RULES[rule]}",
                f"LINE from=0 to={self.length} elements={refine * self.elements} nodes=4 integration=full",
                self.scene,
                *probes,
                "OUTPUT fields=none",
                "END",
                *solution,
                "STOP",
                "",
            ]
        )

    def place(self, column):
        return {"tip": self.length, "mid": 0.5 * self.length}.get(column.split("_")[1], column.split("_")[1])

    def reference(self, jm):
        with open(DATA / f"continuum_{self.number}_jm{jm}.csv", encoding="utf-8") as file:
            names = file.readline().strip().split(",")
            return dict(zip(names, np.loadtxt(file, delimiter=",").T))


EXAMPLES = (
    Example(
        1,
        10.0,
        "MATERIAL m gent mu=5000 c=2500 jm=jm rho=1e-6",
        "CLAMP x=0\nDISTRIBUTED from=0 to=10 q3=2.85",
        20,
        ("1e20", "10", "5", "1"),
        ("u3_tip", "u1_tip"),
    ),
    Example(
        2,
        12.0,
        "MATERIAL m gent mu=5384.6 c=4615.4 jm=jm rho=1e-4",
        "PIN x=0\nPIN x=6\nCLAMP x=12\nDISTRIBUTED from=0 to=4 q3=-20\nPOINT x=9 f3=-6.67",
        24,
        ("1e20", "3", "1"),
        ("u3_3", "u3_9"),
    ),
    Example(
        3,
        12.0,
        "MATERIAL m gent mu=5384.6 c=4615.4 jm=jm rho=4e-4",
        "CLAMP x=0\nPIN x=4\nROLLER x=8\nSLIDE x=12\nDISTRIBUTED from=0 to=4 q3=-50\n"
        "POINT x=6 f3=-50\nPOINT x=12 f3=-16.67",
        24,
        ("1e20", "5", "2"),
        ("u3_12", "u3_2"),
    ),
)


@lru_cache(maxsize=None)
def motion(example, jm, rule, refine=1):
    """Histories of the beam at the reference's instants; `refine` halves elements and steps so many times.

    Two steps of Bathe's scheme from one of those instants to the next: the coarsest of them is 1/100 of the
    first period, and `discretisation` says what that and the mesh leave.
    """
    time = example.reference(jm)["t"]
    steps = 2 * refine * (len(time) - 1)
    solution = [f"TRANSIENT bathe step={float(time[-1]) / steps!r} end={float(time[-1])!r}"]
    probes = solve(example.deck(rule, solution, refine), jm=jm)["transient"].probes
    return {name: probes[name][:: 2 * refine] for name in example.columns}


def relative(found, expected):
    """Relative error in the L2 norm over time."""
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


def largest(history):
    return float(history[np.argmax(np.abs(history))])


@dataclass(frozen=True)
class Row:
    """What one run is off from the continuum, at one place."""

    example: int
    jm: str
    column: str
    rule: str
    l2: float
    largest_continuum: float
    largest_beam: float
    discretisation: float  # L2 distance to the run on half the mesh size and step

    @property
    def largest_error(self):
        return self.largest_beam / self.largest_continuum - 1.0


def history_rows():
    for example in EXAMPLES:
        for jm in example.jms:
            reference = example.reference(jm)
            for rule in RULES:
                coarse, fine = motion(example, jm, rule), motion(example, jm, rule, 2)
                for column in example.columns:
                    yield Row(
                        example.number,
                        jm,
                        column,
                        rule,
                        relative(fine[column], reference[column]),
                        largest(reference[column]),
                        largest(fine[column]),
                        relative(coarse[column], fine[column]),
                    )


def table(name):
    with open(DATA / name, encoding="utf-8") as file:
        return list(csv.DictReader(file))


@lru_cache(maxsize=None)
def frequencies(number, jm, rule, count=6):
    """Angular frequencies of an example about its undeformed state."""
    modal = solve(EXAMPLES[number - 1].deck(rule, [f"MODAL count={count}"], 2), jm=jm)["modal"]
    return 2.0 * np.pi * modal.frequency


def frequency_rows():
    """Example, jm, the continuum's six frequencies, and the beam's relative errors by rule."""
    for row in table("continuum_frequencies.csv"):
        exact = np.array([float(row[f"w{i}"]) for i in range(1, 7)])
        number = int(row["example"])
        errors = {rule: frequencies(number, row["jm"], rule) / exact - 1.0 for rule in RULES}
        yield number, row["jm"], exact, errors


@lru_cache(maxsize=None)
def deflection(jm, load, rule):
    """Static tip displacements of example 1."""
    static = solve(EXAMPLES[0].deck(rule, [f"STATIC steps=10 load={load}"], 2), jm=jm)["static"]
    return {name: float(static.probes[name][-1]) for name in ("u3_tip", "u1_tip")}


def static_rows():
    """jm, load factor, the continuum's tip displacements, and the beam's relative errors by rule."""
    for row in table("continuum_statics.csv"):
        exact = {name: float(row[name]) for name in ("u3_tip", "u1_tip")}
        found = {rule: deflection(row["jm"], row["load"], rule) for rule in RULES}
        errors = {rule: {name: found[rule][name] / exact[name] - 1.0 for name in exact} for rule in RULES}
        yield row["jm"], row["load"], exact, errors


def jm_name(jm):
    return "∞" if float(jm) > UNLIMITED_JM else f"{float(jm):g}"


def jm_symbol(jm):
    return "$J_m = %s$" % jm_name(jm).replace("∞", r"\infty")


def percent(value):
    return f"{100.0 * value:+.2f}"


def write_tables(path, rows):
    lines = [
        INTRODUCTION,
        "| example | Jm | at | L2: gauss 2 | gauss 3 | linear "
        "| largest, continuum | gauss 2 | gauss 3 | linear | mesh: gauss 2 | gauss 3 | linear |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for key in dict.fromkeys((row.example, row.jm, row.column) for row in rows):
        own = {row.rule: row for row in rows if (row.example, row.jm, row.column) == key}
        cells = [str(key[0]), jm_name(key[1]), key[2].replace("_", " at ")]
        cells += [f"{100.0 * own[rule].l2:.2f}" for rule in RULES]
        cells += [f"{own['gauss 3'].largest_continuum:.4g}"]
        cells += [percent(own[rule].largest_error) for rule in RULES]
        cells += [f"{100.0 * own[rule].discretisation:.3f}" for rule in RULES]
        lines.append("| " + " | ".join(cells) + " |")
    lines += [
        "",
        "![Histories of the beam and of the continuum](pictures/model_error_histories.png)",
        "",
        "## Natural frequencies",
        "",
        "Angular frequencies about the undeformed state: the continuum's, and the beam's errors in percent.",
        "",
        "| example | Jm | rule | 1 | 2 | 3 | 4 | 5 | 6 |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for number, jm, exact, errors in frequency_rows():
        cells = [f"{value:.6g}" for value in exact]
        lines.append(f"| {number} | {jm_name(jm)} | continuum | " + " | ".join(cells) + " |")
        for rule in RULES:
            cells = map(percent, errors[rule])
            lines.append(f"| {number} | {jm_name(jm)} | {rule} | " + " | ".join(cells) + " |")
    lines += [
        "",
        "## Statics",
        "",
        "Example 1 at rest under its load times the factor: the continuum's tip displacements, and",
        "the beam's errors in percent.",
        "",
        "| Jm | load | u3 | gauss 2 | gauss 3 | linear | u1 | gauss 2 | gauss 3 | linear |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for jm, load, exact, errors in static_rows():
        cells = [jm_name(jm), load]
        for name in exact:
            cells += [f"{exact[name]:.5g}", *(percent(errors[rule][name]) for rule in RULES)]
        lines.append("| " + " | ".join(cells) + " |")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"wrote {path}")


def write_csv(path, rows):
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["example", "jm", "place", "rule", "l2", "largest_continuum", "largest_beam",
                         "largest_error", "discretisation"])
        for row in rows:
            numbers = (row.l2, row.largest_continuum, row.largest_beam, row.largest_error, row.discretisation)
            texts = [f"{value:.5g}" for value in numbers]
            writer.writerow([row.example, row.jm, row.column, row.rule, *texts])
    print(f"wrote {path}")


def draw_errors(path, rows):
    """One dot a run: a logarithmic scale has no place for bars."""
    rows = [row for row in rows if row.column in {example.columns[0] for example in EXAMPLES}]
    places = list(dict.fromkeys((row.example, row.jm) for row in rows))
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            1, 2, sharey=True, layout="constrained", figsize=(PAGE, 75.0 * MILLIMETRES)
        )
        quantities = (
            ("relative $L_2$ error of the motion (%)", lambda row: row.l2),
            ("error of the largest deflection (%)", lambda row: abs(row.largest_error)),
        )
        for axis, (label, quantity) in zip(axes, quantities):
            for rule, colour, marker in zip(RULES, COLOURS, "osD"):
                own = [row for row in rows if row.rule == rule]
                axis.semilogx(
                    [100.0 * quantity(row) for row in own],
                    [places.index((row.example, row.jm)) for row in own],
                    marker=marker,
                    markersize=4,
                    linestyle="none",
                    color=colour,
                    label=rule,
                )
            axis.set_xlabel(label)
            axis.grid(axis="y", color="0.9", linewidth=0.4)
            axis.xaxis.set_major_formatter("{x:g}")
        names = [f"example {number}, {jm_symbol(jm)}" for number, jm in places]
        axes[0].set_yticks(range(len(places)), names)
        axes[0].invert_yaxis()
        entries = axes[0].get_legend_handles_labels()
        figure.legend(*entries, loc="outside upper center", ncols=3, frameon=False)
        save_picture(figure, str(path))


def draw_histories(path):
    """Every example's first place, for the largest and the smallest Jm."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            len(EXAMPLES), 2, sharex="row", layout="constrained", figsize=(PAGE, 150.0 * MILLIMETRES)
        )
        for example, pair in zip(EXAMPLES, axes):
            column = example.columns[0]
            for jm, axis in zip((example.jms[0], example.jms[-1]), pair):
                reference = example.reference(jm)
                axis.plot(reference["t"], reference[column], color="0.7", linewidth=2.4, label="continuum")
                for rule, colour, dash in zip(("gauss 3", "linear"), COLOURS[1:], DASHES):
                    history = motion(example, jm, rule, 2)[column]
                    style = {"color": colour, "linestyle": dash, "linewidth": 0.8}
                    axis.plot(reference["t"], history, label=rule, **style)
                axis.set_title(f"example {example.number}, {jm_symbol(jm)}")
                axis.axhline(0.0, color="0.6", linewidth=0.4, zorder=0)
                axis.margins(x=0.0)
                axis.set_xlabel("Time")
            pair[0].set_ylabel(f"$u_3$ at $X_1 = {float(example.place(column)):g}$")
        entries = axes[0][0].get_legend_handles_labels()
        figure.legend(*entries, loc="outside upper center", ncols=3, frameon=False)
        save_picture(figure, str(path))


def main():
    parser = Parser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", metavar="FOLDER", default=str(ROOT / "docs"), help="default: docs")
    folder = Path(parser.parse_args().output)
    pictures = folder / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    rows = list(history_rows())
    write_tables(folder / "model-error.md", rows)
    write_csv(pictures / "model_error.csv", rows)
    draw_errors(pictures / "model_error.png", rows)
    draw_histories(pictures / "model_error_histories.png")


if __name__ == "__main__":
    run_script(main)

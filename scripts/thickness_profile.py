#!/usr/bin/env python3
"""Compares the beam's strains through the thickness with the two-dimensional continuum's.

Runs example 1 of the paper with jm = 2 to the first largest tip deflection and takes the strains at X1 = L/2.
The continuum stands beside it twice: the independent one, in scripts/data/, and that of
scripts/paper_continuum.py, stopped at the very instant of the beam. Prints the tables of
docs/theory.md and writes thickness_profile.png and thickness_profile.csv to docs/pictures.

    scripts/thickness_profile.py [--program FILE] [--output FOLDER]

The program is the one --program or the variable GENTBEAM names, else build/release/gentbeam.
"""

import csv
import os
from pathlib import Path

import numpy as np

from gentbeam_pictures import COLOURS, MILLIMETRES, STYLE, plt, save_picture
from gentbeam_results import Parser, run_script
from gentbeam_runs import ROOT, solve
from paper_continuum import Continuum
from paper_examples import EXAMPLES

REFERENCE = ROOT / "scripts" / "data" / "continuum_case1_Jm2_thickness_profile.csv"
PAGE = 160.0 * MILLIMETRES
LENGTH = 10.0
ELEMENTS = 41  # odd: X1 = L/2 is the middle of an element
STEP = 2.5e-6  # 1/2000 of the first period
ACROSS = 8  # elements through the continuum's thickness
DECK = """\
GENTBEAM example 1 of the paper, to the first largest deflection
PARAMETER elements=41 dt=2.5e-6
MATERIAL m gent mu=5000 c=2500 jm=2 rho=1e-6
SECTION s rectangle b=1 h=1 rule=gauss points=4
LINE from=0 to=10 elements=elements nodes=3
CLAMP x=0
DISTRIBUTED from=0 to=10 q3=2.85
PROBE tip u3 x=10
END
TRANSIENT bathe step=dt end=3.5e-3
STOP
"""
QUANTITIES = ("E11", "E33", "E13", "J")
LATER = 1.0e-4  # how far on the level of bending is looked at once more
GAUSS = 1.0 / np.sqrt(3.0)


def deformation_gradient(height, fields, slopes):
    """F11, F31, F13, F33 at X3 = `height` from u1 u3 y1 y3 xi at one X1 and their derivatives by X1."""
    _, _, y1, y3, xi = fields
    u1_slope, u3_slope, y1_slope, y3_slope, xi_slope = slopes
    zeta = height + xi * height**2
    stretch = 1.0 + 2.0 * xi * height
    f11 = 1.0 + u1_slope + zeta * y1_slope + height**2 * xi_slope * y1
    f31 = u3_slope + zeta * y3_slope + height**2 * xi_slope * (1.0 + y3)
    return f11, f31, stretch * y1, stretch * (1.0 + y3)


def strains(f11, f31, f13, f33):
    """Green-Lagrange strains, E = (F'F - 1)/2, and J."""
    return {
        "E11": 0.5 * (f11**2 + f31**2 - 1.0),
        "E33": 0.5 * (f13**2 + f33**2 - 1.0),
        "E13": 0.5 * (f11 * f13 + f31 * f33),
        "J": f11 * f33 - f13 * f31,
    }


def at_gauss_points(x, nodal):
    """Fields and slopes at both Gauss points of an element of three nodes.

    These are the points at which the program integrates, so that equilibrium holds for the strains there;
    they are also where the slopes of a quadratic element are one order better than elsewhere.
    """
    for r in (-GAUSS, GAUSS):
        shapes = np.array([0.5 * r * (r - 1.0), 1.0 - r**2, 0.5 * r * (r + 1.0)])
        derivatives = np.array([r - 0.5, -2.0 * r, r + 0.5]) / (0.5 * (x[-1] - x[0]))
        yield shapes @ nodal, derivatives @ nodal


def section_strains(height, x, nodal):
    """Strains through the thickness at the middle of an element: the mean of those at its Gauss points."""
    found = [strains(*deformation_gradient(height, *point)) for point in at_gauss_points(x, nodal)]
    return {name: sum(profile[name] for profile in found) / len(found) for name in found[0]}


def beam_profile(height, elements=ELEMENTS, step=STEP, later=0.0):
    """Time of the first largest tip deflection, or `later` by so much, and the strains at X1 = L/2 then."""
    beam = solve(DECK, elements=str(elements), dt=step)
    motion = beam["transient"]
    row = int(np.argmax(motion.probes["tip"])) + round(later / step)
    middle = next(nodes for nodes in beam.elements if np.isclose(beam.x[nodes].mean(), 0.5 * LENGTH))
    middle = middle[np.argsort(beam.x[middle])]
    return float(motion.time[row]), section_strains(height, beam.x[middle], motion.u[row, middle])


def read_reference():
    with open(REFERENCE, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def continuum_profile(time, across=ACROSS):
    """Heights and strains of the project's own continuum at X1 = L/2, at the middles of its elements."""
    body = Continuum(EXAMPLES[0].continuum_strip(2.0), across)
    steps = int(np.ceil(time / body.stable_step()))
    step = time / steps
    u, v = np.zeros_like(body.force), np.zeros_like(body.force)
    a = body.acceleration(u)
    for _ in range(steps):
        v += 0.5 * step * a
        u += step * v
        a = body.acceleration(u)
        v += 0.5 * step * a
    # Nodes are half an element apart; those of odd number are the middles of elements.
    section = round(LENGTH * across)
    along = ((u[section + 1] - u[section - 1]) / body.size)[1::2]
    through = (u[section, 2::2] - u[section, :-2:2]) / body.size
    height = (np.arange(across) + 0.5) * body.size - 0.5
    return height, strains(1.0 + along[:, 0], along[:, 1], through[:, 0], 1.0 + through[:, 1])


def parabola(height, values):
    """Mean, slope at mid-height and coefficient of X3^2 of the parabola that comes closest."""
    square, slope, constant = np.polyfit(height, values, 2, w=np.sqrt(np.gradient(height)))
    return constant + square / 12.0, slope, square


def parabolas(profiles):
    """A row for every strain and every profile, as Markdown."""
    yield "| | | mean | slope | of X3^2 |"
    yield "|---|---|---|---|---|"
    for name in QUANTITIES:
        for source, (height, values) in profiles.items():
            cells = [f"{value:+.5f}" for value in parabola(height, values[name] - (name == "J"))]
            shown = "J - 1" if name == "J" else name
            yield f"| {shown} | {source} | " + " | ".join(cells) + " |"


def differences(independent, beam, own, beam_there, finer):
    """The beam's largest differences as Markdown; the last column is half the element and half the step."""
    yield "| | largest strain | beam - independent | at X3 | beam - same instant | at X3 | mesh and step |"
    yield "|---|---|---|---|---|---|---|"
    for name in QUANTITIES:
        cells = [f"{np.abs(independent[name] - (name == 'J')).max():.5f}"]
        for height, off in (
            (independent["X3"], beam[name] - independent[name]),
            (own[0], beam_there[name] - own[1][name]),
        ):
            worst = int(np.argmax(np.abs(off)))
            cells += [f"{off[worst]:+.5f}", f"{height[worst]:+.2f}"]
        cells.append(f"{np.abs(finer[name] - beam[name]).max():.5f}")
        yield f"| {'J - 1' if name == 'J' else name} | " + " | ".join(cells) + " |"


def write_csv(path, profiles):
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["source", "X3", *QUANTITIES])
        for source, (height, values) in profiles.items():
            for row in zip(height, *(values[name] for name in QUANTITIES)):
                writer.writerow([source, *(f"{value:.6g}" for value in row)])
    print(f"wrote {path}")


def bend(height, values):
    """What a profile differs by from its closest parabola's tangent at mid-height."""
    mean, slope, square = parabola(height, values)
    return values - (mean - square / 12.0) - slope * height


def draw(path, profiles):
    """Strains to the right, the thickness upwards, as the section stands."""
    looks = {
        "independent": {"color": "0.7", "linewidth": 2.4, "label": "continuum, independent"},
        "same instant": {
            "color": COLOURS[2],
            "linestyle": "none",
            "marker": "o",
            "markersize": 3.2,
            "markerfacecolor": "white",
            "markeredgewidth": 0.8,
            "label": "continuum, at the beam's instant",
        },
        "beam": {"color": COLOURS[1], "label": "beam"},
    }
    panels = {
        "$E_{11}$ (%)": lambda height, values: values["E11"],
        "$E_{33}$ (%)": lambda height, values: values["E33"],
        "$E_{33}$, its bend (%)": lambda height, values: bend(height, values["E33"]),
        "$E_{13}$ (%)": lambda height, values: values["E13"],
        "$J - 1$ (%)": lambda height, values: values["J"] - 1.0,
    }
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            1, len(panels), sharey=True, layout="constrained", figsize=(PAGE, 70.0 * MILLIMETRES)
        )
        for axis, (label, quantity) in zip(axes, panels.items()):
            for source, (height, values) in profiles.items():
                axis.plot(100.0 * quantity(height, values), height, **looks[source])
            axis.axhline(0.0, color="0.6", linewidth=0.4, zorder=0)
            axis.axvline(0.0, color="0.6", linewidth=0.4, zorder=0)
            axis.set_xlabel(label)
            axis.locator_params(axis="x", nbins=4)
            axis.xaxis.set_major_formatter("{x:g}")
        axes[0].set_ylim(-0.5, 0.5)
        axes[0].set_ylabel("$X_3/h$")
        entries = axes[0].get_legend_handles_labels()
        figure.legend(*entries, loc="outside upper center", ncols=3, frameon=False)
        save_picture(figure, str(path))


def main():
    parser = Parser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", metavar="FILE", help="the gentbeam to run")
    parser.add_argument("-o", "--output", metavar="FOLDER", default=str(ROOT / "docs"), help="default: docs")
    args = parser.parse_args()
    if args.program:
        os.environ["GENTBEAM"] = str(Path(args.program).resolve())
    pictures = Path(args.output) / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    continuum = read_reference()
    time, beam = beam_profile(continuum["X3"])
    _, finer = beam_profile(continuum["X3"], 2 * ELEMENTS + 1, 0.5 * STEP)
    own = continuum_profile(time)
    _, beam_there = beam_profile(own[0])
    print(f"first largest tip deflection of the beam at t = {time:.4g}\n")
    print("\n".join(differences(continuum, beam, own, beam_there, finer)) + "\n")
    profiles = {
        "independent": (continuum["X3"], continuum),
        "same instant": own,
        "beam": (continuum["X3"], beam),
    }
    print("\n".join(parabolas(profiles)) + "\n")
    _, next_beam = beam_profile(continuum["X3"], later=LATER)
    growth = parabola(continuum["X3"], next_beam["E11"])[1] / parabola(continuum["X3"], beam["E11"])[1] - 1.0
    print(f"the beam's slope of E11 grows by {100.0 * growth:.1f} % in the next {LATER:g}\n")
    write_csv(pictures / "thickness_profile.csv", profiles)
    draw(pictures / "thickness_profile.png", profiles)


if __name__ == "__main__":
    run_script(main)

"""Buckling: the load at which the lowest frequency of a compressed column vanishes."""

import numpy as np
import pytest

from closed_forms import Gent, Section, bending_frequencies, buckling_stretch
from gentbeam_runs import solve

E = 12000.0
SUPPORTS = {"pinned": "FIX u1 u3 x=0\nFIX u3 x={L}", "clamped": "FIX u1 u3 y1 x=0"}
WAVE_NUMBER = {"pinned": np.pi, "clamped": 0.5 * np.pi}
# Held too where the buckled shape has a node, the closed form is exact; left free, xi finds a boundary layer.
EXACT = {"pinned": "FIX xi x=0\nFIX xi x={L}", "clamped": "FIX xi x={L}"}


def material(jm=1e20):
    return Gent(E / 2.4, E * 0.2 / 0.96, jm=jm, rho=1e-6)


def lowest_squares(column, slenderness, loads, jm=1e20, held=True):
    """The lowest angular frequency's square of a column under each of the loads."""
    loads = [float(load) for load in loads]
    deck = "\n".join(
        [
            "GENTBEAM column",
            "PARAMETER L=%r" % float(slenderness),
            material(jm).deck,
            "SECTION s rectangle b=1 h=1",
            "LINE from=0 to=L elements=16 nodes=4",
            SUPPORTS[column].replace("{L}", "L"),
            EXACT[column].replace("{L}", "L") if held else "",
            f"POINT x=L f1={-loads[-1]!r}",
            "END",
        ]
        + [f"STATIC steps=2 load={load / loads[-1]!r} name=p{i}\nMODAL count=1 name=m{i}"
           for i, load in enumerate(loads)]
        + ["STOP", ""]
    )
    beam = solve(deck)
    return np.array([(2.0 * np.pi * beam[f"m{i}"].frequency[0]) ** 2 for i in range(len(loads))])


def critical_load(column, slenderness, expected, **options):
    """Where the square of the lowest frequency vanishes: its cubic through four loads below the expected."""
    loads = expected * np.array([0.97, 0.98, 0.99, 0.998])
    squares = lowest_squares(column, slenderness, loads, **options)
    assert np.all(np.diff(squares) < 0.0)
    # Load as a function of the square: no root to be chosen.
    return np.polyval(np.polyfit(squares, loads, 3), 0.0)


def reissner(column, slenderness):
    """The smallest P with P (1 - P/EA + P/GA) = EI k^2 (published.md's formula; Reissner's beam)."""
    bending = E / 12.0 * (WAVE_NUMBER[column] / slenderness) ** 2
    factor = 1.0 / (E / 2.4) - 1.0 / E
    return (np.sqrt(1.0 + 4.0 * factor * bending) - 1.0) / (2.0 * factor)


@pytest.mark.parametrize("column", ["pinned", "clamped"])
@pytest.mark.parametrize("slenderness, jm", [(10, 1e20), (10, 2.0), (40, 1e20)])
def test_load_of_the_beams_own_determinant(column, slenderness, jm):
    """The 3 x 3 determinant of (u3, y1, xi) about the compressed strip (closed_forms.py) gives the same
    load."""
    stretch = buckling_stretch(material(jm), Section(1.0, 1.0), WAVE_NUMBER[column] / slenderness)
    expected = -material(jm).uniaxial(stretch)[1]
    found = critical_load(column, slenderness, expected, jm=jm)
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("column", ["pinned", "clamped"])
def test_load_of_euler_and_reissner(column):
    """P (1 - P/EA + P/GA) = EI k^2 for a material that stays linear; the Gent strip's modulus changes with
    its strain P/EA, so the two may differ by a multiple of (P/EA) P, and do by the same multiple at every
    slenderness."""
    multiples = []
    for slenderness in (20, 40, 80):
        expected = reissner(column, slenderness)
        found = critical_load(column, slenderness, expected, held=False)
        multiples.append((found / expected - 1.0) / (expected / E))
    assert np.abs(multiples).max() < 2.0
    assert np.ptp(multiples) < 0.1 * np.abs(multiples).max()


@pytest.mark.parametrize("column", ["pinned", "clamped"])
def test_slender_column_buckles_at_eulers_load(column):
    """P = pi^2 EI/L^2 pinned, pi^2 EI/(4 L^2) clamped at one end; L/h = 1000 leaves a difference of 1e-5."""
    euler = E / 12.0 * (WAVE_NUMBER[column] / 1000.0) ** 2
    assert critical_load(column, 1000, euler, held=False) == pytest.approx(euler, rel=1e-5)


def test_frequency_falls_as_the_determinant_says():
    """Not only its zero: the whole course of a pinned column's lowest frequency under growing compression."""
    section, slenderness = Section(1.0, 1.0), 12.0
    k = WAVE_NUMBER["pinned"] / slenderness
    buckled = buckling_stretch(material(), section, k)
    loads = -material().uniaxial(buckled)[1] * np.array([0.2, 0.4, 0.6, 0.8, 0.95])
    for found, force in zip(lowest_squares("pinned", slenderness, loads), loads):
        low, high = buckled, 1.0
        for _ in range(60):
            stretch = 0.5 * (low + high)
            low, high = (stretch, high) if -material().uniaxial(stretch)[1] > force else (low, stretch)
        assert found == pytest.approx(bending_frequencies(material(), section, k, stretch)[0] ** 2, rel=1e-6)

"""The elastica: slender cantilevers bent far, against elliptic integrals and the bending equation."""

import numpy as np
import pytest

from gentbeam_runs import solve

# Tip force P L^2/EI: u/L, w/L, tip angle, by elliptic integrals (after Mattiasson, Int. J. Numer. Methods
# Eng. 17, 1981), and uniform dead load q L^3/EI: values made for this project by an independent code.
TIP_FORCE = {
    1: (0.05643324, 0.30172077, 0.46135195),
    2: (0.16064172, 0.49345748, 0.78174983),
    5: (0.38762836, 0.71379152, 1.21536812),
    10: (0.55499560, 0.81060902, 1.43028554),
}
UNIFORM_LOAD = {2.85: (0.06268300, 0.32546813, 0.44330454), 10: (0.34364624, 0.70019972, 1.05264312)}


def tip(load, slenderness, elements=16, nodes=4):
    """Shortening and deflection by the length, and the director's angle, at the tip.

    The root holds the line and the director's angle alone: CLAMP also holds the thickness, and stiffens a
    stretch as long as the beam is thick.
    """
    deck = f"""GENTBEAM elastica
PARAMETER h={1.0 / slenderness!r} E=12000 EI=E*h^3/12
MATERIAL m elastic e=E nu=0.3 rho=1
SECTION s rectangle b=1 h=h
LINE from=0 to=1 elements={elements} nodes={nodes}
FIX u1 u3 y1 x=0
{load}
END
STATIC steps=20
STOP
"""
    u1, u3, y1, y3 = solve(deck)["static"].u[-1, -1, :4]
    return -u1, u3, np.arctan2(-y1, 1.0 + y3)


@pytest.mark.parametrize("load", TIP_FORCE)
def test_tip_force(load):
    """L/h = 2000: extension, shear and thickness change the shape by (h/L)^2, some 1e-6."""
    assert tip(f"POINT x=1 f3={load}*EI", 2000) == pytest.approx(TIP_FORCE[load], rel=3e-6)


@pytest.mark.parametrize("load", UNIFORM_LOAD)
def test_uniform_load(load):
    assert tip(f"DISTRIBUTED from=0 to=1 q3={load}*EI", 2000) == pytest.approx(UNIFORM_LOAD[load], rel=3e-6)


@pytest.mark.parametrize("elements, nodes", [(64, 2), (64, 3), (16, 4), (8, 5)])
def test_every_element_reaches_it(elements, nodes):
    found = tip("POINT x=1 f3=10*EI", 2000, elements, nodes)
    assert found == pytest.approx(TIP_FORCE[10], rel=2e-3 if nodes == 2 else 1e-5)


def test_thick_cantilevers_tend_to_it_with_the_square_of_their_thickness():
    """What shear, extension and the thickness add is of second order in h/L."""
    gaps = [abs(tip("POINT x=1 f3=2*EI", slenderness)[1] - TIP_FORCE[2][1]) for slenderness in (20, 40, 80)]
    assert np.log2(gaps[0] / gaps[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(gaps[1] / gaps[2]) == pytest.approx(2.0, abs=0.1)

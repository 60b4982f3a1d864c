"""Pure bending by end couples: the beam's five fields have a solution of uniform curvature."""

import numpy as np
import pytest

from closed_forms import Gent, PureBending, Section
from gentbeam_runs import solve

# Constants of the paper's second example; M/(E I kappa) over (Jm, kappa h): of a two-dimensional block bent
# into a ring's sector, exact, by an ordinary differential equation, and of the five fields with the thickness
# integrated exactly. Both were made for this project by an independent code.
MU, C, E = 14000.0 / 2.6, 14000.0 * 0.3 / 0.91, 14000.0
INDEPENDENT = {
    (1e20, 0.1): (0.997788, 0.998130),
    (1e20, 0.4): (0.965946, 0.970919),
    (1e20, 0.8): (0.878250, 0.893268),
    (3.0, 0.4): (1.080603, 1.086224),
    (0.5, 0.01): (1.314123, 1.314124),
    (0.5, 0.4): (1.346049, 1.346943),
}


def bend(jm, curvature, rule="gauss points=10", nodes=3):
    """Solves the curvature for its couple, applies that, and hands back the strip with what was expected.

    The couple is a dead pair of forces on the director, square to it where it ends up: after one radian.
    """
    material, section, length = Gent(MU, C, jm=jm), Section(1.0, 1.0), 1.0 / curvature
    points = int(rule.split("=")[1]) if "=" in rule else 40
    moment, stretch, director, xi = PureBending(material, section, points).solve(curvature)
    angle = curvature * length
    m1, m3 = -moment / director * np.cos(angle), -moment / director * np.sin(angle)
    deck = "\n".join(
        [
            "GENTBEAM pure bending",
            material.deck,
            f"SECTION s rectangle b=1 h=1 rule={rule}",
            f"LINE from=0 to={length} elements=16 nodes={nodes}",
            "FIX u1 u3 y1 x=0",
            f"POINT x={length} m1={float(m1)!r} m3={float(m3)!r}",
            "END",
            "STATIC steps=40",
            "STOP",
            "",
        ]
    )
    return solve(deck), moment, stretch, director, xi


@pytest.mark.parametrize("jm, curvature", INDEPENDENT)
def test_moment_of_the_five_fields(jm, curvature):
    """The quadrature of closed_forms.py is the independent five-field value, to its six digits."""
    moment = PureBending(Gent(MU, C, jm=jm), Section(1.0, 1.0)).solve(curvature)[0]
    assert moment / (E / 12.0 * curvature) == pytest.approx(INDEPENDENT[jm, curvature][1], abs=6e-7)


@pytest.mark.parametrize("jm, curvature", INDEPENDENT)
def test_strip_under_the_couple_takes_the_curvature(jm, curvature):
    """gentbeam under that couple bends into the circle: angle, radius, director and xi at every node."""
    beam, _, stretch, director, xi = bend(jm, curvature)
    u1, u3, y1, y3, found_xi = beam["static"].u[-1].T
    angle = curvature * beam.x
    assert np.arctan2(-y1, 1.0 + y3) == pytest.approx(angle, abs=3e-5 * angle[-1])
    assert np.hypot(y1, 1.0 + y3) == pytest.approx(np.full_like(angle, director), rel=3e-5)
    assert found_xi == pytest.approx(np.full_like(angle, xi), rel=3e-3)
    radius = stretch / curvature
    assert beam.x + u1 == pytest.approx(radius * np.sin(angle), abs=3e-5 * beam.x[-1])
    assert u3 == pytest.approx(radius * (1.0 - np.cos(angle)), abs=3e-5 * beam.x[-1])


@pytest.mark.parametrize("points", [2, 3, 4])
def test_every_thickness_rule_solves_its_own_ring(points):
    """With n Gauss points the strip meets the ring integrated by the same n points."""
    beam, _, _, director, _ = bend(3.0, 0.4, f"gauss points={points}")
    y1, y3 = beam["static"].u[-1, :, 2:4].T
    assert np.arctan2(-y1, 1.0 + y3) == pytest.approx(0.4 * beam.x, abs=3e-5)
    assert np.hypot(y1, 1.0 + y3) == pytest.approx(np.full_like(beam.x, director), rel=3e-5)


@pytest.mark.parametrize("jm, curvature", INDEPENDENT)
def test_five_fields_are_stiffer_than_the_block(jm, curvature):
    """An assumed thickness profile can only stiffen: the excess is second order in kappa h, below 2 %."""
    block, fields = INDEPENDENT[jm, curvature]
    moment = PureBending(Gent(MU, C, jm=jm), Section(1.0, 1.0)).solve(curvature)[0] / (E / 12.0 * curvature)
    assert moment > block
    assert moment / block - 1.0 < 0.04 * curvature**2
    assert moment / block == pytest.approx(fields / block, abs=2e-6)

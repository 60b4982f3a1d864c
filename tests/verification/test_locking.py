"""Locking: stiffness that a wrong choice of integration or kinematics adds, and its absence."""

import numpy as np
import pytest

from gentbeam_runs import solve


def deflection(slenderness, nodes=3, integration="reduced", elements=8, nu=0.3, thickness="",
               plane_strain=False, load=1e-4):
    """Tip deflection of a cantilever by P L^3/3EI; the load bends it by 3e-5 of its length, so that it
    stays linear.

    The root holds the line and the director's angle: the thickness is free, but for what `thickness` adds
    at every node. E_eff is 1, or 4 mu (lambda+mu)/(lambda+2mu) of the three-dimensional moduli in plane
    strain.
    """
    mu = 0.5 / (1.0 + nu)
    lame = nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) if plane_strain else nu / (1.0 - nu**2)
    young = 4.0 * mu * (lame + mu) / (lame + 2.0 * mu)
    places = np.linspace(0.0, 1.0, elements * (nodes - 1) + 1)
    lines = [f"FIX {thickness} x={float(x)!r}" for x in places] if thickness else []
    deck = "\n".join(
        [
            "GENTBEAM locking",
            f"PARAMETER h={1.0 / slenderness!r} EI={young!r}*h^3/12",
            f"MATERIAL m neohookean mu={mu!r} c={lame!r} rho=1",
            "SECTION s rectangle b=1 h=h",
            f"LINE from=0 to=1 elements={elements} nodes={nodes} integration={integration}",
            "FIX u1 u3 y1 x=0",
        ]
        + lines
        + [f"POINT x=1 f3={load}*EI", "END", "STATIC steps=1 iterations=60", "STOP", ""]
    )
    return solve(deck)["static"].at(-1, "u3")[-1] / (load / 3.0), young, mu, lame


def timoshenko(slenderness, young, mu):
    """1 + 3 EI/(GA L^2), the shear factor being 1 of these kinematics."""
    return 1.0 + 0.25 * young / mu / slenderness**2


@pytest.mark.parametrize("slenderness", [10.0, 1e2, 1e3, 1e4])
@pytest.mark.parametrize("nodes", [2, 3, 4, 5])
def test_reduced_integration_bends_thin_beams(nodes, slenderness):
    """P L^3/3EI + P L/GA at every L/h: from 3 nodes on to 1e-4 with 8 elements, 2 nodes miss 1/(4 n^2) of it.

    The one-point element's deflection under a tip force is (1 - 1/(4 n^2)) P L^3/3EI for n elements: exact
    solution of its difference equations.
    """
    found, young, mu, _ = deflection(slenderness, nodes)
    expected = timoshenko(slenderness, young, mu) - (1.0 / 256.0 if nodes == 2 else 0.0)
    assert found == pytest.approx(expected, rel=1e-4 if slenderness > 10.0 else 2e-3)


@pytest.mark.parametrize("slenderness", [1e2, 1e3, 1e4])
def test_full_integration_of_two_nodes_locks(slenderness):
    """Two Gauss points in an element of two nodes stiffen its bending by 1 + GA l^2/(12 EI), l its length
    (Hughes, Taylor and Kanoknukulchai, Int. J. Numer. Methods Eng. 11, 1977): what is left of the
    deflection falls as (h/l)^2."""
    found, young, mu, _ = deflection(slenderness, 2, "full", load=1e-6)
    stiffer = 1.0 + mu / young * (slenderness / 8.0) ** 2
    shear = timoshenko(slenderness, young, mu) - 1.0
    assert found == pytest.approx((1.0 - 1.0 / 256.0) / stiffer + shear, rel=1e-4)


@pytest.mark.parametrize("slenderness", [1e2, 1e3, 1e4])
def test_full_integration_costs_higher_elements_little(slenderness):
    """Full integration still locks the shear of 3 nodes a little; 4 and 5 nodes hold the cubic solution."""
    quadratic = deflection(slenderness, 3, "full")[0]
    assert 0.95 < quadratic < deflection(slenderness, 3)[0] - 1e-4
    for nodes in (4, 5):
        assert deflection(slenderness, nodes, "full")[0] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("plane_strain", [False, True])
@pytest.mark.parametrize("nu", [0.2, 0.45, 0.49, 0.499])
def test_free_thickness_does_not_lock(nu, plane_strain):
    """E_eff I, with the thickness free to follow bending by xi, for nu to 0.499.

    In plane strain nu = 0.499 means lambda/mu = 499: with xi fixed that beam would keep 1/125 of its
    deflection.
    """
    found, young, mu, _ = deflection(200.0, nu=nu, plane_strain=plane_strain)
    assert found == pytest.approx(timoshenko(200.0, young, mu), rel=2e-4)


@pytest.mark.parametrize("plane_strain", [False, True])
@pytest.mark.parametrize("nu", [0.2, 0.45, 0.49, 0.499])
def test_poisson_locking_with_xi_fixed(nu, plane_strain):
    """Without xi the fibres cannot thin: bending is as stiff as lambda + 2 mu says, in place of E_eff."""
    found, young, mu, lame = deflection(200.0, nu=nu, plane_strain=plane_strain, thickness="xi")
    stiff = (lame + 2.0 * mu) / young
    expected = 1.0 / stiff + timoshenko(200.0, young, mu) - 1.0
    assert found == pytest.approx(expected, rel=2e-4)
    assert found < 1.0 - 0.9 * nu**2


def test_large_deflection_near_incompressibility():
    """A thin cantilever's large deflection depends on E_eff I alone: nu = 0.2 and 0.499 in plane strain
    agree."""
    tips = [deflection(1000.0, 4, nu=nu, plane_strain=True, elements=12, load=0.5)[0] for nu in (0.2, 0.499)]
    assert tips[0] < 0.99
    assert tips[1] == pytest.approx(tips[0], rel=2e-5)

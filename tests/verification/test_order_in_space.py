"""Order of convergence in space: elements of 2, 3, 4 and 5 nodes, polynomials of degree p = 1 to 4.

Finite-element theory (Strang and Fix, An Analysis of the Finite Element Method): displacements converge with
order p+1 in the L2 norm. At the ends of elements they converge with order 2p, in beams also with p Gauss
points an element (Arnold, Numer. Math. 37, 1981), which gentbeam uses for want of locking.
"""

import numpy as np
import pytest

from closed_forms import Gent, Section, bending_frequencies
from gentbeam_runs import FIELDS, solve

MESHES = {2: (64, 128), 3: (32, 64), 4: (24, 48), 5: (24, 48)}
TIP_MESHES = {
    "gauss points=3": {2: (64, 128), 3: (64, 128), 4: (32, 48), 5: (32, 40)},
    "linear": {2: (64, 128), 3: (32, 64), 4: (8, 12), 5: (10, 14)},
}
FREQUENCY_MESHES = {2: (64, 128), 3: (16, 32), 4: (6, 9), 5: (4, 6)}
MATERIAL = Gent(5000.0, 2500.0, jm=2.0)


def slope(sizes, errors):
    """The order at which two errors fall with the number of elements."""
    return np.log(errors[0] / errors[1]) / np.log(sizes[1] / sizes[0])


def interpolate(beam, u, places):
    """A field between nodes, by the elements' own Lagrange polynomials."""
    values = np.empty_like(places)
    for nodes in beam.elements:
        x = beam.x[nodes]
        inside = (places >= x.min()) & (places <= x.max())
        others = [np.delete(x, i) for i in range(len(x))]
        shapes = [np.prod((places[inside, None] - o) / (x[i] - o), axis=1) for i, o in enumerate(others)]
        values[inside] = u[nodes] @ np.array(shapes)
    return values


def cantilever(nodes, elements, integration="reduced", rule="gauss points=3"):
    """A thick one, bent by a quarter of its length: xi and y3 settle over a tenth of the thickness at the
    ends, and only a mesh that resolves those layers shows its order."""
    deck = f"""GENTBEAM order in space
{MATERIAL.deck}
SECTION s rectangle b=1 h=6 rule={rule}
LINE from=0 to=10 elements={elements} nodes={nodes} integration={integration}
{HELD[rule]}
DISTRIBUTED from=0 to=10 q3={LOADS[rule]}
END
STATIC steps=8 tolerance=1e-13
STOP
"""
    beam = solve(deck)
    return beam, beam["static"].u[-1]


# The linear resultants hold no strain of xi': xi has to be held somewhere, and its layer is absent.
HELD = {"gauss points=3": "FIX u1 u3 y1 x=0", "linear": "FIX u1 u3 y1 xi x=0"}
LOADS = {"gauss points=3": 300, "linear": 1000}


@pytest.fixture(scope="module")
def converged():
    return {rule: cantilever(5, 192, rule=rule) for rule in TIP_MESHES}


@pytest.mark.parametrize("integration", ["reduced", "full"])
@pytest.mark.parametrize("nodes", [2, 3, 4, 5])
def test_bent_cantilever_in_the_l2_norm(nodes, integration, converged):
    """Order p+1 of u1, u3 and y1 in the norm of L2, against a mesh of 192 elements of 5 nodes."""
    fine, reference = converged["gauss points=3"]
    places = (np.arange(1200) + 0.5) / 120.0
    runs = [cantilever(nodes, elements, integration) for elements in MESHES[nodes]]
    for name in ("u1", "u3", "y1"):
        field = FIELDS.index(name)
        exact = interpolate(fine, reference[:, field], places)
        errors = [np.sqrt(np.mean((interpolate(beam, u[:, field], places) - exact) ** 2)) for beam, u in runs]
        assert slope(MESHES[nodes], errors) == pytest.approx(nodes, abs=0.2), (name, errors)


@pytest.mark.parametrize("nodes", [2, 3, 4, 5])
@pytest.mark.parametrize("rule", TIP_MESHES)
def test_bent_cantilever_at_its_tip(nodes, rule, converged):
    """Order 2p of the tip's deflection: 2, 4, 6 and 8, for both section rules."""
    exact = converged[rule][1][-1, 1]
    meshes = TIP_MESHES[rule][nodes]
    errors = [abs(cantilever(nodes, elements, rule=rule)[1][-1, 1] - exact) for elements in meshes]
    assert slope(meshes, errors) == pytest.approx(2 * nodes - 2, abs=0.4), errors


def bar(nodes, elements):
    """A strip held to one dimension (u3, y1, y3, xi fixed at every node) under a uniform load along it."""
    places = [repr(float(x)) for x in np.linspace(0.0, 1.0, elements * (nodes - 1) + 1)]
    deck = "\n".join(
        [
            "GENTBEAM bar under a load along it",
            MATERIAL.deck,
            "SECTION s rectangle b=1 h=1",
            f"LINE from=0 to=1 elements={elements} nodes={nodes}",
            "FIX u1 x=0",
        ]
        + [f"FIX u3 y1 y3 xi x={x}" for x in places]
        + [f"DISTRIBUTED from=0 to=1 q1={LOAD}", "END", "STATIC steps=5 tolerance=1e-13", "STOP", ""]
    )
    beam = solve(deck)
    return beam, beam["static"].u[-1, :, 0]


LOAD = 20000.0


def bar_exact(places):
    """P11(l1) A = q (L - x), and u1 the integral of l1 - 1: Gauss points between the places."""
    z, weights = np.polynomial.legendre.leggauss(6)
    edges = np.concatenate([[0.0], places])
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    force = LOAD * (1.0 - (middle[:, None] + half[:, None] * z))
    stretch = np.ones_like(force)
    for _ in range(100):
        stretch -= (MATERIAL.stress(stretch, 1.0)[0] - force) / MATERIAL.moduli(stretch, 1.0)[0]
        stretch = np.clip(stretch, 0.5, np.sqrt(MATERIAL.jm + 1.0) - 1e-9)
    return np.cumsum(((stretch - 1.0) @ weights) * half)


@pytest.mark.parametrize("nodes", [2, 3, 4, 5])
def test_gent_bar_under_its_own_load(nodes):
    """Order p+1 in L2 to the closed solution of a nonlinear bar whose strain runs from 0 to 60 %."""
    places = (np.arange(1200) + 0.5) / 1200.0
    exact = bar_exact(places)
    assert 0.3 < exact[-1] < 0.5
    errors = []
    for elements in MESHES[nodes]:
        beam, u = bar(nodes, elements)
        errors.append(np.sqrt(np.mean((interpolate(beam, u, places) - exact) ** 2)))
    assert slope(MESHES[nodes], errors) == pytest.approx(nodes, abs=0.2), errors


@pytest.mark.parametrize("nodes", [2, 3, 4, 5])
def test_frequencies_of_a_simply_supported_strip(nodes):
    """Order 2p to the closed form of the third bending wave (closed_forms.py), which has no layers."""
    material, section = Gent(5000.0, 2500.0, jm=2.0, rho=1e-6), Section(1.0, 2.0)
    exact = bending_frequencies(material, section, 0.3 * np.pi)[0] / (2.0 * np.pi)
    errors = []
    for elements in FREQUENCY_MESHES[nodes]:
        deck = f"""GENTBEAM order of frequencies
{material.deck}
SECTION s rectangle b=1 h=2
LINE from=0 to=10 elements={elements} nodes={nodes}
FIX u1 u3 xi x=0
FIX u1 u3 xi x=10
END
MODAL count=8
STOP
"""
        errors.append(np.abs(solve(deck)["modal"].frequency / exact - 1.0).min())
    assert slope(FREQUENCY_MESHES[nodes], errors) == pytest.approx(2 * nodes - 2, abs=0.4), errors

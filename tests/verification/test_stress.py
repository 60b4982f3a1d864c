"""Stresses and resultants in the results file: equilibrium, closed forms, the two-dimensional continuum."""

import subprocess

import h5py
import numpy as np
import pytest

from gentbeam_runs import program
from thickness_profile import DECK as PROFILE_DECK
from thickness_profile import LENGTH, read_reference

CANTILEVER = """\
GENTBEAM cantilever
PARAMETER n=10 jm=2
MATERIAL m gent mu=5000 c=2500 jm=jm rho=1e-6
SECTION s rectangle b=1 h=1 rule={rule}
LINE from=0 to=10 elements=n
CLAMP x=0
DISTRIBUTED from=0 to=10 q3=2.85
{loads}
OUTPUT fields=[u a strain stress]
END
{solution}
STOP
"""


@pytest.fixture
def run(tmp_path):
    def run_deck(deck, **parameters):
        command = [program(), "-q", "-o", "beam"]
        for name, value in parameters.items():
            command += ["--set", f"{name}={value}"]
        done = subprocess.run(command, input=deck, cwd=tmp_path, text=True, capture_output=True, check=False)
        assert done.returncode == 0, done.stderr
        with h5py.File(tmp_path / "beam.h5", "r") as file:
            found = {}
            file.visititems(
                lambda name, item: found.update({name: item[()]} if hasattr(item, "shape") else {})
            )
        return found

    return run_deck


def shapes(results):
    """Element nodes, shape functions and slopes (by X1) of quadratic elements at the stations."""
    x, elements = results["mesh/x"], results["mesh/elements"][:, :3]
    nodes = elements[results["mesh/stations/element"]]
    half = 0.5 * (x[nodes[:, 2]] - x[nodes[:, 0]])
    s = (results["mesh/stations/x"] - x[nodes[:, 1]]) / half
    n = np.stack([0.5 * s * (s - 1.0), 1.0 - s**2, 0.5 * s * (s + 1.0)], axis=1)
    d = np.stack([s - 0.5, -2.0 * s, s + 0.5], axis=1) / half[:, None]
    return nodes, n, d


def directors(results, group, row):
    nodes, n, _ = shapes(results)
    fields = np.einsum("si,sif->sf", n, results[f"{group}/u"][row][nodes])
    return fields, np.stack([fields[:, 2], 1.0 + fields[:, 3]], axis=1)


def section_forces(results, group, row):
    """Forces across the sections along the axes of space, put together from axial and shear force."""
    _, w = directors(results, group, row)
    along = w / np.linalg.norm(w, axis=1, keepdims=True)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    axial, shear = results[f"{group}/stress/axial"][row], results[f"{group}/stress/shear"][row]
    return axial[:, None] * normal + shear[:, None] * along


@pytest.mark.parametrize("rule", ["gauss points=4", "linear"])
def test_forces_of_a_cantilever_balance_its_loads(run, rule):
    """Statically determinate: the force across a section is that of the loads beyond it, to round-off, since
    the element's two integration points carry the linear force exactly."""
    results = run(CANTILEVER.format(rule=rule, loads="POINT x=10 f1=3 f3=-5", solution="STATIC steps=5"))
    beyond = LENGTH - results["mesh/stations/x"]
    expected = np.stack([np.full_like(beyond, 3.0), -5.0 + 2.85 * beyond], axis=1)
    assert section_forces(results, "static", -1) == pytest.approx(expected, abs=1e-8)


def moments_of_loads(results):
    """Moments of the dead loads beyond each station about its deformed place, positive as in the file."""
    x, elements, u = results["mesh/x"], results["mesh/elements"][:, :3], results["static/u"][-1]
    points, weights = np.polynomial.legendre.leggauss(4)

    def place(element, at):
        a, b, c = x[elements[element]]
        s = (at - b) / (0.5 * (c - a))
        n = np.array([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)])
        return np.array([at, 0.0]) + n @ u[elements[element], :2]

    tip, found = place(len(elements) - 1, LENGTH), []
    for station, home in zip(results["mesh/stations/x"], results["mesh/stations/element"]):
        here = place(home, station)
        arm = tip - here
        moment = arm[0] * -5.0 - arm[1] * 3.0
        for element in range(home, len(elements)):
            low, high = max(x[elements[element][0]], station), x[elements[element][2]]
            for point, weight in zip(points, weights):
                at = low + 0.5 * (high - low) * (1.0 + point)
                moment += 0.5 * (high - low) * weight * 2.85 * (place(element, at) - here)[0]
        found.append(-moment)
    return np.array(found)


def test_moments_of_a_cantilever_converge_to_those_of_its_loads(run):
    errors = []
    for n in (10, 20, 40):
        deck = CANTILEVER.format(
            rule="gauss points=4", loads="POINT x=10 f1=3 f3=-5", solution="STATIC steps=5"
        )
        results = run(deck, n=n)
        exact = moments_of_loads(results)
        errors.append(np.abs(results["static/stress/moment"][-1] - exact).max() / np.abs(exact).max())
    assert errors[0] < 1e-4 and errors[2] < errors[0] / 4.0, errors


def test_forces_of_a_moving_beam_balance_loads_and_inertia(run):
    """Virtual work of every free node: what the sections carry is load less mass times acceleration."""
    deck = CANTILEVER.format(
        rule="gauss points=4", loads="", solution="TRANSIENT newmark step=1.35e-4 end=2.7e-3"
    )
    results = run(deck)
    nodes, _, d = shapes(results)
    x, elements = results["mesh/x"], results["mesh/elements"][:, :3]
    for row in (1, 7, 20):
        force, balance = section_forces(results, "transient", row), np.zeros((len(x), 2))
        size = (x[elements[:, 2]] - x[elements[:, 0]])[results["mesh/stations/element"]]
        for station in range(len(size)):
            balance[nodes[station]] += 0.5 * size[station] * np.outer(d[station], force[station])
        inertia, scale = np.array([[4, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 30.0, 0.0
        for element in elements:
            length = x[element[2]] - x[element[0]]
            load = 2.85 * length * np.array([1.0, 4.0, 1.0]) / 6.0
            mass = 1e-6 * length * inertia @ results["transient/a"][row][element, :2]
            balance[element] += mass
            balance[element, 1] -= load
            scale = max(scale, np.abs(load).max(), np.abs(mass).max())
        assert np.abs(balance[1:]).max() < 1e-6 * scale, row


def test_uniform_tension(run):
    """A bar free to thin: the whole section carries f1, and nothing else is there."""
    deck = """\
GENTBEAM bar
MATERIAL m gent mu=5000 c=2500 jm=2 rho=1e-6
SECTION s rectangle b=2 h=0.5 rule={rule}
LINE from=0 to=10 elements=4
FIX u1 u3 y1 {hold} x=0
POINT x=10 f1=2000
OUTPUT fields=[u strain stress]
END
STATIC steps=4
STOP
"""
    for rule in ("gauss", "linear"):
        # Rule linear has no hold on a xi that alternates from node to node.
        hold = "xi" if rule == "linear" else ""
        results = run(deck.format(rule=rule, hold=hold))
        stretch = 1.0 + results["static/u"][-1][-1, 0] / 10.0
        thinning = 1.0 + results["static/u"][-1][-1, 3]
        s, cauchy = results["static/stress/S"][-1], results["static/stress/cauchy"][-1]
        assert results["static/stress/axial"][-1] == pytest.approx(np.full(8, 2000.0), rel=1e-10)
        for name in ("shear", "moment"):
            assert np.abs(results[f"static/stress/{name}"][-1]).max() < 1e-6
        assert s[..., 0] == pytest.approx(np.full(s.shape[:2], 2000.0 / stretch), rel=1e-9)
        assert cauchy[..., 0] == pytest.approx(np.full(s.shape[:2], 2000.0 / thinning), rel=1e-9)
        assert np.abs(s[..., 1:]).max() < 1e-6 and np.abs(cauchy[..., 1:]).max() < 1e-6
        e = results["static/strain/E"][-1]
        assert e[..., 0] == pytest.approx(np.full(e.shape[:2], 0.5 * (stretch**2 - 1.0)), rel=1e-12)
        assert results["static/strain/J"][-1] == pytest.approx(
            np.full(e.shape[:2], stretch * thinning), rel=1e-9
        )
        i1 = np.full(e.shape[:2], stretch**2 + thinning**2 - 2.0)
        assert results["static/strain/I1-2"][-1] == pytest.approx(i1, rel=1e-9)


def test_turning_the_beam_turns_cauchy_alone(run):
    """A quarter of a turn given to both ends of a stretched bar: S stays, Cauchy's 11 becomes its 33."""
    deck = """\
GENTBEAM turned bar
MATERIAL m gent mu=5000 c=2500 jm=2 rho=1e-6
SECTION s rectangle b=1 h=0.5
LINE from=0 to=10 elements=4
PRESCRIBE x=0 u1=0 u3=0 y1={y1} y3={y3}
PRESCRIBE x=10 u1={u1} u3={u3} y1={y1} y3={y3}
OUTPUT fields=[u stress]
END
STATIC steps=20
STOP
"""
    straight = run(deck.format(u1=2, u3=0, y1=0, y3=0))
    # Steps of the ends run along a chord; the last state is all that is looked at.
    turned = run(deck.format(u1=-10, u3=12, y1=-1, y3=-1))
    s = [results["static/stress/S"][-1] for results in (straight, turned)]
    scale = np.abs(s[0]).max()
    assert s[1] == pytest.approx(s[0], abs=1e-7 * scale)
    cauchy = [results["static/stress/cauchy"][-1] for results in (straight, turned)]
    assert cauchy[1][..., 1] == pytest.approx(cauchy[0][..., 0], abs=1e-7 * scale)
    assert cauchy[1][..., 0] == pytest.approx(cauchy[0][..., 1], abs=1e-7 * scale)
    for name in ("axial", "shear", "moment"):
        ours, theirs = (results[f"static/stress/{name}"][-1] for results in (turned, straight))
        assert ours == pytest.approx(theirs, abs=1e-7 * scale)


def test_profile_of_the_continuum(run):
    """Example 1 at its first largest deflection, X1 = L/2. The independent continuum bends 3 % more there
    than the beam (docs/theory.md, the thickness profile). Fibre strain and stress agree to that; S33, zero on
    the continuum's faces, is small beside S11; S13 has the right integral, not the right shape."""
    deck = PROFILE_DECK.replace("dt=2.5e-6", "dt=1e-5")
    results = run(deck.replace("PROBE tip", "OUTPUT fields=[u strain stress]\nPROBE tip"))
    row = int(np.argmax(results["transient/probes/tip"]))
    element = np.argmin(np.abs(results["mesh/x"][results["mesh/elements"][:, 1]] - 0.5 * LENGTH))
    stations = np.flatnonzero(results["mesh/stations/element"] == element)
    continuum = read_reference()
    order = np.argsort(continuum["X3"])
    heights = results["mesh/stations/x3"][stations[0]]

    def off(name, component, column):
        beam = results[f"transient/{name}"][row][stations, :, component].mean(axis=0)
        return np.abs(beam - np.interp(heights, continuum["X3"][order], continuum[column][order])).max()

    strain, stress = np.abs(continuum["E11"]).max(), np.abs(continuum["S11"]).max()
    assert off("strain/E", 0, "E11") < 0.035 * strain
    assert off("strain/E", 1, "E33") < 0.02 * strain
    assert off("stress/S", 0, "S11") < 0.035 * stress
    assert off("stress/S", 1, "S33") < 0.015 * stress
    # The tractions' integrals: transverse force and moment.
    step = np.diff(continuum["X3"][order])

    def integral(values):
        return (0.5 * (values[order][1:] + values[order][:-1]) * step).sum()

    traction = [
        continuum[f"F{i}1"] * continuum["S11"] + continuum[f"F{i}3"] * continuum["S13"] for i in (1, 3)
    ]
    force = np.array([integral(part) for part in traction])
    ours = section_forces(results, "transient", row)[stations].mean(axis=0)
    # The force along X1 rings with axial waves, sixteen times as fast as the bending: another instant,
    # another force.
    assert ours[1] == pytest.approx(force[1], rel=0.04)
    # Positions across the continuum's section, by integrating its F33 and F13 from the mid-line.
    across = np.stack([continuum["F13"][order], continuum["F33"][order]], axis=1)
    place = np.concatenate(
        [np.zeros((1, 2)), np.cumsum(0.5 * (across[1:] + across[:-1]) * step[:, None], axis=0)]
    )
    place -= [np.interp(0.0, continuum["X3"][order], place[:, i]) for i in (0, 1)]
    arm = np.empty_like(place)
    arm[order] = place
    moment = integral(traction[0] * arm[:, 1] - traction[1] * arm[:, 0])
    assert results["transient/stress/moment"][row][stations].mean() == pytest.approx(moment, rel=0.035)

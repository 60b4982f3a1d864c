"""Order of convergence in time of every scheme, and the discrete frequencies that theory gives them."""

import numpy as np
import pytest

from closed_forms import Gent
from gentbeam_runs import solve

IMPLICIT = ["newmark", "hht alpha=-0.1", "generalized rho=0.8", "generalized rho=0", "bathe", "bathe rho=0.5",
            "energy"]
MATERIAL = Gent(5000.0, 2500.0, jm=2.0, rho=1e-6)
END = 2e-3


def swing(scheme, steps, elements=4, inertia="diagonal", rule="gauss points=3"):
    """A cantilever swung up to half its length by a load that grows smoothly; tip history and end state."""
    deck = f"""GENTBEAM order in time
{MATERIAL.deck}
SECTION s rectangle b=1 h=1 rule={rule} inertia={inertia}
LINE from=0 to=10 elements={elements} nodes=3
HISTORY smooth formula f=sin(pi*t/{2.0 * END})^4
CLAMP x=0
DISTRIBUTED from=0 to=10 q3=10 history=smooth
PROBE tip u3 x=10
PROBE speed v3 x=10
OUTPUT every={steps} fields=u
END
TRANSIENT {scheme} step={END / steps!r} end={END} tolerance=1e-13
STOP
"""
    return solve(deck)["transient"]


def tip_errors(scheme, counts, reference, **options):
    """Largest errors of tip displacement and speed over the coarsest run's instants."""
    errors = []
    for steps in counts:
        run = swing(scheme, steps, **options)
        rows = []
        for probe in ("tip", "speed"):
            exact, found = reference.probes[probe], run.probes[probe]
            every, own = (len(exact) - 1) // counts[0], (len(found) - 1) // counts[0]
            rows.append(np.abs(found[::own] - exact[::every]).max() / np.abs(exact).max())
        errors.append(rows)
    return np.array(errors)


@pytest.fixture(scope="module")
def converged():
    """`energy` and Bathe's scheme at a far smaller step; the two agree to a part of what is tested."""
    references = [swing(scheme, 25600) for scheme in ("energy", "bathe")]
    gap = np.abs(references[0].probes["tip"] - references[1].probes["tip"]).max()
    assert gap < 1e-6 * np.abs(references[0].probes["tip"]).max()
    return references[1]


@pytest.mark.parametrize("scheme", IMPLICIT)
def test_second_order(scheme, converged):
    """Every implicit scheme converges with order 2 to the same motion (displacement and velocity)."""
    errors = tip_errors(scheme, (100, 200, 400, 800), converged)
    slopes = np.log2(errors[:-1] / errors[1:])
    assert slopes[-1] == pytest.approx(np.array([2.0, 2.0]), abs=0.1), slopes
    assert errors[-1].max() < 1e-3


def test_newmark_with_numerical_damping_is_of_first_order(converged):
    """gamma > 1/2 costs one order (Newmark; Hughes, The Finite Element Method, 9.1)."""
    errors = tip_errors("newmark beta=0.3025 gamma=0.6", (200, 400, 800), converged)
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(np.array([1.0, 1.0]), abs=0.1)


@pytest.mark.parametrize("scheme", ["newmark", "bathe"])
def test_second_order_with_configuration_dependent_mass(scheme):
    """inertia=full: the mass depends on the configuration, the order stays 2."""
    reference = swing("bathe", 12800, inertia="full")
    errors = tip_errors(scheme, (100, 200, 400, 800), reference, inertia="full")
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(np.array([2.0, 2.0]), abs=0.1), errors


@pytest.mark.parametrize("scheme", ["newmark", "bathe"])
def test_second_order_with_linear_resultants(scheme):
    """rule=linear, the paper's resultants: no potential, the same order."""
    reference = swing("bathe", 12800, rule="linear")
    errors = tip_errors(scheme, (100, 200, 400, 800), reference, rule="linear")
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(np.array([2.0, 2.0]), abs=0.1), errors


def test_central_difference_is_of_second_order():
    """Explicit, lumped mass: order 2 to its own limit, at steps below its stability limit."""
    reference = swing("central", 51200)
    errors = tip_errors("central", (800, 1600, 3200, 6400), reference)
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(np.array([2.0, 2.0]), abs=0.15), errors


def test_central_difference_meets_the_implicit_motion_on_a_fine_mesh(converged):
    """Lumped and consistent mass differ by the mesh alone: the gap closes with the second power of its
    size."""
    gaps = []
    for elements in (8, 16):
        explicit, implicit = swing("central", 6400, elements), swing("bathe", 1600, elements)
        gaps.append(np.abs(explicit.probes["tip"][::4] - implicit.probes["tip"]).max())
    assert gaps[1] < 0.3 * gaps[0]


WAVE_STEPS = 40


def standing_wave(scheme, step, elements=8):
    """A bar wave u1 = A sin(pi x/2L) of tiny amplitude, on 2-node elements held to one dimension."""
    material = Gent(5000.0, 2500.0, rho=1e-6)
    places = [repr(float(x)) for x in np.linspace(0.0, 1.0, elements + 1)]
    deck = "\n".join(
        [
            "GENTBEAM standing wave",
            material.deck,
            "SECTION s rectangle b=1 h=1",
            f"LINE from=0 to=1 elements={elements} nodes=2",
            "FIX u1 x=0",
        ]
        + [f"FIX u3 y1 y3 xi x={x}" for x in places]
        + [
            "INITIAL displacement u1=1e-9*sin(pi*x/2)",
            "END",
            f"TRANSIENT {scheme} step={step!r} end={WAVE_STEPS * step!r} tolerance=1e-13",
            "STOP",
            "",
        ]
    )
    return solve(deck)["transient"]


def bar_frequency(elements, mass):
    """Angular frequency of that wave on 2-node elements: the difference equations have sines for
    solutions."""
    material = Gent(5000.0, 2500.0, rho=1e-6)
    size = 1.0 / elements
    modulus = material.moduli(1.0, 1.0)[0]
    cosine = np.cos(0.5 * np.pi * size)
    if mass == "consistent":
        square = 6.0 * modulus / (material.rho * size**2) * (1.0 - cosine) / (2.0 + cosine)
    else:
        square = 2.0 * modulus / (material.rho * size**2) * (1.0 - cosine)
    return float(np.sqrt(square))


@pytest.mark.parametrize("scheme, mass", [("newmark", "consistent"), ("energy", "consistent"),
                                          ("central", "lumped")])
@pytest.mark.parametrize("omega_step", [0.05, 0.15])
def test_discrete_frequency_of_a_standing_wave(scheme, mass, omega_step):
    """The trapezoidal rule moves with Omega, tan(Omega dt/2) = omega dt/2; central differences with
    sin(Omega dt/2) = omega dt/2: closed forms of the whole scheme, with the mesh's own exact frequency."""
    omega = bar_frequency(8, mass)
    step = omega_step / omega
    run = standing_wave(scheme, step)
    half = 0.5 * omega_step
    phase = 2.0 * (np.arctan(half) if mass == "consistent" else np.arcsin(half))
    expected = 1e-9 * np.cos(phase * np.arange(WAVE_STEPS + 1))
    assert run.at(-1, "u1") == pytest.approx(expected, abs=1e-9 * 1e-6)

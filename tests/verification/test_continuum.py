"""The beam against the two-dimensional continuum (data/README.md): docs/model-error.md states the differences,
these tests hold them to what the beam's kinematics explain. Both are made by scripts/model_error.py."""

import numpy as np
import pytest

from gentbeam_runs import solve
from model_error import EXAMPLES, frequencies, frequency_rows, largest, motion, relative, static_rows

RULES = ("gauss 3", "linear")
RUNS = [(example, jm) for example in EXAMPLES for jm in example.jms]
ids = [f"example{example.number}-jm{jm}" for example, jm in RUNS]


@pytest.fixture(scope="module")
def frequency_errors():
    """The larger of the errors at the two Jm tabulated, by example and rule: of the first three frequencies."""
    found = {}
    for number, _, exact, errors in frequency_rows():
        for rule in RULES:
            now = np.abs(errors[rule][:3])
            before = found.get((number, rule), (0.0, None))[0]
            found[number, rule] = (np.maximum(before, now), exact[:3])
    return found


def test_frequencies_lie_above_the_continuums():
    """Rayleigh: a beam's motions are among the continuum's, so its frequencies are upper bounds.

    That takes the exact inertia, the thickness integrated (nearly) exactly, and the same supports: example 1.
    """
    for number, jm, exact, _ in frequency_rows():
        if number == 1:
            deck = EXAMPLES[0].deck("gauss 3", ["MODAL count=6"], 2)
            deck = deck.replace("points=3", "points=10 inertia=full")
            found = 2.0 * np.pi * solve(deck, jm=jm)["modal"].frequency
            assert (found / exact > 1.0 - 2e-5).all()


@pytest.mark.parametrize("number, modes", [(1, 3), (2, 4), (3, 3)])
def test_frequencies_near_the_continuums(number, modes):
    """The kinematics' shear factor is 1 where the section's is 5/6: that moves a frequency by less than 10 %
    of the part that shear has in it, itself E_eff/mu (kh)^2/12 at most, k = omega-th wave number of a bar."""
    for example, jm, exact, _ in frequency_rows():
        if example == number:
            found = frequencies(number, jm, "gauss 3")
            errors = np.abs(found / exact - 1.0)[:modes]
            assert (errors < 0.006).all(), errors
            assert errors[0] < 0.004


def test_statics_of_the_cantilever():
    """Stiffer than the continuum by what its shear lacks, (1/kappa - 1) 4 EI/(GA L^2) with kappa = 5/6, and as
    much again at most for the section held plane at the clamp and the thickness profile."""
    for jm, _, exact, errors in static_rows():
        mu, lame = 5000.0, 2500.0 + 10000.0 / float(jm)
        young = 4.0 * mu * (lame + mu) / (lame + 2.0 * mu)
        missing = 0.2 * 4.0 * young / 12.0 / mu / 100.0
        assert exact["u3_tip"] > 0.0
        assert -2.5 * missing < errors["gauss 3"]["u3_tip"] < 0.0


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("example, jm", RUNS, ids=ids)
def test_motion(example, jm, rule, frequency_errors):
    """What frequencies are off adds up to a phase: |d omega| T of the first three modes bounds the L2 error of
    the history at the example's main place; the largest deflection, before phases part, is off by no more
    than the stiffness, 2 |d omega|/omega of those modes."""
    reference = example.reference(jm)
    column = example.columns[0]
    found = motion(example, jm, rule)[column]
    errors, exact = frequency_errors[example.number, rule]
    phase = (errors * exact).sum() * reference["t"][-1]
    assert relative(found, reference[column]) < phase
    assert abs(largest(found) / largest(reference[column]) - 1.0) < 2.0 * errors.sum()


@pytest.mark.parametrize("example", EXAMPLES, ids=ids[:: len(ids) // 3][:3])
def test_mesh_and_step_are_converged(example):
    """Halving both changes the history by far less than the model's error."""
    jm, column = example.jms[0], example.columns[0]
    coarse, fine = motion(example, jm, "gauss 3")[column], motion(example, jm, "gauss 3", 2)[column]
    assert relative(coarse, fine) < 0.25 * relative(fine, example.reference(jm)[column])


def test_smaller_jm_is_stiffer_as_in_the_continuum():
    """The paper's 5.1 and 5.2 print the reverse of its own conclusion; the continuum decides: smaller Jm, smaller
    deflection, and the beam follows its ratio to half a percent."""
    for example in EXAMPLES:
        column = example.columns[0]
        soft, stiff = example.jms[0], example.jms[-1]
        ratios = [
            abs(largest(run(stiff)[column]) / largest(run(soft)[column]))
            for run in (example.reference, lambda jm, of=example: motion(of, jm, "gauss 3"))
        ]
        assert ratios[0] < 0.95
        assert ratios[1] == pytest.approx(ratios[0], rel=0.01)


def test_two_thickness_points_need_full_integration():
    """gauss 2 sees one X3^2: with reduced integration u3 + h^2/12 xi has a sawtooth free of energy, and the first
    frequency of a beam on inner supports falls with the mesh. With full integration it stays the continuum's."""
    def first(integration, refine):
        deck = EXAMPLES[1].deck("gauss 2", ["MODAL count=1"], refine)
        deck = deck.replace("integration=full", f"integration={integration}")
        return 2.0 * np.pi * solve(deck)["modal"].frequency[0]

    continuum = 1026.491
    assert first("full", 1) == pytest.approx(continuum, rel=0.005)
    assert first("full", 2) == pytest.approx(continuum, rel=0.005)
    assert first("reduced", 2) < 0.8 * first("reduced", 1) < 0.8 * continuum

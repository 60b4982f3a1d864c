"""The beam against the two-dimensional continuum (data/README.md): docs/model-error.md states the
differences, these tests hold them to what the beam's kinematics explain. Both are made by
scripts/model_error.py."""

import numpy as np
import pytest

from gentbeam_runs import solve
from model_error import EXAMPLES, frequency_rows, largest, motion, relative, static_rows

RULES = ("gauss 3", "linear")
RUNS = [(example, jm) for example in EXAMPLES for jm in example.jms]
ids = [f"example{example.number}-jm{jm}" for example, jm in RUNS]


@pytest.fixture(scope="module")
def frequency_errors():
    """The larger of the errors at the two Jm tabulated, by example and rule: of the first three
    frequencies."""
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


def shear_share(jm, mu, c):
    """E_eff/(12 mu): what shear adds to the compliance of a wave is this times (k h)^2."""
    lame = c + 2.0 * mu / float(jm)
    return (lame + mu) / (lame + 2.0 * mu) / 3.0


@pytest.mark.parametrize("rule", RULES)
def test_frequencies_near_the_continuums(rule):
    """Closer than a beam without shear could be: the error of the lowest four is below what shear takes from
    them, E_eff/(12 mu) (k h)^2 / 2 with the wave number k of bending, k^4 = omega^2 rho A/(E_eff I)."""
    constants = {1: (5000.0, 2500.0, 1e-6), 2: (5384.6, 4615.4, 1e-4), 3: (5384.6, 4615.4, 4e-4)}
    for number, jm, exact, errors in frequency_rows():
        mu, c, rho = constants[number]
        share = shear_share(jm, mu, c)
        square = exact * np.sqrt(rho / (share * mu))
        assert (np.abs(errors[rule]) < 0.5 * share * square)[:4].all(), (number, jm, errors[rule])


def test_statics_of_the_cantilever():
    """Stiffer than the continuum, as an assumed deformation must be, and by less than shear's own share of
    the deflection, 4 EI/(GA L^2)."""
    for jm, _, _, errors in static_rows():
        assert -4.0 * shear_share(jm, 5000.0, 2500.0) / 100.0 < errors["gauss 3"]["u3_tip"] < 0.0


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("example, jm", RUNS, ids=ids)
def test_motion(example, jm, rule, frequency_errors):
    """What frequencies are off adds up to a phase: |d omega| T of the first three modes bounds the L2 error
    of the history at the example's main place; the largest deflection, before phases part, is off by no
    more than the stiffness, 2 |d omega|/omega of those modes."""
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
    """The paper's 5.1 and 5.2 print the reverse of its own conclusion; the continuum decides: smaller Jm,
    smaller deflection, and the beam follows its ratio to one percent."""
    for example in EXAMPLES:
        column = example.columns[0]
        soft, stiff = example.jms[0], example.jms[-1]
        ratios = [
            abs(largest(run(stiff)[column]) / largest(run(soft)[column]))
            for run in (example.reference, lambda jm, of=example: motion(of, jm, "gauss 3"))
        ]
        assert ratios[0] < 0.95
        assert ratios[1] == pytest.approx(ratios[0], rel=0.01)


@pytest.mark.parametrize("integration", ["reduced", "full"])
def test_two_thickness_points_do_not_feel_point_supports(integration):
    """gauss 2 sees one X3^2 = h^2/12, and shear only as (u3 + h^2/12 xi)': next to a support u3 may jump at
    no more cost than xi over one element. The first frequency of a beam on inner supports falls with the
    mesh, fast with reduced integration, slowly with full; three points hold it."""
    def first(rule, refine):
        deck = EXAMPLES[1].deck(rule, ["MODAL count=1"], refine)
        return solve(deck.replace("integration=full", f"integration={integration}"))["modal"].frequency[0]

    falls = {rule: 1.0 - first(rule, 4) / first(rule, 1) for rule in ("gauss 2", "gauss 3")}
    assert falls["gauss 2"] > (0.3 if integration == "reduced" else 0.003)
    assert abs(falls["gauss 3"]) < 2e-4

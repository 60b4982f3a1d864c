"""Uniform states, waves and frequencies against formulas of the energy (closed_forms.py)."""

import numpy as np
import pytest

from closed_forms import Gent, Section, bending_frequencies, bending_matrices
from gentbeam_runs import solve

# Constants of the paper's second example, with and beside the width and thickness 1.
MU, C = 14000.0 / 2.6, 14000.0 * 0.3 / 0.91
LENGTH = 2.5


def strip(material, section, nodes=2, elements=1, rule="gauss points=3", inertia="diagonal"):
    return "\n".join(
        [
            "GENTBEAM closed form",
            material.deck,
            f"SECTION s rectangle b={section.b} h={section.h} rule={rule} inertia={inertia}",
            f"LINE from=0 to={LENGTH} elements={elements} nodes={nodes}",
            "",
        ]
    )


def stretch_by_force(material, section, force, steps, **options):
    """u1 and y3 at the end of a strip pulled by `force` in steps, of which every row is equilibrium."""
    deck = strip(material, section, **options) + "\n".join(
        ["FIX u1 u3 y1 xi x=0", f"POINT x={LENGTH} f1={force!r}", "END", f"STATIC steps={steps}", "STOP", ""]
    )
    static = solve(deck)["static"]
    return static.time, 1.0 + static.at(-1, "u1") / LENGTH, 1.0 + static.at(-1, "y3")


PUBLISHED_STRETCHES = [
    (1e20, 1.2, 0.93988948, 0.46383981),
    (1e20, 1.8, 0.77336028, 1.46772993),
    (3.0, 1.4, 0.8228961, 1.16340709),
    (3.0, 1.8, 0.6307354, 3.477499),
    (0.5, 1.4, 0.61061927, 3.3913081),
]


@pytest.mark.parametrize("jm, l1, l3, stress", PUBLISHED_STRETCHES)
def test_uniaxial_stretch_independent_values(jm, l1, l3, stress):
    """P11 = mu (l1^2 - l3^2)/(l1 D), D = 1 - (I1-2)/Jm, at sigma33 = 0: values from code independent of this.

    The force of a stretch, applied, must give that stretch back; digits as given (7 to 8).
    """
    section = Section(1.3, 0.7)
    _, found, thickness = stretch_by_force(Gent(MU, C, jm=jm), section, stress * MU * section.area, 10)
    assert found[-1] == pytest.approx(l1, rel=2e-7)
    assert thickness[-1] == pytest.approx(l3, rel=3e-7)


@pytest.mark.parametrize("rule", ["gauss points=2", "gauss points=3", "linear"])
@pytest.mark.parametrize("beta", [-2.0, -1.0, 0.7])
@pytest.mark.parametrize("nodes", [2, 3, 5])
def test_uniaxial_stretch_formula(nodes, beta, rule):
    """Every rule, exponent and element meets P11(l1) of the energy at every load, in tension and compression.

    A uniform strain is in the space of every element (the patch test), so only round-off may differ.
    """
    material, section = Gent(MU, C, beta=beta, jm=3.0), Section(1.0, 1.0)
    for force in (1.5 * MU, -0.6 * MU):
        load, l1, l3 = stretch_by_force(material, section, force, 8, nodes=nodes, elements=2, rule=rule)
        for factor, stretch, thickness in zip(load, l1, l3):
            expected_l3, stress = material.uniaxial(stretch)
            assert thickness == pytest.approx(expected_l3, rel=1e-9)
            assert stress == pytest.approx(factor * force, abs=1e-9 * abs(force))


@pytest.mark.parametrize("jm", [0.5, 3.0, 50.0])
def test_uniaxial_stretch_close_to_locking(jm):
    """At I1 - 2 = 0.99999 Jm the chains carry 1e5 times their first modulus: P11 still follows the
    formula."""
    material, section = Gent(MU, C, jm=jm), Section(1.0, 1.0)
    low, high = 1.0, np.sqrt(jm + 2.0)
    for _ in range(200):
        l1 = 0.5 * (low + high)
        l3 = material.thickness_stretch(l1)
        low, high = (l1, high) if l1**2 + l3**2 - 2.0 < 0.99999 * jm else (low, l1)
    # Geometric growth of the load: the stretch tends to its limit as 1/load.
    l1 = float(l1)
    force = material.uniaxial(l1)[1]
    load, stretches, thicknesses = stretch_by_force(material, section, force, 400)
    assert stretches[-1] == pytest.approx(l1, rel=1e-8)
    assert thicknesses[-1] == pytest.approx(l3, rel=1e-8)
    i1 = stretches[-1] ** 2 + thicknesses[-1] ** 2
    assert (i1 - 2.0) / jm == pytest.approx(0.99999, rel=1e-7)
    for factor, l1, l3 in list(zip(load, stretches, thicknesses))[1:]:
        # Stress is the ill-conditioned direction here; the stretch of a given stress is not.
        stress, modulus = material.uniaxial(l1)[1], material.fibre_modulus(l1)
        assert abs(stress - factor * force) / modulus < 1e-9


@pytest.mark.parametrize("jm", [0.5, 3.0, 1e20])
@pytest.mark.parametrize("rule", ["gauss points=3", "linear"])
def test_simple_shear_of_the_director(jm, rule):
    """F13 = g alone: J = 1 and P13 = mu g/(1 - g^2/Jm), which locks at g = sqrt(Jm)."""
    material, section = Gent(MU, C, jm=jm), Section(1.3, 0.7)
    target = float(min(0.999 * np.sqrt(jm), 2.0))
    couple = 0.5 * LENGTH * section.area * MU * target / (1.0 - target**2 / jm)
    deck = strip(material, section, rule=rule) + "\n".join(
        ["FIX u1 u3 y3 xi x=0", f"FIX u1 u3 y3 xi x={LENGTH}"]
        + [f"POINT x={x} m1={couple!r}" for x in (0.0, LENGTH)]
        + ["END", "STATIC steps=50", "STOP", ""]
    )
    static = solve(deck)["static"]
    for node in (0, -1):
        shear = static.at(node, "y1")
        assert shear[-1] == pytest.approx(target, rel=1e-9)
        needed = 0.5 * LENGTH * section.area * MU * shear / (1.0 - shear**2 / jm)
        # The shear that a couple needs, to round-off: dP/dg grows without bound towards locking.
        slope = 0.5 * LENGTH * section.area * MU * (1.0 + shear**2 / jm) / (1.0 - shear**2 / jm) ** 2
        assert np.abs((needed - static.time * couple) / slope).max() < 1e-10
    if rule != "linear":
        work = -0.5 * MU * jm * np.log1p(-(static.at(-1, "y1") ** 2) / jm) * section.area * LENGTH
        assert static.energy["strain"] == pytest.approx(work, rel=1e-10)


@pytest.mark.parametrize("jm", [0.5, 1e20])
def test_simple_shear_of_the_line(jm):
    """F31 = g alone: J = 1 and P31 = mu g/(1 - g^2/Jm)."""
    material, section = Gent(MU, C, jm=jm), Section(1.3, 0.7)
    target = float(min(0.99 * np.sqrt(jm), 2.0))
    force = section.area * MU * target / (1.0 - target**2 / jm)
    deck = strip(material, section, nodes=3, elements=2) + "\n".join(
        ["FIX u1 u3 y1 y3 xi x=0"]
        + [f"FIX u1 y1 y3 xi x={0.25 * i * LENGTH}" for i in range(1, 5)]
        + [f"POINT x={LENGTH} f3={force!r}", "END", "STATIC steps=30", "STOP", ""]
    )
    beam = solve(deck)
    shears = beam["static"].u[-1, 1:, 1] / beam.x[1:]
    assert shears == pytest.approx(np.full(4, target), rel=1e-9)


def test_prescribed_simple_shear_stores_the_energy_of_the_formula():
    """W = -(mu Jm/2) ln(1 - g^2/Jm) in simple shear that supports impose, J = 1."""
    jm, target = 0.5, 0.7
    deck = strip(Gent(MU, C, jm=jm), Section(1.0, 1.0)) + "\n".join(
        [f"FIX u1 u3 y3 xi x={x}\nPRESCRIBE x={x} y1={target}" for x in (0.0, LENGTH)]
        + ["END", "STATIC steps=7", "STOP", ""]
    )
    static = solve(deck)["static"]
    shear = target * static.time
    expected = -0.5 * MU * jm * np.log1p(-(shear**2) / jm) * LENGTH
    assert static.energy["strain"] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("jm", [0.5, 3.0, 1e20])
@pytest.mark.parametrize("l1", [0.8, 1.0, 1.3])
def test_bar_frequencies_about_a_stretched_state(l1, jm):
    """omega = (2n-1) pi/(2L) sqrt(E_t/rho), E_t = dP11/dl1 with the thickness free; long waves (h << L).

    With l1 = 1, E_t is E_eff = 4 mu (lambda+mu)/(lambda+2mu), lambda = c + 2 mu/Jm. The thickness moves with
    the wave and slows it by at most (k h)^2/12 of the fibre's rotary inertia, here below 1e-5.
    """
    material, section = Gent(MU, C, jm=jm, rho=1e-3), Section(1.0, 0.001 * LENGTH)
    force = material.uniaxial(l1)[1] * section.area
    lines = ["FIX u1 x=0"]
    lines += [f"FIX u3 y1 xi x={LENGTH * i / 40!r}" for i in range(41)]
    lines += [f"POINT x={LENGTH} f1={force!r}"] if l1 != 1.0 else []
    lines += ["END"] + (["STATIC steps=10"] if l1 != 1.0 else []) + ["MODAL count=3", "STOP", ""]
    beam = solve(strip(material, section, nodes=5, elements=10) + "\n".join(lines))
    speed = np.sqrt(material.fibre_modulus(l1) / material.rho)
    expected = (2.0 * np.arange(1, 4) - 1.0) / (4.0 * LENGTH) * speed
    assert beam["modal"].frequency == pytest.approx(expected, rel=1e-5)


def test_effective_modulus_of_the_examples():
    """E_eff = E for Jm = infinity and 1.41 E for Jm = 0.5: most of what the paper sees as stiffening."""
    free, limited = Gent(5000.0, 2500.0), Gent(5000.0, 2500.0, jm=0.5)
    assert free.young == pytest.approx(12000.0, rel=1e-12)
    assert limited.young / free.young == pytest.approx(1.41, abs=0.01)


@pytest.mark.parametrize(
    "free, inertia, factor",
    [
        (("y1",), "diagonal", lambda m: 12.0 * m.mu),
        (("y1",), "full", lambda m: 12.0 * m.mu),
        (("y3",), "diagonal", lambda m: 12.0 * (m.lame + 2.0 * m.mu)),
        (("xi",), "diagonal", lambda m: 80.0 / 3.0 * (m.lame + 2.0 * m.mu)),
        (("u3", "xi"), "full", lambda m: 60.0 * (m.lame + 2.0 * m.mu)),
    ],
)
@pytest.mark.parametrize("jm", [2.0, 1e20])
def test_cut_off_frequencies_of_the_thickness(free, inertia, factor, jm):
    """omega^2 rho h^2 of uniform thickness motions: shear 12 mu, stretch 12 (lambda+2mu), and
    xi (80/3)(lambda+2mu) with inertia `diagonal`, 60 (lambda+2mu) with `full`, where u3 goes along."""
    material, section = Gent(MU, C, jm=jm, rho=2e-3), Section(1.3, 0.2)
    fixed = " ".join(name for name in ("u1", "u3", "y1", "y3", "xi") if name not in free)
    deck = strip(material, section, nodes=3, elements=2, inertia=inertia) + "\n".join(
        [f"FIX {fixed} x={0.25 * i * LENGTH}" for i in range(5)]
        + ["END", f"MODAL count={5 * len(free)}", "STOP", ""]
    )
    modal = solve(deck)["modal"]
    expected = np.sqrt(factor(material) / (material.rho * section.h**2)) / (2.0 * np.pi)
    nearest = np.argmin(np.abs(modal.frequency / expected - 1.0))
    # Neighbours in frequency, 2e-4 apart, are told apart to 1e-5: the frequency is right to the square of
    # that.
    assert modal.frequency[nearest] == pytest.approx(expected, rel=1e-8)
    assert np.ptp(modal.modes[nearest], axis=0).max() < 1e-3 * np.abs(modal.modes[nearest]).max()


@pytest.mark.parametrize("inertia", ["diagonal", "translational"])
def test_bending_frequencies_of_a_simply_supported_strip(inertia):
    """Waves sin(n pi x/L) of the beam's own equations (3 x 3 determinant, closed_forms.py), n = 1 to 4.

    Supports u3 = xi = 0 keep the wave exact; 5-node elements leave an error below 1e-7.
    """
    material, section = Gent(MU, C, jm=3.0, rho=1e-3), Section(1.3, 0.3)
    deck = strip(material, section, nodes=5, elements=16, inertia=inertia) + "\n".join(
        ["FIX u1 u3 xi x=0", f"FIX u3 xi x={LENGTH}", "END", "MODAL count=12", "STOP", ""]
    )
    modal = solve(deck)["modal"]
    bending = [
        2.0 * np.pi * frequency
        for frequency, mode in zip(modal.frequency, modal.modes)
        if np.abs(mode[:, 1]).max() > np.abs(mode[:, 0]).max()
    ]
    for n in range(1, 5):
        k = n * np.pi / LENGTH
        if inertia == "diagonal":
            expected = bending_frequencies(material, section, k)[0]
        else:
            expected = without_rotary_inertia(material, section, k)
        assert bending[n - 1] == pytest.approx(expected, rel=1e-7)


def without_rotary_inertia(material, section, k):
    stiffness, mass = bending_matrices(material, section, k, 1.0)
    condensed = stiffness[0, 0] - stiffness[0, 1:] @ np.linalg.solve(stiffness[1:, 1:], stiffness[1:, 0])
    return np.sqrt(condensed / mass[0, 0])


@pytest.mark.parametrize("l1", [1.0, 1.25])
def test_stretch_waves_travel_with_the_bar_speed(l1):
    """A long pulse runs along a strip with sqrt(E_t/rho) of reference length a time: sqrt(E_eff/rho)
    unloaded.

    E_t = dP11/dl1 at the stretch the strip is held at. Arrival times at two places, by the pulse's centroid.
    """
    material = Gent(MU, C, jm=1.0, rho=1e-3)
    length, width, held, push = 40.0, 0.1, material.uniaxial(l1)[1] * 0.1, 1e-4 * MU * 0.1
    speed = float(np.sqrt(material.fibre_modulus(l1) / material.rho))
    duration = 4.0 / speed
    end = 36.0 / speed
    deck = "\n".join(
        [
            "GENTBEAM stretch wave",
            material.deck,
            f"SECTION s rectangle b=1 h={width}",
            f"LINE from=0 to={length} elements=100 nodes=3",
            f"HISTORY pulse formula f=sin(pi*min(t,{duration!r})/{duration!r})^2",
            f"FIX u1 u3 y1 x={length}",
            "FIX u3 x=0",
            f"POINT x=0 f1={-held!r}" if l1 != 1.0 else "",
            f"POINT x=0 f1={push!r} history=pulse stage=transient",
            "PROBE near v1 x=8",
            "PROBE far v1 x=24",
            "OUTPUT fields=none",
            "END",
            "STATIC steps=10" if l1 != 1.0 else "",
            f"TRANSIENT energy end={end!r} step={end / 900!r}",
            "STOP",
            "",
        ]
    )
    probes = solve(deck)["transient"].probes
    time, near, far = probes["time"], probes["near"], probes["far"]
    near_time, far_time = ((time * pulse**2).sum() / (pulse**2).sum() for pulse in (near, far))
    assert 16.0 / (far_time - near_time) == pytest.approx(speed, rel=1e-3)

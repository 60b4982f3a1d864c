"""What must not matter: mirrored, moved, rescaled, renumbered and differently written scenes.

Where no rounding changes, the same numbers are asserted bit for bit; elsewhere to round-off.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from gentbeam_runs import solve

LENGTH = 12.0
# Of 50 to 100 steps (central: 200) of a matrix whose condition number is some 1e4, and of modes sought to
# 1e-11.
ROUND_OFF = 5e-12
MODAL_ROUND_OFF = 5e-11


@dataclass(frozen=True)
class Scene:
    """A beam clamped at one end, held at a third, loaded along a part, by a force and by a couple."""

    scheme: str = "newmark"
    rule: str = "gauss points=3"
    up: float = 1.0  # -1: mirrored through the beam's line
    right: float = 1.0  # -1: the clamp at the other end
    origin: float = 0.0
    length: float = 1.0  # units
    force: float = 1.0
    time: float = 1.0
    cut: tuple = ()  # places where one LINE becomes two

    def place(self, x):
        return repr(self.origin + self.length * (x if self.right > 0.0 else LENGTH - x))

    def span(self, start, stop):
        ends = sorted((start, stop), key=lambda x: self.right * x)
        return f"from={self.place(ends[0])} to={self.place(ends[1])}"

    @property
    def deck(self):
        pressure = self.force / self.length**2
        cuts = sorted((0.0, *self.cut, LENGTH), key=lambda x: self.right * x)
        lines = [
            f"LINE {self.span(*pair)} elements={round(abs(pair[1] - pair[0]) * 2)} nodes=3"
            for pair in zip(cuts, cuts[1:])
        ]
        return "\n".join(
            [
                "GENTBEAM scene",
                f"MATERIAL m gent mu={5384.6 * pressure!r} c={4615.4 * pressure!r} jm=2 "
                f"rho={1e-4 * pressure * (self.time / self.length)**2!r}",
                f"SECTION s rectangle b={self.length!r} h={self.length!r} rule={self.rule}",
                *lines,
                f"CLAMP x={self.place(0.0)}",
                f"ROLLER x={self.place(4.0)}",
                f"DISTRIBUTED {self.span(5.0, 9.25)} q3={20.0 * self.up * self.force / self.length!r}",
                f"POINT x={self.place(12.0)} f1={-15.0 * self.right * self.force!r} "
                f"f3={3.0 * self.up * self.force!r}",
                f"POINT x={self.place(7.0)} m1={25.0 * self.up * self.right * self.force * self.length!r}",
                "END",
                f"TRANSIENT {self.scheme} step={2e-4 * self.time!r} end={1e-2 * self.time!r}",
                "MODAL count=4",
                "STOP",
                "",
            ]
        )

    def run(self):
        """Fields in the units and the frame of the plain scene, nodes counted from the clamp."""
        beam = solve(self.deck)
        u = beam["transient"].u.copy()
        if self.right < 0.0:
            u = u[:, ::-1]
        u *= np.array([self.right, self.up, self.right * self.up, 1.0, 1.0])
        u /= np.array([self.length, self.length, 1.0, 1.0, 1.0 / self.length])
        return u, beam["modal"].frequency * self.time


SCENES = [
    Scene(),
    Scene(scheme="bathe"),
    Scene(scheme="generalized"),
    Scene(scheme="energy"),
    Scene(scheme="central"),
    Scene(rule="linear"),
]
ids = [f"{scene.scheme}-{scene.rule.split()[0]}" for scene in SCENES]


def gap(found, expected):
    """The largest difference of every field, by the field's largest value."""
    return (np.abs(found - expected).max(axis=(0, 1)) / np.abs(expected).max(axis=(0, 1))).max()


@pytest.fixture(scope="module")
def plain():
    return {scene: scene.run() for scene in SCENES}


def test_the_scene_moves_far(plain):
    """A scene at rest would pass everything else."""
    u = plain[SCENES[0]][0]
    assert (np.abs(u).max(axis=(0, 1)) > [0.3, 1.0, 0.2, 0.01, 0.01]).all()


@pytest.mark.parametrize("scene", SCENES, ids=ids)
@pytest.mark.parametrize("units", [{"force": 2.0**-20}, {"time": 2.0**11}], ids=["force", "time"])
def test_units_of_force_and_time_by_powers_of_two(scene, units, plain):
    """The same numbers, bit for bit: all entries of a matrix share the factor, here a square with an exact
    root."""
    u, frequency = replace(scene, **units).run()
    assert np.array_equal(u, plain[scene][0])
    assert np.array_equal(frequency, plain[scene][1])


@pytest.mark.parametrize("scene", SCENES, ids=ids)
@pytest.mark.parametrize("units", [{"length": 16.0}, {"length": 2.0**-10, "force": 2.0**8, "time": 0.25}],
                         ids=["length", "all"])
def test_units_of_length_by_powers_of_two(scene, units, plain):
    """Bit for bit where the matrix is symmetric or lumped. Forces and couples take different factors, so an
    unsymmetric one (energy, linear) chooses other pivots, and the search for modes other shifts:
    round-off."""
    u, frequency = replace(scene, **units).run()
    if scene.scheme == "energy" or scene.rule == "linear":
        assert gap(u, plain[scene][0]) < ROUND_OFF
    else:
        assert np.array_equal(u, plain[scene][0])
    assert frequency == pytest.approx(plain[scene][1], rel=MODAL_ROUND_OFF)


@pytest.mark.parametrize("scene", SCENES, ids=ids)
@pytest.mark.parametrize("units", [{"length": 8.0}, {"force": 2.0**7}], ids=["length", "force"])
def test_units_by_odd_powers_of_two(scene, units, plain):
    """Roots of odd powers of two are rounded (Cholesky): the same numbers to round-off."""
    u, frequency = replace(scene, **units).run()
    assert gap(u, plain[scene][0]) < ROUND_OFF
    assert frequency == pytest.approx(plain[scene][1], rel=MODAL_ROUND_OFF)


@pytest.mark.parametrize("scene", SCENES, ids=ids)
def test_mirror_through_the_line(scene, plain):
    """u3 -> -u3, y1 -> -y1: to round-off (bit by bit it is not: thickness points are added up in one
    order)."""
    u, frequency = replace(scene, up=-1.0).run()
    mirrored = u * np.array([1.0, 1.0, 1.0, 1.0, -1.0])
    assert gap(mirrored, plain[scene][0]) < ROUND_OFF
    assert frequency == pytest.approx(plain[scene][1], rel=MODAL_ROUND_OFF)


@pytest.mark.parametrize("scene", SCENES, ids=ids)
def test_numbering_reversed(scene, plain):
    """The clamp at the other end: the mirror across the beam, with nodes numbered from the free end."""
    u, frequency = replace(scene, right=-1.0).run()
    assert gap(u, plain[scene][0]) < ROUND_OFF
    assert frequency == pytest.approx(plain[scene][1], rel=MODAL_ROUND_OFF)


@pytest.mark.parametrize("scene", SCENES, ids=ids)
@pytest.mark.parametrize("origin", [64.0, -2048.0, 1000.1])
def test_origin_moved(scene, origin, plain):
    """Coordinates enter by their differences alone: round-off of 1e-16 of the origin by the element's
    length."""
    u, frequency = replace(scene, origin=origin).run()
    assert gap(u, plain[scene][0]) < ROUND_OFF
    assert frequency == pytest.approx(plain[scene][1], rel=MODAL_ROUND_OFF)


@pytest.mark.parametrize("scene", SCENES, ids=ids)
def test_one_line_written_as_three(scene, plain):
    """LINEs that join end to end are one beam, bit for bit."""
    u, frequency = replace(scene, cut=(2.5, 9.0)).run()
    assert np.array_equal(u, plain[scene][0])
    assert np.array_equal(frequency, plain[scene][1])

"""The strains through the thickness: what they are for motions known in closed form."""

import numpy as np
import pytest

from thickness_profile import (
    deformation_gradient,
    parabola,
    read_reference,
    section_strains,
    strains,
)

HEIGHT = np.linspace(-0.5, 0.5, 11)
X = np.array([4.9, 5.0, 5.1])


def nodal(u1, u3, y1, y3, xi):
    return np.stack([np.broadcast_to(values, X.shape) for values in (u1, u3, y1, y3, xi)], axis=-1)


@pytest.mark.parametrize("angle", [0.0, 0.7, -2.5])
def test_a_rigid_rotation_strains_nothing(angle):
    s, c = np.sin(angle), np.cos(angle)
    found = section_strains(HEIGHT, X, nodal((c - 1.0) * X, s * X, -s, c - 1.0, 0.0))
    for name in ("E11", "E33", "E13"):
        assert found[name] == pytest.approx(np.zeros(HEIGHT.size), abs=1e-14)
    assert found["J"] == pytest.approx(np.ones(HEIGHT.size), abs=1e-14)


def test_stretches_and_shear():
    found = section_strains(HEIGHT, X, nodal(0.1 * X, 0.0, 0.05, -0.02, 0.03))
    thickness = 1.0 + 0.06 * HEIGHT
    assert found["E11"] == pytest.approx(np.full(HEIGHT.size, 0.5 * (1.1**2 - 1.0)))
    assert found["E33"] == pytest.approx(0.5 * (thickness**2 * (0.05**2 + 0.98**2) - 1.0))
    assert found["E13"] == pytest.approx(0.5 * 1.1 * 0.05 * thickness)
    assert found["J"] == pytest.approx(1.1 * 0.98 * thickness)


def test_the_gradient_is_that_of_the_position():
    def fields(x):
        waves = np.array([0.3, 0.5, 0.2, -0.1, 0.15])
        return waves * np.sin(0.4 * x + np.arange(5)), 0.4 * waves * np.cos(0.4 * x + np.arange(5))

    def position(x, height):
        u1, u3, y1, y3, xi = fields(x)[0]
        zeta = height + xi * height**2
        return np.array([x + u1 + zeta * y1, u3 + zeta * (1.0 + y3)])

    x, height, d = 1.3, 0.4, 1e-6
    along = (position(x + d, height) - position(x - d, height)) / (2.0 * d)
    through = (position(x, height + d) - position(x, height - d)) / (2.0 * d)
    f11, f31, f13, f33 = deformation_gradient(height, *fields(x))
    assert (f11, f31) == pytest.approx(tuple(along), abs=1e-9)
    assert (f13, f33) == pytest.approx(tuple(through), abs=1e-9)


def test_the_strains_in_the_data_are_those_of_its_gradient():
    data = read_reference()
    found = strains(*(data[name] for name in ("F11", "F31", "F13", "F33")))
    for name, values in found.items():
        assert values == pytest.approx(data[name], abs=2e-6)


def test_a_parabola_is_found_again():
    assert parabola(HEIGHT, 1.0 - 2.0 * HEIGHT + 3.0 * HEIGHT**2) == pytest.approx((1.25, -2.0, 3.0))

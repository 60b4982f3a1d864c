"""Closed forms of the Gent material and of uniform states of the beam, written from the energy

    W(F) = -(mu Jm/2) ln(1 - (I1-2)/Jm) - mu ln J + (c/beta^2)(beta ln J + J^-beta - 1)

(Firouzi, equation 15, with its misprint corrected: docs/theory.md) and sharing nothing with the program.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class Gent:
    mu: float
    c: float
    beta: float = -2.0
    jm: float = 1e20
    rho: float = 1.0

    @property
    def deck(self):
        values = (self.mu, self.c, self.beta, self.jm, self.rho)
        return "MATERIAL m gent mu=%r c=%r beta=%r jm=%r rho=%r" % tuple(float(v) for v in values)

    @property
    def lame(self):
        """The first Lame modulus at small strain."""
        return self.c + 2.0 * self.mu / self.jm

    @property
    def young(self):
        """The fibre modulus with the thickness free."""
        return 4.0 * self.mu * (self.lame + self.mu) / (self.lame + 2.0 * self.mu)

    def energy(self, l1, l3):
        """Stored energy of the stretches l1, l3."""
        i1, j = l1**2 + l3**2, l1 * l3
        chains = -0.5 * self.mu * self.jm * np.log1p(-(i1 - 2.0) / self.jm)
        volume = self.c / self.beta**2 * (self.beta * np.log(j) + j**-self.beta - 1.0)
        return chains - self.mu * np.log(j) + volume

    def a(self, l1, l3):
        return self.mu / (1.0 - (l1**2 + l3**2 - 2.0) / self.jm)

    def b(self, l1, l3):
        return -self.mu + self.c / self.beta * (1.0 - (l1 * l3) ** -self.beta)

    def stress(self, l1, l3):
        """First Piola-Kirchhoff stresses P11, P33 of the stretches l1, l3."""
        a, b = self.a(l1, l3), self.b(l1, l3)
        return a * l1 + b / l1, a * l3 + b / l3

    def moduli(self, l1, l3):
        """dP11/dl1, dP11/dl3 = dP33/dl1, dP33/dl3."""
        a, b = self.a(l1, l3), self.b(l1, l3)
        da = 2.0 * a**2 / (self.mu * self.jm)
        db = self.c * (l1 * l3) ** -self.beta
        return (
            a + da * l1**2 + (db - b) / l1**2,
            da * l1 * l3 + db / (l1 * l3),
            a + da * l3**2 + (db - b) / l3**2,
        )

    def thickness_stretch(self, l1):
        """l3 that leaves the thickness free of stress, by Newton's rule kept in a bracket."""
        low, high = 1e-3, min(10.0, np.sqrt(self.jm + 2.0 - l1**2))
        l3 = min(1.0, 0.5 * (low + high))
        for _ in range(200):
            p33 = self.stress(l1, l3)[1]
            low, high = (l3, high) if p33 < 0.0 else (low, l3)
            step = l3 - p33 / self.moduli(l1, l3)[2]
            step = step if low < step < high else 0.5 * (low + high)
            if abs(step - l3) < 1e-16:
                break
            l3 = step
        return float(l3)

    def uniaxial(self, l1):
        """Thickness stretch and P11 of a strip stretched to l1."""
        l3 = self.thickness_stretch(l1)
        return l3, float(self.stress(l1, l3)[0])

    def fibre_modulus(self, l1):
        """dP11/dl1 with the thickness free."""
        e11, e13, e33 = self.moduli(l1, self.thickness_stretch(l1))
        return float(e11 - e13**2 / e33)


@dataclass
class Section:
    b: float
    h: float

    @property
    def area(self):
        return self.b * self.h

    @property
    def second(self):
        return self.b * self.h**3 / 12.0

    @property
    def fourth(self):
        return self.b * self.h**5 / 80.0


def bending_matrices(material, section, k, l1):
    """Stiffness and mass of the wave u3 = W sin kx, y1 = Y cos kx, xi = X sin kx on a beam stretched to l1.

    Second variation of the beam's potential about a uniform state: first-order strains F11: X3 y1',
    F13: y1, F31: u3' + l3 X3^2 xi', F33: 2 l3 X3 xi. The one second-order strain at a stress, F11: X3^2 (xi
    y1)', sums to nothing over half a wave. Inertia is `diagonal`. The wave meets the supports u3 = xi = 0
    exactly, and, a quarter of it, u3 = y1 = 0 beside xi = 0.
    """
    l3 = material.thickness_stretch(l1)
    a, b = material.a(l1, l3), material.b(l1, l3)
    e11, e13, e33 = material.moduli(l1, l3)
    area, second, fourth = section.area, section.second, section.fourth
    cross = -b / (l1 * l3)
    stiffness = np.array(
        [
            [a * area * k**2, cross * area * k, a * second * k**2 * l3],
            [0.0, a * area + e11 * second * k**2, (cross - 2.0 * e13) * l3 * second * k],
            [0.0, 0.0, (a * fourth * k**2 + 4.0 * e33 * second) * l3**2],
        ]
    )
    stiffness += np.triu(stiffness, 1).T
    return stiffness, material.rho * np.diag([area, second, fourth])


def bending_frequencies(material, section, k, l1=1.0):
    """Angular frequencies of that wave: bending, then the two of the thickness (negative squares:
    buckled)."""
    stiffness, mass = bending_matrices(material, section, k, l1)
    scale = 1.0 / np.sqrt(np.diag(mass))
    squares = np.linalg.eigvalsh(scale[:, None] * stiffness * scale)
    return np.sign(squares) * np.sqrt(np.abs(squares))


def buckling_stretch(material, section, k):
    """The stretch below 1 at which that wave needs no force."""
    low, high = 0.5, 1.0
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        if np.linalg.eigvalsh(bending_matrices(material, section, k, middle)[0])[0] > 0.0:
            high = middle
        else:
            low = middle
        if middle in (low, high) and high - low < 3e-16:
            break
    return 0.5 * (low + high)


@dataclass
class PureBending:
    """The beam's five fields in pure bending: strip of constant curvature, stretches and xi uniform."""

    material: Gent
    section: Section
    points: int = 40

    def energy(self, kappa, unknowns):
        """Stored energy per length; unknowns are the mid-line's stretch, the director's length, and xi."""
        stretch, length, xi = unknowns
        z, weights = np.polynomial.legendre.leggauss(self.points)
        z = 0.5 * self.section.h * z
        l1 = stretch - (z + xi * z**2) * length * kappa
        l3 = (1.0 + 2.0 * xi * z) * length
        return 0.5 * self.section.area * (weights * self.material.energy(l1, l3)).sum(), (z, weights, l1, l3)

    def derivatives(self, kappa, unknowns):
        """Gradient and second derivatives with respect to stretch, length, xi, kappa."""
        stretch, length, xi = unknowns
        _, (z, weights, l1, l3) = self.energy(kappa, unknowns)
        weights = 0.5 * self.section.area * weights
        zeta = z + xi * z**2
        one, zero = np.ones_like(z), np.zeros_like(z)
        d1 = np.array([one, -zeta * kappa, -(z**2) * length * kappa, -zeta * length])
        d3 = np.array([zero, 1.0 + 2.0 * xi * z, 2.0 * z * length, zero])
        p11, p33 = self.material.stress(l1, l3)
        e11, e13, e33 = self.material.moduli(l1, l3)
        gradient = d1 @ (weights * p11) + d3 @ (weights * p33)
        second = (d1 * (weights * e11)) @ d1.T + (d3 * (weights * e33)) @ d3.T
        mixed = (d1 * (weights * e13)) @ d3.T
        second += mixed + mixed.T
        curved = np.zeros((4, 4))
        curved[1, 2] = (weights * (p33 * 2.0 * z - p11 * z**2 * kappa)).sum()
        curved[1, 3] = -(weights * p11 * zeta).sum()
        curved[2, 3] = -(weights * p11 * z**2 * length).sum()
        return gradient, second + curved + curved.T

    def solve(self, kappa):
        """Moment, mid-line stretch, director's length and xi at the curvature kappa (per reference
        length)."""
        unknowns = np.array([1.0, 1.0, 0.0])
        for part in np.linspace(0.0, 1.0, 21)[1:]:
            for _ in range(50):
                gradient, second = self.derivatives(part * kappa, unknowns)
                step = np.linalg.solve(second[:3, :3], gradient[:3])
                unknowns = unknowns - step
                if np.abs(step).max() < 1e-15:
                    break
        return self.derivatives(kappa, unknowns)[0][3], *unknowns

"""The paper's strips as two-dimensional continua: no beam assumption, and no line shared with gentbeam.

Biquadratic quadrilaterals on the whole strip, 3 x 3 Gauss points, the Gent energy with beta = -2, a diagonal
mass (the nodes' own Simpson weights) and explicit central differences from rest. Loads are dead, sudden and
spread evenly through the thickness; a support inside the strip holds the mean displacement of its section.
"""

from dataclasses import dataclass

import numpy as np

# Part of the stability limit of the undeformed strip that a step takes; strained chains are stiffer.
SAFETY = 0.7


@dataclass(frozen=True)
class Strip:
    """A strip of unit width and thickness; lengths, forces and times in any consistent units."""

    length: float
    mu: float
    c: float
    jm: float
    rho: float
    clamped: tuple = ()  # sections whose displacements are all held
    held: tuple = ()  # (x, component) of sections whose mean displacement is held; component 0: u1, 1: u3
    slides: tuple = ()  # sections whose u1 is held at every point
    spread: tuple = ()  # (from, to, q3): force a length
    points: tuple = ()  # (x, f3): force


class Continuum:
    """The strip cut into `across` elements through the thickness, as long as they are thick."""

    def __init__(self, strip, across=4):
        self.strip = strip
        self.size = 1.0 / across
        self.columns = round(strip.length * across)
        rows = 2 * across + 1
        self.shape = (2 * self.columns + 1, rows)
        self.thickness_weights = simpson(across)
        self._build_elements(across)
        self.mass = strip.rho * np.outer(simpson(self.columns), self.thickness_weights) * self.size**2
        self.force = self._loads()
        self.fixed = np.zeros((*self.shape, 2), dtype=bool)
        for x in strip.clamped:
            self.fixed[self._section(x)] = True
        for x in strip.slides:
            self.fixed[self._section(x), :, 0] = True

    def _section(self, x):
        return round(2.0 * x / self.size)

    def _build_elements(self, across):
        corner_x, corner_z = np.meshgrid(2 * np.arange(self.columns), 2 * np.arange(across), indexing="ij")
        local_x, local_z = np.meshgrid(np.arange(3), np.arange(3), indexing="ij")
        x = corner_x.reshape(-1, 1) + local_x.reshape(1, -1)
        z = corner_z.reshape(-1, 1) + local_z.reshape(1, -1)
        self.nodes = x * self.shape[1] + z
        points, weights = np.polynomial.legendre.leggauss(3)
        shape = np.stack([points * (points - 1) / 2, 1 - points**2, points * (points + 1) / 2], axis=1)
        slope = np.stack([points - 0.5, -2 * points, points + 0.5], axis=1) * 2.0 / self.size
        along, through = np.kron(slope, shape), np.kron(shape, slope)
        self.gradient = np.concatenate([along, through]).T.copy()  # (nodes of an element, 2 x Gauss points)
        self.weights = np.outer(weights, weights).reshape(-1) * self.size**2 / 4.0

    def _loads(self):
        force = np.zeros((*self.shape, 2))
        through = self.thickness_weights * self.size
        for start, stop, q3 in self.strip.spread:
            first, last = self._section(start), self._section(stop)
            along = simpson((last - first) // 2) * self.size
            force[first : last + 1, :, 1] += q3 * np.outer(along, through)
        for x, f3 in self.strip.points:
            force[self._section(x), :, 1] += f3 * through
        return force

    def _deformation(self, u):
        """F11, F13, F31, F33 at every Gauss point, each (elements, points)."""
        elements = u.reshape(-1, 2)[self.nodes]  # (elements, nodes, 2)
        both = np.concatenate([elements[:, :, 0], elements[:, :, 1]]) @ self.gradient
        count, points = len(self.nodes), len(self.weights)
        return (
            1.0 + both[:count, :points],
            both[:count, points:],
            both[count:, :points],
            1.0 + both[count:, points:],
        )

    def internal_force(self, u):
        f11, f13, f31, f33 = self._deformation(u)
        material = self.strip
        stretched = f11 * f11 + f13 * f13 + f31 * f31 + f33 * f33 - 2.0
        j = f11 * f33 - f13 * f31
        if not (stretched.max() < material.jm and j.min() > 0.0):
            raise ArithmeticError("the continuum left the admissible states: the time step is too long")
        a = self.weights * (material.mu / (1.0 - stretched / material.jm))
        b = self.weights * ((0.5 * material.c * (j * j - 1.0) - material.mu) / j)
        stress = np.concatenate(
            [
                np.concatenate([a * f11 + b * f33, a * f13 - b * f31], axis=1),
                np.concatenate([a * f31 - b * f13, a * f33 + b * f11], axis=1),
            ]
        )
        nodal = stress @ self.gradient.T
        count, total = len(self.nodes), self.mass.size
        force = [
            np.bincount(self.nodes.reshape(-1), part.reshape(-1), total)
            for part in (nodal[:count], nodal[count:])
        ]
        return np.stack(force, axis=1).reshape(self.force.shape)

    def strain_energy(self, u):
        f11, f13, f31, f33 = self._deformation(u)
        material = self.strip
        stretched = f11 * f11 + f13 * f13 + f31 * f31 + f33 * f33 - 2.0
        j = f11 * f33 - f13 * f31
        density = -0.5 * material.mu * material.jm * np.log1p(-stretched / material.jm)
        density += -material.mu * np.log(j) + 0.25 * material.c * (j * j - 1.0 - 2.0 * np.log(j))
        return float((density * self.weights).sum())

    def acceleration(self, u):
        a = (self.force - self.internal_force(u)) / self.mass[:, :, None]
        a[self.fixed] = 0.0
        for x, component in self.strip.held:
            section = a[self._section(x), :, component]
            section -= self.thickness_weights @ section / self.thickness_weights.sum()
        return a

    def stable_step(self):
        material = self.strip
        lame = material.c + 2.0 * material.mu / material.jm
        speeds = (lame + 3.0 * material.mu) / material.rho  # both waves' speeds squared, together
        return SAFETY * 2.0 / np.sqrt(24.0 * speeds / self.size**2)

    def history(self, probes, interval, rows):
        """Mid-line displacements at the probes (x, component), (rows, probes), every `interval` from rest.

        Also returns the largest error of the energy balance, relative to the largest external work.
        """
        splits = int(np.ceil(interval / self.stable_step()))
        dt = interval / splits
        middle = self.shape[1] // 2
        u = np.zeros((*self.shape, 2))
        a = self.acceleration(u)
        v = np.zeros_like(u)
        values = np.zeros((rows, len(probes)))
        balance = work = 0.0
        for row in range(1, rows):
            for _ in range(splits):
                v += 0.5 * dt * a
                u += dt * v
                a = self.acceleration(u)
                v += 0.5 * dt * a
            values[row] = [u[self._section(x), middle, component] for x, component in probes]
            external = float((self.force * u).sum())
            kinetic = 0.5 * float((self.mass[:, :, None] * v * v).sum())
            work = max(work, abs(external))
            balance = max(balance, abs(kinetic + self.strain_energy(u) - external))
        return values, balance / work


def simpson(elements):
    """Simpson's weights of `elements` quadratic elements of length 1."""
    weights = np.zeros(2 * elements + 1)
    weights[1::2] = 4.0 / 6.0
    weights[0::2] = 2.0 / 6.0
    weights[[0, -1]] = 1.0 / 6.0
    return weights

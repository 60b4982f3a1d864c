"""The beam as a strip with thickness and strains, from the fields of a results file.

Strains are computed at each element's Gauss points, where they are best, and carried on from there; u, and so
the shape, is taken from the nodes. Rows of points run along the beam, from the bottom face to the top.
"""

from dataclasses import dataclass

import numpy as np

from gentbeam_results import ResultsError

SUBDIVISIONS = 6  # of an element
LEVELS = 5  # across the thickness, faces included
QUANTITIES = ("E11", "E33", "E13", "J")


@dataclass
class Strip:
    """Interpolation from a mesh's nodes to the points of its strip."""

    x: np.ndarray  # reference X1 (columns)
    x3: np.ndarray  # reference X3 (columns, levels)
    values: np.ndarray  # (columns, nodes): fields at the columns
    carried: np.ndarray  # (columns, nodes): fields at the Gauss points, carried on to the columns
    slopes: np.ndarray  # (columns, nodes): their derivatives, carried on
    ends: np.ndarray  # first column of every element, and the end


def lagrange(nodes, points):
    """Values and derivatives (points, nodes) of Lagrange's polynomials."""
    values, slopes = np.ones((len(points), len(nodes))), np.zeros((len(points), len(nodes)))
    for j, node in enumerate(nodes):
        others = np.delete(nodes, j)
        for other in others:
            values[:, j] *= (points - other) / (node - other)
        for k, other in enumerate(others):
            rest = np.delete(others, k)
            slopes[:, j] += np.prod((points[:, None] - rest) / (node - rest), axis=1) / (node - other)
    return values, slopes


def build_strip(mesh, path):
    if mesh.thickness is None:
        raise ResultsError(f"{path}: has no /mesh/thickness")
    x, x3, ends = [], [], [0]
    values, carried, slopes = [], [], []
    for element, thickness in zip(mesh.elements, mesh.thickness):
        nodes = mesh.x[element]
        count = len(nodes) * SUBDIVISIONS // 2 + 1
        points = np.linspace(nodes.min(), nodes.max(), count)
        gauss = np.polynomial.legendre.leggauss(max(1, len(nodes) - 1))[0]
        gauss = nodes.min() + 0.5 * np.ptp(nodes) * (1.0 + gauss)
        there = lagrange(nodes, gauss)
        onwards = lagrange(gauss, points)[0]
        for matrices, block in (
            (values, lagrange(nodes, points)[0]),
            (carried, onwards @ there[0]),
            (slopes, onwards @ there[1]),
        ):
            whole = np.zeros((count, len(mesh.x)))
            whole[:, element] = block
            matrices.append(whole)
        x.append(points)
        x3.append(np.broadcast_to(thickness * np.linspace(-0.5, 0.5, LEVELS), (count, LEVELS)))
        ends.append(ends[-1] + count)
    return Strip(
        np.concatenate(x),
        np.concatenate(x3),
        np.concatenate(values),
        np.concatenate(carried),
        np.concatenate(slopes),
        np.array(ends),
    )


def places(strip, fields):
    """Deformed places (columns, levels, 2) of a row of fields (nodes, 5)."""
    u1, u3, y1, y3, xi = (strip.values @ fields).T[:, :, None]
    zeta = strip.x3 + xi * strip.x3**2
    return np.stack([strip.x[:, None] + u1 + zeta * y1, u3 + zeta * (1.0 + y3)], axis=-1)


def strains(strip, fields):
    """Green-Lagrange strains and J (columns, levels), by name; F of docs/theory.md."""
    _, _, y1, y3, xi = (strip.carried @ fields).T[:, :, None]
    u1_slope, u3_slope, y1_slope, y3_slope, xi_slope = (strip.slopes @ fields).T[:, :, None]
    z = strip.x3
    zeta, stretch = z + xi * z**2, 1.0 + 2.0 * xi * z
    f11 = 1.0 + u1_slope + zeta * y1_slope + z**2 * xi_slope * y1
    f31 = u3_slope + zeta * y3_slope + z**2 * xi_slope * (1.0 + y3)
    f13, f33 = stretch * y1, stretch * (1.0 + y3)
    return {
        "E11": 0.5 * (f11**2 + f31**2 - 1.0),
        "E33": 0.5 * (f13**2 + f33**2 - 1.0),
        "E13": 0.5 * (f11 * f13 + f31 * f33),
        "J": f11 * f33 - f13 * f31,
    }

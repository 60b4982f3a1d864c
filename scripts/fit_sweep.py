#!/usr/bin/env python3
"""Fits the parameters of a study to a measured history of a probe.

Between the members every value of the history is interpolated by a polynomial in the parameters (in their
logarithms, where they are positive). Its parameters are moved until the history is as near as possible to
the measured one. How much it changes with them says how well they are known: one standard deviation, for
noise that is independent from point to point. That the interpolation is good enough is checked and said.

example:
  fit_sweep.py fit.h5 --data measured.csv --probe tip -o fit.png
"""

import argparse
import csv
import os
from itertools import product

import numpy as np
from matplotlib.ticker import MaxNLocator

from gentbeam_pictures import (
    COLOURS,
    MILLIMETRES,
    STYLE,
    add_picture_options,
    axis_label,
    draw_levels,
    escape,
    picture_path,
    plt,
    save_picture,
    symbol,
)
from gentbeam_results import Parser, ResultsError, run_script, warn
from gentbeam_studies import open_study

DEFAULT_SIZE = (160.0, 70.0)
# Highest degree of the interpolating polynomial; less where the members are too few.
MOST_DEGREE = 5
ROUNDS = 50


def parse_arguments():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "file", metavar="FILE.h5", help="results of a deck with SWEEPs that keeps histories"
    )
    parser.add_argument(
        "--data", required=True, metavar="TABLE", help="two columns: time and value; # comments"
    )
    parser.add_argument("--probe", metavar="NAME", help="the probe that was measured (default: the first)")
    parser.add_argument("--group", metavar="NAME", help="the solution (default: the first with probes)")
    add_picture_options(parser, "width and height in millimetres (default: 160 70)")
    return parser.parse_args()


def main():
    args = parse_arguments()
    path = picture_path(args, os.path.splitext(args.file)[0] + "-fit")
    measured = read_table(args.data)
    with open_study(args.file) as study:
        names, values = study.names, study.values[study.complete]
        histories = []
        for _, group in study.members(args.group):
            history = group.history(args.probe or group.probes[0])
            histories.append(np.interp(measured[:, 0], history.time, history.values))
            if measured[-1, 0] > history.time[-1] * (1 + 1e-9):
                raise ResultsError(
                    f"{args.data}: goes on after the end of the histories, {history.time[-1]:g}"
                )
        labels = (
            axis_label("Time", history.time_unit),
            axis_label(escape(args.probe or group.probes[0]), history.unit),
            history.unit,
        )
    squares = ((np.array(histories) - measured[:, 1]) ** 2).sum(axis=1)
    fit = Fit(values, np.array(histories), measured[:, 1], values[squares.argmin()])
    report(names, values, squares, len(measured), fit)
    if args.csv:
        with open(args.csv, "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(names + ["rms"])
            writer.writerows(
                [*map(repr, map(float, v)), repr(float(np.sqrt(s / len(measured))))]
                for v, s in zip(values, squares)
            )
    with plt.rc_context(STYLE):
        save_picture(
            draw(names, values, squares, histories, measured, fit, labels, args.title, args.size), path
        )


def read_table(path):
    try:
        table = np.loadtxt(path, delimiter="," if "," in open(path).read() else None, ndmin=2)
    except ValueError as error:
        raise ResultsError(f"{path}: {error}") from error
    if table.shape[1] != 2 or len(table) < 3 or not (np.diff(table[:, 0]) > 0).all():
        raise ResultsError(f"{path}: two columns are expected, with increasing times")
    return table


class Fit:
    """The best parameters between the members: .values, .spread, .rms; .misfit of the interpolation."""

    def __init__(self, values, histories, measured, start):
        self.logarithms = (values > 0).all(axis=0)
        self.low, self.high = self.inward(values.min(axis=0)), self.inward(values.max(axis=0))
        if (self.low == self.high).any():
            raise ResultsError("a fit takes members that differ in every parameter")
        x = self.scaled(values)
        self.degree = self.find_degree(x)
        terms = self.terms(x)
        self.coefficients = np.linalg.lstsq(terms, histories, rcond=None)[0]
        self.misfit = np.sqrt(((terms @ self.coefficients - histories) ** 2).mean())
        self.solve(measured, self.scaled(start[None])[0])

    def inward(self, values):
        return np.where(self.logarithms, np.log(np.where(self.logarithms, values, 1.0)), values)

    def scaled(self, values):
        """-1 to 1 from one end of a parameter to the other."""
        return 2.0 * (self.inward(values) - self.low) / (self.high - self.low) - 1.0

    def powers(self):
        return [p for p in product(range(self.degree + 1), repeat=len(self.low)) if sum(p) <= self.degree]

    def terms(self, x):
        return np.column_stack([np.prod(x ** np.array(power), axis=1) for power in self.powers()])

    def find_degree(self, x):
        """The highest for which the members outnumber the coefficients by half, and tell them apart."""
        for self.degree in range(MOST_DEGREE, 0, -1):
            count = len(self.powers())
            if len(x) >= 1.5 * count and np.linalg.matrix_rank(self.terms(x)) == count:
                return self.degree
        raise ResultsError("the members are too few for a fit")

    def solve(self, measured, x):
        """Gauss and Newton's method, within the members."""

        def history(at):
            return self.terms(at[None])[0] @ self.coefficients

        step = 1e-6
        for _ in range(ROUNDS):
            here = history(x)
            slopes = np.array([(history(x + step * one) - here) / step for one in np.eye(len(x))]).T
            change = np.linalg.lstsq(slopes, measured - here, rcond=None)[0]
            moved = np.clip(x + np.clip(change, -0.2, 0.2), -1.0, 1.0)
            if np.abs(moved - x).max() < 1e-9:
                break
            x = moved
        self.at_edge = bool((np.abs(x) >= 1.0).any())
        self.rms = np.sqrt(((measured - history(x)) ** 2).mean())
        variance = self.rms**2 * len(measured) / max(1, len(measured) - len(x))
        self.covariance = variance * np.linalg.pinv(slopes.T @ slopes)  # of the scaled parameters
        self.x, self.values = x, self.unscaled(x)
        spread = np.sqrt(np.diag(self.covariance)) * 0.5 * (self.high - self.low)
        self.spread = np.where(self.logarithms, spread * self.values, spread)

    def unscaled(self, x):
        inward = self.low + 0.5 * (x + 1.0) * (self.high - self.low)
        return np.where(self.logarithms, np.exp(np.where(self.logarithms, inward, 0.0)), inward)

    def distances(self, values, measured):
        """Distance (rms) of the interpolated histories at other parameters."""
        histories = self.terms(self.scaled(values)) @ self.coefficients
        return np.sqrt(((histories - measured) ** 2).mean(axis=1))

    def ellipse(self, count=100):
        """Parameters one standard deviation from the fit (of two)."""
        angle = np.linspace(0.0, 2.0 * np.pi, count)
        root = np.linalg.cholesky(self.covariance[:2, :2] + 1e-18 * np.eye(2))
        return self.unscaled(self.x[:2] + (root @ [np.cos(angle), np.sin(angle)]).T)


def report(names, values, squares, points, fit):
    print("best members: " + ", ".join(names) + ", rms")
    for i in np.argsort(squares, kind="stable")[:5]:
        print(
            "  "
            + "  ".join(f"{value:10.5g}" for value in values[i])
            + f"  {np.sqrt(squares[i] / points):10.4g}"
        )
    print(
        "fit: " + ", ".join(f"{n} = {v:.5g} +- {d:.2g}" for n, v, d in zip(names, fit.values, fit.spread))
    )
    print(
        f"rms distance of the fit {fit.rms:.4g}; interpolated by degree {fit.degree}, "
        f"which is off by {fit.misfit:.2g}"
    )
    if fit.misfit > 0.3 * fit.rms:
        warn(
            "the interpolation between the members is not much better than the fit: "
            "take more members, nearer by"
        )
    if fit.at_edge:
        warn("the fit lies at the edge of the study: widen it")


def draw(names, values, squares, histories, measured, fit, labels, title=None, size=None):
    """Left the distance over the parameters, right the measured history and the best member's."""
    width, height = size or DEFAULT_SIZE
    figure, (left, right) = plt.subplots(
        1, 2, layout="constrained", figsize=(width * MILLIMETRES, height * MILLIMETRES)
    )
    if len(names) == 2:
        draw_map(figure, left, values, measured, fit, labels[2])
        left.set_ylabel(f"${symbol(names[1])}$")
    else:
        left.plot(values[:, 0], np.sqrt(squares / len(measured)), ".", markersize=4, color=COLOURS[2])
        left.set_ylabel(axis_label("Distance of each member, rms", labels[2]))
    left.set_xlabel(f"${symbol(names[0])}$")
    right.plot(*measured.T, ".", markersize=2.5, color="0.6", label="measured")
    right.plot(measured[:, 0], histories[squares.argmin()], color=COLOURS[1], label="best member")
    right.set_xlabel(labels[0])
    right.set_ylabel(labels[1])
    right.xaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 5, 10]))
    right.legend(frameon=False, fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
    if title:
        figure.suptitle(escape(title), fontsize=9)
    return figure


def draw_map(figure, axis, values, measured, fit, unit):
    """The interpolated distance over two parameters, the members, and the fit in its ellipse."""
    ends = np.linspace(-1.0, 1.0, 81)
    grid = fit.unscaled(np.stack(np.meshgrid(ends, ends), axis=-1).reshape(-1, 2))
    shape = (len(ends), len(ends))
    distance = fit.distances(grid, measured[:, 1]).reshape(shape)
    x, y = grid[:, 0].reshape(shape), grid[:, 1].reshape(shape)
    label = axis_label("Distance, rms", unit)
    draw_levels(figure, axis, x, y, distance, label, logarithmic=True, lines=False)
    axis.plot(values[:, 0], values[:, 1], ".", color="white", markersize=1)
    axis.plot(*fit.ellipse().T, color="white")
    axis.plot(*fit.values, "+", color="white")
    axis.set_xlim(values[:, 0].min(), values[:, 0].max())
    axis.set_ylim(values[:, 1].min(), values[:, 1].max())


if __name__ == "__main__":
    run_script(main)

#!/usr/bin/env python3
"""Draws random values of parameters for SWEEP file=: a table with a line of names and a row a member.

NAME=normal:MEAN:SPREAD       NAME=uniform:LOW:HIGH       NAME=lognormal:MEDIAN:SPREAD (of the logarithm)

The same seed gives the same table. Members are spread evenly over the range of every single parameter (a
Latin hypercube), which makes means and spreads of the responses more exact than independent draws would.

example:
  sample_parameters.py -n 10000 --seed 1 E=normal:12000:600 h=uniform:0.95:1.05 -o samples.csv
"""

import argparse
import math
import sys
from statistics import NormalDist

import numpy as np

from gentbeam_results import Parser, ResultsError, run_script

DIGITS = 6


def parse_arguments():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "parameters", nargs="+", metavar="NAME=LAW:A:B", help="a parameter and how it is spread"
    )
    parser.add_argument("-n", "--members", type=int, default=1000, metavar="N", help="rows (default: 1000)")
    parser.add_argument("--seed", type=int, default=1, help="of the random numbers (default: 1)")
    parser.add_argument(
        "-o", "--output", default="-", metavar="FILE", help="the table (default: standard output)"
    )
    return parser.parse_args()


def main():
    args = parse_arguments()
    if args.members < 1:
        raise ResultsError("--members: at least one")
    laws = [parse_law(word) for word in args.parameters]
    table = draw_members([law for _, law in laws], args.members, args.seed)
    with sys.stdout if args.output == "-" else open(args.output, "w") as file:
        print(",".join(name for name, _ in laws), file=file)
        for row in table:
            print(",".join(f"{value:.{DIGITS}g}" for value in row), file=file)


def parse_law(word):
    """A name and the function that turns a probability into the parameter's value."""
    try:
        name, law = word.split("=")
        kind, first, second = law.split(":")
        first, second = float(first), float(second)
    except ValueError:
        raise ResultsError(f"{word}: NAME=LAW:A:B is expected") from None
    if kind == "uniform" and first < second:
        return name, lambda p: first + (second - first) * p
    if kind == "normal" and second > 0:
        return name, np.vectorize(NormalDist(first, second).inv_cdf)
    if kind == "lognormal" and first > 0 and second > 0:
        return name, lambda p: np.exp(np.vectorize(NormalDist(math.log(first), second).inv_cdf)(p))
    raise ResultsError(f"{word}: normal:MEAN:SPREAD, uniform:LOW:HIGH or lognormal:MEDIAN:SPREAD is expected")


def draw_members(laws, members, seed):
    """A row a member; of every parameter each of `members` equally probable parts holds one member."""
    random = np.random.default_rng(seed)
    columns = []
    for law in laws:
        # Away from 0 and 1, which the laws without ends do not have.
        within = random.uniform(0.001, 0.999, members)
        columns.append(law((random.permutation(members) + within) / members))
    return np.column_stack(columns)


if __name__ == "__main__":
    run_script(main)

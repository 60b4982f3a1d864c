#!/usr/bin/env python3
"""Computes the 2D continuum's histories in scripts/data/ that no independent solution is there for.

usage: scripts/paper_make_data.py [elements through the thickness, 8 unless given]

Before that, one history of each example that is there is computed as well: how far the two continua are apart
says how good the new ones are, and goes into their first lines. Takes some ten minutes on two cores.
"""

import concurrent.futures
import sys

import numpy as np

from gentbeam_results import run_script
from paper_continuum import Continuum
from paper_examples import EXAMPLES, Curve, jm_text, read_continuum, write_continuum

CHECKED = {1: 1.0, 2: 1.0, 3: 2.0}
MADE = {1: (2.0, 0.5), 2: (2.0, 0.5), 3: (0.5,)}


def solve(number, jm, across):
    example = EXAMPLES[number - 1]
    continuum = Continuum(example.continuum_strip(jm), across)
    probes = [(q.x, int(q.field == "u3")) for q in example.quantities]
    rows = round(example.end / example.interval) + 1
    values, balance = continuum.history(probes, example.interval, rows)
    time = example.interval * np.arange(rows)
    return {q.name: Curve(time, values[:, i]) for i, q in enumerate(example.quantities)}, balance


def main():
    if len(sys.argv) > 2 or not all(word.isdigit() and int(word) > 0 for word in sys.argv[1:]):
        sys.exit(__doc__.strip())
    across = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    with concurrent.futures.ProcessPoolExecutor() as pool:
        jobs = {
            (number, jm): pool.submit(solve, number, jm, across)
            for number in CHECKED
            for jm in (CHECKED[number], *MADE[number])
        }
        for number, checked in CHECKED.items():
            example = EXAMPLES[number - 1]
            known, solved = read_continuum(example, checked), jobs[number, checked].result()[0]
            apart = ", ".join(
                f"{q.name} {100 * solved[q.name].distance(known[q.name]):.2g} %" for q in example.quantities
            )
            print(f"example {number}, jm = {jm_text(checked)}: apart from the known history by {apart}")
            for jm in MADE[number]:
                histories, balance = jobs[number, jm].result()
                comments = (
                    f"2D continuum, Gent energy, jm = {jm_text(jm)}, made by scripts/paper_make_data.py: "
                    f"{across} biquadratic elements through the thickness, energy balance {balance:.1e}",
                    f"for jm = {jm_text(checked)} apart from the independent history (relative L2) "
                    f"by {apart}",
                )
                write_continuum(example, jm, histories, comments)
                print(f"wrote {example.continuum_file(jm)}")


if __name__ == "__main__":
    run_script(main)

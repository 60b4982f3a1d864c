"""The runs behind the report on the paper (paper_report.py), and the numbers that come out of them."""

import concurrent.futures
import csv
import math
import os
import sys

import gentbeam_runs
from gentbeam_results import ResultsError
from paper_claims import TABLE2
from paper_examples import DATA, EXAMPLES, UNLIMITED, Curve, deck_text, read_continuum, replace

LIMITED = 0.5
MESHES = (4, 8, 12, 16, 20, 24, 28)
TABLE1_MESHES = (2, 4, 6, 8, 10, 20, 40)
SMALL_LOAD = 1e-4
MODES = 6
ROWS_NONE = 10**9  # OUTPUT every=: of the whole beam only the first and the last row


class Runs:
    """All runs of the report, by a key that says what was run; every one is computed once."""

    def __init__(self):
        self._pool = concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1)
        self._jobs = {}
        self._done = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._pool.shutdown(cancel_futures=True)

    def ask(self, key, deck, jm):
        job = self._pool.submit(gentbeam_runs.solve, deck, jm=jm)
        job.add_done_callback(self._count)
        self._jobs[key] = job

    def _count(self, _):
        self._done += 1
        if sys.stderr.isatty():
            print(f"\r{self._done} of {len(self._jobs)} runs", end="", file=sys.stderr, flush=True)

    def wait(self):
        """Until all is done; the first run that fails ends it with what the program said."""
        for key, job in self._jobs.items():
            try:
                job.result()
            except (gentbeam_runs.RunError, OSError, KeyError) as error:
                # The program's words come first, the whole deck last.
                said = " ".join(" ".join(str(error).splitlines()[:3]).split())
                raise ResultsError(f"run {' '.join(map(str, key))}: {said}") from error
        if sys.stderr.isatty():
            print(file=sys.stderr)

    def curves(self, *key):
        """The history of every probe of a transient run."""
        probes = self._jobs[key].result()["transient"].probes
        return {name: Curve(probes["time"], values) for name, values in probes.items() if name != "time"}

    def last(self, *key):
        probes = self._jobs[key].result()["static"].probes
        return {name: float(values[-1]) for name, values in probes.items()}

    def frequencies(self, *key):
        return self._jobs[key].result()["modal"].frequency


def ask_all(runs):
    for example in EXAMPLES:
        number = example.number
        fine = {"elements": example.elements, "step": example.step, "end": example.end, "every": ROWS_NONE}
        # The longest first, so that no core waits for one at the end.
        for jm in sorted(example.family):
            runs.ask(("fine", number, jm), deck_text(example, **fine), jm)
    for example in EXAMPLES:
        number = example.number
        for jm in example.family:
            runs.ask(("deck", number, jm), deck_text(example, every=ROWS_NONE), jm)
        for jm in (UNLIMITED, LIMITED):
            runs.ask(("linear", number, jm), deck_text(example, rule="linear", every=ROWS_NONE), jm)
            runs.ask(("static", number, jm), deck_text(example, static=True), jm)
            small = deck_text(example, static=True, load=SMALL_LOAD)
            runs.ask(("static small", number, jm), small, jm)
        modal = deck_text(example, elements=example.elements)
        modal = replace(modal, r"^TRANSIENT\b.*$", f"MODAL        count={MODES}", example.deck)
        for jm in (UNLIMITED, 2.0):
            runs.ask(("modal", number, jm), modal, jm)
    first, second = EXAMPLES[:2]
    small = deck_text(first, load=SMALL_LOAD, every=ROWS_NONE, step=first.step)
    runs.ask(("small", 1, UNLIMITED), small, UNLIMITED)
    for jm in (UNLIMITED, LIMITED):
        for elements in TABLE1_MESHES:
            deck = deck_text(first, elements=elements, every=ROWS_NONE)
            runs.ask(("mesh", 1, jm, 3, elements), deck, jm)
    for jm in TABLE2:
        for nodes in (2, 3):
            for elements in MESHES:
                deck = deck_text(second, elements=elements, nodes=nodes, every=ROWS_NONE)
                runs.ask(("mesh", 2, jm, nodes, elements), deck, jm)


class Results:
    """Our curves beside the continuum's, and the numbers the report states."""

    def __init__(self, runs):
        self.runs = runs
        self.continuum = {
            (example.number, jm): read_continuum(example, jm)
            for example in EXAMPLES
            for jm in example.family
        }

    def history(self, kind, example, jm, name):
        """Of "deck", "fine" or "linear" runs, or the "continuum"; over the time that the deck asks for."""
        if kind == "continuum":
            curve = self.continuum[example.number, jm][name]
        else:
            curve = self.runs.curves(kind, example.number, jm)[name]
        return curve.until(self.end(example))

    def end(self, example):
        return self.runs.curves("deck", example.number, UNLIMITED)[example.quantities[0].name].time[-1]

    def largest(self, kind, example, jm, name):
        """The largest displacement, on the side to which the continuum without limit moves furthest."""
        side = math.copysign(1.0, self.history("continuum", example, UNLIMITED, name).extreme()[0])
        return self.history(kind, example, jm, name).extreme(side)[0]

    def reduction(self, kind, example, name, jm=LIMITED):
        """By how many per cent the largest displacement is smaller than without limit of the chains."""
        limited, unlimited = (self.largest(kind, example, value, name) for value in (jm, UNLIMITED))
        return 100.0 * (1.0 - limited / unlimited)

    def first_swing(self, kind, example, name):
        """The same of the first swing: the first extreme that reaches nine tenths of the largest."""
        limited, unlimited = (
            abs(first_swing(self.history(kind, example, value, name))) for value in (LIMITED, UNLIMITED)
        )
        return 100.0 * (1.0 - limited / unlimited)

    def static_reduction(self, kind, example, name):
        limited, unlimited = (self.runs.last(kind, example.number, jm)[name] for jm in (LIMITED, UNLIMITED))
        return 100.0 * (1.0 - limited / unlimited)

    def distance(self, kind, example, jm, name):
        """Relative L2 difference from the continuum's history, in per cent."""
        theirs = self.history("continuum", example, jm, name)
        return 100.0 * self.history(kind, example, jm, name).distance(theirs)

    def mesh_values(self, number, jm, nodes, meshes, name, at_end=False):
        """The largest deflection, or that at the end, relative to the finest mesh."""
        found = []
        for elements in meshes:
            curve = self.runs.curves("mesh", number, jm, nodes, elements)[name]
            found.append(curve.values[-1] if at_end else curve.extreme()[0])
        return [value / found[-1] for value in found]


def first_swing(curve):
    sizes = abs(curve.values)
    high = int((sizes >= 0.9 * sizes.max()).argmax())
    stop = high
    while stop + 1 < len(sizes) and sizes[stop + 1] >= 0.9 * sizes.max():
        stop += 1
    return Curve(curve.time[high - 1 : stop + 2], curve.values[high - 1 : stop + 2]).extreme()[0]


def small_load_law(example, jm):
    return 100.0 * (1.0 - example.modulus(UNLIMITED) / example.modulus(jm))


def read_frequencies():
    with open(DATA / "continuum_frequencies.csv", newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(line for line in stream if not line.startswith("#")))[1:]
    return {(int(row[0]), float(row[1])): [float(word) for word in row[2:]] for row in rows}

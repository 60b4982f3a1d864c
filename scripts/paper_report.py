#!/usr/bin/env python3
"""Runs the paper's three examples and writes the report on its figures and tables for
scripts/reproduce_paper.

The program is the one the environment variable GENTBEAM names, else build/release/gentbeam.
"""

import argparse
import concurrent.futures
import csv
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

import gentbeam_runs
import paper_pictures
from gentbeam_results import Parser, ResultsError, run_script
from paper_examples import (
    DATA,
    EXAMPLES,
    ROOT,
    UNLIMITED,
    Curve,
    deck_text,
    jm_text,
    read_continuum,
    replace,
)
from paper_page import Page

LIMITED = 0.5
MESHES = (4, 8, 12, 16, 20, 24, 28)
TABLE1_MESHES = (2, 4, 6, 8, 10, 20, 40)
# The paper's Table 2, by jm.
TABLE2 = {
    0.5: (0.8073549, 0.9345453, 0.9595087, 0.9787287, 0.9913640, 1.0, 1.0),
    1.0: (0.8676084, 0.9241677, 0.9408307, 0.9681008, 0.9870096, 1.0, 1.0),
    2.0: (0.8455928, 0.8644630, 0.8922715, 0.9435270, 0.9764234, 1.0, 1.0),
    3.0: (0.7561741, 0.7701017, 0.8343928, 0.9099674, 0.9656469, 1.0, 1.0),
    UNLIMITED: (1.7662481, 1.7899937, 1.8854212, 1.3762555, 1.1042929, 1.0, 1.0),
}
# By how many per cent the paper finds the largest deflection smaller for jm = 0.5 than for 1e20, by example.
CLAIMS = {1: 27.0, 2: 23.0}
# Example 1 with linear resultants (Bathe, Ramm and Wilson's model), converged: (time, tip deflection / L).
LINEAR_RESULTANTS = ((2.698e-3, 0.6016), (5.343e-3, -0.0103))
SMALL_LOAD = 1e-4
MODES = 6
ROWS_NONE = 10**9  # OUTPUT every=: of the whole beam only the first and the last row

JM = "<i>J</i><sub>m</sub>"
FIELDS = {"u1": "<i>u</i><sub>1</sub>", "u3": "<i>u</i><sub>3</sub>"}
X1 = "<i>X</i><sub>1</sub>"
DASH = "–"


# ---- runs


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


# ---- what comes out of them


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


# ---- words


def percent(value, digits=1):
    return f"{value:.{digits}f} %"


def signed_percent(value, digits=2):
    rounded = round(value, digits)
    return f"{'−' if rounded < 0 else '+' if rounded > 0 else ''}{abs(rounded):.{digits}f} %"


def number(value, digits):
    return f"{value:.{digits}f}".replace("-", "−")


def jm_word(jm):
    return "∞" if jm >= UNLIMITED else jm_text(jm)


def jm_is(jm):
    return f"{JM} = {jm_word(jm)}"


def quantity_word(quantity):
    return f"{FIELDS[quantity.field]} at {X1} = {quantity.x:g}"


def ylabel(example, quantity):
    field = paper_pictures.symbol(quantity.field)
    return f"${field}/L$ at the tip" if example.number == 1 else f"${field}$ at $X_1 = {quantity.x:g}$"


# ---- the report


def main():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "results" / "paper", metavar="FOLDER")
    parser.add_argument("--docs", action="store_true", help="write docs/paper.md and its pictures, too")
    args = parser.parse_args()
    version = program_version()
    pictures = args.output / "pictures"
    decks = args.output / "decks"
    for folder in (pictures, decks):
        folder.mkdir(parents=True, exist_ok=True)
    for example in EXAMPLES:
        (decks / example.deck).write_text(deck_text(example), encoding="utf-8")
    with Runs() as runs:
        ask_all(runs)
        print("runs of gentbeam", flush=True)
        runs.wait()
        print("pictures", flush=True)
        page = report(Results(runs), pictures)
    path = args.output / "paper.html"
    footer = f"{version}; made by <code>scripts/reproduce_paper</code>."
    path.write_text(page.html(footer), encoding="utf-8")
    print(f"wrote {path}")
    if args.docs:
        write_docs(page)


def program_version():
    program = gentbeam_runs.program()
    try:
        done = subprocess.run([program, "--version"], capture_output=True, text=True, check=False)
    except OSError as error:
        raise ResultsError(f"cannot run {program}: {error.strerror}") from error
    if done.returncode != 0:
        raise ResultsError(f"{program} --version: exit status {done.returncode}")
    return done.stdout.splitlines()[0].strip()


def write_docs(page):
    folder = ROOT / "docs" / "pictures"
    folder.mkdir(parents=True, exist_ok=True)
    for block in page.blocks:
        if block[0] == "figure":
            shutil.copy(block[1], folder / block[1].name)
    path = ROOT / "docs" / "paper.md"
    origin = "This page is written by `scripts/reproduce_paper --docs`, with every number in it."
    path.write_text(f"{page.markdown('pictures')}\n{origin}\n", encoding="utf-8")
    print(f"wrote {path}")


def report(results, pictures):
    page = Page("The paper’s examples, computed again")
    introduce(page, results, pictures)
    for write in (write_example_1, write_example_2, write_example_3):
        write(page, results, pictures)
    write_tables(page, results, pictures)
    write_methods(page, results)
    return page


def introduce(page, results, pictures):
    first, second = EXAMPLES[:2]
    tip, at_a = first.quantities[0].name, second.quantities[0].name
    deck = {e.number: results.reduction("deck", e, n) for e, n in ((first, tip), (second, at_a))}
    solid = {e.number: results.reduction("continuum", e, n) for e, n in ((first, tip), (second, at_a))}
    page.paragraph(
        f"""N. Firouzi’s paper “Nonlinear Dynamic Large Deformation Analysis of Hyperelastic Beams Based
        on the Gent Constitutive Model” shows three beams under sudden loads, for several limits {JM} of
        how far the material’s chains stretch. This report runs all three with gentbeam and sets every
        figure and table beside what the paper says of it and beside a two-dimensional continuum of the
        same material, which makes no beam assumption."""
    )
    force = second.quantities[1].name
    page.paragraph(
        f"""<b>What comes out.</b> The paper’s conclusion holds: a smaller {JM} makes a stiffer beam. In
        example 1, {jm_is(LIMITED)} makes the largest tip deflection {percent(deck[1])} smaller (the
        continuum: {percent(solid[1])}), where the paper says {CLAIMS[1]:.0f} %; the static deflection
        under the same load is {percent(results.static_reduction("static", first, tip))} smaller. In
        example 2 the paper’s {CLAIMS[2]:.0f} % at its point A compares with {percent(deck[2])} (continuum
        {percent(solid[2])}) in the middle of the loaded span and with
        {percent(results.reduction("deck", second, force))}
        ({percent(results.reduction("continuum", second, force))}) under the force in the other span. The
        mesh sensitivity of the paper’s Table 2 is not that of our elements, which need no such meshes."""
    )
    page.heading(2, "The claims at a glance")
    page.table(
        ("The paper’s claim", "The paper", "gentbeam", "gentbeam, fine", "2D continuum"),
        claim_rows(results),
        f"""“gentbeam” is the deck in <code>input/</code>, with its mesh and step; “fine” has more
        elements and a step ten times shorter (in <a href="#how-it-was-computed">How it was computed</a>).
        The largest deflection is the largest within the time that the deck runs for. The continuum’s
        values for {jm_is(LIMITED)} and for {jm_is(UNLIMITED)} come from two codes, which differ by less
        than one per cent of a history in these examples.""",
    )
    panels = [stiffening_panel(results, e, n) for e, n in ((first, tip), (second, at_a))]
    page.figure(
        paper_pictures.draw_stiffening(pictures, "paper_stiffening", panels),
        f"""How much smaller the largest deflection is than with {jm_is(UNLIMITED)}. The grey curve is no
        dynamics at all: the small-strain modulus <i>E</i><sub>eff</sub> already depends on {JM} through
        λ<sub>eff</sub> = <i>c</i> + 2μ/{JM}, and that alone gives
        {percent(small_load_law(first, LIMITED))} and {percent(small_load_law(second, LIMITED))} for
        {jm_is(LIMITED)}. Example 2 is shown for {X1} = 3.""",
    )


def claim_rows(results):
    first, second = EXAMPLES[:2]
    tip, at_a = first.quantities[0].name, second.quantities[0].name
    rows = []
    for example, name, words in (
        (first, tip, "Example 1, largest tip deflection"),
        (second, at_a, f"Example 2, largest deflection at A, {X1} = 3"),
        (second, second.quantities[1].name, f"Example 2, the same if A is {X1} = 9"),
    ):
        found = [results.reduction(kind, example, name) for kind in ("deck", "fine", "continuum")]
        words += f": {jm_is(LIMITED)} against ∞, smaller by"
        rows.append((words, f"{CLAIMS[example.number]:.0f} %", *map(percent, found)))
    ten = results.mesh_values(1, UNLIMITED, 3, TABLE1_MESHES, tip)[TABLE1_MESHES.index(10)]
    rows.append(
        (
            "Example 1: ten elements suffice; change from ten to forty",
            DASH,
            signed_percent(100 * (1 - ten)),
            DASH,
            DASH,
        )
    )
    four = results.mesh_values(2, UNLIMITED, 3, MESHES, at_a)[0]
    rows.append(
        (
            f"Example 2, Table 2: four elements against the finest mesh, {jm_is(UNLIMITED)}",
            signed_percent(100 * (TABLE2[UNLIMITED][0] - 1), 1),
            signed_percent(100 * (four - 1), 1),
            DASH,
            DASH,
        )
    )
    return rows


def stiffening_panel(results, example, name):
    limits = [jm for jm in example.family if jm < UNLIMITED]
    law = [0.5 * 20.0 ** (i / 60) for i in range(61)]
    return (
        f"Example {example.number}",
        (law, [small_load_law(example, jm) for jm in law]),
        (limits, [results.reduction("fine", example, name, jm) for jm in limits]),
        (limits, [results.reduction("continuum", example, name, jm) for jm in limits]),
        ([LIMITED], [CLAIMS[example.number]]),
    )


def write_readings(page, results, example, name, where):
    """What "smaller by" comes to, by what is compared."""
    rows = [
        (
            "small static load, closed form 1 − <i>E</i>/<i>E</i><sub>eff</sub>",
            small_load_law(example, LIMITED),
            None,
        ),
        ("small static load", results.static_reduction("static small", example, name), None),
        ("full static load", results.static_reduction("static", example, name), None),
        (
            "first swing",
            results.first_swing("fine", example, name),
            results.first_swing("continuum", example, name),
        ),
        (
            "largest deflection, fine",
            results.reduction("fine", example, name),
            results.reduction("continuum", example, name),
        ),
        ("largest deflection, deck", results.reduction("deck", example, name), None),
        (
            "largest deflection, deck with the paper’s linear resultants (<code>rule=linear</code>)",
            results.reduction("linear", example, name),
            None,
        ),
    ]
    page.table(
        ("What is compared", "Smaller by", "2D continuum"),
        [(words, percent(ours), DASH if solid is None else percent(solid)) for words, ours, solid in rows],
        f"""{where}, {jm_is(LIMITED)} against {jm_is(UNLIMITED)}. The paper claims
        {CLAIMS[example.number]:.0f} %.""",
    )


def write_comparison(page, results, example, quantities):
    """The largest deflection of every member of the family, ours and the continuum's."""
    rows = []
    digits = 4 if example.number == 1 else 5
    for quantity in quantities:
        for jm in example.family:
            values = [
                results.largest(kind, example, jm, quantity.name) / example.length
                for kind in ("deck", "fine", "continuum")
            ]
            rows.append(
                (
                    quantity_word(quantity) if jm == example.family[0] else "",
                    jm_word(jm),
                    *(number(value, digits) for value in values),
                    signed_percent(100.0 * (values[1] / values[2] - 1.0)),
                    percent(results.distance("fine", example, jm, quantity.name)),
                )
            )
    per_length = ", divided by <i>L</i>" if example.number == 1 else ""
    page.table(
        (
            "Displacement",
            JM,
            "gentbeam",
            "gentbeam, fine",
            "2D continuum",
            "Fine against continuum",
            "History apart",
        ),
        rows,
        f"""Largest displacement up to <i>t</i> = {results.end(example):g} s{per_length}. “History apart”
        is the relative L2 difference of the whole history between gentbeam, fine, and the continuum.""",
    )


def draw_figure(results, pictures, example, quantity, name):
    def curves(kind):
        found = {jm: results.history(kind, example, jm, quantity.name) for jm in example.family}
        return {jm: Curve(curve.time, curve.values / example.length) for jm, curve in found.items()}

    return paper_pictures.draw_family(
        pictures,
        name,
        example.family,
        curves("deck"),
        curves("fine"),
        curves("continuum"),
        ylabel(example, quantity),
        "s",
    )


def draw_shapes(pictures, example):
    """The deck's own run, drawn with its supports."""
    folder = pictures / "runs"
    folder.mkdir(exist_ok=True)
    stem = folder / f"example_{example.number}"
    stem.with_suffix(".inp").write_text(deck_text(example), encoding="utf-8")
    path = pictures / f"paper_example_{example.number}.png"
    commands = (
        (gentbeam_runs.program(), "-q", "-o", str(stem), str(stem.with_suffix(".inp"))),
        (
            sys.executable,
            str(ROOT / "scripts" / "plot_shapes.py"),
            str(stem.with_suffix(".h5")),
            "--times",
            *SHAPE_TIMES[example.number],
            "--size",
            *SHAPE_SIZES[example.number],
            "-o",
            str(path),
        ),
    )
    for command in commands:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ResultsError(f"{Path(command[0]).name}: {' '.join(done.stderr.split())}")
    shutil.rmtree(folder)
    return path


SHAPE_TIMES = {1: ("0", "6.75e-4", "1.35e-3", "2.7e-3"), 2: ("0", "2e-3"), 3: ("0", "8e-3")}
SHAPE_SIZES = {1: ("150", "85"), 2: ("150", "45"), 3: ("150", "45")}


def write_example_1(page, results, pictures):
    example = EXAMPLES[0]
    tip = example.quantities[0]
    page.heading(2, f"Example 1: {example.title.lower()}")
    page.paragraph(
        f"""Clamped at {X1} = 0, <i>L</i> = 10 in, <i>b</i> = <i>h</i> = 1 in, <i>E</i> = 12000 psi, ν =
        0.2, ρ = 10<sup>−6</sup> lb s²/in<sup>4</sup>; 2.85 lb/in from <i>t</i> = 0 on, dead. Ten elements
        of three nodes, a hundred steps of 1.35·10<sup>−4</sup> s of Newmark’s scheme. The paper prints
        <i>c</i> = 2500 beside moduli in MPa; it is 2500 psi, <i>E</i>ν/(1−ν²)."""
    )
    page.figure(draw_shapes(pictures, example), "Example 1, first swing, to scale.")

    page.heading(3, "Figure 3: the tip without limit of the chains")
    deck = scaled(results.history("deck", example, UNLIMITED, tip.name), 1.0 / example.length)
    fine = scaled(results.history("fine", example, UNLIMITED, tip.name), 1.0 / example.length)
    solid = scaled(results.history("continuum", example, UNLIMITED, tip.name), 1.0 / example.length)
    small = results.runs.curves("small", 1, UNLIMITED)[tip.name]
    small = scaled(small, 1.0 / (SMALL_LOAD * example.length))
    page.figure(
        paper_pictures.draw_validation(
            pictures, "paper_figure_3", deck, small, solid, LINEAR_RESULTANTS, ylabel(example, tip), "s"
        ),
        f"""Figure 3: tip deflection, {jm_is(UNLIMITED)}. Grey: the same beam under a ten-thousandth of
        the load, times ten thousand. Circles: the first extremes of a beam with linear resultants,
        converged, from another code.""",
    )
    linear = results.history("linear", example, UNLIMITED, tip.name).extreme()[0] / example.length
    first = first_swing(fine)
    period = 2.0 * math.pi / read_frequencies()[1, UNLIMITED][0]
    page.paragraph(
        f"""The example is that of Bathe, Ramm and Wilson, whose cantilever is linear elastic; what else
        the paper’s figure 3 draws is not recorded in this project. The first swing reaches
        {number(first, 4)} <i>L</i> (fine), the continuum’s {number(first_swing(solid), 4)}, the beam with
        linear resultants {LINEAR_RESULTANTS[0][1]:.4f}; over the whole time the deck’s largest is
        {number(deck.extreme()[0], 4)}, and {number(linear, 4)} with <code>rule=linear</code>. Deck and
        continuum are {percent(100 * deck.distance(solid))} apart, the fine run
        {percent(100 * fine.distance(solid))}: half of the deck’s difference is its time step. Large
        rotations keep the tip well below the {number(small.extreme()[0], 3)} <i>L</i> of small
        displacements, and make it return earlier than after the linear period of {period * 1e3:.2f} ms."""
    )

    page.heading(3, f"Figure 4: the tip for several {JM}")
    page.figure(
        draw_figure(results, pictures, example, tip, "paper_figure_4"),
        f"""Figure 4: tip deflection for several {JM}; below, the softest and the stiffest beside the
        continuum.""",
    )
    page.paragraph(
        f"""The paper says: {jm_is(LIMITED)} swings about {CLAIMS[1]:.0f} % less far than
        {jm_is(UNLIMITED)}. Ours: {percent(results.reduction("deck", example, tip.name))}; the continuum:
        {percent(results.reduction("continuum", example, tip.name))}. The table shows what the number
        depends on: under small static loads the reduction is the change of modulus, and large rotations,
        which hold back the softer beam more, take some of it away, in the motion more than at rest,
        because it swings further. Of the readings in the table, the full static load comes nearest to the
        paper’s number; in example 2 it does not, so it need not be what the paper compared. A sentence of
        section 5.1 has the order the wrong way round ({JM} = 10<sup>20</sup> deflecting less); the
        paper’s own conclusion and all results here say that smaller {JM} is stiffer."""
    )
    write_readings(page, results, example, tip.name, "Example 1, tip")
    write_comparison(page, results, example, (tip,))


def scaled(curve, factor):
    return Curve(curve.time, factor * curve.values)


def write_example_2(page, results, pictures):
    example = EXAMPLES[1]
    at_a, at_b, along = example.quantities[:3]
    page.heading(2, f"Example 2: {example.title.lower()}")
    page.paragraph(
        f"""<i>L</i> = 12, <i>b</i> = <i>h</i> = 1, <i>E</i> = 14000, ν = 0.3, ρ = 10<sup>−4</sup> in any
        consistent units. Pinned at {X1} = 0 and 6, clamped at 12; −20 a length on 0 to 4 and −6.67 at 9,
        both sudden. The deck has 24 elements and steps of 10<sup>−4</sup>. Which point the paper calls A,
        and what each of its figures 6 to 8 shows, is not recorded in this project: we take A as the
        middle of the first span, {X1} = 3, and follow the three displacements below."""
    )
    page.figure(
        draw_shapes(pictures, example), "Example 2 at rest and near its first largest deflection, to scale."
    )
    captions = {
        at_a.name: "deflection in the middle of the first span (A)",
        at_b.name: "deflection under the force in the second span",
        along.name: "displacement along the beam in the middle of the first span",
    }
    write_family_figures(page, results, pictures, example, captions)
    at_9, solid_9 = (results.reduction(kind, example, at_b.name) for kind in ("deck", "continuum"))
    at_2, at_4 = (results.reduction("deck", example, q.name) for q in example.quantities[3:5])
    solid_2, solid_4 = (results.reduction("continuum", example, q.name) for q in example.quantities[3:5])
    page.paragraph(
        f"""The paper says: {CLAIMS[2]:.0f} % smaller at A for {jm_is(LIMITED)}. Ours:
        {percent(results.reduction("deck", example, at_a.name))}; the continuum:
        {percent(results.reduction("continuum", example, at_a.name))}. Were A at {X1} = 2 or 4, ours would
        be {percent(at_2)} or {percent(at_4)} and the continuum’s {percent(solid_2)} or
        {percent(solid_4)}. Under the force, at {X1} = 9, they are {percent(at_9)} and {percent(solid_9)}:
        of the four places tried, this is the nearest to the paper’s number. Whether it is the paper’s A
        we cannot tell. In the loaded span the reduction is less than the modulus alone would make it
        ({percent(small_load_law(example, LIMITED))}), because a span six thicknesses long bends and
        shears, and the shear modulus does not depend on {JM}."""
    )
    write_readings(page, results, example, at_a.name, "Example 2, A")
    write_comparison(page, results, example, (at_a, at_b, along))
    page.paragraph(
        f"""The deflections follow the continuum. The displacement {quantity_word(along)}, two orders
        smaller, is a second-order effect of the bending in a span held at both ends; its first swings
        agree, later ones lose the continuum’s phase, for small {JM} first."""
    )


def write_example_3(page, results, pictures):
    example = EXAMPLES[2]
    span, middle, end, along = example.quantities
    page.heading(2, f"Example 3: {example.title.lower()}")
    page.paragraph(
        f"""As example 2 but ρ = 4·10<sup>−4</sup>; clamped at {X1} = 0, pinned at 4, on a roller at 8,
        and at 12 a slide that holds the rotation; −50 a length on 0 to 4, −50 at 6, −16.67 at 12, all
        sudden. The deck has 24 elements and steps of 2·10<sup>−4</sup>. What each of the paper’s figures
        10 to 13 shows is not recorded in this project, nor is a claim about their sizes: we follow the
        four displacements below."""
    )
    page.figure(
        draw_shapes(pictures, example), "Example 3 at rest and near its first largest deflection, to scale."
    )
    captions = {
        span.name: "deflection in the middle of the first span",
        middle.name: "deflection under the force in the second span",
        end.name: "deflection of the sliding end",
        along.name: "displacement along the beam at the roller",
    }
    write_family_figures(page, results, pictures, example, captions)
    write_comparison(page, results, example, example.quantities)

    def mean(quantity, kind):
        return float(results.history(kind, example, UNLIMITED, quantity.name).values.mean())

    deck_step = float(deck_number(example, "step"))
    steps = 2.0 * math.pi / read_frequencies()[3, UNLIMITED][4] / deck_step
    page.paragraph(
        f"""The sliding end, which carries the slow first mode, meets the continuum to
        {percent(results.distance("fine", example, UNLIMITED, end.name))} for {jm_is(UNLIMITED)}. In the
        stiff inner spans many fast modes take part, and there the histories drift apart: a mode whose
        frequency is half a per cent off has lost a good part of a radian at the end of the window (next
        table). The position about which the spans swing differs, too: on average
        {number(mean(span, "fine"), 4)} against the continuum’s {number(mean(span, "continuum"), 4)} at
        {X1} = 2 and {number(mean(middle, "fine"), 4)} against {number(mean(middle, "continuum"), 4)} at
        6, for {jm_is(UNLIMITED)}. The spans are four thicknesses long, where supports and point forces
        are felt over all of a span: this is the beam model’s error, for a finer mesh keeps it. The deck’s
        own step, some {steps:.0f} to a period of the fifth mode, adds to it: use a shorter one where the
        inner spans matter."""
    )
    write_frequencies(page, results)


def write_family_figures(page, results, pictures, example, captions):
    for quantity in example.quantities:
        if not quantity.figure:
            continue
        page.heading(3, f"Figure {quantity.figure}: {captions[quantity.name]}")
        picture = draw_figure(results, pictures, example, quantity, f"paper_figure_{quantity.figure}")
        worst = max(results.distance("fine", example, jm, quantity.name) for jm in example.family)
        least = min(results.distance("fine", example, jm, quantity.name) for jm in example.family)
        page.figure(
            picture,
            f"""Figure {quantity.figure}: {quantity_word(quantity)} for several {JM}; below, the softest
            and the stiffest beside the continuum. {jm_is(LIMITED)} against {jm_is(UNLIMITED)}: the
            largest displacement is {change_word(results.reduction("deck", example, quantity.name))}
            (deck), {change_word(results.reduction("continuum", example, quantity.name))} (continuum). The
            fine histories are {percent(least)} to {percent(worst)} (relative L2) from the continuum’s
            over the family.""",
        )


def change_word(reduction):
    return f"{percent(abs(reduction))} {'smaller' if reduction >= 0 else 'larger'}"


def read_frequencies():
    with open(DATA / "continuum_frequencies.csv", newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(line for line in stream if not line.startswith("#")))[1:]
    return {(int(row[0]), float(row[1])): [float(word) for word in row[2:]] for row in rows}


def write_frequencies(page, results):
    rows = []
    for (case, jm), solid in read_frequencies().items():
        solid = np.array(solid)
        ours = 2.0 * math.pi * results.runs.frequencies("modal", case, jm)[:MODES]
        apart = [signed_percent(100.0 * (a / b - 1.0)) for a, b in zip(ours, solid)]
        end = EXAMPLES[case - 1].end
        drift = max(abs(ours - solid)[:4]) * end
        rows.append((case, jm_word(jm), *apart, f"{drift:.1f}"))
    page.table(
        ("Example", JM, *(f"ω<sub>{i + 1}</sub>" for i in range(MODES)), "Drift (rad)"),
        rows,
        f"""Natural frequencies about the undeformed state: gentbeam (fine mesh) against the continuum.
        The last column is the largest phase that one of the first four loses or gains over the
        continuum’s window ({EXAMPLES[0].end:g}, {EXAMPLES[1].end:g} and {EXAMPLES[2].end:g} s).""",
    )


def write_tables(page, results, pictures):
    first, second = EXAMPLES[:2]
    tip, at_a = first.quantities[0].name, second.quantities[0].name
    page.heading(2, "Tables 1 and 2: sensitivity to the mesh")
    page.paragraph(
        """What the paper’s Table 1 holds is not recorded in this project; its text says of example 1 that
        ten elements suffice. Here is example 1 on meshes of two to forty elements (largest tip
        deflection, relative to the finest)."""
    )
    rows = []
    for jm in (UNLIMITED, LIMITED):
        values = results.mesh_values(1, jm, 3, TABLE1_MESHES, tip)
        rows.append((jm_word(jm), *(f"{value:.5f}" for value in values)))
    page.table(
        (JM, *map(str, TABLE1_MESHES)),
        rows,
        "In place of Table 1: example 1, elements of three nodes, by their number.",
    )
    page.paragraph("Ten suffice, and so do four.")
    page.heading(3, "Table 2: example 2")
    rows = []
    ours, at_end, two_nodes = {}, {}, {}
    for jm, paper in TABLE2.items():
        ours[jm] = results.mesh_values(2, jm, 3, MESHES, at_a)
        at_end[jm] = results.mesh_values(2, jm, 3, MESHES, at_a, at_end=True)
        two_nodes[jm] = results.mesh_values(2, jm, 2, MESHES, at_a)
        for source, values in (
            ("the paper", paper),
            ("ours, largest", ours[jm]),
            ("ours, at the end", at_end[jm]),
            ("ours, largest, 2 nodes", two_nodes[jm]),
        ):
            rows.append((jm_word(jm) if source == "the paper" else "", source, *(f"{v:.4f}" for v in values)))
    page.table(
        (JM, "Source", *map(str, MESHES)),
        rows,
        f"""Table 2: deflection at A by the number of elements, divided by that of the finest mesh, as in
        the paper. “Largest” is the largest up to <i>t</i> = {results.end(second):g}, “at the end” the
        deflection at that instant; elements have three nodes unless said otherwise.""",
    )
    panels = (("The paper", TABLE2), ("gentbeam, largest", ours), ("gentbeam, at the end", at_end))
    page.figure(
        paper_pictures.draw_mesh(
            pictures, "paper_table_2", MESHES, panels, tuple(sorted(TABLE2, reverse=True))
        ),
        "Table 2 as a picture: the paper’s numbers, and ours in two readings.",
    )
    spread = max(abs(row[0] - 1.0) for row in ours.values())
    page.paragraph(
        f"""The paper’s numbers need 24 elements to settle, and those for {jm_is(UNLIMITED)} overshoot by
        up to {percent(100 * (max(TABLE2[UNLIMITED]) - 1), 0)} before they do. The largest deflection of
        our three-node elements is within {percent(100 * spread)} of the finest mesh from four elements
        on. Which quantity the paper’s table holds is not recorded here. A deflection at a fixed instant
        depends more on the mesh, because the frequencies do, and it may err to both sides: for
        {jm_is(LIMITED)} and the end of the window our four elements give {number(at_end[LIMITED][0], 2)}
        and eight {number(at_end[LIMITED][1], 2)}, near the paper’s {TABLE2[LIMITED][0]:.2f} and
        {TABLE2[LIMITED][1]:.2f}; for the other {JM} ours settle sooner. Elements of two nodes need a
        finer mesh for the largest deflection too ({number(two_nodes[LIMITED][0], 2)} and
        {number(two_nodes[LIMITED][1], 2)}). The paper’s row for {jm_is(UNLIMITED)} comes out in none of
        these readings."""
    )


def write_methods(page, results):
    page.heading(2, "How it was computed")
    rows = []
    for example in EXAMPLES:
        elements, step = (deck_number(example, key) for key in ("elements", "step"))
        rows.append(
            (
                f"{example.number}, <code>input/{example.deck}</code>",
                elements,
                f"{float(step):g}",
                f"{results.end(example):g}",
                example.elements,
                f"{example.step:g}",
            )
        )
    page.table(
        ("Example", "Elements", "Step", "End", "Elements, fine", "Step, fine"),
        rows,
        """Newmark’s scheme with β = 1/4 and γ = 1/2, as in the paper; elements of three nodes with
        reduced integration; Gauss points through the thickness; inertia <code>diagonal</code>.""",
    )
    page.paragraph(
        """<b>The paper’s formulas</b> carry misprints (Gent’s energy, the sign and factor of the
        volumetric stress, traces printed as determinants, and others). gentbeam computes with the
        corrected forms; as printed, the undeformed beam would not be free of stress."""
    )
    page.paragraph(
        f"""<b>The 2D continuum</b> is a strip of biquadratic quadrilaterals with the same Gent energy,
        dead loads spread evenly through the thickness, and supports that hold the mean displacement of
        their section. Its histories are in <code>scripts/data/</code>: those for {JM} = 2 and 0.5 in
        examples 1 and 2 and for 0.5 in example 3 come from <code>scripts/paper_make_data.py</code>, all
        others from an independent code. The two meet, on histories that both computed, to
        {continuum_check(1)} (example 1), {continuum_check(2)} (example 2) and {continuum_check(3)}
        (example 3; relative L2, by displacement)."""
    )
    page.paragraph(
        """<b>To run it again:</b> <code>scripts/reproduce_paper</code>. The decks of the three examples,
        with all probes, are written beside the report; the other runs change one or two of their numbers."""
    )


def deck_number(example, key):
    return re.search(rf"\b{key}=(\S+)", deck_text(example)).group(1)


def continuum_check(case):
    """How far the two continua are apart, as the second line of the data made here says."""
    path = EXAMPLES[case - 1].continuum_file(LIMITED)
    found = [float(word) for word in re.findall(r"(\S+) %", path.read_text(encoding="utf-8").split("\n")[1])]
    if not found:
        raise ResultsError(f"{path}: its second line does not say how far it is from the known history")
    return f"{min(found):g} to {max(found):g} %"


if __name__ == "__main__":
    run_script(main)

"""The chapters of the report on the paper (paper_report.py): its three examples."""

import math
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

import gentbeam_runs
import paper_pictures
from gentbeam_results import ResultsError
from paper_claims import CLAIMS, LINEAR_RESULTANTS
from paper_examples import EXAMPLES, ROOT, UNLIMITED, Curve, deck_number, deck_text
from paper_runs import LIMITED, MODES, SMALL_LOAD, first_swing, read_frequencies, small_load_law
from paper_words import (
    DASH,
    JM,
    X1,
    change_word,
    jm_is,
    jm_word,
    number,
    percent,
    quantity_word,
    signed_percent,
    ylabel,
)

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


def scaled(curve, factor):
    return Curve(curve.time, factor * curve.values)

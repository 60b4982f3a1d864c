"""Writes docs/work-precision.md: which setting to use at which error, from the runs of the charts."""

LIMITS = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
PEER_LIMITS = (1e-2, 1e-3)
# A numerical error of this part of the model's changes the total by some five per cent, adding as squares.
WASTED = 1.0 / 3.0
# Other models than gauss 3 and more, and not better ones (docs/model-error.md): drawn, not recommended.
NOT_RECOMMENDED = ("gauss 2", "linear")

INTRODUCTION = """\
# Work and precision

Which scheme, mesh, element and step is the cheapest at the error you can live with, and where refining
stops paying. Written by `scripts/work_precision.py`, which also takes a deck of your own:

    scripts/work_precision.py my.inp --probe tip -o charts

It runs the deck some thousand times, which takes minutes; `--quick` gives a first look.

## In short

- Take `newmark` with three-node elements and `rule=gauss`: down to the error that is marked "enough" it
  costs at most {most} times the cheapest at the errors of the tables. Below that `bathe` or `hht` can be
  cheaper. Refine mesh and step together; the tables say how far.
- Below the numerical error that is marked "enough", the beam's own distance from a two-dimensional
  continuum is all that remains. More elements and shorter steps cost and give nothing.

{short}

Errors are relative differences of a probe's history in the L2 norm over the whole run, of two and a
half to five periods: mostly errors of phase. "Numerical" is against the limit of the same beam in mesh
and step, "total" against the continuum.
"""

METHOD = """\
## What is measured

- **Solve loop.** From the CPU time T(n) that the program notes as `cpu_seconds` for a run of n steps,
  and T(1) of one step on the same mesh: (T(n) - T(1)) n / (n - 1). Newton's iterations, the recording
  of the probes and energies at every step are in it; start-up, reading the deck, counting unknowns and
  opening the file are not. For other programs T is the CPU time of the calls that step (Exudyn,
  OpenSees, Kratos) or of the process (CalculiX).
- **Whole process.** User and system time of the process from start to end, as the system counts it. For
  Python packages that includes starting the interpreter and loading the package.
- Each is the least of several rounds in which all runs take turns; a run that costs half as much again
  as another of its series that is no less exact is measured once (column `runs` of the table). Decks
  run as they are in input/, with `OUTPUT fields=none`, quiet, one thread.
- The limit is that of two runs of `newmark` (`bathe` for rule `linear`) on a mesh four times finer than
  the deck's, extrapolated in the step; what it may itself be off is taken from the same on half the
  mesh and half the steps, and errors below twice that are not shown.
- The other programs compute the cantilever in its linear-elastic limit, each against its own limit,
  with Newmark's trapezoidal rule and the fastest solver of those tried in each: Exudyn's geometrically exact
  beam with modified Newton, OpenSees' `timoshenkoBeamColumn` and `elasticBeamColumn` in corotational
  frames, Kratos' `CrBeamElement2D2N`, CalculiX' `B32R`. Their adapters are scripts/peer_*.py.
- Newton's tolerance is the deck's, 1e-10, in gentbeam, and 1e-8 in the other programs. A looser one is faster
  in all: 10 elements and 200 steps took Exudyn 0.6 of the time with 1e-4, and gentbeam's 400 steps 0.8 of
  the iterations with 1e-6, with errors far below those of the step. The charts do not make use of that.
- Small errors of coarse meshes can be luck: errors of mesh and step of opposite sign cancel in part.
  The fronts take them as they are, of all programs alike.
- Rule `gauss 2` comes closest to the continuum in example 1, and drifts with the mesh on inner supports
  ([model-error.md](model-error.md)); there it has no limit, and only total errors. It and `linear` are
  drawn, and not recommended.
"""


def seconds(value):
    """A time in words, three digits."""
    if value != value:
        return "-"
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"


def recommendable(case):
    return case.series.panel != "peer" and case.setting.rule not in NOT_RECOMMENDED


def cheapest(chart, limit, time="loop", wanted=recommendable, error="own"):
    """The cheapest case with an error of at most `limit`; None where there is none."""
    able = [
        case
        for case in chart.done
        if wanted(case) and case.errors.get(error, 1e300) <= limit and getattr(case, time) > 0.0
    ]
    return min(able, key=lambda case: getattr(case, time), default=None)


def model_error(chart):
    """What the deck's own rule leaves against the truth, refined without end; 0 where that is the truth."""
    return 0.0 if chart.model_is_beam else chart.model_errors[chart.scene.rule()]


def enough(chart):
    """The numerical error that is worth going to."""
    return WASTED * model_error(chart)


def percent(value):
    return f"{100.0 * value:.2g} %"


def short_table(charts):
    heads = ("deck", "the model's own error", "enough", "cheapest setting for that", "solve loop", "process")
    rows = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for chart in charts:
        case = cheapest(chart, enough(chart))
        if case:
            cells = [f"input/{chart.scene.name}.inp", percent(model_error(chart)), percent(enough(chart))]
            cells += [case.setting.words, seconds(case.loop), seconds(case.process)]
            rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def newmark_at_worst(charts):
    """How many times the cheapest time newmark with three nodes takes, where refining still pays."""
    ratios = [1.0]
    for chart in charts:
        for limit in (*LIMITS, enough(chart)):
            best = cheapest(chart, limit)
            if best and limit >= enough(chart) > 0.0:
                own = cheapest(chart, limit, wanted=is_newmark)
                ratios.append(own.loop / best.loop if own else float("inf"))
    return max(ratios)


def is_newmark(case):
    one = case.setting
    return recommendable(case) and one.scheme == "newmark" and one.nodes == 3 and one.steps > 0


def write_page(path, charts):
    lines = [INTRODUCTION.format(short=short_table(charts), most=f"{newmark_at_worst(charts):.2g}")]
    for chart in charts:
        lines += section(chart)
    lines.append(METHOD)
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines))
    print(f"wrote {path}")


def section(chart):
    name = chart.scene.name
    lines = [f"## {chart.scene.title}", ""]
    lines += [f"![Error against CPU time](pictures/work_precision_{name}.png)", ""]
    table = f"pictures/work_precision_{name}.csv"
    runs = f"All {len(chart.cases)} runs: [{table}]({table})."
    heads = ("numerical error up to", "cheapest setting", "its error", "total error", "solve loop", "process")
    lines += [f"input/{name}.inp, probe `{chart.scene.probe}`. {runs}", ""]
    lines += ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for limit in LIMITS:
        case = cheapest(chart, limit)
        if case:
            cells = [f"{limit:g}", case.setting.words, f"{case.errors['own']:.2g}"]
            cells += [f"{case.errors['total']:.2g}", seconds(case.loop), seconds(case.process)]
            lines.append("| " + " | ".join(cells) + " |")
    lines.append("")
    if model_error(chart):
        lines += [
            f"Refined without end, the beam with {chart.scene.rule()} is {percent(model_error(chart))} from "
            f"{chart.model}: a numerical error below {percent(enough(chart))} is enough.",
            "",
        ]
    lines += peer_table(chart) + failures(chart)
    return lines + [chart.machine + ".", ""]


def peer_table(chart):
    """What the other programs need for the same error, and how many times as much that is."""
    labels = list(dict.fromkeys(case.series.label for case in chart.cases if case.series.panel == "peer"))
    if not labels:
        return []
    heads = [f"{kind}, {limit:g}" for limit in PEER_LIMITS for kind in ("loop", "process")]
    lines = ["| program | " + " | ".join(heads) + " |", "|---" * (1 + len(heads)) + "|"]
    best = {(limit, t): cheapest(chart, limit, t) for limit in PEER_LIMITS for t in ("loop", "process")}
    lines.append("| gentbeam | " + " | ".join(cost(case, t) for (_, t), case in best.items()) + " |")
    for label in labels:
        cells = []
        for (limit, t), own in best.items():
            case = cheapest(chart, limit, t, lambda one, label=label: one.series.label == label)
            times = f" ({getattr(case, t) / getattr(own, t):.3g} times)" if case and own else ""
            cells.append(cost(case, t) + times)
        lines.append(f"| {label} | " + " | ".join(cells) + " |")
    return [
        "Other programs at the same error, each against its own limit (a dash: no run got there):",
        "",
        *lines,
        "",
    ]


def cost(case, time):
    return seconds(getattr(case, time)) if case else "-"


def failures(chart):
    if not chart.failed and not chart.missing:
        return []
    lines = []
    for label in dict.fromkeys(case.series.label for case in chart.failed):
        own = [case for case in chart.failed if case.series.label == label]
        first = f"the first ({own[0].size}) with: {own[0].failure}"
        lines.append(f"- {label}: {len(own)} failed, {first}")
    lines += [f"- left out: {words}" for words in chart.missing]
    return ["Failed and left out:", "", *lines, ""]

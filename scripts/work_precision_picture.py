"""Draws a work-precision chart: CPU time over error, a line a series, the front, what failed, the machine."""

import textwrap

from gentbeam_pictures import COLOURS, DASHES, MILLIMETRES, STYLE, escape, plt, save_picture
from work_precision_grid import front
from work_precision_page import cheapest, enough, model_error, percent, seconds

PEER_COLOURS = ("#B2182B", "#7F5539", "#B08968", "#8C6BB1", "#737373")
MARKERS = "os^Dv<>ph*X"
FRONT = {"color": "#FFD24D", "linewidth": 6.0, "alpha": 0.65}
WIDTH = 200.0  # millimetres
# From the picture's upper edge down to the panels' tops; their left edges and size; the legends' left edge.
TOPS, COLUMNS, PANEL, LEGEND = (18.0, 100.0), (15.0, 87.0), (62.0, 66.0), 153.0
TEXT_TOP = 180.0
LINE = 3.7
WRAP = 150
FAILURES_SHOWN = 6
LIMITS = (1e-1, 1e-2, 1e-3, 1e-4)


def styles(chart):
    """Line style by series: solid for schemes, dashes for models, hollow marks for other programs."""
    looks = {}
    count = {"scheme": 0, "model": 0, "peer": 0}
    for series in dict.fromkeys(case.series for case in chart.cases):
        panel, i = series.panel, count[series.panel]
        count[panel] += 1
        colours = PEER_COLOURS if panel == "peer" else COLOURS
        colour = colours[i % len(colours)]
        looks[series.label] = {
            "color": colour,
            "linestyle": {"scheme": "-", "model": DASHES[1], "peer": DASHES[3]}[panel],
            "marker": MARKERS[i % len(MARKERS)],
            "markersize": 3.2,
            "markerfacecolor": "white" if panel == "peer" else colour,
            "markeredgewidth": 0.7,
        }
    return looks


def points_of(cases, error, time):
    """Error and time of those that have both."""
    able = [case for case in cases if error in case.errors and getattr(case, time) > 0.0]
    return [(case.errors[error], getattr(case, time)) for case in able]


def draw_series(axis, cases, error, time, look):
    """All points faintly, and the line through those of them that no other beats."""
    points = points_of(cases, error, time)
    if points:
        axis.plot(*zip(*points), ".", color=look["color"], markersize=1.5, alpha=0.2, zorder=1)
        axis.plot(*zip(*(points[i] for i in front(points))), **look, zorder=3)


def draw_panel(axis, chart, looks, wanted, error, time, name):
    done = [case for case in chart.done if case.series.panel in wanted]
    for label in dict.fromkeys(case.series.label for case in done):
        draw_series(axis, [c for c in done if c.series.label == label], error, time, looks[label])
    best = points_of(chart.fronts[name], error, time)
    if best:
        axis.plot(*zip(*best), **FRONT, zorder=0, solid_capstyle="round")
    axis.set(xscale="log", yscale="log")
    axis.grid(which="major", color="#E4E4E4", linewidth=0.4, zorder=-1)


def mark(axis, x, words):
    """A dotted upright with words beside it."""
    axis.axvline(x, color="#404040", linewidth=0.8, linestyle=DASHES[3], zorder=2)
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6}
    place = {"transform": axis.get_xaxis_transform(), "va": "top", "ha": "right", "rotation": 90}
    axis.text(0.94 * x, 0.98, words, fontsize=7, bbox=box, zorder=4, **place)


def add_legend(figure, entries, top, title):
    if not entries:
        return
    made = figure.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=(LEGEND / WIDTH, 1.0 - top * MILLIMETRES / figure.get_figheight()),
        frameon=False,
        fontsize=7.5,
        title=title,
        title_fontsize=8,
        borderaxespad=0.0,
        handlelength=2.6,
    )
    made._legend_box.align = "left"


def entries(chart, looks, panel):
    labels = dict.fromkeys(case.series.label for case in chart.cases if case.series.panel == panel)
    return [plt.Line2D([], [], label=label, **looks[label]) for label in labels]


def advice(chart):
    """Lines of text: the cheapest setting at some errors."""
    lines = ["Cheapest setting at a numerical error of at most"]
    for limit in LIMITS:
        case = cheapest(chart, limit)
        if case:
            costs = f"{seconds(case.loop)} in the solve loop, {seconds(case.process)} in all"
            lines.append(f"    {percent(limit)}:  {case.setting.words}  ({costs})")
    if model_error(chart):
        lines.append(f"Enough: {percent(enough(chart))}, a third of what the model itself is off")
    return lines


def failures(chart):
    """Lines of text: what failed, by series, and what is not here."""
    lines = [f"Failed runs, \u00d7: {len(chart.failed) or 'none'} of {len(chart.cases)}"]
    labels = list(dict.fromkeys(case.series.label for case in chart.failed))
    for label in labels[:FAILURES_SHOWN]:
        own = [case for case in chart.failed if case.series.label == label]
        more = f" and {len(own) - 1} more" if len(own) > 1 else ""
        lines.append(f"\u00d7  {label} ({own[0].size}{more}): {own[0].failure}")
    if len(labels) > FAILURES_SHOWN:
        lines.append(f"\u00d7  and {len(labels) - FAILURES_SHOWN} series more: see the table")
    if chart.missing:
        lines.append("Left out: " + "; ".join(chart.missing))
    return [part for line in lines for part in textwrap.wrap(line, WRAP, subsequent_indent="    ")]


def panels(figure):
    height = figure.get_figheight() / MILLIMETRES
    size = (PANEL[0] / WIDTH, PANEL[1] / height)
    return [
        figure.add_axes([left / WIDTH, 1.0 - (top + PANEL[1]) / height, *size])
        for top in TOPS
        for left in COLUMNS
    ]


def draw(chart, path):
    words = [*advice(chart), "", *failures(chart)]
    height = TEXT_TOP + LINE * len(words) + 8.0
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(WIDTH * MILLIMETRES, height * MILLIMETRES))
        schemes, models, process, total = panels(figure)
        looks = styles(chart)
        draw_panel(schemes, chart, looks, ("scheme", "peer"), "own", "loop", "loop")
        draw_panel(models, chart, looks, ("model",), "own", "loop", "loop")
        draw_panel(process, chart, looks, ("scheme", "peer"), "own", "process", "process")
        draw_panel(total, chart, looks, ("scheme", "model"), "total", "loop", "total")
        if model_error(chart):
            mark(total, model_error(chart), f"the model itself: {percent(model_error(chart))}")
            mark(schemes, enough(chart), f"enough: {percent(enough(chart))}")
        models.set(xlim=schemes.get_xlim(), ylim=schemes.get_ylim())
        titles = {
            schemes: "(a) solve loop, by scheme",
            models: "(b) solve loop, by element and section rule",
            process: "(c) whole process",
            total: f"(d) solve loop and total error: against\n{escape(chart.model)}",
        }
        for axis, title in titles.items():
            axis.set_title(title, loc="left", pad=3)
            against = "" if axis is total else " (against the beam's limit)"
            axis.set_xlabel("relative error" + against, labelpad=1)
        for axis in (schemes, process):
            axis.set_ylabel("CPU time (s)", labelpad=1)
        rule = chart.scene.rule()
        add_legend(figure, entries(chart, looks, "scheme"), TOPS[0], f"3 nodes, {rule}")
        add_legend(figure, entries(chart, looks, "peer"), TOPS[0] + 40.0, "other programs")
        others = f"newmark, with other than\n3 nodes and {rule}"
        add_legend(figure, entries(chart, looks, "model"), TOPS[1], others)
        both = [
            plt.Line2D([], [], label="front: cheapest\nof gentbeam", **FRONT),
            plt.Line2D([], [], color="#808080", marker=".", linestyle="", markersize=3, label="every run"),
        ]
        add_legend(figure, both, TOPS[1] + 44.0, None)
        head = f"{escape(chart.scene.title)}: error of {escape(chart.scene.probe)}, and what it costs"
        figure.text(COLUMNS[0] / WIDTH, 1.0 - 5.0 / height, head, fontsize=11, va="center")
        left, top = 6.0 / WIDTH, 1.0 - TEXT_TOP / height
        figure.text(left, top, escape("\n".join(words)), fontsize=7.5, va="top", linespacing=1.3)
        corner = {"fontsize": 6.5, "ha": "right", "color": "#505050"}
        figure.text(1.0 - 3.0 / WIDTH, 2.5 / height, escape(chart.machine), **corner)
        save_picture(figure, str(path))

#!/usr/bin/env python3
"""Draws a study: a response against a parameter, the family of all histories, or a map over two parameters.

examples:
  plot_sweep.py fit.h5                                   what suits: a curve, a map, or points
  plot_sweep.py fit.h5 --kind response --against jm      a response against one of the parameters
  plot_sweep.py samples.h5 --kind response --against E --against h    the same, coloured by another
  plot_sweep.py fit.h5 --kind family --probe tip         all histories, coloured by a parameter
  plot_sweep.py samples.h5 --response tip_time_of_max    another response
  plot_sweep.py modes.h5 --response modal_frequency:2    the frequency of a MODAL's second mode
"""

import argparse
import csv
import os
import sys

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import MaxNLocator

from gentbeam_pictures import (
    COLOURS,
    LINE_COLOURS,
    MILLIMETRES,
    STYLE,
    add_picture_options,
    axis_label,
    draw_levels,
    draw_zero,
    escape,
    picture_path,
    plt,
    save_picture,
    symbol,
)
from gentbeam_results import Parser, ResultsError, run_script, warn
from gentbeam_studies import open_study
from plot_tip import parameter_label

KINDS = ("response", "family", "map")
DEFAULT_SIZE = (120.0, 80.0)
# More curves than these colours are coloured by a parameter.
MOST_CURVES = len(COLOURS)
# A parameter that spans so many times its smallest value is shown in logarithms.
WIDE = 50.0
# Responses of a map, so many times.
DECADES = 100.0
COLOUR_MAP = "viridis"
WORDS = {"max": "largest", "min": "smallest", "time_of_max": "time of the largest"}


def parse_arguments():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.h5", help="results of a deck with SWEEPs")
    parser.add_argument("--kind", choices=KINDS, help="what to draw (default: what suits the study)")
    parser.add_argument(
        "--response",
        metavar="NAME",
        help="a summary of /sweep: PROBE_max, PROBE_min, PROBE_time_of_max, or COMMAND_frequency[:MODE] of a "
        "MODAL, the first mode unless it says (default: the first summary)",
    )
    parser.add_argument(
        "--against",
        action="append",
        metavar="NAME",
        help="a parameter; a second one is the other axis of a map, the colour of a response (default: the "
        "first ones)",
    )
    parser.add_argument("--probe", metavar="NAME", help="of a family (default: the first)")
    parser.add_argument(
        "--group", metavar="NAME", help="the solution of a family (default: the first with probes)"
    )
    parser.add_argument(
        "--most", type=int, default=500, metavar="N", help="histories of a family at most (500)"
    )
    add_picture_options(parser, "width and height in millimetres (default: 120 80)")
    return parser.parse_args()


def main():
    args = parse_arguments()
    path = picture_path(args, os.path.splitext(args.file)[0] + "-sweep")
    with open_study(args.file) as study:
        absent = int(np.count_nonzero(~study.complete))
        if absent:
            warn(f"{study.path}: {absent} of {len(study.complete)} members are not complete and left out")
        columns = [study.column(name) for name in args.against or ()]
        kind = args.kind or ("map" if is_grid(study, columns) else "response")
        collect = {"response": collect_response, "family": collect_family, "map": collect_map}[kind]
        picture = collect(study, columns, args)
    if args.csv:
        write_csv(args.csv, picture)
    with plt.rc_context(STYLE):
        save_picture(draw(kind, picture, args.title, args.size), path)


def is_grid(study, columns):
    """Whether the members are all pairs of some values of two parameters."""
    if len(study.names) != 2 or len(columns) == 1:
        return False
    counts = [len(np.unique(study.values[:, i])) for i in (0, 1)]
    return min(counts) > 2 and np.prod(counts) == len(np.unique(study.values, axis=0)) == len(study.values)


def pick_response(study, args):
    if not study.summaries:
        raise ResultsError(f"{study.path}: has no summaries of probes or frequencies")
    return study.summary(args.response or study.summaries[0])


def response_label(summary):
    """ "largest tip (in)" or "frequency of mode 2, modal (1/s)", from the summary's name."""
    name, _, mode = summary.name.partition(":")
    if mode:
        command = escape(name.removesuffix("_frequency"))
        return axis_label(f"frequency of mode {mode}, {command}", summary.unit)
    for ending in sorted(WORDS, key=len, reverse=True):
        if name.endswith("_" + ending):
            return axis_label(f"{WORDS[ending]} {escape(name[: -len(ending) - 1])}", summary.unit)
    return axis_label(escape(name), summary.unit)


def collect_response(study, columns, args):
    """A curve for every set of values of the other parameters, or the members as points where those are
    nearly all different; a parameter that colours them where they are too many for labels."""
    summary = pick_response(study, args)
    column = columns[0] if columns else 0
    values, responses = study.values[study.complete], summary.values[study.complete]
    others = [i for i in range(len(study.names)) if i != column]
    colour = (columns[1:] + others + [column])[0]
    sets, which = np.unique(values[:, others], axis=0, return_inverse=True)
    points = len(sets) > max(MOST_CURVES, len(values) // 2)
    curves, colours = [], []
    for number in range(1 if points else len(sets)):
        mine = np.arange(len(values)) if points else np.flatnonzero(which.reshape(-1) == number)
        if not points:
            mine = mine[np.argsort(values[mine, column], kind="stable")]
        label = ", ".join(parameter_label(study.names[i], repr(float(values[mine[0], i])))[0] for i in others)
        curves.append((label, values[mine, column], responses[mine]))
        colours.append(values[mine, colour])
    return {
        "x_label": f"${symbol(study.names[column])}$",
        "y_label": response_label(summary),
        "colour_label": f"${symbol(study.names[colour])}$",
        "curves": curves,
        "colours": colours if points or len(sets) > MOST_CURVES else None,
        "points": points,
        "header": [study.names[column], summary.name],
        "rows": [(a, b) for _, xs, ys in curves for a, b in zip(xs, ys)],
    }


def collect_family(study, columns, args):
    column = columns[0] if columns else 0
    count = int(np.count_nonzero(study.complete))
    if args.most < 1:
        raise ResultsError("--most: at least one history")
    chosen = set(np.unique(np.linspace(0, count - 1, min(args.most, count)).round().astype(int)).tolist())
    values = study.values[study.complete, column]
    lines, colours, rows = [], [], []
    for i, (number, group) in enumerate(study.members(args.group)):
        if i not in chosen:
            continue
        history = group.history(args.probe or group.probes[0])
        probe, progress = args.probe or group.probes[0], axis_label(group.progress_name, history.time_unit)
        lines.append(np.column_stack([history.time, history.values]))
        colours.append(values[i])
        rows += [(number, values[i], t, v) for t, v in lines[-1]]
    quantity = f"${symbol(history.field)}$ at {escape(probe)}" if history.field else escape(probe)
    return {
        "x_label": progress,
        "y_label": axis_label(quantity, history.unit),
        "colour_label": f"${symbol(study.names[column])}$",
        "lines": lines,
        "colours": np.array(colours),
        "header": ["member", study.names[column], "time", probe],
        "rows": rows,
    }


def collect_map(study, columns, args):
    summary = pick_response(study, args)
    if len(columns) < 2:
        columns = (columns + [i for i in range(len(study.names)) if i not in columns])[:2]
    if len(columns) != 2 or columns[0] == columns[1]:
        raise ResultsError(
            f"{study.path}: a map takes two parameters that vary (there are: {', '.join(study.names)})"
        )
    shown = study.complete
    x, y, z = study.values[shown, columns[0]], study.values[shown, columns[1]], summary.values[shown]
    return {
        "x_label": f"${symbol(study.names[columns[0]])}$",
        "y_label": f"${symbol(study.names[columns[1]])}$",
        "colour_label": response_label(summary),
        "x": x,
        "y": y,
        "z": z,
        "header": [study.names[columns[0]], study.names[columns[1]], summary.name],
        "rows": list(zip(x, y, z)),
    }


def write_csv(path, picture):
    with sys.stdout if path == "-" else open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(picture["header"])
        for row in picture["rows"]:
            writer.writerow([repr(float(value)) if isinstance(value, float) else value for value in row])


def is_wide(values, span=WIDE):
    return len(values) > 2 and values.min() > 0.0 and values.max() > span * values.min()


def draw(kind, picture, title=None, size=None):
    width, height = size or DEFAULT_SIZE
    figure, axis = plt.subplots(layout="constrained", figsize=(width * MILLIMETRES, height * MILLIMETRES))
    {"response": draw_response, "family": draw_family, "map": draw_map}[kind](figure, axis, picture)
    axis.set_xlabel(picture["x_label"])
    axis.set_ylabel(picture["y_label"])
    for scale, ticks in ((axis.get_xscale(), axis.xaxis), (axis.get_yscale(), axis.yaxis)):
        if scale == "linear":
            ticks.set_major_locator(MaxNLocator(nbins=7, steps=[1, 2, 2.5, 5, 10]))
    if title:
        axis.set_title(escape(title))
    return figure


def draw_response(figure, axis, picture):
    curves = picture["curves"]
    if picture["colours"] is None:
        for i, (label, x, y) in enumerate(curves):
            axis.plot(x, y, "o-", markersize=2.5, color=COLOURS[i], label=label)
        if len(curves) > 1:
            axis.legend(frameon=False, fontsize=8)
    else:
        draw_coloured(figure, axis, picture)
    if is_wide(np.concatenate([x for _, x, _ in curves])):
        axis.set_xscale("log")


def draw_coloured(figure, axis, picture):
    """Points or curves in the colour of a parameter, which a bar tells."""
    scale = ScalarMappable(scale_of(np.concatenate(picture["colours"])), LINE_COLOURS)
    for (_, x, y), colours in zip(picture["curves"], picture["colours"]):
        if picture["points"]:
            draw_dots(axis, x, y, colours, scale.norm, LINE_COLOURS)
        else:
            axis.plot(x, y, "o-", markersize=2.5, color=scale.to_rgba(colours[0]))
    figure.colorbar(scale, ax=axis, label=picture["colour_label"])


def draw_dots(axis, x, y, colours, norm, colour_map):
    """Dots the smaller the more there are; very many are drawn as pixels also where the picture is of lines,
    so that the file stays small."""
    area = float(np.clip(3000.0 / len(x), 3.0, 16.0))
    return axis.scatter(
        x, y, c=colours, s=area, cmap=colour_map, norm=norm, linewidths=0, rasterized=len(x) > 2000
    )


def scale_of(values, span=WIDE):
    """How numbers become colours."""
    if is_wide(values, span):
        return LogNorm(values.min(), values.max())
    spread = 0.5 * max(abs(values.max()), 1e-300) * 1e-6 if values.max() == values.min() else 0.0
    return Normalize(values.min() - spread, values.max() + spread)


def draw_family(figure, axis, picture):
    lines, colours = picture["lines"], picture["colours"]
    collection = LineCollection(
        lines,
        array=colours,
        cmap=COLOUR_MAP,
        norm=scale_of(colours),
        linewidths=0.6 if len(lines) < 50 else 0.3,
    )
    axis.add_collection(collection)
    axis.autoscale_view()
    axis.set_xlim(min(line[0, 0] for line in lines), max(line[-1, 0] for line in lines))
    draw_zero(axis)
    figure.colorbar(collection, ax=axis, label=picture["colour_label"])


def draw_map(figure, axis, picture):
    x, y, z = picture["x"], picture["y"], picture["z"]
    columns, rows = np.unique(x), np.unique(y)
    if is_wide(columns):
        axis.set_xscale("log")
    if is_wide(rows):
        axis.set_yscale("log")
    if len(columns) * len(rows) == len(z) and min(len(columns), len(rows)) > 1:
        grid = np.empty((len(rows), len(columns)))
        grid[np.searchsorted(rows, y), np.searchsorted(columns, x)] = z
        draw_levels(figure, axis, columns, rows, grid, picture["colour_label"], is_wide(z, DECADES))
    else:
        # Members that are missing, or scattered from the start: every one is a point of its own.
        shown = draw_dots(axis, x, y, z, scale_of(z, DECADES), LINE_COLOURS)
        figure.colorbar(shown, ax=axis, label=picture["colour_label"])


if __name__ == "__main__":
    run_script(main)

#!/usr/bin/env python3
"""Draws the histories of probes from one or many gentbeam results files.

examples:
  plot_tip.py cantilever.h5                          the first probe of the first transient or static solution
  plot_tip.py jm-*.h5 --normalise L -o family.pdf    a family, told apart by the parameters that differ
  plot_tip.py beam.h5 --probe tip --probe middle     two probes
"""

import argparse
import csv
import os
import sys
from collections import namedtuple

import numpy as np
from matplotlib.text import OffsetFrom
from matplotlib.ticker import MaxNLocator

from gentbeam_pictures import (
    COLOURS,
    DASHES,
    MILLIMETRES,
    STYLE,
    UNLIMITED_JM,
    add_picture_options,
    axis_label,
    draw_error_bar,
    draw_zero,
    error_bar_words,
    escape,
    picture_path,
    plt,
    save_picture,
    symbol,
)
from gentbeam_results import HISTORY_KINDS, Parser, ResultsError, open_results, run_script, warn_if_incomplete

DEFAULT_SIZE = (120.0, 80.0)
EXTRA_PANEL = 50.0

# One line on the picture: `history` holds the numbers drawn, `plain` is the label in the CSV file.
Series = namedtuple("Series", "file group probe history divisor label plain")


def parse_arguments():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="results files")
    parser.add_argument(
        "--probe", action="append", metavar="NAME", help="a probe; repeat for more (default: the first)"
    )
    parser.add_argument(
        "--group", metavar="NAME", help="the solution (default: the first transient or static one)"
    )
    parser.add_argument(
        "--labels", nargs="+", metavar="TEXT", help="one label a line, in place of the automatic ones"
    )
    parser.add_argument(
        "--normalise",
        metavar="VALUE",
        help="divide by this number, or by this parameter of the deck (for instance L)",
    )
    parser.add_argument(
        "--if-any",
        action="store_true",
        help="do nothing, successfully, when no file holds the history of a probe",
    )
    add_picture_options(parser, "width and height in millimetres (default: 120 80)")
    return parser.parse_args()


def main():
    args = parse_arguments()
    path = picture_path(args, os.path.splitext(args.files[0])[0] + "-history")
    results = []
    try:
        for name in args.files:
            results.append(open_results(name))
            warn_if_incomplete(results[-1])
        if args.if_any and not any(has_history(result) for result in results):
            print("no history of a probe to draw")
            return
        series = collect_series(results, args)
    finally:
        for result in results:
            result.__exit__()
    if args.csv:
        write_csv(args.csv, series)
    with plt.rc_context(STYLE):
        save_picture(draw(series, args.title, args.size), path)


def has_history(results):
    return any(group.kind in HISTORY_KINDS and group.probes for group in results.groups)


def collect_series(results, args):
    """The lines to draw, file by file and probe by probe, with their labels."""
    found = []
    for result in results:
        group = result.group(args.group)
        if not group.probes:
            raise ResultsError(f"{result.path}: no probes in {group.name}")
        for probe in args.probe or group.probes[:1]:
            history = group.history(probe)
            divisor, divisor_name = find_divisor(result, args.normalise, history.unit)
            history.values = history.values / divisor
            if history.error_bar is not None:
                history.error_bar /= abs(divisor)
            found.append(Series(result, group, probe, history, divisor_name, "", ""))
    if args.labels:
        if len(args.labels) != len(found):
            raise ResultsError(f"--labels: {len(args.labels)} given for {len(found)} lines")
        return [line._replace(label=label, plain=label) for line, label in zip(found, args.labels)]
    return label_series(found, several_probes=len(args.probe or ()) > 1)


def find_divisor(results, wanted, unit):
    """The number to divide by and how the axis names it."""
    if wanted is None:
        return 1.0, ""
    try:
        value, name = float(wanted), f"({wanted} {escape(unit)})" if unit else wanted
    except ValueError:
        parameters = results.parameters
        if wanted.lower() not in parameters:
            available = ", ".join(parameters) or "none"
            raise ResultsError(f"{results.path}: no parameter '{wanted}' (there are: {available})") from None
        value, name = as_number(parameters[wanted.lower()]), f"${symbol(wanted)}$"
    if value is None or value == 0.0 or not np.isfinite(value):
        raise ResultsError(f"--normalise {wanted}: cannot divide by it")
    return value, name


def as_number(words):
    try:
        return float(words)
    except ValueError:
        return None


def label_series(series, several_probes):
    """Labels lines by their probe, where there are several, and by what sets their file apart."""
    labelled = []
    files = list(dict.fromkeys(line.file for line in series))
    differences = distinguish(files, {line.file: line.group for line in series})
    for line in series:
        probe = [(escape(line.probe), line.probe)] if several_probes else []
        parts = probe + differences[line.file]
        label, plain = (", ".join(part) for part in zip(*parts)) if parts else ("", "")
        labelled.append(line._replace(label=label, plain=plain))
    return labelled


def distinguish(files, group_of):
    """For every file what tells it from the others, each as (on the picture, in plain text)."""
    if len(files) == 1:
        return {files[0]: []}
    parameters = {file: file.parameters for file in files}
    names = dict.fromkeys(name for file in files for name in parameters[file])
    differing = [name for name in names if len({parameters[file].get(name) for file in files}) > 1]
    labels = {
        file: [
            parameter_label(name, parameters[file][name]) for name in differing if name in parameters[file]
        ]
        for file in files
    }
    if len({group_of[file].scheme for file in files}) > 1:
        for file in files:
            labels[file].append((escape(group_of[file].scheme), group_of[file].scheme))
    # Two runs of one deck: only their files' names are left to tell them apart.
    for file in files:
        if sum(labels[other] == labels[file] for other in files) > 1:
            labels = {other: labels[other] + [(escape(other.name), other.name)] for other in files}
            break
    return labels


def parameter_label(name, value):
    number = as_number(value)
    if number is None:
        return f"${symbol(name)}$ = {escape(value)}", f"{name} = {value}"
    if name == "jm" and number >= UNLIMITED_JM:
        return rf"${symbol(name)} = \infty$", f"{name} = inf"
    mantissa, _, exponent = f"{number:g}".partition("e")
    power = rf" \times 10^{{{int(exponent)}}}" if exponent else ""
    return f"${symbol(name)} = {mantissa}{power}$", f"{name} = {number:g}"


def write_csv(path, series):
    """One row a point, every number with all its digits."""
    with open(sys.stdout.fileno() if path == "-" else path, "w", newline="", closefd=path != "-") as stream:
        writer = csv.writer(stream)
        writer.writerow(("file", "group", "probe", "label", "time", "value", "time_unit", "unit"))
        for line in series:
            unit = "" if line.divisor else line.history.unit
            for time, value in zip(line.history.time, line.history.values):
                writer.writerow(
                    (
                        line.file.path,
                        line.group.name,
                        line.probe,
                        line.plain,
                        repr(float(time)),
                        repr(float(value)),
                        line.history.time_unit,
                        unit,
                    )
                )


def draw(series, title=None, size=None):
    """The figure: one panel for every kind of quantity, one line for every series."""
    panels = {}
    for line in series:
        panels.setdefault((line.history.field, line.history.unit), []).append(line)
    width, height = size or (DEFAULT_SIZE[0], DEFAULT_SIZE[1] + EXTRA_PANEL * (len(panels) - 1))
    figure, axes = plt.subplots(
        len(panels),
        1,
        sharex=True,
        squeeze=False,
        layout="constrained",
        figsize=(width * MILLIMETRES, height * MILLIMETRES),
    )
    axes = axes[:, 0]
    styles = {id(line): (COLOURS[i % len(COLOURS)], DASHES[i % len(DASHES)]) for i, line in enumerate(series)}
    for axis, lines in zip(axes, panels.values()):
        for line in lines:
            colour, dashes = styles[id(line)]
            # A single row is a point: a line would not show it.
            marker = "o" if len(line.history.time) == 1 else ""
            axis.plot(
                line.history.time,
                line.history.values,
                color=colour,
                linestyle=dashes,
                marker=marker,
                markersize=3,
                clip_on=False,
            )
            draw_error_bar(axis, line.history, colour, line.group.kind == "static")
        note_error_bars(axis, lines)
        axis.set_ylabel(quantity_label(lines))
        axis.margins(x=0.0 if any(len(line.history.time) > 1 for line in lines) else 0.05)
        draw_zero(axis)
    first = series[0]
    # Round numbers: ticks at 0.0025 need labels so long that they run into each other.
    axes[-1].xaxis.set_major_locator(MaxNLocator(nbins=7, steps=[1, 2, 5, 10]))
    axes[-1].set_xlabel(axis_label(first.group.progress_name, first.history.time_unit))
    if title:
        # Above the words about error bars.
        axes[0].set_title(escape(title), pad=plt.rcParams["axes.titlepad"] + 8)
    figure.align_ylabels(axes)
    for axis, lines in zip(axes, panels.values()):
        # The axis already names the probe of a line that is alone.
        if len(lines) > 1 or lines[0].plain != lines[0].probe:
            label_lines(figure, axis, [(line.label, line.history, styles[id(line)][0]) for line in lines])
    return figure


def note_error_bars(axis, lines):
    words = error_bar_words([line.history for line in lines])
    if words and lines[0].divisor:
        words = "bands and bars: estimated errors"
    size = 0.9 * plt.rcParams["xtick.labelsize"]
    axis.set_title(words, loc="right", fontsize=size, color="0.35", pad=2)


def quantity_label(lines):
    """What the vertical axis shows: the field where all lines share it, the probe where there is one."""
    first = lines[0]
    probes = list(dict.fromkeys(escape(line.probe) for line in lines))
    quantity = f"${symbol(first.history.field)}$" if first.history.field else ", ".join(probes)
    divisor = first.divisor
    if divisor.startswith("$") and quantity.startswith("$"):
        quantity = f"{quantity[:-1]}/{divisor[1:]}"
    elif divisor:
        quantity = f"{quantity} / {divisor}"
    if first.history.field and len(probes) == 1:
        quantity = f"{quantity} at {probes[0]}"
    return axis_label(quantity, "" if divisor else first.history.unit)


def label_lines(figure, axis, lines):
    """Names every line beside its last point, so that no eye has to travel to a legend and back."""
    lines = [(label, history, colour) for label, history, colour in lines if label]
    if not lines:
        return
    figure.canvas.draw()  # settles the scales the positions are computed from
    points = 72.0 / figure.dpi
    spacing = 1.25 * plt.rcParams["xtick.labelsize"]
    ends = []
    for label, history, colour in lines:
        finite = np.flatnonzero(np.isfinite(history.values))
        last = finite[-1] if finite.size else 0
        ends.append((history.time[last], history.values[last] if finite.size else 0.0))
    bottom = axis.bbox.y0 * points
    heights = [axis.transData.transform(end)[1] * points - bottom for end in ends]
    right = axis.get_xlim()[1]
    corner = OffsetFrom(axis.patch, (1.0, 0.0), unit="points")
    for (label, _, colour), end, height, place in zip(lines, ends, heights, spread(heights, spacing)):
        # A label that stands level with the line's end needs no leader.
        leader = abs(place - height) > 2.0 or end[0] < right
        axis.annotate(
            label,
            xy=end,
            xytext=(10, place),
            textcoords=corner,
            annotation_clip=False,
            color=colour,
            va="center",
            ha="left",
            fontsize=plt.rcParams["xtick.labelsize"],
            arrowprops={
                "arrowstyle": "-",
                "color": colour,
                "linewidth": 0.4,
                "shrinkA": 1,
                "shrinkB": 1,
                "alpha": 1.0 if leader else 0.0,
            },
        )


def spread(places, spacing):
    """The nearest places (least squares) in the same order that keep their distance."""
    order = np.argsort(places, kind="stable")
    blocks = []  # pools of neighbours: [sum of shifted places, count]
    for rank, i in enumerate(order):
        blocks.append([places[i] - rank * spacing, 1])
        while len(blocks) > 1 and blocks[-2][0] / blocks[-2][1] > blocks[-1][0] / blocks[-1][1]:
            total, count = blocks.pop()
            blocks[-1][0] += total
            blocks[-1][1] += count
    shifted = [total / count for total, count in blocks for _ in range(count)]
    spaced = np.empty(len(places))
    spaced[order] = np.array(shifted) + spacing * np.arange(len(places))
    return spaced


if __name__ == "__main__":
    run_script(main)

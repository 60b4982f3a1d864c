"""The pictures of scripts/report.py: scene, probes, energies, solver, shapes, modes, resultants."""

import re
from dataclasses import dataclass, field

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.ticker import MaxNLocator

from gentbeam_pictures import (
    COLOURS,
    DASHES,
    LINE_COLOURS,
    MILLIMETRES,
    axis_label,
    draw_error_bar,
    draw_zero,
    escape,
    plt,
)
from gentbeam_strip import build_strip, places, strains
from plot_shapes import SHAPES, deform, distinct_rows, draw_support, support_size

WIDTH = 170.0
MODES = 6
# Of the beam's length: the largest displacement of a mode as drawn.
MODE_SIZE = 0.15
ENERGIES = ("kinetic", "strain", "external", "dissipated")


@dataclass
class Load:
    """A line of the file's scene: what kind, where, and components by name."""

    kind: str
    at: dict
    components: dict
    words: str
    extra: dict = field(default_factory=dict)


def read_scene(text):
    """Loads and driven supports of the attribute `scene` of /deck; supports are in /mesh/fixed."""
    loads = []
    for line in text.splitlines():
        kind, *words = line.split()
        pairs = dict(word.split("=", 1) for word in words if "=" in word)
        extra = {name: pairs.pop(name) for name in ("history", "stage") if name in pairs}
        numbers = {name: float(value) for name, value in pairs.items()}
        at = {name: numbers.pop(name) for name in ("x", "from", "to") if name in numbers}
        if kind != "support":
            loads.append(Load(kind, at, numbers, load_words(kind, numbers, at, extra), extra))
    return loads


def load_words(kind, numbers, at, extra):
    parts = [f"{name} = {value:g}" for name, value in numbers.items()]
    if "from" in at:
        parts.append(f"on {at['from']:g} to {at['to']:g}")
    elif "x" in at:
        parts.append(f"at x = {at['x']:g}")
    if extra.get("history", "step") != "step":
        parts.append(f"history {extra['history']}")
    if extra.get("stage", "all") != "all":
        parts.append(f"{extra['stage']} only")
    return f"{kind}: " + ", ".join(parts)


def new_figure(height, columns=1, **options):
    return plt.subplots(
        1,
        columns,
        layout="constrained",
        figsize=(WIDTH * MILLIMETRES, height * MILLIMETRES),
        **options,
    )


def scene(mesh, loads):
    """The beam at rest with nodes, supports and loads; arrows point as the forces do, not to scale."""
    length, size = np.ptp(mesh.x), support_size(mesh)
    thickness = np.full(len(mesh.elements), 0.04 * length) if mesh.thickness is None else mesh.thickness
    half = 0.5 * thickness.max()
    # Each load stands a little farther out than the one before, so that none hides another.
    reaches = [(0.09 + 0.05 * number) * length for number in range(len(loads))]
    tall = max([half + 1.4 * reach for reach in reaches] + [1.6 * size])
    left, right = mesh.x.min() - 0.12 * length, mesh.x.max() + 0.12 * length
    figure, axis = new_figure(float(np.clip(WIDTH * 2.0 * tall / (right - left) + 12.0, 30.0, 110.0)))
    for element, height in zip(mesh.elements, 0.5 * thickness):
        low, high = mesh.x[element].min(), mesh.x[element].max()
        corners = [(low, -height), (high, -height), (high, height), (low, height)]
        axis.add_patch(plt.Polygon(corners, facecolor="0.9", edgecolor="0.4", linewidth=0.5, zorder=2))
    axis.plot(mesh.x, np.zeros_like(mesh.x), ".", color="0.3", markersize=2.0, zorder=3)
    for node in np.flatnonzero(mesh.fixed.any(axis=1)):
        draw_support(axis, mesh, node, size)
    for load, reach in zip(loads, reaches):
        draw_load(axis, load, mesh, half, reach)
    axis.set_xlim(left, right)
    axis.set_ylim(-tall, tall)
    axis.set_aspect("equal", adjustable="box")
    ticks = MaxNLocator(6).tick_values(mesh.x.min(), mesh.x.max())
    axis.set_xticks([tick for tick in ticks if mesh.x.min() <= tick <= mesh.x.max()])
    axis.set_xlabel(axis_label("$X_1$", mesh.unit))
    axis.set_yticks([])
    axis.spines["left"].set_visible(False)
    return figure


def draw_load(axis, load, mesh, half, reach):
    colour = {"gravity": COLOURS[3], "prescribed": COLOURS[4]}.get(load.kind, COLOURS[1])
    low = load.at.get("from", load.at.get("x", mesh.x.min()))
    high = load.at.get("to", load.at.get("x", mesh.x.max()))
    at = [low] if low == high else np.linspace(low, high, max(3, int(12 * (high - low) / np.ptp(mesh.x))))
    for name, value in load.components.items():
        if value == 0.0 and load.kind != "prescribed":
            continue
        sign = -1.0 if value < 0.0 else 1.0
        if name.startswith("m") or name in ("y1", "y3", "xi"):
            axis.annotate(
                f"{name} = {value:g}",
                (low, half),
                xytext=(0, 14),
                textcoords="offset points",
                ha="center",
                color=colour,
                arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.6},
            )
            continue
        along = name.endswith("1")
        for x in at:
            # Arrows end on the beam where they push at it, and start there where they pull.
            tail = (x - sign * reach, 0.0) if along else (x, -sign * (half + reach))
            tip = (x, 0.0) if along else (x, -sign * half)
            if along and len(at) == 1:
                tail, tip = (x, 0.0), (x + sign * reach, 0.0)
            elif not along and len(at) == 1 and sign > 0:
                tail, tip = (x, half), (x, half + reach)
            axis.annotate(
                "",
                tip,
                tail,
                arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 0.9, "mutation_scale": 7},
                zorder=6,
            )
        if len(at) > 1 and not along:
            line = -sign * (half + reach)
            axis.plot([low, high], [line, line], color=colour, linewidth=0.8, zorder=6)
        place = (at[-1], -sign * (half + 1.15 * reach)) if not along else (at[-1], half + 0.3 * reach)
        if not along and len(at) == 1 and sign > 0:
            place = (at[-1], half + 1.15 * reach)
        axis.text(*place, f"{name} = {value:g}", color=colour, fontsize=7, ha="center", va="center", zorder=6)


def probes(histories, progress, only_end):
    """One panel a probe, at most three side by side; estimated errors are those of the end, or all along."""
    columns = min(3, len(histories))
    rows = -(-len(histories) // columns)
    figure, axes = plt.subplots(
        rows,
        columns,
        squeeze=False,
        layout="constrained",
        figsize=(WIDTH * MILLIMETRES, 48.0 * rows * MILLIMETRES),
    )
    for axis, (name, history) in zip(axes.flat, histories.items()):
        axis.plot(history.time, history.values, color=COLOURS[2])
        draw_error_bar(axis, history, COLOURS[2], only_end)
        draw_zero(axis)
        axis.set_title(escape(name))
        axis.set_ylabel(axis_label(escape(history.field or name), history.unit))
        axis.set_xlabel(progress)
    for axis in axes.flat[len(histories) :]:
        axis.set_visible(False)
    return figure


def tuning(tuned):
    """The parts of the estimated error and the accuracy asked for; how the changes of the trials fell."""
    figure, (left, right) = new_figure(52.0, 2)
    parts = {"together": tuned.estimate, **tuned.parts}
    names = list(parts)[::-1]
    left.barh(
        names,
        [parts[name] for name in names],
        color=[COLOURS[2] if name == "together" else COLOURS[5] for name in names],
        height=0.6,
    )
    left.axvline(tuned.accuracy, color=COLOURS[1], linewidth=0.8)
    left.set_xscale("log")
    left.set_xlim(right=3.0 * max(tuned.accuracy, *parts.values()))
    left.set_xlabel("estimated error (line: asked for)")
    for number, source in enumerate(("mesh", "time")):
        rungs = [rung for rung in tuned.rungs if rung["source"] == source and rung["change"] > 0.0]
        sizes = [rung["elements" if source == "mesh" else "steps"] for rung in rungs]
        right.loglog(
            sizes,
            [rung["change"] for rung in rungs],
            color=COLOURS[2 + number],
            marker="os"[number],
            markersize=3,
            label={"mesh": "mesh: elements", "time": "time: steps"}[source],
        )
    right.axhline(tuned.accuracy, color=COLOURS[1], linewidth=0.8)
    right.set_xlabel("elements or steps of a trial")
    right.set_ylabel("change of the probes")
    right.legend(frameon=False, fontsize=7)
    return figure


def energies(time, ledger, unit, progress):
    figure, (left, right) = new_figure(58.0, 2, width_ratios=(2, 1))
    for number, name in enumerate(ENERGIES):
        left.plot(time, ledger[name], color=COLOURS[number], linestyle=DASHES[number], label=name)
    # Above the curves, which fill the panel.
    left.legend(frameon=False, fontsize=7, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(ENERGIES))
    left.set_ylabel(axis_label("energy", unit))
    right.plot(time, ledger["balance"], color=COLOURS[1])
    right.axhline(0.0, color="0.6", linewidth=0.4, zorder=0)
    right.set_title("balance")
    for axis in (left, right):
        axis.set_xlabel(progress)
    return figure


def solver(record, progress):
    """What each step took: iterations and cuts, its size, what was left of the residual."""
    figure, axes = new_figure(50.0, 3)
    steps = np.arange(1, len(record["iterations"]))
    axes[0].step(steps, record["iterations"][1:], color=COLOURS[2], where="mid", label="Newton iterations")
    if record["cuts"].any():
        axes[0].step(steps, record["cuts"][1:], color=COLOURS[1], where="mid", label="cuts")
    axes[0].legend(frameon=False, fontsize=7)
    axes[0].set_ylim(bottom=0.0)
    axes[0].yaxis.set_major_locator(MaxNLocator(integer=True))
    axes[1].plot(steps, record["step"][1:], color=COLOURS[3])
    axes[1].set_ylabel(axis_label("step size", progress))
    axes[1].set_ylim(bottom=0.0)
    left = record["residual"][1:]
    axes[2].semilogy(steps[left > 0.0], left[left > 0.0], ".", markersize=2.5, color=COLOURS[4])
    axes[2].set_ylabel("residual over forces")
    for axis in axes:
        axis.set_xlabel("step")
    return figure


def draw_strip(axis, strip, place, values, look):
    for first, end in zip(strip.ends, strip.ends[1:]):
        x, z = place[first:end, :, 0], place[first:end, :, 1]
        axis.pcolormesh(x, z, values[first:end], shading="gouraud", rasterized=True, **look)
    axis.plot(*outline(place).T, color="black", linewidth=0.5)


def shapes(mesh, times, fields, label, path):
    """Above, the strip at rows that differ most; below, the one of the largest strain, coloured by E11."""
    strip = build_strip(mesh, path)
    rows = distinct_rows(fields, SHAPES)
    drawn = {row: places(strip, fields[row]) for row in rows}
    largest = max(range(len(times)), key=lambda row: np.abs(strains(strip, fields[row])["E11"]).max())
    values = strains(strip, fields[largest])["E11"]
    reach = np.abs(values).max() or 1e-12
    look = {"cmap": "RdBu_r", "vmin": -reach, "vmax": reach}
    at_largest = places(strip, fields[largest])
    low, high = limits([*drawn.values(), at_largest], mesh)
    height = float(np.clip((WIDTH - 40.0) * (high[1] - low[1]) / (high[0] - low[0]), 22.0, 110.0))
    figure, (above, below) = plt.subplots(
        2, 1, layout="constrained", figsize=(WIDTH * MILLIMETRES, (2.0 * height + 26.0) * MILLIMETRES)
    )
    shades = ListedColormap(LINE_COLOURS(np.linspace(0.0, 1.0, len(rows))))
    for number, row in enumerate(rows):
        above.plot(*outline(drawn[row]).T, color=shades(number), linewidth=0.8)
    scale = plt.cm.ScalarMappable(BoundaryNorm(np.arange(len(rows) + 1) - 0.5, len(rows)), shades)
    bar = figure.colorbar(scale, ax=above, label=label, fraction=0.04)
    bar.set_ticks(range(len(rows)), labels=[f"{times[row]:.4g}" for row in rows])
    bar.ax.tick_params(which="both", length=0, labelsize=6)
    draw_strip(below, strip, at_largest, values, look)
    below.set_title(f"largest strain, at {times[largest]:.4g}", loc="left")
    scale = plt.cm.ScalarMappable(plt.Normalize(-reach, reach), look["cmap"])
    bar = figure.colorbar(scale, ax=below, label="$E_{11}$", fraction=0.04)
    bar.ax.tick_params(labelsize=6)
    for axis in (above, below):
        for node in np.flatnonzero(mesh.fixed.any(axis=1)):
            draw_support(axis, mesh, node, support_size(mesh))
        axis.set_xlim(low[0], high[0])
        axis.set_ylim(low[1], high[1])
        axis.set_aspect("equal", adjustable="box")
        axis.set_ylabel(axis_label("$x_3$", mesh.unit))
    below.set_xlabel(axis_label("$x_1$", mesh.unit))
    return figure


def outline(place):
    return np.concatenate([place[:, 0], place[::-1, -1], place[:1, 0]])


def limits(shown, mesh):
    """Lower left and upper right corner of what is drawn, supports and a margin included."""
    size = 1.3 * support_size(mesh)
    held = [[[x - size, -size], [x + size, size]] for x in mesh.x[mesh.fixed.any(axis=1)]]
    points = np.concatenate([*(place.reshape(-1, 2) for place in shown), *held])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.03 * max(high - low)
    return low - margin, high + margin


def modes(mesh, state, frequency, shapes_of, unit):
    """The mid-line in a state (fields of all nodes), and on it the first modes, all to one scale."""
    count = min(MODES, len(frequency))
    columns, rows = min(3, count), -(-count // 3)
    moved = [state + MODE_SIZE * np.ptp(mesh.x) * shape for shape in shapes_of[:count]]
    lines = [deform(mesh, 0.0, fields).middle for fields in (state, *moved)]
    low, high = mode_limits(lines)
    width = WIDTH / columns - 6.0
    height = float(np.clip(width * (high[1] - low[1]) / (high[0] - low[0]), 20.0, 80.0)) + 12.0
    figure, axes = plt.subplots(
        rows,
        columns,
        squeeze=False,
        layout="constrained",
        figsize=(WIDTH * MILLIMETRES, rows * height * MILLIMETRES),
    )
    for axis in axes.flat[count:]:
        axis.set_visible(False)
    for number, (axis, fields) in enumerate(zip(axes.flat, moved)):
        axis.plot(*lines[0].T, color="0.7", linewidth=0.6)
        axis.plot(*lines[number + 1].T, color=COLOURS[2])
        axis.plot(mesh.x + fields[:, 0], fields[:, 1], ".", color=COLOURS[2], markersize=2.0)
        axis.set_title(axis_label(f"{number + 1}: {frequency[number]:.6g}", unit))
        axis.set_xlim(low[0], high[0])
        axis.set_ylim(low[1], high[1])
        axis.set_aspect("equal", adjustable="box")
        axis.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        axis.set_yticks([])
        axis.spines["left"].set_visible(False)
    return figure


def mode_limits(lines):
    """Corners around all lines, not too flat for a panel."""
    points = np.concatenate(lines)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.05 * max(high - low)
    flat = max(0.0, 0.35 * (high - low)[0] - (high - low)[1])
    return low - [margin, margin + 0.5 * flat], high + [margin, margin + 0.5 * flat]


def resultants(x, parts, units, length_unit, when):
    """Axial force, shear force and bending moment along the beam at one instant."""
    figure, axes = new_figure(50.0, 3)
    for axis, (name, values), unit in zip(axes, parts.items(), units):
        axis.fill_between(x, values, color=COLOURS[5], alpha=0.35, linewidth=0.0)
        axis.plot(x, values, color=COLOURS[2])
        axis.axhline(0.0, color="0.4", linewidth=0.5)
        axis.set_title(f"{name}, at {when:.4g}")
        axis.set_ylabel(unit)
        axis.set_xlabel(axis_label("$X_1$", length_unit))
    return figure


def plain(words):
    """A file's words as an HTML id."""
    return re.sub(r"[^a-z0-9]+", "-", words.lower())

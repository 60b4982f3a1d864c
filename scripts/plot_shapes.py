#!/usr/bin/env python3
"""Draws the deformed beam, with its thickness, at chosen times of a gentbeam results file.

examples:
  plot_shapes.py cantilever.h5                       the seven shapes that differ most
  plot_shapes.py cantilever.h5 --times 0 2e-3 4e-3   the stored rows nearest to these times
  plot_shapes.py stiff.h5 --scale 50                 displacements enlarged, which the title says
"""

import argparse
import csv
import os
import sys
from collections import namedtuple

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap
from matplotlib.patches import Circle, Polygon, Rectangle

from gentbeam_pictures import (
    LINE_COLOURS,
    MILLIMETRES,
    STYLE,
    add_picture_options,
    axis_label,
    escape,
    picture_path,
    plt,
    save_picture,
)
from gentbeam_results import FIELDS, Parser, ResultsError, open_results, run_script, warn, warn_if_incomplete

WIDTH = 120.0
SHAPES = 7
HEIGHTS = (45.0, 160.0)
POINTS_PER_ELEMENT = 13

# The beam at one time: points (n, 2) of mid-line and faces from end to end; no faces without a thickness.
Shape = namedtuple("Shape", "time reference middle top bottom")


def parse_arguments():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.h5", help="a results file")
    parser.add_argument(
        "--group", metavar="NAME", help="the solution (default: the first transient or static one)"
    )
    chosen = parser.add_mutually_exclusive_group()
    chosen.add_argument(
        "--times", nargs="+", type=float, metavar="T", help="times (of a static solution: load factors)"
    )
    chosen.add_argument(
        "--count",
        type=int,
        metavar="N",
        help=f"this many, evenly spaced (default: the {SHAPES} that differ most)",
    )
    parser.add_argument(
        "--scale", type=float, default=1.0, metavar="FACTOR", help="enlarge displacements, also in --csv"
    )
    parser.add_argument(
        "--thickness", type=float, metavar="H", help="the beam's thickness, where the file has none"
    )
    parser.add_argument("--no-supports", action="store_true", help="leave out the supports")
    add_picture_options(
        parser, f"width and height in millimetres (default: {WIDTH:g} and what the shapes need)"
    )
    args = parser.parse_args()
    if args.count is not None and args.count < 1:
        parser.error("--count must be at least 1")
    if not (args.scale > 0.0 and np.isfinite(args.scale)):
        parser.error("--scale must be positive")
    if args.thickness is not None and not args.thickness > 0.0:
        parser.error("--thickness must be positive")
    return args


def main():
    args = parse_arguments()
    path = picture_path(args, os.path.splitext(args.file)[0] + "-shapes")
    with open_results(args.file) as results:
        warn_if_incomplete(results)
        mesh = results.mesh()
        group = results.group(args.group)
        times, fields = group.displacements()
        if fields.ndim != 3 or fields.shape[1] != len(mesh.x) or fields.shape[2] < 2:
            raise ResultsError(f"{results.path}: {group.name}/u does not fit the mesh")
        if args.thickness is not None:
            mesh.thickness = np.full(len(mesh.elements), args.thickness)
        elif mesh.thickness is None:
            warn(f"{results.path}: has no /mesh/thickness; drawing the mid-line (see --thickness)")
        if args.times is None and args.count is None:
            rows = distinct_rows(fields, SHAPES)
        else:
            rows = choose_rows(times, args.times, args.count, results.path)
        shapes = [enlarge(mesh, deform(mesh, times[row], fields[row]), args.scale) for row in rows]
        progress = axis_label(group.progress_name, group.progress_unit)
    if args.csv:
        write_csv(args.csv, shapes)
    with plt.rc_context(STYLE):
        title = scaled_title(args.title, args.scale)
        figure = draw(shapes, mesh, progress, title, args.size, supports=not args.no_supports)
        save_picture(figure, path)


def choose_rows(times, wanted, count, path):
    """The rows to draw: those nearest to the times wanted, or `count` rows evenly spaced in time."""
    if wanted is None:
        wanted = np.linspace(times[0], times[-1], count) if count > 1 else times[-1:]
    slack = 1e-9 * np.ptp(times)
    for time in wanted:
        if not times.min() - slack <= time <= times.max() + slack:
            raise ResultsError(
                f"{path}: time {time:g} is outside the solution ({times.min():g} to {times.max():g})"
            )
    return list(dict.fromkeys(int(np.argmin(np.abs(times - time))) for time in wanted))


def distinct_rows(fields, count):
    """The first row, and one after another those whose displacements are farthest from all chosen; in order.

    Rows evenly spaced in time would catch a periodic motion at the same phases again and again.
    """
    displacements = fields[:, :, :2].reshape(len(fields), -1)
    rows, nearest = [0], np.full(len(fields), np.inf)
    while len(rows) < count:
        distances = np.linalg.norm(displacements - displacements[rows[-1]], axis=1)
        nearest = np.fmin(nearest, distances)
        nearest[rows] = 0.0
        if not np.nanmax(nearest) > 0.0:
            break
        rows.append(int(np.nanargmax(nearest)))
    return sorted(rows)


def scaled_title(title, scale):
    said = "" if scale == 1.0 else f"displacements {scale:g} times as large"
    return f"{title} ({said})" if title and said else title or said


def shape_functions(nodes, points):
    """Lagrange's polynomials (points, nodes) over the nodes' places."""
    values = np.ones((len(points), len(nodes)))
    for j, node in enumerate(nodes):
        for other in np.delete(nodes, j):
            values[:, j] *= (points - other) / (node - other)
    return values


def derivatives(nodes, points):
    """d/dX1 of shape_functions."""
    values = np.zeros((len(points), len(nodes)))
    for j, node in enumerate(nodes):
        others = np.delete(nodes, j)
        for k, other in enumerate(others):
            rest = np.delete(others, k)
            values[:, j] += np.prod((points[:, None] - rest) / (node - rest), axis=1) / (node - other)
    return values


def deform(mesh, time, fields):
    """The beam's mid-line and faces: x(X1, +-h/2) = (X1 + u1, u3) + (+-h/2 + xi h^2/4) (y1, 1 + y3)."""
    reference, middle, top, bottom = [], [], [], []
    for number, element in enumerate(mesh.elements):
        nodes = mesh.x[element]
        points = np.linspace(nodes.min(), nodes.max(), POINTS_PER_ELEMENT)
        values = shape_functions(nodes, points) @ fields[element]
        line = np.stack([points + values[:, 0], values[:, 1]], axis=1)
        reference.append(points)
        middle.append(line)
        if mesh.thickness is None:
            continue
        if fields.shape[1] >= 4:
            director = np.stack([values[:, 2], 1.0 + values[:, 3]], axis=1)
        else:
            # Without a director the sections are taken normal to the mid-line.
            slope = derivatives(nodes, points) @ fields[element, :2]
            director = np.stack([-slope[:, 1], 1.0 + slope[:, 0]], axis=1)
            director /= np.linalg.norm(director, axis=1, keepdims=True)
        stretch = values[:, 4:5] if fields.shape[1] >= 5 else 0.0
        half = 0.5 * mesh.thickness[number]
        top.append(line + (half + stretch * half**2) * director)
        bottom.append(line + (-half + stretch * half**2) * director)
    faces = (np.concatenate(top), np.concatenate(bottom)) if top else (None, None)
    return Shape(float(time), np.concatenate(reference), np.concatenate(middle), *faces)


def enlarge(mesh, shape, scale):
    """The shape with the displacement of every point, from where it is at rest, times `scale`."""
    if scale == 1.0:
        return shape
    rest = deform(mesh, shape.time, np.zeros((len(mesh.x), len(FIELDS))))
    parts = [
        start if start is None else start + scale * (place - start)
        for start, place in zip(rest[2:], shape[2:])
    ]
    return Shape(shape.time, shape.reference, *parts)


def write_csv(path, shapes):
    """One row a point, every number with all its digits."""
    with open(sys.stdout.fileno() if path == "-" else path, "w", newline="", closefd=path != "-") as stream:
        writer = csv.writer(stream)
        writer.writerow(
            ("time", "X1", "middle_x1", "middle_x3", "top_x1", "top_x3", "bottom_x1", "bottom_x3")
        )
        for shape in shapes:
            columns = [shape.middle] + ([shape.top, shape.bottom] if shape.top is not None else [])
            for i, place in enumerate(shape.reference):
                numbers = [shape.time, place] + [value for column in columns for value in column[i]]
                writer.writerow([repr(float(number)) for number in numbers])


def draw(shapes, mesh, progress, title=None, size=None, supports=True):
    low, high = extent(shapes, mesh, supports)
    width, height = size or (WIDTH, fitting_height(low, high, len(shapes)))
    figure, axis = plt.subplots(layout="constrained", figsize=(width * MILLIMETRES, height * MILLIMETRES))
    colours = LINE_COLOURS(np.linspace(0.0, 1.0, len(shapes))) if len(shapes) > 1 else [(0.0, 0.0, 0.0, 1.0)]
    for rank, (shape, colour) in enumerate(zip(shapes, colours)):
        draw_shape(axis, shape, colour, min(0.22, 1.5 / len(shapes)), zorder=2.0 + rank / len(shapes))
    if supports:
        for node in np.flatnonzero(mesh.fixed.any(axis=1)):
            draw_support(axis, mesh, node, support_size(mesh))
    axis.set_xlabel(axis_label("$x_1$", mesh.unit))
    axis.set_ylabel(axis_label("$x_3$", mesh.unit))
    if title:
        axis.set_title(escape(title))
    if len(shapes) > 1:
        add_time_scale(axis, shapes, colours, progress)
    fill_frame(figure, axis, low, high)
    return figure


def extent(shapes, mesh, supports):
    """Lower left and upper right corner of what is drawn, with a margin."""
    points = [
        part for shape in shapes for part in (shape.middle, shape.top, shape.bottom) if part is not None
    ]
    if supports:
        reach = 1.3 * support_size(mesh)
        places = mesh.x[mesh.fixed.any(axis=1)]
        points += [np.array([[place - reach, -reach], [place + reach, reach]]) for place in places]
    points = np.concatenate(points)
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        raise ResultsError("the shapes hold no finite number")
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.03 * max(high - low)
    return low - margin, high + margin


def fitting_height(low, high, count):
    """Millimetres that leave the axes about as high as their data ask for at the default width."""
    beside, around = (32.0 if count > 1 else 16.0), 16.0
    height = (WIDTH - beside) * (high[1] - low[1]) / (high[0] - low[0]) + around
    return float(np.clip(height, *HEIGHTS))


def fill_frame(figure, axis, low, high):
    """Equal scales on both axes, with limits widened until the panel fills the figure."""
    axis.set_xlim(low[0], high[0])
    axis.set_ylim(low[1], high[1])
    figure.canvas.draw()  # settles the panel's shape
    panel = axis.get_window_extent()
    span = high - low
    scale = max(span / (panel.width, panel.height))
    middle, half = 0.5 * (low + high), 0.5 * scale * np.array((panel.width, panel.height))
    axis.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axis.set_ylim(middle[1] - half[1], middle[1] + half[1])
    # The new ticks may be of another width than the old ones.
    axis.set_aspect("equal", adjustable="box")


def draw_shape(axis, shape, colour, opacity, zorder):
    if shape.top is not None:
        outline = np.concatenate([shape.top, shape.bottom[::-1]])
        axis.add_patch(
            Polygon(outline, closed=True, facecolor=(*colour[:3], opacity), edgecolor="none", zorder=zorder)
        )
        axis.add_patch(
            Polygon(
                outline,
                closed=True,
                fill=False,
                edgecolor=colour,
                linewidth=0.8,
                joinstyle="miter",
                zorder=zorder,
            )
        )
    axis.plot(
        *shape.middle.T,
        color=colour,
        linewidth=0.5 if shape.top is not None else 1.0,
        linestyle=(0, (8, 2, 1.5, 2)) if shape.top is not None else "-",
        zorder=zorder,
    )


def add_time_scale(axis, shapes, colours, progress):
    """A bar with one field for every shape, named by its time."""
    count = len(shapes)
    cmap = LinearSegmentedColormap.from_list("shapes", colours, N=count)
    scale = ScalarMappable(BoundaryNorm(np.arange(count + 1) - 0.5, count), cmap)
    place = axis.inset_axes([1.03, 0.0, 0.03, 1.0])
    bar = axis.figure.colorbar(scale, cax=place, label=progress)
    # More names than this run into each other.
    shown = np.unique(np.linspace(0, count - 1, min(count, 9)).round().astype(int))
    bar.set_ticks(shown, labels=[f"{shapes[i].time:.4g}" for i in shown])
    bar.ax.tick_params(which="both", length=0)
    bar.outline.set_linewidth(0.6)


def support_size(mesh):
    """Half the width of a support's symbol."""
    thickness = 0.0 if mesh.thickness is None else mesh.thickness.max()
    return max(0.9 * thickness, 0.045 * np.ptp(mesh.x))


def draw_support(axis, mesh, node, size):
    """The symbol of what is fixed, at the node's reference place."""
    place = mesh.x[node]
    # Walls stand outside the beam.
    side = -1.0 if place <= 0.5 * (mesh.x.min() + mesh.x.max()) else 1.0
    fixed = {name for name, is_fixed in zip(FIELDS, mesh.fixed[node]) if is_fixed} - {"xi"}
    if fixed == {"u1", "u3", "y1", "y3"}:
        draw_wall(axis, place, side, size)
    elif fixed == {"u1", "u3"}:
        draw_pin(axis, place, size, gap=0.0)
    elif fixed == {"u3"}:
        draw_pin(axis, place, size, gap=0.3 * size)
    elif fixed == {"u1", "y1", "y3"}:
        draw_guide(axis, place, side, size)
    else:
        names = " ".join(name for name in FIELDS if mesh.fixed[node][FIELDS.index(name)])
        axis.plot(place, 0.0, marker="D", markersize=4, color="black", markerfacecolor="white", zorder=5)
        axis.annotate(
            names,
            (place, 0.0),
            xytext=(0, -8),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=7,
            zorder=5,
        )


def draw_hatched(axis, corner, width, height):
    axis.add_patch(
        Rectangle(
            corner,
            width,
            height,
            facecolor="none",
            edgecolor="0.25",
            hatch="////////",
            linewidth=0.0,
            zorder=4,
        )
    )


def draw_wall(axis, place, side, size):
    """Clamped."""
    axis.plot([place, place], [-1.2 * size, 1.2 * size], color="black", linewidth=1.0, zorder=5)
    draw_hatched(axis, (min(place, place + 0.45 * side * size), -1.2 * size), 0.45 * size, 2.4 * size)


def draw_pin(axis, place, size, gap):
    """Pinned; with a gap above the ground, a roller."""
    foot = -0.9 * size
    axis.add_patch(
        Polygon(
            [(place, 0.0), (place - 0.55 * size, foot), (place + 0.55 * size, foot)],
            closed=True,
            facecolor="white",
            edgecolor="black",
            linewidth=0.8,
            zorder=5,
        )
    )
    for shift in (-0.35, 0.0, 0.35) if gap else ():
        axis.add_patch(
            Circle(
                (place + shift * size, foot - 0.5 * gap),
                0.5 * gap,
                facecolor="white",
                edgecolor="black",
                linewidth=0.6,
                zorder=5,
            )
        )
    ground = foot - gap
    axis.plot(
        [place - 0.8 * size, place + 0.8 * size], [ground, ground], color="black", linewidth=0.8, zorder=5
    )
    draw_hatched(axis, (place - 0.8 * size, ground - 0.3 * size), 1.6 * size, 0.3 * size)


def draw_guide(axis, place, side, size):
    """Free to slide along x3, not to move along x1 or to turn."""
    radius = 0.16 * size
    for height in (-0.75, -0.25, 0.25, 0.75):
        axis.add_patch(
            Circle(
                (place + side * radius, height * size),
                radius,
                facecolor="white",
                edgecolor="black",
                linewidth=0.6,
                zorder=5,
            )
        )
    wall = place + 2.0 * side * radius
    axis.plot([wall, wall], [-1.2 * size, 1.2 * size], color="black", linewidth=0.8, zorder=5)
    draw_hatched(axis, (min(wall, wall + 0.3 * side * size), -1.2 * size), 0.3 * size, 2.4 * size)


if __name__ == "__main__":
    run_script(main)

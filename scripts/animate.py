#!/usr/bin/env python3
"""Makes a film of the moving beam, with its thickness and coloured by strain, from a gentbeam results file.

examples:
  animate.py cantilever.h5                          cantilever.gif, coloured by E11
  animate.py cantilever.h5 -o film.mp4 --fps 30     where ffmpeg is installed
  animate.py cantilever.h5 --colour J --frames 100
"""

import argparse
import os
import shutil

import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter

from gentbeam_pictures import MILLIMETRES, STYLE, axis_label, escape, plt
from gentbeam_results import Parser, ResultsError, open_results, run_script, warn_if_incomplete
from gentbeam_strip import QUANTITIES, build_strip, places, strains
from plot_shapes import draw_support, support_size

LABELS = {"E11": "$E_{11}$", "E33": "$E_{33}$", "E13": "$E_{13}$", "J": "$J$"}
REST = {"J": 1.0}  # the value without deformation, in the middle of the colours
WIDTH = 140.0
HEIGHTS = (40.0, 160.0)
DPI = 120


def parse_arguments():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.h5", help="a results file")
    parser.add_argument("--group", metavar="NAME", help="the solution (default: the first with a course)")
    parser.add_argument("-o", "--output", metavar="FILE", help=".gif or, with ffmpeg, .mp4 (default: .gif)")
    parser.add_argument(
        "--colour", choices=(*QUANTITIES, "none"), default="E11", help="what colours the strip (default: E11)"
    )
    parser.add_argument("--range", nargs=2, type=float, metavar=("LOW", "HIGH"), help="ends of the colours")
    parser.add_argument("--frames", type=int, default=60, metavar="N", help="evenly in time (default: 60)")
    parser.add_argument("--fps", type=float, default=20.0, help="frames a second (default: 20)")
    parser.add_argument("--size", nargs=2, type=float, metavar=("W", "H"), help="in millimetres")
    parser.add_argument("--title", help="a title above the picture")
    parser.add_argument("--no-supports", action="store_true", help="leave out the supports")
    args = parser.parse_args()
    if args.frames < 2:
        parser.error("--frames must be at least 2")
    if not 0.1 <= args.fps <= 100.0:
        parser.error("--fps must be from 0.1 to 100")
    if args.range and not args.range[0] < args.range[1]:
        parser.error("--range needs LOW below HIGH")
    return args


def film_writer(path, fps):
    """How the film is written, by its ending."""
    ending = os.path.splitext(path)[1].lower()
    if ending == ".gif":
        return PillowWriter(fps=fps)
    if ending == ".mp4":
        if shutil.which("ffmpeg") is None:
            raise ResultsError(f"{path}: mp4 needs ffmpeg, which is not installed; .gif does not")
        # Without encoder's name and date the same numbers make the same file.
        return FFMpegWriter(fps=fps, extra_args=["-pix_fmt", "yuv420p", "-fflags", "+bitexact"])
    raise ResultsError(f"{path}: unknown kind of film (there are: gif, mp4)")


def main():
    args = parse_arguments()
    path = args.output or os.path.splitext(args.file)[0] + ".gif"
    writer = film_writer(path, args.fps)
    with open_results(args.file) as results:
        warn_if_incomplete(results)
        mesh, group = results.mesh(), results.group(args.group)
        times, fields = group.displacements()
        if fields.ndim != 3 or fields.shape[1:] != (len(mesh.x), 5):
            raise ResultsError(f"{results.path}: {group.name}/u does not fit the mesh")
        progress, unit = group.progress_name, group.progress_unit
        strip = build_strip(mesh, results.path)
    rows = frame_rows(times, args.frames)
    with plt.rc_context(STYLE):
        film = Film(strip, mesh, fields[rows], args)
        with writer.saving(film.figure, path, DPI):
            for number, row in enumerate(rows):
                film.show(number, f"{progress.lower()} {times[row]:.4g} {unit}".rstrip())
                writer.grab_frame()
    plt.close(film.figure)
    print(f"wrote {path}: {len(rows)} frames, {len(rows) / args.fps:.3g} s")


def frame_rows(times, count):
    """Rows nearest to `count` instants spread evenly over the solution, each once."""
    count = min(count, len(times))
    wanted = np.linspace(0, len(times) - 1, count)
    if np.all(np.diff(times) > 0.0):
        instants = np.linspace(times[0], times[-1], count)
        wanted = np.interp(instants, times, np.arange(len(times)))
    return np.unique(np.round(wanted).astype(int))


class Film:
    """The figure of one frame, and how it goes on to the next."""

    def __init__(self, strip, mesh, fields, args):
        self.strip, self.name = strip, args.colour
        self.places = [places(strip, row) for row in fields]
        self.values = None if args.colour == "none" else [strains(strip, row)[args.colour] for row in fields]
        low, high = self.extent(mesh, supports=not args.no_supports)
        width, height = args.size or (WIDTH, self.fitting_height(low, high))
        self.figure, self.axis = plt.subplots(
            layout="constrained", figsize=self.even_pixels(width, height), dpi=DPI
        )
        self.axis.set_aspect("equal", adjustable="box")
        self.axis.set_xlim(low[0], high[0])
        self.axis.set_ylim(low[1], high[1])
        self.axis.set_xlabel(axis_label("$x_1$", mesh.unit))
        self.axis.set_ylabel(axis_label("$x_3$", mesh.unit))
        if not args.no_supports:
            for node in np.flatnonzero(mesh.fixed.any(axis=1)):
                draw_support(self.axis, mesh, node, support_size(mesh))
        self.clock = self.axis.set_title(" ", fontsize=9)
        if args.title:
            self.figure.suptitle(escape(args.title), fontsize=9)
        self.parts = []
        self.colours = {} if self.values is None else self.colour_scale(args.range)

    @staticmethod
    def even_pixels(width, height):
        """Inches for the millimetres, of a whole and even number of pixels: films ask for that."""
        return [2.0 * round(0.5 * length * MILLIMETRES * DPI) / DPI for length in (width, height)]

    def extent(self, mesh, supports):
        points = np.concatenate([frame.reshape(-1, 2) for frame in self.places])
        if not np.isfinite(points).all():
            raise ResultsError("the motion holds numbers that are not finite")
        if supports:
            reach = 1.3 * support_size(mesh)
            held = mesh.x[mesh.fixed.any(axis=1)]
            points = np.concatenate([points, *[[[x - reach, -reach], [x + reach, reach]] for x in held]])
        low, high = points.min(axis=0), points.max(axis=0)
        margin = 0.04 * max(high - low)
        return low - margin, high + margin

    @staticmethod
    def fitting_height(low, high):
        height = (WIDTH - 40.0) * (high[1] - low[1]) / (high[0] - low[0]) + 24.0
        return float(np.clip(height, *HEIGHTS))

    def colour_scale(self, wanted):
        middle = REST.get(self.name, 0.0)
        reach = max(np.abs(frame - middle).max() for frame in self.values) or 1e-12
        low, high = wanted or (middle - reach, middle + reach)
        look = {"cmap": "RdBu_r", "vmin": low, "vmax": high}
        bar = self.figure.colorbar(
            plt.cm.ScalarMappable(plt.Normalize(low, high), look["cmap"]),
            ax=self.axis,
            label=LABELS[self.name],
            fraction=0.05,
        )
        bar.outline.set_linewidth(0.6)
        return look

    def show(self, number, clock):
        for part in self.parts:
            part.remove()
        place = self.places[number]
        self.parts = []
        for first, end in zip(self.strip.ends, self.strip.ends[1:]):
            x, z = place[first:end, :, 0], place[first:end, :, 1]
            if self.values is None:
                self.parts += self.axis.fill(
                    np.concatenate([x[:, 0], x[::-1, -1]]),
                    np.concatenate([z[:, 0], z[::-1, -1]]),
                    color="0.8",
                )
            else:
                values = self.values[number][first:end]
                self.parts.append(self.axis.pcolormesh(x, z, values, shading="gouraud", **self.colours))
            for face in (0, -1):
                self.parts += self.axis.plot(x[:, face], z[:, face], color="black", linewidth=0.6)
        for end, column in ((0, 0), (-1, -1)):
            self.parts += self.axis.plot(*place[column].T, color="black", linewidth=0.6)
        self.clock.set_text(clock)


if __name__ == "__main__":
    run_script(main)

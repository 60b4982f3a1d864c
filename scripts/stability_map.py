#!/usr/bin/env python3
"""Runs the stability scenes by every scheme over a grid of steps and draws a map of where each one fails.

One map a scene: a panel for every Jm, a row for every scheme, a column for every step. A cell shows by
colour, hatching and symbol what became of the run; the figure in it is how far the energy balance drifts, in
per cent of the largest energy (negative: lost), or the part of the run after which it stopped. A table of the
same goes beside each picture.

examples:
  stability_map.py                                   all scenes, into results/stability
  stability_map.py --quick -o /tmp/maps              every other step, one Jm
  stability_map.py --scene spinning --scene thin     two of them
"""

import argparse
import csv
import os
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np
from matplotlib.patches import Rectangle

from gentbeam_pictures import MILLIMETRES, STYLE, UNLIMITED_JM, plt, save_picture
from gentbeam_results import Parser, ResultsError, run_script

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "stability"))
from scenes import SCENES, SCHEMES, run  # noqa: E402

# Kind of outcome: face, hatching, ink, sign, words of the legend. Lightness alone tells the five apart.
LOOKS = {
    "completed": ("#FFFFFF", "", "#000000", "", "completed"),
    "cut": ("#CBE3F5", "....", "#000000", "", "completed, steps cut"),
    "loses": ("#8DBBDD", "\\\\\\\\", "#000000", "\u2212", "energy lost, more than 1 %"),
    "gains": ("#E69F00", "////", "#000000", "+", "energy gained, more than 1 %"),
    "failed": ("#2B2B2B", "", "#FFFFFF", "\u00d7", "stopped: could not be solved"),
}
HATCHING = "#FFFFFF80"
NAMES = {"generalized": "generalized (0.8)", "hht": "hht (\u22120.05)", "bathe": "bathe (0)"}
REASONS = {
    "inadmissible": "I",
    "not converged": "N",
    "diverged": "N",
    "no decrease": "N",
    "step limit": "L",
    "singular": "S",
    "endless": "T",
}
REASON_WORDS = {
    "I": "no admissible state",
    "N": "Newton's method did not converge",
    "L": "step far beyond the explicit limit",
    "S": "singular tangent",
    "T": "no end in the time allowed",
    "B": "broke down",
}
FOOTNOTE = "Number of steps in the run.  In the cells: drift of the energy balance, or where the run stopped"
COLUMNS = "scene jm scheme step outcome reason reached_time end_time drift_percent cuts".split()
SECONDS = 300


def parse_arguments():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--scene", action="append", metavar="NAME", help=f"only this one (repeatable): {', '.join(SCENES)}"
    )
    parser.add_argument("--quick", action="store_true", help="every other step and the first Jm only")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        default=str(ROOT / "results" / "stability"),
        help="(results/stability; those of docs/ are in docs/pictures)",
    )
    parser.add_argument(
        "--program",
        metavar="FILE",
        default=str(ROOT / "build" / "release" / "gentbeam"),
        help="the executable (build/release/gentbeam)",
    )
    parser.add_argument(
        "--jobs", type=int, metavar="N", default=os.cpu_count() or 1, help="runs side by side (all cores)"
    )
    args = parser.parse_args()
    for name in args.scene or ():
        if name not in SCENES:
            parser.error(f"no scene '{name}' (there are: {', '.join(SCENES)})")
    if args.jobs < 1:
        parser.error("--jobs: at least 1")
    if not (os.path.isfile(args.program) and os.access(args.program, os.X_OK)):
        raise ResultsError(f"{args.program}: no such program; build it, or name it with --program")
    args.program = os.path.abspath(args.program)
    return args


def run_one(program, name, scheme, step, jm):
    """One cell of a map."""
    with tempfile.TemporaryDirectory() as folder:
        outcome = run(program, SCENES[name], scheme, step, jm, folder, SECONDS)
    kind = outcome.kind
    if kind == "energy":
        kind = "gains" if outcome.drift > 0.0 else "loses"
    elif kind not in ("completed", "cut"):
        kind = "failed"
    return {
        "scene": name,
        "jm": jm,
        "scheme": scheme,
        "step": step,
        "outcome": kind,
        "reason": {"endless": "endless", "broken": "broken"}.get(outcome.kind, outcome.reason),
        "reached_time": outcome.time,
        "end_time": SCENES[name].end,
        "drift_percent": 100.0 * outcome.drift,
        "cuts": outcome.cuts,
    }


def grid(scene, quick):
    steps = scene.steps[::2] if quick else scene.steps
    jms = scene.jms[:1] if quick else scene.jms
    return [(scheme, step, jm) for jm in jms for scheme in scene.schemes for step in steps]


def run_all(args, names):
    """The cells of every scene, with progress on standard error."""
    cells = {name: [] for name in names}
    with ProcessPoolExecutor(args.jobs) as pool:
        waiting = [
            pool.submit(run_one, args.program, name, *point)
            for name in names
            for point in grid(SCENES[name], args.quick)
        ]
        for count, done in enumerate(as_completed(waiting), 1):
            cell = done.result()
            cells[cell["scene"]].append(cell)
            show_progress(count, len(waiting), cell)
    return cells


def show_progress(count, total, cell):
    if sys.stderr.isatty():
        words = f"{cell['scene']} {cell['scheme']} {cell['step']:g}"
        print(f"\r{count}/{total}  {words:40.40}", end="\n" if count == total else "", file=sys.stderr)
    elif count == total or count % max(1, total // 10) == 0:
        print(f"{count}/{total} runs", file=sys.stderr)


def write_table(path, cells):
    order = list(SCHEMES)
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for cell in sorted(cells, key=lambda c: (c["jm"], order.index(c["scheme"]), -c["step"])):
            writer.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in cell.items()})
    print(f"wrote {path}")


def letter(cell):
    return REASONS.get(cell["reason"], "B")


def cell_words(cell):
    """The figure in a cell: drift of the energy, or where in the run it stopped and why."""
    if cell["outcome"] == "failed":
        if cell["reached_time"] == 0.0:
            return f"{letter(cell)} at once"
        part = min(99.0, 100.0 * cell["reached_time"] / cell["end_time"])
        return f"{letter(cell)} at {part:.0f}%" if part >= 1.0 else f"{letter(cell)} at <1%"
    drift = abs(cell["drift_percent"])
    if drift < 0.005:
        return "<0.01%"
    if drift >= 9.5:
        return f"{drift:.0f}%"
    return f"{drift:.1f}%" if drift > 1.0 else f"{min(drift, 0.99):.2f}%"


def draw_map(name, cells):
    """The map of a scene: panels side by side, one for each Jm."""
    scene = SCENES[name]
    jms = sorted({cell["jm"] for cell in cells})
    steps = sorted({cell["step"] for cell in cells}, reverse=True)
    schemes = [scheme for scheme in scene.schemes if any(cell["scheme"] == scheme for cell in cells)]
    width, height = 9.6 * len(steps), 6.2 * len(schemes)
    left, gap, right, top = 24.0, 4.0, 3.0, 13.0
    stopped = sorted({letter(cell) for cell in cells if cell["outcome"] == "failed"})
    bottom = 24.0 + 3.6 * max(0, len(stopped) - 1)
    size = (max(162.0, left + right + len(jms) * width + (len(jms) - 1) * gap), top + bottom + height)
    figure = plt.figure(figsize=[length * MILLIMETRES for length in size])
    for column, jm in enumerate(jms):
        box = (left + column * (width + gap), bottom, width, height)
        axis = figure.add_axes([box[0] / size[0], box[1] / size[1], box[2] / size[0], box[3] / size[1]])
        draw_panel(axis, [cell for cell in cells if cell["jm"] == jm], schemes, steps, scene.end)
        axis.set_title(r"$J_m = \infty$" if jm > UNLIMITED_JM else f"$J_m = {jm:g}$", pad=4)
        axis.set_yticks(range(len(schemes)), [NAMES.get(s, s) for s in schemes] if column == 0 else [])
    place = left / size[0]
    figure.text(place, 1.0 - 4.5 / size[1], scene.title, fontsize=10, va="center")
    figure.text(place, (bottom - 9.0) / size[1], FOOTNOTE, fontsize=8, va="center")
    draw_legend(figure, size, left, stopped)
    return figure


def draw_panel(axis, cells, schemes, steps, end):
    for cell in cells:
        x, y = steps.index(cell["step"]), schemes.index(cell["scheme"])
        face, hatch, ink, sign, _ = LOOKS[cell["outcome"]]
        add_swatch(axis, (x - 0.5, y - 0.5, 1, 1), face, hatch)
        box = {"boxstyle": "round,pad=0.12", "facecolor": face, "edgecolor": "none"}
        words = f"{sign}{cell_words(cell)}" if cell["outcome"] != "failed" else f"{sign} {cell_words(cell)}"
        axis.text(x, y, words, ha="center", va="center", fontsize=5.4, color=ink, bbox=box)
    axis.set_xlim(-0.5, len(steps) - 0.5)
    axis.set_ylim(len(schemes) - 0.5, -0.5)
    axis.set_xticks(range(len(steps)), [f"{end / step:.0f}" for step in steps])
    axis.set_xticks(np.arange(0.5, len(steps) - 1), minor=True)
    axis.set_yticks(np.arange(0.5, len(schemes) - 1), minor=True)
    axis.grid(which="minor", color="#808080", lw=0.4)
    axis.tick_params(which="both", length=0)
    for side in axis.spines.values():
        side.set(visible=True, linewidth=0.6)


def add_swatch(axis, box, face, hatch):
    x, y, width, height = box
    axis.add_patch(Rectangle((x, y), width, height, facecolor=face, hatch=hatch, edgecolor=HATCHING, lw=0))


def draw_legend(figure, size, left, stopped):
    """A swatch for every kind, in two lines, and the letters of the reasons below."""
    places = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0)]
    axis = figure.add_axes([0, 0, 1, 1])
    axis.set(xlim=(0, size[0]), ylim=(0, size[1]))
    axis.axis("off")
    base = 2.0 + 3.6 * max(0, len(stopped) - 1)
    for (face, hatch, ink, sign, words), (column, line) in zip(LOOKS.values(), places):
        x, y = left + 42.0 * column, base + 6.5 - 4.6 * line
        add_swatch(axis, (x, y - 1.6, 5.0, 3.2), face, hatch)
        axis.add_patch(Rectangle((x, y - 1.6), 5.0, 3.2, facecolor="none", edgecolor="#404040", lw=0.5))
        if sign:
            box = {"boxstyle": "round,pad=0.05", "facecolor": face, "edgecolor": "none"}
            axis.text(x + 2.5, y, sign, ha="center", va="center", fontsize=6, color=ink, bbox=box)
        axis.text(x + 6.5, y - 0.1, words, va="center", fontsize=7.5)
    for line, name in enumerate(stopped):
        place = (left + 84.0 + 6.5, base + 2.0 - 3.6 * line)
        axis.text(*place, f"{name}: {REASON_WORDS[name]}", va="center", fontsize=7)


def main():
    args = parse_arguments()
    names = list(dict.fromkeys(args.scene or SCENES))
    folder = Path(args.output)
    folder.mkdir(parents=True, exist_ok=True)
    cells = run_all(args, names)
    for name in names:
        write_table(folder / f"stability_{name}.csv", cells[name])
        with plt.rc_context({**STYLE, "hatch.linewidth": 0.5}):
            save_picture(draw_map(name, cells[name]), str(folder / f"stability_{name}.png"))


if __name__ == "__main__":
    run_script(main)

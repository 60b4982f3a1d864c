#!/usr/bin/env python3
"""Holds `auto` against truth and against the best setting by hand, scene by scene.

The true error is that against a run of the same scene far finer than either: its own error, from the same
on half the mesh and half the steps, is noted beside it. The best setting by hand is the cheapest of a grid
of meshes, steps and inertias that is good enough and stays so when it is refined: its true error, and that
of every setting of the grid with as many elements and steps or more, is below the accuracy asked for. (What
is only good by luck, because errors of mesh and step undo each other at one place, is nothing that a person
could choose without knowing the truth.) The trial runs that a person would need to find it cost nothing
here, while those of `auto` all count.

Writes docs/choosing-a-model.md's table, docs/pictures/auto.csv and docs/pictures/auto.png.
"""

import argparse
import csv
import itertools
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np

from auto_scenes import all_scenes
from gentbeam_pictures import COLOURS, MILLIMETRES, STYLE, plt, save_picture
from gentbeam_runs import ROOT, program

PAGE = ROOT / "docs" / "choosing-a-model.md"
PICTURES = ROOT / "docs" / "pictures"
BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"
ROUNDS = 3
FINEST = {"elements": 96, "steps": 16000, "points": 6}
# Without start-up, times below this are not told from it [ms].
SMALLEST = 0.3
# Slopes next to an interval so many times as long as its neighbour mean nothing.
UNEVEN = 8.0
COLUMNS = (
    "scene", "accuracy", "estimate", "true_error", "ratio", "reference_error", "rungs", "chosen", "by_hand",
    "loop_ms", "loop_by_hand_ms", "loop_ratio", "process_ms", "process_by_hand_ms", "process_ratio",
)  # fmt: skip


@dataclass(frozen=True)
class Setting:
    elements: int
    steps: int
    points: int = 3
    inertia: str = "diagonal"
    scheme: str = "newmark"

    def __str__(self):
        model = f"gauss {self.points}, {self.inertia}, {self.scheme}"
        return f"{self.elements} elements, {model}, {self.steps} steps"


@dataclass
class Run:
    time: np.ndarray
    values: np.ndarray
    seconds: float  # CPU time that the program notes
    process: float  # user and system time of the process
    tuning: dict


def run_deck(deck, task):
    """One run in a process of its own; None where it failed."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.inp"
        path.write_text(deck)
        child = subprocess.Popen(
            [program(), "-q", "-o", str(Path(folder) / "scene"), str(path)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
        words = child.stderr.read()
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            return words.strip()
        with h5py.File(Path(folder) / "scene.h5") as file:
            probes = file[task]["probes"]
            tuning = {}
            if "tuning" in file:
                tuning = dict(file["tuning"].attrs)
                tuning["rungs"] = file["tuning/rungs/work"].size
            return Run(
                probes["time"][()],
                probes["tip"][()],
                float(file.attrs["cpu_seconds"]),
                usage.ru_utime + usage.ru_stime,
                tuning,
            )


def cheapest_of(deck, task, rounds=ROUNDS):
    """The run, with the least times of several."""
    runs = [run_deck(deck, task) for _ in range(rounds)]
    for run in runs:
        if isinstance(run, str):
            return run
    runs[0].seconds = min(run.seconds for run in runs)
    runs[0].process = min(run.process for run in runs)
    return runs[0]


def sampled(run, instants):
    """Values of a run between its rows, by the cubic that has their slopes."""
    slopes = np.gradient(run.values, run.time, edge_order=2 if run.time.size > 2 else 1)
    i = np.clip(np.searchsorted(run.time, instants) - 1, 0, run.time.size - 2)
    h = run.time[i + 1] - run.time[i]
    steps = np.diff(run.time)
    shortest = np.minimum(np.append(steps[0], steps), np.append(steps, steps[-1]))
    chord = (run.values[i + 1] - run.values[i]) / h
    left = np.where(h > UNEVEN * shortest[i], chord, slopes[i])
    right = np.where(h > UNEVEN * shortest[i + 1], chord, slopes[i + 1])
    s = (instants - run.time[i]) / h
    return (
        (1 + 2 * s) * (1 - s) ** 2 * run.values[i]
        + s**2 * (3 - 2 * s) * run.values[i + 1]
        + s * (1 - s) * h * ((1 - s) * left - s * right)
    )


def error(run, truth, scene):
    """Relative difference, root mean square over time; of a static command where it ends."""
    if not scene.end:
        return abs(run.values[-1] - truth.values[-1]) / np.abs(truth.values).max()
    instants = np.linspace(0.0, scene.end, 4001)[1:]
    expected = sampled(truth, instants)
    return float(np.sqrt(np.mean((sampled(run, instants) - expected) ** 2) / np.mean(expected**2)))


def finest(scene, coarser=1):
    elements = -(-FINEST["elements"] // coarser // scene.unit) * scene.unit
    steps = FINEST["steps"] // coarser if scene.end else 20
    inertia = "full" if scene.end else "diagonal"
    return run_deck(scene.by_hand(Setting(elements, steps, FINEST["points"], inertia)), scene.task)


def grid(scene, around):
    """Settings worth trying by hand, round the one that the program has chosen."""
    elements = sorted({max(1, round(around.elements * f / scene.unit)) * scene.unit for f in
                       (0.4, 0.5, 0.6, 0.75, 0.9, 1.0, 1.25, 1.6, 2.0)})  # fmt: skip
    if scene.end:
        steps = sorted({max(4, round(around.steps * 2.0 ** (k / 3))) for k in range(-8, 5)})
    else:
        steps = (1, 2, 4)
    inertias = ("diagonal", "full") if around.inertia == "full" and scene.end else ("diagonal",)
    schemes = ("newmark", around.scheme) if around.scheme != "newmark" else ("newmark",)
    for n, count, inertia, scheme in itertools.product(elements, steps, inertias, schemes):
        yield Setting(n, count, 3, inertia, scheme)


def stays_good(setting, errors, scene):
    """Whether a setting and all that are at least as fine are good enough."""
    return all(
        errors[other] <= scene.accuracy
        for other in errors
        if (other.inertia, other.scheme) == (setting.inertia, setting.scheme)
        and other.elements >= setting.elements
        and other.steps >= setting.steps
    )


def best_by_hand(scene, truth, around):
    """The cheapest setting of the grid that stays good enough: those that are near it are measured again."""
    errors, seconds = {}, {}
    for setting in grid(scene, around):
        run = run_deck(scene.by_hand(setting), scene.task)
        failed = isinstance(run, str)
        errors[setting] = np.inf if failed else error(run, truth, scene)
        seconds[setting] = np.inf if failed else run.seconds
    good = [setting for setting in errors if stays_good(setting, errors, scene)]
    best = None
    for setting in sorted(good, key=seconds.get)[:5]:
        run = cheapest_of(scene.by_hand(setting), scene.task)
        if best is None or run.seconds < best[0].seconds:
            best = (run, setting)
    return best


def measure(scene):
    truth, half = finest(scene), finest(scene, coarser=2)
    run = cheapest_of(scene.by_program(), scene.task)
    row = {"scene": scene.name, "accuracy": scene.accuracy}
    for words in (truth, half, run):
        if isinstance(words, str):
            row["chosen"] = words
            return row
    tuning = run.tuning
    inertia = tuning["inertia"] if isinstance(tuning["inertia"], str) else tuning["inertia"].decode()
    scheme = tuning["scheme"] if isinstance(tuning["scheme"], str) else tuning["scheme"].decode()
    chosen = Setting(int(tuning["elements"]), int(tuning["steps"]), int(tuning["points"]), inertia, scheme)
    adaptive = "local_accuracy" in tuning
    true_error = error(run, truth, scene)
    row |= {
        "estimate": float(tuning["estimate"]),
        "true_error": true_error,
        "ratio": true_error / float(tuning["estimate"]),
        "reference_error": error(half, truth, scene),
        "rungs": tuning["rungs"],
        "chosen": str(chosen) + (", adaptive" if adaptive else ""),
        "process_ms": 1e3 * run.process,
    }
    best = best_by_hand(scene, truth, replace(chosen, steps=3 * chosen.steps) if adaptive else chosen)
    if best:
        row |= {
            "by_hand": str(best[1]),
            "process_by_hand_ms": 1e3 * best[0].process,
            "process_ratio": run.process / best[0].process,
        }
        if scene.end:
            start = cheapest_of(scene.by_hand(replace(best[1], steps=1)), scene.task)
            idle = 0.0 if isinstance(start, str) else start.seconds
            row["loop_ms"] = 1e3 * (run.seconds - idle)
            row["loop_by_hand_ms"] = 1e3 * (best[0].seconds - idle)
            if row["loop_by_hand_ms"] > SMALLEST:
                row["loop_ratio"] = row["loop_ms"] / row["loop_by_hand_ms"]
    return row


def write_csv(path, rows):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})


def read_csv(path):
    with open(path, newline="") as file:
        return [{k: number(v) for k, v in row.items()} for row in csv.DictReader(file)]


def number(word):
    try:
        return float(word)
    except ValueError:
        return word


def cells(row, width=3):
    """The row of the page's table."""
    if row["estimate"] == "":
        return f"| {row['scene']} | {row['accuracy']:g} | {row['chosen']} | | | | | |"
    ratios = ("ratio", "process_ratio", "loop_ratio")
    words = [f"{row[k]:.{width - 1}g}" if row.get(k, "") != "" else "-" for k in ratios]
    return (
        f"| {row['scene']} | {row['accuracy']:g} | {row['chosen']} | {row['estimate']:.2g} | "
        f"{row['true_error']:.2g} | {words[0]} | {words[1]} | {words[2]} |"
    )


def summary(rows):
    """What the table says, in two sentences."""
    honesty, process, loop = (
        [row[name] for row in rows if row[name] != ""] for name in ("ratio", "process_ratio", "loop_ratio")
    )
    within = sum(ratio <= 4 for ratio in process)
    return (
        f"The true error is {min(honesty):.2g} to {max(honesty):.2g} of the estimate. The process takes "
        f"{min(process):.2g} to {max(process):.2g} times\n"
        f"the CPU time of the best by hand, at most 4 in {within} of {len(process)} scenes; "
        f"without start-up {min(loop):.2g} to {max(loop):.2g} times."
    )


def write_page(rows):
    head = (
        "| scene | accuracy | chosen | estimate | true error | true/estimate | cost/best, process | "
        "cost/best, loop |\n|---|---|---|---|---|---|---|---|"
    )
    text = PAGE.read_text()
    table = "\n".join([head, *(cells(row) for row in rows), "", summary(rows)])
    before, after = text.index(BEGIN) + len(BEGIN), text.index(END)
    PAGE.write_text(f"{text[:before]}\n\n{table}\n\n{text[after:]}")


def draw(rows, path):
    rows = [row for row in rows if row["estimate"] != ""]
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(170 * MILLIMETRES, 112 * MILLIMETRES))
        draw_honesty(figure.add_axes((0.085, 0.11, 0.40, 0.80)), rows)
        draw_cost(figure.add_axes((0.685, 0.11, 0.295, 0.80)), rows)
        save_picture(figure, path)


def draw_honesty(axis, rows):
    limits = np.array([3e-6, 5e-2])
    axis.fill_between(limits, 0.1 * limits, 2 * limits, color="#E6EEF6", linewidth=0)
    axis.plot(limits, limits, "-", color="0.6", linewidth=0.7)
    looks = ((True, COLOURS[2], "o", "TRANSIENT"), (False, COLOURS[1], "s", "STATIC"))
    for moving, colour, marker, label in looks:
        mine = [row for row in rows if (row["loop_ms"] != "") == moving]
        axis.loglog(
            [row["estimate"] for row in mine],
            [row["true_error"] for row in mine],
            marker,
            color=colour,
            markersize=4,
            markerfacecolor="none",
            label=f"{label} auto",
        )
    axis.set(xlim=limits, ylim=(1e-6, 5e-2), xlabel="estimated error", ylabel="true error")
    axis.set_title("error bars: true against estimated", loc="left")
    axis.text(2.2e-4, 7e-6, "band: true/estimate\nfrom 0.1 to 2", color="0.4", fontsize=8)
    axis.legend(frameon=False, loc="upper left", fontsize=8)


def draw_cost(axis, rows):
    places = np.arange(len(rows))[::-1]
    axis.axvline(4, color="0.6", linewidth=0.7, linestyle="--")
    axis.axvline(1, color="0.6", linewidth=0.7)
    process, loop = ([row[k] or np.nan for row in rows] for k in ("process_ratio", "loop_ratio"))
    axis.semilogx(process, places, "o", color=COLOURS[2], markersize=3.5, label="whole process")
    axis.semilogx(
        loop, places, "d", color=COLOURS[6], markersize=3.5, markerfacecolor="none", label="without start-up"
    )
    axis.set_yticks(places, [row["scene"] for row in rows], fontsize=6.5)
    axis.set_ylim(-0.7, len(rows) - 0.3)
    axis.set_xlabel("CPU time over that of the best setting by hand", fontsize=8)
    axis.set_title("cost, all trials included", loc="left")
    axis.legend(frameon=False, loc="lower right", fontsize=7, bbox_to_anchor=(1.03, 0.02))


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scene", help="only scenes whose name holds this; nothing is written")
    parser.add_argument("--draw", action="store_true", help="measure nothing: page and picture from the CSV")
    args = parser.parse_args()
    table = PICTURES / "auto.csv"
    if not args.draw:
        rows = []
        for scene in all_scenes():
            if args.scene and args.scene not in scene.name:
                continue
            rows.append(measure(scene))
            print({k: f"{v:.3g}" if isinstance(v, float) else v for k, v in rows[-1].items()}, flush=True)
        if args.scene:
            return
        write_csv(table, rows)
    rows = read_csv(table)
    write_page(rows)
    draw(rows, PICTURES / "auto.png")


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Runs a deck by every scheme, mesh, element and section rule, and charts error against CPU time.

For every deck NAME, in FOLDER/pictures: work_precision_NAME.png and work_precision_NAME.csv. With the decks
of the three examples, the default, also FOLDER/work-precision.md.

Errors are relative, in the L2 norm over time, of the history of one probe: against the beam's own limit in
mesh and step (the same section rule), and against a two-dimensional continuum or, where none is given, the
finest beam. What is timed is said in work_precision_runs.py. Other programs that are found here compute
input/cantilever.inp too: OpenSeesPy, Exudyn and Kratos in the interpreter --peers names, CalculiX as ccx.

examples:
  work_precision.py                                   the three examples, into docs
  work_precision.py my.inp --probe tip -o /tmp/charts
  work_precision.py --quick -o /tmp/charts            a few runs, to try it out
"""

import argparse
import csv
import platform
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

import work_precision_grid as grid
from gentbeam_results import Parser, ResultsError, run_script, text
from gentbeam_runs import ROOT, program
from work_precision_page import write_page
from work_precision_picture import draw
from work_precision_runs import GentbeamRunner, RunFailed
from work_precision_scene import History, Scene, Setting, distance

# The decks that a continuum has been computed for: its table and the column that the first probe follows.
CONTINUUM = {
    "cantilever": ("continuum_case1_Jm1e20.csv", "u3_10"),
    "two_span": ("continuum_case2_Jm1e20.csv", "u3_3"),
    "sliding": ("continuum_case3_Jm1e20.csv", "u3_12"),
}
EXAMPLES = tuple(ROOT / "input" / f"{name}.inp" for name in CONTINUUM)
WITH_PEERS = "cantilever"
COLUMNS = (
    "program,version,series,scheme,nodes,rule,elements,steps,accuracy,error,total_error,loop_seconds,"
    "process_seconds,runs,front_loop,front_process,front_total,failure"
).split(",")
# Points this close to what the reference itself may be off are not told from it.
CLOSE = 2.0
# A rule whose finest meshes still differ by this much has no limit (gauss 2 on inner supports).
UNSETTLED = 0.05


@dataclass
class Chart:
    """All that a picture, a table and a page are made from."""

    scene: Scene
    cases: list
    references: dict  # by series
    model: str  # what total errors are against
    model_is_beam: bool  # where there is no other truth
    model_errors: dict  # by section rule: of the converged beam
    missing: list  # programs that are not here, and why
    machine: str = ""
    fronts: dict = field(default_factory=dict)

    @property
    def failed(self):
        return [case for case in self.cases if case.failure]

    @property
    def done(self):
        return [case for case in self.cases if not case.failure]


def parse_arguments():
    words = __doc__.split("\n\n", 1)
    parser = Parser(
        description=words[0], epilog=words[1], formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("decks", nargs="*", type=Path, help="default: the three examples of input/")
    add("-o", "--output", type=Path, default=ROOT / "docs", metavar="FOLDER", help="default: docs")
    add("--probe", help="the probe that is followed (default: the deck's first)")
    add("--set", action="append", default=[], metavar="NAME=VALUE", help="as gentbeam's --set")
    add("--against", metavar="FILE:COLUMN", help="a table of the history to take as the truth")
    add("--elements", type=int, nargs="+", help="numbers of elements (default: by the deck's)")
    add("--steps", type=int, nargs="+", help="numbers of steps")
    add("--rounds", type=int, default=5, help="how often a short run is measured (default: 5)")
    add("--limit", type=int, default=20, help="seconds a run may take (default: 20)")
    add("--peers", default=sys.executable, metavar="PYTHON", help="interpreter with the peers")
    add("--no-peers", action="store_true", help="gentbeam alone")
    add("--quick", action="store_true", help="few runs and a coarse reference")
    args = parser.parse_args()
    if min(args.steps or [2]) < 2 or min(args.elements or [1]) < 1 or args.rounds < 1:
        parser.error("--steps from 2, --elements and --rounds from 1 on")
    return args


def read_table(path, column):
    """A history from a table with a header line, time first; lines with # are comments."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.reader(line for line in file if not line.startswith("#")))
        numbers = np.array(rows[1:], dtype=float)
        return History(numbers[:, 0], numbers[:, rows[0].index(column)])
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror}") from error
    except (ValueError, IndexError) as error:
        raise ResultsError(f"{path}: no table with a column {column}: {error}") from error


def truth(scene, args):
    """The history of what the beam is a model of, and its name; None where there is no such table."""
    if args.against:
        path, _, column = args.against.rpartition(":")
        return read_table(path, column), f"{Path(path).name}, {column}"
    if scene.path.resolve() in EXAMPLES and not args.set and not args.probe:
        name, column = CONTINUUM[scene.name]
        return read_table(ROOT / "scripts" / "data" / name, column), "the two-dimensional continuum"
    return None, ""


def accepts_mesh(scene, folder):
    """Whether the places a deck names are nodes of a mesh, as the program itself sees it."""

    def accepts(elements, nodes):
        deck = scene.deck(Setting("newmark", "gauss 3", nodes, elements, 100))
        chosen = [word for pair in scene.parameters for word in ("--set", pair)]
        command = [program(), "--check", *chosen]
        done = subprocess.run(command, input=deck, cwd=folder, text=True, capture_output=True, check=False)
        if done.returncode and "node" not in done.stderr:
            raise ResultsError(f"{scene.path}: {done.stderr.strip().splitlines()[0]}")
        return done.returncode == 0

    return accepts


def gentbeam_cases(scene, runner, args, accepts):
    """Cases of the deck, and the references of their section rules, by series and by rule."""
    series = grid.gentbeam_series(scene, accepts, args.quick, args.elements, args.steps)
    fineness = 2 if args.quick else 4
    elements = next(n for n in (fineness * scene.elements, 2 * scene.elements) if accepts(n // 2, 3))
    by_rule = {}
    for rule in dict.fromkeys([scene.rule(), *(one.rule for one in series)]):
        # The resultants of rule linear need a scheme that damps, and cost more.
        scheme, steps = ("bathe", 2000) if rule == "linear" else ("newmark", 16000)
        try:
            setting = Setting(scheme, rule, 3, elements, 400 if args.quick else steps)
            by_rule[rule] = grid.make_reference(runner, setting)
        except RunFailed as failed:
            if rule == scene.rule():
                raise ResultsError(f"{scene.path}: no reference: {failed}") from failed
            by_rule[rule] = None
        if rule != scene.rule() and by_rule[rule] and by_rule[rule].uncertainty > UNSETTLED:
            by_rule[rule] = None
    cases = [case for one in series for case in grid.cases(one, runner)]
    return cases, {one.label: by_rule[one.rule] for one in series}, by_rule


def peer_cases(args, folder):
    """The same of the other programs that are here, and what is missing."""
    cases, references, missing = [], {}, []
    for label, runner, elements, steps, (fine, number) in grid.peers(args.peers, folder, 10 * args.limit):
        reason = runner.missing()
        if reason:
            missing.append(f"{runner.name}: {reason}")
            continue
        if args.quick:
            elements, steps, fine, number = elements[:1], (50,), 2 * elements[0], 100
        series = grid.Series(label, "peer", "newmark", "", 2, elements, steps)
        try:
            setting = Setting("newmark", "", 2, fine, number)
            references[label] = grid.make_reference(runner, setting, linear=True)
        except RunFailed as failed:
            missing.append(f"{label}: no reference: {failed}")
            continue
        cases += grid.cases(series, runner)
    return cases, references, list(dict.fromkeys(missing))


def measure(cases, references, model, rounds):
    """All cases in turn, round after round, so that each meets all moods of the machine."""
    for number in range(rounds):
        starts = {id(case.start): case.start for case in cases if not case.failure}
        for start in starts.values():
            start.measure()
        for case in cases:
            if not (case.failure or case.settled(number)):
                case.measure()
        if number == 0:
            for case in cases:
                find_errors(case, references[case.series.label], model)
            for case in cases:
                case.hopeless = grid.hopeless(case, [o for o in cases if o.series == case.series])
        print(f"round {number + 1} of {rounds}", file=sys.stderr)


def find_errors(case, reference, model):
    if case.failure:
        return
    if reference is not None:
        error = distance(case.history, reference.history)
        if error > CLOSE * reference.uncertainty:
            case.errors["own"] = error
    if model is not None and case.series.panel != "peer":
        case.errors["total"] = distance(case.history, model)


def add_fronts(chart):
    """Which cases no other case of gentbeam's beats: by loop, process and total error."""
    own = [case for case in chart.done if case.series.panel != "peer"]
    for name, error, time in (
        ("loop", "own", "loop"),
        ("process", "own", "process"),
        ("total", "total", "loop"),
    ):
        able = [case for case in own if error in case.errors and getattr(case, time) > 0.0]
        points = [(case.errors[error], getattr(case, time)) for case in able]
        chart.fronts[name] = [able[i] for i in grid.front(points)]


def machine(scene, folder):
    """Processor, compiler and version, for the picture's corner."""
    name = platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        name = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    with h5py.File(folder / "run.h5", "r") as file:
        compiler, version, revision = (
            text(file.attrs.get(key, "")) for key in ("compiler", "program_version", "git_revision")
        )
    return f"{name}; {compiler}; gentbeam {version} ({revision}); one thread"


def make_chart(path, args, folder):
    scene = Scene.read(path, args.probe, args.set)
    runner = GentbeamRunner(scene, folder, args.limit)
    accepts = accepts_mesh(scene, folder)
    cases, references, by_rule = gentbeam_cases(scene, runner, args, accepts)
    model, name = truth(scene, args)
    alone = model is None
    if alone:
        model, name = by_rule[scene.rule()].history, "the finest beam"
    missing = [f"rule {rule} has no limit to compare with" for rule, one in by_rule.items() if one is None]
    if scene.path.resolve() in EXAMPLES and scene.name == WITH_PEERS and not (args.no_peers or args.set):
        more, theirs, absent = peer_cases(args, folder)
        cases += more
        missing += absent
        references.update(theirs)
    measure(cases, references, model, args.rounds if not args.quick else 1)
    errors = {rule: distance(one.history, model) for rule, one in by_rule.items() if one}
    chart = Chart(scene, cases, references, name, alone, errors, missing)
    add_fronts(chart)
    chart.machine = machine(scene, folder)
    return chart


def write_csv(path, chart):
    with open(path, "w", newline="", encoding="utf-8") as file:
        file.write(f"# {chart.scene.name}, probe {chart.scene.probe}; {chart.machine}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for case in chart.cases:
            setting = case.setting
            row = [case.runner.name, case.version, case.series.label, setting.scheme, setting.nodes]
            row += [setting.rule, setting.elements, case.steps or setting.steps, setting.accuracy or ""]
            row += [f"{case.errors[name]:.4g}" if name in case.errors else "" for name in ("own", "total")]
            times = (case.loop, case.process) if not case.failure else ("", "")
            row += [f"{time:.4g}" if time != "" and time > 0.0 else "" for time in times] + [case.runs]
            row += [int(any(case is one for one in chart.fronts[name])) for name in chart.fronts]
            writer.writerow([*row, case.failure])
    print(f"wrote {path}")


def main():
    args = parse_arguments()
    decks = args.decks or EXAMPLES
    pictures = args.output / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    charts = []
    with tempfile.TemporaryDirectory() as folder:
        for deck in decks:
            chart = make_chart(deck, args, Path(folder))
            charts.append(chart)
            write_csv(pictures / f"work_precision_{chart.scene.name}.csv", chart)
            draw(chart, pictures / f"work_precision_{chart.scene.name}.png")
    if not args.decks:
        write_page(args.output / "work-precision.md", charts)


if __name__ == "__main__":
    run_script(main)

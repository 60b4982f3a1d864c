"""What a work-precision chart compares: series of settings, their references, and who is on the front."""

from dataclasses import dataclass, replace

from work_precision_runs import CalculixRunner, Case, PythonPeerRunner, Start
from work_precision_scene import History, Setting, distance, extrapolated

# A case this much slower than its series' best at the same error is measured once only.
HOPELESS = 1.5


@dataclass(frozen=True)
class Series:
    label: str
    panel: str  # "scheme", "model" or "peer"
    scheme: str
    rule: str
    nodes: int
    elements: tuple
    steps: tuple
    accuracies: tuple = ()

    def settings(self):
        for elements in self.elements:
            for steps in self.steps:
                yield Setting(self.scheme, self.rule, self.nodes, elements, steps)
            for accuracy in self.accuracies:
                yield Setting(self.scheme, self.rule, self.nodes, elements, 0, accuracy)


@dataclass(frozen=True)
class Reference:
    """A history converged in mesh and step, and how far it may itself be off."""

    history: object
    uncertainty: float


SCHEMES = ("newmark", "hht", "generalized", "bathe", "energy", "central")
# Ladders of steps and of elements, as parts of the deck's own; the fine one where runs are cheap.
STEPS = (25, 50, 100, 200, 400, 800, 1600, 3200)
FINE_STEPS = (18, 25, 35, 50, 71, 100, 141, 200, 283, 400, 566, 800, 1131, 1600, 2263, 3200)
PARTS = (0.25, 0.5, 1.0)
FINE_PARTS = (0.2, 0.25, 0.3, 1 / 3, 0.4, 0.5, 0.6, 2 / 3, 0.8, 1.0, 1.5, 2.0)
ACCURACIES = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
QUICK_STEPS = (50, 200)


def gentbeam_series(scene, accepts, quick=False, elements=None, steps=None):
    """The series of a deck; `accepts` says of (elements, nodes) whether its places are nodes of that mesh."""
    rule = scene.rule()

    def chosen(parts, nodes=3):
        # As many nodes for every order of elements.
        wanted = {max(1, round(scene.elements * part * 2.0 / (nodes - 1))) for part in parts}
        return tuple(n for n in sorted(elements or wanted) if accepts(n, nodes))

    if quick:
        own = chosen((0.5, 1.0))
        ladder = steps or QUICK_STEPS
        return [
            Series("newmark", "scheme", "newmark", rule, 3, own, ladder),
            Series("central", "scheme", "central", rule, 3, own, ladder),
            Series("2 nodes", "model", "newmark", rule, 2, chosen((0.5, 1.0), 2), ladder),
        ]
    fine, coarse = steps or FINE_STEPS, steps or STEPS
    made = []
    for scheme in SCHEMES:
        fast = scheme not in ("energy", "central")
        parts, ladder = (FINE_PARTS, fine) if fast else (PARTS, coarse)
        made.append(Series(scheme, "scheme", scheme, rule, 3, chosen(parts), ladder))
    made.append(Series("newmark, adaptive", "scheme", "newmark", rule, 3, chosen(FINE_PARTS), (), ACCURACIES))
    for nodes in (2, 4, 5):
        made.append(Series(f"{nodes} nodes", "model", "newmark", rule, nodes, chosen(PARTS, nodes), coarse))
    for other in ("gauss 2", "gauss 3", "gauss 4", "linear"):
        if other != rule:
            parts, ladder = (PARTS, coarse) if other == "linear" else (FINE_PARTS, fine)
            made.append(Series(other, "model", "newmark", other, 3, chosen(parts), ladder))
    return made


def peers(python, folder, limit):
    """Every other program that an adapter knows, with its grid: label, runner, elements, steps, reference."""
    common = {"python": python, "folder": folder, "limit": limit}
    opensees = ("OpenSees", "openseespy", "peer_opensees.py")
    steps = (35, 50, 71, 100, 141, 200, 283, 400, 566, 800, 1131)
    return [
        (
            "Exudyn, exact beam",
            PythonPeerRunner("Exudyn", "exudyn", "peer_exudyn.py", "beam", **common),
            (5, 8, 10, 14, 20, 28, 40),
            steps,
            (80, 8000),
        ),
        (
            "OpenSees, Timoshenko frame",
            PythonPeerRunner(*opensees, "timoshenkoBeamColumn", **common),
            (5, 8, 10, 14, 20, 28, 40),
            steps,
            (80, 4000),
        ),
        (
            "OpenSees, frame without shear",
            PythonPeerRunner(*opensees, "elasticBeamColumn", **common),
            (5, 10, 20, 40),
            steps[1::2],
            (80, 4000),
        ),
        (
            "Kratos, corotational beam",
            PythonPeerRunner("Kratos", "KratosMultiphysics", "peer_kratos.py", "CrBeamElement2D2N", **common),
            (5, 10, 20, 40),
            steps[1::2],
            (80, 4000),
        ),
        ("CalculiX, B32R", CalculixRunner("B32R", folder, limit), (2, 4), (50, 100, 200), (8, 400)),
    ]


def cases(series, runner):
    """One case a setting; those of one mesh and scheme share the cost of the first step."""
    starts = {}
    for setting in series.settings():
        key = (setting.elements, setting.nodes, setting.rule, setting.scheme)
        if key not in starts:
            starts[key] = Start(runner, replace(setting, steps=100, accuracy=0.0))
        yield Case(series, setting, runner, starts[key])


def make_reference(runner, setting, linear=False):
    """The limit of a run in its step, from it and one of twice the steps; with `linear`, in the mesh too.

    How far it may be off is told by the same on half the mesh and half the steps: of what that changes,
    methods of second order leave a third.
    """

    def limit(parts):
        some = replace(setting, elements=setting.elements // parts, steps=setting.steps // parts)
        coarse, fine = (runner.run(replace(some, steps=n)).history for n in (some.steps, 2 * some.steps))
        return extrapolated(coarse, fine)

    halves = limit(2)
    best = limit(1)
    change = distance(halves, best) / 3.0
    if linear:
        best = History(halves.time, (4.0 * best.values[::2] - halves.values) / 3.0)
    return Reference(best, change)


def front(points):
    """Indices of (error, time) pairs that no other pair beats in both, from the largest error on."""
    order = sorted(range(len(points)), key=lambda i: (points[i][1], points[i][0]))
    kept, least = [], float("inf")
    for i in order:
        if points[i][0] < least:
            kept.append(i)
            least = points[i][0]
    return kept


def hopeless(case, others):
    """Whether for every kind of error another case of its series is as exact and much cheaper."""
    return bool(case.errors) and all(
        any(
            other.errors.get(kind, 1e300) <= error and HOPELESS * other.seconds < case.seconds
            for other in others
        )
        for kind, error in case.errors.items()
    )

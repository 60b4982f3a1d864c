"""The scenes in which methods fail: a deck each, run by any scheme at any step, and what became of it.

    outcome = run("gentbeam", SCENES["spinning"], "newmark", step=1e-3, folder=folder)
    outcome.kind        # completed | energy | cut | failed | refused | endless | broken
"""

import math
import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

DECKS = Path(__file__).resolve().parent / "scenes"

# Schemes by the words that choose them in a deck.
SCHEMES = {
    "newmark": "newmark",
    "hht": "hht",
    "generalized": "generalized  rho=0.8",
    "bathe": "bathe",
    "energy": "energy",
    "central": "central",
}
# The program itself warns from here on: drift of the balance over the largest energy.
WORRYING_DRIFT = 0.01


@dataclass(frozen=True)
class Scene:
    title: str
    deck: str
    end: float
    steps: tuple  # from coarse to fine
    jms: tuple = (0.5, 3.0, 1e20)
    parameters: dict = field(default_factory=dict)
    schemes: tuple = tuple(SCHEMES)

    def settings(self, jm):
        """Parameters of the deck at this jm."""
        settings = {"jm": jm, **self.parameters}
        if self.deck == "locking":
            settings["pull"] = pull_to_locking(jm)
        return settings


def pull_to_locking(jm, part=0.95, c_over_mu=0.5):
    """Sudden force over mu A whose work as far as I1-2 = part*jm is the energy stored there (beta = -2).

    Plane uniaxial tension: sigma33 = 0 fixes the stretches. The force that holds the strip there at rest is
    about ten times as large; applied at once, it would bring I1-2 to within 1e-13 of jm: the barrier of the
    energy is a logarithm.
    """
    limit = 2.0 + part * jm

    def thickness_stress(l3):
        j = math.sqrt(limit - l3**2) * l3
        return l3**2 / (1.0 - part) - 1.0 + 0.5 * c_over_mu * (j**2 - 1.0)

    low, high = 1e-6, 1.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if thickness_stress(middle) > 0.0 else (middle, high)
    l1 = math.sqrt(limit - low**2)
    j = l1 * low
    stored = -0.5 * jm * math.log(1.0 - part) - math.log(j)
    stored += 0.25 * c_over_mu * (j**2 - 1.0 - 2.0 * math.log(j))
    return stored / (l1 - 1.0)


CANTILEVER_STEPS = (5.4e-4, 2.7e-4, 1.35e-4, 6.75e-5, 3.375e-5)
SCENES = {
    "spinning": Scene(
        "Free-flying beam, spinning", "spinning", 0.1, (2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5)
    ),
    "flying": Scene("Flying beam (Simo and Vu-Quoc)", "flying", 15.0, (0.5, 0.2, 0.1, 0.05, 0.02)),
    "cantilever_1": Scene("Cantilever, load of the paper", "cantilever", 1.35e-2, CANTILEVER_STEPS),
    "cantilever_5": Scene(
        "Cantilever, 5 times the load", "cantilever", 1.35e-2, CANTILEVER_STEPS, parameters={"times": 5}
    ),
    "cantilever_20": Scene(
        "Cantilever, 20 times the load", "cantilever", 1.35e-2, CANTILEVER_STEPS, parameters={"times": 20}
    ),
    "locking": Scene(
        "Strip pulled to 95 % of locking",
        "locking",
        2e-3,
        (1e-4, 5e-5, 2e-5, 1e-5, 5e-6),
        jms=(0.5, 3.0, 10.0),
    ),
    "snap": Scene("Strut snapped through", "snap", 4e-2, (2e-3, 1e-3, 5e-4, 2e-4, 1e-4)),
    "impact": Scene("Beam thrown against a wall", "impact", 1e-3, (5e-5, 2e-5, 1e-5, 5e-6, 2e-6)),
    "thin": Scene("Thin cantilever, L/h = 1000", "thin", 1.35, (5.4e-2, 2.7e-2, 1.35e-2, 6.75e-3, 3.375e-3)),
    "linear_rule": Scene(
        "Cantilever, rule linear",
        "linear_rule",
        0.27,
        (2.7e-4, 1.35e-4, 6.75e-5),
        schemes=("newmark", "hht", "generalized", "bathe", "central"),
    ),
}


@dataclass
class Outcome:
    """What became of a run."""

    kind: str  # completed | energy | cut | failed | refused | endless | broken
    reason: str  # in a few words; empty where it completed
    status: int
    time: float = 0.0  # reached
    drift: float = 0.0  # largest balance over the largest energy, with its sign
    cuts: int = 0
    rows: int = 0
    warned: bool = False
    text: str = ""  # all that was printed
    path: Path = None


def deck_text(scene, scheme, step=None, accuracy=None, end=None, fields="u", extra=""):
    """The deck of a scene; `extra` are more model commands."""
    steps = f"step={step!r}" if accuracy is None else f"accuracy={accuracy!r}"
    text = (DECKS / f"{scene.deck}.inp").read_text()
    text = text.replace("{scheme}", SCHEMES.get(scheme, scheme)).replace("{steps}", steps)
    text = text.replace("{end}", repr(end or scene.end)).replace("{fields}", fields)
    return text.replace("\nEND\n", f"\n{extra}\nEND\n")


def run(program, scene, scheme, step=None, jm=None, folder=".", seconds=300, settings=None, **deck):
    """Runs a scene in `folder` and says what became of it; results stay there as run.h5."""
    path = Path(folder) / "run.h5"
    path.unlink(missing_ok=True)
    values = {**scene.settings(scene.jms[0] if jm is None else jm), **(settings or {})}
    options = [part for key, value in values.items() for part in ("--set", f"{key}={value!r}")]
    try:
        done = subprocess.run(
            [str(program), "-o", path.stem, *options],
            input=deck_text(scene, scheme, step, **deck),
            cwd=folder,
            timeout=seconds,
            capture_output=True,
            text=True,
        )
    except subprocess.TimeoutExpired:
        return Outcome("endless", f"no end within {seconds} s", -1, path=path)
    return judge(done.returncode, done.stdout + done.stderr, path)


def judge(status, text, path):
    """The outcome from exit status, text and results file."""
    outcome = Outcome("completed", "", status, text=text, path=path)
    outcome.warned = "the energy balance drifts" in text
    if status == 1:
        outcome.kind, outcome.reason = "refused", first_error(text)
        return outcome
    if status not in (0, 2):
        outcome.kind, outcome.reason = "broken", f"exit status {status}"
        return outcome
    with h5py.File(path, "r") as file:
        if "transient/energy" not in file:
            outcome.kind, outcome.reason = "failed", reason_of_failure(text)
            return outcome
        if not all_finite(file):
            outcome.kind, outcome.reason = "broken", "not a number in the results"
            return outcome
        group = file["transient"]
        outcome.time = float(group["probes/time"][-1])
        outcome.rows = len(group["probes/time"])
        outcome.cuts = int(np.sum(group["solver/cuts"]))
        outcome.drift = drift_of(group)
    if status == 2:
        outcome.kind, outcome.reason = "failed", reason_of_failure(text)
    elif abs(outcome.drift) > WORRYING_DRIFT:
        outcome.kind, outcome.reason = "energy", f"energy off by {100 * outcome.drift:.2g} %"
    elif outcome.cuts > 0:
        outcome.kind, outcome.reason = "cut", f"{outcome.cuts} cuts"
    return outcome


def drift_of(group):
    """The balance where it is largest over the largest of kinetic and strain energy and external work."""
    energies = [np.abs(group[f"energy/{name}"][()]).max() for name in ("kinetic", "strain", "external")]
    balance = group["energy/balance"][()]
    largest = max(energies)
    return float(balance[np.argmax(np.abs(balance))] / largest) if largest > 0.0 else 0.0


def all_finite(file):
    """Whether no dataset of the file holds a NaN or an infinity."""
    found = []

    def visit(_, item):
        if isinstance(item, h5py.Dataset) and item.dtype.kind == "f":
            found.append(bool(np.isfinite(item[()]).all()))

    file.visititems(visit)
    return all(found)


def first_error(text):
    match = re.search(r"error: (.*)", text)
    return match.group(1) if match else "refused"


FAILURES = (
    ("no admissible state", "inadmissible"),
    ("not admissible", "inadmissible"),
    ("did not converge", "not converged"),
    ("line search", "no decrease"),
    ("diverged", "diverged"),
    ("singular", "singular"),
    ("explicit scheme is stable", "step limit"),
    ("no step from", "no step"),
)


def reason_of_failure(text):
    """The program's long sentence as one or two words."""
    error = first_error(text)
    return next((short for words, short in FAILURES if words in error), "failed")

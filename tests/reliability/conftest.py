"""Runs the program under faults: kills, calls that fail, limits of the system.

GENTBEAM names the executable. meddler.c stands between it and the system; it is compiled once a session.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from sanitized import is_sanitized  # noqa: E402

SECONDS = 120 * int(os.environ.get("GENTBEAM_PATIENCE", "1"))

DECK = """\
GENTBEAM     Faults
PARAMETER    q=2.85
MATERIAL     rubber  gent  mu=5000  c=2500  jm=10  rho=1e-6
SECTION      square  rectangle  b=1  h=1
LINE         from=0  to=10  elements=4
CLAMP        x=0
DISTRIBUTED  from=0  to=10  q3=q
PROBE        tip  u3  x=10
PROBE        rate  v3  x=10
OUTPUT       fields=[u v a]  every={every}
END
{commands}
STOP
"""

COMMANDS = """\
STATIC steps=5 load=0.4 name=bend
MODAL count=3 name=modes
TRANSIENT newmark step=1e-5 end=1.2e-2 name=swing
TRANSIENT generalized step=1e-5 end=8e-3 name=damped
STATIC steps=4 load=0.2 name=rest"""


def deck(commands=COMMANDS, every=1):
    return DECK.format(commands=commands, every=every)


SWING = "TRANSIENT newmark step=1e-5 end=4e-3 name=swing"


def study_deck(members=40, fields="[u v a]", commands=SWING):
    """A study; every tenth member's deck is wrong."""
    values = " ".join("-1" if i % 10 == 9 else str(1 + 0.01 * i) for i in range(members))
    text = deck(commands, every=20).replace("q=2.85", "q=2.85 r=1").replace("rho=1e-6", "rho=1e-6*r")
    text = text.replace("fields=[u v a]", f"fields={fields}")
    return text.replace("MATERIAL", f"SWEEP r=[{values}]\nMATERIAL")


@pytest.fixture(scope="session")
def executable():
    path = os.environ.get("GENTBEAM", "")
    if not path:
        pytest.fail("GENTBEAM does not name the program")
    return path


@pytest.fixture(scope="session")
def meddler(tmp_path_factory):
    """Environment under which meddler.so stands between program and system; orders are keywords."""
    library = tmp_path_factory.mktemp("meddler") / "meddler.so"
    compiler = os.environ.get("CC") or shutil.which("cc") or "gcc"
    command = [compiler, "-std=gnu11", "-O1", "-shared", "-fPIC", "-o", library, HERE / "meddler.c", "-ldl"]
    subprocess.run(command, check=True)
    libraries = [str(library)]
    sanitizer = {}
    if is_sanitized():
        # It looks at the clock by itself while it gives memory back, which would make a clock that goes on
        # with every look go on much faster while the program writes.
        options = [os.environ.get("ASAN_OPTIONS", ""), "allocator_release_to_os_interval_ms=-1"]
        sanitizer["ASAN_OPTIONS"] = ":".join(filter(None, options))
        # The sanitizer's library has to come first.
        ask = [compiler, "-print-file-name=libasan.so"]
        found = subprocess.run(ask, capture_output=True, text=True, check=True)
        libraries.insert(0, found.stdout.strip())

    def environment(**orders):
        names = {f"MEDDLER_{name.upper()}": str(value) for name, value in orders.items()}
        return {**os.environ, **sanitizer, "LD_PRELOAD": ":".join(libraries), **names}

    return environment


class Program:
    """The program in a folder of its own."""

    def __init__(self, executable, folder):
        self.executable, self.folder = executable, folder

    def start(self, text, *arguments, **options):
        """Runs in the background; `text` is the deck."""
        (self.folder / "deck.inp").write_text(text)
        command = [self.executable, "-q", "-o", "out", *map(str, arguments), "deck.inp"]
        return subprocess.Popen(
            command, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options
        )

    def run(self, text, *arguments, **options):
        """Its exit status and what it said on standard error."""
        process = self.start(text, *arguments, **options)
        _, said = process.communicate(timeout=SECONDS)
        said = said.decode()
        assert "Backtrace" not in said and "Fortran runtime" not in said and "HDF5-DIAG" not in said, said
        return process.returncode, said

    @property
    def results(self):
        return self.folder / "out.h5"

    @property
    def part(self):
        return self.folder / "out.h5.part"


@pytest.fixture
def program(executable, tmp_path):
    return Program(executable, tmp_path)


def datasets(file):
    """All datasets of a file as arrays: every one of them is read."""
    found = {}

    def visit(name, item):
        if isinstance(item, h5py.Dataset):
            found[name] = np.asarray(item[()])

    file.visititems(visit)
    return found


def check_whole(path, reference=None):
    """Sees that a file holds the first steps of the reference run, bit for bit, all series up to one step.

    Without a reference it sees that the series belong to one another. Returns the status and the number of
    steps.
    """
    with h5py.File(path, "r") as file:
        status = file.attrs["status"]
        assert status in ("running", "complete", "failed", "interrupted")
        found = datasets(file)
        commands = sorted((g for g in file.values() if "order" in g.attrs), key=lambda g: g.attrs["order"])
        assert [g.attrs["order"] for g in commands] == list(range(1, len(commands) + 1))
        names = [g.name.strip("/") for g in commands]
    if status == "complete" and reference is not None:
        assert set(found) == set(reference)
        assert all(found[key].shape == reference[key].shape for key in found)
    steps = 0
    for name in names:
        mine = {key: value for key, value in found.items() if key.startswith(name + "/")}
        if reference is not None:
            whole = {key: value for key, value in reference.items() if key.startswith(name + "/")}
            check_same(mine, whole, is_over=name != names[-1])
        if f"{name}/time" in mine:
            steps += check_series(mine, name)
    return status, steps


def check_same(mine, whole, is_over):
    """A command's datasets are those of the reference, or their beginnings while it is running."""
    assert set(mine) == set(whole) or not mine and not is_over
    for key, value in mine.items():
        assert not is_over or len(value) == len(whole[key]), key
        assert value.tobytes() == whole[key][: len(value)].tobytes(), key


def check_series(mine, name):
    """All series of a command end at the same step: its number."""
    steps = {len(value) for key, value in mine.items() if key.count("/") == 2}
    rows = {len(value) for key, value in mine.items() if key.count("/") == 1}
    assert len(steps) == len(rows) == 1, (name, steps, rows)
    step_at = {time: step for step, time in enumerate(mine[f"{name}/probes/time"])}
    places = [step_at[time] for time in mine[f"{name}/time"]]
    assert (mine[f"{name}/probes/tip"][places] == mine[f"{name}/u"][:, -1, 1]).all()
    assert (mine[f"{name}/probes/rate"][places] == mine[f"{name}/v"][:, -1, 1]).all()
    return max(0, steps.pop() - 1)


def check_study(path, reference=None):
    """Sees that a study's file holds members of the reference run with all they have to tell, bit for bit.

    Returns the status and the number of members.
    """
    with h5py.File(path, "r") as file:
        status = file.attrs["status"]
        assert status in ("running", "complete", "failed", "interrupted")
        found = datasets(file)
        groups = set(file["sweep/members"]) if "members" in file["sweep"] else None
    numbers = found["sweep/number"]
    places = numbers - 1
    assert len(set(numbers)) == len(numbers)
    assert groups is None or groups == {f"{number:06d}" for number in numbers}
    for name, value in found.items():
        if name.startswith("sweep/") and not name.startswith("sweep/members/"):
            assert len(value) == len(numbers), name
            if reference is not None:
                assert value.tolist() == reference[name][places].tolist(), name
        elif reference is not None and name != "deck":
            assert value.tobytes() == reference[name].tobytes(), name
    if reference is not None:
        members = {name for name in reference if name.startswith("sweep/members/")}
        there = {name for name in members if name.split("/")[2] in groups}
        assert set(found) == set(reference) - members | there
    return status, len(numbers)


@pytest.fixture(scope="session")
def references(executable, tmp_path_factory):
    """Datasets of undisturbed runs, by deck."""
    made = {}

    def reference(text):
        if text not in made:
            program = Program(executable, tmp_path_factory.mktemp("reference"))
            assert program.run(text) == (0, "")
            with h5py.File(program.results) as file:
                made[text] = datasets(file)
        return made[text]

    return reference

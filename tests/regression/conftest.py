"""Runs the program as a user does.

GENTBEAM names the executable; GENTBEAM_DEBUG, where set, one built with all checks.
"""

import os
import subprocess
from pathlib import Path

import h5py
import pytest

ROOT = Path(__file__).resolve().parents[2]
INPUT = ROOT / "input"
# More than any run may take; builds with sanitizers ask for patience.
SECONDS = 120 * int(os.environ.get("GENTBEAM_PATIENCE", "1"))

CANTILEVER = """\
GENTBEAM     Cantilever, \u00e9lastique
UNITS        length=in  force=lbf  time=s
PARAMETER    jm=1e20  q=2.85
MATERIAL     rubber  gent  mu=5000  c=2500  jm=jm  rho=1e-6
SECTION      square  rectangle  b=1  h=1
LINE         from=0  to=10  elements=4
CLAMP        x=0
DISTRIBUTED  from=0  to=10  q3=q
PROBE        tip  u3  x=10
{model}
END
{solution}
STOP
"""


class Runner:
    """The program in a folder of its own."""

    def __init__(self, executable, folder):
        self.executable, self.folder = executable, folder

    def __call__(self, *arguments, deck=None, status=0, **options):
        """Runs it, `deck` going in by standard input, and expects the exit status."""
        options.setdefault("stdout", subprocess.PIPE)
        options.setdefault("stderr", subprocess.PIPE)
        done = subprocess.run(
            [self.executable, *map(str, arguments)],
            input=None if deck is None else deck.encode(),
            cwd=options.pop("cwd", self.folder),
            timeout=SECONDS,
            **options,
        )
        self.out = (done.stdout or b"").decode()
        self.err = (done.stderr or b"").decode()
        assert done.returncode == status, f"exit status {done.returncode}\n{self.out[-2000:]}\n{self.err}"
        for text in (self.out, self.err):
            assert "Backtrace" not in text and "Fortran runtime" not in text and "HDF5-DIAG" not in text, text
        return self

    def results(self, name="gentbeam"):
        return h5py.File(self.folder / f"{name}.h5", "r")

    def sole_error(self):
        """The one line on standard error, without the program's name."""
        lines = self.err.splitlines()
        assert len(lines) == 1 and lines[0].startswith("gentbeam: error: "), self.err
        return lines[0][len("gentbeam: error: ") :]


@pytest.fixture(scope="session")
def executable():
    path = os.environ.get("GENTBEAM", "")
    if not path:
        pytest.fail("GENTBEAM does not name the program")
    return path


@pytest.fixture
def gentbeam(executable, tmp_path):
    return Runner(executable, tmp_path)


def small_deck(solution="TRANSIENT newmark step=2e-4 end=1e-3", model=""):
    return CANTILEVER.format(solution=solution, model=model)

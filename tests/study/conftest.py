"""Runs studies as a user does. GENTBEAM names the executable."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parent / "support"))
ROOT = HERE.parents[1]
SECONDS = 300 * int(os.environ.get("GENTBEAM_PATIENCE", "1"))


class Runner:
    """The program in a folder of its own."""

    def __init__(self, executable, folder):
        self.executable, self.folder = executable, folder

    def __call__(self, *arguments, deck=None, status=0, environment=None, before=()):
        """Runs it and expects the exit status (None: any); `before` is a command that runs it."""
        start = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(
            [*before, self.executable, *map(str, arguments)],
            input="" if deck is None else deck,
            cwd=self.folder,
            timeout=SECONDS,
            text=True,
            capture_output=True,
            env={**self.clean(), **(environment or {})},
        )
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.cpu = end.ru_utime + end.ru_stime - start.ru_utime - start.ru_stime
        self.waits = end.ru_nvcsw - start.ru_nvcsw
        self.out, self.err, self.status = done.stdout, done.stderr, done.returncode
        said = f"exit status {done.returncode}\n{self.out[-2000:]}\n{self.err}"
        assert status in (None, done.returncode), said
        for text in (self.out, self.err):
            assert "Backtrace" not in text and "Fortran runtime" not in text and "HDF5-DIAG" not in text, text
        return self

    @staticmethod
    def clean():
        """The environment without what launchers and OpenMP put there."""
        launchers = ("SLURM_", "PMI", "OMPI_", "OMP_")
        return {name: value for name, value in os.environ.items() if not name.startswith(launchers)}

    def path(self, name="gentbeam"):
        return self.folder / f"{name}.h5"

    def results(self, name="gentbeam"):
        return h5py.File(self.path(name), "r")

    def last_line(self):
        return self.out.rstrip("\n").splitlines()[-1]


@pytest.fixture(scope="session")
def executable():
    path = os.environ.get("GENTBEAM", "")
    if not path:
        pytest.fail("GENTBEAM does not name the program")
    return path


@pytest.fixture
def gentbeam(executable, tmp_path):
    return Runner(executable, tmp_path)

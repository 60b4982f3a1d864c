"""GENTBEAM names the executable; GENTBEAM_DEBUG, where set, one with all run-time checks and traps."""

import os
from pathlib import Path

import h5py
import pytest

from scenes import SCENES, run


class Stage:
    """Runs scenes in a folder of its own."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def __call__(self, scene, scheme, step=None, jm=None, seconds=120, **options):
        outcome = run(self.program, SCENES[scene], scheme, step, jm, self.folder, seconds, **options)
        assert outcome.kind not in ("broken", "endless"), f"{outcome.reason}\n{outcome.text[-2000:]}"
        assert "Backtrace" not in outcome.text and "Fortran runtime" not in outcome.text, outcome.text
        return outcome

    def open(self, outcome):
        return h5py.File(outcome.path, "r")


@pytest.fixture
def stage(tmp_path):
    return Stage(Path(os.environ["GENTBEAM"]).resolve(), tmp_path)


@pytest.fixture
def debug_stage(tmp_path):
    if "GENTBEAM_DEBUG" not in os.environ:
        pytest.skip("GENTBEAM_DEBUG names no executable")
    return Stage(Path(os.environ["GENTBEAM_DEBUG"]).resolve(), tmp_path)

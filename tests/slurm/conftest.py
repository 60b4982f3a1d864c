"""The program and a cluster to run it on."""

import os
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "study")]

from cluster import Cluster, missing  # noqa: E402


@pytest.fixture(scope="session")
def executable():
    path = os.environ.get("GENTBEAM", "")
    if not path:
        pytest.fail("GENTBEAM does not name the program")
    return path


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    reason = missing()
    if reason and os.environ.get("CI"):
        pytest.fail(reason)
    if reason:
        pytest.skip(reason)
    with Cluster(tmp_path_factory.mktemp("slurm")) as running:
        yield running

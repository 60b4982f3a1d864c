"""Damaged results files: scripts and restarts refuse them in one line, or find what was written; no crash.

GENTBEAM_DAMAGE sets the number of files of each kind, GENTBEAM_SEED which ones they are.
"""

import os
import random
import subprocess
import sys
from pathlib import Path

import h5py
import pytest
from conftest import SECONDS, small_deck

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import gentbeam_results  # noqa: E402

CASES = int(os.environ.get("GENTBEAM_DAMAGE", "40"))
SEED = int(os.environ.get("GENTBEAM_SEED", "1"))
KINDS = ["bits", "bytes", "end"]


@pytest.fixture
def whole(gentbeam):
    """Results, with a checkpoint on the way to them."""
    deck = small_deck("CHECKPOINT every=3\nSTATIC steps=4 load=0.1\nTRANSIENT newmark step=1e-4 end=1e-3")
    (gentbeam.folder / "deck.inp").write_text(deck)
    gentbeam("-q", "deck.inp")
    return (gentbeam.folder / "deck.h5").read_bytes()


def damaged(whole, kind):
    random.seed(SEED)
    # Zeros between the structures of the file are of no use to anybody.
    places = [place for place, byte in enumerate(whole) if byte]
    for _ in range(CASES):
        data = bytearray(whole)
        if kind == "end":
            del data[random.randrange(len(data)) :]
        else:
            for _ in range(random.choice((1, 1, 2, 8, 30))):
                place = random.choice(places)
                bit = 1 << random.randrange(8)
                data[place] = random.randrange(256) if kind == "bytes" else data[place] ^ bit
        yield data


def use(path):
    """What the plotting scripts read of a file, in bytes."""
    with gentbeam_results.open_results(path) as results:
        group = results.group()
        arrays = []
        for probe in group.probes:
            history = group.history(probe)
            arrays += [history.time, history.values]
        arrays += group.displacements()
        arrays.append(results.mesh().x)
        texts = repr((results.parameters, results.units, group.probes))
        return b"".join(array.tobytes() for array in arrays) + texts.encode()


def outcome(path, whole):
    """`used`, `refused`, or what became of a process that came back with neither."""
    process = os.fork()
    if process == 0:
        status = 2
        try:
            status = 0 if use(path) == whole else 3
        except gentbeam_results.ResultsError as error:
            status = 2 if "\n" in str(error) else 1
        finally:
            os._exit(status)
    answer = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    return {0: "used", 1: "refused", 3: "used, and wrong"}.get(answer, f"exit status {answer}")


@pytest.mark.parametrize("kind", KINDS)
def test_scripts(gentbeam, whole, kind):
    path = gentbeam.folder / "damaged.h5"
    undamaged = use(gentbeam.folder / "deck.h5")
    answers = []
    for data in damaged(whole, kind):
        path.write_bytes(data)
        answers.append(outcome(path, undamaged))
        assert answers[-1] in ("used", "refused")
    assert answers.count("refused") > CASES / 2


def datasets(path):
    """All numbers of a file, in bytes."""
    found = {}

    def look(name, thing):
        if isinstance(thing, h5py.Dataset):
            found[name] = repr(thing[()]) if thing.dtype == object else thing[()].tobytes()

    with h5py.File(path, "r") as file:
        file.visititems(look)
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_restart(gentbeam, whole, kind):
    path = gentbeam.folder / "deck.h5"
    undamaged = datasets(path)
    answers = []
    for data in damaged(whole, kind):
        path.write_bytes(data)
        command = [gentbeam.executable, "-q", "--restart", "deck.chk.h5", "deck.inp"]
        done = subprocess.run(
            command, cwd=gentbeam.folder, capture_output=True, text=True, timeout=SECONDS, check=False
        )
        answers.append(done.returncode)
        assert done.returncode in (0, 3), done.stderr
        if done.returncode == 3:
            assert done.stderr.startswith("gentbeam: error: cannot ") and done.stderr.count("\n") == 1
            assert path.read_bytes() == data
        else:
            assert datasets(path) == undamaged
        assert not list(gentbeam.folder.glob("*.part")) and not list(gentbeam.folder.glob("*.new"))
        # A run that went well has replaced its checkpoint.
        assert (gentbeam.folder / "deck.chk.h5").exists()
    assert answers.count(3) > 0

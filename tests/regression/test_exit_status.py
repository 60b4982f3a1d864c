"""How runs end: solutions that fail (2), files that cannot be read or written (3); no backtrace, no hang."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import small_deck

# Two iterations a step are too few: the second command fails, the first one stands.
FAILING = """STATIC steps=4 load=0.1 name=bend
TRANSIENT newmark step=1e-4 end=2e-4 name=easy
TRANSIENT newmark step=5e-3 end=1 iterations=2 cuts=1 name=hard"""


def test_failed_solution(gentbeam):
    gentbeam("-o", "out", deck=small_deck(FAILING), status=2)
    message = gentbeam.sole_error()
    assert message.startswith("TRANSIENT: step 1 failed from t = 0 to ")
    assert "did not converge in 2 iterations" in message and "worst at element " in message
    with gentbeam.results("out") as file:
        assert file.attrs["status"] == "failed"
        assert file.attrs["message"] == message
        assert file["bend/u"].shape == (5, 9, 5)
        assert file["easy/u"].shape == (3, 9, 5)
        assert file["hard/time"][:].tolist() == [0.0]
        assert file["hard"].attrs["order"] == 3
        assert np.isfinite(file["hard/u"][()]).all()


def test_steps_before_the_failure_are_kept(gentbeam):
    """A load that starts late, beyond what three iterations can follow."""
    late = "HISTORY late step start=1e-3\nPOINT x=10 f3=2000 history=late"
    text = small_deck("TRANSIENT newmark step=1e-4 end=1 iterations=6 cuts=0", late)
    gentbeam("-o", "out", deck=text, status=2)
    with gentbeam.results("out") as file:
        group = file["transient"]
        rows = group["time"].shape[0]
        assert rows >= 11
        for name in ("u", "probes/tip", "energy/balance", "solver/residual"):
            assert group[name].shape[0] == rows, name
        assert group["probes/tip"][-1] != 0.0


def test_static_failure_names_the_load(gentbeam):
    gentbeam("-o", "out", deck=small_deck("STATIC steps=2 iterations=3 cuts=1"), status=2)
    message = gentbeam.sole_error()
    assert message.startswith("STATIC: step 1 of 2 failed at load factor 0.25 after 1 cut")
    assert "worst at element " in message


def test_nothing_is_written_where_the_deck_is_wrong(gentbeam):
    gentbeam("-o", "out", deck=small_deck("TRANSIENT newmark step=0 end=1"), status=1)
    assert list(gentbeam.folder.iterdir()) == []
    (gentbeam.folder / "out.h5").write_text("precious")
    gentbeam("-o", "out", deck=small_deck("NONSENSE"), status=1)
    assert (gentbeam.folder / "out.h5").read_text() == "precious"


def test_missing_folder(gentbeam):
    gentbeam("-o", "no/such/out", deck=small_deck(), status=3)
    assert gentbeam.sole_error() == "cannot write the results file no/such/out.h5: No such file or directory"


def test_directory_in_place_of_the_file(gentbeam):
    (gentbeam.folder / "out.h5").mkdir()
    gentbeam("-o", "out", deck=small_deck(), status=3)
    assert gentbeam.sole_error() == "cannot write the results file out.h5: Is a directory"


def test_no_permission(gentbeam):
    """As root, who may write everywhere, the program is run as nobody."""
    options = {}
    if os.geteuid() == 0:
        options = {"user": "nobody", "group": "nogroup", "extra_groups": []}
    folder = Path(tempfile.mkdtemp(dir="/tmp"))
    try:
        program = shutil.copy(gentbeam.executable, folder / "program")
        folder.chmod(0o755)
        locked = folder / "locked"
        locked.mkdir()
        locked.chmod(0o555)
        gentbeam.executable = program
        gentbeam("-o", locked / "out", deck=small_deck(), status=3, cwd=folder, **options)
        assert gentbeam.sole_error() == f"cannot write the results file {locked}/out.h5: Permission denied"
        present = folder / "present.h5"
        present.write_text("precious")
        present.chmod(0o444)
        gentbeam("-o", folder / "present", deck=small_deck(), status=3, cwd=folder, **options)
        assert gentbeam.sole_error() == f"cannot write the results file {present}: Permission denied"
        assert present.read_text() == "precious"
    finally:
        shutil.rmtree(folder)


def test_results_name_that_is_no_file(gentbeam):
    os.symlink("/dev/full", gentbeam.folder / "out.h5")
    gentbeam("-o", "out", deck=small_deck(), status=3)
    assert gentbeam.sole_error().startswith("cannot write the results file out.h5: ")


def test_results_do_not_replace_the_deck_or_a_table(gentbeam):
    """By whatever name."""
    deck = small_deck(model='HISTORY push table file="push.h5"\nPOINT x=10 f3=1 history=push')
    for name, content in (("deck.h5", deck), ("push.h5", "0 0\n1 1\n")):
        (gentbeam.folder / name).write_text(content)
    (gentbeam.folder / "link.h5").symlink_to("push.h5")
    for name in ("deck", "push", "link"):
        before = (gentbeam.folder / f"{name}.h5").read_bytes()
        gentbeam("-o", name, "deck.h5", status=1)
        assert gentbeam.sole_error().startswith(f"{name}.h5 is the deck, or a table that it reads: give")
        assert (gentbeam.folder / f"{name}.h5").read_bytes() == before
    gentbeam("deck.h5", status=1)
    gentbeam("-o", "free", "deck.h5")
    gentbeam("-o", "free", "deck.h5")


@pytest.mark.parametrize("closed", ["1>&-", "0<&- 1>&-", "2>&-", "1>&- 2>&-", "0<&-"])
def test_closed_standard_files_take_nothing_into_the_results(gentbeam, closed):
    """The first file that is opened would be number 1, and the log would go into it."""
    (gentbeam.folder / "deck.inp").write_text(small_deck())
    gentbeam("-q", "-o", "whole", "deck.inp")
    script = f"exec {closed}; exec {gentbeam.executable} -o out deck.inp"
    done = subprocess.run(["sh", "-c", script], cwd=gentbeam.folder, capture_output=True, timeout=60)
    assert done.returncode == (3 if "1>&-" in closed else 0)
    with gentbeam.results("whole") as whole, gentbeam.results("out") as out:
        names = []
        whole.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        assert names and all(np.array_equal(whole[name][()], out[name][()]) for name in names)
        assert out.attrs["status"] == "complete"


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 512 kB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=512k", "none", folder], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip("a small tmpfs cannot be mounted here: " + mounted.stderr.decode().strip())
    yield folder
    subprocess.run(["umount", folder], check=True)


def test_disk_that_fills_up(gentbeam, small_disk):
    gentbeam("-o", small_disk / "out", deck=small_deck("TRANSIENT newmark step=1e-6 end=1e-2"), status=3)
    message = gentbeam.sole_error()
    assert message == f"cannot write the results file {small_disk}/out.h5: No space left on device"
    assert not list(small_disk.glob("*probe*"))


def test_full_disk(gentbeam, small_disk):
    (small_disk / "filler").write_bytes(b"")
    with (small_disk / "filler").open("wb") as filler:
        try:
            while True:
                filler.write(b"\0" * 4096)
                filler.flush()
        except OSError:
            pass
        try:
            filler.close()
        except OSError:
            pass
    gentbeam("-o", small_disk / "out", deck=small_deck(), status=3)
    assert "No space left on device" in gentbeam.sole_error()


def test_file_size_limit(gentbeam):
    """Writes beyond a limit fail like those to a full disk, and need no root."""
    import resource
    import signal

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))

    text = small_deck("TRANSIENT newmark step=1e-6 end=1e-2")
    gentbeam("-o", "out", deck=text, status=3, preexec_fn=limit)
    assert gentbeam.sole_error() == "cannot write the results file out.h5: File too large"


def test_file_open_elsewhere(gentbeam):
    """h5py holds the lock of a file that it reads."""
    gentbeam("-o", "out", deck=small_deck())
    with h5py.File(gentbeam.folder / "out.h5", "r"):
        before = (gentbeam.folder / "out.h5").read_bytes()
        gentbeam("-o", "out", deck=small_deck(), status=3)
        message = gentbeam.sole_error()
        assert message.startswith("cannot write the results file out.h5: ") and "another program" in message
        assert (gentbeam.folder / "out.h5").read_bytes() == before


PEEK = """
import sys, h5py
print("ready", flush=True)
while True:
    h5py.File(sys.argv[1], "r").close()
"""


def test_readers_who_peek_do_not_keep_a_run_from_replacing_results(gentbeam):
    (gentbeam.folder / "deck.inp").write_text(small_deck())
    gentbeam("-q", "-o", "out", "deck.inp")
    command = [sys.executable, "-c", PEEK, "out.h5"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(command, cwd=gentbeam.folder, **pipes) as reader:
        try:
            reader.stdout.readline()
            for _ in range(20):
                gentbeam("-q", "-o", "out", "deck.inp")
        finally:
            reader.kill()


def test_missing_deck(gentbeam):
    gentbeam("no.inp", status=3)
    assert "no.inp" in gentbeam.sole_error() and "No such file or directory" in gentbeam.sole_error()
    assert list(gentbeam.folder.iterdir()) == []


def test_directory_in_place_of_the_deck(gentbeam):
    gentbeam(gentbeam.folder, status=3)
    assert "Is a directory" in gentbeam.sole_error()


def test_closed_standard_input(gentbeam):
    done = subprocess.run(
        [sys.executable, "-c", f"import os; os.close(0); os.execv({gentbeam.executable!r}, ['gentbeam'])"],
        cwd=gentbeam.folder,
        capture_output=True,
        timeout=60,
    )
    assert done.returncode in (1, 3)
    assert b"Backtrace" not in done.stderr and b"Fortran runtime" not in done.stderr

"""Shards of a study: what each holds, what is joined, and what a shard does that is started again."""

import os
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from conftest import Runner
from studies import SHORT, same_file, study

ALL = SHORT + "\nMODAL count=2"
SWEEP = "SWEEP E=[11000 12000 -1 13000 14000]\nSWEEP jm=[1 2 5]"


def shard_names(name, shards):
    return [f"{name}.shard-{i}-of-{shards}.h5" for i in range(1, shards + 1)]


@pytest.mark.parametrize("output", ["", "OUTPUT fields=none"])
@pytest.mark.parametrize("shards", [1, 2, 4, 20])
def test_merged_shards_are_the_whole(gentbeam, shards, output):
    deck = study(SWEEP, ALL, output)
    gentbeam("-q", "--threads", 2, "-o", "whole", deck=deck)
    for i in range(1, shards + 1):
        # A shard whose members all fail says so; one without members has nothing to say.
        alone = [k for k in range(i, 16, shards)]
        status = 2 if alone and all(7 <= k <= 9 for k in alone) else 0
        gentbeam("-q", "--shard", f"{i}/{shards}", "-o", "part", deck=deck, status=status)
    names = shard_names("part", shards) if shards > 1 else ["part.h5"]
    gentbeam("--merge", "joined", *reversed(names))
    assert gentbeam.out == f"merged {len(names)} files into joined.h5: 12 of 15 members complete, 3 failed\n"
    same_file(gentbeam.path("whole"), gentbeam.path("joined"))


def test_what_a_shard_holds(gentbeam):
    gentbeam("--shard", "2/4", deck=study(SWEEP, ALL))
    with gentbeam.results("gentbeam.shard-2-of-4") as file:
        assert dict(file["sweep"].attrs) == {"members": 15, "shard": 2, "shards": 4}
        assert file["sweep/number"][:].tolist() == [2, 6, 10, 14]
        assert file["sweep/parameters"][:].tolist() == [[11000, 2], [12000, 5], [13000, 1], [14000, 2]]
        assert list(file["sweep/members"]) == ["000002", "000006", "000010", "000014"]
    assert "  shard 2 of 4: 4 members\n" in gentbeam.out


def test_missing_members_are_told(gentbeam):
    for i in (1, 4):
        gentbeam("-q", "--shard", f"{i}/4", "-o", "part", deck=study(SWEEP, ALL))
    gentbeam("--merge", "some.h5", "part.shard-1-of-4.h5", "part.shard-4-of-4.h5", status=2)
    assert gentbeam.err == "gentbeam: error: members missing in some.h5: 2-3, 6-7, 10-11, 14-15\n"
    with gentbeam.results("some") as file:
        assert file.attrs["status"] == "interrupted"
        assert file["sweep/number"][:].tolist() == [1, 4, 5, 8, 9, 12, 13]
        assert file["sweep/parameters"][:, 0].tolist() == [11000, 12000, 12000, -1, -1, 13000, 14000]
        assert file["sweep/status"][:].tolist() == [1, 1, 1, 2, 2, 1, 1]
        assert all(file["sweep/message"][3:5]) and not any(file["sweep/message"][:3])
        assert list(file["sweep/members"]) == [
            "000001",
            "000004",
            "000005",
            "000008",
            "000009",
            "000012",
            "000013",
        ]


def test_a_finished_shard_runs_nothing(gentbeam):
    deck = study(SWEEP, ALL)
    gentbeam("--shard", "1/2", deck=deck)
    gentbeam("--shard", "1/2", deck=deck)
    assert "  8 of them were finished by an earlier run\n" in gentbeam.out
    assert gentbeam.last_line().endswith("6 of 8 members complete, 2 failed")


def finished(path):
    try:
        with h5py.File(path, "r") as file:
            return int(np.count_nonzero(file["sweep/status"][:]))
    except (OSError, KeyError):
        return 0


# So long the shard takes that it can be ended at work, longer than what it has finished waits for the file.
SECONDS_A_SHARD = 4.0
STEP = 1e-5


def long_study(steps, output):
    values = " ".join(str(11000 + i) for i in range(40))
    return study(
        f"SWEEP E=[{values}]", f"TRANSIENT newmark step={STEP} end={steps * STEP}", output, elements=2
    )


@pytest.fixture(scope="module", params=["OUTPUT every=50", "OUTPUT fields=none"])
def ended(request, executable, tmp_path_factory):
    """A runner in a folder with a study, its results, and those of its second shard."""
    runner = Runner(executable, tmp_path_factory.mktemp("ended"))

    def run(steps):
        (runner.folder / "study.inp").write_text(long_study(steps, request.param))
        runner("-q", "--threads", 2, "-o", "whole", "study.inp")
        with runner.results("whole") as file:
            return file.attrs["cpu_seconds"]

    run(int(4000 * 2 * SECONDS_A_SHARD / run(4000)))
    runner("-q", "--threads", 2, "--shard", "2/2", "study.inp")
    return runner


@pytest.mark.parametrize("how", [signal.SIGUSR1, signal.SIGTERM, signal.SIGKILL])
def test_a_shard_goes_on_where_it_was_ended(ended, how):
    path = ended.path("study.shard-1-of-2")
    path.unlink(missing_ok=True)
    first = subprocess.Popen([ended.executable, "-q", "--shard", "1/2", "study.inp"], cwd=ended.folder)
    while finished(path) == 0 and first.poll() is None:
        time.sleep(0.02)
    first.send_signal(how)
    assert first.wait() == (-9 if how == signal.SIGKILL else 4)
    with h5py.File(path) as file:
        assert file.attrs["status"] == ("running" if how == signal.SIGKILL else "interrupted")
    done = finished(path)
    assert 0 < done < 20
    ended("--threads", 2, "--shard", "1/2", "study.inp")
    assert f"  {done} of them were finished by an earlier run\n" in ended.out
    ended("-q", "--merge", "joined", *shard_names("study", 2))
    same_file(ended.path("whole"), ended.path("joined"))


PEEK = """
import sys, h5py
print("ready", flush=True)
while True:
    try:
        h5py.File(sys.argv[1], "r").close()
    except OSError:
        pass
"""


def test_readers_who_peek_do_not_end_a_study(gentbeam):
    (gentbeam.folder / "study.inp").write_text(long_study(40, "OUTPUT every=50"))
    path = gentbeam.path("study.shard-1-of-2")
    command = [sys.executable, "-c", PEEK, str(path)]
    readers = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    try:
        for reader in readers:
            assert reader.stdout.readline() == "ready\n"
        for _ in range(10):
            path.unlink(missing_ok=True)
            gentbeam("-q", "--shard", "1/2", "study.inp")
    finally:
        for reader in readers:
            reader.kill()
            reader.communicate()


def test_a_run_that_is_stopped_says_so(gentbeam):
    deck = study("SWEEP E=[11000 11500 12000]", "TRANSIENT newmark step=1e-6 end=1")
    (gentbeam.folder / "study.inp").write_text(deck)
    run = subprocess.Popen(
        [gentbeam.executable, "study.inp"],
        cwd=gentbeam.folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while "time left" not in run.stdout.readline():
        pass
    run.send_signal(signal.SIGINT)
    out, err = run.communicate()
    assert run.returncode == 4
    assert out.rstrip().endswith("0 of 3 members complete, 0 failed, 3 missing")
    assert err.startswith("gentbeam: stopped by SIGINT with 0 of 3 members complete")
    with gentbeam.results("study") as file:
        assert file.attrs["status"] == "interrupted" and not file["sweep/status"][:].any()


def test_a_file_of_another_study_is_left_alone(gentbeam):
    gentbeam("-q", "--shard", "1/2", deck=study(SWEEP))
    before = gentbeam.path("gentbeam.shard-1-of-2").read_bytes()
    for deck, arguments in ((study(SWEEP, ALL), ()), (study(SWEEP), ("--set", "nu=0.3"))):
        gentbeam("--shard", "1/2", *arguments, deck=deck, status=3)
        assert "holds the results of another deck or of other parameters: delete it" in gentbeam.err
    assert gentbeam.path("gentbeam.shard-1-of-2").read_bytes() == before


def test_a_broken_file_is_begun_anew(gentbeam):
    gentbeam.path("gentbeam.shard-1-of-2").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(1000))
    gentbeam("--shard", "1/2", deck=study(SWEEP))
    assert "earlier run" not in gentbeam.out
    assert finished(gentbeam.path("gentbeam.shard-1-of-2")) == 8


def test_a_damaged_file_is_begun_anew_and_not_merged(gentbeam):
    """One bit of one number is wrong."""
    deck, path = study(SWEEP), gentbeam.path("gentbeam.shard-1-of-2")
    for i in (1, 2):
        gentbeam("-q", "--shard", f"{i}/2", deck=deck)
    whole = path.read_bytes()
    with h5py.File(path) as file:
        place = file["sweep/members/000001/transient/u"].id.get_offset() + 1000
    path.write_bytes(whole[:place] + bytes([whole[place] ^ 4]) + whole[place + 1 :])
    gentbeam("--merge", "joined.h5", *shard_names("gentbeam", 2), status=3)
    assert "sweep/members/000001/transient/u is not what was written" in gentbeam.err
    assert not gentbeam.path("joined").exists()
    gentbeam("--shard", "1/2", deck=deck)
    assert "000001/transient/u is not what was written; it is begun anew\n" in gentbeam.out
    gentbeam("-q", "--merge", "joined.h5", *shard_names("gentbeam", 2))


def test_what_cannot_be_merged(gentbeam):
    for i in (1, 2):
        gentbeam("-q", "--shard", f"{i}/2", "-o", "a", deck=study(SWEEP))
    gentbeam("-q", "--shard", "1/2", "-o", "b", "--set", "nu=0.3", deck=study(SWEEP))
    gentbeam("-q", "-o", "single", deck=study(""))
    (gentbeam.folder / "text.h5").write_text("no results")
    one = "a.shard-1-of-2.h5"
    for files, words in (
        ((one, "b.shard-1-of-2.h5"), "are not of the same study"),
        ((one, one), "hold the same shard"),
        ((one, "none.h5"), "none.h5: there is no such file"),
        ((one, "text.h5"), "cannot read text.h5 as the results of a SWEEP"),
        ((one, "single.h5"), "cannot read single.h5 as the results of a SWEEP"),
        ((one, "out.h5"), "out.h5 is to be written, and cannot be joined with itself"),
    ):
        if "out.h5" in files:
            (gentbeam.folder / "out.h5").write_bytes(b"x")
        gentbeam("--merge", "out.h5", *files, status=3)
        assert words in gentbeam.err and gentbeam.err.count("\n") == 1
    assert (gentbeam.folder / "out.h5").read_bytes() == b"x"
    # A file that is to be written and was forgotten: the first shard stands in its place.
    before = (gentbeam.folder / one).read_bytes()
    gentbeam("--merge", one, "a.shard-2-of-2.h5", status=1)
    assert f"{one} is to be written, and is the results of a shard: name the file for all" in gentbeam.err
    (gentbeam.folder / "link.h5").symlink_to(one)
    gentbeam("--merge", "link.h5", one, "a.shard-2-of-2.h5", status=1)
    assert (gentbeam.folder / one).read_bytes() == before
    gentbeam("--merge", "out.h5", status=1)
    gentbeam("--merge", status=1)


@pytest.mark.parametrize("value", ["0/2", "3/2", "1", "1/", "/2", "a/b", "-1/2", "1/2/3", "", "1/0"])
def test_wrong_shards(gentbeam, value):
    gentbeam("--shard", value, deck=study(SWEEP), status=1)
    assert "option --shard needs I/N with 1 <= I <= N, or auto" in gentbeam.err


def test_a_deck_without_sweep_has_no_shards(gentbeam):
    for value in ("1/2", "auto"):
        gentbeam("--shard", value, deck=study(""), status=1)
        assert (
            gentbeam.err == "gentbeam: error: --shard divides the members of a SWEEP, and the deck has none\n"
        )
    assert not os.listdir(gentbeam.folder)

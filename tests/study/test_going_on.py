"""A study that is stopped and taken up again ends with the same file as one that is not, bit for bit."""

import itertools
import random
import shutil
import signal
import subprocess
import time

import h5py
import pytest
from conftest import Runner
from studies import same_file, study

# Members of several schemes and of one that fails; each takes a while.
SCHEMES = (
    "TRANSIENT newmark step=1e-5 end=4e-2 name=plain",
    "TRANSIENT generalized end=1e-2 accuracy=1e-5 name=adaptive",
    "TRANSIENT energy step=1e-5 end=4e-3 name=energy\nMODAL count=2",
    "STATIC steps=40 name=bend\nTRANSIENT bathe step=2e-5 end=5e-3 name=swing",
)
OUTPUTS = ("OUTPUT every=20", "OUTPUT fields=none")
MOST_STOPS = 6
STOPS = (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1)


def deck(commands, output, members=60):
    values = " ".join("-1" if i == 7 else str(11000 + i) for i in range(members))
    return study(f"SWEEP E=[{values}]", commands, output, elements=2)


def start(gentbeam, *arguments):
    return subprocess.Popen(
        [gentbeam.executable, "-q", *arguments, "study.inp"],
        cwd=gentbeam.folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run_whole(gentbeam, commands, output, seconds):
    """Runs a study that takes about so long on this machine, undisturbed: how long it took."""
    members = 40
    for _ in range(2):
        (gentbeam.folder / "study.inp").write_text(deck(commands, output, members))
        begin = time.monotonic()
        gentbeam("-q", "-o", "whole", "study.inp")
        duration = time.monotonic() - begin
        members = max(40, min(4000, int(members * seconds / duration)))
    return duration


def members_in(path):
    with h5py.File(path) as file:
        number = len(file["sweep/number"])
        assert {len(table) for table in file["sweep/summary"].values()} == {number}
        return number, file.attrs["status"]


@pytest.mark.parametrize("output", OUTPUTS)
@pytest.mark.parametrize("commands", SCHEMES)
def test_interrupted_often(gentbeam, commands, output):
    duration = run_whole(gentbeam, commands, output, 2.5)
    chance = random.Random(1)
    restart, done, stops = [], [], 0
    while True:
        process = start(gentbeam, *restart)
        # After some stops it is left alone: a stop before another member is done brings it no further.
        if stops < MOST_STOPS:
            time.sleep((0.05 + chance.uniform(0.1, 0.3) * duration) * 1.3**stops)
            process.send_signal(STOPS[stops % 3])
        _, said = process.communicate()
        assert process.returncode in (0, 4), said
        if process.returncode == 0:
            break
        stops += 1
        assert said.startswith(f"gentbeam: stopped by {STOPS[(stops - 1) % 3].name} with ")
        assert said.endswith("; to go on: gentbeam --restart study.chk.h5 DECK\n")
        finished, status = members_in(gentbeam.path("study"))
        assert status == "interrupted"
        done.append(finished)
        restart = ["--restart", "study.chk.h5"]
    assert done == sorted(done) and len(set(done)) >= 2 and stops >= 2, done
    same_file(gentbeam.path("whole"), gentbeam.path("study"))


def test_killed_and_gone_on_with(gentbeam):
    """After kill -9: by the checkpoint that CHECKPOINT leaves, or by the results file itself."""
    commands = "CHECKPOINT every=100\nTRANSIENT newmark step=1e-5 end=1e-2"
    run_whole(gentbeam, commands, "OUTPUT every=1000", 10.0)
    before = 0
    for restart in ([], ["--restart", "study.h5"]):
        process = start(gentbeam, *restart)
        wait_for_members(process, gentbeam.path("study"), before)
        process.kill()
        process.communicate()
        before = count_members(gentbeam.path("study"))
    assert before > 0
    gentbeam("--restart", "study.chk.h5", "study.inp")
    assert f"  {before} of them were finished by an earlier run\n" in gentbeam.out
    same_file(gentbeam.path("whole"), gentbeam.path("study"))


def wait_for_members(process, path, before=0):
    while process.poll() is None and count_members(path) <= before:
        time.sleep(0.01)


def count_members(path):
    try:
        return members_in(path)[0]
    except (OSError, KeyError):
        return 0


def test_another_name_leaves_the_old_file(gentbeam):
    (gentbeam.folder / "study.inp").write_text(deck(SCHEMES[0], OUTPUTS[0], members=2000))
    process = start(gentbeam)
    wait_for_members(process, gentbeam.path("study"))
    process.terminate()
    process.communicate()
    assert process.returncode == 4
    old = gentbeam.path("study").read_bytes()
    process = start(gentbeam, "--restart", "study.chk.h5", "-o", "new")
    wait_for_members(process, gentbeam.path("new"), members_in(gentbeam.path("study"))[0])
    process.terminate()
    _, said = process.communicate()
    assert process.returncode == 4 and "--restart new.chk.h5" in said
    assert gentbeam.path("study").read_bytes() == old
    assert members_in(gentbeam.path("new"))[0] > members_in(gentbeam.path("study"))[0]


@pytest.mark.parametrize("shard", [(), ("--shard", "2/3")])
def test_max_time_until_it_is_done(gentbeam, shard):
    (gentbeam.folder / "study.inp").write_text(deck(SCHEMES[0], OUTPUTS[1], members=300))
    begin = time.monotonic()
    gentbeam("-q", *shard, "-o", "whole", "study.inp")
    limit = max(0.1, (time.monotonic() - begin) / 3)
    name = "study" + (".shard-2-of-3" if shard else "")
    restart = []
    for tries in itertools.count():
        process = start(gentbeam, *shard, "--max-time", str(limit), *restart)
        _, said = process.communicate()
        if process.returncode == 0:
            break
        assert process.returncode == 4 and said.startswith("gentbeam: stopped by --max-time with "), said
        restart = ["--restart", f"{name}.chk.h5"]
        assert tries < 100
    assert tries >= 2
    same_file(gentbeam.path(name.replace("study", "whole")), gentbeam.path(name))


@pytest.fixture
def stopped(executable, tmp_path):
    """A study whose table and deck can be changed, stopped at work."""
    runner = Runner(executable, tmp_path)
    (tmp_path / "rows.txt").write_text("E\n" + "".join(f"{11000 + i}\n" for i in range(2000)))
    (tmp_path / "study.inp").write_text(study('SWEEP file="rows.txt"', SCHEMES[3], OUTPUTS[0], elements=2))
    process = start(runner)
    wait_for_members(process, runner.path("study"))
    process.terminate()
    process.communicate()
    assert process.returncode == 4
    return runner


def test_what_does_not_fit(stopped):
    before = stopped.path("study").read_bytes()
    deck, rows = stopped.folder / "study.inp", stopped.folder / "rows.txt"
    text, table = deck.read_text(), rows.read_text()
    for restart in ("study.chk.h5", "study.h5"):
        words = {
            "deck": "another deck",
            "parameters": "other parameters" if restart == "study.h5" else "the parameters differ",
            "table": "a table that the deck reads from a file has changed",
        }
        for what, said in words.items():
            arguments = ["--set", "nu=0.3"] if what == "parameters" else []
            deck.write_text(text.replace("rho=1e-6", "rho=2e-6") if what == "deck" else text)
            rows.write_text(table.replace("11000", "11000.5") if what == "table" else table)
            stopped("-q", "--restart", restart, *arguments, "study.inp", status=None)
            assert stopped.status in (1, 3) and said in stopped.err and stopped.err.count("\n") == 1
            assert stopped.path("study").read_bytes() == before
        rows.write_text(table)
        deck.write_text(text)
    shutil.copy(stopped.path("study"), stopped.path("elsewhere"))
    stopped.path("study").unlink()
    stopped("--restart", "study.chk.h5", "study.inp", status=3)
    assert "without the results of the steps before it: study.h5 is not there" in stopped.err
    stopped("--restart", "none.chk.h5", "study.inp", status=3)
    assert "cannot restart from none.chk.h5: No such file or directory" in stopped.err
    assert not list(stopped.folder.glob("*.part"))


@pytest.mark.parametrize("kind", ["bits", "bytes", "end"])
def test_damaged_results(stopped, kind):
    """Refused with one line, and left as they are; a shard that finds them begins anew."""
    whole = stopped.path("study").read_bytes()
    places = [place for place, byte in enumerate(whole) if byte]
    chance = random.Random(2)
    refused = 0
    for _ in range(8):
        data = bytearray(whole)
        if kind == "end":
            del data[chance.randrange(len(data)) :]
        else:
            for place in chance.sample(places, chance.choice((1, 3, 30))):
                bit = 1 << chance.randrange(8)
                data[place] = chance.randrange(256) if kind == "bytes" else data[place] ^ bit
        stopped.path("study").write_bytes(data)
        process = start(stopped, "--restart", "study.h5", "--max-time", "0.2")
        _, said = process.communicate()
        assert process.returncode in (3, 4) and said.count("\n") == 1, said
        if process.returncode == 3:
            refused += 1
            assert said.startswith("gentbeam: error: cannot ")
            assert stopped.path("study").read_bytes() == data
        assert not list(stopped.folder.glob("*.part"))
    assert refused >= 4

"""kill -9 at any instant leaves a results file that opens, and that ends at a whole step."""

import os
import random
import subprocess
import sys
import time
from collections import Counter

import h5py
import pytest
from conftest import check_study, check_whole, deck, study_deck

# A clock that goes on with every look at it makes the program publish its results as often as in a run of
# many minutes.
TICKS = (0.01, 0.1)
OLDER = "TRANSIENT newmark step=1e-4 end=1e-3 name=older"


def older_results(program):
    """Results of another run under the same name; what they are, to recognise them."""
    assert program.run(deck(OLDER)) == (0, "")
    return program.results.read_bytes()


def judge(program, older, reference, check=check_whole):
    """What a killed run has left: `old`, or its status and its number of steps, or of members."""
    assert {path.name for path in program.folder.iterdir()} <= {"deck.inp", "out.h5", "out.h5.part"}
    if program.results.read_bytes() == older:
        return "old", 0
    return check(program.results, reference)


def kill_at_random(program, reference, meddler, text, source, latest, check=check_whole):
    older = older_results(program)
    process = program.start(text, env=meddler(tick=source.uniform(*TICKS)))
    # Some come in the first milliseconds, where the file is made.
    delay = source.uniform(0.0, 0.02) if source.random() < 0.2 else source.uniform(0.0, latest)
    time.sleep(delay)
    process.kill()
    process.communicate()
    return judge(program, older, reference, check)


def duration(program, environment, text):
    """The shortest of three runs, whatever else the machine is doing."""
    times = []
    for _ in range(3):
        start = time.monotonic()
        assert program.run(text, env=environment) == (0, "")
        times.append(time.monotonic() - start)
    return min(times)


def kill_often(program, references, meddler, count, seed):
    source = random.Random(seed)
    kinds = {}
    found = set()
    for every in (1, 7):
        text = deck(every=every)
        latest = 0.9 * duration(program, meddler(tick=TICKS[1]), text)
        for _ in range(count // 2):
            kind, steps = kill_at_random(program, references(text), meddler, text, source, latest)
            kinds[kind] = kinds.get(kind, 0) + 1
            found.add(steps)
    return kinds, found


def test_kills_at_random_instants(program, references, meddler):
    kinds, found = kill_often(program, references, meddler, 20, 1)
    print(kinds, sorted(found))
    assert sum(kinds.values()) == 20
    # The kills have hit running files, at several steps.
    assert kinds.get("running", 0) >= 5 and len(found) >= 4


@pytest.mark.long
def test_many_kills_at_random_instants(program, references, meddler):
    kinds, found = kill_often(program, references, meddler, 300, int(os.environ.get("GENTBEAM_SEED", "2")))
    print(kinds, len(found))
    assert sum(kinds.values()) == 300
    assert kinds.get("running", 0) >= 200 and len(found) >= 50


def kill_studies(program, references, meddler, count, seed):
    source = random.Random(seed)
    kinds, found = Counter(), set()
    for fields in ("[u v a]", "none"):
        text = study_deck(120 if fields == "none" else 60, fields)
        latest = 0.9 * duration(program, meddler(tick=TICKS[1]), text)
        for _ in range(count // 2):
            kind, members = kill_at_random(
                program, references(text), meddler, text, source, latest, check_study
            )
            kinds[kind] += 1
            found.add(members)
    return kinds, found


def test_kills_of_studies(program, references, meddler):
    kinds, found = kill_studies(program, references, meddler, 20, 3)
    print(kinds, sorted(found))
    assert sum(kinds.values()) == 20 and kinds["running"] >= 5 and len(found) >= 4


@pytest.mark.long
def test_many_kills_of_studies(program, references, meddler):
    kinds, found = kill_studies(program, references, meddler, 200, int(os.environ.get("GENTBEAM_SEED", "4")))
    print(kinds, len(found))
    assert sum(kinds.values()) == 200 and kinds["running"] >= 120 and len(found) >= 20


MEMBERS = 300


@pytest.mark.parametrize("fields", ["[u v a]", "none"])
def test_kill_of_a_study_at_every_write(program, references, meddler, fields):
    """As below for a run, but at every fourth call; the next run goes on with what is left."""
    text = study_deck(MEMBERS, fields, "TRANSIENT newmark step=1e-4 end=1e-3 name=swing")
    reference = references(text)
    environment = meddler(tick=0.05)
    older = older_results(program)
    kinds = []
    while not kinds or kinds[-1][0] != "complete":
        program.results.write_bytes(older)
        status, _ = program.run(text, env={**environment, "MEDDLER_KILL": str(4 * len(kinds) + 1)})
        kinds.append(judge(program, older, reference, check_study))
        assert status in (0, -9)
        if kinds[-1][0] == "running":
            assert program.run(text, "--restart", "out.h5") == (0, "")
            assert check_study(program.results, reference) == ("complete", MEMBERS)
    print(len(kinds), Counter(kinds))
    assert kinds[0] == ("old", 0) and len({kind for kind in kinds if kind[0] == "running"}) >= 3


@pytest.mark.parametrize("tick", [0.15, 0.2, 0.25, 0.5])
def test_places_of_editions_are_used_again(program, references, meddler, tick):
    """With some clocks an edition outgrows the place of an older one and is made once more."""
    text = study_deck(MEMBERS, "[u]", "TRANSIENT newmark step=1e-4 end=1e-3 name=swing")
    assert program.run(text, env=meddler(tick=tick)) == (0, "")
    assert check_study(program.results, references(text)) == ("complete", MEMBERS)


def count_calls(program, environment, text):
    name = program.folder / "count"
    assert program.run(text, env={**environment, "MEDDLER_COUNT": str(name)}) == (0, "")
    number = int(name.read_text().split()[0])
    name.unlink()
    return number


SHORT = "STATIC steps=3 load=0.4 name=bend\nTRANSIENT newmark step=1e-4 end=2e-3 name=swing"
MIDDLE = """STATIC steps=3 load=0.4 name=bend
TRANSIENT newmark step=1e-5 end=1.2e-2 name=swing
MODAL count=2"""


def test_kill_at_every_write(program, references, meddler):
    """The process dies at every single call that changes a file, from the first one on; writes are torn."""
    text = deck(MIDDLE)
    reference = references(text)
    environment = meddler(tick=0.004)
    calls = count_calls(program, environment, text)
    older = older_results(program)
    kinds = []
    number = 0
    while not kinds or kinds[-1][0] != "complete":
        number += 1
        program.results.write_bytes(older)
        status, _ = program.run(text, env={**environment, "MEDDLER_KILL": str(number)})
        kinds.append(judge(program, older, reference))
        assert status in (0, -9)
        # The next run is not hindered by what is left.
        if number % 10 == 1:
            assert program.run(text) == (0, "")
            assert check_whole(program.results, reference)[0] == "complete" and not program.part.exists()
    print(number, Counter(kinds))
    assert number >= 0.8 * calls >= 20
    assert kinds[0] == ("old", 0)
    assert len({kind for kind in kinds if kind[0] == "running"}) >= 3


def test_killed_before_anything_is_visible(program, meddler):
    """Then there is no file under its name, and the next run cleans up."""
    status, _ = program.run(deck(SHORT), env=meddler(kill=2))
    assert status == -9
    assert not program.results.exists() and program.part.exists()
    assert program.run(deck(SHORT)) == (0, "")
    assert program.results.exists() and not program.part.exists()


def test_large_models_are_visible_from_the_start(program, meddler):
    """Also while their first step is being computed."""
    text = deck(SHORT).replace("elements=4", "elements=600")
    for number in range(1, 20):
        program.run(text, env=meddler(kill=number))
        if program.results.exists():
            break
    with h5py.File(program.results) as file:
        assert file.attrs["status"] == "running" and file["mesh/x"].shape == (1201,)
        assert "bend" not in file


# Opens a file, and looks at what is in it only when it is told to: all of it, from the file.
LATE_READER = """
import h5py, sys
with h5py.File(sys.argv[1], "r") as file:
    print("open", flush=True)
    sys.stdin.readline()
    names = []
    file.visit(names.append)
    rows = {len(file[f"swing/{name}"][()]) for name in ("u", "time", "probes/tip", "energy/balance")}
    print(len(names), *rows, file.attrs["status"])
"""


@pytest.fixture
def endless(program, meddler):
    """Starts a run that goes on till the test is over; its clock runs faster."""
    started = []

    def start():
        text = deck("TRANSIENT newmark step=1e-7 end=1 name=swing")
        started.append(program.start(text, env=meddler(clock=5)))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.communicate()


def wait_for(condition, process):
    limit = time.monotonic() + 60.0
    while not condition():
        assert process.poll() is None and time.monotonic() < limit
        time.sleep(0.001)


def test_reading_while_it_is_written(program, endless):
    """A reader finds whole steps at any time; what it has opened stays as it was for half a minute."""
    process = endless()
    wait_for(program.results.exists, process)
    late = subprocess.Popen(
        [sys.executable, "-c", LATE_READER, program.results],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert late.stdout.readline() == "open\n"
    seen = []
    while len(set(seen)) < 4:
        status, steps = check_whole(program.results)
        assert status == "running" and process.poll() is None
        seen.append(steps)
    assert seen == sorted(seen)
    said, _ = late.communicate("now\n")
    _, rows, status = said.split()
    assert late.returncode == 0 and status == "running"
    assert int(rows) - 1 <= seen[0] < seen[-1]


def test_two_runs_at_once(program, endless):
    """The second one is refused, whether the first is visible already or not."""
    process = endless()
    for is_there in (program.part.exists, program.results.exists):
        wait_for(is_there, process)
        status, said = program.run(deck(SHORT))
        assert status == 3
        assert said == "gentbeam: error: cannot write the results file out.h5: another program is using it\n"
        assert process.poll() is None
    assert check_whole(program.results)[0] == "running"

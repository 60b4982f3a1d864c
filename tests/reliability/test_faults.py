"""Disks that fill up, calls that fail, files and folders that vanish: exit status 3 and a sentence, and
nothing half-written that looks whole."""

import errno
import os
import re
import resource
import shutil
import signal
import time
from collections import Counter

import h5py
import pytest
from conftest import check_study, check_whole, deck, study_deck
from sanitized import is_sanitized

COMMANDS = """STATIC steps=3 load=0.4 name=bend
TRANSIENT newmark step=1e-5 end=1.2e-2 name=swing
MODAL count=2"""


def judge(program, status, said, words, reference, check=check_whole):
    """A failed run has said why in one line, and what it has left does not look whole."""
    assert status == 3, said
    assert re.fullmatch(f"gentbeam: error: cannot write the results file out.h5: {words}\n", said), said
    assert {path.name for path in program.folder.iterdir()} <= {"deck.inp", "out.h5"}
    if not program.results.exists():
        return "none"
    kind, _ = check(program.results, reference)
    assert kind in ("running", "failed")
    if kind == "failed":
        with h5py.File(program.results) as file:
            assert file.attrs["message"] in said
    return kind


def count_calls(program, environment, text):
    name = program.folder / "count"
    assert program.run(text, env={**environment, "MEDDLER_COUNT": str(name)}) == (0, "")
    number = int(name.read_text().split()[0])
    name.unlink()
    return number


def fail_each_call(program, references, meddler, error, once, tick, text=None, check=check_whole):
    """Every call that changes a file fails: it and all after it, as on a full disk, or it alone."""
    text = text or deck(COMMANDS)
    reference = references(text)
    environment = meddler(tick=tick, error=error, once=once)
    calls = count_calls(program, environment, text)
    kinds = Counter()
    for number in range(1, calls):
        program.results.unlink(missing_ok=True)
        status, said = program.run(text, env={**environment, "MEDDLER_FAIL": str(number)})
        kinds[judge(program, status, said, os.strerror(error), reference, check)] += 1
    # The last one closes a file in which all is said already.
    status, said = program.run(text, env={**environment, "MEDDLER_FAIL": str(calls)})
    assert status == 3 and os.strerror(error) in said
    print(calls, kinds)
    # With a sanitizer a study has fewer editions.
    assert kinds["none"] >= 5 and kinds["failed" if once else "running"] >= (5 if is_sanitized() else 20)


@pytest.mark.parametrize("error, once", [(errno.ENOSPC, 0), (errno.EIO, 1)])
def test_each_call_fails(program, references, meddler, error, once):
    fail_each_call(program, references, meddler, error, once, tick=0.003)


def fail_study(program, references, meddler, fields, once):
    text = study_deck(60, fields, "TRANSIENT newmark step=1e-4 end=3e-4 name=swing")
    fail_each_call(program, references, meddler, errno.ENOSPC, once, 0.2, text, check_study)


def test_each_call_of_a_study_fails(program, references, meddler):
    fail_study(program, references, meddler, "[u]", 0)


@pytest.mark.long
@pytest.mark.parametrize("fields, once", [("[u]", 1), ("none", 0), ("none", 1)])
def test_each_call_of_other_studies_fails(program, references, meddler, fields, once):
    fail_study(program, references, meddler, fields, once)


@pytest.mark.long
@pytest.mark.parametrize("once", [0, 1])
@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EDQUOT, errno.EIO])
def test_each_call_of_a_longer_run_fails(program, references, meddler, error, once):
    fail_each_call(program, references, meddler, error, once, tick=0.01)


def test_each_size_limit(program, references, meddler):
    """Files may not grow beyond a limit: every limit from nothing to just too little."""
    text = deck(COMMANDS)
    environment = meddler(tick=0.01)
    reference = references(text)
    assert program.run(text, env=environment) == (0, "")
    whole = program.results.stat().st_size

    kinds = Counter()
    for part in range(20):
        size = part * whole // 20

        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

        program.results.unlink(missing_ok=True)
        status, said = program.run(text, env=environment, preexec_fn=limit)
        kinds[judge(program, status, said, "File too large", reference)] += 1
    print(kinds)
    assert kinds["none"] >= 1 and kinds["running"] >= 3


@pytest.fixture
def endless(program, meddler):
    """Starts a run that goes on till the test is over, with a faster clock, and waits for its file."""
    started = []

    def start():
        text = deck("TRANSIENT newmark step=1e-7 end=1 name=swing")
        started.append(program.start(text, "-o", "sub/out", env=meddler(clock=20)))
        limit = time.monotonic() + 60.0
        while not (program.folder / "sub" / "out.h5").exists():
            assert started[-1].poll() is None and time.monotonic() < limit
            time.sleep(0.01)
        return started[-1]

    (program.folder / "sub").mkdir()
    yield start
    for process in started:
        process.kill()
        process.communicate()


REMOVED = (
    "gentbeam: error: cannot write the results file sub/out.h5: it was removed or replaced during the run\n"
)


def test_folder_vanishes(program, endless):
    process = endless()
    shutil.rmtree(program.folder / "sub")
    _, said = process.communicate(timeout=60)
    assert process.returncode == 3 and said.decode() == REMOVED
    assert not (program.folder / "sub").exists()


def test_file_is_replaced(program, endless):
    """What somebody puts in its place is not touched."""
    process = endless()
    other = program.folder / "other"
    other.write_text("precious")
    os.replace(other, program.folder / "sub" / "out.h5")
    _, said = process.communicate(timeout=60)
    assert process.returncode == 3 and said.decode() == REMOVED
    assert (program.folder / "sub" / "out.h5").read_text() == "precious"


def test_file_is_moved(program, endless):
    """A moved file keeps what was visible, and the run ends."""
    process = endless()
    os.replace(program.folder / "sub" / "out.h5", program.folder / "moved.h5")
    _, said = process.communicate(timeout=60)
    assert process.returncode == 3 and said.decode() == REMOVED
    assert check_whole(program.folder / "moved.h5")[0] == "running"


def test_file_made_read_only_during_the_run(program, endless):
    """The permission is asked for when the run begins; later changes are for the next one."""
    process = endless()
    results = program.folder / "sub" / "out.h5"
    results.chmod(0o444)
    before = check_whole(results)[1]
    limit = time.monotonic() + 60.0
    while check_whole(results)[1] == before:
        assert process.poll() is None and time.monotonic() < limit
        time.sleep(0.05)


def test_read_only_file_is_not_replaced(program):
    """Root may write everywhere; then the program is run as nobody."""
    options = {"user": "nobody", "group": "nogroup", "extra_groups": []} if os.geteuid() == 0 else {}
    program.results.write_text("precious")
    program.results.chmod(0o444)
    program.folder.chmod(0o777)
    for folder in program.folder.parents:
        if options and not folder.stat().st_mode & 1:
            folder.chmod(folder.stat().st_mode | 0o111)
    program.executable = shutil.copy(program.executable, program.folder / "program")
    os.chmod(program.executable, 0o755)
    status, said = program.run(deck(COMMANDS), **options)
    assert status == 3
    assert said == "gentbeam: error: cannot write the results file out.h5: Permission denied\n"
    assert program.results.read_text() == "precious" and not program.part.exists()


def test_permissions_are_kept(program):
    """A new file has those of the one it replaces."""
    assert program.run(deck(COMMANDS)) == (0, "")
    program.results.chmod(0o640)
    assert program.run(deck(COMMANDS)) == (0, "")
    assert program.results.stat().st_mode & 0o777 == 0o640


def test_link_is_followed(program):
    """Where the results' name is a link, the file it points to is replaced."""
    (program.folder / "far").mkdir()
    target = program.folder / "far" / "target.h5"
    target.write_text("older")
    program.results.symlink_to(target)
    assert program.run(deck(COMMANDS)) == (0, "")
    assert program.results.is_symlink()
    assert check_whole(target)[0] == "complete"


def test_what_stands_in_the_place_of_the_part_is_not_written_to(program):
    """A link or a pipe named NAME.h5.part is none of ours: it stays, and so does what a link points to."""
    other = program.folder / "precious.txt"
    other.write_text("precious")
    program.part.symlink_to(other)
    status, said = program.run(deck(COMMANDS))
    assert status == 3 and "the same name with .part is a link" in said
    assert program.part.is_symlink() and other.read_text() == "precious"
    program.part.unlink()
    os.mkfifo(program.part)
    status, said = program.run(deck(COMMANDS))
    assert status == 3 and "the same name with .part is not an ordinary file" in said
    assert program.part.is_fifo() and not program.results.exists()

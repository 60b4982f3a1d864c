"""A run that is interrupted, again and again, ends with the numbers of one that was not, bit for bit."""

import os
import re
import shutil
import signal
import subprocess
import time

import h5py
import pytest
from conftest import SECONDS, small_deck

# Everything that carries state from one step to the next: damping, a driven support, loads that jump between
# two multiples of the step, rows every third step only, statics before and between the transients, modes.
RICH = """\
GENTBEAM     Interrupted
UNITS        length=in  force=lbf  time=s
PARAMETER    q=2.85
MATERIAL     rubber  gent  mu=5000  c=2500  jm=4  rho=1e-6
SECTION      square  rectangle  b=1  h=1 {section}
LINE         from=0  to=10  elements=4
CLAMP        x=0
HISTORY      hit  pulse  start=1.37e-3  stop=4.11e-3
HISTORY      shake  sine  frequency=150
DISTRIBUTED  from=0  to=10  q3=q  history=hit
GRAVITY      g3=-386
{drive}
DAMPING      mass=20  stiffness=1e-6
PROBE        tip  u3  x=10
PROBE        speed  v3  x=7.5
OUTPUT       every=3  fields=[u v a]
END
{solution}
STOP
"""
DRIVEN = "PRESCRIBE    x=5  u3=0.2  history=shake"
SCHEMES = ["newmark", "hht alpha=-0.1", "generalized", "bathe", "energy", "central"]


def rich_deck(solution, drive="", section=""):
    return RICH.format(solution=solution, drive=drive, section=section)


def contents(path):
    """Every dataset's bytes, type and shape, and the order and attributes of all that is in the file."""
    found = {}

    def note(name, thing):
        data = None
        if isinstance(thing, h5py.Dataset):
            data = thing[()]
            data = data if isinstance(data, bytes) else (data.dtype.str, data.shape, data.tobytes())
        found[name] = (data, repr(sorted(thing.attrs.items())))

    with h5py.File(path, "r") as file:
        file.visititems(note)
        for name, thing in file.items():
            if isinstance(thing, h5py.Group):
                found["members of " + name] = list(thing)
    return found


def assert_same(first, second):
    first, second = contents(first), contents(second)
    assert set(first) == set(second)
    for name, value in first.items():
        assert value == second[name], name


class Interrupter:
    """Runs a deck to its end, with a signal after so many lines of the log in each part."""

    def __init__(self, gentbeam, deck, name="part"):
        self.gentbeam, self.name, self.interruptions = gentbeam, name, 0
        (gentbeam.folder / "deck.inp").write_text(deck)

    def part(self, after=None, sent=signal.SIGTERM, arguments=()):
        """One part, from the checkpoint if there is one; interrupted after so many log lines, if given."""
        folder = self.gentbeam.folder
        command = [self.gentbeam.executable, "-o", self.name, *arguments, "deck.inp"]
        if (folder / f"{self.name}.chk.h5").exists():
            command += ["--restart", f"{self.name}.chk.h5"]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        with subprocess.Popen(command, cwd=folder, text=True, **pipes) as process:
            lines, solving = 0, False
            for line in process.stdout:
                solving = solving or "results: " in line
                # Numbered lines tell of steps.
                lines += solving and line.split()[:1] != [] and line.split()[0].isdigit()
                if after is not None and lines == after:
                    process.send_signal(sent)
                    after = None
            self.err = process.stderr.read()
            status = process.wait(SECONDS)
        assert "Backtrace" not in self.err, self.err
        if status == 4:
            self.interruptions += 1
            assert self.err.startswith("gentbeam: stopped by "), self.err
            assert self.err.rstrip().endswith(f"go on with --restart {self.name}.chk.h5"), self.err
            with h5py.File(folder / f"{self.name}.h5", "r") as file:
                assert file.attrs["status"] == "interrupted"
                assert "gentbeam: " + file.attrs["message"] == self.err.rstrip()
                for group in file.values():
                    if isinstance(group, h5py.Group) and "probes" in group:
                        assert group["time"][-1] == group["probes/time"][-1]
        else:
            assert status == 0, self.err
        return status


def check_interruptions(gentbeam, deck, least):
    """Interrupts after one line of the log, then two, and so on; compares with a run in one go."""
    gentbeam("-q", "-o", "whole", deck=deck)
    run = Interrupter(gentbeam, deck)
    after = 1
    while run.part(after, [signal.SIGTERM, signal.SIGINT, signal.SIGUSR1][after % 3]) == 4:
        after += 1
        assert after < 60
    assert run.interruptions >= least
    assert_same(gentbeam.folder / "whole.h5", gentbeam.folder / "part.h5")


@pytest.mark.parametrize("drive", ["", DRIVEN], ids=["loads", "driven"])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_scheme(gentbeam, scheme, drive):
    solution = f"""STATIC steps=30 load=0.3 name=bend
MODAL count=3
TRANSIENT {scheme} step=5e-6 end=8e-3 name=first
TRANSIENT {scheme} step=7e-6 end=3e-3 name=second"""
    check_interruptions(gentbeam, rich_deck(solution, drive), least=4)


@pytest.mark.parametrize("scheme", SCHEMES[:-1])
def test_adaptive_steps(gentbeam, scheme):
    solution = f"""TRANSIENT {scheme} accuracy=1e-5 end=8e-3
STATIC steps=20
TRANSIENT newmark step=5e-5 end=2e-3"""
    check_interruptions(gentbeam, rich_deck(solution, DRIVEN), least=3)


def test_steps_that_are_cut(gentbeam):
    """Few iterations allowed: steps are halved, and the halvings carry over from one step to the next."""
    solution = "STATIC steps=40 load=6 iterations=3\nTRANSIENT newmark step=2e-4 end=4e-2 iterations=3"
    deck = rich_deck(solution, DRIVEN)
    check_interruptions(gentbeam, deck, least=3)
    with gentbeam.results("part") as file:
        assert file["static/solver/cuts"][:].sum() > 3 and file["transient/solver/cuts"][:].sum() > 3


def test_full_inertia_and_linear_rule(gentbeam):
    solution = "TRANSIENT bathe step=2e-5 end=6e-3"
    check_interruptions(gentbeam, rich_deck(solution, DRIVEN, "inertia=full rule=linear"), least=2)


def test_full_inertia_by_the_block_solver(gentbeam):
    """It remembers how its iterations converge, and takes damping by the mass alone."""
    solution = "TRANSIENT bathe step=2e-5 end=2e-2 solver=block"
    deck = rich_deck(solution, DRIVEN, "inertia=full").replace("stiffness=1e-6", "")
    check_interruptions(gentbeam, deck, least=2)


def test_time_limit(gentbeam):
    """Parts of two fifths of what the whole takes; how many that gives depends on the machine, because every
    part takes over the results of those before it."""
    deck = rich_deck("TRANSIENT newmark step=5e-7 end=8e-3\nTRANSIENT bathe step=1e-6 end=8e-3")
    start = time.monotonic()
    gentbeam("-q", "-o", "whole", deck=deck)
    limit = f"{max(0.25, (time.monotonic() - start) * 0.4):.2f}"
    run = Interrupter(gentbeam, deck)
    while run.part(arguments=["--max-time", limit]) == 4:
        assert f"stopped by --max-time {float(limit):g} after " in run.err
        assert run.interruptions < 500
    assert run.interruptions > 0
    assert_same(gentbeam.folder / "whole.h5", gentbeam.folder / "part.h5")


def test_checkpoints_of_the_deck(gentbeam):
    """CHECKPOINT every= leaves the last one behind; a run goes on from it, though its results went on."""
    deck = rich_deck(
        "TRANSIENT newmark step=2e-5 end=1e-3 name=plain\nCHECKPOINT every=40 file=safe.h5\n"
        "TRANSIENT newmark step=2e-5 end=8e-3 name=guarded\nTRANSIENT newmark step=2e-5 end=1e-3 name=after"
    )
    (gentbeam.folder / "deck.inp").write_text(deck)
    gentbeam("-q", "-o", "whole", "deck.inp")
    with h5py.File(gentbeam.folder / "safe.h5") as file:
        assert (file.attrs["command"], file.attrs["step"]) == ("after", 40)
        assert file.attrs["format"] == "gentbeam checkpoint" and file["deck"][()].decode() == deck
    shutil.copy(gentbeam.folder / "safe.h5", gentbeam.folder / "kept.h5")
    reference = contents(gentbeam.folder / "whole.h5")
    gentbeam("-q", "-o", "whole", "--restart", "kept.h5", "deck.inp")
    assert contents(gentbeam.folder / "whole.h5") == reference
    # Under another name the run goes on in a copy.
    gentbeam("-q", "-o", "other", "--restart", "kept.h5", "deck.inp")
    assert contents(gentbeam.folder / "other.h5") == reference
    assert not (gentbeam.folder / "plain.chk.h5").exists() and not list(gentbeam.folder.glob("*.new"))


def test_checkpoints_by_the_clock(gentbeam):
    deck = rich_deck("CHECKPOINT seconds=1e-6\nTRANSIENT newmark step=1e-4 end=1e-3")
    gentbeam("-v", deck=deck)
    assert gentbeam.out.count("checkpoint gentbeam.chk.h5") == 10


def test_second_interrupt_stops_at_once(gentbeam):
    """The first one is noted only, and the step goes on; the second ends a run as it would any program."""
    deck = rich_deck("TRANSIENT newmark step=1e-7 end=1").replace("elements=4", "elements=20000")
    (gentbeam.folder / "deck.inp").write_text(deck.replace("fields=[u v a]", "fields=none"))
    command = [gentbeam.executable, "-q", "deck.inp"]
    results = gentbeam.folder / "deck.h5"
    for _ in range(20):
        with subprocess.Popen(command, cwd=gentbeam.folder, stderr=subprocess.PIPE) as process:
            while not results.exists():
                assert process.poll() is None
            process.send_signal(signal.SIGINT)
            time.sleep(0.005)
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=SECONDS)
        results.unlink()
        # Between two steps, the first is answered before the second comes.
        if process.returncode != 4:
            break
    assert process.returncode == -signal.SIGINT


@pytest.fixture
def interrupted(gentbeam):
    """A folder with a deck, its results so far, and a checkpoint."""
    deck = small_deck("CHECKPOINT every=3\nTRANSIENT newmark step=1e-4 end=1e-3")
    (gentbeam.folder / "deck.inp").write_text(deck)
    gentbeam("-q", "deck.inp")
    return gentbeam


def refused(gentbeam, *arguments, status=3):
    """The message of a restart that is refused and leaves everything as it was."""
    before = {path.name: path.read_bytes() for path in gentbeam.folder.iterdir() if path.is_file()}
    gentbeam(*arguments, status=status)
    after = {path.name: path.read_bytes() for path in gentbeam.folder.iterdir() if path.is_file()}
    assert before == after
    return gentbeam.sole_error()


def test_another_deck_is_refused(interrupted):
    folder = interrupted.folder
    deck = (folder / "deck.inp").read_text()
    (folder / "deck.inp").write_text(deck.replace("elements=4", "elements=5"))
    assert refused(interrupted, "--restart", "deck.chk.h5", "deck.inp", status=1) == (
        "cannot restart from deck.chk.h5: it belongs to another deck; the first line that differs is 6: then "
        "'LINE         from=0  to=10  elements=4', now 'LINE         from=0  to=10  elements=5'"
    )
    (folder / "deck.inp").write_text(deck)
    assert refused(interrupted, "--restart", "deck.chk.h5", "--set", "q=3", "deck.inp", status=1) == (
        "cannot restart from deck.chk.h5: the parameters differ: then 'q=2.85', now 'q=3' (--set)"
    )


def test_what_cannot_be_seen_in_a_line_is_told(interrupted):
    """Line ends, a byte-order mark, and a difference at the end of a long line."""
    deck = (interrupted.folder / "deck.inp").read_bytes()
    for other in (deck.replace(b"\n", b"\r\n"), b"\xef\xbb\xbf" + deck):
        (interrupted.folder / "deck.inp").write_bytes(other)
        assert refused(interrupted, "--restart", "deck.chk.h5", "deck.inp", status=1).endswith(
            "the first line that differs is 1: it ends in another way (CR LF, LF), or has a byte-order mark"
        )
    (interrupted.folder / "deck.inp").write_bytes(deck)
    long = deck.replace(b"LINE ", b"LINE " + 150 * b" ", 1)
    (interrupted.folder / "deck.inp").write_bytes(long)
    interrupted("-q", "deck.inp")
    (interrupted.folder / "deck.inp").write_bytes(long.replace(b"elements=4", b"elements=5"))
    said = refused(interrupted, "--restart", "deck.chk.h5", "deck.inp", status=1)
    assert re.search(r"then '\.\.\. .*elements=4', now '\.\.\. .*elements=5'$", said)


def test_an_earlier_name_may_come_back(gentbeam):
    """The file of that name holds the run too, but ends before the checkpoint."""
    deck = small_deck("TRANSIENT newmark step=1e-6 end=6e-2", model="OUTPUT every=100")
    (gentbeam.folder / "deck.inp").write_text(deck)
    gentbeam("-q", "-o", "whole", "deck.inp")
    stopped = ("-q", "--max-time", "0.04")
    gentbeam(*stopped, "-o", "one", "deck.inp", status=4)
    gentbeam(*stopped, "-o", "two", "--restart", "one.chk.h5", "deck.inp", status=4)
    gentbeam("-q", "-o", "one", "--restart", "two.chk.h5", "deck.inp")
    with gentbeam.results("whole") as whole, gentbeam.results("one") as one:
        assert whole["transient/u"][:].tobytes() == one["transient/u"][:].tobytes()


def test_results_do_not_replace_the_deck_of_a_restart(interrupted):
    (interrupted.folder / "deck.inp").rename(interrupted.folder / "plan.h5")
    said = refused(interrupted, "-o", "plan", "--restart", "deck.chk.h5", "plan.h5", status=1)
    assert said.startswith("plan.h5 is the deck, or a table that it reads: give the results another name")


def test_results_do_not_replace_the_checkpoint(interrupted):
    shutil.copy(interrupted.folder / "deck.chk.h5", interrupted.folder / "a b.h5")
    said = refused(interrupted, "-o", "a b", "--restart", "a b.h5", "deck.inp", status=1)
    assert said.startswith("a b.h5 is the checkpoint that the run goes on from: give the results another")


def test_advice_can_be_pasted(gentbeam):
    (gentbeam.folder / "deck.inp").write_text(small_deck("TRANSIENT newmark step=1e-6 end=10"))
    gentbeam("-q", "--max-time", "0.04", "-o", "it's $HOME", "deck.inp", status=4)
    assert gentbeam.err.endswith("""--restart 'it'\\''s $HOME.chk.h5'\n""")


def test_another_table_is_refused(gentbeam):
    (gentbeam.folder / "load.txt").write_text("0 0\n1e-3 1\n")
    model = "HISTORY push table file=load.txt\nPOINT x=10 f3=1 history=push"
    deck = small_deck("CHECKPOINT every=3\nTRANSIENT newmark step=1e-4 end=1e-3", model)
    (gentbeam.folder / "deck.inp").write_text(deck)
    gentbeam("-q", "deck.inp")
    (gentbeam.folder / "load.txt").write_text("0 0\n1e-3 1.5\n")
    assert "a table that the deck reads from a file has changed" in refused(
        gentbeam, "--restart", "deck.chk.h5", "deck.inp", status=1
    )


def test_results_that_do_not_fit_are_refused(interrupted):
    folder = interrupted.folder
    arguments = ["--restart", "deck.chk.h5", "deck.inp"]
    start = "cannot restart from deck.chk.h5 without the results of the steps before it: deck.h5 "
    (folder / "deck.h5").rename(folder / "away.h5")
    assert refused(interrupted, *arguments) == start + "is not there"
    (folder / "deck.h5").write_text("nothing of the kind")
    assert refused(interrupted, *arguments) == start + "is no HDF5 file, or is damaged"
    shutil.copy(folder / "deck.chk.h5", folder / "deck.h5")
    assert refused(interrupted, *arguments) == start + "holds the results of another run"
    shutil.copy(folder / "away.h5", folder / "deck.h5")
    interrupted("-q", *arguments)


def test_files_that_are_no_checkpoints_are_refused(interrupted):
    folder = interrupted.folder
    assert refused(interrupted, "--restart", "no.h5", "deck.inp") == (
        "cannot read the checkpoint no.h5: No such file or directory"
    )
    said = "it is no checkpoint of gentbeam, or it is damaged"
    assert refused(interrupted, "--restart", "deck.h5", "deck.inp") == f"cannot restart from deck.h5: {said}"
    (folder / "empty").write_bytes(b"")
    assert refused(interrupted, "--restart", "empty", "deck.inp") == f"cannot restart from empty: {said}"
    (folder / "folder").mkdir()
    assert refused(interrupted, "--restart", "folder", "deck.inp").startswith("cannot re")


def test_another_program_is_refused(interrupted):
    """A checkpoint whose version is another one, resealed as that program would have."""
    path = interrupted.folder / "deck.chk.h5"
    with h5py.File(path, "r+") as file:
        file.attrs["program_version"] = "9.9.9"
    reseal(path)
    message = refused(interrupted, "--restart", "deck.chk.h5", "deck.inp")
    assert "it was written by gentbeam 9.9.9 (" in message and "only the same program goes on" in message


def reseal(path):
    # h5py cuts off what it does not know.
    data = path.read_bytes().partition(b"gentbeam sealed file")[0]
    digest = 0xCBF29CE484222325
    for byte in data:
        digest = (digest ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    seal = f"gentbeam sealed file, length {len(data)}, FNV-1a {digest:016x}\n"
    path.write_bytes(data + seal.encode().ljust(512, b"\0"))


def test_a_piece_that_is_missing_is_told(interrupted):
    path = interrupted.folder / "deck.chk.h5"
    with h5py.File(path, "r+") as file:
        del file["memory/stepper.factors_start"]
    reseal(path)
    assert "does not fit this model: 'stepper.factors_start' is missing" in refused_late(interrupted)


def refused_late(gentbeam):
    gentbeam("-q", "--restart", "deck.chk.h5", "deck.inp", status=3)
    return gentbeam.sole_error()


@pytest.mark.parametrize("where", ["bits", "ends"])
def test_damaged_checkpoints_are_refused(interrupted, where):
    """Every bit counts: one that is wrong, or an end that is missing, and the file is refused."""
    path = interrupted.folder / "deck.chk.h5"
    whole = path.read_bytes()
    results = (interrupted.folder / "deck.h5").read_bytes()
    places = range(0, len(whole), max(1, len(whole) // 60))
    for number, place in enumerate(places):
        data = bytearray(whole[:place] if where == "ends" else whole)
        if where == "bits":
            data[place] ^= 1 << number % 8
        path.write_bytes(data)
        interrupted("--restart", "deck.chk.h5", "deck.inp", status=3)
        assert "it is no checkpoint of gentbeam, or it is damaged" in interrupted.sole_error()
        assert (interrupted.folder / "deck.h5").read_bytes() == results
    path.write_bytes(whole)
    interrupted("-q", "--restart", "deck.chk.h5", "deck.inp")


def test_checkpoint_in_place_of_the_results(gentbeam):
    deck = small_deck("CHECKPOINT every=1 file=./out.h5\nTRANSIENT newmark step=1e-4 end=1e-3")
    (gentbeam.folder / "out.h5").write_bytes(b"old")
    gentbeam("-o", "out", deck=deck, status=1)
    assert "give checkpoints another name" in gentbeam.sole_error()
    assert (gentbeam.folder / "out.h5").read_bytes() == b"old"


@pytest.mark.parametrize("study", [False, True], ids=["run", "study"])
def test_checkpoint_in_place_of_other_files(gentbeam, study):
    """Neither the deck, nor a table, nor the results, by whatever name, nor what is no ordinary file."""
    folder = gentbeam.folder
    (folder / "load.txt").write_text("0 0\n1e-3 1\n")
    (folder / "here").symlink_to(".")
    os.mkfifo(folder / "pipe")
    model = "HISTORY push table file=load.txt\nPOINT x=10 f3=1 history=push"
    if study:
        model += "\nPARAMETER s=1\nSWEEP s=[1 2]"
    for place in ["deck.inp", "load.txt", "pipe", "deck.h5", "deck.h5.part", "here/deck.h5"]:
        deck = small_deck(f"CHECKPOINT every=1 file={place}\nTRANSIENT newmark step=1e-4 end=1e-3", model)
        (folder / "deck.inp").write_text(deck)
        gentbeam("-q", "deck.inp", status=1)
        assert f"CHECKPOINT file=: {place} is " in gentbeam.sole_error()
        assert (folder / "deck.inp").read_text() == deck
        assert sorted(os.listdir(folder)) == ["deck.inp", "here", "load.txt", "pipe"]
    # An empty file, made to have a name of one's own, is none of these.
    (folder / "mine").touch()
    (folder / "deck.inp").write_text(deck.replace(place, "mine"))
    gentbeam("-q", "deck.inp")
    assert h5py.is_hdf5(folder / "mine")


def test_checkpoint_that_cannot_be_written(gentbeam):
    """On the way it is warned of; at the end of an interrupted run it is an error, for nothing is saved."""
    deck = small_deck("CHECKPOINT every=2 file=no/such/place.h5\nTRANSIENT newmark step=1e-4 end=1e-3")
    gentbeam("-o", "out", deck=deck)
    trouble = "cannot write the checkpoint no/such/place.h5: No such file or directory"
    assert gentbeam.out.count(f"warning: {trouble}; the run goes on") == 5
    endless = deck.replace("every=2", "every=100000").replace("end=1e-3", "end=1")
    (gentbeam.folder / "deck.inp").write_text(endless)
    command = [gentbeam.executable, "deck.inp"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, cwd=gentbeam.folder, **pipes) as process:
        while b"step  " not in process.stdout.readline():
            pass
        process.send_signal(signal.SIGTERM)
        err = process.communicate(timeout=SECONDS)[1].decode()
    assert process.returncode == 3
    assert "stopped by SIGTERM after step " in err and trouble in err
    with gentbeam.results("deck") as file:
        assert file.attrs["status"] == "failed" and file.attrs["message"].endswith(trouble)
        assert file.attrs["wall_seconds"] > 0


@pytest.mark.parametrize("value", ["", "0", "-1", "soon", "1e10", "1 2"])
def test_wrong_time_limits(gentbeam, value):
    gentbeam("--max-time", value, deck=small_deck(), status=1)
    assert gentbeam.sole_error() == f"option --max-time needs a number of seconds above 0, not '{value}'"
    assert os.listdir(gentbeam.folder) == []

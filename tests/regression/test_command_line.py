"""Options, the log, and the progress bar."""

import os
import pty
import re
import select
import subprocess

import h5py
import pytest
from conftest import small_deck


def test_deck_from_a_file_and_from_standard_input(gentbeam):
    (gentbeam.folder / "bend.inp").write_text(small_deck())
    gentbeam("bend.inp")
    assert "results: bend.h5" in gentbeam.out
    gentbeam(deck=small_deck())
    assert "results: gentbeam.h5" in gentbeam.out
    gentbeam("-", deck=small_deck())
    with gentbeam.results("bend") as file, gentbeam.results() as piped:
        assert file["transient/u"][()].tobytes() == piped["transient/u"][()].tobytes()


def test_deck_in_a_folder_leaves_its_results_here(gentbeam):
    (gentbeam.folder / "decks").mkdir()
    (gentbeam.folder / "decks" / "bend.inp").write_text(small_deck())
    gentbeam("decks/bend.inp")
    assert re.search(r"results: (decks/)?bend\.h5", gentbeam.out)
    name = re.search(r"results: (\S+)", gentbeam.out).group(1)
    assert h5py.is_hdf5(gentbeam.folder / name)


@pytest.mark.parametrize("option", [("-o", "out"), ("-o", "out.h5"), ("--output", "out"), ("--output=out",)])
def test_output(gentbeam, option):
    gentbeam(*option, deck=small_deck(model="OUTPUT file=other"))
    assert [path.name for path in gentbeam.folder.iterdir()] == ["out.h5"]


def test_output_of_the_deck(gentbeam):
    gentbeam(deck=small_deck(model="OUTPUT file=other"))
    assert [path.name for path in gentbeam.folder.iterdir()] == ["other.h5"]


def test_a_deck_that_writes_elsewhere_is_told(gentbeam):
    """A deck may be somebody else's. Who names the file on the command line knows where it goes."""
    inner = gentbeam.folder / "inner"
    inner.mkdir()
    tasks = "CHECKPOINT every=100 file=/tmp/never.h5\nTRANSIENT newmark step=2e-4 end=1e-3"
    deck = small_deck(tasks, "OUTPUT file=../up")
    out = gentbeam(deck=deck, cwd=inner).out
    assert "warning: the deck puts the results outside this folder, into ../up.h5" in out
    assert "warning: the deck puts checkpoints outside this folder, into /tmp/never.h5" in out
    assert (gentbeam.folder / "up.h5").exists()
    assert "warning" not in gentbeam("-o", "../up", deck=small_deck(), cwd=inner).out
    assert "warning" not in gentbeam(deck=small_deck(model="OUTPUT file=a..b"), cwd=inner).out


def test_name_with_blanks_and_letters_of_other_scripts(gentbeam):
    gentbeam("-o", "Balken \u00fcber zwei", deck=small_deck())
    assert h5py.is_hdf5(gentbeam.folder / "Balken \u00fcber zwei.h5")


def test_set_replaces_parameters(gentbeam):
    tips = []
    for options in ([], ["--set", "q=5.7"], ["--set=q=2*2.85"], ["--set", "q=1", "--set", "jm=0.5"]):
        gentbeam(*options, deck=small_deck())
        with gentbeam.results() as file:
            tips.append(file["transient/probes/tip"][1])
    assert tips[1] == tips[2] == pytest.approx(2.0 * tips[0], rel=0.01)
    assert tips[3] == pytest.approx(tips[0] / 2.85, rel=0.05)


@pytest.mark.parametrize(
    "options, words",
    [
        (["--set", "p=1"], ["--set p=1", "no parameter 'p'"]),
        (["--set", "q=1/0"], ["--set q=1/0", "division by zero"]),
        (["--set", "q=abc"], ["--set q=abc", "abc"]),
        (["--set", "q"], ["--set needs name=value", "'q'"]),
        (["--set", "=3"], ["--set needs name=value"]),
        (["--set", "q="], ["--set needs name=value"]),
        (["--set"], ["option --set needs a value"]),
        (["-o"], ["option -o needs a value"]),
        (["-o", ""], ["option -o needs a file name"]),
        (["-o", "/"], ["option -o needs a file name"]),
        (["-o", "folder/"], ["option -o needs a file name"]),
        (["-o", ".."], ["option -o needs a file name"]),
        (["--merge", "folder/", "a.h5"], ["option --merge needs a file name"]),
        (["-o", "two\nlines"], ["option -o needs a file name without line ends"]),
        (["--outptu", "x"], ["unknown option '--outptu'", "did you mean '--output'?"]),
        (["-z"], ["unknown option '-z'"]),
        (["--threads", "0"], ["--threads needs a whole number", "'0'"]),
        (["--threads", "two"], ["--threads needs a whole number", "'two'"]),
        (["one.inp", "two.inp"], ["one deck at a time", "one.inp", "two.inp"]),
        ([""], ["name of the deck is empty"]),
    ],
)
def test_wrong_options(gentbeam, options, words):
    gentbeam(*options, deck=small_deck(), status=1)
    for word in words:
        assert word in gentbeam.err
    assert "error" in gentbeam.err
    assert list(gentbeam.folder.iterdir()) == []


def test_check_runs_nothing(gentbeam):
    gentbeam("--check", deck=small_deck())
    assert "4 elements of 3 nodes" in gentbeam.out and "Newton" not in gentbeam.out
    assert list(gentbeam.folder.iterdir()) == []
    gentbeam("--check", deck=small_deck("NONSENSE"), status=1)
    assert "<stdin>:12:1: error: unknown command 'NONSENSE'" in gentbeam.err


def test_version(gentbeam):
    gentbeam("--version")
    assert re.fullmatch(r"gentbeam \d+\.\d+\.\d+ \(\S+\)\n", gentbeam.out)


def test_help_names_every_option(gentbeam):
    gentbeam("--help")
    for option in "output set check threads quiet verbose keywords version help".split():
        assert f"--{option}" in gentbeam.out
    assert "exit status" in gentbeam.out
    first = gentbeam.out
    assert gentbeam("-h").out == first


def test_keywords_lists_every_command(gentbeam):
    gentbeam("--keywords")
    for keyword in "MATERIAL SECTION LINE CLAMP DISTRIBUTED PROBE STATIC MODAL TRANSIENT STOP".split():
        assert re.search(rf"\b{keyword}\b", gentbeam.out), keyword


def test_quiet_and_verbose(gentbeam):
    gentbeam("-q", deck=small_deck())
    assert gentbeam.out == "" and gentbeam.err == ""
    normal = gentbeam(deck=small_deck()).out
    verbose = gentbeam("-v", deck=small_deck()).out
    assert "iteration" not in normal.replace("Newton iterations", "")
    assert "iteration 1  increment " in verbose


def test_log_says_what_came_out(gentbeam):
    gentbeam(deck=small_deck("TRANSIENT newmark step=1e-4 end=5e-3"))
    with gentbeam.results() as file:
        tip = file["transient/probes/tip"][:]
    largest = float(re.search(r"tip: largest (\S+) at t = ", gentbeam.out).group(1))
    assert largest == pytest.approx(tip.max(), rel=1e-5)
    assert re.search(r"50 steps, \d+ Newton iterations, 0 cuts", gentbeam.out)
    assert "energy: kinetic" in gentbeam.out
    assert gentbeam.err == ""
    assert len(gentbeam.out.splitlines()) < 45


def test_log_that_cannot_be_written(gentbeam):
    with open("/dev/full", "w") as full:
        gentbeam(deck=small_deck(), status=3, stdout=full)
    assert "standard output" in gentbeam.sole_error()
    with gentbeam.results() as file:
        assert file.attrs["status"] == "complete"


def test_check_that_cannot_be_written(gentbeam):
    with open("/dev/full", "w") as full:
        gentbeam("--check", deck=small_deck(), status=3, stdout=full)
    assert "could not be written to standard output" in gentbeam.sole_error()


def test_log_into_a_closed_pipe(gentbeam):
    """Nobody reads it: an error, or the end by the signal that says so, but no backtrace."""
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [gentbeam.executable],
        input=small_deck().encode(),
        stdout=writer,
        stderr=subprocess.PIPE,
        cwd=gentbeam.folder,
        timeout=60,
    )
    os.close(writer)
    assert done.returncode in (3, -13)
    assert b"Backtrace" not in done.stderr and b"Fortran runtime" not in done.stderr


@pytest.mark.parametrize("option", ["--help", "--version", "--keywords", "--man", "--completion"])
def test_texts_that_cannot_be_written(gentbeam, option):
    with open("/dev/full", "w") as full:
        done = subprocess.run([gentbeam.executable, option], stdout=full, stderr=subprocess.PIPE, timeout=60)
    assert done.returncode == 3
    assert done.stderr == b"gentbeam: error: standard output took no more\n"


def test_error_message_that_cannot_be_written(gentbeam):
    with open("/dev/full", "w") as full:
        gentbeam("no.inp", status=3, stderr=full)


def on_terminal(gentbeam, *options):
    """What the program writes to standard error when that is a terminal."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [gentbeam.executable, *options],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=theirs,
        cwd=gentbeam.folder,
    )
    os.close(theirs)
    process.stdin.write(small_deck("TRANSIENT newmark step=2e-7 end=6e-3").encode())
    process.stdin.close()
    written = b""
    while select.select([ours], [], [], 60.0)[0]:
        try:
            block = os.read(ours, 65536)
        except OSError:
            break
        if not block:
            break
        written += block
    os.close(ours)
    assert process.wait(60) == 0
    return written.decode()


def test_progress_bar_on_a_terminal(gentbeam):
    text = on_terminal(gentbeam)
    parts = re.findall(r"\r  \[(#*)(\.*)\] (\d+) %, ((?:\d+ (?:h|min|s) ?)+) left", text)
    assert parts
    assert all(len(done) + len(left) == 40 for done, left, _, _ in parts)
    percentages = [int(percent) for _, _, percent, _ in parts]
    assert percentages == sorted(percentages) and percentages[-1] <= 100
    assert text.endswith("\r"), "the bar is not wiped off"


def test_no_bar_elsewhere(gentbeam):
    gentbeam(deck=small_deck("TRANSIENT newmark step=2e-7 end=6e-3"))
    assert gentbeam.err == ""
    assert on_terminal(gentbeam, "-q") == ""


SCENE = """\
GENTBEAM everything that can be drawn
MATERIAL m gent mu=5000 c=2500 jm=2 rho=1e-6
SECTION thick rectangle b=1 h=1
SECTION thin rectangle b=1 h=0.5
LINE from=0 to=6 elements=6 section=thick
LINE from=6 to=12 elements=2 nodes=5 section=thin
PIN x=0
ROLLER x=6
CLAMP x=12
PRESCRIBE x=7.5 u3=-0.25
POINT x=3 f1=2 m3=-1
DISTRIBUTED from=3 to=9 q3=-20
GRAVITY g3=9.81
END
STATIC
STOP
"""


def test_check_draws_the_model_to_scale(gentbeam):
    """61 columns for the beam: 5 a unit of length."""
    gentbeam("--check", deck=SCENE)
    drawn = gentbeam.out.split("0 probes, 1 solution command\n\n")[1]
    lines = drawn.splitlines()
    assert [line[14:] for line in lines[:5]] == [
        61 * "^",
        15 * " " + 31 * "v",
        15 * " " + ">",
        15 * " " + "@",
        38 * " " + "*",
    ]
    assert [line[:14].strip() for line in lines[:5]] == ["g3 9.81", "q3 -20", "f1 2", "m3 -1", "u3 = -0.25"]
    beam = lines[5][14:]
    assert len(beam) == 61
    assert [i for i, mark in enumerate(beam) if mark == "+"] == [0, 5, 10, 15, 20, 25, 30, 45, 60]
    assert [i for i, mark in enumerate(beam[:30]) if mark == "o"] == [3, 8, 13, 18, 23, 28]
    assert beam[31:60].count("o") == 6 and beam[:30].count("=") == 18 and beam[31:60].count("-") == 22
    assert lines[6][14:] == "A" + 29 * " " + "O" + 29 * " " + "X"
    assert lines[7].split() == ["0", "6", "12"] and lines[7].index("6") == 44
    assert "- thinner" in lines[8] and len(lines) == 9


@pytest.mark.parametrize("fields, mark", [("u1 u3", "A"), ("u1 u3 y1", "X"), ("u1 y1", "I"), ("u3", "O")])
def test_check_draws_what_a_support_holds(gentbeam, fields, mark):
    """y1 is the rotation; y3 is the thickness, which a clamp may leave free."""
    gentbeam("--check", deck=small_deck().replace("CLAMP", f"FIX {fields}"))
    assert 14 * " " + mark in gentbeam.out.splitlines()


def test_check_draws_many_nodes(gentbeam):
    gentbeam("--check", deck=small_deck().replace("elements=4", "elements=400"))
    assert 14 * " " + 61 * "#" in gentbeam.out.splitlines() and "# several nodes" in gentbeam.out


ESCAPE = "\x1b["


def both_on_terminal(gentbeam, *options, deck, **environment):
    """Output and errors of the program on a terminal, and its exit status."""
    ours, theirs = pty.openpty()
    (gentbeam.folder / "deck.inp").write_text(deck)
    process = subprocess.Popen(
        [gentbeam.executable, *options, "deck.inp"],
        stdout=theirs,
        stderr=theirs,
        cwd=gentbeam.folder,
        env={**{k: v for k, v in os.environ.items() if k != "NO_COLOR"}, "TERM": "xterm", **environment},
    )
    os.close(theirs)
    written = b""
    while select.select([ours], [], [], 60.0)[0]:
        try:
            block = os.read(ours, 65536)
        except OSError:
            break
        if not block:
            break
        written += block
    os.close(ours)
    return written.decode().replace("\r\n", "\n"), process.wait(60)


def test_colours_on_a_terminal(gentbeam):
    wrong = small_deck().replace("elements=4", "elemnts=4")
    text, status = both_on_terminal(gentbeam, deck=wrong)
    assert status == 1
    bold, red, green, reset = (ESCAPE + code for code in ("1m", "1;31m", "32m", "0m"))
    assert f"{bold}deck.inp:6:29: {reset}{red}error:{reset} unknown key 'elemnts' in LINE\n" in text
    assert re.search(re.escape(green) + r" +\^~+" + re.escape(reset) + "\n", text)
    text, status = both_on_terminal(gentbeam, deck=small_deck())
    assert status == 0 and f"{green}done in" in text


@pytest.mark.parametrize("environment", [{"NO_COLOR": "1"}, {"TERM": "dumb"}])
def test_no_colours_where_they_are_not_wanted(gentbeam, environment):
    for deck in (small_deck(), small_deck().replace("elements=4", "elemnts=4")):
        text, _ = both_on_terminal(gentbeam, deck=deck, **environment)
        assert ESCAPE not in text and text


def test_no_colours_in_pipes(gentbeam):
    gentbeam(deck=small_deck())
    assert ESCAPE not in gentbeam.out
    gentbeam(deck=small_deck().replace("elements=4", "elemnts=4"), status=1)
    assert ESCAPE not in gentbeam.err

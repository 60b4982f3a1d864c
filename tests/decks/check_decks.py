#!/usr/bin/env python3
"""Runs gentbeam on bad and good decks and compares what it says.

    check_decks.py GENTBEAM [--update]

bad/NAME.inp must end with status 1 and exactly the text of bad/NAME.err on standard error, once named on the
command line and once through standard input. good/NAME.inp must pass `--check`. Decks that are too large or
too odd to keep are made here. With --update the .err files are written anew: read them before they are kept.
"""
import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
BEGIN = "<!-- commands: begin -->"
END = "<!-- commands: end -->"
# More than any deck may take; builds with sanitizers ask for patience.
SECONDS = 60*int(os.environ.get("GENTBEAM_PATIENCE", "1"))
DECK = (HERE / "good" / "plain.inp").read_bytes()


class Results:
    """Counts checks and says which of them failed."""

    def __init__(self):
        self.passed = 0
        self.failed = 0

    def check(self, name, problems):
        if problems:
            self.failed += 1
            print(f"FAILED {name}")
            for problem in problems:
                print("    " + problem.replace("\n", "\n    "))
        else:
            self.passed += 1


def run(program, arguments, text=None, folder=HERE):
    """Exit status, standard output and standard error of one run."""
    done = subprocess.run([program, *arguments], input=text, cwd=folder, timeout=SECONDS, check=False,
                          stdin=subprocess.DEVNULL if text is None else None, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE)
    return done.returncode, done.stdout, done.stderr.decode("utf-8", "backslashreplace")


def unlike(expected, found):
    """What to say where the texts differ."""
    return [] if expected == found else [f"expected:\n{expected}\nfound:\n{found}"]


def results_files():
    return {str(path) for path in HERE.rglob("*.h5")}


def check_bad(program, results, update):
    for deck in sorted((HERE / "bad").glob("*.inp")):
        name = f"bad/{deck.name}"
        before = results_files()
        status, _, said = run(program, [name])
        wanted = deck.with_suffix(".err")
        if update:
            wanted.write_text(said, encoding="utf-8")
        problems = unlike(wanted.read_text(encoding="utf-8") if wanted.exists() else "(no .err file)", said)
        if status != 1:
            problems.append(f"exit status {status}, not 1")
        if results_files() != before:
            problems.append("a results file appeared")
        results.check(name, problems)
        status, _, through = run(program, [], deck.read_bytes(), deck.parent)
        problems = unlike(said.replace(name, "<stdin>").replace("bad/", ""), through)
        if status != 1:
            problems.append(f"exit status {status}, not 1")
        results.check(name + " through standard input", problems)


def check_good(program, results):
    for deck in sorted((HERE / "good").glob("*.inp")):
        name = f"good/{deck.name}"
        for arguments, text in ((["--check", name], None), (["--check"], deck.read_bytes())):
            status, _, said = run(program, arguments, text, HERE if text is None else deck.parent)
            problems = unlike("", said)
            if status != 0:
                problems.append(f"exit status {status}, not 0")
            results.check(name if text is None else name + " through standard input", problems)


def check_text(program, results, name, text, first_lines, arguments=(), status=1, exact=False):
    """A generated deck: its status, and what standard error begins with (or is, exactly)."""
    started = time.monotonic()
    found, _, said = run(program, [*arguments], text)
    problems = []
    if not said.startswith(first_lines) or (exact and said != first_lines):
        problems.append(f"expected the beginning:\n{first_lines}\nfound:\n{said[:2000]}")
    if found != status:
        problems.append(f"exit status {found}, not {status}")
    if len(said) > 20000:
        problems.append(f"a message of {len(said)} characters")
    if time.monotonic() - started > 30:
        problems.append(f"it took {time.monotonic() - started:.0f} s")
    results.check(name, problems)


def replaced(old, new):
    assert old in DECK
    return DECK.replace(old, new, 1)


def check_generated(program, results):
    def bad(name, text, first_lines):
        check_text(program, results, name, text, "<stdin>:" + first_lines)

    def good(name, text):
        check_text(program, results, name, text, "", ["--check"], 0)

    check_long_lines(bad, good)
    check_many_things(bad, good)
    check_depths(bad, good)
    check_bytes(bad, good)
    check_text(program, results, "more than 64 MB", b" " * (65 * 1024 * 1024),
               "gentbeam: error: standard input is larger than 64 MB")


def check_long_lines(bad, good):
    good("a comment of 10 MB", replaced(b"CLAMP", b"! " + b"x" * 10_000_000 + b"\nCLAMP"))
    bad("a line of 10 MB, one word", replaced(b"CLAMP x=0", b"CLAMP x=0 " + b"y" * 10_000_000),
        "6:11: error: unexpected '" + "y" * 40 + "...' in CLAMP\n")
    bad("a line of 10 MB, a million words", replaced(b"CLAMP x=0", b"CLAMP x=0" + b" wordwords" * 1_000_000),
        "6:11: error: unexpected 'wordwords' in CLAMP\n")
    bad("a line of 10 MB, the mistake at its end",
        replaced(b"CLAMP x=0", b"CLAMP " + b" " * 10_000_000 + b"x=zero"),
        "6:10000009: error: undefined parameter 'zero'\n    ...")
    bad("a million unknown keys", replaced(b"CLAMP x=0", b"CLAMP x=0" + b" key=1" * 1_000_000),
        "6:11: error: unknown key 'key' in CLAMP\n")
    bad("a million equals signs", replaced(b"CLAMP x=0", b"CLAMP x=0" + b" =" * 1_000_000), "6:")
    bad("only continuations", b"&\n" * 100_000, "100000:1: error: the deck ends where '&' says")
    bad("only line feeds", b"\n" * 1_000_000, "1:1: error: the deck is empty")


def check_many_things(bad, good):
    def repeated(form, count):
        return b"".join(form(i) for i in range(count))

    good("three hundred thousand parameters", replaced(
        b"CLAMP", b"PARAMETER p0=1" + repeated(lambda i: b" p%d=p%d+1" % (i + 1, i), 300_000) + b"\nCLAMP"))
    bad("three hundred thousand undefined parameters", replaced(
        b"CLAMP", b"PARAMETER" + repeated(lambda i: b" p%d=q%d" % (i, i), 300_000) + b"\nCLAMP"),
        "6:14: error: undefined parameter 'q0'\n")
    bad("a hundred thousand materials", replaced(
        b"LINE", repeated(lambda i: b"MATERIAL m%d gent mu=1 c=1 jm=1 rho=1\n" % i, 100_000)
        + b"MATERIAL m7 elastic e=1\nLINE"),
        "100005:1: error: missing keys 'nu', 'rho' in MATERIAL elastic\n")
    bad("a hundred thousand unknown commands", replaced(b"CLAMP", b"CLAMB x=0\n" * 100_000 + b"CLAMP"),
        "6:1: error: unknown command 'CLAMB'\n")
    bad("a hundred thousand solution commands", replaced(
        b"STOP", b"STATIC\n" * 100_000 + b"PIN x=0\nSTOP"),
        "100011:1: error: PIN belongs to the model")
    bad("a hundred thousand lines in reverse order", replaced(
        b"CLAMP", repeated(lambda i: b"LINE from=%d to=%d elements=1\n" % (100_000 - i, 100_001 - i), 99_990)
        + b"CLAMP"),
        "99995:11: error: LINEs must join end to end: this one starts at x = 11, the one before it ends "
        "at x = 10 (a gap)\n")


def check_depths(bad, good):
    def place(text):
        return replaced(b"x=0", b"x=" + text)

    for depth in (1_000, 1_000_000):
        bad(f"{depth} parentheses", place(b"(" * depth + b"1" + b")" * depth),
            "6:109: error: nested deeper than 100")
        bad(f"{depth} open parentheses", place(b"(" * depth), "6:9: error: this '(' is never closed\n")
        bad(f"{depth} calls", place(b"abs(" * depth + b"1" + b")" * depth),
            "6:412: error: nested deeper than 100")
        bad(f"{depth} powers", place(b"2" + b"^1" * depth), "6:210: error: nested deeper than 100")
        good(f"{depth} signs", place(b"-" * depth + b"0"))
        good(f"{depth} sums", place(b"0" + b"+0" * depth))


def check_bytes(bad, good):
    no_text = "error: this is no plain text: it holds the byte "
    bad("NUL bytes", b"\0" * 100, f"1:1: {no_text}0x00\n")
    bad("an executable", b"\x7fELF\x02\x01\x01\0\0\0", f"1:1: {no_text}0x7F\n")
    bad("a results file", b"\x89HDF\r\n\x1a\n\0\0", f"2:1: {no_text}0x1A\n")
    bad("UTF-16", DECK.decode().encode("utf-16-le"), f"1:2: {no_text}0x00\n")
    bad("a lone carriage return", replaced(b"x=0", b"x=0\rPIN x=1"), f"6:10: {no_text}0x0D\n")
    bad("broken UTF-8", replaced(b"x=0", b"x=\xc3\x28\xff"), "6:10: error: this '(' is never closed\n")
    bad("an escape sequence", replaced(b"x=0", "x=0\u009b31m".encode()), "6:10: error: unexpected '?' in an")
    good("NUL bytes after STOP", DECK + b"\0\0\0")


def check_overrides(program, results):
    def override(name, settings, first_lines, status=1, exact=False):
        arguments = ["--check"] + [word for setting in settings for word in ("--set", setting)]
        check_text(program, results, "--set " + name, DECK, first_lines, arguments, status, exact)

    override("a value", ["h=0.5"], "", 0)
    override("an expression", ["h=L/20"], "", 0)
    override("twice", ["h=0.5", "H=0.25"], "", 0)
    override("an unknown name", ["hh=1"], "--set hh=1: error: the deck has no parameter 'hh'\n")
    override("a misspelt name", ["LL=1"], "--set LL=1: error: the deck has no parameter 'LL'\n")
    override("a name defined later", ["L=h"], "--set L=h: error: parameter 'h' is used before it is defined\n"
             "<stdin>:2:16: note: defined here\n    PARAMETER L=10 h=1\n                   ^\n")
    override("a division by zero", ["h=1/0"], "--set h=1/0: error: division by zero\n")
    override("a name like a function's", ["h=abc"],
             "--set h=abc: error: undefined parameter 'abc'\n", exact=True)
    swept = DECK.replace(b"\nMATERIAL", b"\nSWEEP h=[1 2]\nMATERIAL")
    check_text(program, results, "--set what a SWEEP varies", swept,
               "<stdin>:3:7: error: parameter 'h' is varied here, and given by --set\n", ["--check", "--set", "h=3"])
    override("a value out of range", ["h=-1"], "<stdin>:4:32: error: 'h' must be above 0, and is -1\n")


def check_reference(program, results):
    """The commands in docs/deck.md are what the program prints."""
    status, said, _ = run(program, ["--keywords", "--markdown"])
    _, begin, rest = (HERE.parents[1] / "docs" / "deck.md").read_text(encoding="utf-8").partition(BEGIN)
    written, end, _ = rest.partition(END)
    problems = unlike(said.decode().strip(), written.strip())
    if status != 0 or not begin or not end:
        problems.append(f"exit status {status}, or no marks in docs/deck.md")
    results.check("docs/deck.md", problems)
    status, said, _ = run(program, ["--keywords"])
    problems = [] if status == 0 and b"TRANSIENT newmark" in said else [f"exit status {status}"]
    problems += [f"longer than 110 columns: {line}" for line in said.decode().splitlines() if len(line) > 110]
    results.check("--keywords", problems)


def check_files(program, results):
    """Decks that cannot be read: status 3 and a sentence."""
    with tempfile.TemporaryDirectory() as folder:
        for name, path in (("a missing file", "missing.inp"), ("a folder", folder)):
            status, _, said = run(program, [path], folder=folder)
            problems = [] if status == 3 else [f"exit status {status}, not 3"]
            if path not in said or "cannot read" not in said:
                problems.append(f"it said:\n{said}")
            results.check(name, problems)
        fifo = Path(folder, "pipe.inp")
        os.mkfifo(fifo)
        with subprocess.Popen([program, "--check", str(fifo)], stdout=subprocess.DEVNULL) as process:
            fifo.write_bytes(DECK)
            results.check("a named pipe", [] if process.wait(SECONDS) == 0 else ["it was not read"])


def check_mutations(program, results, count=300):
    """Good decks with bytes changed at random: whatever is said, the program ends as documented."""
    chance = random.Random(1975)
    decks = [path.read_bytes() for path in sorted((HERE / "good").glob("*.inp"))]
    alphabet = b" =()[]\"&!#,\n\r\t+-*/^.0123456789eExtLh\xc3\xbc\0"
    problems = []
    for _ in range(count):
        text = bytearray(chance.choice(decks))
        for _ in range(chance.randint(1, 8)):
            place = chance.randrange(len(text))
            kind = chance.randrange(3)
            if kind == 0:
                del text[place:place + chance.randint(1, 12)]
            elif kind == 1:
                text.insert(place, chance.choice(alphabet))
            else:
                text[place] = chance.choice(alphabet)
            text = text or bytearray(b" ")
        status, _, said = run(program, ["--check"], bytes(text))
        if status not in (0, 1) or (status == 1) != bool(said):
            problems.append(f"exit status {status}, {len(said)} characters of diagnostics: {bytes(text)!r}")
    results.check(f"{count} decks changed at random", problems)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="the gentbeam executable")
    parser.add_argument("--update", action="store_true", help="write the .err files anew")
    options = parser.parse_args()
    program = str(Path(options.program).resolve())
    results = Results()
    check_bad(program, results, options.update)
    check_good(program, results)
    check_generated(program, results)
    check_overrides(program, results)
    check_files(program, results)
    check_reference(program, results)
    check_mutations(program, results)
    print(f"{results.passed} passed, {results.failed} failed")
    return 0 if results.failed == 0 and results.passed > 0 else 1


if __name__ == "__main__":
    sys.exit(main())

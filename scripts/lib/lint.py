"""Checks the style of the sources; prints one line a finding, exits 1 when there is any, changes no file.

Every text: at most 110 columns, no tabs, no trailing blanks, a line feed at the end.
Fortran: `implicit none` in every module and program; `stop` in src/main.f90 alone; keywords in lower case;
blocks indented by four columns, as fprettify indents them (the alignment of continued lines is free).
Rooms: a module in src/ uses modules of its own room and of the rooms below it only.
Build files: no option that breaks NaN tests (-Ofast, -ffast-math).
"""

import argparse
import io
import logging
import re
import sys
from pathlib import Path

import fprettify

ROOT = Path(__file__).resolve().parents[2]
MAX_COLUMNS = 110
# pFUnit's directives cannot be continued on a second line.
MAX_COLUMNS_DIRECTIVE = 120
INDENT = 4
# A file in another style would bury the findings of all others.
MAX_SHOWN = 10
FORTRAN = {".f90", ".F90", ".pf"}
BUILD_FILES = {".cmake", ".json"}
TEXTS = FORTRAN | {".py", ".sh", ".cmake"}
NAMED_TEXTS = {"CMakeLists.txt", "scripts/run", "scripts/test", "scripts/lint", "scripts/reproduce_paper",
    "scripts/make_pictures", "scripts/check_memory",
    ".ci/run"}
SKIPPED_FOLDERS = {".git", ".venv", "build", "results", "__pycache__"}
# Decks that are wrong on purpose, and tests of such texts.
SKIPPED_PATHS = ("tests/decks/",)

# What each room of src/ may use besides itself; src/main.f90 uses run alone.
ROOMS = {
    "base": (),
    "model": ("base",),
    "element": ("base", "model"),
    "solve": ("base", "model", "element"),
    "deck": ("base", "model"),
    "io": ("base", "model"),
    "study": ("base", "model", "element", "solve"),
    "tune": ("base", "model", "element", "solve", "study"),
    "run": ("base", "model", "element", "solve", "deck", "io", "study", "tune"),
    "main.f90": ("run",),
}
USE = re.compile(r"use\s+(gb_\w+)", re.I)

UNIT = re.compile(
    r"(?:module(?!\s+(?:procedure|subroutine|function)\b)|submodule\s*\(.*\)|program)\s+(\w+)", re.I
)
END_UNIT = re.compile(r"end\s*(module|submodule|program)\b", re.I)
IMPLICIT_NONE = re.compile(r"implicit\s+none\b", re.I)
KEYWORDS = set("""
    abstract allocatable allocate associate block call case character class contains cycle data deallocate
    default deferred dimension do elemental else elseif end enddo endif error exit extends final forall
    function generic if implicit import in include inout integer intent interface intrinsic kind len logical
    module none nopass only open optional out parameter pass print private procedure program protected public
    pure read real recursive result return rewind save select stop submodule subroutine target then to type
    use value where while write and or not eq ne lt le gt ge eqv neqv true false
    """.split())
STOP = re.compile(r"(?:^|\)|;)\s*(?:\d+\s+)?(?:error\s+)?stop\b(?!\s*=)", re.I)
FAST_MATH = re.compile(r"-Ofast\b|-f(?:unsafe-math-optimizations|fast-math|finite-math-only)\b")


def find_files(root):
    """Every file of the project that is checked, with its path relative to the root."""
    for path in sorted(root.rglob("*")):
        name = path.relative_to(root).as_posix()
        folders = path.relative_to(root).parts[:-1]
        if SKIPPED_FOLDERS.intersection(folders) or name.startswith(SKIPPED_PATHS) or not path.is_file():
            continue
        if path.suffix in TEXTS | BUILD_FILES or path.name in NAMED_TEXTS or name in NAMED_TEXTS:
            yield path, name


def strip_comment(line, quote=""):
    """The line without comment and with its texts blanked, and the quote still open at its end."""
    code = []
    for character in line:
        if quote:
            quote = "" if character == quote else quote
            code.append(" ")
        elif character in "'\"":
            quote = character
            code.append(" ")
        elif character == "!":
            break
        else:
            code.append(character)
    code = "".join(code)
    # A text goes on in the next line only behind an ampersand.
    return code, quote if quote and line.rstrip().endswith("&") else ""


def fortran_code(lines):
    """Number, code and "begins a statement" of every line; comments and texts are blanked."""
    quote, continued = "", False
    for number, line in enumerate(lines, 1):
        code, quote = strip_comment(line, quote)
        yield number, code, not continued
        if code.strip() or quote:
            continued = bool(quote) or code.rstrip().endswith("&")


def check_lines(name, lines):
    for number, line in enumerate(lines, 1):
        directive = name.endswith(".pf") and line.lstrip().startswith("@")
        limit = MAX_COLUMNS_DIRECTIVE if directive else MAX_COLUMNS
        if len(line) > limit:
            yield number, f"{len(line)} columns, at most {limit}"
        if "\t" in line:
            yield number, "tab"
        if line != line.rstrip():
            yield number, "trailing blank"


def statements(lines):
    """Number of the first line and code, continued lines joined, of every statement."""
    start, parts = 1, []
    for number, code, begins in fortran_code(lines):
        if begins:
            yield start, "".join(parts).strip()
            start, parts = number, []
        parts.append(code.strip().strip("&") + " ")
    yield start, "".join(parts).strip()


def check_fortran(name, lines):
    unit = None
    has_implicit_none = False
    for number, code in statements(lines):
        if name.startswith("src/") and name != "src/main.f90" and STOP.search(code):
            yield number, "stop outside src/main.f90: hand the error to the caller"
        for word in re.findall(r"(?<!%)\b[A-Za-z]+\b", code):
            if word.lower() in KEYWORDS and word != word.lower():
                yield number, f"keyword '{word}' not in lower case"
        if unit is None and UNIT.match(code):
            unit = (number, UNIT.match(code).group(1))
            has_implicit_none = False
        elif IMPLICIT_NONE.match(code):
            has_implicit_none = True
        elif END_UNIT.match(code) or code.lower() == "end":
            if unit and not has_implicit_none:
                yield unit[0], f"no implicit none in {unit[1]}"
            unit = None


def check_rooms(name, lines):
    """Uses that run against the order of the rooms; a module of a room is a file of its name there."""
    room = name.split("/")[1]
    for number, code in statements(lines):
        use = USE.match(code)
        if not use:
            continue
        homes = {path.parent.name for path in (ROOT / "src").glob(f"*/{use.group(1).lower()}.*")}
        if not homes & {room, *ROOMS.get(room, ())}:
            yield number, f"src/{room} may not use {use.group(1)} of {', '.join(sorted(homes)) or 'nowhere'}"


def check_indentation(name, text, lines):
    """Indentation of each statement's first line against fprettify's."""
    pretty = io.StringIO()
    try:
        fprettify.reformat_ffile(
            io.StringIO(text),
            pretty,
            impose_whitespace=False,
            indent_size=INDENT,
            llength=1024,
            orig_filename=name,
        )
    except fprettify.fparse_utils.FprettifyException as error:
        yield error.line_nr, f"fprettify cannot read it: {error}"
        return
    wanted = pretty.getvalue().split("\n")[:-1]
    if len(wanted) != len(lines):
        yield 1, "fprettify breaks lines in it; see fprettify --diff"
        return
    for (number, code, begins), line, want in zip(fortran_code(lines), lines, wanted):
        if not begins or not code.strip() or line.lstrip().startswith(("#", "@")):
            continue
        have, should = (len(side) - len(side.lstrip()) for side in (line, want))
        if have != should:
            yield number, f"indented by {have} columns, want {should}"


def check_file(path, name):
    try:
        text = path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        yield 1, "not UTF-8"
        return
    lines = text.split("\n")
    if lines.pop():
        yield len(lines) + 1, "no line feed at the end"
        lines = text.split("\n")
    if path.suffix in BUILD_FILES or path.name == "CMakeLists.txt":
        for number, line in enumerate(lines, 1):
            if FAST_MATH.search(line.split("#")[0]):
                yield number, "an option that breaks NaN tests"
    if path.suffix != ".json":
        yield from check_lines(name, lines)
    if path.suffix in FORTRAN:
        yield from check_fortran(name, lines)
        yield from check_indentation(name, text, lines)
        if name.startswith("src/"):
            yield from check_rooms(name, lines)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--root", type=Path, default=ROOT, help="folder of the project (default: this one)")
    root = parser.parse_args().root.resolve()
    # What fprettify has to say about a file, it says through the lines it writes.
    logging.disable(logging.CRITICAL)

    files = total = 0
    for path, name in find_files(root):
        files += 1
        findings = sorted(check_file(path, name))
        total += len(findings)
        for number, finding in findings[:MAX_SHOWN]:
            print(f"{name}:{number}: {finding}")
        if len(findings) > MAX_SHOWN:
            print(f"{name}: and {len(findings) - MAX_SHOWN} more")
    print(f"lint: {files} files, {total} findings")
    return 1 if total or not files else 0


if __name__ == "__main__":
    sys.exit(main())

"""Models that are larger than the machine: a sentence and exit status 1, before or while memory is taken."""

import re
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import deck, is_sanitized

pytestmark = pytest.mark.skipif(is_sanitized(), reason="the sanitizers take all addresses for themselves")

ONE_STEP = "TRANSIENT newmark step=1e-7 end=1e-7 name=swing"


def sized(elements, commands=ONE_STEP, nodes=3):
    """The deck of conftest with so many elements of length 0.1."""
    text = deck(commands)
    text = text.replace("elements=4", f"elements={elements} nodes={nodes}")
    return text.replace("to=10", f"to={0.1 * elements}").replace("x=10", f"x={0.1 * elements}")


def limited(megabytes):
    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (megabytes * 1000000,) * 2)

    return limit


def test_a_thousand_million_elements(program):
    status, said = program.run(deck().replace("elements=4", "elements=1e9"))
    assert status == 1
    assert "error: 'elements' must be from 1 to 10000000, and is 1000000000" in said
    assert not program.results.exists()


@pytest.mark.parametrize("megabytes", [60, 150, 400])
def test_mesh_larger_than_the_limit(program, megabytes):
    """Told at the deck's line, by --check too."""
    for arguments in ((), ("--check",)):
        status, said = program.run(sized(9999999), *arguments, preexec_fn=limited(megabytes))
        assert status == 1
        found = re.search(
            r"^deck\.inp:5:1: error: the mesh of 19999999 nodes is too large for this machine: "
            r"it needs about 1\.2 GB of memory, and (\d+) MB are available\n",
            said,
        )
        assert found and int(found[1]) < megabytes
    assert not program.results.exists() and not program.part.exists()


def test_mesh_within_the_limit(program):
    """--check needs no more than the mesh, and the mesh no more than is said."""
    status, said = program.run(sized(9999999), "--check", preexec_fn=limited(1300))
    assert (status, said) == (0, "")


@pytest.mark.parametrize("elements, gigabytes", [(1000000, "3.6 GB"), (400000, "1.5 GB"), (200000, "736 MB")])
def test_equations_larger_than_the_limit(program, elements, gigabytes):
    status, said = program.run(sized(elements), preexec_fn=limited(500))
    assert status == 1
    assert said.startswith(
        f"gentbeam: error: the model of {2 * elements + 1} nodes is too large for this machine: it needs "
        f"about {gigabytes} of memory, and "
    )
    assert not program.results.exists() and not program.part.exists()


# A process begins with the peak of the one that starts it: a small one.
MEASURE = """
import os, sys
process = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ)
_, status, usage = os.wait4(process, 0)
print(os.waitstatus_to_exitcode(status), 1024 * usage.ru_maxrss, usage.ru_minflt)
"""


def measured(program, *arguments):
    """Exit status, largest resident memory in bytes, and how often the system was asked for a page."""
    command = [sys.executable, "-S", "-c", MEASURE, program.executable, *arguments]
    done = subprocess.run(command, cwd=program.folder, capture_output=True, text=True, check=True)
    return tuple(map(int, done.stdout.split()[-3:]))


def peak(program, text):
    """Largest resident memory of a run in bytes."""
    (program.folder / "deck.inp").write_text(text)
    status, size, _ = measured(program, "-q", "-o", "out", "deck.inp")
    # On so slender a beam a method may fail to converge, with all its memory taken.
    assert status in (0, 2)
    return size


LARGE_PAGES = Path("/sys/kernel/mm/transparent_hugepage/enabled")


@pytest.mark.skipif(
    not LARGE_PAGES.exists() or "[never]" in LARGE_PAGES.read_text(), reason="no large pages here"
)
def test_a_small_run_asks_for_few_pages(program):
    """What a run takes beyond starting the program lies in a large page or two, not in hundreds of small."""
    (program.folder / "deck.inp").write_text(deck("TRANSIENT newmark step=1e-4 end=1e-2 name=swing"))
    # The system has no large page to give now and then.
    extra = []
    for _ in range(5):
        status, _, faults = measured(program, "-q", "-o", "out", "deck.inp")
        assert status == 0
        extra.append(faults - measured(program, "--version")[2])
    print(extra)
    assert min(extra) < 300


def needed(program, text):
    """What the program says that it needs, in bytes."""
    _, said = program.run(text, preexec_fn=limited(60))
    found = re.search(r"about (\S+) (GB|MB) of memory", said)
    assert found, said
    return float(found[1]) * {"GB": 1e9, "MB": 1e6}[found[2]]


@pytest.mark.parametrize("nodes", [2, 3, 5])
@pytest.mark.parametrize(
    "command",
    [
        "STATIC steps=1 load=1e-9",
        ONE_STEP,
        "TRANSIENT central step=1e-9 end=1e-9",
        "TRANSIENT energy step=1e-7 end=1e-7",
        "MODAL count=3",
    ],
)
def test_what_is_needed_is_what_is_taken(program, command, nodes):
    """The estimate is no smaller than the memory taken, and not much larger."""
    text = sized(40000 // (nodes - 1), command, nodes)
    ratio = needed(program, text) / peak(program, text)
    print(command, nodes, ratio)
    assert 1.0 <= ratio <= 2.0


@pytest.mark.parametrize("inertia", ["diagonal", "full"])
@pytest.mark.parametrize("damping", ["", "DAMPING mass=20\n"])
def test_matrices_beside_the_block_solver_are_counted(program, inertia, damping):
    text = sized(20000).replace("h=1\n", f"h=1  inertia={inertia}\n")
    text = text.replace("OUTPUT", damping + "OUTPUT").replace("fields=[u v a]", "fields=none")
    ratio = needed(program, text) / peak(program, text)
    print(inertia, damping, ratio)
    assert 1.0 <= ratio <= 2.0


@pytest.mark.parametrize("nodes", [2, 5])
@pytest.mark.parametrize("fields", ["strain", "u strain stress"])
def test_strains_and_stresses_are_counted(program, fields, nodes):
    text = sized(40000 // (nodes - 1), "STATIC steps=1 load=1e-9", nodes)
    text = text.replace("fields=[u v a]", f"fields=[{fields}]")
    ratio = needed(program, text) / peak(program, text)
    print(fields, nodes, ratio)
    assert 1.0 <= ratio <= 2.0


def test_any_refusal_of_memory(program, meddler):
    """Each single request that the system may refuse ends in a sentence: no crash, no traceback."""
    text = deck("STATIC steps=2 load=0.4\nMODAL count=2\nTRANSIENT newmark step=1e-4 end=5e-4")
    count = program.folder / "count"
    # Once before: a run that finds an older file asks once less.
    assert program.run(text) == (0, "")
    assert program.run(text, env=meddler(count=count)) == (0, "")
    requests = int(count.read_text().split()[1])
    print(requests)
    assert requests > 100
    # The last of them are those that write the count.
    for number in range(1, requests - 4, 4):
        status, said = program.run(text, env=meddler(memory=number))
        assert status == 1, (number, said)
        assert said.startswith("gentbeam: error: out of memory: the system refuses another "), (number, said)
        assert said.count("\n") == 1

"""The library without files, from Python, C, C++ and Fortran; what cmake --install and cpack put where."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from sanitized import is_sanitized, not_sanitized

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("GENTBEAM", ROOT / "build" / "release" / "gentbeam")).resolve().parent
os.environ.setdefault("GENTBEAM_LIBRARY", str(BUILD / "libgentbeam.so"))
sys.path.insert(0, str(ROOT / "python"))

import gentbeam  # noqa: E402

DECK = """\
GENTBEAM Everything that is kept
UNITS length=in force=lbf time=s
PARAMETER jm=2 steps=3
MATERIAL m gent mu=5000 c=2500 jm=jm rho=1e-6
SECTION s rectangle b=1 h=1
LINE from=0 to=10 elements=5
CLAMP x=0
DISTRIBUTED from=0 to=10 q3=2.85
PROBE tip u3 x=10
PROBE speed v3 x=7.3
OUTPUT every=3 fields=[u v a strain stress]
END
STATIC steps=steps load=0.5
MODAL count=3
TRANSIENT bathe step=1e-4 end=1.3e-3
STOP
"""


def program(*arguments, deck, folder):
    return subprocess.run(
        [str(BUILD / "gentbeam"), "-q", *arguments], input=deck, cwd=folder, text=True, capture_output=True
    )


def test_arrays_are_those_of_the_results_file(tmp_path):
    """Bit for bit; nothing is missing but whole numbers of the mesh and what the file says in words."""
    assert program("--set", "jm=0.5", deck=DECK, folder=tmp_path).returncode == 0
    result = gentbeam.run(DECK, jm=0.5)
    assert result.commands == ("static", "modal", "transient")
    assert result.kinds == {"static": "static", "modal": "modal", "transient": "transient"}
    assert result.units == {"length": "in", "force": "lbf", "time": "s"}
    assert result.title == "Everything that is kept" and result.parameters["jm"] == "0.5"
    with h5py.File(tmp_path / "gentbeam.h5") as file:
        stored = {}
        file.visititems(lambda name, item: stored.update({name: item} if hasattr(item, "shape") else {}))
        only_there = {name for name in stored if name not in result and not name.startswith("VTKHDF")}
        assert only_there == {
            "deck",
            "mesh/elements",
            "mesh/fixed",
            "mesh/thickness",
            "mesh/stations/element",
        }
        assert len(result) == 3 + 2 * (22 + 2) + 2
        for name, array in result.items():
            assert array.shape == stored[name].shape, name
            assert array.tobytes() == stored[name][()].astype(float).tobytes(), name


def test_what_is_left_to_the_program(tmp_path, capfd):
    """`auto` chooses the same in the library, without a word; signals stay the caller's."""
    deck = DECK[: DECK.index("END")] + "END\nTRANSIENT auto accuracy=2e-2 probe=tip end=8e-3\n"
    assert program(deck=deck, folder=tmp_path).returncode == 0
    before = signal.getsignal(signal.SIGTERM)
    result = gentbeam.run(deck)
    with h5py.File(tmp_path / "gentbeam.h5") as file:
        assert result["mesh/x"].tobytes() == file["mesh/x"][()].tobytes()
        assert result.probe("tip")[1].tobytes() == file["transient/probes/tip"][()].tobytes()
    assert capfd.readouterr() == ("", "") and signal.getsignal(signal.SIGTERM) == before


def test_ways_to_the_usual_arrays():
    result = gentbeam.run(DECK)
    time, tip = result.probe("tip")
    assert time.tolist() == result["transient/probes/time"].tolist() and tip.shape == (14,)
    assert result.probe("tip", "static").values.tolist() == result["static/probes/tip"].tolist()
    assert result.probes() == ["tip", "speed"]
    assert result.field("u").values.shape == (6, 11, 5) and result.field("stress/S").time.shape == (6,)
    assert result.energy("balance").values[0] == 0.0
    assert result.frequency.shape == (3,) and result.modes.shape == (3, 11, 5)
    assert result.x.tolist() == result["mesh/x"].tolist()
    with pytest.raises(KeyError, match="no probes/top in this run .there are: .*probes/tip"):
        result.probe("top")
    with pytest.raises(KeyError, match="no command rest in this run .there are: static, "):
        result.probe("tip", command="rest")
    with pytest.raises(KeyError, match="no x/y in this run .there are: .*transient/probes/tip"):
        result["x/y"]


def test_a_deck_may_be_a_file_and_name_others(tmp_path):
    (tmp_path / "load.txt").write_text("0 0\n1 1\n")
    text = DECK.replace("q3=2.85", "q3=2.85 history=slow")
    (tmp_path / "deck.inp").write_text(text.replace("CLAMP", "HISTORY slow table file=load.txt\nCLAMP"))
    result = gentbeam.run(tmp_path / "deck.inp", steps=5)
    assert len(result.probe("tip", "static").values) == 6
    assert sorted(path.name for path in tmp_path.iterdir()) == ["deck.inp", "load.txt"]


def test_errors():
    with pytest.raises(gentbeam.DeckError) as caught:
        gentbeam.run(DECK.replace("elements=5", "elemnts=5"))
    assert "<text>:6:19: error: unknown key 'elemnts' in LINE" in str(caught.value)
    with pytest.raises(gentbeam.DeckError, match="the deck has no parameter 'jn'"):
        gentbeam.run(DECK, jn=2)
    with pytest.raises(gentbeam.FileError, match="nowhere.inp: No such file or directory"):
        gentbeam.run("nowhere.inp")
    with pytest.raises(TypeError):
        gentbeam.run(DECK, jm=[1, 2])
    with pytest.raises(gentbeam.SolutionError, match="STATIC: step . of 4 failed") as failed:
        hopeless = DECK.replace("load=0.5", "load=1e6 cuts=1 iterations=5")
        gentbeam.run(hopeless.replace("every=3", "every=1"), steps=4.0)
    assert 0 < len(failed.value.result.probe("tip", "static").values) < 5


@not_sanitized
def test_many_runs_leave_no_memory_behind():
    """A hundred results of some 100 kB each: what stays is far less than one run in ten would be."""
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT / 'python')!r}); import gentbeam, resource\n"
        f"deck = {DECK!r}\n"
        "def peak(): return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "def size(): return sum(array.nbytes for array in gentbeam.run(deck).values())\n"
        "for _ in range(20): size()\n"
        "before = peak()\n"
        "total = sum(size() for _ in range(100))\n"
        "print(total, 1024 * (peak() - before))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    total, grown = map(int, done.stdout.split())
    assert grown < total / 10, (total, grown)


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    """The project installed from its build folder."""
    if is_sanitized():
        pytest.skip("what others link with the library would need the sanitizer too")
    place = tmp_path_factory.mktemp("prefix")
    subprocess.run(
        ["cmake", "--install", str(BUILD), "--prefix", str(place)], check=True, capture_output=True
    )
    return place


def test_installed_files(prefix):
    """And that the version is the one of CMakeLists.txt everywhere."""
    version = re.search(r"project\(gentbeam VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
    found = {str(path.relative_to(prefix)) for path in prefix.rglob("*") if path.is_file()}
    for wanted in (
        r"bin/gentbeam",
        rf"lib\S*/libgentbeam\.so\.{re.escape(version)}",
        r"lib\S*/libgentbeam_core\.a",
        r"include/gentbeam\.h",
        r"include/gentbeam/gb_system\.mod",
        r"share/man/man1/gentbeam\.1",
        r"share/bash-completion/completions/gentbeam",
        r"share/gentbeam/input/cantilever\.inp",
        r"lib/python3/dist-packages/gentbeam/__init__\.py",
        r"share/doc/gentbeam/deck\.md",
    ):
        assert any(re.fullmatch(wanted, name) for name in found), wanted
    said = subprocess.run([prefix / "bin/gentbeam", "--version"], capture_output=True, text=True, check=True)
    assert said.stdout.split()[1] == gentbeam.version == version
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"## [{version}]" in (ROOT / "CHANGELOG.md").read_text()
    assert f'"gentbeam {version}"' in (prefix / "share/man/man1/gentbeam.1").read_text()


def test_installed_python_package(prefix):
    """It finds the library beside it."""
    code = (
        "import gentbeam; print(gentbeam.__file__); print(gentbeam.run(open('deck.inp').read()).frequency[0])"
    )
    environment = {name: value for name, value in os.environ.items() if name != "GENTBEAM_LIBRARY"}
    environment["PYTHONPATH"] = str(prefix / "lib/python3/dist-packages")
    (prefix / "deck.inp").write_text(DECK)
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=prefix, env=environment, capture_output=True, text=True, check=True
    )
    where, frequency = done.stdout.split()
    assert where.startswith(str(prefix)) and float(frequency) == gentbeam.run(DECK).frequency[0]


C_SOURCE = """\
#include <gentbeam.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    const char *set[] = {"jm=0.5", "steps=2"};
    gentbeam_result *result = gentbeam_run_file(argv[argc - 1], 2, set);
    size_t shape[GENTBEAM_MAX_RANK];
    int rank, i;

    if (gentbeam_status(result) != GENTBEAM_OK) {
        fputs(gentbeam_message(result), stdout);
        gentbeam_free(result);
        return 1;
    }
    for (i = 0; i < gentbeam_count(result); i++) {
        const double *values = gentbeam_array(result, gentbeam_name(result, i), &rank, shape);
        size_t size = 1;
        for (int k = 0; k < rank; k++)
            size *= shape[k];
        printf("%s %d %zu %.17g\\n", gentbeam_name(result, i), rank, size, values ? values[size - 1] : 0.0);
    }
    printf("%s|%s|%s\\n", gentbeam_text(result, "commands"), gentbeam_text(result, "units/length"),
           gentbeam_text(result, "nonsense") ? "there" : "not there");
    if (gentbeam_array(result, "nonsense", &rank, shape) || rank || gentbeam_name(result, -1))
        abort();
    gentbeam_free(result);
    gentbeam_free(NULL);
    return 0;
}
"""
FORTRAN_SOURCE = """\
program beam
    use gb_kinds, only: wp
    use gb_section, only: material_t
    implicit none
    type(material_t) :: material
    material%mu = 5000.0_wp
    material%c = 2500.0_wp
    print '(f12.4)', material%fibre_modulus()
end program beam
"""
PROJECT = """\
cmake_minimum_required(VERSION 3.20)
project(user LANGUAGES {languages})
find_package(gentbeam 0.1 REQUIRED {components})
add_executable(user {source})
target_link_libraries(user PRIVATE {library})
"""


def build_user(prefix, folder, source, languages, library="gentbeam::gentbeam", components=""):
    text = PROJECT.format(languages=languages, source=source, library=library, components=components)
    (folder / "CMakeLists.txt").write_text(text)
    configure = ["cmake", "-S", str(folder), "-B", str(folder / "build"), f"-DCMAKE_PREFIX_PATH={prefix}"]
    for command in (configure, ["cmake", "--build", str(folder / "build")]):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    return folder / "build" / "user"


@pytest.mark.parametrize("language, name", [("C", "user.c"), ("CXX", "user.cpp")])
def test_c_and_cxx(prefix, tmp_path, language, name):
    """find_package, the header, and every array: the same last number as in Python."""
    if language == "CXX" and not shutil.which("g++"):
        pytest.skip("no C++ compiler")
    (tmp_path / name).write_text(C_SOURCE)
    (tmp_path / "deck.inp").write_text(DECK)
    user = build_user(prefix, tmp_path, name, language)
    done = subprocess.run([user, tmp_path / "deck.inp"], capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert lines[-1] == "static modal transient|in|not there"
    result = gentbeam.run(DECK, jm=0.5, steps=2)
    assert [line.split()[0] for line in lines[:-1]] == list(result)
    for line in lines[:-1]:
        array, rank, size, last = line.split()
        found = result[array]
        assert (found.ndim, found.size) == (int(rank), int(size)), array
        assert float(last) == (found.ravel()[-1] if found.size else 0.0), array
    (tmp_path / "wrong.inp").write_text(DECK.replace("CLAMP", "CLMP"))
    done = subprocess.run([user, tmp_path / "wrong.inp"], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "unknown command 'CLMP'" in done.stdout


def test_valgrind_finds_nothing(prefix, tmp_path):
    """Every byte is freed, and none is read that was not written: a good deck, a wrong one, a missing one. A
    program built for the newest processors cannot run there."""
    if not shutil.which("valgrind"):
        pytest.skip("no valgrind")
    (tmp_path / "user.c").write_text(C_SOURCE)
    (tmp_path / "good.inp").write_text(DECK)
    (tmp_path / "wrong.inp").write_text(DECK.replace("CLAMP", "CLMP"))
    user = build_user(prefix, tmp_path, "user.c", "C")
    for deck, status in (("good.inp", 0), ("wrong.inp", 1), ("missing.inp", 1)):
        done = subprocess.run(
            [
                "valgrind",
                "-q",
                "--error-exitcode=9",
                "--leak-check=full",
                "--show-leak-kinds=definite",
                user,
                deck,
            ],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode == -signal.SIGILL:
            pytest.skip("valgrind does not know this processor's instructions")
        assert done.returncode == status, done.stderr


def test_fortran_modules(prefix, tmp_path):
    (tmp_path / "user.f90").write_text(FORTRAN_SOURCE)
    user = build_user(
        prefix, tmp_path, "user.f90", "C Fortran", "gentbeam::gentbeam_core", "COMPONENTS Fortran"
    )
    done = subprocess.run([user], capture_output=True, text=True, check=True)
    assert float(done.stdout) == pytest.approx(12000.0)


@not_sanitized
def test_library_shows_nothing_but_its_functions():
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", str(BUILD / "libgentbeam.so")],
        capture_output=True,
        text=True,
        check=True,
    )
    names = {line.split()[-1].split("@")[0] for line in listed.stdout.splitlines()}
    header = (ROOT / "include" / "gentbeam.h").read_text()
    declared = set(re.findall(r"\b(gentbeam_\w+)\(", re.sub(r"/\*.*?\*/", "", header, flags=re.S)))
    assert names == declared and len(names) == 10


@not_sanitized
def test_debian_package(tmp_path):
    """cpack makes it; apt would install it here, and what is in it runs."""
    for tool in ("cpack", "dpkg-deb", "dpkg-shlibdeps", "apt-get"):
        if not shutil.which(tool):
            pytest.skip(f"no {tool}: not a Debian machine, or scripts/test has not set it up")
    command = ["cpack", "--config", str(BUILD / "CPackConfig.cmake"), "-B", str(tmp_path)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (package,) = tmp_path.glob("gentbeam_*.deb")
    fields = subprocess.run(["dpkg-deb", "-f", package], capture_output=True, text=True, check=True).stdout
    values = dict(re.findall(r"^([A-Z][\w-]*): (.*)$", fields, re.M))
    assert values["Package"] == "gentbeam" and values["Version"].startswith(gentbeam.version)
    needed = subprocess.run(["ldd", BUILD / "gentbeam"], capture_output=True, text=True, check=True).stdout
    for library in ("libc6", "libgfortran", "libhdf5"):
        if library == "libc6" or library in needed:
            assert library in values["Depends"], values
    planned = subprocess.run(
        ["apt-get", "install", "--simulate", "--no-install-recommends", package],
        capture_output=True,
        text=True,
        check=False,
    )
    assert planned.returncode == 0, planned.stdout + planned.stderr
    assert re.search(r"^Inst gentbeam ", planned.stdout, re.M)
    root = tmp_path / "root"
    subprocess.run(["dpkg-deb", "-x", package, root], check=True)
    (tmp_path / "deck.inp").write_text(DECK)
    done = subprocess.run(
        [root / "usr/bin/gentbeam", "deck.inp"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert "done in" in done.stdout and (tmp_path / "deck.h5").exists()
    environment = {**os.environ, "PYTHONPATH": str(root / "usr/lib/python3/dist-packages")}
    del environment["GENTBEAM_LIBRARY"]
    code = "import gentbeam; print(gentbeam.library._name, gentbeam.run('deck.inp').probe('tip').values[-1])"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    library, tip = done.stdout.split()
    assert library.startswith(str(root)) and float(tip) == gentbeam.run(DECK).probe("tip").values[-1]
    assert np.isfinite(float(tip))

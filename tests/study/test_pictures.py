"""The scripts of studies: what they draw and print, and what they say to a file that does not suit."""

import csv
import subprocess
import sys

import matplotlib.image
import numpy as np
import pytest
from conftest import ROOT
from studies import SHORT, study

SCRIPTS = ROOT / "scripts"
GRID = "SWEEP E=[11000 11500 12000 12500]\nSWEEP jm=[1 2 4 8 16]"


@pytest.fixture
def script(gentbeam):
    """Runs a script in the folder of the program; its standard output and error are kept."""

    def run(name, *arguments, status=0):
        done = subprocess.run(
            [sys.executable, SCRIPTS / name, *map(str, arguments)],
            cwd=gentbeam.folder,
            capture_output=True,
            text=True,
        )
        assert done.returncode == status, done.stderr
        run.out, run.err = done.stdout, done.stderr
        return run

    return run


def table(path):
    rows = list(csv.reader(open(path)))
    return rows[0], np.array(rows[1:], dtype=float)


def is_picture(path):
    image = matplotlib.image.imread(path)
    return image.shape[0] > 200 and image[..., :3].std() > 0.02


def test_a_map_of_two_crossed_parameters(gentbeam, script):
    gentbeam("-q", deck=study(GRID, output="OUTPUT fields=none"))
    script("plot_sweep.py", "gentbeam.h5", "-o", "map.png", "--csv", "map.csv")
    assert is_picture(gentbeam.folder / "map.png")
    header, rows = table(gentbeam.folder / "map.csv")
    with gentbeam.results() as file:
        assert header == ["E", "jm", "tip_max"]
        assert (rows[:, :2] == file["sweep/parameters"][:]).all() and (
            rows[:, 2] == file["sweep/summary/tip_max"][:]
        ).all()


def test_a_response_in_curves(gentbeam, script):
    gentbeam("-q", deck=study(GRID, output="OUTPUT fields=none"))
    script(
        "plot_sweep.py",
        "gentbeam.h5",
        "--kind",
        "response",
        "--against",
        "JM",
        "--response",
        "tip_min",
        "-o",
        "curves.png",
        "--csv",
        "curves.csv",
    )
    assert is_picture(gentbeam.folder / "curves.png")
    header, rows = table(gentbeam.folder / "curves.csv")
    assert header == ["jm", "tip_min"] and rows[:, 0].tolist() == [1, 2, 4, 8, 16] * 4


def test_frequencies_are_responses(gentbeam, script):
    solution = f"{SHORT}\nMODAL count=3\nMODAL count=1 name=again"
    gentbeam("-q", deck=study(GRID, output="OUTPUT fields=none", solution=solution))
    with gentbeam.results() as file:
        stored = file["sweep/summary/modal_frequency"][:]
    for asked, mode in (("modal_frequency", 1), ("Modal_Frequency:2", 2), ("modal_frequency:3", 3)):
        script("plot_sweep.py", "gentbeam.h5", "--response", asked, "-o", "map.png", "--csv", "map.csv")
        header, rows = table(gentbeam.folder / "map.csv")
        assert header[2] == f"modal_frequency:{mode}" and (rows[:, 2] == stored[:, mode - 1]).all()
    script("plot_sweep.py", "gentbeam.h5", "-o", "map.png", "--csv", "map.csv")
    assert table(gentbeam.folder / "map.csv")[0][2] == "tip_max"
    for asked in ("modal_frequency:4", "modal_frequency:0", "modal_frequency:x"):
        script("plot_sweep.py", "gentbeam.h5", "--response", asked, "-o", "x.png", status=1)
        assert "tip_u1_time_of_max, modal_frequency:1 to :3, again_frequency)" in script.err


def test_a_study_of_frequencies_alone(gentbeam, script):
    deck = study(GRID, output="OUTPUT fields=none", solution="MODAL count=2").replace("PROBE", "! PROBE")
    gentbeam("-q", deck=deck)
    script("plot_sweep.py", "gentbeam.h5", "-o", "map.png", "--csv", "map.csv")
    assert is_picture(gentbeam.folder / "map.png")
    assert table(gentbeam.folder / "map.csv")[0] == ["E", "jm", "modal_frequency:1"]


def test_points_and_members_that_failed(gentbeam, script):
    gentbeam(
        "-q",
        deck=study(
            "SWEEP E=[%s -1]\nSWEEP nu=[0.2 0.3]" % " ".join(str(11000 + 7 * i) for i in range(20)),
            output="OUTPUT fields=none",
        ),
    )
    script(
        "plot_sweep.py",
        "gentbeam.h5",
        "--kind",
        "response",
        "--against",
        "nu",
        "-o",
        "p.pdf",
        "--csv",
        "p.csv",
    )
    assert "2 of 42 members are not complete and left out" in script.err
    assert table(gentbeam.folder / "p.csv")[1].shape == (40, 2)


def test_a_family(gentbeam, script):
    gentbeam("-q", deck=study(GRID))
    script(
        "plot_sweep.py",
        "gentbeam.h5",
        "--kind",
        "family",
        "--against",
        "jm",
        "--probe",
        "tip_u1",
        "--most",
        7,
        "-o",
        "family.png",
        "--csv",
        "family.csv",
    )
    assert is_picture(gentbeam.folder / "family.png")
    header, rows = table(gentbeam.folder / "family.csv")
    assert header == ["member", "jm", "time", "tip_u1"]
    numbers = np.unique(rows[:, 0]).astype(int)
    assert len(numbers) == 7 and numbers[0] == 1 and numbers[-1] == 20
    with gentbeam.results() as file:
        last = file["sweep/members/000020/transient/probes/tip_u1"][:]
    assert (rows[rows[:, 0] == 20, 3] == last).all()


def test_what_does_not_suit(gentbeam, script):
    gentbeam("-q", "-o", "single", deck=study(""))
    gentbeam("-q", "-o", "none", deck=study(GRID, output="OUTPUT fields=none"))
    for arguments, words in (
        (("single.h5",), "single.h5: not the results of a SWEEP"),
        (
            ("none.h5", "--kind", "family"),
            "none.h5: keeps no histories of its members (OUTPUT fields=none)",
        ),
        (("none.h5", "--against", "mu"), "no parameter 'mu' varies (there are: E, jm)"),
        (("none.h5", "--response", "top_max"), "no summary 'top_max' (there are: tip_max,"),
        (("absent.h5",), "absent.h5: no such file"),
    ):
        script("plot_sweep.py", *arguments, "-o", "x.png", status=1)
        assert (
            script.err.startswith("plot_sweep.py: error: ")
            and words in script.err
            and script.err.count("\n") == 1
        )
    assert not (gentbeam.folder / "x.png").exists()


@pytest.mark.parametrize("name", ["report.py", "plot_tip.py", "plot_shapes.py", "animate.py"])
def test_scripts_for_single_runs_name_the_one_for_studies(gentbeam, script, name):
    gentbeam("-q", deck=study(GRID))
    script(name, "gentbeam.h5", status=1)
    words = "gentbeam.h5: is a study of many members; scripts/plot_sweep.py draws it"
    assert script.err == f"{name}: error: {words}\n"


def test_the_worked_example_finds_its_parameters(gentbeam, script):
    gentbeam("-q", "--threads", 2, ROOT / "input" / "fit.inp")
    script("fit_sweep.py", "fit.h5", "--data", ROOT / "input" / "fit_tip.csv", "-o", "fit.png")
    assert is_picture(gentbeam.folder / "fit.png") and not script.err
    line = next(line for line in script.out.splitlines() if line.startswith("fit: "))
    found = {}
    for part in line[len("fit: ") :].split(", "):
        name, value = part.split(" = ")
        found[name] = tuple(map(float, value.split(" +- ")))
    # What the history was made with lies within two standard deviations, and those are small.
    for name, truth in (("mu", 5230.0), ("jm", 3.2)):
        assert abs(found[name][0] - truth) < 2 * found[name][1] < 0.5 * truth
    rms = float(script.out.split("rms distance of the fit ")[1].split(";")[0])
    assert rms == pytest.approx(0.01, rel=0.2)


def test_a_fit_without_noise_is_exact(gentbeam, script):
    gentbeam("-q", "-o", "truth", "--set", "E=11800", "--set", "jm=3", deck=study(""))
    gentbeam("-q", deck=study("SWEEP E=[11400 11600 11800 12000 12200]\nSWEEP jm=[2 2.5 3 3.5 4]"))
    with gentbeam.results("truth") as file:
        history = np.column_stack([file["transient/probes/time"][:], file["transient/probes/tip"][:]])
    np.savetxt(gentbeam.folder / "data.txt", history)
    script("fit_sweep.py", "gentbeam.h5", "--data", "data.txt", "-o", "fit.png")
    values = [
        float(part.split(" +- ")[0])
        for part in script.out.split("fit: ")[1].split("\n")[0].split(" = ")[1:]
    ]
    assert values == pytest.approx([11800, 3], rel=2e-3)


def test_samples(gentbeam, script):
    laws = ("E=normal:12000:600", "h=uniform:0.9:1.1", "q=lognormal:2.85:0.1")
    script("sample_parameters.py", "-n", 2000, "--seed", 3, *laws, "-o", "a.csv")
    script("sample_parameters.py", "-n", 2000, "--seed", 3, *laws, "-o", "b.csv")
    assert (gentbeam.folder / "a.csv").read_bytes() == (gentbeam.folder / "b.csv").read_bytes()
    header, rows = table(gentbeam.folder / "a.csv")
    assert header == ["E", "h", "q"] and rows.shape == (2000, 3)
    assert rows[:, 0].mean() == pytest.approx(12000, rel=1e-4) and rows[:, 0].std() == pytest.approx(
        600, rel=0.01
    )
    assert 0.9 <= rows[:, 1].min() < 0.901 and 1.099 < rows[:, 1].max() <= 1.1
    assert np.log(rows[:, 2]).std() == pytest.approx(0.1, rel=0.01) and np.median(
        rows[:, 2]
    ) == pytest.approx(2.85, rel=1e-3)
    assert np.abs(np.corrcoef(rows.T) - np.eye(3)).max() < 0.08
    for law in ("E", "E=normal:1", "E=normal:1:0", "E=uniform:2:1", "E=flat:1:2"):
        script("sample_parameters.py", law, status=1)
        assert script.err.startswith("sample_parameters.py: error: ") and script.err.count("\n") == 1


def test_the_monte_carlo_table_is_what_its_deck_says(gentbeam, script):
    text = (ROOT / "input" / "monte_carlo.inp").read_text()
    command = next(line for line in text.splitlines() if "sample_parameters.py" in line).split(
        "sample_parameters.py"
    )[1]
    script("sample_parameters.py", *command.split(), "-o", "again.csv")
    shipped = table(ROOT / "input" / "monte_carlo.csv")
    again = table(gentbeam.folder / "again.csv")
    assert shipped[0] == again[0] and shipped[1].shape == again[1].shape == (10000, 3)
    assert again[1] == pytest.approx(shipped[1], rel=2e-6)

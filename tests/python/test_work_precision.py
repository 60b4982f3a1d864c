"""The work-precision chart: errors and fronts in closed form, decks as they are changed, and a tiny chart."""

import csv
import os
import sys
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

import gentbeam_results
import peer_beam
import peer_calculix
import work_precision
import work_precision_picture
from work_precision_grid import front
from work_precision_runs import RunFailed, child
from work_precision_scene import History, Scene, Setting, distance, extrapolated

ROOT = Path(__file__).resolve().parents[2]
CANTILEVER = ROOT / "input" / "cantilever.inp"


def sampled(function, rows):
    time = np.linspace(0.0, 2.0, rows)
    return History(time, function(time))


def test_a_scaled_history_is_off_by_its_scale():
    exact = sampled(np.sin, 401)
    assert distance(sampled(lambda t: 1.01 * np.sin(t), 23), exact) == pytest.approx(0.01, rel=1e-6)


def test_a_cubic_between_the_rows_is_exact():
    def cubic(t):
        return 1.0 + t - 2.0 * t**2 + 0.7 * t**3

    assert distance(sampled(cubic, 17), sampled(cubic, 11)) < 1e-14


def test_the_limit_of_two_runs_has_no_error_of_second_order():
    rows = (11, 21)
    coarse, fine = (sampled(lambda t, h=2.0 / (n - 1): np.cos(t) + 3.0 * h**2 * t, n) for n in rows)
    assert distance(extrapolated(coarse, fine), sampled(np.cos, 401)) < 1e-7
    assert distance(fine, sampled(np.cos, 401)) > 1e-2


def test_the_front_is_what_no_other_point_beats():
    points = [(1e-1, 1.0), (1e-2, 3.0), (2e-2, 2.0), (3e-2, 2.5), (1e-2, 4.0), (5e-1, 1.0)]
    assert [points[i] for i in front(points)] == [(1e-1, 1.0), (2e-2, 2.0), (1e-2, 3.0)]


def test_a_deck_takes_on_a_setting(tmp_path):
    path = tmp_path / "beam.inp"
    path.write_text(
        "GENTBEAM a beam ! of two parts\nSECT s rectangle b=1 h=1 rule=gauss points=5\n"
        "LINE from=0 to=1 & ! goes on\n elements=4 nodes=2\nLINE from=1 to=2 elements=2\nCLAMP x=0\n"
        "PROBE tip u3 x=2\nOUTPUT file=beam every=5 fields=[u v]\nEND\n"
        "TRAN bathe rho=0.5 step=1e-3 end=2*0.5\nSTOP\nrubbish\n"
    )
    scene = Scene.read(path)
    assert (scene.elements, scene.rule(), scene.probe, scene.title) == (6, "gauss 5", "tip", "a beam")
    lines = scene.deck(Setting("newmark", "linear", 3, 12, 50)).splitlines()
    line = next(line for line in lines if line.startswith("LINE")).split()
    assert set(line) == {"LINE", "from=0", "to=1", "elements=8", "nodes=3"}
    assert "elements=4 nodes=3" in lines[3]
    assert lines[1].split() == "SECT s rectangle b=1 h=1 rule=linear".split()
    assert "TRANSIENT newmark step=(2*0.5)/50 end=2*0.5" in lines
    assert "OUTPUT fields=none" in lines and lines[-1] == "STOP"
    first = scene.deck(Setting("hht", "gauss 2", 3, 12, 50), first_step_only=True)
    assert "TRANSIENT hht step=(2*0.5)/50 end=(2*0.5)/50" in first


def test_a_deck_without_motion_is_refused(tmp_path):
    path = tmp_path / "static.inp"
    path.write_text("GENTBEAM rest\nLINE from=0 to=1 elements=4\nEND\nSTATIC\nSTOP\n")
    with pytest.raises(gentbeam_results.ResultsError, match="needs a deck with LINE and TRANSIENT"):
        Scene.read(path)


def test_a_child_that_fails_or_never_ends_says_so(tmp_path):
    complain = "import sys; print('talk'); sys.exit('no convergence in step 3')"
    with pytest.raises(RunFailed, match="no convergence in step 3"):
        child([sys.executable, "-c", complain], tmp_path, 5)
    with pytest.raises(RunFailed, match="stopped after 1 s"):
        child([sys.executable, "-c", "while True: pass"], tmp_path, 1)


@pytest.mark.parametrize("elements", [1, 4, 10])
def test_the_other_programs_carry_the_whole_load(elements):
    size = peer_beam.LENGTH / elements
    held = 0.5 * peer_beam.LOAD * size
    assert sum(peer_beam.nodal_forces(elements)) + held == pytest.approx(peer_beam.LOAD * peer_beam.LENGTH)
    lines = peer_calculix.deck("B32R", elements, 100, 1).splitlines()
    loads = [float(line.split(",")[2]) for line in lines[lines.index("*CLOAD") + 1 : -3]]
    assert sum(loads) + held / 3.0 == pytest.approx(peer_beam.LOAD * peer_beam.LENGTH)


@pytest.fixture(scope="module")
def chart(tmp_path_factory):
    """The chart of a deck that `newmark` gets through and explicit steps do not; no other programs."""
    if "GENTBEAM" not in os.environ:
        pytest.skip("needs the program")
    folder = tmp_path_factory.mktemp("chart")
    thin = CANTILEVER.read_text().replace(" h=1 ", " h=0.02 ").replace("q3=2.85", "q3=4e-6")
    (folder / "thin.inp").write_text(thin.replace("end=1.35e-2", "end=0.675"))
    patch = pytest.MonkeyPatch()
    captured = []
    draw = work_precision.draw
    patch.setattr(work_precision, "draw", lambda chart, path: (captured.append(chart), draw(chart, path)))
    patch.setattr(sys, "argv", ["work_precision.py", "--quick", "-o", str(folder), str(folder / "thin.inp")])
    work_precision.main()
    patch.undo()
    with open(folder / "pictures" / "work_precision_thin.csv", newline="") as file:
        assert file.readline().startswith("# thin, probe tip; ")
        rows = list(csv.DictReader(file))
    return folder, captured[0], rows


def test_every_run_has_a_row_and_failed_ones_say_why(chart):
    _, made, rows = chart
    assert len(rows) == 12
    assert {row["series"] for row in rows} == {"newmark", "central", "2 nodes"}
    failed = [row for row in rows if row["failure"]]
    assert {row["series"] for row in failed} == {"central"} and len(failed) == 4
    assert all("error" in row["failure"] and not row["process_seconds"] for row in failed)
    assert len(made.failed) == 4


def test_errors_fall_with_the_step_and_times_are_there(chart):
    _, _, rows = chart
    own = [row for row in rows if row["series"] == "newmark" and row["elements"] == "10"]
    errors = {int(row["steps"]): float(row["error"]) for row in own}
    assert errors[200] < 0.5 * errors[50]
    assert all(float(row["process_seconds"]) > 0.0 for row in own)


def test_the_front_of_the_table_is_that_of_its_numbers(chart):
    _, _, rows = chart
    able = [row for row in rows if row["error"] and row["process_seconds"]]
    marked = [row for row in able if row["front_process"] == "1"]
    assert marked
    for row in able:
        beaten = any(
            float(other["error"]) <= float(row["error"])
            and float(other["process_seconds"]) < float(row["process_seconds"])
            for other in able
        )
        assert not (beaten and row in marked)
        assert beaten or row in marked


def test_the_picture_lists_the_failures(chart):
    folder, made, _ = chart
    words = "\n".join(work_precision_picture.failures(made))
    assert "4 of 12" in words and "central (5 elements, 50 steps and 3 more)" in words
    picture = matplotlib.image.imread(folder / "pictures" / "work_precision_thin.png")
    assert picture.shape[1] > 2000 and picture.std() > 0.05

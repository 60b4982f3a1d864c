"""The plotting scripts: the numbers they draw, labels and pictures, and what they say to a wrong file."""

import csv
import subprocess
import sys

import h5py
import matplotlib.colors
import matplotlib.image
import numpy as np
import pytest
from conftest import LENGTH, SCRIPTS, bent_fields, dataset, swing
from matplotlib.text import Text

import gentbeam_results
import plot_shapes
import plot_tip

JM = ("1e20", "10", "5", "2", "1", "0.5")


class Script:
    """Runs a script's main as the command line does, and keeps what came out."""

    def __init__(self, module, monkeypatch, capsys, folder):
        self.module, self.monkeypatch, self.capsys, self.folder = module, monkeypatch, capsys, folder
        self.name = module.__name__ + ".py"
        self.figures = []
        draw = module.draw
        monkeypatch.setattr(module, "draw", lambda *args, **kwargs: self.keep(draw(*args, **kwargs)))

    def keep(self, figure):
        self.figures.append(figure)
        return figure

    def __call__(self, *arguments):
        self.monkeypatch.setattr(sys, "argv", [self.name, *map(str, arguments)])
        self.capsys.readouterr()
        try:
            gentbeam_results.run_script(self.module.main)
        except SystemExit as end:
            # A text as exit status is printed by the interpreter, which then ends with status 1.
            if isinstance(end.code, str):
                print(end.code, file=sys.stderr)
            self.status = 1 if isinstance(end.code, str) else end.code or 0
        else:
            self.status = 0
        self.out, self.err = self.capsys.readouterr()
        return self

    def draws(self, *arguments):
        """Runs it, expects success, and gives the figure."""
        self(*arguments, "-o", self.folder / "picture.png")
        assert self.status == 0, self.err
        return self.figures[-1]

    def numbers(self, *arguments):
        """Runs it, expects success, and gives the rows of the CSV file."""
        table = self.folder / "numbers.csv"
        self.draws(*arguments, "--csv", table)
        with open(table, newline="") as stream:
            return list(csv.DictReader(stream))

    def refuses(self, *arguments):
        """Runs it, expects failure, and gives the one line of the error."""
        self(*arguments)
        assert self.status == 1
        lines = self.err.splitlines()
        assert len(lines) == 1 and lines[0].startswith(f"{self.name}: error: "), self.err
        return lines[0].split("error: ", 1)[1]


@pytest.fixture
def tip(monkeypatch, capsys, tmp_path):
    return Script(plot_tip, monkeypatch, capsys, tmp_path)


@pytest.fixture
def shapes(monkeypatch, capsys, tmp_path):
    return Script(plot_shapes, monkeypatch, capsys, tmp_path)


@pytest.fixture(params=[plot_tip, plot_shapes], ids=["tip", "shapes"])
def either(request, monkeypatch, capsys, tmp_path):
    return Script(request.param, monkeypatch, capsys, tmp_path)


@pytest.fixture
def family(builder):
    """Six files that differ in jm, its amplitude falling with it."""
    return [
        builder.write(f"jm-{jm}.h5", parameters=f"L=10\njm={jm}", amplitude=3.0 - 0.1 * rank)
        for rank, jm in enumerate(JM)
    ]


def column(rows, name):
    return np.array([float(row[name]) for row in rows])


def labels_of(figure):
    return [words.get_text() for axis in figure.axes for words in axis.texts]


def curves(figure, panel=0):
    return [line for line in figure.axes[panel].lines if len(line.get_xdata()) > 2]


# ---- plot_tip: numbers


def test_numbers_are_those_of_the_file_to_the_last_digit(tip, builder):
    rows = tip.numbers(builder.write(rows=55))
    time = np.linspace(0.0, 1.35e-2, 55)
    assert np.array_equal(column(rows, "time"), time)
    assert np.array_equal(column(rows, "value"), swing(time))
    assert {(row["probe"], row["group"], row["time_unit"], row["unit"]) for row in rows} == {
        ("tip", "transient", "s", "in")
    }


def test_curve_drawn_is_the_one_in_the_csv_file(tip, builder):
    rows = tip.numbers(builder.write(), "--normalise", 2.5)
    (curve,) = curves(tip.figures[-1])
    assert np.array_equal(curve.get_xdata(), column(rows, "time"))
    assert np.array_equal(curve.get_ydata(), column(rows, "value"))


@pytest.mark.parametrize("normalise, divisor", [("4", 4.0), ("-0.5", -0.5), ("L", 10.0), ("l", 10.0)])
def test_normalised_numbers(tip, builder, normalise, divisor):
    rows = tip.numbers(builder.write(), f"--normalise={normalise}")
    assert np.array_equal(column(rows, "value"), swing(column(rows, "time")) / divisor)
    assert {row["unit"] for row in rows} == {""}


def test_every_file_is_normalised_by_its_own_parameter(tip, builder):
    files = [builder.write(f"{length}.h5", parameters=f"L={length}") for length in (5, 20)]
    rows = tip.numbers(*files, "--normalise", "L")
    for path, length in zip(files, (5, 20)):
        mine = [row for row in rows if row["file"] == str(path)]
        assert np.array_equal(column(mine, "value"), swing(column(mine, "time")) / length)


def test_csv_on_standard_output(builder):
    done = run_in_shell("plot_tip.py", builder.write(rows=3), "--csv", "-")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == "file,group,probe,label,time,value,time_unit,unit"
    assert len([line for line in done.stdout.splitlines() if ",transient,tip," in line]) == 3


# ---- plot_tip: what is chosen


def test_first_probe_of_the_deck_is_the_default(tip, builder):
    rows = tip.numbers(builder.write(probes=("tip", "slope")))
    assert {row["probe"] for row in rows} == {"tip"}
    rows = tip.numbers(builder.write(probes=("slope", "tip")))
    assert {row["probe"] for row in rows} == {"slope"}


def test_probe_name_in_any_case(tip, builder):
    assert {row["probe"] for row in tip.numbers(builder.write(), "--probe", "SLOPE")} == {"SLOPE"}


def test_quantities_of_different_kind_get_a_panel_each(tip, builder):
    figure = tip.draws(
        builder.write(probes=("tip", "middle", "slope")),
        "--probe",
        "tip",
        "--probe",
        "slope",
        "--probe",
        "middle",
    )
    assert [axis.get_ylabel() for axis in figure.axes] == ["$u_3$ (in)", "$y_1$ at slope"]
    assert [len(curves(figure, panel)) for panel in (0, 1)] == [2, 1]
    assert labels_of(figure) == ["tip", "middle"]


def test_default_solution_is_the_first_with_a_course(tip, builder):
    path = builder.write(group="swing")
    with h5py.File(path, "r+") as file:
        file["swing"].attrs["order"] = 3
        modal = file.create_group("modal")
        modal.attrs.update({"kind": "modal", "order": 1})
        file.copy("swing", "preload")
        file["preload"].attrs.update({"kind": "static", "order": 2})
    assert {row["group"] for row in tip.numbers(path)} == {"preload"}
    assert tip.figures[-1].axes[0].get_xlabel().startswith("Load factor")
    assert {row["group"] for row in tip.numbers(path, "--group", "SWING")} == {"swing"}
    assert tip.refuses(path, "--group", "modal").endswith("no probes in modal")


# ---- plot_tip: labels


def test_axes_carry_units(tip, builder):
    axis = tip.draws(builder.write()).axes[0]
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("Time (s)", "$u_3$ at tip (in)")
    axis = tip.draws(builder.write(units=("", "", ""))).axes[0]
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("Time", "$u_3$ at tip")


def test_static_solution_runs_over_the_load_factor(tip, builder):
    assert tip.draws(builder.write(kind="static")).axes[0].get_xlabel() == "Load factor"


def test_normalised_axis_says_by_what(tip, builder):
    path = builder.write()
    assert tip.draws(path, "--normalise", "L").axes[0].get_ylabel() == "$u_3/L$ at tip"
    assert tip.draws(path, "--normalise", "10").axes[0].get_ylabel() == "$u_3$ / (10 in) at tip"


@pytest.mark.parametrize(
    "description, quantity",
    [
        ("u3 at x = 10", "$u_3$ at tip"),
        ("xi at x = 10", r"$\xi$ at tip"),
        ("velocity of u3 at x = 10", r"$\dot{u}_3$ at tip"),
        ("acceleration of u1 at x = 10", r"$\ddot{u}_1$ at tip"),
        ("velocity of y1 at x = 10", "tip"),
        ("u30 at x = 10", "tip"),
        ("", "tip"),
    ],
)
def test_quantity_is_read_from_the_description(tip, builder, description, quantity):
    path = builder.write()
    with h5py.File(path, "r+") as file:
        file["transient/probes/tip"].attrs["description"] = description
    assert tip.draws(path).axes[0].get_ylabel() == f"{quantity} (in)"


def test_family_is_labelled_by_what_differs(tip, family):
    rows = tip.numbers(*family)
    assert list(dict.fromkeys(row["label"] for row in rows)) == [
        "jm = inf",
        "jm = 10",
        "jm = 5",
        "jm = 2",
        "jm = 1",
        "jm = 0.5",
    ]
    assert labels_of(tip.figures[-1]) == [
        r"$J_m = \infty$",
        "$J_m = 10$",
        "$J_m = 5$",
        "$J_m = 2$",
        "$J_m = 1$",
        "$J_m = 0.5$",
    ]


def test_several_parameters_that_differ(tip, builder):
    files = [
        builder.write("a.h5", parameters="E=12000\nstep=1e-6\nL=10"),
        builder.write("b.h5", parameters="E=11000\nstep=2e-4\nL=10"),
    ]
    assert labels_of(tip.draws(*files)) == [
        r"$E = 12000$, $\mathrm{step} = 1 \times 10^{-6}$",
        r"$E = 11000$, $\mathrm{step} = 0.0002$",
    ]


def test_one_deck_with_two_schemes_and_twice_the_same(tip, builder):
    newmark, bathe, again = (
        builder.write(f"{name}.h5", scheme=scheme)
        for name, scheme in (("n", "newmark"), ("b", "bathe"), ("again", "newmark"))
    )
    assert labels_of(tip.draws(newmark, bathe)) == ["newmark", "bathe"]
    assert labels_of(tip.draws(newmark, again)) == ["n", "again"]


def test_one_file_needs_no_legend(tip, builder):
    assert labels_of(tip.draws(builder.write())) == []


def test_own_labels(tip, family):
    assert labels_of(tip.draws(*family[:2], "--labels", "rubber", "a $ sign")) == ["rubber", "a $ sign"]
    assert "2 given for 3 lines" in tip.refuses(*family[:3], "--labels", "one", "two")


def test_dollar_in_a_unit_is_no_formula(tip, builder):
    assert tip.draws(builder.write(units=("$x^", "", "s"))).axes[0].get_ylabel() == r"$u_3$ at tip (\$x^)"


def test_title(either, builder):
    path = builder.write()
    assert either.draws(path).axes[0].get_title() == ""
    assert either.draws(path, "--title", "A beam").axes[0].get_title() == "A beam"


# ---- plot_tip: the picture


def test_lines_are_told_apart_without_colour(tip, family):
    lines = curves(tip.draws(*family))
    assert len({str(line._dash_pattern) for line in lines}) == len(JM)
    assert len({line.get_color() for line in lines}) == len(JM)


@pytest.mark.parametrize(
    "low, high, zero",
    [(-0.17, -0.095, False), (1.0, 4.1, False), (0.2, 1.0, True), (-1.0, -0.19, True), (-2.0, 3.0, True)],
)
def test_zero_is_in_view_where_it_is_near(tip, builder, low, high, zero):
    path = builder.write()
    with h5py.File(path, "r+") as file:
        values = file["transient/probes/tip"]
        values[...] = low + (high - low) * 0.5 * (1.0 + np.sin(np.linspace(0.0, 20.0, len(values))))
        values[0], values[-1] = low, high
    axis = tip.draws(path).axes[0]
    bottom, top = axis.get_ylim()
    assert (bottom <= 0.0 <= top) == zero
    assert (len(axis.lines) == 2) == zero
    assert zero or top - bottom < 1.2 * (high - low)


def test_a_constant_history_is_seen_from_zero(tip, builder):
    path = builder.write()
    with h5py.File(path, "r+") as file:
        file["transient/probes/tip"][...] = 5.0
    bottom, top = tip.draws(path).axes[0].get_ylim()
    assert bottom <= 0.0 and top >= 5.0


def test_labels_keep_clear_of_each_other_and_inside_the_picture(tip, builder):
    # All lines end at nearly the same value.
    files = [builder.write(f"{i}.h5", parameters=f"jm={i + 1}", amplitude=3.0 + 1e-3 * i) for i in range(8)]
    figure = tip.draws(*files)
    figure.canvas.draw()
    # The words alone, without their leaders.
    boxes = sorted((Text.get_window_extent(words) for words in figure.axes[0].texts), key=lambda box: box.y0)
    assert len(boxes) == 8
    assert all(low.y1 <= high.y0 for low, high in zip(boxes, boxes[1:]))
    assert all(figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1 for box in boxes)


def test_spread_keeps_order_distance_and_what_is_already_apart():
    assert np.array_equal(plot_tip.spread([30.0, 0.0, 100.0], 10.0), [30.0, 0.0, 100.0])
    assert np.allclose(plot_tip.spread([5.0, 5.0, 100.0], 10.0), [0.0, 10.0, 100.0])
    assert np.allclose(plot_tip.spread([3.0, 2.0, 1.0], 10.0), [12.0, 2.0, -8.0])


def test_picture_shows_every_line(tip, family, tmp_path):
    tip.draws(*family)
    picture = matplotlib.image.imread(tmp_path / "picture.png")[:, :, :3]
    assert np.mean(picture.min(axis=2) > 0.99) > 0.8, "mostly white"
    for colour in plot_tip.COLOURS[: len(JM)]:
        near = np.abs(picture - matplotlib.colors.to_rgb(colour)).max(axis=2) < 0.02
        assert near.sum() > 500, colour


@pytest.mark.parametrize("ending, magic", [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_formats(either, builder, tmp_path, ending, magic):
    path = builder.write()
    for name, options in ((f"a.{ending}", ()), ("b", ("--format", ending))):
        assert either(path, "-o", tmp_path / name, *options).status == 0
    pictures = [(tmp_path / name).read_bytes() for name in (f"a.{ending}", f"b.{ending}")]
    assert pictures[0].startswith(magic) and len(pictures[0]) > 4000
    assert pictures[0] == pictures[1], "the same numbers make the same file"
    assert either.out == f"wrote {tmp_path / 'b'}.{ending}\n"


def test_picture_lies_beside_the_results_unless_named(either, builder, tmp_path):
    suffix = {"plot_tip.py": "history", "plot_shapes.py": "shapes"}[either.name]
    assert either(builder.write("beam.h5")).status == 0
    assert (tmp_path / f"beam-{suffix}.png").exists()


def test_size_is_in_millimetres(either, builder, tmp_path):
    either.draws(builder.write(), "--size", "88", "60")
    height, width = matplotlib.image.imread(tmp_path / "picture.png").shape[:2]
    assert (width, height) == (int(88 / 25.4 * 300), int(60 / 25.4 * 300))


# ---- both: wrong files and wrong options


def test_file_missing(either, tmp_path):
    assert either.refuses(tmp_path / "none.h5") == f"{tmp_path}/none.h5: no such file"


def test_folder_in_place_of_a_file(either, tmp_path):
    assert either.refuses(tmp_path) == f"{tmp_path}: is a folder"


@pytest.mark.parametrize("content", [b"", b"GENTBEAM a deck\n"])
def test_not_hdf5(either, tmp_path, content):
    path = tmp_path / "deck.h5"
    path.write_bytes(content)
    assert either.refuses(path) == f"{path}: not an HDF5 file"


def test_cut_off_file(either, builder):
    path = builder.write()
    path.write_bytes(path.read_bytes()[:5000])
    assert f"{path}: cannot be opened" in either.refuses(path)


def test_hdf5_of_something_else(either, tmp_path):
    path = tmp_path / "other.h5"
    h5py.File(path, "w").close()
    assert either.refuses(path) == f"{path}: not a gentbeam results file (no attribute format = gentbeam)"


def test_version_of_the_future(either, builder):
    path = builder.write()
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 2
    assert either.refuses(path) == f"{path}: format_version is 2, this script reads 1"


def test_no_such_solution(either, builder):
    assert either.refuses(builder.write(), "--group", "modal").endswith(
        "no solution 'modal' (there are: transient (transient))"
    )


def test_no_solution_at_all(either, builder):
    path = builder.write()
    with h5py.File(path, "r+") as file:
        del file["transient"]
    assert either.refuses(path).endswith("no transient or static solution (there are: none)")


def test_no_such_probe(tip, builder):
    assert tip.refuses(builder.write(), "--probe", "nose").endswith(
        "no probe 'nose' in transient (there are: tip, slope)"
    )


def test_empty_history(tip, builder):
    assert tip.refuses(builder.write(rows=0)).endswith("the history of probe 'tip' in transient is empty")


def test_nothing_to_draw_is_an_error_unless_allowed(tip, builder, tmp_path):
    path = builder.write(probes=())
    assert tip.refuses(path).endswith("no probes in transient")
    assert tip(path, "--if-any", "-o", tmp_path / "picture.png").status == 0
    assert tip.out == "no history of a probe to draw\n"
    assert not (tmp_path / "picture.png").exists()


@pytest.mark.parametrize(
    "value, message",
    [
        ("width", "no parameter 'width' (there are: l, h, jm)"),
        ("0", "--normalise 0: cannot divide by it"),
        ("inf", "--normalise inf: cannot divide by it"),
    ],
)
def test_cannot_normalise(tip, builder, value, message):
    assert tip.refuses(builder.write(), "--normalise", value).endswith(message)


def test_unknown_option_and_no_file(either):
    assert "--colour" in either.refuses("a.h5", "--colour")
    assert "required" in either.refuses()


@pytest.mark.parametrize(
    "options, message",
    [
        (("-o", "results.h5"), "unknown picture format (there are: png, pdf, svg)"),
        (("-o", "a.pdf", "--format", "png"), "--format png contradicts the file's ending"),
        (("--size", "1", "60"), "--size: width and height in millimetres, 10 to 2000"),
        (("--size", "nan", "60"), "--size: width and height in millimetres, 10 to 2000"),
        (("-o", "no/such/folder/a.png"), "No such file or directory: 'no/such/folder/a.png'"),
    ],
)
def test_picture_that_cannot_be(either, builder, options, message):
    assert either.refuses(builder.write(), *options).endswith(message)


def run_in_shell(script, *arguments):
    return subprocess.run(
        [sys.executable, str(SCRIPTS / script), *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("script", ["plot_tip.py", "plot_shapes.py"])
def test_exit_status_of_the_command(script, builder, tmp_path):
    done = run_in_shell(script, builder.write(), "-o", tmp_path / "a.png")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"wrote {tmp_path}/a.png\n", "")
    done = run_in_shell(script, tmp_path / "none.h5")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"{script}: error: {tmp_path}/none.h5: no such file\n"
    done = run_in_shell(script, "--help")
    assert done.returncode == 0 and "examples:" in done.stdout and "--csv" in done.stdout


# ---- both: files of another kind that must be read


@pytest.mark.parametrize("status", ["running", "failed", "interrupted"])
def test_incomplete_run_is_drawn_with_a_warning(either, builder, status):
    either.draws(builder.write(status=status, message="step 7:\nno convergence"))
    assert either.err.endswith(f"cantilever.h5: the run's status is {status}: step 7: no convergence\n")
    assert either.err.startswith(f"{either.name}: warning: ") and either.err.count("\n") == 1


def test_complete_run_gives_no_warning(either, builder):
    either.draws(builder.write())
    assert either.err == ""


def test_strings_of_fixed_length(either, builder):
    assert either.draws(builder.write(text=np.bytes_, parameters="L=10\njm=0.5"))
    assert either.err == ""


def test_parameters_of_fixed_length_strings(tip, builder):
    files = [builder.write(f"{jm}.h5", text=np.bytes_, parameters=f"jm={jm}") for jm in (1, 2)]
    assert labels_of(tip.draws(*files)) == ["$J_m = 1$", "$J_m = 2$"]


def test_history_still_being_written(tip, builder):
    path = builder.write(rows=20, status="running")
    with h5py.File(path, "r+") as file:
        time = file["transient/probes/time"][:15]
        del file["transient/probes/time"]
        dataset(file["transient/probes"], "time", time, "s")
    assert len(tip.numbers(path)) == 15


def test_a_single_row_is_drawn_as_a_point(tip, builder):
    figure = tip.draws(builder.write(rows=1))
    assert [line.get_marker() for line in figure.axes[0].lines if len(line.get_xdata()) == 1] == ["o"]


def test_error_bars_are_a_band_along_a_motion(tip, builder):
    path = builder.write(error_bars={"tip": 0.2})
    figure = tip.draws(path, "--normalise", "-2", "--probe", "tip", "--probe", "slope")
    (band,) = figure.axes[0].collections
    curve = curves(figure)[0]
    corners = band.get_paths()[0].vertices
    for time, value in zip(curve.get_xdata(), curve.get_ydata()):
        heights = corners[np.isclose(corners[:, 0], time), 1]
        assert heights.min() == pytest.approx(value - 0.1) and heights.max() == pytest.approx(value + 0.1)
    assert figure.axes[0].get_title(loc="right") == "bands and bars: estimated errors"
    assert not figure.axes[1].collections and figure.axes[1].get_title(loc="right") == ""


def test_error_bar_of_statics_is_that_of_its_end(tip, builder):
    path = builder.write(group="static", kind="static", end=1.0, error_bars={"tip": 0.2})
    figure = tip.draws(path)
    (bar,) = figure.axes[0].containers
    _, _, (stems,) = bar
    end = curves(figure)[0].get_ydata()[-1]
    assert np.allclose(stems.get_segments(), [[[1.0, end - 0.2], [1.0, end + 0.2]]])
    assert figure.axes[0].get_title(loc="right") == "estimated error: 0.2 in"


# ---- plot_shapes


def expected_faces(x, fields, thickness):
    middle = np.stack([x + fields[:, 0], fields[:, 1]], axis=1)
    director = np.stack([fields[:, 2], 1.0 + fields[:, 3]], axis=1)
    bulge = fields[:, 4:5] * thickness**2 / 4.0
    return middle, middle + (thickness / 2 + bulge) * director, middle + (-thickness / 2 + bulge) * director


def points(rows, part):
    return np.stack([column(rows, f"{part}_x1"), column(rows, f"{part}_x3")], axis=1)


def test_faces_of_a_bent_beam(shapes, builder):
    path = builder.write(thickness=0.8, xi=0.3, rows=9, end=8e-3, curvature=0.12)
    rows = [row for row in shapes.numbers(path, "--times", "2e-3", "4e-3") if float(row["time"]) == 4e-3]
    x = column(rows, "X1")
    assert (x[0], x[-1]) == (0.0, LENGTH)
    at_nodes = np.isclose((x / 0.5) % 1.0, 0.0)
    fields = bent_fields(x, 0.12 * swing(4e-3, 0.5), 0.3)
    for part, expected in zip(("middle", "top", "bottom"), expected_faces(x, fields, 0.8)):
        assert np.allclose(points(rows, part)[at_nodes], expected[at_nodes], rtol=0, atol=1e-12)
        assert np.allclose(points(rows, part), expected, rtol=0, atol=5e-4)


@pytest.mark.parametrize("nodes", [2, 3, 4, 5])
def test_elements_are_drawn_with_their_own_shape_functions(shapes, builder, nodes):
    path = builder.write(nodes=nodes)
    with h5py.File(path, "r+") as file:
        x = file["mesh/x"][()]
        # The highest power the element can follow.
        file["transient/u"][-1, :, 1] = (x / LENGTH) ** (nodes - 1)
    rows = shapes.numbers(path, "--times", "1.35e-2")
    x = column(rows, "X1")
    assert len(np.unique(x)) == 121
    assert np.allclose(column(rows, "middle_x3"), (x / LENGTH) ** (nodes - 1), rtol=0, atol=1e-13)


def test_elements_in_any_order_with_any_order_of_nodes(shapes, builder):
    path = builder.write()
    with h5py.File(path, "r+") as file:
        file["mesh/thickness"][3] = 2.0
    in_order = shapes.numbers(path)
    assert column(in_order, "top_x3")[3 * 13] == 1.0
    with h5py.File(path, "r+") as file:
        elements = file["mesh/elements"][()][::-1]
        elements[:, [1, 2]] = elements[:, [2, 1]]
        file["mesh/elements"][...] = elements
        file["mesh/thickness"][...] = file["mesh/thickness"][()][::-1]
    for row, expected in zip(shapes.numbers(path), in_order):
        assert {k: float(v) for k, v in row.items()} == pytest.approx(
            {k: float(v) for k, v in expected.items()}
        )


def test_rows_nearest_to_the_times(shapes, builder):
    path = builder.write(rows=11, end=1.0)
    drawn = dict.fromkeys(row["time"] for row in shapes.numbers(path, "--times", "0.04", "0.26", "1"))
    assert [float(time) for time in drawn] == pytest.approx([0.0, 0.3, 1.0])
    drawn = dict.fromkeys(row["time"] for row in shapes.numbers(path, "--count", "3"))
    assert [float(time) for time in drawn] == pytest.approx([0.0, 0.5, 1.0])


def test_shapes_that_differ_most_are_the_default(shapes, builder):
    """Six even steps would be half a period each, and show two shapes only."""
    path = builder.write(rows=97, end=2.4e-2, period=8e-3)
    drawn = shapes.numbers(path)
    times = np.array(list(dict.fromkeys(float(row["time"]) for row in drawn)))
    assert len(times) == 7 and times[0] == 0.0 and np.all(np.diff(times) > 0.0)
    tips = np.array([float(row["middle_x3"]) for row in drawn if float(row["X1"]) == LENGTH])
    heights = np.sort(tips)
    assert np.diff(heights).min() > 0.08 * heights.max()
    assert heights.max() == pytest.approx((1.0 - np.cos(1.2)) / 0.12)


def test_shapes_that_are_all_the_same_are_drawn_once(shapes, builder):
    assert {row["time"] for row in shapes.numbers(builder.write(curvature=0.0))} == {"0.0"}


@pytest.mark.parametrize("changes", [{"xi": 0.3}, {"fields": 2}, {"thickness": None}])
def test_displacements_enlarged(shapes, builder, changes):
    path = builder.write(**changes)
    plain = shapes.numbers(path, "--times", "4e-3")
    large = shapes.numbers(path, "--times", "4e-3", "--scale", "2.5")
    assert shapes.figures[-1].axes[0].get_title() == "displacements 2.5 times as large"
    x = np.stack([column(plain, "X1"), np.zeros(len(plain))], axis=1)
    for part, height in (("middle", 0.0), ("top", 0.5), ("bottom", -0.5)):
        if part == "middle" or "thickness" not in changes:
            rest = x + [0.0, height]
            assert np.allclose(points(large, part), rest + 2.5 * (points(plain, part) - rest), atol=1e-12)
    figure = shapes.draws(path, "--scale", "2", "--title", "A beam")
    assert figure.axes[0].get_title() == "A beam (displacements 2 times as large)"
    assert "--scale must be positive" in shapes.refuses(path, "--scale", "0")


def test_time_outside_the_solution(shapes, builder):
    assert shapes.refuses(builder.write(end=1.0), "--times", "0.5", "1.2").endswith(
        "time 1.2 is outside the solution (0 to 1)"
    )
    assert "nan" in shapes.refuses(builder.write(end=1.0), "--times", "nan")


def test_options_that_make_no_sense(shapes, builder):
    assert "--count must be at least 1" in shapes.refuses(builder.write(), "--count", "0")
    assert "--thickness must be positive" in shapes.refuses(builder.write(), "--thickness", "-1")
    assert "not allowed with" in shapes.refuses(builder.write(), "--count", "2", "--times", "0")


def test_without_a_thickness_the_mid_line_is_drawn(shapes, builder):
    path = builder.write(thickness=None)
    rows = shapes.numbers(path, "--count", "2")
    assert "has no /mesh/thickness" in shapes.err
    assert rows[0]["top_x1"] is None and rows[0]["middle_x1"] is not None
    rows = shapes.numbers(path, "--count", "2", "--thickness", "0.4")
    assert shapes.err == ""
    assert column(rows, "top_x3")[0] == 0.2


def test_without_xi_sections_keep_their_middle(shapes, builder):
    rows = shapes.numbers(builder.write(fields=4, xi=0.3))
    assert np.allclose(
        0.5 * (points(rows, "top") + points(rows, "bottom")), points(rows, "middle"), atol=1e-13
    )


def test_without_a_director_sections_stay_normal(shapes, builder):
    path = builder.write(fields=2, rows=9, end=8e-3)
    rows = shapes.numbers(path, "--times", "4e-3")
    x = column(rows, "X1")
    _, top, bottom = expected_faces(x, bent_fields(x, 0.12), 1.0)
    assert np.allclose(points(rows, "top"), top, atol=1e-2)
    assert np.allclose(points(rows, "bottom"), bottom, atol=1e-2)
    across = points(rows, "top") - points(rows, "bottom")
    assert np.allclose(np.linalg.norm(across, axis=1), 1.0, rtol=1e-13)


def test_no_displacements_stored(shapes, builder):
    path = builder.write()
    with h5py.File(path, "r+") as file:
        del file["transient/u"]
    assert shapes.refuses(path).endswith("transient stores no displacements")
    assert shapes.refuses(builder.write(rows=0)).endswith("transient holds no rows")


def test_mesh_that_does_not_fit(shapes, builder):
    path = builder.write()
    with h5py.File(path, "r+") as file:
        del file["mesh/x"]
        dataset(file["mesh"], "x", np.linspace(0.0, 1.0, 30), "in")
    assert shapes.refuses(path).endswith("transient/u does not fit the mesh")
    with h5py.File(path, "r+") as file:
        del file["mesh/elements"]
    assert shapes.refuses(path).endswith("has no /mesh/elements")


@pytest.mark.parametrize("size", [(), ("--size", "80", "120"), ("--size", "160", "50")])
def test_scales_are_equal_and_nothing_is_cut_off(shapes, builder, size):
    axis = shapes.draws(builder.write(), *size).axes[0]
    unit = axis.transData.transform([(0, 0), (1, 0), (0, 1)])
    assert unit[1, 0] - unit[0, 0] == pytest.approx(unit[2, 1] - unit[0, 1], rel=1e-6)
    outlines = np.concatenate(
        [patch.get_xy() for patch in axis.patches if len(patch.get_path().vertices) > 50]
    )
    (left, right), (bottom, top) = axis.get_xlim(), axis.get_ylim()
    assert left < outlines[:, 0].min() and outlines[:, 0].max() < right
    assert bottom < outlines[:, 1].min() and outlines[:, 1].max() < top


def test_axes_and_time_scale(shapes, builder):
    axis = shapes.draws(builder.write(rows=5, end=0.4), "--count", "5").axes[0]
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("$x_1$ (in)", "$x_3$ (in)")
    (bar,) = axis.child_axes
    assert bar.get_ylabel() == "Time (s)"
    assert [tick.get_text() for tick in bar.get_yticklabels()] == ["0", "0.1", "0.2", "0.3", "0.4"]


def test_time_scale_of_many_shapes_stays_readable(shapes, builder):
    axis = shapes.draws(builder.write(rows=41), "--count", "41").axes[0]
    assert len(axis.child_axes[0].get_yticklabels()) == 9


def supports_drawn(shapes, path, fixed):
    """The symbols drawn for the last node with these fields fixed: name, place, and side or "rolls"."""
    with h5py.File(path, "r+") as file:
        file["mesh/fixed"][...] = 0
        for field in fixed:
            file["mesh/fixed"][-1, gentbeam_results.FIELDS.index(field)] = 1
    drawn = []
    for name in ("draw_wall", "draw_pin", "draw_guide"):
        symbol = getattr(plot_shapes, name)
        shapes.monkeypatch.setattr(
            plot_shapes,
            name,
            lambda *args, _name=name, _symbol=symbol, **kwargs: (
                drawn.append((_name, args[1], kwargs["gap"] > 0.0 if kwargs else args[2])),
                _symbol(*args, **kwargs),
            ),
        )
    figure = shapes.draws(path, "--count", "1")
    shapes.monkeypatch.undo()
    return drawn, labels_of(figure)


@pytest.mark.parametrize(
    "fixed, symbol",
    [
        (("u1", "u3", "y1", "y3", "xi"), ("draw_wall", LENGTH, 1.0)),
        (("u1", "u3"), ("draw_pin", LENGTH, False)),
        (("u3",), ("draw_pin", LENGTH, True)),
        (("u1", "y1", "y3"), ("draw_guide", LENGTH, 1.0)),
    ],
)
def test_supports(shapes, builder, fixed, symbol):
    assert supports_drawn(shapes, builder.write(), fixed) == ([symbol], [])


def test_support_without_a_symbol_is_named(shapes, builder):
    assert supports_drawn(shapes, builder.write(), ("u1", "y3")) == ([], ["u1 y3"])


def test_supports_can_be_left_out(shapes, builder):
    path = builder.write()
    marked = len(shapes.draws(path, "--count", "1").axes[0].patches)
    assert len(shapes.draws(path, "--count", "1", "--no-supports").axes[0].patches) == marked - 1


def test_shapes_are_coloured_by_time(shapes, builder, tmp_path):
    shapes.draws(builder.write(rows=5, end=4e-3), "--count", "3", "--no-supports")
    picture = matplotlib.image.imread(tmp_path / "picture.png")[:, :, :3]
    for place in (0.0, 0.5, 1.0):
        near = np.abs(picture - plot_shapes.LINE_COLOURS(place)[:3]).max(axis=2) < 0.02
        assert near.sum() > 1000, place

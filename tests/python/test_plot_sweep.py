"""The pictures of studies: what is drawn of which members, and in which colours."""

import matplotlib.colors
import numpy as np
import pytest
from test_plots import Script

import gentbeam_pictures
import plot_sweep


@pytest.fixture
def sweep(monkeypatch, capsys, tmp_path):
    return Script(plot_sweep, monkeypatch, capsys, tmp_path)


def crossed(**lists):
    """The parameters of all combinations, the last one changing first."""
    grids = np.meshgrid(*lists.values(), indexing="ij")
    return {name: grid.ravel() for name, grid in zip(lists, grids)}


def test_many_curves_are_coloured_by_the_other_parameter(sweep, builder):
    study = crossed(mu=np.linspace(4800.0, 5600.0, 9), jm=[2.0, 4.0, 6.0])
    path = builder.write_study(
        parameters=study, summaries={"tip_max": 1e4 / study["mu"] + 0.1 * study["jm"]}
    )
    axis, bar = sweep.draws(path, "--kind", "response", "--against", "jm").axes
    assert len(axis.lines) == 9 and bar.get_ylabel() == r"$\mu$" and bar.get_ylim() == (4800.0, 5600.0)
    for line, place in zip(axis.lines, np.linspace(0.0, 1.0, 9)):
        assert line.get_xdata().tolist() == [2.0, 4.0, 6.0]
        assert matplotlib.colors.to_rgba(line.get_color()) == pytest.approx(plot_sweep.LINE_COLOURS(place))


def test_few_curves_have_labels(sweep, builder):
    study = crossed(e=[11000.0, 12000.0], jm=[2.0, 4.0, 1e20])
    path = builder.write_study(parameters=study, summaries={"tip_max": 1.0 * study["e"]})
    (axis,) = sweep.draws(path, "--kind", "response").axes
    assert [words.get_text() for words in axis.get_legend().get_texts()] == [
        "$J_m = 2$",
        "$J_m = 4$",
        r"$J_m = \infty$",
    ]


def test_members_of_a_table_are_dots_in_the_colour_asked_for(sweep, builder):
    table = {name: np.random.default_rng(seed).random(40) for seed, name in enumerate("hqe")}
    path = builder.write_study(parameters=table, summaries={"tip_max": table["h"]}, failed=(3,))
    for options, name in (((), "q"), (("--against", "h", "--against", "e"), "e")):
        axis, bar = sweep.draws(path, *options).axes
        (dots,) = axis.collections
        assert bar.get_ylabel() == {"q": "$q$", "e": "$E$"}[name]
        assert dots.get_array().tolist() == np.delete(table[name], 3).tolist()
        assert dots.get_sizes()[0] >= 3.0


def test_one_parameter_makes_one_curve(sweep, builder):
    path = builder.write_study(parameters={"h": [3.0, 1.0, 2.0]}, summaries={"tip_max": [9.0, 1.0, 4.0]})
    (axis,) = sweep.draws(path).axes
    assert axis.get_legend() is None
    (line,) = axis.lines
    assert line.get_xydata().tolist() == [[1.0, 1.0], [2.0, 4.0], [3.0, 9.0]]


def draw_map(sweep, builder, response):
    study = crossed(mu=np.linspace(1.0, 2.0, 9), jm=np.linspace(2.0, 6.0, 7))
    path = builder.write_study(
        parameters=study, summaries={"tip_max": response(study["mu"] - 1.0, (study["jm"] - 2.0) / 4.0)}
    )
    return sweep.draws(path).axes


@pytest.mark.parametrize(
    "response",
    [
        lambda x, y: 5.0 - x + y * y,
        lambda x, y: np.exp(9.0 * x - y),
        lambda x, y: np.hypot(x - 0.5, y - 0.5),
        lambda x, y: -1e-5 * (x**8 + y),
        lambda x, y: 3.0 + 0.0 * x,
    ],
    ids=["slope", "decades", "bowl", "edge", "flat"],
)
def test_numbers_of_a_map_are_whole_and_apart(sweep, builder, response):
    axis, _ = draw_map(sweep, builder, response)
    panel = axis.get_window_extent()
    boxes = [words.get_window_extent() for words in axis.texts]
    for number, box in enumerate(boxes):
        assert panel.x0 < box.x0 and box.x1 < panel.x1 and panel.y0 < box.y0 and box.y1 < panel.y1
        assert not any(box.overlaps(other) for other in boxes[:number])


def test_lines_of_a_map_stand_at_the_round_numbers_of_its_bar(sweep, builder):
    axis, bar = draw_map(sweep, builder, lambda x, y: 0.27 + 0.49 * x + 0.36 * y)
    assert [tick for tick in bar.get_yticks()] == pytest.approx([0.4, 0.6, 0.8, 1.0])
    labels = [words.get_text() for words in bar.get_yticklabels()]
    assert sorted(words.get_text() for words in axis.texts) == sorted(labels)


def test_decades_of_a_map_are_colours_in_logarithms(sweep, builder):
    axis, bar = draw_map(sweep, builder, lambda x, y: 10.0 ** (-5.0 + 4.0 * x + y))
    assert isinstance(axis.collections[0].norm, matplotlib.colors.LogNorm)
    labels = [words.get_text() for words in bar.get_yticklabels()]
    assert labels == ["$10^{-5}$", "$10^{-4}$", "0.001", "0.01", "0.1", "1"]
    axis, _ = draw_map(sweep, builder, lambda x, y: 1.0 + 90.0 * x)
    assert not isinstance(axis.collections[0].norm, matplotlib.colors.LogNorm)


@pytest.mark.parametrize(
    "low, high, logarithmic, levels",
    [
        (4.86, 5.88, False, [4.8, 5.0, 5.2, 5.4, 5.6, 5.8, 6.0]),
        (-1.92, 0.03, False, [-2.0, -1.5, -1.0, -0.5, 0.0, 0.5]),
        (0.011, 1.2, True, [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0]),
        (0.01, 30.0, True, [0.01, 0.1, 1.0, 10.0, 100.0]),
        (1e-9, 1.0, True, [1e-9, 1e-7, 1e-5, 1e-3, 1e-1, 10.0]),
    ],
)
def test_round_levels(low, high, logarithmic, levels):
    assert gentbeam_pictures.round_levels(low, high, logarithmic) == pytest.approx(levels)

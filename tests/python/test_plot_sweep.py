"""The pictures of studies: what is drawn of which members, and in which colours."""

import matplotlib.colors
import numpy as np
import pytest
from test_plots import Script

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

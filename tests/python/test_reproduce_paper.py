"""The report on the paper: its continuum, decks and data, its page, a run with a stand-in."""

import os
import re
import stat
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import paper_chapters  # noqa: E402
import paper_examples  # noqa: E402
import paper_report  # noqa: E402
import paper_runs  # noqa: E402
import paper_words  # noqa: E402
from gentbeam_results import ResultsError  # noqa: E402
from paper_continuum import Continuum, Strip, simpson  # noqa: E402
from paper_examples import (  # noqa: E402
    EXAMPLES,
    UNLIMITED,
    Curve,
    deck_text,
    read_continuum,
    write_continuum,
)
from paper_page import Page  # noqa: E402

FIGURES = ("3", "4", "6", "7", "8", "10", "11", "12", "13")


def swings(deck, jm):
    """In place of a solution: every probe that the deck asks for swings, less far for a smaller jm."""
    size = 1.0 / (1.0 + 0.2 / jm)
    probes = re.findall(r"^PROBE +(\S+)", deck, re.M)
    kind = re.search(r"^(TRANSIENT|STATIC|MODAL)\b", deck, re.M).group(1).lower()
    step, end = 1.0, 10.0
    if kind == "transient":
        step, end = (float(re.search(rf"\b{key}=(\S+)", deck).group(1)) for key in ("step", "end"))
    time = step * np.arange(round(end / step) + 1)
    values = {name: size * np.sin(8.5 * np.pi * time / end) for name in probes}
    solution = SimpleNamespace(probes={"time": time, **values}, frequency=60.0 * np.arange(1, 7) ** 2)
    return {kind: solution}


@pytest.fixture
def stand_in(tmp_path):
    def make(text):
        path = tmp_path / "stand-in"
        path.write_text(text, encoding="utf-8")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        return path

    return make


def reproduce(program, output, *options):
    return subprocess.run(
        [sys.executable, str(ROOT / "scripts" / "paper_report.py"), "--output", str(output), *options],
        env={**os.environ, "GENTBEAM": str(program)},
        capture_output=True,
        text=True,
        check=False,
    )


# ---- the continuum

STRIP = Strip(length=3.0, mu=5000.0, c=2500.0, jm=0.8, rho=1e-6, clamped=(0.0,), spread=((0.0, 3.0, 2.0),))


def test_simpson_weights_integrate_cubics():
    x = np.linspace(0.0, 3.0, 7)
    assert simpson(3) @ x**3 == pytest.approx(81.0 / 4.0)


def test_mass_and_load_of_a_strip_are_those_of_its_volume():
    continuum = Continuum(STRIP, 2)
    assert continuum.mass.sum() == pytest.approx(3.0e-6)
    assert continuum.force[:, :, 1].sum() == pytest.approx(6.0)
    point = Continuum(Strip(3.0, 1.0, 1.0, 1.0, 1.0, points=((1.5, -7.0),)), 2)
    assert point.force[:, :, 1].sum() == pytest.approx(-7.0)


def test_internal_force_is_the_gradient_of_the_energy():
    continuum = Continuum(STRIP, 2)
    random = np.random.default_rng(7)
    u = 0.02 * random.standard_normal((*continuum.shape, 2))
    direction = random.standard_normal(u.shape)
    change = 1e-6
    slope = continuum.strain_energy(u + change * direction) - continuum.strain_energy(u - change * direction)
    force = (continuum.internal_force(u) * direction).sum()
    assert slope / (2.0 * change) == pytest.approx(force, rel=1e-7)


def test_rigid_motion_strains_nothing():
    continuum = Continuum(STRIP, 2)
    x, z = np.meshgrid(np.linspace(0, 3, 13), np.linspace(-0.5, 0.5, 5), indexing="ij")
    turned = np.stack([-z - x + 2.0, x - z], axis=-1)
    assert abs(continuum.internal_force(turned)).max() < 1e-9
    assert abs(continuum.strain_energy(turned)) < 1e-9


def test_continuum_says_when_it_leaves_the_admissible_states():
    continuum = Continuum(STRIP, 2)
    with pytest.raises(ArithmeticError, match="admissible"):
        continuum.internal_force(np.random.default_rng(1).standard_normal((*continuum.shape, 2)))


def test_continuum_meets_the_independent_history_and_keeps_its_energy():
    example = EXAMPLES[1]
    known = read_continuum(example, 1.0)["u3_3"].until(6e-3)
    continuum = Continuum(example.continuum_strip(1.0), 2)
    values, balance = continuum.history([(3.0, 1)], example.interval, len(known.time))
    assert Curve(known.time, values[:, 0]).distance(known) < 0.02
    assert balance < 1e-4


# ---- curves, decks, data


def test_extreme_between_the_rows():
    time = np.linspace(0.0, 1.0, 21)
    value, at = Curve(time, 3.0 - (time - 0.512) ** 2).extreme()
    assert (value, at) == pytest.approx((3.0, 0.512))
    assert Curve(time, -time).extreme() == (-1.0, 1.0)
    assert Curve(time, time - 0.75).extreme(-1.0) == (-0.75, 0.0)


def test_distance_is_relative():
    time = np.linspace(0.0, 1.0, 11)
    assert Curve(time, 1.02 * time).distance(Curve(time, time)) == pytest.approx(0.02)


def test_first_swing_is_not_the_largest():
    time = np.linspace(0.0, 2.0, 401)
    values = (1.0 - np.cos(2.0 * np.pi * time)) * (1.0 + 0.03 * time)
    assert paper_runs.first_swing(Curve(time, values)) == pytest.approx(2.03, abs=1e-3)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.deck)
def test_decks_can_be_varied(example):
    deck = deck_text(example, elements=6, nodes=2, step=1e-6, every=9, rule="linear", load=0.5)
    assert re.search(r"^LINE.* elements=6 +nodes=2\b", deck, re.M)
    assert re.search(r"^TRANSIENT +newmark +step=1e-06\b", deck, re.M)
    assert "rule=linear" in deck and "points=" not in deck and re.search(r"q3=\(\S+\)\*0.5", deck)
    assert all(f"PROBE        {q.name}  {q.field}  x={q.x:g}\n" in deck for q in example.quantities)
    assert re.search(r"^STATIC ", deck_text(example, static=True), re.M)


def test_a_deck_without_what_is_to_vary_is_refused():
    with pytest.raises(ResultsError, match=r"cantilever.inp: nothing in it matches \\bslope="):
        deck_text(EXAMPLES[0], slope=1.0)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.deck)
def test_every_curve_has_a_continuum(example):
    for jm in example.family:
        found = read_continuum(example, jm)
        assert set(found) == {q.name for q in example.quantities}
        curve = found[example.quantities[0].name]
        assert curve.time[1] == pytest.approx(example.interval)
        assert curve.time[-1] == pytest.approx(example.end, rel=5e-3)


def test_data_are_read_as_written_or_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(paper_examples, "DATA", tmp_path)
    example = EXAMPLES[0]
    with pytest.raises(ResultsError, match="continuum_case1_Jm3.csv: No such file"):
        read_continuum(example, 3.0)
    time = np.linspace(0.0, 1.0, 3)
    write_continuum(example, 3.0, {q.name: Curve(time, time + 1.5) for q in example.quantities}, ("a", "b"))
    assert read_continuum(example, 3.0)["u1_10"].values == pytest.approx([1.5, 2.0, 2.5])
    example.continuum_file(3.0).write_text("t,u3_10\n0,nothing\n", encoding="utf-8")
    with pytest.raises(ResultsError, match="not a table of histories"):
        read_continuum(example, 3.0)


def test_small_loads_feel_the_modulus():
    assert [round(paper_runs.small_load_law(example, 0.5), 1) for example in EXAMPLES[:2]] == [29.1, 23.9]
    assert paper_runs.small_load_law(EXAMPLES[0], UNLIMITED) == pytest.approx(0.0)


def test_signs_of_per_cents():
    assert paper_words.signed_percent(-0.001) == "0.00 %"
    assert paper_words.signed_percent(-1.234) == "−1.23 %"
    assert paper_words.signed_percent(1.0, 0) == "+1 %"


# ---- the page


def make_page(tmp_path):
    picture = tmp_path / "a.png"
    picture.write_bytes(b"\x89PNG")
    page = Page("Title")
    page.paragraph("Some\n   words.")
    page.heading(2, "First <i>J</i> part")
    page.table(("<i>J</i>", "kind", "value"), [("∞", "beam", "−1.5 %"), (0.5, "", "–")], "Numbers")
    page.figure(picture, "A <i>picture</i>. More.")
    return page


def test_html_page_stands_alone(tmp_path):
    text = make_page(tmp_path).html("the end")
    assert '<a href="#first-j-part">' in text and '<h2 id="first-j-part">' in text
    assert '<img alt="A picture." src="data:image/png;base64,iVBORw==">' in text
    assert '<td class="number">∞</td><td>beam</td><td class="number">−1.5 %</td>' in text
    assert "<p>Some words.</p>" in text and "<footer>the end</footer>" in text
    assert "http" not in text


def test_markdown_page(tmp_path):
    text = make_page(tmp_path).markdown("pictures")
    assert text.startswith("# Title\n\nSome words.\n\n## First <i>J</i> part\n")
    assert "| <i>J</i> | kind | value |\n| --: | --- | --: |\n| ∞ | beam | −1.5 % |\n" in text
    assert "![A picture.](pictures/a.png)\n\nA <i>picture</i>. More.\n" in text


# ---- the whole


def test_the_report_is_complete(tmp_path, monkeypatch, capsys):
    def draw_shapes(pictures, example):
        path = pictures / f"paper_example_{example.number}.png"
        path.write_bytes(b"\x89PNG")
        return path

    monkeypatch.setattr(paper_runs.gentbeam_runs, "solve", swings)
    monkeypatch.setattr(paper_report, "program_version", lambda: "gentbeam 0.0")
    monkeypatch.setattr(paper_chapters, "draw_shapes", draw_shapes)
    monkeypatch.setattr(sys, "argv", ["paper_report.py", "--output", str(tmp_path / "out")])
    paper_report.main()
    assert capsys.readouterr().out.endswith(f"wrote {tmp_path}/out/paper.html\n")
    text = (tmp_path / "out" / "paper.html").read_text(encoding="utf-8")
    for figure in FIGURES:
        assert f"Figure {figure}: " in text
        for ending in ("png", "pdf"):
            assert (tmp_path / "out" / "pictures" / f"paper_figure_{figure}.{ending}").stat().st_size > 5000
    assert text.count("<img ") == len(FIGURES) + 5
    for claim in ("27 %", "23 %", "1.7662", "0.8074"):
        assert claim in text
    assert not re.search(r"\b(nan|inf)\b", re.sub(r'src="[^"]*"', "", text))
    assert not re.search(r'(?:src|href)="(?!data:|#)', text)


def test_a_run_that_fails_is_named(stand_in, tmp_path):
    says_version = '#!/bin/sh\nif [ "$1" = --version ]; then echo gentbeam; exit 0; fi\n'
    program = stand_in(says_version + 'echo "step 7: no convergence" >&2\nexit 2\n')
    done = reproduce(program, tmp_path / "out")
    assert done.returncode == 1
    assert "error: run fine 1 0.5: " in done.stderr and "step 7: no convergence" in done.stderr
    assert done.stderr.count("\n") == 1
    done = reproduce(stand_in(says_version), tmp_path / "out")
    assert done.returncode == 1
    assert "error: run fine 1 0.5: " in done.stderr and "No such file" in done.stderr


def test_no_program(tmp_path):
    done = reproduce(tmp_path / "none", tmp_path / "out")
    assert done.returncode == 1
    assert done.stderr.endswith("none: No such file or directory\n")
    script = ROOT / "scripts" / "reproduce_paper"
    done = subprocess.run(
        [str(script), "--program", str(tmp_path / "none")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr == f"scripts/reproduce_paper: error: no program at {tmp_path}/none\n"

"""scripts/animate.py and scripts/report.py on results of the program; the page is opened in a browser."""

import html.parser
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from conftest import SCRIPTS
from matplotlib.image import imread
from PIL import Image

import gentbeam_results
import report
import report_pictures
from gentbeam_strip import build_strip, places, strains

DECK = """\
GENTBEAM Two spans <&> "gravity"
UNITS length=in force=lbf time=s
PARAMETER jm=2 load=20
MATERIAL rubber gent mu=5384.6 c=4615.4 jm=jm rho=1e-4
SECTION square rectangle b=1 h=1
SECTION thin rectangle b=1 h=0.5
LINE from=0 to=6 elements=6 section=square
LINE from=6 to=12 elements=6 section=thin
PIN x=0
ROLLER x=6
CLAMP x=12
DISTRIBUTED from=0 to=4 q3=-load
POINT x=9 f3=-6.67
PROBE left u3 x=2
PROBE right u3 x=9
OUTPUT fields=[u strain stress]
END
STATIC steps=3 load=0.2
MODAL count=4
TRANSIENT bathe step=2e-4 end=6e-3
STOP
"""
# Zero where the beam is held.
BUMP = "1e-4*x*(x-6)*(12-x)^2"
BROWSER = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --hide-scrollbars"
).split()


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("solved")
    command = [os.environ["GENTBEAM"], "-q", "-o", "beam"]
    subprocess.run(command, input=DECK, cwd=folder, text=True, check=True)
    return folder / "beam.h5"


def script(name, *arguments, status=0):
    command = [sys.executable, str(SCRIPTS / name), *map(str, arguments)]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    assert done.returncode == status, done.stderr
    return done.stdout if status == 0 else done.stderr


def test_strains_of_the_strip_are_the_programs(results):
    """At the stations and heights of the program: what the scripts compute from u is what it has stored."""
    with gentbeam_results.open_results(str(results)) as file:
        group, mesh = file.group("transient"), file.mesh()
        strip = build_strip(mesh, file.path)
        stored, stations = group.array("strain/E"), file.array("mesh/stations/x")
        _, fields = group.displacements()
        found = strains(strip, fields[20])
        for number, (first, end) in enumerate(zip(strip.ends, strip.ends[1:])):
            for station in (2 * number, 2 * number + 1):
                for level, height in ((0, 0), (2, 2), (4, 4)):
                    along = [
                        np.interp(stations[station], strip.x[first:end], found[name][first:end, level])
                        for name in ("E11", "E33", "E13")
                    ]
                    # Quadratic between the columns, which are a sixth of an element apart.
                    assert along == pytest.approx(stored[20, station, height], abs=2e-5)
        bottom, top = places(strip, np.zeros_like(fields[0]))[0, [0, -1]]
        assert (bottom.tolist(), top.tolist()) == ([0.0, -0.5], [0.0, 0.5])


def test_gif_moves(results, tmp_path):
    film = tmp_path / "film.gif"
    said = script("animate.py", results, "--group", "transient", "-o", film, "--frames", 12, "--fps", 10)
    assert "12 frames" in said
    with Image.open(film) as image:
        assert image.n_frames == 12 and image.info["duration"] == 100
        frames = []
        for number in range(12):
            image.seek(number)
            frames.append(np.asarray(image.convert("RGB")).astype(int))
    assert len({frame.shape for frame in frames}) == 1
    for before, after in zip(frames, frames[1:]):
        assert (np.abs(after - before).max(axis=2) > 60).sum() > 50

    # Strain colours the strip: red and blue are there, and not in the picture without colours.
    def colourful(frame):
        return (np.abs(frame[..., 0] - frame[..., 2])[:, : frame.shape[1] * 3 // 4] > 40).sum()

    assert max(map(colourful, frames)) > 300
    plain = tmp_path / "plain.gif"
    script("animate.py", results, "--group", "transient", "-o", plain, "--frames", 2, "--colour", "none")
    with Image.open(plain) as image:
        assert colourful(np.asarray(image.convert("RGB")).astype(int)) == 0


def test_films_are_the_same_bits(results, tmp_path):
    for name in ("one", "other"):
        script("animate.py", results, "-o", tmp_path / f"{name}.gif", "--frames", 3)
    assert (tmp_path / "one.gif").read_bytes() == (tmp_path / "other.gif").read_bytes()


def test_mp4_where_ffmpeg_is(results, tmp_path):
    film = tmp_path / "film.mp4"
    if shutil.which("ffmpeg"):
        script("animate.py", results, "-o", film, "--frames", 5)
        assert film.read_bytes()[4:8] == b"ftyp"
    else:
        said = script("animate.py", results, "-o", film, status=1)
        assert said == f"animate.py: error: {film}: mp4 needs ffmpeg, which is not installed; .gif does not\n"


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--frames", "1"], "--frames must be at least 2"),
        (["-o", "film.avi"], "film.avi: unknown kind of film (there are: gif, mp4)"),
        (["--group", "modal"], "modal stores no displacements"),
        (["--range", "1", "0"], "--range needs LOW below HIGH"),
    ],
)
def test_film_refuses(results, tmp_path, arguments, words):
    said = script("animate.py", results, *arguments, status=1)
    assert words in said and len(said.splitlines()) == 1


class Parsed(html.parser.HTMLParser):
    """Tags that must be closed, pictures, links and texts of a page."""

    def __init__(self, text):
        super().__init__()
        self.open, self.images, self.links, self.ids, self.sources = [], [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag not in ("img", "meta", "br"):
            self.open.append(tag)
        if tag == "img":
            self.images.append(attributes)
        if tag == "a":
            self.links.append(attributes["href"])
        if "id" in attributes:
            self.ids.append(attributes["id"])
        self.sources += [value for name, value in attributes.items() if name in ("src", "href")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def page(results, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "beam.html"
    script("report.py", results, "-o", path)
    return path


def test_page_is_whole_and_alone(page):
    text = page.read_text(encoding="utf-8")
    parsed = Parsed(text)
    assert parsed.open == []
    assert all(source.startswith(("data:image/svg+xml;base64,", "#")) for source in parsed.sources)
    assert "<script" not in text and "http" not in re.sub(r"base64,[^\"]*", "", text)
    assert {link[1:] for link in parsed.links} <= set(parsed.ids)
    assert len(parsed.images) == len({image["src"] for image in parsed.images}) >= 11
    assert all(image["alt"] for image in parsed.images)


def test_page_says_what_the_file_says(page, results):
    text = page.read_text(encoding="utf-8")
    assert "<h1>Two spans &lt;&amp;&gt; &quot;gravity&quot;</h1>" in text and "complete" in text
    assert "distributed: q3 = -20, on 0 to 4" in text and "point: f3 = -6.67, at x = 9" in text
    assert "DISTRIBUTED from=0 to=4 q3=-load" in text
    with gentbeam_results.open_results(str(results)) as file:
        history = file.group("transient").history("left")
        assert f"{history.values.min():.6g}" in text
        assert f"{file.group('modal').array('frequency')[0]:.7g}" in text


def test_headings_say_name_kind_and_scheme_once(page):
    headings = re.findall(r"<h2[^>]*>(.*?)</h2>", page.read_text(encoding="utf-8"))
    assert headings[1:-1] == ["static: newton", "modal: subspace iteration", "transient: bathe"]


def test_modes_stand_on_the_bent_beam(results):
    with gentbeam_results.open_results(str(results)) as file:
        state = report.Page(file).state_before(file.group("modal"))
        mesh, modes = file.mesh(), file.group("modal").array("modes")
        assert np.array_equal(state, file.group("static").displacements()[1][-1]) and state.any()
    state[:, 1] += 3.0
    figure = report_pictures.modes(mesh, state, np.arange(1.0, 5.0), modes, "1/s")
    for number, axis in enumerate(figure.axes[:4]):
        rest, moved, nodes = (line.get_xydata() for line in axis.lines)
        assert np.allclose(rest[0], [state[0, 0], 3.0]) and np.isclose(rest[-1, 0], 12.0 + state[-1, 0])
        moves = (state + 1.8 * modes[number])[:, :2]
        assert np.allclose(nodes, np.stack([mesh.x, 0.0 * mesh.x], axis=1) + moves)
        (left, right), (bottom, top) = axis.get_xlim(), axis.get_ylim()
        assert left < moved[:, 0].min() and moved[:, 0].max() < right
        assert bottom < moved[:, 1].min() and moved[:, 1].max() < top
    report_pictures.plt.close(figure)


@pytest.mark.parametrize(
    "change, told",
    [
        (("STATIC steps=3 load=0.2\n", ""), False),
        (("END\nSTATIC steps=3 load=0.2\n", f"INITIAL displacement u3={BUMP}\nEND\n"), True),
        (("[u strain stress]", "stress"), True),
    ],
    ids=["straight", "initial", "not stored"],
)
def test_page_tells_that_the_bent_beam_is_not_in_the_file(tmp_path, change, told):
    deck = DECK.replace(*change).replace("TRANSIENT bathe step=2e-4 end=6e-3\n", "")
    command = [os.environ["GENTBEAM"], "-q", "-o", "beam"]
    subprocess.run(command, input=deck, cwd=tmp_path, text=True, check=True)
    script("report.py", tmp_path / "beam.h5")
    text = (tmp_path / "beam.html").read_text(encoding="utf-8")
    assert ("does not hold the shape of the beam here" in text) == told


def test_legend_of_the_energies_hides_no_curve():
    time = np.linspace(0.0, 1.0, 20)
    ledger = {name: time for name in (*report_pictures.ENERGIES, "balance")}
    figure = report_pictures.energies(time, ledger, "J", "Time (s)")
    figure.canvas.draw()
    axis = figure.axes[0]
    legend = axis.get_legend().get_window_extent()
    assert legend.y0 >= axis.get_window_extent().y1 - 1.0 and legend.y1 <= figure.bbox.y1
    assert legend.x1 <= figure.axes[1].get_window_extent().x0
    report_pictures.plt.close(figure)


def test_page_tells_what_auto_chose(tmp_path):
    commands = "STATIC steps=3 load=0.2\nMODAL count=4\nTRANSIENT bathe step=2e-4"
    deck = DECK.replace(commands, "TRANSIENT auto accuracy=5e-2 probe=right")
    command = [os.environ["GENTBEAM"], "-q", "-o", "beam"]
    subprocess.run(command, input=deck, cwd=tmp_path, text=True, check=True)
    script("report.py", tmp_path / "beam.h5", "-o", tmp_path / "beam.html")
    text = (tmp_path / "beam.html").read_text(encoding="utf-8")
    parsed = Parsed(text)
    assert parsed.open == [] and "tuning" in parsed.ids and "#tuning" in parsed.links
    with gentbeam_results.open_results(str(tmp_path / "beam.h5")) as file:
        tuned = file.tuning()
        assert f"<td>{tuned.choice}</td>" in text and f"<td>{tuned.estimate:.2g}</td>" in text
        steps = len(file.group("transient").history("left").time) - 1
        assert tuned.choice.endswith(f"newmark, {steps} steps")
        assert 0.0 < tuned.estimate < tuned.accuracy == 5e-2 and len(tuned.parts) == 4
        assert text.count(", from ") == sum(rung["compared_with"] > 0 for rung in tuned.rungs) > 2
        assert file.group("transient").history("left").error_bar is None
        assert f"{file.group('transient').history('right').error_bar:.2g}</td></tr>" in text


def test_page_in_a_browser(page, tmp_path):
    """Every picture is drawn, and the page is not blank where they stand."""
    browser = os.environ.get("GENTBEAM_BROWSER") or shutil.which("chromium")
    if not browser:
        pytest.skip("no browser (scripts/test installs Chromium on Debian)")
    look = (
        "<script>onload = () => { document.title = JSON.stringify([...document.images].map("
        "i => [i.complete, i.naturalWidth, i.getBoundingClientRect().height])) + '|' +"
        " document.documentElement.scrollWidth + '|' + innerWidth; }</script></body>"
    )
    copy = tmp_path / "copy.html"
    copy.write_text(page.read_text(encoding="utf-8").replace("</body>", look), encoding="utf-8")
    start = [browser, *BROWSER, f"--user-data-dir={tmp_path / 'profile'}"]
    done = subprocess.run(
        [*start, "--virtual-time-budget=5000", "--dump-dom", copy.as_uri()],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    title = re.search(r"<title>(.*?)</title>", done.stdout).group(1)
    images, wide, window = title.split("|")
    drawn = re.findall(r"\[(true|false),([\d.]+),([\d.]+)\]", images)
    assert len(drawn) == page.read_text(encoding="utf-8").count("<img ") > 0
    assert all(
        ready == "true" and float(width) > 100 and float(height) > 50 for ready, width, height in drawn
    )
    assert int(wide) <= int(window)
    shot = tmp_path / "page.png"
    subprocess.run(
        [*start, "--window-size=1000,3000", f"--screenshot={shot}", page.as_uri()],
        capture_output=True,
        check=True,
        timeout=120,
    )
    pixels = imread(shot)[..., :3]
    # Bands of the page's height: something dark and something coloured in nearly all of them.
    bands = np.array_split(pixels, 15)
    assert sum((band.min(axis=2) < 0.5).any() for band in bands) >= 13
    coloured = [(np.ptp(band, axis=2) > 0.3).sum() for band in bands]
    assert sum(count > 100 for count in coloured) >= 8, coloured


def test_page_of_a_run_that_failed(results, tmp_path):
    deck = DECK.replace("load=0.2", "load=1e6 cuts=2").replace("steps=3", "steps=1")
    command = [os.environ["GENTBEAM"], "-q", "-o", "failed"]
    done = subprocess.run(command, input=deck, cwd=tmp_path, text=True, capture_output=True, check=False)
    assert done.returncode == 2
    script("report.py", tmp_path / "failed.h5")
    text = (tmp_path / "failed.html").read_text(encoding="utf-8")
    assert 'class="status other">failed' in text and "STATIC: step 1 of 1 failed" in text
    assert Parsed(text).open == []


def test_scene_reads_every_kind_of_load():
    loads = report_pictures.read_scene(
        "support x=0 u1\nprescribed x=5 u3=3 history=slow\n"
        "point x=2.5 f1=-1 m3=2.25 history=slow stage=static\n"
        "distributed from=0 to=10 q3=1.5 history=step stage=all\ngravity g3=-9.81 history=step stage=all\n"
    )
    assert [load.words for load in loads] == [
        "prescribed: u3 = 3, at x = 5, history slow",
        "point: f1 = -1, m3 = 2.25, at x = 2.5, history slow, static only",
        "distributed: q3 = 1.5, on 0 to 10",
        "gravity: g3 = -9.81",
    ]

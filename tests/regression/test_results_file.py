"""The results file: all of docs/results.md is there; the same deck gives the same bits."""

import os
import re
import subprocess
import time
import zlib

import h5py
import numpy as np
import pytest
from conftest import INPUT, small_deck

STRING = h5py.string_dtype("utf-8")
SERIES = {"time", "probes/time", "probes/tip"}
ENERGY = {f"energy/{name}" for name in ("kinetic", "strain", "external", "dissipated", "balance")}
SOLVER = {f"solver/{name}" for name in ("iterations", "cuts", "step", "residual")}
NODES, ELEMENTS = 9, 4


def datasets(group):
    found = {}

    def visit(name, item):
        if isinstance(item, h5py.Dataset):
            found[name] = item

    group.visititems(visit)
    return found


def text_attribute(item, name):
    """A text attribute, which must be stored as a scalar UTF-8 text of variable length."""
    type_id = item.attrs.get_id(name).get_type()
    assert type_id.is_variable_str() and type_id.get_cset() == h5py.h5t.CSET_UTF8, name
    value = item.attrs[name]
    assert isinstance(value, str), name
    return value


ALL = """TRANSIENT newmark step=2e-4 end=1e-3 name=swing
STATIC steps=3 load=0.5
MODAL count=3"""


@pytest.fixture
def everything(gentbeam):
    """A file with one command of every kind."""
    gentbeam(deck=small_deck(ALL, "OUTPUT fields=[u v a]"))
    with gentbeam.results() as file:
        yield file


def test_root_attributes(everything):
    attributes = everything.attrs
    assert text_attribute(everything, "format") == "gentbeam"
    assert attributes["format_version"] == 1 and attributes["format_version"].shape == ()
    assert re.fullmatch(r"\d+\.\d+\.\d+", text_attribute(everything, "program_version"))
    assert text_attribute(everything, "git_revision")
    assert "GCC" in text_attribute(everything, "compiler")
    assert text_attribute(everything, "title") == "Cantilever, \u00e9lastique"
    created = text_attribute(everything, "created")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d[+-]\d\d:\d\d", created), created
    assert text_attribute(everything, "status") == "complete"
    assert text_attribute(everything, "message") == ""
    assert 0.0 < attributes["wall_seconds"] < 60.0
    assert 0.0 <= attributes["cpu_seconds"] < 60.0


def test_deck_is_kept_as_read(gentbeam):
    text = small_deck(model="! a remark, \u00e0 part\r\n")
    gentbeam("--set", "q=1.5", deck=text)
    with gentbeam.results() as file:
        deck = file["deck"]
        assert deck.dtype == STRING and deck.shape == ()
        assert deck.asstr()[()] == text
        parameters = dict(line.split("=") for line in text_attribute(deck, "parameters").splitlines())
        assert {name: float(value) for name, value in parameters.items()} == {"jm": 1e20, "q": 1.5}


def test_scene_has_numbers_for_expressions(gentbeam):
    model = """SLIDE x=10
PRESCRIBE x=5 u3=2*q history=slow
POINT x=2.5 f1=-1 m3=q^2 history=slow stage=static
GRAVITY g3=-9.81
"""
    text = small_deck(model="OUTPUT fields=none").replace("CLAMP", "HISTORY slow ramp rise=1\nCLAMP")
    gentbeam("--set", "q=1.5", deck=text.replace("OUTPUT", model + "OUTPUT"))
    with gentbeam.results() as file:
        assert text_attribute(file["deck"], "scene").splitlines() == [
            "support x=0 u1 u3 y1 y3 xi",
            "support x=10 u1 y1 y3",
            "prescribed x=5 u3=3 history=slow",
            "point x=2.5 f1=-1 m3=2.25 history=slow stage=static",
            "distributed from=0 to=10 q3=1.5 history=step stage=all",
            "gravity g3=-9.81 history=step stage=all",
        ]


def test_units(everything):
    units = everything["units"]
    assert {name: text_attribute(units, name) for name in units.attrs} == {
        "length": "in",
        "force": "lbf",
        "time": "s",
    }


def lines(attributes):
    """The attributes that are texts, by name, each with a line feed."""
    texts = [attributes[name] for name in sorted(attributes) if isinstance(attributes[name], str)]
    return "".join(text + "\n" for text in texts).encode()


def test_checksums(everything):
    """As docs/results.md says: every number and every text is under one of them."""
    seen = []

    def look(name, item):
        texts = lines(item.attrs)
        assert ("text_checksum" in item.attrs) == (len(texts) > 0 and name != "units"), name
        if "text_checksum" in item.attrs:
            assert item.attrs["text_checksum"] == zlib.crc32(texts), name
        if isinstance(item, h5py.Dataset):
            value = item[()]
            data = value if isinstance(value, bytes) else value.tobytes()
            assert item.attrs["checksum"] == zlib.crc32(data), name
            seen.append(name)

    everything.visititems(look)
    texts = lines(everything.attrs) + lines(everything["units"].attrs)
    assert everything.attrs["text_checksum"] == zlib.crc32(texts)
    assert {"deck", "mesh/x", "swing/u", "swing/solver/cuts", "modal/modes"} <= set(seen)


def test_mesh(everything):
    mesh = everything["mesh"]
    assert set(mesh) == {"x", "elements", "fixed", "thickness"}
    assert mesh["x"].dtype == "<f8"
    assert mesh["x"][:] == pytest.approx(np.linspace(0.0, 10.0, NODES))
    assert mesh["elements"].dtype == "<i4"
    expected = [[2 * e, 2 * e + 1, 2 * e + 2, -1, -1] for e in range(ELEMENTS)]
    assert mesh["elements"][:].tolist() == expected
    assert mesh["fixed"].dtype == "int8"
    assert mesh["fixed"][:].tolist() == [[1] * 5] + [[0] * 5] * (NODES - 1)
    assert mesh["thickness"][:].tolist() == [1.0] * ELEMENTS


@pytest.mark.parametrize("name, rows", [("swing", 6), ("static", 4)])
def test_command_groups(everything, name, rows):
    group = everything[name]
    found = datasets(group)
    assert set(found) == SERIES | ENERGY | SOLVER | {"u", "v", "a"}
    for key, item in found.items():
        shape = (rows, NODES, 5) if key in ("u", "v", "a") else (rows,)
        assert item.shape == shape, key
        assert item.dtype == ("<i4" if key in ("solver/iterations", "solver/cuts") else "<f8"), key
        assert np.isfinite(item[()]).all(), key
    assert group["time"][:].tolist() == group["probes/time"][:].tolist()
    assert group["probes/tip"][:].tolist() == group["u"][:, -1, 1].tolist()


def test_command_attributes(everything):
    swing, static, modal = everything["swing"], everything["static"], everything["modal"]
    kinds = [text_attribute(group, "kind") for group in (swing, static, modal)]
    assert kinds == ["transient", "static", "modal"]
    assert [group.attrs["order"] for group in (swing, static, modal)] == [1, 2, 3]
    assert text_attribute(swing, "scheme") == "newmark"
    assert (swing.attrs["beta"], swing.attrs["gamma"], swing.attrs["dt"]) == (0.25, 0.5, 2e-4)
    assert swing["time"][:] == pytest.approx(np.arange(6) * 2e-4, abs=1e-18)
    assert static["time"][:] == pytest.approx([0.0, 0.5 / 3, 1.0 / 3, 0.5], abs=1e-15)


def test_modes(everything):
    modal = everything["modal"]
    assert set(datasets(modal)) == {"frequency", "modes"}
    assert modal["frequency"].shape == (3,) and modal["modes"].shape == (3, NODES, 5)
    assert (modal["frequency"][:] > 0.0).all()
    assert np.abs(modal["modes"][:, :, :2]).max(axis=(1, 2)) == pytest.approx([1.0] * 3)
    assert not modal["modes"][:, 0, :].any()


def test_every_dataset_has_unit_and_description(everything):
    found = datasets(everything)
    units = {}
    for name, item in found.items():
        units[name] = text_attribute(item, "unit")
        assert text_attribute(item, "description").strip(), name
    assert units["mesh/x"] == "in" and units["mesh/thickness"] == "in"
    assert units["swing/time"] == units["swing/probes/time"] == units["swing/solver/step"] == "s"
    assert units["static/time"] == units["static/solver/step"] == ""
    assert units["swing/probes/tip"] == "in"
    assert units["swing/u"] == "in, in, 1, 1, 1/in"
    assert units["swing/v"] == "in/s, in/s, 1/s, 1/s, 1/in/s"
    assert units["swing/energy/kinetic"] == "lbf*in"
    assert units["modal/frequency"] == "1/s"


def test_units_are_empty_where_the_deck_names_none(gentbeam):
    gentbeam(deck=small_deck().replace("UNITS        length=in  force=lbf  time=s\n", ""))
    with gentbeam.results() as file:
        assert {text_attribute(file["units"], name) for name in ("length", "force", "time")} == {""}
        found = datasets(file)
        assert {text_attribute(item, "unit") for item in found.values()} == {""}
        assert all(text_attribute(item, "description") for item in found.values())


def test_energy_balance_is_what_it_says(everything):
    energy = {name: item[:] for name, item in everything["swing/energy"].items()}
    balance = energy["kinetic"] + energy["strain"] - energy["external"] + energy["dissipated"]
    assert energy["balance"] == pytest.approx(balance - balance[0], abs=1e-12)
    assert energy["balance"][0] == 0.0
    assert energy["kinetic"].max() > 1.0


@pytest.mark.parametrize(
    "every, steps", [(1, range(12)), (2, [0, 2, 4, 6, 8, 10, 11]), (11, [0, 11]), (20, [0, 11])]
)
def test_rows_of_every(gentbeam, every, steps):
    """11 steps: fields every so many of them and at the last, probes always."""
    rows = len(steps)
    gentbeam(deck=small_deck("TRANSIENT newmark step=1e-4 end=11e-4", f"OUTPUT every={every} fields=[u a]"))
    with gentbeam.results() as file:
        group = file["transient"]
        assert group["time"].shape == (rows,)
        assert group["time"][:] == pytest.approx(np.array(steps) * 1e-4, abs=1e-15)
        assert group["u"].shape == group["a"].shape == (rows, NODES, 5)
        assert "v" not in group
        for name in ("probes/time", "probes/tip", "energy/balance", "solver/step"):
            assert group[name].shape == (12,), name
        assert group["probes/tip"][list(steps)].tolist() == group["u"][:, -1, 1].tolist()


def test_long_runs_keep_every_row(gentbeam):
    """More rows than any buffer holds."""
    gentbeam("-q", deck=small_deck("TRANSIENT newmark step=1e-6 end=3e-3"))
    with gentbeam.results() as file:
        group = file["transient"]
        assert group["u"].shape == (3001, NODES, 5)
        assert group["time"][:] == pytest.approx(np.arange(3001) * 1e-6, abs=1e-15)
        assert group["probes/tip"][:].tolist() == group["u"][:, -1, 1].tolist()
        assert (np.diff(group["probes/tip"][:1000]) > 0.0).all()


def test_fields_none_leaves_probes(gentbeam):
    gentbeam(deck=small_deck(model="OUTPUT fields=none"))
    with gentbeam.results() as file:
        group = file["transient"]
        assert not {"u", "v", "a"} & set(group)
        assert group["probes/tip"].shape == (6,)


def test_probes_of_rates_between_nodes(gentbeam):
    probes = "\n".join(f"PROBE p_{field} {field} x=3.7" for field in "u1 y1 xi v1 v3 a1 a3".split())
    gentbeam(deck=small_deck(model=f"OUTPUT fields=[u v a]\n{probes}"))
    # x = 3.7 in the second element, from 2.5 to 5, with nodes at -1, 0, 1.
    s = 2.0 * (3.7 - 2.5) / 2.5 - 1.0
    weights = np.array([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)])
    places = {"u1": ("u", 0), "y1": ("u", 2), "xi": ("u", 4), "v1": ("v", 0), "v3": ("v", 1)}
    places |= {"a1": ("a", 0), "a3": ("a", 1)}
    with gentbeam.results() as file:
        group = file["transient"]
        units = {}
        for name, (fields, number) in places.items():
            probe = group[f"probes/p_{name}"]
            expected = group[fields][:, 2:5, number] @ weights
            assert probe[:] == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(expected).max()), name
            assert "x = 3.7" in text_attribute(probe, "description")
            units[name] = text_attribute(probe, "unit")
        assert (units["u1"], units["y1"], units["xi"]) == ("in", "1", "1/in")
        assert (units["v1"], units["v3"], units["a1"], units["a3"]) == ("in/s", "in/s", "in/s^2", "in/s^2")


def differences(first, second):
    """Datasets of two files that are not the same bit for bit."""
    ours, theirs = datasets(first), datasets(second)
    assert set(ours) == set(theirs)
    return [
        name
        for name in set(ours) - {"deck"}
        if ours[name].shape != theirs[name].shape or ours[name][()].tobytes() != theirs[name][()].tobytes()
    ]


@pytest.mark.parametrize("name", ["cantilever", "sliding", "static_tip_load"])
def test_same_deck_same_bits(gentbeam, name):
    gentbeam("-q", "-o", "first", INPUT / f"{name}.inp")
    gentbeam("-q", "-o", "second", INPUT / f"{name}.inp", env={**os.environ, "OMP_NUM_THREADS": "3"})
    with gentbeam.results("first") as first, gentbeam.results("second") as second:
        assert differences(first, second) == []


def test_an_older_file_is_replaced(gentbeam):
    gentbeam(deck=small_deck("STATIC steps=2 name=first"))
    gentbeam(deck=small_deck("STATIC steps=2 name=second"))
    with gentbeam.results() as file:
        assert "first" not in file and "second" in file


def test_checked_build_gives_the_same(gentbeam):
    """Round-off, grown by the motion: 55 steps of example 1."""
    checked = os.environ.get("GENTBEAM_DEBUG", "")
    if not checked:
        pytest.skip("GENTBEAM_DEBUG names no program built with all checks")
    deck = (INPUT / "cantilever.inp").read_text().replace("end=1.35e-2", "end=7.425e-3")
    gentbeam("-q", "-o", "release", deck=deck)
    gentbeam.executable = checked
    gentbeam("-q", "-o", "debug", deck=deck)
    with gentbeam.results("release") as release, gentbeam.results("debug") as debug:
        for name in ("u", "probes/tip", "energy/strain", "energy/external"):
            ours, theirs = release[f"transient/{name}"][()], debug[f"transient/{name}"][()]
            assert np.abs(ours - theirs).max() <= 1e-7 * np.abs(ours).max(), name


def test_running_file_can_be_read_and_survives_a_kill(gentbeam):
    """Rows come to the file every two seconds; what is there stays when the run is killed."""
    deck = small_deck("TRANSIENT newmark step=1e-8 end=1")
    process = subprocess.Popen(
        [gentbeam.executable, "-q"], stdin=subprocess.PIPE, stderr=subprocess.PIPE, cwd=gentbeam.folder
    )
    process.stdin.write(deck.encode())
    process.stdin.close()
    try:
        rows = 0
        limit = time.monotonic() + 60.0
        while rows < 2 and time.monotonic() < limit:
            time.sleep(0.2)
            assert process.poll() is None, process.stderr.read().decode()
            try:
                with gentbeam.results() as file:
                    rows = file["transient/time"].shape[0]
            except (OSError, KeyError):
                pass
    finally:
        process.kill()
        process.wait()
        process.stderr.close()
    assert rows >= 2
    with gentbeam.results() as file:
        group = file["transient"]
        kept = group["time"].shape[0]
        assert file.attrs["status"] == "running" and kept >= rows
        assert group["u"].shape == (kept, NODES, 5) and np.isfinite(group["u"][()]).all()
        shown = file["VTKHDF/Steps"].attrs["NSteps"]
        assert rows <= shown <= file["VTKHDF/Points"].shape[0] // (3 * NODES)
        assert group["probes/tip"][:kept].tolist() == group["u"][:, -1, 1].tolist()


RECOVERED = {
    "strain/E": ((8, 5, 3), "1"),
    "strain/I1-2": ((8, 5), "1"),
    "strain/J": ((8, 5), "1"),
    "stress/axial": ((8,), "lbf"),
    "stress/shear": ((8,), "lbf"),
    "stress/moment": ((8,), "lbf*in"),
    "stress/S": ((8, 5, 3), "lbf/in^2"),
    "stress/cauchy": ((8, 5, 3), "lbf/in^2"),
}


@pytest.mark.parametrize("asked", ["strain", "stress", "strain stress"])
def test_strains_and_stresses_on_demand(gentbeam, asked):
    """Rows of both as u has them; stations are the two Gauss points of each element, heights faces and three
    Gauss points."""
    gentbeam(deck=small_deck(ALL, f"OUTPUT every=2 fields=[u {asked}]"))
    with gentbeam.results() as file:
        stations = file["mesh/stations"]
        points = 1.25 * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))
        expected = 2.5 * np.arange(ELEMENTS)[:, None] + points
        assert stations["x"][:].reshape(ELEMENTS, 2) == pytest.approx(expected)
        assert stations["element"][:].tolist() == [e for e in range(ELEMENTS) for _ in range(2)]
        inner = 0.5 * np.sqrt(0.6)
        assert stations["x3"][:] == pytest.approx(np.tile([-0.5, -inner, 0.0, inner, 0.5], (8, 1)))
        for command, rows in (("swing", 4), ("static", 3)):
            found = datasets(file[command])
            groups = {name.split("/")[0] for name in found} & {"strain", "stress"}
            assert groups == set(asked.split())
            for name, (shape, unit) in RECOVERED.items():
                if name.split("/")[0] not in asked.split():
                    continue
                item = found[name]
                assert item.shape == (rows, *shape) and item.dtype == "<f8", name
                assert text_attribute(item, "unit") == unit and text_attribute(item, "description"), name
                assert np.isfinite(item[()]).all(), name
            assert found["time"].shape == (rows,)
        assert not {"strain", "stress"} & set(file["modal"])


def test_faces_beyond_the_limit_have_the_stress_of_the_next_point(gentbeam):
    """Two Gauss points do not see the faces of a bent bar pass the limit of the chains, where no stress
    exists. The log says so, and what stands there is that of the Gauss point beside it."""
    deck = """\
GENTBEAM bar bent by couples
MATERIAL m gent mu=5000 c=2500 jm=0.01 rho=1e-6
SECTION s rectangle b=1 h=1 points=2
LINE from=0 to=10 elements=8
CLAMP x=0
POINT x=10 m1=300
OUTPUT fields=[strain stress]
END
STATIC steps=20
STOP
"""
    gentbeam(deck=deck)
    assert "times a face lay beyond the material's limits" in gentbeam.out
    with gentbeam.results() as file:
        limit, s = file["static/strain/I1-2"][-1], file["static/stress/S"][-1]
        beyond = limit >= 0.01
        assert beyond[:, [0, 3]].any() and not beyond[:, 1:3].any(), limit
        assert np.isfinite(s).all()
        beside = s[:, [1, 1, 2, 2]]
        assert s[beyond].tolist() == beside[beyond].tolist()
        assert (s[~beyond][:, 0] != 0.0).all()

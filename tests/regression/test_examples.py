"""The three examples: the largest deflections, and the histories of two-dimensional bodies."""

from pathlib import Path

import numpy as np
import pytest
from conftest import INPUT

DATA = Path(__file__).parent / "data"

# Largest u3(L)/L over the steps of input/cantilever.inp (10 elements, step 1.35e-4 to 1.35e-2), by
# independent code.
LARGEST = {
    "gauss": {"1e20": 0.60283, "10": 0.58226, "5": 0.56586, "2": 0.52976, "1": 0.49394, "0.5": 0.46083},
    "linear": {"1e20": 0.60161, "10": 0.58210, "5": 0.56645, "2": 0.53235, "1": 0.49902, "0.5": 0.46692},
}




@pytest.mark.parametrize("jm", LARGEST["gauss"])
@pytest.mark.parametrize("rule", LARGEST)
def test_largest_deflection(gentbeam, rule, jm):
    text = (INPUT / "cantilever.inp").read_text()
    assert "rule=gauss  points=4" in text
    if rule == "linear":
        text = text.replace("rule=gauss  points=4", "rule=linear")
    gentbeam("-o", "out", "--set", f"jm={jm}", deck=text)
    with gentbeam.results("out") as file:
        tip = file["transient/probes/tip"][:]
        assert tip.shape == (101,)
        assert tip.max() / 10.0 == pytest.approx(LARGEST[rule][jm], abs=2e-5)
        assert file["transient/u"][:, -1, 1].max() == tip.max()


def distances(gentbeam, name, jm, step):
    """Of every probe: distance to the body's history over its norm; largest value over the body's."""
    text = (INPUT / f"{name}.inp").read_text()
    line = next(line for line in text.splitlines() if line.startswith("TRANSIENT"))
    given = float(line.split("step=")[1].split()[0])
    text = text.replace(line, line.replace(line.split("step=")[1].split()[0], f"{given * step!r}"))
    gentbeam("-q", "-o", "out", "--set", f"jm={jm}", deck=text)
    body = np.genfromtxt(DATA / f"{name}_jm{jm}.csv", delimiter=",", names=True)
    found = {}
    with gentbeam.results("out") as file:
        probes = file["transient/probes"]
        time = probes["time"][:]
        assert body["t"].max() == pytest.approx(time[-1], rel=0.01)
        for probe in body.dtype.names[1:]:
            beam = np.interp(body["t"], time, probes[probe][:])
            apart = np.linalg.norm(beam - body[probe]) / np.linalg.norm(body[probe])
            found[probe] = apart, np.abs(beam).max() / np.abs(body[probe]).max()
    return found


# Bounds of the distance with the deck's step and with a quarter of it, and of what the largest value is off.
# The second is the model's own error, since smaller steps do not change it: the section follows X3 + xi X3^2
# only, its ends and supports are held in a line and not over a face, and a frequency that is a little too
# high adds up over the periods. It is largest where the motion is small beside the rest of the beam: at B in
# the unloaded span, and at `mid` and `span` of the third example, whose axial waves the deck's step does not
# resolve.
BODIES = [
    ("cantilever", "1e20", {"tip": (0.015, 0.008, 0.004), "tip_u1": (0.031, 0.010, 0.005)}),
    ("cantilever", "1", {"tip": (0.015, 0.014, 0.007), "tip_u1": (0.030, 0.020, 0.012)}),
    ("two_span", "1e20", {"A": (0.011, 0.011, 0.010), "B": (0.040, 0.060, 0.015)}),
    ("two_span", "1", {"A": (0.024, 0.015, 0.010), "B": (0.055, 0.035, 0.030)}),
    ("sliding", "1e20", {"end": (0.03, 0.02, 0.04), "mid": (0.26, 0.22, 0.06), "span": (0.15, 0.12, 0.04)}),
    ("sliding", "2", {"end": (0.06, 0.04, 0.04), "mid": (0.55, 0.22, 0.10), "span": (0.35, 0.10, 0.06)}),
]


@pytest.mark.parametrize("name, jm, bounds", BODIES, ids=[f"{name}-jm{jm}" for name, jm, _ in BODIES])
def test_history_of_the_body(gentbeam, name, jm, bounds):
    given = distances(gentbeam, name, jm, 1.0)
    quarter = distances(gentbeam, name, jm, 0.25)
    assert given.keys() == quarter.keys() == bounds.keys()
    for probe, (coarse, fine, peak) in bounds.items():
        print(f"{name} jm={jm} {probe}: {given[probe][0]:.4f}", *(f"{x:.4f}" for x in quarter[probe]))
        assert given[probe][0] < coarse, probe
        assert quarter[probe][0] < fine, probe
        assert quarter[probe][1] == pytest.approx(1.0, abs=peak), probe


def test_static_deck_meets_the_elastica(gentbeam):
    gentbeam("-o", "out", INPUT / "static_tip_load.inp")
    with gentbeam.results("out") as file:
        assert file["static/probes/tip"][-1] == pytest.approx(-0.81060902, abs=7e-4)
        assert file["static/probes/tip_u1"][-1] == pytest.approx(-0.55499560, abs=3e-4)
        assert file["static/time"][:] == pytest.approx(np.linspace(0.0, 1.0, 11))
        assert file["bent"].attrs["order"] == 2
        assert (np.diff(file["bent/frequency"][:]) > 0.0).all()


def test_modal_deck_meets_beam_theory(gentbeam):
    gentbeam("-o", "out", INPUT / "modal_beam.inp")
    slender = np.array([15.4182057, 49.9648620, 104.247696]) / (2.0 * np.pi)
    slender *= 0.01 * np.sqrt(1e6 / 1100.0 / 12.0)
    with gentbeam.results("out") as file:
        assert file["modal/frequency"][:3] == pytest.approx(slender, rel=3e-3)

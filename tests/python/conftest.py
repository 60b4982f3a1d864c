"""Results files as gentbeam writes them, made here so that the plotting scripts are tested by themselves."""

import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
sys.path.insert(0, str(SCRIPTS.parent / "tests" / "support"))

LENGTH = 10.0
ELEMENTS = 10
FIELDS = ("u1", "u3", "y1", "y3", "xi")


def dataset(group, name, data, unit="", description="", **attributes):
    made = group.create_dataset(name, data=data)
    made.attrs["unit"] = unit
    made.attrs["description"] = description
    for key, value in attributes.items():
        made.attrs[key] = value
    return made


def bent_fields(x, curvature, xi=0.0):
    """u1 u3 y1 y3 xi of a cantilever bent to a circular arc: lengths are kept, sections stay straight."""
    angle = curvature * x
    if curvature == 0.0:
        u1, u3 = np.zeros_like(x), np.zeros_like(x)
    else:
        u1, u3 = np.sin(angle) / curvature - x, (1.0 - np.cos(angle)) / curvature
    return np.stack([u1, u3, -np.sin(angle), np.cos(angle) - 1.0, np.full_like(x, xi)], axis=-1)


def swing(time, amplitude=3.0, period=8e-3):
    return amplitude * (1.0 - np.cos(2.0 * np.pi * time / period))


class Builder:
    """Makes results files; every part can be left out or changed."""

    def __init__(self, folder):
        self.folder = folder

    def write(self, name="cantilever.h5", **changes):
        path = self.folder / name
        with h5py.File(path, "w", track_order=True) as file:
            self.fill(file, **changes)
        return path

    def write_study(self, name="study.h5", *, parameters, summaries, failed=()):
        """A study without histories: names and values of the parameters, and of the summaries."""
        path = self.folder / name
        values = np.array(list(parameters.values()), dtype=float).T
        status = np.array([2 if number in failed else 1 for number in range(len(values))])
        with h5py.File(path, "w") as file:
            file.attrs.update({"format": "gentbeam", "format_version": np.int32(1), "status": "complete"})
            sweep = file.create_group("sweep")
            dataset(sweep, "number", np.arange(1, len(values) + 1))
            dataset(sweep, "parameters", values, names=list(parameters))
            dataset(sweep, "status", status)
            summary = sweep.create_group("summary")
            for label, data in summaries.items():
                dataset(summary, label, data, "in")
        return path

    def fill(
        self,
        file,
        *,
        parameters="L=10\nh=1\njm=1e20",
        status="complete",
        message="",
        units=("in", "lbf", "s"),
        nodes=3,
        rows=55,
        end=1.35e-2,
        amplitude=3.0,
        period=8e-3,
        scheme="newmark",
        probes=("tip", "slope"),
        group="transient",
        kind="transient",
        thickness=1.0,
        fields=5,
        clamped=True,
        curvature=0.12,
        xi=0.0,
        error_bars=(),
        text=str,
    ):
        file.attrs.update(
            {
                "format": text("gentbeam"),
                "format_version": np.int32(1),
                "status": text(status),
                "message": text(message),
                "title": text("Cantilever"),
            }
        )
        deck = file.create_dataset("deck", data="GENTBEAM Cantilever\n")
        deck.attrs["parameters"] = text(parameters)
        length, force, time_unit = units
        file.create_group("units").attrs.update(
            {"length": text(length), "force": text(force), "time": text(time_unit)}
        )

        mesh = file.create_group("mesh")
        x = np.linspace(0.0, LENGTH, ELEMENTS * (nodes - 1) + 1)
        elements = np.full((ELEMENTS, 5), -1, dtype=np.int32)
        elements[:, :nodes] = np.arange(ELEMENTS)[:, None] * (nodes - 1) + np.arange(nodes)
        fixed = np.zeros((len(x), 5), dtype=np.int8)
        if clamped:
            fixed[0, :] = 1
        dataset(mesh, "x", x, length)
        dataset(mesh, "elements", elements)
        dataset(mesh, "fixed", fixed)
        if thickness is not None:
            dataset(mesh, "thickness", np.full(ELEMENTS, thickness), length)

        solution = file.create_group(group)
        solution.attrs.update({"kind": text(kind), "scheme": text(scheme), "order": np.int32(1)})
        progress_unit = time_unit if kind == "transient" else ""
        time = np.linspace(0.0, end, rows)
        motion = [bent_fields(x, curvature * swing(t, 0.5), xi)[:, :fields] for t in time]
        dataset(solution, "time", time, progress_unit)
        dataset(solution, "u", np.array(motion).reshape(rows, len(x), fields), length)
        recorded = solution.create_group("probes", track_order=True)
        dataset(recorded, "time", time, progress_unit)
        known = {
            "tip": ("u3", length, swing(time, amplitude, period)),
            "slope": ("y1", "", -0.1 * swing(time, amplitude, period)),
            "middle": ("u3", length, 0.4 * swing(time, amplitude, period)),
        }
        for probe in probes:
            field, unit, values = known[probe]
            dataset(recorded, probe, values, unit, f"{field} at x = {LENGTH:g}")
        for probe, error in dict(error_bars).items():
            file.create_dataset(f"tuning/error_bars/{group}.{probe}", data=[error, 0.01])


@pytest.fixture
def builder(tmp_path):
    return Builder(tmp_path)

"""/VTKHDF in the results file, opened by VTK's own reader (which is ParaView's) and drawn off screen."""

import os
import subprocess

import h5py
import numpy as np
import pytest

vtk = pytest.importorskip("vtk", reason="scripts/test installs vtk")
from vtk.util.numpy_support import vtk_to_numpy  # noqa: E402

DECK = """\
GENTBEAM cantilever
UNITS length=in force=lbf time=s
MATERIAL m gent mu=5000 c=2500 jm=2 rho=1e-6
SECTION thin rectangle b=1 h=0.6
SECTION thick rectangle b=1 h=1.2 rule=linear
LINE from=0 to=4 elements=4 section=thick
LINE from=4 to=10 elements=6 nodes=4 section=thin
CLAMP x=0
DISTRIBUTED from=0 to=10 q3=2
OUTPUT {output}
END
{solution}
STOP
"""
TRANSIENT = "TRANSIENT bathe step=1e-4 end=4e-3"
SCALARS = ("xi", "E11", "E33", "I1-2", "J", "energy_density")


@pytest.fixture
def solve(tmp_path):
    def run(output="fields=[u strain]", solution=TRANSIENT):
        deck = DECK.format(output=output, solution=solution)
        command = [os.environ["GENTBEAM"], "-q", "-o", "beam"]
        done = subprocess.run(command, input=deck, cwd=tmp_path, text=True, capture_output=True, check=False)
        assert done.returncode == 0, done.stderr
        return tmp_path / "beam.h5"

    return run


class Reader:
    """VTK's reader, with what it says on the way."""

    def __init__(self, path):
        self.complaints = []
        self.reader = vtk.vtkHDFReader()
        for event in ("ErrorEvent", "WarningEvent"):
            self.reader.AddObserver(event, lambda *_: self.complaints.append(event))
        assert self.reader.CanReadFile(str(path))
        self.reader.SetFileName(str(path))
        self.reader.UpdateInformation()
        key = vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        self.times = np.array(self.reader.GetOutputInformation(0).Get(key))

    def grid(self, row):
        self.reader.SetStep(row)
        self.reader.Update()
        assert not self.complaints
        found = self.reader.GetOutputDataObject(0)
        assert found.GetClassName() == "vtkUnstructuredGrid"
        return found


def points(grid):
    return vtk_to_numpy(grid.GetPoints().GetData()).astype(float)


def values(grid, name):
    return vtk_to_numpy(grid.GetPointData().GetArray(name)).astype(float)


def columns(file):
    """Node and thickness of every column of the strip: nodes of each line's elements."""
    x, elements, h = file["mesh/x"][:], file["mesh/elements"][:], file["mesh/thickness"][:]
    found = []
    for number, row in enumerate(elements):
        for node in row[row >= 0]:
            if not found or found[-1] != (node, h[number]):
                found.append((node, h[number]))
    nodes, thickness = (np.array(part) for part in zip(*found))
    return x[nodes], nodes, thickness


def expected_places(file, u):
    x, nodes, h = columns(file)
    x3 = h[:, None] * np.array([-0.5, 0.0, 0.5])
    q = u[nodes]
    zeta = x3 + q[:, 4:5] * x3**2
    along = (x + q[:, 0])[:, None] + zeta * q[:, 2:3]
    across = q[:, 1:2] + zeta * (1.0 + q[:, 3:4])
    return np.stack([along, np.zeros_like(along), across], axis=-1).reshape(-1, 3)


def test_points_and_fields_are_the_motion(solve):
    path = solve()
    reader = Reader(path)
    with h5py.File(path, "r") as file:
        run = file["transient"]
        assert reader.times == pytest.approx(run["time"][:], abs=1e-15)
        rest = expected_places(file, np.zeros_like(run["u"][0]))
        for row in (0, 7, 25, 40):
            grid = reader.grid(row)
            places = expected_places(file, run["u"][row])
            assert points(grid) == pytest.approx(places, abs=2e-6 * 10.0)
            assert values(grid, "u") == pytest.approx(places - rest, abs=2e-6 * 10.0)
            q = np.repeat(run["u"][row][columns(file)[1]], 3, axis=0)
            director = np.stack([q[:, 2], np.zeros(len(q)), 1.0 + q[:, 3]], axis=-1)
            assert values(grid, "director") == pytest.approx(director, abs=1e-6)
            assert values(grid, "xi") == pytest.approx(q[:, 4], abs=1e-6)


def test_strip_of_quads(solve):
    """Two quads across between neighbouring nodes, none over the step in thickness, all of positive area that
    adds up to that of the beam."""
    grid = Reader(solve()).grid(0)
    assert grid.GetNumberOfCells() == 2 * (4 * 2 + 6 * 3)
    area = 0.0
    for number in range(grid.GetNumberOfCells()):
        cell = grid.GetCell(number)
        assert cell.GetCellType() == vtk.VTK_QUAD
        corner = np.array([cell.GetPoints().GetPoint(i) for i in range(4)])[:, [0, 2]]
        one, other = corner[2] - corner[0], corner[3] - corner[1]
        part = 0.5 * (one[0] * other[1] - one[1] * other[0])
        assert part > 0.0
        area += part
    assert area == pytest.approx(4.0 * 1.2 + 6.0 * 0.6, rel=1e-6)


def test_strains_at_the_points(solve):
    """Invariants and energy belong together, and the strains to the shape of the quads: E11 to the lengths of
    the faces' edges."""
    path = solve()
    grid = Reader(path).grid(20)
    e11, e33, i1, j = (values(grid, name) for name in ("E11", "E33", "I1-2", "J"))
    # Plane: det C = J^2, tr C = I1, so that C13 follows and must be real.
    c11, c33 = 1.0 + 2.0 * e11, 1.0 + 2.0 * e33
    gauss = slice(3 * 9, None)  # rule gauss; rule linear has no J of its own beside E
    assert (c11 + c33 - 2.0)[gauss] == pytest.approx(i1[gauss], abs=1e-5)
    assert (c11 * c33 - j**2 > -1e-5)[gauss].all()
    mu, c, jm = 5000.0, 2500.0, 2.0
    energy = (
        -0.5 * mu * jm * np.log(1.0 - i1 / jm) - mu * np.log(j) + 0.25 * c * (j**2 - 1.0 - 2.0 * np.log(j))
    )
    # I1-2 and J are rounded to 32 bits.
    assert values(grid, "energy_density") == pytest.approx(energy, abs=1e-3 * energy.max())
    top = points(grid).reshape(-1, 3, 3)[9:, 2]
    rest = points(Reader(path).grid(0)).reshape(-1, 3, 3)[9:, 2]
    stretch = np.linalg.norm(np.diff(top, axis=0), axis=1) / np.linalg.norm(np.diff(rest, axis=0), axis=1)
    strain = 0.5 * (stretch**2 - 1.0)
    mean = 0.5 * (e11.reshape(-1, 3)[9:-1, 2] + e11.reshape(-1, 3)[10:, 2])
    assert mean[1:] == pytest.approx(strain[1:], abs=0.05 * np.abs(strain).max())


def test_without_strains_there_is_the_motion_alone(solve):
    data = Reader(solve(output="every=5")).grid(3).GetPointData()
    assert [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())] == ["u"]


def test_nothing_where_no_rows_are_kept(solve):
    with h5py.File(solve(output="fields=none"), "r") as file:
        assert "VTKHDF" not in file


def test_commands_follow_one_another_on_one_clock(solve):
    """The state that a later command starts from is there once."""
    path = solve(
        solution="STATIC steps=4 load=0.5\nMODAL count=2\nTRANSIENT bathe step=1e-4 end=1e-3\nSTATIC steps=2"
    )
    reader = Reader(path)
    with h5py.File(path, "r") as file:
        static, swing, back = (file[name]["time"][:] for name in ("static", "transient", "static_2"))
        clock = np.concatenate([static, 0.5 + swing[1:], 0.5 + swing[-1] + np.abs(back[1:] - back[0])])
        assert reader.times == pytest.approx(clock)
        last = file["static_2/u"][-1]
        assert points(reader.grid(len(clock) - 1)) == pytest.approx(expected_places(file, last), abs=2e-5)
        assert file["VTKHDF/Steps"].attrs["NSteps"] == len(clock)


def draw(grid, path):
    """A picture of the strip coloured by E11, as an array of rows from the top."""
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputData(grid)
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("E11")
    mapper.SetScalarRange(-0.1, 0.1)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1.0, 1.0, 1.0)
    renderer.AddActor(actor)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(5.0, 0.0, 3.0)
    camera.SetPosition(5.0, -20.0, 3.0)
    camera.SetViewUp(0.0, 0.0, 1.0)
    camera.SetParallelScale(5.0)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(400, 320)
    window.AddRenderer(renderer)
    window.Render()
    taken = vtk.vtkWindowToImageFilter()
    taken.SetInput(window)
    taken.ReadFrontBufferOff()
    taken.Update()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetInputConnection(taken.GetOutputPort())
    writer.Write()
    image = taken.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1, :, :3]


def test_pictures_show_the_beam_and_it_moves(solve, tmp_path):
    reader = Reader(solve())
    pictures = {row: draw(reader.grid(row), tmp_path / f"row{row}.png") for row in (0, 12, 25)}
    scale = 320 / 10.0  # pixels a unit of length
    middle = []
    for row, picture in pictures.items():
        beam = (picture < 250).any(axis=2)
        # The strip's area, seen square on.
        places = points(reader.grid(row)).reshape(-1, 3, 3)[:, :, [0, 2]]
        outline = np.concatenate([places[:, 0], places[::-1, 2]])
        x, y = outline.T
        area = 0.5 * abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1)))
        assert beam.sum() == pytest.approx(area * scale**2, rel=0.05), row
        # Its tip, by the rightmost pixels, is where the points are.
        rows, across = np.nonzero(beam)
        tip = rows[across >= across.max() - 3].mean()
        drawn = places[-1, 1]
        assert (160 - tip) / scale + 3.0 == pytest.approx(drawn[1], abs=0.5), row
        middle.append(tip)
        colours = np.unique(picture[beam], axis=0)
        assert len(colours) > (1 if row else 0)
    assert middle[0] - middle[1] > 30 and middle[0] - middle[2] > 60, middle

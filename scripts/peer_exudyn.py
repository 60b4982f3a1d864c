"""Example 1 by Exudyn: geometrically exact beams of two nodes, modified Newton, trapezoidal rule."""

import time
import warnings

warnings.simplefilter("ignore", DeprecationWarning)
import exudyn as exu  # noqa: E402
from exudyn.itemInterface import (  # noqa: E402
    CoordinateConstraint,
    Force,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    NodeRigidBody2D,
    ObjectBeamGeometricallyExact2D,
    SensorNode,
)

import peer_beam as beam

MASS = beam.DENSITY * beam.AREA
BENDING = beam.E * beam.INERTIA
AXIAL = beam.E * beam.AREA
SHEAR = beam.SHEAR_FACTOR * beam.G * beam.AREA


def add_beam(system, elements):
    """Nodes of linear elements that bend, stretch and shear."""
    size = beam.LENGTH / elements
    nodes = [
        system.AddNode(NodeRigidBody2D(referenceCoordinates=[size * i, 0, 0])) for i in range(elements + 1)
    ]
    for pair in zip(nodes, nodes[1:]):
        system.AddObject(
            ObjectBeamGeometricallyExact2D(
                nodeNumbers=list(pair),
                physicsLength=size,
                physicsMassPerLength=MASS,
                physicsCrossSectionInertia=beam.DENSITY * beam.INERTIA,
                physicsBendingStiffness=BENDING,
                physicsAxialStiffness=AXIAL,
                physicsShearStiffness=SHEAR,
            )
        )
    return nodes



def build(elements):
    system = exu.SystemContainer().AddSystem()
    nodes = add_beam(system, elements)
    ground = system.AddNode(NodePointGround())
    anchor = system.AddMarker(MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for coordinate in range(3):
        marker = system.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        system.AddObject(CoordinateConstraint(markerNumbers=[anchor, marker]))
    for node, force in zip(nodes[1:], beam.nodal_forces(elements)):
        marker = system.AddMarker(MarkerNodePosition(nodeNumber=node))
        system.AddLoad(Force(markerNumber=marker, loadVector=[0, force, 0]))
    kind = exu.OutputVariableType.Displacement
    tip = system.AddSensor(SensorNode(nodeNumber=nodes[-1], storeInternal=True, outputVariableType=kind))
    system.Assemble()
    return system, tip


def run(_, elements, steps, last):
    system, tip = build(elements)
    settings = exu.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = beam.END / steps
    settings.linearSolverType = exu.LinearSolverType.EigenSparse
    settings.parallel.numberOfThreads = 1
    integration = settings.timeIntegration
    integration.numberOfSteps = last
    integration.endTime = beam.END * last / steps
    integration.verboseMode = 0
    integration.adaptiveStep = False
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance = beam.TOLERANCE
    integration.generalizedAlpha.spectralRadius = 1.0
    start = time.process_time()
    system.SolveDynamic(settings)
    seconds = time.process_time() - start
    rows = system.GetSensorStoredData(tip)
    if len(rows) != last + 1:
        beam.fail(len(rows))
    return seconds, [float(value) for value in rows[:, 2]], exu.__version__


if __name__ == "__main__":
    beam.answer(run)

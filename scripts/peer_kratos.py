"""Example 1 by Kratos' structural mechanics: two-node corotational beams with shear, Newmark's rule."""

import time

import KratosMultiphysics as kratos
import KratosMultiphysics.StructuralMechanicsApplication as structural
from KratosMultiphysics import python_linear_solver_factory

import peer_beam as beam

VARIABLES = (
    kratos.DISPLACEMENT,
    kratos.ROTATION,
    kratos.VELOCITY,
    kratos.ACCELERATION,
    kratos.ANGULAR_VELOCITY,
    kratos.ANGULAR_ACCELERATION,
    kratos.REACTION,
    kratos.REACTION_MOMENT,
    kratos.VOLUME_ACCELERATION,
    structural.POINT_LOAD,
)
UNKNOWNS = (
    (kratos.DISPLACEMENT_X, kratos.REACTION_X),
    (kratos.DISPLACEMENT_Y, kratos.REACTION_Y),
    (kratos.ROTATION_Z, kratos.REACTION_MOMENT_Z),
)


def build(model, element, elements):
    part = model.CreateModelPart("beam")
    part.SetBufferSize(3)
    for variable in VARIABLES:
        part.AddNodalSolutionStepVariable(variable)
    part.ProcessInfo[kratos.DOMAIN_SIZE] = 2
    section = part.GetProperties()[1]
    section.SetValue(kratos.YOUNG_MODULUS, beam.E)
    section.SetValue(kratos.POISSON_RATIO, beam.NU)
    section.SetValue(kratos.DENSITY, beam.DENSITY)
    section.SetValue(structural.CROSS_AREA, beam.AREA)
    section.SetValue(structural.I33, beam.INERTIA)
    section.SetValue(structural.AREA_EFFECTIVE_Y, beam.SHEAR_FACTOR * beam.AREA)
    section.SetValue(kratos.CONSTITUTIVE_LAW, structural.BeamConstitutiveLaw())
    for i in range(elements + 1):
        part.CreateNewNode(i + 1, beam.LENGTH * i / elements, 0.0, 0.0)
    for unknown, reaction in UNKNOWNS:
        kratos.VariableUtils().AddDof(unknown, reaction, part)
        part.Nodes[1].Fix(unknown)
    for i in range(elements):
        part.CreateNewElement(element, i + 1, [i + 1, i + 2], section)
    for i, force in enumerate(beam.nodal_forces(elements), 1):
        condition = part.CreateNewCondition("PointLoadCondition2D1N", i, [i + 1], section)
        condition.SetValue(structural.POINT_LOAD, [0.0, force, 0.0])
    return part


def strategy(part):
    solver = python_linear_solver_factory.ConstructSolver(
        kratos.Parameters('{"solver_type": "skyline_lu_factorization"}')
    )
    made = kratos.ResidualBasedNewtonRaphsonStrategy(
        part,
        kratos.ResidualBasedBossakDisplacementScheme(0.0),
        # Tighter than this its increments do not get on fine meshes.
        kratos.DisplacementCriteria(1e-6, 1e-9),
        kratos.ResidualBasedBlockBuilderAndSolver(solver),
        25,
        False,
        False,
        True,
    )
    made.SetEchoLevel(0)
    made.Initialize()
    return made


def run(element, elements, steps, last):
    kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
    model = kratos.Model()
    part = build(model, element, elements)
    solver = strategy(part)
    dt = beam.END / steps
    now = 0.0

    def step_by(size):
        nonlocal now
        now += size
        part.CloneTimeStep(now)
        part.ProcessInfo[kratos.STEP] += 1
        solver.InitializeSolutionStep()
        solver.Predict()
        converged = solver.SolveSolutionStep()
        solver.FinalizeSolutionStep()
        return converged

    for node in list(part.Nodes)[1:]:
        node.SetSolutionStepValue(kratos.ACCELERATION_Y, 0, beam.INITIAL_ACCELERATION)
    node = part.Nodes[elements + 1]
    tip = [0.0]
    start = time.process_time()
    for step in range(1, last + 1):
        if not step_by(dt):
            beam.fail(step)
        tip.append(node.GetSolutionStepValue(kratos.DISPLACEMENT_Y))
    return time.process_time() - start, tip, kratos.Kernel.Version()


if __name__ == "__main__":
    beam.answer(run)

"""Example 1 by OpenSees: two-node frame elements in corotational frames, consistent mass, Newmark's rule."""

import time

import openseespy.opensees as ops

import peer_beam as beam


def build(element, elements):
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for i in range(elements + 1):
        ops.node(i + 1, beam.LENGTH * i / elements, 0.0)
    ops.fix(1, 1, 1, 1)
    ops.geomTransf("Corotational", 1)
    ops.section("Elastic", 1, beam.E, beam.AREA, beam.INERTIA, beam.G, beam.SHEAR_FACTOR)
    ops.beamIntegration("Legendre", 1, 1, 2)
    stiffness = {
        "timoshenkoBeamColumn": (1, 1),
        "elasticBeamColumn": (beam.AREA, beam.E, beam.INERTIA, 1),
    }[element]
    for i in range(elements):
        ops.element(element, i + 1, i + 1, i + 2, *stiffness, "-mass", beam.DENSITY * beam.AREA, "-cMass")
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    for i, force in enumerate(beam.nodal_forces(elements), 2):
        ops.load(i, 0.0, force, 0.0)


def run(element, elements, steps, last):
    build(element, elements)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandSPD")
    ops.test("NormDispIncr", beam.TOLERANCE, 25, 0)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    dt = beam.END / steps
    for i in range(elements):
        ops.setNodeAccel(i + 2, 2, beam.INITIAL_ACCELERATION, "-commit")
    tip = [0.0]
    start = time.process_time()
    for step in range(1, last + 1):
        if ops.analyze(1, dt):
            beam.fail(step)
        tip.append(ops.nodeDisp(elements + 1, 2))
    return time.process_time() - start, tip, ops.version()


if __name__ == "__main__":
    beam.answer(run)

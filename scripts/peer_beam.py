"""What the other programs' adapters have in common: the beam of example 1, and how they answer.

An adapter is a process of its own: `peer_NAME.py ELEMENT ELEMENTS STEPS FILE [LAST]` computes one run, up to
its step LAST, and writes FILE, in JSON: seconds of CPU time of the calls that step, time, tip, version. It
imports the program it is for and little else, so that the process costs what the program costs.
"""

import json
import sys

# Example 1 in the limit of linear elasticity: a cantilever under a sudden dead load.
LENGTH = 10.0
E = 12000.0
NU = 0.2
G = E / (2.0 * (1.0 + NU))
AREA = 1.0
INERTIA = 1.0 / 12.0
DENSITY = 1e-6
LOAD = 2.85  # force a length
END = 1.35e-2
SHEAR_FACTOR = 10.0 * (1.0 + NU) / (12.0 + 11.0 * NU)
TOLERANCE = 1e-8  # of Newton's method
# For programs that do not find it themselves: what the free nodes start with.
INITIAL_ACCELERATION = LOAD / (DENSITY * AREA)


def nodal_forces(elements):
    """The load on nodes 1 to `elements`; node 0 is clamped."""
    size = LOAD * LENGTH / elements
    return [size] * (elements - 1) + [0.5 * size]


def answer(run):
    """Computes the run that the command line asks for and writes what came of it."""
    element, elements, steps, path = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
    last = int(sys.argv[5]) if len(sys.argv) > 5 else steps
    seconds, tip, version = run(element, elements, steps, last)
    time = [END * row / steps for row in range(last + 1)]
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"seconds": seconds, "time": time, "tip": tip, "version": version}, file)


def fail(step):
    sys.exit(f"no convergence in step {step}")

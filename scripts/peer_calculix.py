"""Example 1 by CalculiX: three-node beams, which it computes as quadratic bricks with reduced integration."""

import peer_beam as beam


def deck(element, elements, steps, last):
    """The input file of `last` out of `steps` fixed steps by Newmark's rule (alpha = 0)."""
    nodes = 2 * elements + 1
    dt = beam.END / steps
    size = beam.LOAD * beam.LENGTH / elements
    # Consistent nodal forces of a quadratic element: 1/6, 4/6, 1/6 of the load on it.
    forces = [size * (4.0 if i % 2 else 2.0) / 6.0 for i in range(nodes)]
    forces[-1] = size / 6.0
    return "\n".join(
        [
            "*NODE, NSET=ALL",
            *(f"{i + 1}, {beam.LENGTH * i / (nodes - 1)!r}, 0, 0" for i in range(nodes)),
            f"*ELEMENT, TYPE={element}, ELSET=BEAM",
            *(f"{i + 1}, {2 * i + 1}, {2 * i + 2}, {2 * i + 3}" for i in range(elements)),
            "*NSET, NSET=TIP",
            f"{nodes}",
            "*MATERIAL, NAME=LINEAR",
            "*ELASTIC",
            f"{beam.E}, {beam.NU}",
            "*DENSITY",
            f"{beam.DENSITY}",
            "*BEAM SECTION, ELSET=BEAM, MATERIAL=LINEAR, SECTION=RECT",
            "1, 1",
            "0, 0, 1",
            "*BOUNDARY",
            "1, 1, 6",
            *(f"{i + 1}, 3, 3" for i in range(1, nodes)),
            f"*STEP, NLGEOM, INC={steps + 1}",
            "*DYNAMIC, DIRECT, ALPHA=0, SOLVER=SPOOLES",
            f"{dt!r}, {dt * last!r}",
            "*CLOAD",
            *(f"{i + 1}, 2, {forces[i]!r}" for i in range(1, nodes)),
            "*NODE PRINT, NSET=TIP",
            "U",
            "*END STEP",
            "",
        ]
    )


def read(path, steps, last):
    """Times and the tip's deflection, from rest on, in a .dat file."""
    rows = []
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if len(words) == 4 and words[0].isdigit():
                rows.append(float(words[2]))
    if len(rows) != last:
        raise ValueError(f"stopped after {len(rows)} of {last} steps")
    return [beam.END * row / steps for row in range(last + 1)], [0.0, *rows]

"""Decks of published benchmarks and the figures compared, for the tests and for scripts/benchmarks.py."""

import numpy as np

from gentbeam_runs import solve


def first_extreme(time, values, sign):
    """The first local extreme of that sign, by the parabola through the three rows about it."""
    scaled = sign * values
    rows = np.flatnonzero((scaled[1:-1] >= scaled[:-2]) & (scaled[1:-1] > scaled[2:])) + 1
    row = rows[scaled[rows] > 0.5 * scaled.max()][0]
    a, b, c = np.polyfit(time[row - 1 : row + 2] - time[row], values[row - 1 : row + 2], 2)
    return time[row] - 0.5 * b / a, c - 0.25 * b**2 / a


def bathe_ramm_wilson(solution, support="CLAMP x=0"):
    return solve(f"""GENTBEAM Bathe, Ramm and Wilson
MATERIAL m gent mu=5000 c=2500 jm=1e20 rho=1e-6
SECTION s rectangle b=1 h=1
LINE from=0 to=10 elements=24 nodes=4
{support}
DISTRIBUTED from=0 to=10 q3=2.85
PROBE tip u3 x=10
OUTPUT fields=none
END
{solution}
STOP
""")


def turek_hron(solution, support="FIX u1 u3 y1 x=0"):
    """A neo-Hookean plane-strain beam (mu = 0.5 MPa, lambda = 2 MPa) of 0.35 m behind the cylinder."""
    return solve(f"""GENTBEAM Turek and Hron
MATERIAL m neohookean mu=0.5e6 c=2e6 rho=1000
SECTION s rectangle b=1 h=0.02
LINE from=0 to=0.35 elements=16 nodes=4
{support}
GRAVITY g3=-2
PROBE u1 u1 x=0.35
PROBE u3 u3 x=0.35
OUTPUT fields=none
END
{solution}
STOP
""")


def swing(time, values):
    """Mean, amplitude and frequency of a vibration: of its extremes, and of its crossings of their middle."""
    low, high = values.min(), values.max()
    mean, amplitude = 0.5 * (high + low), 0.5 * (high - low)
    middle = values - mean
    rows = np.flatnonzero((middle[:-1] > 0.0) & (middle[1:] <= 0.0))
    crossings = time[rows] + (time[rows + 1] - time[rows]) * middle[rows] / (middle[rows] - middle[rows + 1])
    frequency = (len(crossings) - 1) / (crossings[-1] - crossings[0])
    return mean, amplitude, frequency


SPIN_UP = 15.0
FASTER = "6/15*(t^2/2+(15/(2*pi))^2*(cos(2*pi*t/15)-1))"
BEFORE = "min(1,max(0,(15-t)*1e12))"
ANGLE = f"({BEFORE}*({FASTER})+(1-{BEFORE})*(6*t-45))"


def spin_up(scheme, step, end, may_fail=False):
    """The arm's tip as the turning frame sees it: time, axial and transverse displacement."""
    beam = solve(
        f"""GENTBEAM spin-up
MATERIAL m elastic e=3.614784e8 nu=0.4 rho=15.49193
SECTION s rectangle b=1 h=0.0774597
LINE from=0 to=10 elements=10 nodes=4
HISTORY sine formula f=-sin({ANGLE})
HISTORY cosine formula f=cos({ANGLE})-1
PIN x=0
PRESCRIBE x=0 y1=1 history=sine
PRESCRIBE x=0 y3=1 history=cosine
PROBE u1 u1 x=10
PROBE u3 u3 x=10
OUTPUT fields=none
END
TRANSIENT {scheme} step={step} end={end}
STOP
""",
        may_fail=may_fail,
    )
    probes = beam["transient"].probes
    time = probes["time"]
    angle = 0.4 * (0.5 * time**2 + (7.5 / np.pi) ** 2 * (np.cos(2.0 * np.pi * time / 15.0) - 1.0))
    angle = np.where(time < SPIN_UP, angle, 6.0 * time - 45.0)
    x, z = 10.0 + probes["u1"], probes["u3"]
    axial, transverse = np.cos(angle) * x + np.sin(angle) * z - 10.0, np.cos(angle) * z - np.sin(angle) * x
    return beam.complete, time, axial, transverse

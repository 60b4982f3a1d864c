"""The rule `linear` has no energy to conserve: what that comes to, over thousands of steps and, in the long
run, a hundred thousand."""

import numpy as np
import pytest


@pytest.mark.parametrize("scheme", ["generalized", "bathe"])
def test_damping_schemes_bound_the_drift(stage, scheme):
    outcome = stage("linear_rule", scheme, 1.35e-4, 3.0)
    assert outcome.kind == "completed" and abs(outcome.drift) < 0.01


def test_newmark_does_not(stage):
    """At a step where damping schemes go on, the trapezoidal rule gains energy until it cannot be solved."""
    outcome = stage("linear_rule", "newmark", 1.35e-4, 3.0)
    assert outcome.kind in ("failed", "energy") and outcome.drift > 0.0


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["hht", "generalized", "bathe"])
def test_hundred_thousand_steps(stage, scheme):
    """Dissipation beats the drift: the swing grows smaller, and no energy is gained."""
    outcome = stage("linear_rule", scheme, 1.35e-4, 3.0, end=13.5, seconds=1500, fields="v")
    assert outcome.status == 0 and outcome.rows >= 100001
    with stage.open(outcome) as file:
        tip = file["transient/probes/end"][()]
        kinetic = file["transient/energy/kinetic"][()]
        balance = file["transient/energy/balance"][()]
    assert np.ptp(tip[-1000:]) < 0.97 * np.ptp(tip[:1000])
    assert kinetic[-1000:].max() < kinetic[:1000].max()
    assert balance.max() < 0.02 * kinetic.max()

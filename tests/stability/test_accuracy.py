"""Order 2 of every scheme on a smooth motion of the beam, and steps that choose themselves."""

import numpy as np
import pytest

# Load that comes and goes smoothly, so that no scheme meets a jump; it adds to none of the scene's own.
SMOOTH = "HISTORY smooth formula f=sin(250*t)^4\nDISTRIBUTED from=0 to=L q3=2 history=smooth"
PUSH = "HISTORY push pulse start=1.1111e-3 stop=4.4447e-3\nPOINT x=L f3=2 history=push"
QUIET = {"times": 0.0}


def tip(stage, scheme, step=None, **options):
    """Times and values of the probe."""
    outcome = stage("cantilever_1", scheme, step, 3.0, settings=options.pop("settings", QUIET), **options)
    assert outcome.status == 0, outcome.text[-1000:]
    with stage.open(outcome) as file:
        return file["transient/probes/time"][()], file["transient/probes/end"][()]


@pytest.mark.parametrize(
    "scheme, step",
    [
        ("newmark", 1e-4),
        ("hht", 1e-4),
        ("hht  alpha=-0.3", 1e-4),
        ("generalized", 1e-4),
        ("generalized  rho=0", 1e-4),
        ("generalized  rho=0.5", 1e-4),
        ("bathe", 1e-4),
        ("bathe  rho=0.5", 1e-4),
        ("energy", 1e-4),
        ("central", 1.6e-6),
    ],
)
def test_order_two(stage, scheme, step):
    """Differences between a step, its half and its quarter fall by four: slope of the whole tip history."""
    histories = []
    for halvings in range(3):
        time, values = tip(stage, scheme, step / 2**halvings, end=6e-3, extra=SMOOTH)
        histories.append(values[:: 2**halvings])
        assert time[:: 2**halvings] == pytest.approx(np.linspace(0.0, 6e-3, len(histories[0])), abs=1e-12)
    coarse = np.abs(histories[1] - histories[0]).max()
    fine = np.abs(histories[2] - histories[1]).max()
    assert coarse < 0.05 * np.abs(histories[2]).max()
    assert 1.8 < np.log2(coarse / fine) < 2.3


@pytest.mark.parametrize("scheme", ["newmark", "generalized", "bathe", "energy"])
def test_error_falls_with_accuracy(stage, scheme):
    end = 6e-3
    exact = tip(stage, "bathe  rho=1", 5e-6, end=end, extra=SMOOTH)[1][-1]
    errors, steps = [], []
    for accuracy in (1e-3, 1e-4, 1e-5):
        time, values = tip(stage, scheme, accuracy=accuracy, end=end, extra=SMOOTH)
        errors.append(abs(values[-1] - exact))
        steps.append(len(time))
    assert errors[0] > errors[1] > errors[2]
    # An error per step that falls by ten takes steps shorter by the cube root: the error at the end falls by
    # about 4.6.
    assert errors[2] < errors[0] / 8.0
    assert steps[0] < steps[1] < steps[2] < 60 * steps[0]


@pytest.mark.parametrize("scheme", ["newmark", "hht", "bathe", "energy"])
@pytest.mark.parametrize("steps", [{"step": 3e-4}, {"step": None, "accuracy": 1e-3}])
def test_steps_land_on_load_jumps(stage, scheme, steps):
    time, _ = tip(stage, scheme, extra=PUSH, **steps)
    for jump in (1.1111e-3, 4.4447e-3):
        assert np.abs(time - jump).min() == 0.0
    assert time[-1] == 1.35e-2
    assert np.all(np.diff(time) > 0.0)


@pytest.mark.parametrize(
    "scheme, drift",
    [("newmark", 2e-3), ("hht", 1.5e-2), ("generalized", 5e-3), ("bathe", 1e-2), ("energy", 1e-10)],
)
def test_jump_is_no_error(stage, scheme, drift):
    """A load that jumps between two multiples of the step costs no more energy than the scheme damps."""
    outcome = stage("cantilever_1", scheme, 1e-4, 3.0, settings=QUIET, extra=PUSH)
    assert abs(outcome.drift) < drift


def test_rows_of_fixed_steps_stand_on_multiples(stage):
    time, _ = tip(stage, "newmark", 3e-4, extra=PUSH)
    rest = time[np.abs(time / 3e-4 - np.round(time / 3e-4)) > 1e-9]
    assert rest == pytest.approx([1.1111e-3, 4.4447e-3])


@pytest.mark.parametrize("scheme", ["newmark", "bathe", "energy"])
def test_step_control_does_not_chatter(stage, scheme):
    """Few steps are refused, and a step seldom turns from growing to shrinking by much and back."""
    outcome = stage("cantilever_1", scheme, None, 3.0, accuracy=1e-4, settings=QUIET, extra=SMOOTH)
    with stage.open(outcome) as file:
        steps = np.diff(file["transient/probes/time"][()])
        refused = int(file["transient/solver/cuts"][()].sum())
    assert refused < 0.15 * len(steps)
    growth = np.log(steps[1:-1] / steps[:-2])
    swings = np.sum((growth[1:] * growth[:-1] < 0.0) & (np.abs(growth[1:] - growth[:-1]) > np.log(2.0)))
    assert swings < 0.1 * len(steps)


def test_cut_step_grows_back(stage):
    """Few iterations allowed force cuts under the sudden load; the rows stay on multiples of the step."""
    scheme = "newmark  iterations=5"
    outcome = stage("cantilever_5", scheme, 2.7e-4, 0.5)
    with stage.open(outcome) as file:
        time = file["transient/probes/time"][()]
        cuts = file["transient/solver/cuts"][()]
    assert cuts.sum() > 0
    assert time == pytest.approx(2.7e-4 * np.arange(len(time)), rel=1e-9)


@pytest.mark.parametrize("scheme", ["newmark", "energy"])
def test_drives_pay_for_their_work(stage, scheme):
    """A driven end's work is in the ledger: a shaken cantilever's balance falls with the step squared."""
    shaken = "HISTORY shake formula f=sin(500*t)^2\nPRESCRIBE x=L u3=2 history=shake"
    drifts = []
    for step in (2e-4, 1e-4, 5e-5):
        outcome = stage("cantilever_1", scheme, step, 3.0, settings=QUIET, extra=shaken)
        drifts.append(abs(outcome.drift))
    assert drifts[2] < 2e-4
    assert drifts[2] < drifts[0] / 10.0 or drifts[0] < 1e-10


@pytest.mark.parametrize("scheme", ["newmark", "bathe", "energy"])
def test_damping_is_in_the_ledger(stage, scheme):
    """What damping takes is what is missing, to second order in the step."""
    damped = SMOOTH + "\nDAMPING mass=100 stiffness=2e-6"
    outcome = stage("cantilever_1", scheme, 2.5e-5, 3.0, settings=QUIET, extra=damped)
    with stage.open(outcome) as file:
        dissipated = file["transient/energy/dissipated"][()]
        external = file["transient/energy/external"][()]
    assert np.all(np.diff(dissipated) > -1e-12 * dissipated.max())
    assert dissipated[-1] > 0.05 * np.abs(external).max()
    assert abs(outcome.drift) < 2e-3

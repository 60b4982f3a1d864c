"""`auto` as a user meets it: its estimates against finer runs, what it leaves in the file, how it stops."""

import signal
import subprocess
import time

import h5py
import numpy as np
import pytest
from conftest import SECONDS
from studies import differences

SCENES = {
    "cantilever": """CLAMP x=0
DISTRIBUTED from=0 to=10 q3=2.85
PROBE tip u3 x=10
PROBE turn y1 x=10""",
    "three supports": """PIN x=0
ROLLER x=4
CLAMP x=10
DISTRIBUTED from=0 to=4 q3=-40
POINT x=7 f3=-40
PROBE tip u3 x=7
PROBE turn y1 x=4""",
}
DECK = """GENTBEAM tuned
PARAMETER jm=5 n=10
MATERIAL rubber gent mu=5000 c=2500 jm=jm rho=1e-6
SECTION s rectangle b=1 h=1 {section}
LINE from=0 to=10 elements=n
{scene}
{output}
END
{tasks}
"""
SPINNING = """GENTBEAM spin
PARAMETER omega=300 n=10
MATERIAL rubber gent mu=5000 c=2500 jm=0.5 rho=1e-6
SECTION s rectangle b=1 h=0.5
LINE from=0 to=10 elements=n
INITIAL velocity u3=omega*(x-5)+0.2*omega*sin(3*pi*x/10) y1=-omega
PROBE tip u3 x=10
OUTPUT fields=none
END
TRANSIENT {task} end=0.1
"""
FINEST = "points=5 inertia=full"


def deck(scene, tasks, section="", output=""):
    return DECK.format(scene=SCENES[scene], tasks=tasks, section=section, output=output)


def between(time_rows, values, instants):
    """Values between rows, by the cubic that has their slopes."""
    slopes = np.gradient(values, time_rows, edge_order=2)
    i = np.clip(np.searchsorted(time_rows, instants) - 1, 0, time_rows.size - 2)
    h = time_rows[i + 1] - time_rows[i]
    s = (instants - time_rows[i]) / h
    return (
        (1 + 2 * s) * (1 - s) ** 2 * values[i]
        + s**2 * (3 - 2 * s) * values[i + 1]
        + s * (1 - s) * h * ((1 - s) * slopes[i] - s * slopes[i + 1])
    )


def relative_error(file, truth, command, probe, since=0.0):
    one, other = file[command]["probes"], truth[command]["probes"]
    if file[command].attrs["kind"] == "static":
        return abs(one[probe][-1] - other[probe][-1]) / np.abs(other[probe][()]).max()
    instants = np.linspace(since, other["time"][-1], 2001)[1:]
    expected = between(other["time"][()], other[probe][()], instants)
    found = between(one["time"][()], one[probe][()], instants)
    return np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2))


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("accuracy", [3e-2, 5e-3])
def test_estimates_are_honest(gentbeam, scene, accuracy):
    gentbeam("-o", "tuned", deck=deck(scene, f"TRANSIENT auto accuracy={accuracy} probe=tip end=8e-3"))
    gentbeam("-q", "-o", "truth", "--set", "n=60",
             deck=deck(scene, f"TRANSIENT newmark step={2e-5 * accuracy} end=8e-3", FINEST))  # fmt: skip
    with gentbeam.results("tuned") as file, gentbeam.results("truth") as truth:
        estimate = file["tuning"].attrs["estimate"]
        assert estimate <= accuracy
        assert 0.1 < relative_error(file, truth, "transient", "tip") / estimate < 2


@pytest.mark.parametrize("scene", SCENES)
def test_static_estimates_are_honest(gentbeam, scene):
    gentbeam("-q", "-o", "tuned", deck=deck(scene, "STATIC auto accuracy=1e-4 probe=[tip turn]"))
    gentbeam("-q", "-o", "truth", "--set", "n=400", deck=deck(scene, "STATIC steps=4", FINEST))
    with gentbeam.results("tuned") as file, gentbeam.results("truth") as truth:
        estimate = file["tuning"].attrs["estimate"]
        errors = [relative_error(file, truth, "static", probe) for probe in ("tip", "turn")]
        assert estimate <= 1e-4
        assert 0.1 < max(errors) / estimate < 2


def test_every_rung_is_in_the_file(gentbeam):
    tasks = "TRANSIENT auto accuracy=1e-2 probe=tip end=8e-3"
    out = gentbeam("-o", "tuned", deck=deck("cantilever", tasks)).out
    with gentbeam.results("tuned") as file:
        tuning = file["tuning"]
        rungs = tuning["rungs"]
        n = rungs["elements"].size
        assert n >= 5 and all(item.size == n for name, item in rungs.items() if name != "source")
        sources = rungs["source"][()].decode().split()
        assert len(sources) == n and {"footing", "mesh", "time", "thickness", "inertia"} == set(sources)
        assert (rungs["work"][()] > 0).all() and (rungs["cpu_seconds"][()] >= 0).all()
        compared = rungs["compared_with"][()]
        assert (compared < np.arange(1, n + 1)).all() and (compared[1:] > 0).any()
        assert tuning.attrs["elements"] == file["mesh/elements"].shape[0]
        assert file["transient"].attrs["dt"] == 8e-3 / tuning.attrs["steps"]
        parts = [tuning.attrs[f"error_{name}"] for name in ("mesh", "time", "thickness", "inertia")]
        assert 0 < tuning.attrs["estimate"] <= sum(parts) * 1.1
        absolute, relative = tuning["error_bars/transient.tip"][()]
        size = np.sqrt(np.mean(file["transient/probes/tip"][()] ** 2))
        assert relative == pytest.approx(tuning.attrs["estimate"])
        assert absolute == pytest.approx(relative * size, rel=0.05)
    assert "left out: inertia=full" in out and "error bar" in out


def test_a_chosen_setting_written_by_hand_is_the_same_run(gentbeam):
    gentbeam("-q", "-o", "tuned", deck=deck("cantilever", "TRANSIENT auto accuracy=1e-2 probe=tip end=8e-3"))
    with gentbeam.results("tuned") as file:
        chosen, group = file["tuning"].attrs, file["transient"].attrs
        section = f"points={chosen['points']} inertia={chosen['inertia']}"
        steps = f"step={float(group['dt'])!r} end=8e-3 tolerance={float(group['tolerance'])!r}"
        text = deck("cantilever", f"TRANSIENT {chosen['scheme']} {steps}", section)
        gentbeam("-q", "-o", "hand", "--set", f"n={chosen['elements']}", deck=text)
        with gentbeam.results("hand") as hand:
            assert not differences(file["transient"], hand["transient"])


def test_commands_around_it(gentbeam):
    """A preload and a motion of their own accuracy, and plain commands: one mesh serves all."""
    tasks = """STATIC auto accuracy=1e-3 probe=tip load=0.5 name=preload
MODAL count=2
TRANSIENT auto accuracy=2e-2 probe=[tip turn] end=4e-3 name=motion
TRANSIENT bathe step=1e-4 end=1e-3"""
    gentbeam("-q", "-o", "tuned", deck=deck("cantilever", tasks))
    gentbeam("-q", "-o", "truth", "--set", "n=40", deck=deck("cantilever", """STATIC load=0.5 name=preload
TRANSIENT newmark step=4e-7 end=4e-3 name=motion""", FINEST))  # fmt: skip
    with gentbeam.results("tuned") as file, gentbeam.results("truth") as truth:
        assert sorted(file["tuning/error_bars"]) == ["motion.tip", "motion.turn", "preload.tip"]
        assert file["preload"].attrs["load"] == 0.5 and file["transient"].attrs["scheme"] == "bathe"
        assert relative_error(file, truth, "preload", "tip") < 1e-3
        assert relative_error(file, truth, "motion", "turn") < 2e-2
        assert file["motion/probes/tip"][0] == file["preload/probes/tip"][-1]


def test_newmark_gives_way(gentbeam):
    """A beam that spins fast in free flight: Newmark's rule comes to no end, the scheme that damps does, and
    its estimate holds against the scheme that conserves energy and momentum."""
    gentbeam("-o", "tuned", deck=SPINNING.format(task="auto accuracy=5e-3 probe=tip"))
    task = "energy step=2.5e-5"
    gentbeam("-q", "-o", "truth", "--set", "n=16", deck=SPINNING.format(task=task))
    with gentbeam.results("tuned") as file, gentbeam.results("truth") as truth:
        assert file["tuning"].attrs["scheme"] == "bathe"
        assert file["transient"].attrs["scheme"] == "bathe"
        assert file["tuning/rungs/failed"][()].any()
        estimate = file["tuning"].attrs["estimate"]
        assert 0.1 < relative_error(file, truth, "transient", "tip") / estimate < 2


LATE = """CLAMP x=0
GRAVITY g1=100
HISTORY knock pulse start=0.4 stop=0.401
POINT x=10 f3=10 history=knock
PROBE tip u3 x=10"""


def test_steps_are_adaptive_where_that_pays(gentbeam):
    """Next to nothing for long, then a knock: few steps for the first, and in all as many as promised."""
    tasks = "TRANSIENT auto accuracy=2e-2 probe=tip end=0.42"
    tuned = DECK.format(scene=LATE, section="", output="", tasks=tasks)
    out = gentbeam("-o", "tuned", deck=tuned).out
    truth = DECK.format(scene=LATE, section=FINEST, output="", tasks="TRANSIENT newmark step=4e-6 end=0.42")
    gentbeam("-q", "-o", "truth", "--set", "n=24", deck=truth)
    with gentbeam.results("tuned") as file, gentbeam.results("truth") as truth:
        assert file["transient"].attrs["accuracy"] == file["tuning"].attrs["local_accuracy"]
        estimate = file["tuning"].attrs["estimate"]
        assert 0.1 < relative_error(file, truth, "transient", "tip", 0.4) / estimate < 2
        assert (file["transient/time"][()] < 0.3999).sum() < 0.2 * file["transient/time"].size
        assert 0.7 < file["transient/time"].size / file["tuning"].attrs["steps"] < 1.4
    assert "adaptive with accuracy" in out


def test_given_inertia_is_kept(gentbeam):
    """The error is that of the inertia that the deck gives then; left open, this scene needs the full one."""
    tasks = "TRANSIENT auto accuracy=5e-3 probe=tip end=8e-3"
    for given in ("", "inertia=diagonal", "inertia=translational"):
        gentbeam("-q", "-o", "tuned", deck=deck("three supports", tasks, given))
        with gentbeam.results("tuned") as file:
            chosen = file["tuning"].attrs["inertia"]
            assert chosen == (given.partition("=")[2] or "full")
            assert (3 in file["tuning/rungs/inertia"][()]) == (given == "")
            if given != "inertia=diagonal":
                continue
            gentbeam("-q", "-o", "truth", "--set", "n=60",
                     deck=deck("three supports", "TRANSIENT newmark step=1e-7 end=8e-3", given))  # fmt: skip
            with gentbeam.results("truth") as truth:
                estimate = file["tuning"].attrs["estimate"]
                assert 0.1 < relative_error(file, truth, "transient", "tip") / estimate < 2


def test_probes_at_rest(gentbeam):
    tasks = "TRANSIENT auto accuracy=1e-2 probe=wall end=1e-3"
    gentbeam("-q", "-o", "tuned", deck=deck("cantilever", tasks, output="PROBE wall u3 x=0"))
    with gentbeam.results("tuned") as file:
        assert file["tuning"].attrs["estimate"] == 0 and not file["transient/probes/wall"][()].any()


def test_restart_makes_the_same_choice(gentbeam):
    tasks = "TRANSIENT auto accuracy=5e-3 probe=tip end=4e-2"
    whole = deck("cantilever", tasks)
    (gentbeam.folder / "beam.inp").write_text(whole.replace("TRANSIENT", "CHECKPOINT every=100\nTRANSIENT"))
    gentbeam("-q", "-o", "part", "beam.inp")
    with gentbeam.results("part") as file, h5py.File(gentbeam.folder / "whole.h5", "w") as copy:
        file.copy("transient", copy)
    gentbeam("-q", "-o", "part", "--restart", "part.chk.h5", "beam.inp")
    with gentbeam.results("part") as file, h5py.File(gentbeam.folder / "whole.h5") as copy:
        assert not differences(file["transient"], copy["transient"])


def test_stopped_while_it_chooses(gentbeam):
    (gentbeam.folder / "beam.inp").write_text(
        deck("cantilever", "TRANSIENT auto accuracy=1e-3 probe=acc end=2e-2", output="PROBE acc a3 x=10")
    )
    with subprocess.Popen([gentbeam.executable, "beam.inp"], cwd=gentbeam.folder, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:  # fmt: skip
        while "footing" not in run.stdout.readline() and run.poll() is None:
            if "rung" in run.stdout.readline():
                break
        time.sleep(0.3)
        run.send_signal(signal.SIGTERM)
        _, words = run.communicate(timeout=SECONDS)
    assert run.returncode == 4 and "SIGTERM: stopped while choosing a model" in words
    assert not (gentbeam.folder / "beam.h5").exists()


@pytest.mark.parametrize(
    "section, tasks",
    [
        ("", "TRANSIENT auto accuracy=1e-3 probe=acc end=2e-2"),
        ("rule=auto", "TRANSIENT newmark step=1e-8 end=2e-2"),
    ],
)
def test_time_limit_counts_the_choice(gentbeam, section, tasks):
    text = deck("cantilever", tasks, section, output="PROBE acc a3 x=10")
    (gentbeam.folder / "beam.inp").write_text(text)
    err = gentbeam("-q", "--max-time", 0.3, "beam.inp", status=4).err
    assert "--max-time: stopped while choosing a model" in err
    assert not (gentbeam.folder / "beam.h5").exists()


def test_out_of_reach(gentbeam):
    """A probe that the scene does not determine: no estimate, no results, and words that say what to do."""
    tasks = "STATIC auto accuracy=1e-15 probe=tip"
    err = gentbeam("-q", "-o", "tuned", deck=deck("cantilever", tasks), status=2).err
    assert "auto: " in err and not (gentbeam.folder / "tuned.h5").exists()


def test_rule_auto(gentbeam):
    """Points that strains need, and answers that agree with many points everywhere."""
    tasks = "STATIC steps=5\nTRANSIENT newmark step=2e-4 end=4e-3"
    for section, name in (("rule=auto tolerance=1e-5", "auto"), ("points=10", "many"), ("points=3", "few")):
        gentbeam("-q", "-o", name, "--set", "jm=0.4",
                 deck=deck("cantilever", tasks, section, output="DAMPING stiffness=1e-12"))  # fmt: skip
    with gentbeam.results("auto") as auto, gentbeam.results("many") as many, gentbeam.results("few") as few:
        points = auto["mesh/points"][()]
        assert points.size == 10 and points[0] > 4 and points[-1] == 3
        error = relative_error(auto, many, "static", "tip")
        assert error < 1e-5 and error < 0.1 * relative_error(few, many, "static", "tip")
        assert relative_error(auto, many, "transient", "tip") < 1e-4
        assert "points" not in few["mesh"]


def test_rule_auto_in_a_study(gentbeam):
    """Every member has its own points, and is what a run of it alone gives."""
    tasks = "STATIC steps=5\nTRANSIENT newmark step=2e-4 end=4e-3"
    text = deck("cantilever", tasks, "rule=auto tolerance=1e-5", output="DAMPING stiffness=1e-12")
    gentbeam("-q", "-o", "study", "--threads", 2,
             deck=text.replace("MATERIAL", "SWEEP jm=[0.4 5]\nMATERIAL"))  # fmt: skip
    for number, jm in enumerate(("0.4", "5"), 1):
        gentbeam("-q", "-o", f"alone{number}", "--set", f"jm={jm}", deck=text)
        with gentbeam.results("study") as study, gentbeam.results(f"alone{number}") as alone:
            found = study[f"sweep/members/{number:06d}/transient/probes/tip"][()]
            assert (found == alone["transient/probes/tip"][()]).all()

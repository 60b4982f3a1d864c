"""Studies under Slurm: an array is submitted by one line, tasks are stopped and killed and go on, and the
merged file is the same as that of one process."""

import subprocess
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from studies import same_file, study

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts" / "slurm"
SHARDS = 3
MEMBERS = 24
# So long a shard takes that it can be caught at work, longer than what it has finished waits for the file.
SECONDS_A_SHARD = 5.0
STEP = 2e-5


def deck(steps):
    values = " ".join(str(11000 + 100 * i) for i in range(MEMBERS))
    return study(
        f"SWEEP E=[{values}]",
        f"TRANSIENT newmark step={STEP} end={steps * STEP}",
        "OUTPUT every=100",
        elements=4,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory, executable):
    """A folder with a study that takes as long as wanted, and its results from one process."""
    place = tmp_path_factory.mktemp("study")

    def run(steps):
        (place / "study.inp").write_text(deck(steps))
        subprocess.run([executable, "-q", "--threads", "2", "-o", "one", "study.inp"], cwd=place, check=True)
        with h5py.File(place / "one.h5") as file:
            return file.attrs["cpu_seconds"]

    run(int(1000 * SHARDS * SECONDS_A_SHARD / run(1000)))
    return place


def finished(path):
    """Members that a shard's file counts as finished."""
    try:
        with h5py.File(path, "r") as file:
            return int(np.count_nonzero(file["sweep/status"][:]))
    except (OSError, KeyError):
        return 0


def submit(cluster, executable, folder, *arguments):
    """Numbers of the array's tasks and of the joining job."""
    said = cluster.run(
        SCRIPTS / "submit",
        "--shards",
        SHARDS,
        "--time=10",
        *arguments,
        "study.inp",
        cwd=folder,
        env={"GENTBEAM": executable},
    )
    words = said.replace(",", "").split()
    return words[words.index("array") + 1], words[words.index("merge") + 1]


def let_start(cluster, task):
    """A job that was requeued waits for two minutes otherwise. One that comes back within a second of its end
    slurmd takes for the one that has ended."""
    cluster.wait_for(lambda: cluster.state(task) == "PENDING", f"{task} in the queue")
    time.sleep(3)
    cluster.run("scontrol", "update", f"JobId={task}", "StartTime=now", check=False)


def end_of(cluster, job):
    cluster.wait_for(
        lambda: cluster.state(job) in ("COMPLETED", "FAILED", "CANCELLED", "NODE_FAIL", "TIMEOUT"),
        f"job {job}",
        240,
    )
    return cluster.state(job)


def test_stopped_and_killed_tasks_go_on(cluster, executable, folder):
    array, merge = submit(cluster, executable, folder, "-o", "many")
    shard = {i: folder / f"many.shard-{i}-of-{SHARDS}.h5" for i in (1, 2)}
    for i, path in shard.items():
        cluster.wait_for(lambda path=path: finished(path) >= 1, f"the first members of shard {i}")
    # What Slurm does a minute before the end of the time, and what a node that fails does.
    cluster.run("scancel", "--signal=USR1", "--batch", f"{array}_1")
    cluster.run("scontrol", "requeue", f"{array}_2")
    for i in (1, 2):
        let_start(cluster, f"{array}_{i}")
    assert end_of(cluster, merge) == "COMPLETED", cluster.logs()
    log = {i: (folder / f"many.shard-{i}-of-{SHARDS}.log").read_text() for i in (1, 2)}
    assert "goes back into the queue" in log[1] and "goes back" not in log[2]
    for i in (1, 2):
        assert "were finished by an earlier run" in log[i], log[i]
        assert int(cluster.job(f"{array}_{i}", "Restarts")) == 1
    assert "24 of 24 members complete, 0 failed" in (folder / "many.merge.log").read_text()
    same_file(folder / "one.h5", folder / "many.h5")


def test_a_cancelled_task_does_not_come_back(cluster, executable, folder):
    array, merge = submit(cluster, executable, folder, "-o", "cancelled")
    cluster.wait_for(lambda: finished(folder / f"cancelled.shard-1-of-{SHARDS}.h5") >= 1, "the first member")
    cluster.run("scancel", f"{array}_1")
    assert end_of(cluster, f"{array}_1") == "CANCELLED"
    # The shards that are left are joined, and the members of the first are told as missing.
    assert end_of(cluster, merge) == "FAILED"
    log = (folder / "cancelled.merge.log").read_text()
    assert "members missing in cancelled.h5:" in log
    assert cluster.state(f"{array}_1") == "CANCELLED"


@pytest.fixture(scope="module")
def short(tmp_path_factory, executable):
    """The same for a short study."""
    place = tmp_path_factory.mktemp("short")
    (place / "study.inp").write_text(deck(20))
    subprocess.run([executable, "-q", "-o", "one", "study.inp"], cwd=place, check=True)
    return place


def merge(executable, folder, name, shards):
    names = [f"{name}.shard-{i}-of-{shards}.h5" for i in range(1, shards + 1)]
    assert sorted(path.name for path in folder.glob(f"{name}.shard-*.h5")) == names
    subprocess.run([executable, "-q", "--merge", f"{name}.h5", *names], cwd=folder, check=True)
    same_file(folder / "one.h5", folder / f"{name}.h5")


def test_srun_runs_shards(cluster, executable, short):
    cluster.run(
        "srun",
        "--ntasks=2",
        "--overcommit",
        executable,
        "-q",
        "--shard",
        "auto",
        "-o",
        "srun",
        "study.inp",
        cwd=short,
    )
    merge(executable, short, "srun", 2)


def test_auto_in_an_array(cluster, executable, short):
    job = cluster.run(
        "sbatch",
        "--parsable",
        "--array=4-10:3",
        "--output=/dev/null",
        f"--wrap={executable} -q --shard auto -o auto study.inp",
        cwd=short,
    ).strip()
    for task in (4, 7, 10):
        assert end_of(cluster, f"{job}_{task}") == "COMPLETED", cluster.logs()
    merge(executable, short, "auto", 3)


def test_auto_of_steps_in_an_array(cluster, executable, short):
    """The ranks of a step times the tasks of the array."""
    job = cluster.run(
        "sbatch",
        "--parsable",
        "--array=1-2",
        "--ntasks=2",
        "--overcommit",
        "--output=/dev/null",
        f"--wrap=srun --overcommit {executable} -q --shard auto -o both study.inp",
        cwd=short,
    ).strip()
    for task in (1, 2):
        assert end_of(cluster, f"{job}_{task}") == "COMPLETED", cluster.logs()
    merge(executable, short, "both", 4)


def test_what_cannot_be_submitted(cluster, executable, folder):
    (folder / "bad.inp").write_text(deck(10).replace("E=12000", "E=0"))
    said = cluster.run(
        SCRIPTS / "submit", "--shards", 2, "bad.inp", cwd=folder, env={"GENTBEAM": executable}, check=False
    )
    assert "bad.inp:5:" in said and "array" not in said
    said = cluster.run(SCRIPTS / "submit", "study.inp", cwd=folder, env={"GENTBEAM": executable}, check=False)
    assert "--shards needs a whole number" in said

"""--shard auto: rank and size from whoever started the process, and the launchers themselves where they
are."""

import os
import shutil

import pytest
from studies import same_file, study

SWEEP = "SWEEP E=[%s]" % " ".join(str(11000 + 100 * i) for i in range(10))
ARRAY = (
    "SLURM_ARRAY_TASK_ID",
    "SLURM_ARRAY_TASK_COUNT",
    "SLURM_ARRAY_TASK_MIN",
    "SLURM_ARRAY_TASK_MAX",
    "SLURM_ARRAY_TASK_STEP",
)


def array(*values):
    return dict(zip(ARRAY, map(str, values)))


ENVIRONMENTS = {
    "Open MPI": ({"OMPI_COMM_WORLD_RANK": "2", "OMPI_COMM_WORLD_SIZE": "5"}, "3-of-5"),
    "MPICH": ({"PMI_RANK": "0", "PMI_SIZE": "4"}, "1-of-4"),
    "srun": ({"SLURM_PROCID": "3", "SLURM_STEP_NUM_TASKS": "4", "SLURM_NTASKS": "8"}, "4-of-4"),
    "MPICH below srun": (
        {"PMI_RANK": "1", "PMI_SIZE": "2", "SLURM_PROCID": "0", "SLURM_STEP_NUM_TASKS": "1"},
        "2-of-2",
    ),
    "an array": (array(7, 3, 5, 9, 2), "2-of-3"),
    "an array from 0": (array(0, 4, 0, 3, 1), "1-of-4"),
    "ranks in an array": (
        {**array(2, 2, 1, 2, 1), "SLURM_PROCID": "1", "SLURM_STEP_NUM_TASKS": "3"},
        "5-of-6",
    ),
    "a batch script, not a step": (
        {**array(2, 2, 1, 2, 1), "SLURM_PROCID": "0", "SLURM_NTASKS": "4"},
        "2-of-2",
    ),
}


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_environments(gentbeam, name):
    environment, shard = ENVIRONMENTS[name]
    gentbeam("-q", "--shard", "auto", deck=study(SWEEP), environment=environment)
    assert os.listdir(gentbeam.folder) == [f"gentbeam.shard-{shard}.h5"]


def test_no_environment(gentbeam):
    gentbeam("--shard", "auto", deck=study(SWEEP), status=1)
    assert "finds no rank and size in the environment of Open MPI, MPICH or Slurm" in gentbeam.err
    gentbeam("--shard", "auto", deck=study(SWEEP), status=1, environment={"PMI_RANK": "4", "PMI_SIZE": "4"})
    assert "PMI_RANK and PMI_SIZE do not go together" in gentbeam.err
    gentbeam(
        "--shard",
        "auto",
        deck=study(SWEEP),
        status=1,
        environment=array(3, 1, 3, 3, 1) | array(3, 2, 1, 9, 1),
    )
    assert "cannot tell the shards of a job array with gaps apart" in gentbeam.err


def test_one_rank_is_the_whole(gentbeam):
    gentbeam("-q", "--shard", "auto", deck=study(SWEEP), environment={"PMI_RANK": "0", "PMI_SIZE": "1"})
    assert os.listdir(gentbeam.folder) == ["gentbeam.h5"]


def need(program):
    if shutil.which(program):
        return
    if os.environ.get("CI"):
        pytest.fail(f"{program} is not installed")
    pytest.skip(f"{program} is not installed")


def check_shards(gentbeam, shards):
    names = [f"study.shard-{i}-of-{shards}.h5" for i in range(1, shards + 1)]
    assert sorted(path.name for path in gentbeam.folder.glob("study.shard-*")) == names
    gentbeam("-q", "-o", "whole", "study.inp")
    gentbeam("-q", "--merge", "joined", *names)
    same_file(gentbeam.path("whole"), gentbeam.path("joined"))


def test_mpirun(gentbeam):
    need("mpirun")
    (gentbeam.folder / "study.inp").write_text(study(SWEEP))
    gentbeam(
        "-q",
        "--shard",
        "auto",
        "study.inp",
        before=("mpirun", "-n", "3"),
        environment={
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "OMPI_MCA_rmaps_base_oversubscribe": "1",
            "OMPI_MCA_plm_rsh_agent": "/bin/true",
            "HOME": str(gentbeam.folder),
        },
    )
    check_shards(gentbeam, 3)


def test_gnu_parallel(gentbeam):
    need("parallel")
    (gentbeam.folder / "study.inp").write_text(study(SWEEP))
    gentbeam(
        "-q",
        "--shard",
        "{}/4",
        "study.inp",
        ":::",
        "1",
        "2",
        "3",
        "4",
        before=("parallel", "--will-cite", "--jobs", "2"),
        environment={"HOME": str(gentbeam.folder)},
    )
    check_shards(gentbeam, 4)

"""SWEEP: which members there are, what each of them tells, and that threads do not matter."""

import re
import subprocess
import sys

import h5py
import numpy as np
import pytest
from sanitized import not_sanitized
from studies import CROSSED, SHORT, differences, far_apart, same_file, study

ALL = SHORT + "\nSTATIC steps=2\nMODAL count=2\nTRANSIENT bathe accuracy=1e-2 end=2e-3"


def test_lists_cross_and_the_last_varies_fastest(gentbeam):
    gentbeam("--threads", 2, deck=study())
    with gentbeam.results() as file:
        sweep = file["sweep"]
        assert list(sweep["parameters"].attrs["names"]) == ["E", "jm"]
        expected = [[e, jm] for e in (11000, 12000, 13000) for jm in (1, 2, 5, 1e20)]
        assert sweep["parameters"][:].tolist() == expected
        assert sweep["number"][:].tolist() == list(range(1, 13))
        assert sweep["status"][:].tolist() == [1] * 12 and not any(sweep["message"][:])
        assert list(sweep["members"]) == [f"{i:06d}" for i in range(1, 13)]
        assert dict(sweep.attrs) == {"members": 12, "shard": 1, "shards": 1}
        assert file.attrs["status"] == "complete"
    assert gentbeam.last_line().endswith("12 of 12 members complete, 0 failed")


def test_a_table_varies_parameters_together(gentbeam):
    (gentbeam.folder / "table.csv").write_text("# two\njm;E\n\n1.5;11000\n! none\n2.5, 1d4\n3\t12000\r\n")
    gentbeam(deck=study('SWEEP file="table.csv"\nSWEEP nu=[0.2 1/4]'))
    with gentbeam.results() as file:
        expected = [[jm, e, nu] for jm, e in ((1.5, 11000), (2.5, 1e4), (3, 12000)) for nu in (0.2, 0.25)]
        assert file["sweep/parameters"][:].tolist() == expected
        assert list(file["sweep/parameters"].attrs["names"]) == ["jm", "E", "nu"]


@pytest.mark.parametrize("output", ["OUTPUT fields=[u v a] every=3", "OUTPUT fields=none", ""])
def test_threads_do_not_matter(gentbeam, output):
    deck = study(solution=ALL, output=output).replace("{sweep}", CROSSED)
    for threads in (1, 2, 5):
        gentbeam("--threads", threads, "-o", f"t{threads}", deck=deck)
    same_file(gentbeam.path("t1"), gentbeam.path("t2"))
    same_file(gentbeam.path("t1"), gentbeam.path("t5"))


@pytest.mark.parametrize("solver", ["solver=lapack", ""])
def test_a_member_is_what_a_run_of_it_alone_gives(gentbeam, solver):
    """Bit for bit where both go the same way; members in lanes to what Newton's tolerance leaves open."""
    output = "OUTPUT fields=[u v a] every=2"
    solution = ALL.replace(SHORT, f"{SHORT} {solver}")
    gentbeam("--threads", 2, deck=study(solution=solution, output=output))
    alone = study("", solution, output)
    for number, values in ((1, (11000, 1)), (7, (12000, 5)), (12, (13000, 1e20))):
        gentbeam("-o", "alone", "--set", f"E={values[0]}", "--set", f"jm={values[1]}", deck=alone)
        with gentbeam.results() as all_, gentbeam.results("alone") as one:
            member = all_[f"sweep/members/{number:06d}"]
            for name in ("transient", "static", "modal", "transient_2"):
                assert dict(member[name].attrs) == dict(one[name].attrs)
                if solver:
                    assert not differences(member[name], one[name], name)
                else:
                    assert not far_apart(member[name], one[name], name)
            if not solver:
                continue
            tip = one["transient_2/probes/tip"][:]
            summary = {
                name: all_[f"sweep/summary/tip_{name}"][number - 1] for name in ("max", "min", "time_of_max")
            }
            assert summary == {
                "max": tip.max(),
                "min": tip.min(),
                "time_of_max": one["transient_2/probes/time"][tip.argmax()],
            }
            assert (all_["sweep/summary/modal_frequency"][number - 1] == one["modal/frequency"][:]).all()


def test_members_that_need_cuts_go_by_themselves(gentbeam):
    """Lanes take whole steps only. What they give up is, bit for bit, what a run of it alone gives."""
    output, limits = "OUTPUT fields=[u v a]", (0.02, 0.05, 0.5, 1)
    sweep = "SWEEP jm=[%s]" % " ".join(map(str, limits))
    gentbeam("--threads", 2, deck=study(sweep, SHORT, output).replace("2.85", "20"))
    alone = study("", SHORT, output).replace("2.85", "20")
    cuts = []
    for number, limit in enumerate(limits, 1):
        gentbeam("-o", "alone", "--set", f"jm={limit}", deck=alone)
        with gentbeam.results() as all_, gentbeam.results("alone") as one:
            member = all_[f"sweep/members/{number:06d}/transient"]
            cuts.append(int(one["transient/solver/cuts"][:].sum()))
            if cuts[-1]:
                assert not differences(member, one["transient"])
            else:
                assert not far_apart(member, one["transient"])
    assert all(cuts[:2]) and not any(cuts[2:])


def test_summary_of_statics_and_units(gentbeam):
    gentbeam(deck=study(solution="STATIC steps=4"))
    with gentbeam.results() as file:
        summary = file["sweep/summary"]
        assert sorted(summary) == sorted(
            f"{p}_{n}" for p in ("tip", "tip_u1") for n in ("max", "min", "time_of_max")
        )
        assert summary["tip_max"].attrs["unit"] == "in" and summary["tip_time_of_max"].attrs["unit"] == ""
        assert (summary["tip_time_of_max"][:] == 1).all()
        assert (np.diff(summary["tip_max"][::4]) < 0).all()


def test_members_of_other_meshes_have_their_own(gentbeam):
    gentbeam(deck=study("SWEEP n=[2 3 4]"))
    with gentbeam.results() as file:
        members = file["sweep/members"]
        assert ["mesh" in members[name] for name in members] == [True, False, True]
        assert members["000003/mesh/x"].shape == (9,) and members["000003/transient/u"].shape[1:] == (9, 5)


def test_failures_are_told_and_the_others_go_on(gentbeam):
    sweep = "SWEEP E=[12000 -1 12500]\nSWEEP jm=[1 1e-7]"
    gentbeam("--threads", 2, deck=study(sweep, "TRANSIENT newmark step=5e-3 end=1e-2 iterations=12 cuts=0"))
    with gentbeam.results() as file:
        status, message = file["sweep/status"][:], [text.decode() for text in file["sweep/message"][:]]
        assert status.tolist() == [1, 2, 2, 2, 1, 2]
        assert all((text == "") == (one == 1) for one, text in zip(status, message))
        assert message[2] == "<stdin>:6:31: error: 'mu' must be above 0, and is -0.416666666667"
        assert message[1].startswith("TRANSIENT: step 1 failed from t = 0")
        assert (file["sweep/summary/tip_max"][:] == 0).tolist() == (status == 2).tolist()
        failed = file["sweep/members/000002"]
        assert failed.attrs["status"] == "failed" and failed.attrs["message"] == message[1]
        assert file["sweep/members/000003"].attrs["message"] == message[2] and not len(
            file["sweep/members/000003"]
        )
        assert file.attrs["status"] == "complete"
    assert gentbeam.last_line().endswith("2 of 6 members complete, 4 failed")
    assert "  member 3 (E = -1, jm = 1) failed: <stdin>:6:31: error: 'mu'" in gentbeam.out


def test_all_failed(gentbeam):
    gentbeam(deck=study("SWEEP E=[-1 -2 -3]"), status=2)
    assert gentbeam.last_line().endswith("0 of 3 members complete, 3 failed")
    first = "member 1 (E = -1): <stdin>:5:31: error:"
    assert gentbeam.err.startswith(f"gentbeam: error: all members failed; {first}")
    with gentbeam.results() as file:
        assert file.attrs["status"] == "failed" and file["sweep/status"][:].tolist() == [2, 2, 2]


def test_the_log_tells_pace_and_time_left(gentbeam):
    gentbeam(
        deck=study("SWEEP E=[%s]" % " ".join(str(11000 + i) for i in range(40)), output="OUTPUT fields=none")
    )
    lines = gentbeam.out.splitlines()
    start = lines.index("     members      failed   members/s   time left") + 1
    rows = [
        re.fullmatch(r" +(\d+) +(\d+) +([\d.e]+) +([\d.]+ (?:s|min|h))", line) for line in lines[start:-2]
    ]
    assert all(rows) and [int(row[1]) for row in rows] == list(range(4, 41, 4))
    assert rows[-1][4] == "0 s"
    assert "  sweep: 40 members of 40 E" in lines


def test_the_environment_gives_the_number_of_threads(gentbeam):
    for environment, arguments, expected in (
        ({}, (), 1),
        ({"OMP_NUM_THREADS": "3,2"}, (), 3),
        ({"OMP_NUM_THREADS": "3"}, ("--threads", 2), 2),
    ):
        gentbeam(*arguments, deck=study(), environment=environment)
        assert f"  threads: {expected}\n" in gentbeam.out


def test_check_runs_nothing(gentbeam):
    gentbeam("--check", deck=study())
    assert not list(gentbeam.folder.glob("*.h5"))


def many(count):
    """A study of next to nothing, whose members cost little."""
    return study(f'SWEEP file="rows{count}.txt"', "STATIC steps=1", "OUTPUT fields=none", elements=1)


def write_rows(folder, count):
    rows = "".join(f"{11000 + i / 10}\n" for i in range(count))
    (folder / f"rows{count}.txt").write_text("E\n" + rows)


PEAK = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def peak_memory(gentbeam, count):
    """Largest memory of a study [MB]."""
    write_rows(gentbeam.folder, count)
    (gentbeam.folder / "many.inp").write_text(many(count))
    said = subprocess.run(
        [
            sys.executable,
            "-c",
            PEAK,
            gentbeam.executable,
            "-q",
            "--threads",
            "2",
            "-o",
            f"many{count}",
            "many.inp",
        ],
        cwd=gentbeam.folder,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    with h5py.File(gentbeam.path(f"many{count}")) as file:
        assert (file["sweep/status"][:] == 1).all() and len(file["sweep/number"]) == count
        assert "members" not in file["sweep"]
    return int(said) / 1024


@not_sanitized
def test_memory_does_not_grow_with_the_members(gentbeam):
    few, more = peak_memory(gentbeam, 2000), peak_memory(gentbeam, 50000)
    # The table itself is kept. A million rows, 21 times as many as these, must stay below 200 MB. Memory
    # comes in pages of up to 2 MB, which is why the difference of fewer rows would tell nothing.
    assert more - few < 4


@not_sanitized
def test_two_threads_do_not_stand_in_each_others_way(gentbeam):
    """What keeps two threads from halving the time: work that only one of them does, and waiting. The
    processor time of all threads together must not grow, and a thread must hardly ever sleep. What else the
    machine does can only add to both: the least of several runs is looked at, and more of them if need be."""
    members = 400
    sweep = "SWEEP E=[%s]" % " ".join(str(11000 + i) for i in range(members))
    deck = study(sweep, "TRANSIENT newmark step=1.35e-4 end=1.35e-2", "OUTPUT fields=none", elements=10)
    cpu, waits = {1: [], 2: []}, {1: [], 2: []}
    for attempt in range(10):
        for threads in (1, 2):
            gentbeam("-q", "--threads", threads, deck=deck)
            cpu[threads].append(gentbeam.cpu)
            waits[threads].append(gentbeam.waits)
        if attempt > 1 and min(cpu[2]) < 1.15 * min(cpu[1]) and min(waits[2]) < members / 10:
            break
    assert min(cpu[2]) < 1.15 * min(cpu[1]), cpu
    assert min(waits[2]) < members / 10, waits


def test_many_failures_at_once(gentbeam):
    """Threads write their reasons side by side; every one must come out whole."""
    sweep = "SWEEP jm=[%s]\nSWEEP E=[%s]" % (
        " ".join(f"{i}e-7" for i in range(1, 41)),
        " ".join(str(e) for e in (-3, -2, 11000, 12000, -1)),
    )
    deck = study(sweep, "TRANSIENT newmark step=5e-3 end=1e-2 iterations=12 cuts=0", "OUTPUT fields=none")
    gentbeam("-q", "-o", "t1", deck=deck, status=2)
    with gentbeam.results("t1") as file:
        messages = file["sweep/message"][:].tolist()
    assert len(set(messages)) > 80
    for _ in range(5):
        gentbeam("-q", "--threads", 8, "-o", "t8", deck=deck, status=2)
        with gentbeam.results("t8") as file:
            assert file["sweep/message"][:].tolist() == messages

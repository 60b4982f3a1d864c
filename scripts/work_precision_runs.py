"""Measures runs: CPU time of the stepping and of the whole process, the least of several rounds.

T is the CPU time a program spends in its run: gentbeam's attribute cpu_seconds, a library's calls that
step, and for CalculiX the process. From T(n) of n steps and T(1) of the first step alone, the solve
loop's time is (T(n) - T(1)) n / (n - 1): what is done once, as opening a file or counting unknowns, is
left out for all alike.
"""

import json
import os
import shutil
import signal
import subprocess
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Optional

import h5py
import numpy as np

import peer_calculix
from gentbeam_results import open_results, text
from gentbeam_runs import program
from work_precision_scene import History

SCRIPTS = Path(__file__).resolve().parent
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
# Times of processes differ by so much from run to run, the least of several too [s].
NOISE = 5e-5
# A run longer than this is measured twice only [s].
LONG = 0.5


class RunFailed(Exception):
    """A run that did not get to its end; the text says why in a few words."""


@dataclass
class Measured:
    """One process: what it cost and what it computed."""

    seconds: float  # T above
    process: float  # user and system time of the process
    history: History
    version: str


class Start:
    """T(1) of a mesh: what a run costs up to the end of its first step."""

    def __init__(self, runner, setting):
        self.runner, self.setting = runner, setting
        self.seconds = float("inf")

    def measure(self):
        try:
            self.seconds = min(self.seconds, self.runner.run(self.setting, first_step_only=True).seconds)
        except RunFailed:
            self.seconds = 0.0  # the runs themselves will say why


@dataclass
class Case:
    """One point of a chart, and what the rounds have found about it."""

    series: object
    setting: object
    runner: object
    start: object  # the Start that it shares with others of the same mesh
    seconds: float = float("inf")
    process: float = float("inf")
    runs: int = 0
    steps: int = 0
    history: Optional[History] = None
    failure: str = ""
    version: str = ""
    errors: dict = field(default_factory=dict)
    hopeless: bool = False  # far from what its series does best: once is enough

    @property
    def loop(self):
        """CPU time of the solve loop, from the whole of it and that of its first step [s].

        Not a number where the noise of the machine may be as large.
        """
        rest = self.seconds - self.start.seconds
        return rest * self.steps / (self.steps - 1) if rest > NOISE and self.steps > 1 else float("nan")

    @property
    def size(self):
        steps = f"{self.setting.steps} steps" if self.setting.steps else f"accuracy {self.setting.accuracy:g}"
        return f"{self.setting.elements} elements, {steps}"

    def settled(self, rounds):
        return rounds > 0 and (self.hopeless or (self.runs > 1 and self.process > LONG))

    def measure(self):
        try:
            found = self.runner.run(self.setting)
        except RunFailed as failed:
            self.failure = str(failed)
            return
        self.runs += 1
        self.seconds = min(self.seconds, found.seconds)
        self.process = min(self.process, found.process)
        self.version = found.version
        if self.history is None:
            self.history = found.history
            self.steps = len(found.history.time) - 1


def child(command, folder, limit):
    """CPU seconds of a process; RunFailed with its last words where it does not succeed."""
    environment = {**os.environ, **ONE_THREAD}
    with open(folder / "log", "w", encoding="utf-8") as log:
        process = subprocess.Popen(
            [str(word) for word in command],
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
        )
        # Not RLIMIT_CPU: with it the kernel lets the process see its own time in ticks of some milliseconds.
        watch = threading.Timer(limit, process.kill)
        watch.start()
        _, status, usage = os.wait4(process.pid, 0)
        watch.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RunFailed(last_words(folder / "log", process.returncode, limit))
    return usage.ru_utime + usage.ru_stime


def last_words(path, status, limit):
    if status < 0:
        return f"stopped after {limit} s" if status == -signal.SIGKILL else f"ended by signal {-status}"
    lines = [line.strip() for line in path.read_text(errors="replace").splitlines()]
    errors = [line for line in lines if "error" in line.lower() or "failed" in line.lower()]
    words = (errors or [line for line in lines if line] or [f"exit status {status}"])[-1]
    return words.replace(str(path.parent) + "/", "")


class GentbeamRunner:
    name = "gentbeam"

    def __init__(self, scene, folder, limit):
        self.scene, self.folder, self.limit = scene, folder, limit

    def run(self, setting, first_step_only=False):
        deck = self.folder / "run.inp"
        deck.write_text(self.scene.deck(setting, first_step_only), encoding="utf-8")
        chosen = [word for pair in self.scene.parameters for word in ("--set", pair)]
        process = child([program(), "-q", "-o", "run", *chosen, deck], self.folder, self.limit)
        path = self.folder / "run.h5"
        with open_results(str(path)) as results:
            group = next((one for one in results.groups if one.kind == "transient"), None)
            rows = group.history(self.scene.probe)
        with h5py.File(path, "r") as file:
            seconds = float(file.attrs["cpu_seconds"])
            version = text(file.attrs.get("program_version", ""))
        return Measured(seconds, process, History(rows.time, rows.values), version)


class PythonPeerRunner:
    """A program that is a Python package, run by its adapter in an interpreter that has the package."""

    def __init__(self, name, package, adapter, element, python, folder, limit):
        self.name, self.package, self.adapter, self.element = name, package, adapter, element
        self.python, self.folder, self.limit = python, folder, limit

    def missing(self):
        """Why it cannot be run here; empty where it can."""
        look = f"import importlib.util as u; raise SystemExit(u.find_spec({self.package!r}) is None)"
        try:
            found = subprocess.run([self.python, "-c", look], capture_output=True, check=False)
        except OSError as error:
            return f"{self.python}: {error.strerror}"
        return f"no package {self.package} in {self.python}" if found.returncode else ""

    def run(self, setting, first_step_only=False):
        answer = self.folder / "answer.json"
        answer.unlink(missing_ok=True)
        last = [1] if first_step_only else []
        command = [self.python, SCRIPTS / self.adapter, self.element, setting.elements, setting.steps, answer]
        process = child(command + last, self.folder, self.limit)
        found = json.loads(answer.read_text(encoding="utf-8"))
        return Measured(found["seconds"], process, history(found["time"], found["tip"]), found["version"])


class CalculixRunner:
    name = "CalculiX"

    def __init__(self, element, folder, limit):
        self.element, self.folder, self.limit = element, folder, limit

    def missing(self):
        return "" if shutil.which("ccx") else "no program ccx"

    def run(self, setting, first_step_only=False):
        last = 1 if first_step_only else setting.steps
        deck = peer_calculix.deck(self.element, setting.elements, setting.steps, last)
        (self.folder / "run.inp").write_text(deck, encoding="utf-8")
        process = child([shutil.which("ccx"), "run"], self.folder, self.limit)
        try:
            rows = peer_calculix.read(self.folder / "run.dat", setting.steps, last)
        except (ValueError, OSError) as error:
            raise RunFailed(str(error)) from error
        return Measured(process, process, history(*rows), "")


def history(time, values):
    return History(np.array(time), np.array(values))

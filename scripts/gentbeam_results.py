"""Reads gentbeam's results files, and holds what the plotting scripts share.

    with open_results("cantilever.h5") as results:
        group = results.group()                    # the first transient or static solution
        history = group.history(group.probes[0])   # .time, .values, .unit, ...
        mesh = results.mesh()                      # .x, .elements, .fixed, .thickness
        time, u = group.displacements()            # (rows), (rows, nodes, fields)

Whatever is wrong with a file is a ResultsError of one line that says what is there instead.
"""

import argparse
import functools
import os
import re
import signal
import sys
import zlib
from dataclasses import dataclass
from typing import Optional

import h5py
import numpy as np

FORMAT = "gentbeam"
FORMAT_VERSION = 1
HISTORY_KINDS = ("transient", "static")
FIELDS = ("u1", "u3", "y1", "y3", "xi")


# What h5py and numpy raise where a file does not hold what it should.
DAMAGE = (OSError, RuntimeError, LookupError, ValueError, TypeError, ArithmeticError, MemoryError)

# Bytes of an array up to which it is looked through before it is used.
WHOLE = 100_000_000


class ResultsError(Exception):
    """A results file that cannot be used as asked; the text is for the user."""


def reads_file(method):
    """For methods of what has a `path`: a file that is damaged becomes a ResultsError."""

    @functools.wraps(method)
    def guarded(self, *arguments, **options):
        try:
            return method(self, *arguments, **options)
        except DAMAGE as error:
            raise ResultsError(f"{self.path}: is damaged: {one_line(error)}") from error

    return guarded


def find_damage(path):
    """What is wrong with the file, in some words, or nothing. Damaged metadata can end the process that reads
    them, so another one goes first and looks at all there is."""
    if not hasattr(os, "fork"):
        return ""
    reading, writing = os.pipe()
    process = os.fork()
    if process == 0:
        os.close(reading)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(10 + os.path.getsize(path) // 20_000_000)
        try:
            with h5py.File(path, "r", locking=False) as file:
                os.write(writing, walk(file).encode()[:4096])
        except BaseException:  # whatever Python can tell is told by the reader itself
            pass
        os._exit(0)
    os.close(writing)
    with open(reading, encoding="utf-8", errors="replace") as pipe:
        damage = pipe.read()
    if os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) < 0:
        return "reading it ends in a crash of HDF5, or never"
    return damage


def walk(file):
    """What is wrong with a file that could be opened, or nothing."""
    try:
        return ("units" in file and look_at("the file", file)) or file.visititems(look_at) or ""
    except DAMAGE as error:
        return one_line(error)


def look_at(name, thing):
    """What is wrong with an object; nothing where all is well, or where it has no checksums."""
    try:
        texts = text_checksum(thing.attrs)
        if isinstance(thing, h5py.File):
            texts = text_checksum(thing["units"].attrs, texts)
        if thing.attrs.get("text_checksum", texts) != texts:
            return f"the attributes of {name} are not what was written"
        if not isinstance(thing, h5py.Dataset):
            return None
        if thing.shape and thing.nbytes > WHOLE:
            thing[-1:]
        elif "checksum" in thing.attrs and thing.attrs["checksum"] != checksum(thing[()]):
            return f"{name} is not what was written"
    except DAMAGE:
        return f"{name} cannot be read"
    return None


def checksum(values):
    """The CRC-32 that a results file has for a dataset: of its bytes, or of its text, or of all its texts,
    each with a line's end behind it."""
    if isinstance(values, (str, bytes)):
        return zlib.crc32(as_bytes(values))
    if values.dtype == object:
        return zlib.crc32(b"".join(as_bytes(text) + b"\n" for text in values))
    return zlib.crc32(np.ascontiguousarray(values).tobytes())


def text_checksum(attributes, found=0):
    """The CRC-32 of an object's attributes that are texts, or lists of texts: by name, each text with a
    line's end behind it. That of the file goes on with those of /units."""
    for name in sorted(attributes):
        value = attributes[name]
        if isinstance(value, str) or isinstance(value, np.ndarray) and value.dtype == object:
            texts = [value] if isinstance(value, str) else value
            found = zlib.crc32(b"".join(as_bytes(text) + b"\n" for text in texts), found)
    return found


def as_bytes(text):
    return text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text


def text(value):
    """An attribute as str, however the file stores its strings."""
    if isinstance(value, np.ndarray):
        value = value.reshape(-1)[0] if value.size else ""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def unit_of(dataset, otherwise=""):
    unit = text(dataset.attrs.get("unit", otherwise)).strip()
    return "" if unit in ("1", "-") else unit


def open_results(path):
    """The results file at `path`, to be used in a `with` statement."""
    if not os.path.exists(path):
        raise ResultsError(f"{path}: no such file")
    if os.path.isdir(path):
        raise ResultsError(f"{path}: is a folder")
    if not os.access(path, os.R_OK):
        raise ResultsError(f"{path}: no permission to read it")
    if not h5py.is_hdf5(path):
        raise ResultsError(f"{path}: not an HDF5 file")
    damage = find_damage(path)
    if damage:
        raise ResultsError(f"{path}: is damaged: {damage}")
    try:
        # The run may still be writing, and the file may lie on a disk that knows no locks.
        file = h5py.File(path, "r", locking=False)
    except OSError as error:
        raise ResultsError(f"{path}: cannot be opened: {one_line(error)}") from error
    try:
        return Results(path, file)
    except (ResultsError, *DAMAGE) as error:
        file.close()
        if isinstance(error, ResultsError):
            raise
        raise ResultsError(f"{path}: is damaged: {one_line(error)}") from error


def one_line(error):
    return " ".join(str(error).split())


@dataclass
class History:
    """One value a step."""

    time: np.ndarray
    values: np.ndarray
    time_unit: str
    unit: str
    field: str  # u1, u3, v3, ... or empty where the file does not say
    error_bar: Optional[float] = None  # estimated, of the course's mean square or, in statics, its end


@dataclass
class Tuning:
    """What `auto` tried and chose."""

    accuracy: float
    estimate: float
    parts: dict[str, float]  # of the estimate, by source
    choice: str
    rungs: list[dict]  # one a trial; `change` is 0 where it is compared with none


@dataclass
class Mesh:
    x: np.ndarray  # reference X1 of every node
    elements: list[np.ndarray]  # node numbers of every element
    fixed: np.ndarray  # (nodes, 5), true where a field is fixed
    thickness: Optional[np.ndarray]  # of every element; None where the file does not say
    unit: str


class Results:
    def __init__(self, path, file):
        self.path = path
        self._file = file
        attributes = file.attrs
        if text(attributes.get("format", "")) != FORMAT:
            raise ResultsError(f"{path}: not a gentbeam results file (no attribute format = {FORMAT})")
        version = text(attributes.get("format_version", "missing"))
        if version != str(FORMAT_VERSION):
            raise ResultsError(f"{path}: format_version is {version}, this script reads {FORMAT_VERSION}")
        self.status = text(attributes.get("status", "unknown"))
        self.message = text(attributes.get("message", ""))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()

    @property
    def name(self):
        """The file's name without folder and ending."""
        return os.path.splitext(os.path.basename(self.path))[0]

    @property
    def deck(self):
        """The deck's text as read."""
        return text(self._file["deck"][()]) if "deck" in self._file else ""

    def deck_attribute(self, name):
        return text(self._file["deck"].attrs.get(name, "")) if "deck" in self._file else ""

    def attribute(self, name):
        """A text of the run itself, empty where the file does not say."""
        return text(self._file.attrs.get(name, ""))

    def number(self, name):
        return float(np.ravel(self._file.attrs.get(name, np.nan))[0])

    def array(self, name):
        if name not in self._file:
            raise ResultsError(f"{self.path}: has no /{name}")
        return self._file[name][()]

    @property
    @reads_file
    def units(self):
        attributes = self._file["units"].attrs if "units" in self._file else {}
        return {name: text(attributes.get(name, "")) for name in ("length", "force", "time")}

    @property
    @reads_file
    def parameters(self):
        """The deck's parameters as run: name (lower case) to value, as text."""
        if "deck" not in self._file:
            return {}
        lines = text(self._file["deck"].attrs.get("parameters", "")).splitlines()
        pairs = (line.split("=", 1) for line in lines if "=" in line)
        return {name.strip().lower(): value.strip() for name, value in pairs}

    @property
    @reads_file
    def groups(self):
        """The solutions, in the order they were run."""
        found = [
            Group(self, name, item)
            for name, item in self._file.items()
            if isinstance(item, h5py.Group) and "kind" in item.attrs
        ]
        return sorted(found, key=lambda group: group.order)

    def refuse_study(self):
        """Says of a study's file, which has no solution of its own, what draws it."""
        if "sweep" in self._file:
            raise ResultsError(f"{self.path}: is a study of many members; scripts/plot_sweep.py draws it")

    def group(self, name=None):
        """The solution of that name, or else the first that has a course in time or load."""
        self.refuse_study()
        groups = self.groups
        available = ", ".join(f"{group.name} ({group.kind})" for group in groups) or "none"
        if name is not None:
            for group in groups:
                if group.name.lower() == name.lower():
                    return group
            raise ResultsError(f"{self.path}: no solution '{name}' (there are: {available})")
        for group in groups:
            if group.kind in HISTORY_KINDS:
                return group
        raise ResultsError(f"{self.path}: no transient or static solution (there are: {available})")

    @reads_file
    def mesh(self):
        for name in ("mesh/x", "mesh/elements"):
            if name not in self._file:
                raise ResultsError(f"{self.path}: has no /{name}")
        x = self._file["mesh/x"][()]
        nodes = self._file["mesh/elements"][()]
        fixed = (
            self._file["mesh/fixed"][()] if "mesh/fixed" in self._file else np.zeros((len(x), len(FIELDS)))
        )
        thickness = self._file["mesh/thickness"][()] if "mesh/thickness" in self._file else None
        elements = [row[row >= 0] for row in nodes]
        elements.sort(key=lambda element: x[element].min())
        if thickness is not None:
            thickness = thickness[np.argsort([x[row[row >= 0]].min() for row in nodes], kind="stable")]
        unit = unit_of(self._file["mesh/x"], self.units["length"])
        return Mesh(x, elements, fixed.astype(bool), thickness, unit)


    def error_bar(self, group, probe):
        """Estimated error of a probe of an `auto` command, in its unit; None for others."""
        bar = self._file.get(f"tuning/error_bars/{group}.{probe}")
        return None if bar is None else float(bar[0])

    @reads_file
    def tuning(self):
        """What `auto` did; None where the deck has none."""
        if "tuning" not in self._file:
            return None
        item = self._file["tuning"]
        numbers = {name: value for name, value in item.attrs.items() if name != "text_checksum"}
        choice = (
            f"{numbers['elements']} elements of {numbers['nodes']} nodes, {numbers['points']} points through "
            f"the thickness, inertia {text(numbers['inertia'])}, {text(numbers['scheme'])}, "
            f"{numbers['steps']} steps"
        )
        parts = {
            name.removeprefix("error_"): float(value)
            for name, value in numbers.items()
            if name.startswith("error_")
        }
        columns = {name: item["rungs"][name][()] for name in item["rungs"] if name != "source"}
        sources = text(item["rungs/source"][()]).split()
        rungs = [
            {"source": source, **{name: values[row].item() for name, values in columns.items()}}
            for row, source in enumerate(sources)
        ]
        return Tuning(float(numbers["accuracy"]), float(numbers["estimate"]), parts, choice, rungs)


class Group:
    """One solution: a static, modal or transient group of the file."""

    def __init__(self, results, name, item):
        self.results = results
        self.name = name
        self._item = item
        self.kind = text(item.attrs["kind"])
        self.scheme = text(item.attrs.get("scheme", ""))
        self.order = int(np.ravel(item.attrs.get("order", sys.maxsize))[0])

    def _error(self, message):
        return ResultsError(f"{self.results.path}: {message}")

    @property
    def path(self):
        return self.results.path

    @property
    @reads_file
    def probes(self):
        return [name for name in self._item.get("probes", ()) if name != "time"]

    @property
    def progress_name(self):
        return "Load factor" if self.kind == "static" else "Time"

    @property
    def progress_unit(self):
        return "" if self.kind == "static" else self.results.units["time"]

    @reads_file
    def history(self, probe):
        by_name = {name.lower(): name for name in self.probes}
        if probe.lower() not in by_name:
            available = ", ".join(self.probes) or "none"
            raise self._error(f"no probe '{probe}' in {self.name} (there are: {available})")
        if "time" not in self._item["probes"]:
            raise self._error(f"{self.name}/probes has no time")
        times = self._item["probes/time"]
        values = self._item["probes"][by_name[probe.lower()]]
        # A run that is still writing may have stored one of the two first.
        rows = min(len(times), len(values))
        if rows == 0:
            raise self._error(f"the history of probe '{probe}' in {self.name} is empty")
        return History(
            times[:rows],
            values[:rows],
            unit_of(times, self.progress_unit),
            unit_of(values),
            probed_field(values),
            self.results.error_bar(self.name, by_name[probe.lower()]),
        )

    def has(self, name):
        return name in self._item

    def array(self, name):
        if name not in self._item:
            raise self._error(f"{self.name} has no {name}")
        return self._item[name][()]

    def unit(self, name):
        return unit_of(self._item[name]) if name in self._item else ""

    @reads_file
    def displacements(self):
        """Times and fields of the stored rows."""
        if "u" not in self._item or "time" not in self._item:
            raise self._error(f"{self.name} stores no displacements")
        rows = min(len(self._item["time"]), len(self._item["u"]))
        if rows == 0:
            raise self._error(f"{self.name} holds no rows")
        return self._item["time"][:rows], self._item["u"][:rows]


def probed_field(dataset):
    """What a probe follows, as in a deck: u3, or v3 where the description says "velocity of u3 at ..."."""
    description = text(dataset.attrs.get("description", ""))
    found = re.match(r"(?:(velocity|acceleration) of )?(u1|u3|y1|y3|xi)\b", description)
    if not found:
        return ""
    rate, field = found.groups()
    if rate is None:
        return field
    return rate[0] + field[1] if field[0] == "u" else ""


class Parser(argparse.ArgumentParser):
    """An argument parser that answers a mistake as the rest of the scripts do: one line, exit status 1."""

    def error(self, message):
        self.exit(1, f"{self.prog}: error: {message}\n")


def warn(message):
    print(f"{os.path.basename(sys.argv[0])}: warning: {message}", file=sys.stderr)


def warn_if_incomplete(results):
    if results.status != "complete":
        because = f": {one_line(results.message)}" if results.message.strip() else ""
        warn(f"{results.path}: the run's status is {results.status}{because}")


def run_script(main):
    """Runs a script's main; what is wrong with a file becomes one line and exit status 1."""
    try:
        main()
    # Besides our own: what h5py raises on a damaged file, and the system on a picture it cannot write.
    except (ResultsError, OSError, RuntimeError, KeyError) as error:
        sys.exit(f"{os.path.basename(sys.argv[0])}: error: {one_line(error)}")

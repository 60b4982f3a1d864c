"""gentbeam from Python: runs decks and hands the results out as numpy arrays, without files.

    import gentbeam
    r = gentbeam.run("cantilever.inp", jm=0.5)
    time, tip = r.probe("tip")
    r["transient/u"]                     # (rows, nodes, 5), the names of the results file
    r.energy("balance"), r.frequency

Keyword arguments replace the deck's parameters, as --set does. A deck may be a path or a text of several
lines. The shared library libgentbeam is looked for in $GENTBEAM_LIBRARY, beside the installed package, in the
build folders of a source tree, and where the system keeps its libraries.
"""

import ctypes
import glob
import numbers
import os
import threading
from collections import namedtuple
from collections.abc import Mapping
from pathlib import Path

import numpy as np

__all__ = ["DeckError", "Error", "FileError", "Result", "SolutionError", "run", "version"]

MAX_RANK = 4
DECK_WRONG, SOLUTION_FAILED, FILE_TROUBLE = 1, 2, 3

History = namedtuple("History", "time values")


class Error(Exception):
    """What the program has to say against a deck or a run."""


class DeckError(Error):
    """The deck is wrong; the text is the diagnostics, with line, column and caret."""


class FileError(Error):
    """The deck, or a file that it names, cannot be read."""


class SolutionError(Error):
    """A solution failed; `result` holds all steps before."""

    def __init__(self, message, result):
        super().__init__(message)
        self.result = result


def candidates():
    """Places of the shared library, the likeliest first."""
    if os.environ.get("GENTBEAM_LIBRARY"):
        yield os.environ["GENTBEAM_LIBRARY"]
        return
    for folder in Path(__file__).resolve().parents:
        for pattern in ("libgentbeam.so*", "lib*/libgentbeam.so*", "lib/*/libgentbeam.so*"):
            yield from sorted(glob.glob(str(folder / pattern)), key=len)
        for build in ("release", "portable", "debug"):
            yield from sorted(glob.glob(str(folder / "build" / build / "libgentbeam.so*")), key=len)
    yield "libgentbeam.so"


def load():
    for path in candidates():
        try:
            found = ctypes.CDLL(path)
        except OSError as error:
            last = error
            continue
        handle, text, number = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int
        texts = ctypes.POINTER(text)
        shape = ctypes.POINTER(ctypes.c_size_t)
        for name, result, arguments in (
            ("version", text, []),
            ("run_file", handle, [text, number, texts]),
            ("run_text", handle, [text, number, texts]),
            ("status", number, [handle]),
            ("message", text, [handle]),
            ("text", text, [handle, text]),
            ("count", number, [handle]),
            ("name", text, [handle, number]),
            ("array", ctypes.POINTER(ctypes.c_double), [handle, text, ctypes.POINTER(number), shape]),
            ("free", None, [handle]),
        ):
            function = getattr(found, f"gentbeam_{name}")
            function.restype, function.argtypes = result, arguments
        return found
    raise ImportError(f"libgentbeam is not found (set GENTBEAM_LIBRARY to its path): {last}")


library = load()
version = __version__ = library.gentbeam_version().decode()
# The library runs one deck at a time.
one_at_a_time = threading.Lock()


def as_expression(value):
    """A number or text as --set takes it."""
    if isinstance(value, str):
        return value
    if isinstance(value, numbers.Real):
        return repr(float(value))
    raise TypeError(f"a parameter is a number or an expression, not {value!r}")


def run(deck, **parameters):
    """Run a deck, a path or a text of several lines; the parameters replace those of the deck.

    Raises DeckError, FileError or SolutionError.
    """
    words = [f"{name}={as_expression(value)}".encode() for name, value in parameters.items()]
    arguments = len(words), (ctypes.c_char_p * max(1, len(words)))(*words)
    with one_at_a_time:
        if isinstance(deck, str) and "\n" in deck:
            handle = library.gentbeam_run_text(deck.encode(), *arguments)
        else:
            handle = library.gentbeam_run_file(os.fsencode(deck), *arguments)
    try:
        status = library.gentbeam_status(handle)
        message = library.gentbeam_message(handle).decode("utf-8", "replace")
        if status == DECK_WRONG:
            raise DeckError(message)
        if status == FILE_TROUBLE:
            raise FileError(message)
        result = Result(handle)
    finally:
        library.gentbeam_free(handle)
    if status == SOLUTION_FAILED:
        raise SolutionError(message, result)
    return result


class Result(Mapping):
    """The arrays of a run by their names in the results file, and shorter ways to the usual ones.

    `command` chooses a solution by its name; without it, the last one that has what is asked for.
    """

    def __init__(self, handle):
        def text(key):
            found = library.gentbeam_text(handle, key.encode())
            return None if found is None else found.decode("utf-8", "replace")

        self._arrays = {}
        for number in range(library.gentbeam_count(handle)):
            name = library.gentbeam_name(handle, number)
            rank, shape = ctypes.c_int(), (ctypes.c_size_t * MAX_RANK)()
            values = library.gentbeam_array(handle, name, ctypes.byref(rank), shape)
            extent = tuple(shape[: rank.value])
            # A copy: the library's own goes when the run is forgotten.
            array = np.ctypeslib.as_array(values, extent).copy() if values else np.empty(extent)
            self._arrays[name.decode()] = array
        self.title = text("title")
        self.commands = tuple(text("commands").split())
        self.kinds = {name: text(f"{name}/kind") for name in self.commands}
        self.units = {name: text(f"units/{name}") for name in ("length", "force", "time")}
        self.parameters = dict(line.split("=", 1) for line in text("parameters").splitlines())

    def __getitem__(self, name):
        if name not in self._arrays:
            raise KeyError(f"no {name} in this run (there are: {', '.join(self._arrays)})")
        return self._arrays[name]

    def __iter__(self):
        return iter(self._arrays)

    def __len__(self):
        return len(self._arrays)

    def __repr__(self):
        commands = ", ".join(f"{name} ({kind})" for name, kind in self.kinds.items())
        return f"<gentbeam.Result of {self.title!r}: {commands}>"

    def _find(self, path, command):
        for name in [command] if command else reversed(self.commands):
            if f"{name}/{path}" in self._arrays:
                return name
        if command and command not in self.commands:
            raise KeyError(f"no command {command} in this run (there are: {', '.join(self.commands)})")
        wanted = [command] if command else self.commands
        known = sorted({key.split("/", 1)[1] for key in self if key.split("/")[0] in wanted})
        raise KeyError(f"no {path} in {command or 'this run'} (there are: {', '.join(known)})")

    def probe(self, name, command=None):
        """History of a probe: time (or load factor) and values, one a step."""
        command = self._find(f"probes/{name}", command)
        return History(self[f"{command}/probes/time"], self[f"{command}/probes/{name}"])

    def probes(self, command=None):
        """Names of the probes."""
        prefix = f"{self._find('probes/time', command)}/probes/"
        return [key[len(prefix) :] for key in self if key.startswith(prefix) and key != f"{prefix}time"]

    def field(self, name, command=None):
        """Time and the rows of u, v, a, strain/E, stress/moment, ... as far as OUTPUT fields= keeps them."""
        command = self._find(name, command)
        return History(self[f"{command}/time"], self[f"{command}/{name}"])

    def energy(self, name, command=None):
        """kinetic, strain, external, dissipated or balance, one value a step."""
        command = self._find(f"energy/{name}", command)
        return History(self[f"{command}/probes/time"], self[f"{command}/energy/{name}"])

    @property
    def x(self):
        """Reference X1 of every node."""
        return self["mesh/x"]

    @property
    def frequency(self):
        """Natural frequencies of the last MODAL."""
        return self[f"{self._find('frequency', None)}/frequency"]

    @property
    def modes(self):
        """Natural modes of the last MODAL (modes, nodes, 5)."""
        return self[f"{self._find('modes', None)}/modes"]

"""What threads run side by side has no memory in common that changes.

Fortran makes such memory without being asked: a local variable with a first value keeps it from call to
call, and gfortran puts the length of a result that is `character(:), allocatable` into one place for all
threads. Both show in the object files, as symbols of data that can be written.
"""

import os
import re
import subprocess

import pytest

# What solves members; the deck's reader runs one thread at a time.
ROOMS = ("model", "element", "solve", "study")
# Tables of the compiler, of OpenMP and of the sanitizers themselves; nothing of ours writes to them.
HARMLESS = re.compile(r"___vtab_|___def_init_|^jumptable\.|^\.gomp_critical_user_|^__odr_asan\.")
SYMBOL = re.compile(r"^[0-9a-f]* ([bBdDC]) (\S+)$")


@pytest.mark.parametrize("room", ROOMS)
def test_no_data_are_shared(room):
    folder = os.environ["GENTBEAM_OBJECTS"]
    objects = [
        os.path.join(place, name)
        for place, _, names in os.walk(folder)
        for name in names
        if os.path.basename(place) == room and name.endswith((".o", ".obj"))
    ]
    assert objects, f"no objects of src/{room} below {folder}"
    for path in objects:
        said = subprocess.run(["nm", path], check=True, capture_output=True, text=True).stdout
        shared = [m[2] for m in map(SYMBOL.match, said.splitlines()) if m and not HARMLESS.search(m[2])]
        assert not shared, f"{path}: {shared}"

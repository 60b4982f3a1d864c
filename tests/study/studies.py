"""Decks of studies, and how two results files are compared."""

import h5py

DECK = """\
GENTBEAM     Study
UNITS        length=in  force=lbf  time=s
PARAMETER    E=12000  nu=0.2  jm=1e20  n={elements}
{sweep}
MATERIAL     rubber  gent  mu=E/(2*(1+nu))  c=E*nu/(1-nu^2)  jm=jm  rho=1e-6
SECTION      square  rectangle  b=1  h=1
LINE         from=0  to=10  elements=n
CLAMP        x=0
DISTRIBUTED  from=0  to=10  q3=2.85
PROBE        tip  u3  x=10
PROBE        tip_u1  u1  x=10
{output}
END
{solution}
STOP
"""
CROSSED = "SWEEP E=[11000 12000 13000]\nSWEEP jm=[1 2 5 1e20]"
SHORT = "TRANSIENT newmark step=5e-4 end=5e-3"


def study(sweep=CROSSED, solution=SHORT, output="", elements=3):
    return DECK.format(sweep=sweep, solution=solution, output=output, elements=elements)


def attributes(item, without=()):
    found = {}
    for name, value in item.attrs.items():
        if name not in without:
            found[name] = value.tolist() if hasattr(value, "tolist") else value
    return found


def differences(one, other, path=""):
    """Where two groups are not the same, bit for bit; the order of their members counts."""
    found = []
    if list(one) != list(other):
        return [f"{path}: {list(one)[:9]} and {list(other)[:9]}"]
    for name in one:
        here, there, place = one[name], other[name], f"{path}/{name}"
        if attributes(here) != attributes(there):
            found.append(f"{place}: attributes")
        if isinstance(here, h5py.Group):
            found += differences(here, there, place)
        elif here.dtype != there.dtype or here.shape != there.shape:
            found.append(f"{place}: {here.dtype} {here.shape} and {there.dtype} {there.shape}")
        elif here.dtype == object:
            if here.shape == () and here[()] != there[()] or here.shape and list(here[:]) != list(there[:]):
                found.append(f"{place}: texts")
        elif here[()].tobytes() != there[()].tobytes():
            found.append(f"{place}: numbers")
    return found


def same_file(one, other):
    """Two results files hold the same, but for when and how long they ran."""
    timed = ("created", "wall_seconds", "cpu_seconds", "text_checksum")
    with h5py.File(one) as here, h5py.File(other) as there:
        assert attributes(here, timed) == attributes(there, timed)
        assert not differences(here, there)


def far_apart(one, other, path="", agreement=1e-9):
    """Motions, probes and frequencies of two commands that differ by more than a part of the largest."""
    found = []
    for name in one:
        here, there, place = one[name], other[name], f"{path}/{name}"
        if isinstance(here, h5py.Group):
            if name == "probes":
                found += far_apart(here, there, place, agreement)
        elif "/probes/" in place or name in ("u", "frequency"):
            size = abs(there[:]).max()
            if here.shape != there.shape or abs(here[:] - there[:]).max() > agreement * size:
                found.append(place)
    return found

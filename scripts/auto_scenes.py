"""Scenes on which `auto` is held against runs chosen by hand: decks with {elements}, {section} and {task}."""

from dataclasses import dataclass

RUBBER = "mu=E/(2*(1+nu)) c=E*nu/(1-nu^2)"
CANTILEVER = (
    "PARAMETER L=10 E=12000 nu=0.2\n"
    f"MATERIAL rubber gent {RUBBER} jm={{jm}} rho=1e-6\n"
    "SECTION s rectangle b=1 h={h} {section}\n"
    "LINE from=0 to=L elements={elements}\n"
    "CLAMP x=0\n"
    "DISTRIBUTED from=0 to=L q3={q}\n"
    "PROBE tip u3 x=L\n"
)
TWO_SPAN = (
    "PARAMETER L=12 E=14000 nu=0.3\n"
    f"MATERIAL rubber gent {RUBBER} jm={{jm}} rho=1e-4\n"
    "SECTION s rectangle b=1 h={h} {section}\n"
    "LINE from=0 to=L elements={elements}\n"
    "PIN x=0\nPIN x=6\nCLAMP x=L\n"
    "DISTRIBUTED from=0 to=4 q3={q}\nPOINT x=9 f3={q}/3\n"
    "PROBE tip u3 x=3\n"
)
SLIDING = (
    "PARAMETER L=12 E=14000 nu=0.3\n"
    f"MATERIAL rubber gent {RUBBER} jm={{jm}} rho=4e-4\n"
    "SECTION s rectangle b=1 h={h} {section}\n"
    "LINE from=0 to=L elements={elements}\n"
    "CLAMP x=0\nPIN x=4\nROLLER x=8\nSLIDE x=L\n"
    "DISTRIBUTED from=0 to=4 q3={q}\nPOINT x=6 f3={q}\nPOINT x=L f3={q}/3\n"
    "PROBE tip u3 x=L\n"
)
FREE = (
    "PARAMETER L=10 omega=30\n"
    "MATERIAL rubber gent mu=5000 c=2500 jm={jm} rho=1e-6\n"
    "SECTION s rectangle b=1 h={h} {section}\n"
    "LINE from=0 to=L elements={elements}\n"
    "INITIAL velocity u3=omega*(x-5)+0.2*omega*sin(3*pi*x/10) y1=-omega\n"
    "PROBE tip u3 x=L\n"
)
SHAKEN = (
    "PARAMETER L=10 E=12000 nu=0.2\n"
    f"MATERIAL rubber gent {RUBBER} jm={{jm}} rho=1e-6\n"
    "SECTION s rectangle b=1 h={h} {section}\n"
    "LINE from=0 to=L elements={elements}\n"
    "HISTORY shake sine frequency=100\n"
    "FIX u1 y1 y3 xi x=0\nPRESCRIBE x=0 u3=0.5 history=shake\n"
    "PROBE tip u3 x=L\n"
)
PULSE = (
    "PARAMETER L=10 E=12000 nu=0.2\n"
    f"MATERIAL rubber gent {RUBBER} jm={{jm}} rho=1e-6\n"
    "SECTION s rectangle b=1 h={h} {section}\n"
    "LINE from=0 to=L elements={elements}\n"
    "CLAMP x=0\nDAMPING mass=200\n"
    "HISTORY knock pulse stop=1e-3\n"
    "POINT x=L f3={q} history=knock\n"
    "PROBE tip u3 x=L\n"
)
TIP_LOAD = (
    "PARAMETER L=10 E=12000 nu=0.2\n"
    f"MATERIAL rubber gent {RUBBER} jm={{jm}} rho=1e-6\n"
    "SECTION s rectangle b=1 h={h} {section}\n"
    "LINE from=0 to=L elements={elements}\n"
    "CLAMP x=0\n"
    "POINT x=L f3={q}\n"
    "PROBE tip u3 x=L\n"
)


@dataclass
class Scene:
    name: str
    deck: str
    accuracy: float
    unit: int  # elements= by hand must be a multiple of it, so that supports and forces stand at nodes
    values: dict
    end: float = 0.0  # of a TRANSIENT; 0: a STATIC

    @property
    def task(self):
        return "static" if self.end == 0.0 else "transient"

    def write(self, elements, section, task):
        body = self.deck.format(elements=elements, section=section, **self.values)
        return f"GENTBEAM {self.name}\n{body}OUTPUT fields=none\nEND\n{task}\n"

    def by_program(self):
        end = f" end={self.end!r}" if self.end else ""
        return self.write(
            4 * self.unit, "", f"{self.task.upper()} auto accuracy={self.accuracy!r} probe=tip{end}"
        )

    def by_hand(self, setting):
        section = f"points={setting.points} inertia={setting.inertia}"
        if self.end:
            step = f"step={self.end / setting.steps!r} end={self.end!r}"
            return self.write(setting.elements, section, f"TRANSIENT {setting.scheme} {step}")
        return self.write(setting.elements, section, f"STATIC steps={setting.steps}")


def dynamic():
    for jm in ("1e20", "10", "2", "0.5"):
        yield Scene(f"cantilever, Jm {jm}", CANTILEVER, 1e-2, 1, {"jm": jm, "h": 1, "q": 2.85}, 1.35e-2)
    for jm in ("1e20", "2"):
        values = {"jm": jm, "h": 1, "q": 2.85}
        yield Scene(f"cantilever, Jm {jm}, finer", CANTILEVER, 1e-3, 1, values, 1.35e-2)
    yield Scene("thick cantilever", CANTILEVER, 1e-2, 1, {"jm": "5", "h": 2.5, "q": 30}, 6e-3)
    yield Scene("thin cantilever", CANTILEVER, 1e-2, 1, {"jm": "5", "h": 0.25, "q": 0.03}, 5e-2)
    for jm in ("1e20", "3", "1"):
        yield Scene(f"two spans, Jm {jm}", TWO_SPAN, 1e-2, 4, {"jm": jm, "h": 1, "q": -20}, 0.02)
    yield Scene("two thin spans", TWO_SPAN, 1e-2, 4, {"jm": "3", "h": 0.4, "q": -1}, 0.04)
    for jm in ("1e20", "2"):
        yield Scene(f"sliding end, Jm {jm}", SLIDING, 2e-2, 6, {"jm": jm, "h": 1, "q": -50}, 0.05)
    yield Scene("sliding end, thin", SLIDING, 2e-2, 6, {"jm": "5", "h": 0.4, "q": -3}, 0.1)
    yield Scene("free flight, spinning", FREE, 1e-2, 2, {"jm": "5", "h": 0.5}, 0.05)
    yield Scene("shaken cantilever", SHAKEN, 1e-2, 1, {"jm": "5", "h": 1}, 2e-2)
    late = PULSE.replace("pulse stop=1e-3", "pulse start=8e-2 stop=8.1e-2").replace("DAMPING mass=200\n", "")
    yield Scene("knocked late", late, 1e-2, 1, {"jm": "5", "h": 1, "q": 10}, 0.1)
    yield Scene("knocked, damped", PULSE, 1e-2, 1, {"jm": "5", "h": 1, "q": 10}, 2e-2)


def static():
    for jm in ("1e20", "1"):
        yield Scene(f"cantilever at rest, Jm {jm}", CANTILEVER, 1e-3, 1, {"jm": jm, "h": 1, "q": 5})
    yield Scene("cantilever at rest, fine", CANTILEVER, 1e-5, 1, {"jm": "5", "h": 1, "q": 5})
    yield Scene("thin, bent far", TIP_LOAD, 1e-3, 1, {"jm": "5", "h": 0.2, "q": 1})
    yield Scene("thick, bent", TIP_LOAD, 1e-3, 1, {"jm": "2", "h": 2.5, "q": 150})
    yield Scene("two spans at rest", TWO_SPAN, 1e-3, 4, {"jm": "1", "h": 1, "q": -60})
    yield Scene("sliding end at rest", SLIDING, 1e-3, 6, {"jm": "2", "h": 1, "q": -100})


def all_scenes():
    return [*dynamic(), *static()]

"""Numbers and names as the report on the paper (paper_report.py) writes them."""

import paper_pictures
from paper_examples import UNLIMITED, jm_text

JM = "<i>J</i><sub>m</sub>"
FIELDS = {"u1": "<i>u</i><sub>1</sub>", "u3": "<i>u</i><sub>3</sub>"}
X1 = "<i>X</i><sub>1</sub>"
DASH = "–"


def percent(value, digits=1):
    return f"{value:.{digits}f} %"


def signed_percent(value, digits=2):
    rounded = round(value, digits)
    return f"{'−' if rounded < 0 else '+' if rounded > 0 else ''}{abs(rounded):.{digits}f} %"


def number(value, digits):
    return f"{value:.{digits}f}".replace("-", "−")


def jm_word(jm):
    return "∞" if jm >= UNLIMITED else jm_text(jm)


def jm_is(jm):
    return f"{JM} = {jm_word(jm)}"


def quantity_word(quantity):
    return f"{FIELDS[quantity.field]} at {X1} = {quantity.x:g}"


def ylabel(example, quantity):
    field = paper_pictures.symbol(quantity.field)
    return f"${field}/L$ at the tip" if example.number == 1 else f"${field}$ at $X_1 = {quantity.x:g}$"


def change_word(reduction):
    return f"{percent(abs(reduction))} {'smaller' if reduction >= 0 else 'larger'}"

# SPDX-License-Identifier: BSD-3-Clause
"""A step of the method as text to read in a terminal: long formulas are broken at the outermost sums where there are any."""

import re
from itertools import accumulate

from kane.dynamics.readings.steps import Step
from kane.equations.equations import Equations
from kane.present.formula_list import Formula, formulas

WIDTH = 110
"""Columns of a line of text."""
_INDENT = 3

_BREAK = re.compile(r" (?=[+-] )")


def step_text(step: Step, eom: Equations, width: int = WIDTH) -> str:
    """The step with one shared list of intermediates, lines of about `width` columns at most."""
    lines = [f"Step {step.number}. {step.title}", *wrapped(step.text, indent=_INDENT, hang=_INDENT, width=width)]
    if step.number == 1:
        told = (f"{q.name}  {', '.join(filter(None, (q.description, q.unit)))}" for q in eom.coordinates)
        return "\n".join([*lines, *(f"{'':{_INDENT}}{line.rstrip()}" for line in told)])
    between, shown = formulas(step.results, str)
    if between:
        lines += [*_block(between, width), ""]
    return "\n".join([*lines, *_block(shown, width)])


def _block(shown: list[Formula], width: int) -> list[str]:
    column = max((len(f.name) for f in shown), default=0)
    hang = _INDENT + column + 3
    return [
        line
        for f in shown
        for line in wrapped(f"{f.name:<{column}} = {f.text}", indent=_INDENT, hang=hang, width=width)
    ]


def wrapped(text: str, *, indent: int = 0, hang: int | None = None, width: int = WIDTH) -> list[str]:
    """Lines of at most `width` columns, the first indented by `indent`, the others by `hang`, where the text allows it.

    Of the places at which a line can end the outermost is taken, and of those the last: first before a + or −, then at a space.
    """
    following = indent + 4 if hang is None else hang
    lines, lead, rest = [], indent, text
    while lead + len(rest) > width:
        at = _place(rest, width - lead, width // 3)
        if at is None:
            break
        lines.append(" " * lead + rest[:at].rstrip())
        rest, lead = rest[at:].lstrip(), following
    return [*lines, " " * lead + rest]


def _place(text: str, room: int, least: int) -> int | None:
    at = [*accumulate((c in "([{") - (c in ")]}") for c in text)]  # brackets that are open after each character
    for pattern in (_BREAK, re.compile(" ")):
        places = [m.start() for m in pattern.finditer(text) if min(least, room) <= m.start() <= room]
        if places:
            return min(places, key=lambda i: (at[i], -i))
    later = [m.start() for m in _BREAK.finditer(text) if m.start() > room]
    return later[0] if later else None

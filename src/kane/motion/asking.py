# SPDX-License-Identifier: BSD-3-Clause
"""Inputs that a kernel asks Python for: functions of the user's one by one, those of one law at once, expressions as compiled."""

from collections.abc import Callable
from typing import Any

from kane.motion.compiled_equations import Routines
from kane.motion.drives import law_of
from kane.motion.feedback import Law, LawInput
from kane.motion.formulas import Formula
from kane.motion.laws import driving
from kane.numeric.arrays import Array

Fill = Callable[[float, Array, Array], None]
"""It writes the inputs at a time and state."""


def filling(now: Routines) -> Fill:
    """What writes the inputs, in as little time as Python leaves beside the user's functions."""
    laws: dict[Law, list[tuple[int, int]]] = {}
    others: list[tuple[int, Callable[[Any], Any]]] = []
    written = any(isinstance(f, Formula) for f in now.drives)
    for k, f in enumerate(list[Any](now.drives)):
        if isinstance(f, LawInput):
            laws.setdefault(f.law, []).append((k, f.place))
        elif not isinstance(f, Formula):
            others.append((k, f))
    each = list(laws.items())
    law = law_of(now.drives, now.eom.inputs, functions=True) if written else None
    routine = now.eom.numeric(now.settings).routine(driving, *law.values).flat if law else None
    p = law.parameters(now.p) if law else now.p

    def fill(t: float, x: Array, r: Array) -> None:
        for law, places in each:
            answer = law.at(t, x)
            for k, place in places:
                r[k] = answer[place]
        for k, f in others:
            r[k] = f(t)
        if routine is not None:
            r[:] = routine(t, x, p, r)

    return fill

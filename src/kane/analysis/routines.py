# SPDX-License-Identifier: BSD-3-Clause
"""What is compiled, or derived anew, once for each set of equations, and forgotten with it."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from kane.equations.equations import Equations
from kane.equations.handle import Handle
from kane.equations.routines import ports
from kane.expr.node import Expr
from kane.expr.symbols import Symbol
from kane.program.build import Wanted, build_program
from kane.program.native.machine import Settings

T = TypeVar("T")

_known: weakref.WeakKeyDictionary[Equations, dict[Hashable, Any]] = weakref.WeakKeyDictionary()


def once(eom: Equations, key: Hashable, make: Callable[[], T]) -> T:
    """Made once for these equations; what is kept must not hold them, or they are never forgotten."""
    own = _known.setdefault(eom, {})
    if key not in own:
        own[key] = make()
    found: T = own[key]
    return found


def routine(
    eom: Equations,
    name: str,
    roots: Sequence[Expr],
    more: Sequence[Symbol] = (),
    labels: Sequence[str] | None = None,
) -> Handle:
    """Any functions of t, x = (q, u, `more`), p and r."""
    t, x, p, r = ports(eom.derived)
    names = [f"{name}[{k}]" for k in range(len(roots))] if labels is None else labels
    wanted = Wanted(name, roots, (len(roots),), names)
    program = build_program("model", (t, replace(x, symbols=(*x.symbols, *more)), p, r), [wanted], reciprocals=True)
    return Handle(program, name, Settings(), None, "ignore")

# SPDX-License-Identifier: BSD-3-Clause
"""What a system declares, in texts and numbers by which a file knows it again.

Each expression is evaluated at several values of its symbols, which depend on their names alone. So what counts is what an expression
means, not how it is written, and numbers may differ by what rounding on another machine makes of them. Of operations that choose, or
that are defined in a part of the numbers only, such as √x, the arguments are compared too.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, NamedTuple

import numpy as np

from kane.expr.build import add, mul
from kane.expr.evaluation import Walk
from kane.expr.node import ZERO, Expr, as_expr, postorder
from kane.expr.ops import ADD, COS, DIV, MUL, NEG, SIN, SUB
from kane.expr.piecewise import lowered
from kane.expr.symbols import Symbol
from kane.model.bodies import parts_of
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL, ROUNDED_CHAIN
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Dyadic, Vector

_EVERYWHERE = frozenset((ADD, COS, DIV, MUL, NEG, SIN, SUB))
_DRAWN = 4
"""How many values each symbol gets."""


class Declared(NamedTuple):
    """Things declared: [name, text, how many expressions, how many numbers in all], and the numbers, one row each."""

    things: list[list[Any]]
    numbers: Array


def declared(system: System) -> Declared:
    """What a system declares."""
    things: list[list[Any]] = []
    roots: list[Expr] = []
    inner: list[slice] = []
    for name, what in _things(system):
        told = list(_told(what))
        exprs = [x for x in told if isinstance(x, Expr)]
        within = [a for n in postorder(lowered(exprs)) if n.op not in _EVERYWHERE for a in n.args]
        things.append(
            [name, " ".join("#" if isinstance(x, Expr) else x for x in told), len(exprs), len(exprs + within)]
        )
        roots += exprs + within
        inner.append(slice(len(roots) - len(within), len(roots)))
    walk = Walk(roots)
    rows = [np.broadcast_to(x, (_DRAWN,)) for x in walk({s: _drawn(s) for s in walk.symbols})]
    numbers = np.array(rows, dtype=float).reshape(len(roots), _DRAWN)
    for rows_within in inner:  # their order is that of the expression's nodes, which rounding may change
        numbers[rows_within] = np.sort(numbers[rows_within], axis=0)
    return Declared(things, numbers)


def difference(kept: Declared, here: Declared) -> str:
    """In which thing two systems differ, and by what, or ""."""
    one, two = _by_name(kept), _by_name(here)
    for name in one | two:
        if name not in two or name not in one:
            return f"{name}, which {'this system' if name in two else 'that of the file'} has alone"
        (text, count, a), (other, number, b) = one[name], two[name]
        if (text, count, a.shape) != (other, number, b.shape):
            return name
        for rows in (slice(count), slice(count, None)):
            off = _off(a[rows], b[rows])
            if off.any():
                k = rows.indices(len(a))[0] + int(np.argmax(off.any(axis=1)))
                plain = k < count and not (np.ptp(a[k]) or np.ptp(b[k]))
                return f"{name}: {a[k, 0]:.9g} in the file, {b[k, 0]:.9g} here" if plain else name
    return ""


def _by_name(declared: Declared) -> dict[str, tuple[str, int, Array]]:
    """Text, count of expressions and numbers of each thing; of things with one name the later ones are numbered."""
    found: dict[str, tuple[str, int, Array]] = {}
    times: dict[str, int] = {}
    start = 0
    for name, text, count, rows in declared.things:
        times[name] = times.get(name, 0) + 1
        key = name if times[name] == 1 else f"{name} ({times[name]})"
        found[key] = text, count, declared.numbers[start : start + rows]
        start += rows
    if declared.numbers.shape != (start, _DRAWN):
        raise ValueError(f"declared should be of shape {(start, _DRAWN)}, got {declared.numbers.shape}")
    return found


def _off(a: Array, b: Array) -> Any:
    """Where numbers of the same expressions differ by more than rounding; what is infinite or NaN must be so in both."""
    size = np.where(np.isfinite(a), np.abs(a), 0.0)
    limit = EQUAL * size.max(axis=1, keepdims=True, initial=0) + ROUNDED_CHAIN * size.max(initial=0)
    with np.errstate(invalid="ignore"):
        near = (a == b) | (np.abs(a - b) <= limit) | (np.isnan(a) & np.isnan(b))
    return ~near


def _drawn(symbol: Symbol) -> Array:
    """Values of a symbol, by its name: positive ones, then those of either sign."""
    words = [hashlib.sha256(f"{k} {symbol.name}".encode()).digest() for k in range(_DRAWN)]
    sizes = np.array([0.3 + int.from_bytes(w[:6]) / 2**48 for w in words])
    signs = np.array([-1.0 if k >= _DRAWN // 2 and w[6] % 2 else 1.0 for k, w in enumerate(words)])
    return np.asarray(sizes * signs)


def _things(s: System) -> Iterator[tuple[str, Any]]:
    yield from ((f"the parameter {p}", (p.default, p.unit)) for p in s.parameters)
    yield from ((f"the unit of {x}", x.unit) for x in (*s.coordinates, *s.speeds, *s.states, *s.inputs))
    yield from ((f"the speed {u}", definition) for u, definition in s.speeds.items())
    yield from ((f"the rate of {a}", rate) for a, rate in s.states.items())
    yield from ((f"the point {p.name}", (p.parent, p.body, p.offset)) for p in s.points)
    for frame in s.frames:
        o = frame.orientation
        yield f"the frame {frame.name}", o and (o.base.name, o.axis, o.angle, o.direction, o.cosines, o.parameters)
    for part in parts_of(s.bodies):
        yield f"the mass of {part.name}", part.mass
        yield f"the inertia of {part.name}", (part.frame, part.inertia)
        yield f"the mass centre of {part.name}", (part.mass_center, part.momenta)
    yield from (("gravity", g.acceleration) for g in s.gravities)
    yield from ((f"the load {x.name}", x) for x in s.loads)
    yield from ((f"the constraint {c.name}", c) for c in s.constraints)
    yield from ((f"the reaction {r}", r.place) for r in (*s.reactions, *s.auxiliary_speeds))
    yield from ((f"the event {e.name}", e) for e in s.events)


def _told(what: Any) -> Iterator[Expr | str]:
    """The expressions that something declared is made of, and all else in words."""
    if isinstance(what, Expr):
        yield what
    elif isinstance(what, Frame | Point):
        yield what.name
    elif isinstance(what, Vector):
        for frame, triple in sorted(what.parts, key=lambda part: part[0].name):
            yield frame.name
            yield from triple
    elif isinstance(what, Dyadic):
        yield from _told(_entries(what))
    elif is_dataclass(what):
        for field in fields(what):
            yield from _told(getattr(what, field.name))
    elif isinstance(what, Mapping):
        for key, value in what.items():
            yield str(key)
            yield from _told(value)
    elif isinstance(what, tuple | list):
        for x in what:
            yield from _told(x)
    elif isinstance(what, float | int) and not isinstance(what, bool) and np.isfinite(what):
        yield as_expr(what)
    else:
        yield getattr(what, "__name__", "a function") if callable(what) else repr(what)


def _entries(inertia: Dyadic) -> dict[str, list[Expr]]:
    """The nine entries of a dyadic along each pair of frames."""
    entries: dict[str, list[Expr]] = {}
    for a, b in inertia.dyads:
        for one, left in a.parts:
            for two, right in b.parts:
                total = entries.setdefault(f"{one.name} {two.name}", [ZERO] * 9)
                total[:] = [add(x, mul(left[k // 3], right[k % 3])) for k, x in enumerate(total)]
    return dict(sorted(entries.items()))

# SPDX-License-Identifier: BSD-3-Clause
"""One degree of freedom: the kinetic energy as a sum of squares, as one writes it by hand.

    K = ½ Σ W x²,   x = X u_I,   ẋ = X u̇_I + d:       (Σ W X²) u̇_I = F̃ − Σ W X d

The x are measure numbers of velocities of mass centres, each along a frame in which they are short, and of angular velocities. What a
constraint says vanishes is left out of them, and those that are multiples of each other are one: moments of inertia are then about
the points that constraints guide.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from kane.dynamics import assembly
from kane.dynamics.assembly import blocks
from kane.dynamics.bodies import Moving
from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.block_solution import block_solution
from kane.dynamics.routes.embedded import evident
from kane.dynamics.routes.power import still
from kane.dynamics.solved import Solved
from kane.expr.build import add, mul, sub
from kane.expr.collect import collected
from kane.expr.count import Prices
from kane.expr.evaluation import is_constant_in_time
from kane.expr.matrix import dot
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import AuxiliarySpeed
from kane.kinematics.motion import Motion
from kane.kinematics.speeds import ScalarForm
from kane.space.rotation import Basis

Form = dict[Expr, Expr]
"""Coefficients by speed."""

_TERM = 4
"""Operations that a term of a measure number brings: in it, in its derivative, and in products with both."""


class Square(NamedTuple):
    """W x y, where x is y but for products of inertia."""

    weight: Expr
    x: Form
    y: Form


def squares(derived: Derived, e: Embedding) -> Solved:
    """u̇ from the sum of squares, without the reactions; what is divided by is not watched yet."""
    every: list[Expr] = [ONE] * len(derived.speeds)
    for i, (b,) in zip(e.partition.dependent, e.a_n.rows, strict=True):
        every[i] = b
    by_speed: dict[Expr, Expr] = dict(zip(derived.speeds, every, strict=True))
    known = derived.kinematics.with_following(e.following(derived.speeds), {})
    left = derived.left_by(derived.kinematics, [still(m) for m in derived.bodies])
    right = dot(every, [assembly.generalized_by_motion(left, s) for s in derived.speeds])
    mass = ZERO
    for w, x, y in _merged(_squares(derived, e)):
        share, other = _value(x, by_speed), _value(y, by_speed)
        carried = mul(w, other)
        mass = add(mass, mul(share, carried))
        d = known.drift(ScalarForm(x, ZERO).total())
        right = sub(right, mul(carried, collected(d) if len(x) > 1 else d))
    inner = block_solution(blocks([[mass]], [right], (), (), {}))
    matrix = evident(derived)
    return Solved("squares", derived, e, e.every(inner.accelerations), (), inner.pivots, matrix, matrix)


def _value(x: Form, by: Mapping[Expr, Expr]) -> Expr:
    total = ZERO
    for u, c in x.items():
        total = add(total, mul(c, by[u]))
    return total


def _merged(found: Iterator[Square]) -> list[Square]:
    """Those that are multiples of each other by parameters, as one."""
    weights: dict[tuple[tuple[tuple[Expr, Expr], ...], ...], Expr] = {}
    for w, x, y in found:
        (a, x_), (b, y_) = _normed(x), _normed(y)
        key = tuple(x_.items()), tuple(y_.items())
        weights[key] = add(weights.get(key, ZERO), mul(mul(w, a), b))
    return [Square(w, dict(x), dict(y)) for (x, y), w in weights.items()]


def _normed(x: Form) -> tuple[Expr, Form]:
    """A parameter and the rest."""
    if len(x) == 1:
        ((u, c),) = x.items()
        if is_constant_in_time([c]):
            return c, {u: ONE}
    return ONE, x


def _squares(derived: Derived, e: Embedding) -> Iterator[Square]:
    """Those of each part, its velocity along the frame in which it is shortest beside those before."""
    speeds: Sequence[Expr] = derived.speeds
    given = [derived.constraints.a.rows[r] for r in e.partition.rows]
    rows = [{u: a for u, a in zip(speeds, row, strict=True) if a is not ZERO} for row in given]
    parts = zip(e.partition.dependent, e.a_n.rows, e.c, strict=True)
    zero = {speeds[d] for d, (x,), c in parts if x is ZERO and c is ZERO}
    seen: list[Expr] = []
    for m in derived.bodies:
        best: list[Form] = []
        if m.center.partials:
            ways = [[_short(x, rows, zero) for x in _forms(m.center, f)] for f in _frames(derived, m)]
            best = _shortest(ways, seen)
        seen += [c for x in best for c in x.values()]
        yield from (Square(m.part.mass, x, x) for x in best if x)
        if m.rotation is None:
            continue
        inertia = m.rotation.inertia
        omega = [_short(x, rows, zero) for x in _forms(m.rotation.motion, inertia.frame)]
        for row, x in zip(inertia.rows, omega, strict=True):
            yield from (Square(w, x, y) for w, y in zip(row, omega, strict=True) if w is not ZERO and x and y)


def _shortest(ways: Sequence[list[Form]], seen: Sequence[Expr]) -> list[Form]:
    price = Prices(seen)
    return min(ways, key=lambda xs: price([c for x in xs for c in x.values()]) + _TERM * sum(map(len, xs)))


def _frames(derived: Derived, m: Moving) -> list[Basis]:
    """Those that the partial velocities are written along, and the body's."""
    found = [f for v in m.center.partials.values() for f, _ in v.parts]
    if m.part.frame is not None:
        found.append(derived.kinematics.aligned.rates(m.part.frame)[0])
    return list(dict.fromkeys(found))


def _forms(motion: Motion, frame: Basis) -> list[Form]:
    """The measure numbers of a velocity along a frame."""
    forms: list[Form] = [{}, {}, {}]
    for u, v in motion.partials.items():
        if isinstance(u, AuxiliarySpeed):
            continue
        for x, c in zip(forms, v.components(frame), strict=True):
            if c is not ZERO:
                x[u] = c
    return forms


def _short(x: Form, rows: Sequence[Form], zero: set[Expr]) -> Form:
    """x without what constraints say is zero."""
    for row in rows:
        for join in (sub, add):
            less = {u: join(x.get(u, ZERO), row.get(u, ZERO)) for u in {**x, **row}}
            less = {u: c for u, c in less.items() if c is not ZERO}
            if len(less) < len(x):
                x = less
    return {u: c for u, c in x.items() if u not in zero}

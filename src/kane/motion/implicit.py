# SPDX-License-Identifier: BSD-3-Clause
"""∂(q̇, u̇, P)/∂(q, u, ∫P dt) of a motion, exact, for methods that solve for a step: Radau, BDF, LSODA.

Written out entry by entry where that is short; of large systems as products with all unit vectors in one native loop, whose code is as
long as a few right-hand sides.
"""

from collections.abc import Callable

import numpy as np

from kane.dynamics.derivatives.slopes import forward, slopes
from kane.dynamics.readings.singular import with_regular_rates
from kane.dynamics.readings.values import without_unknowns
from kane.equations.equations import Equations
from kane.equations.on_demand import along
from kane.equations.routines import ports
from kane.expr.diff import tangent, weighted
from kane.expr.node import ONE, Expr
from kane.motion.collocated import Given
from kane.motion.routines import Routines
from kane.numeric.arrays import Array
from kane.program.bundle import Bundle, Shaped
from kane.program.native.entry import entry, hoisted
from kane.program.program import Port

_STEP = 2.0**-24
"""Share by which inputs and states are moved for differences."""
_LONG = 40_000
"""Operations of the right-hand side times states from which on entries are not written out."""


def _first(x: Array) -> Array:
    return x


def entries(eom: Equations) -> Bundle[Array]:
    """∂(q̇, u̇, P)/∂(q, u)."""
    x, power = eom.state, without_unknowns(eom.solved, [eom.power])
    roots = [*slopes(eom.solved, x).entries, *weighted(power, [ONE], x)]
    shape = (len(x) + 1, len(x))
    return Bundle("slopes", ports(eom.derived), _first, {"x": Shaped(shape, _regular(eom, roots))})


def products(eom: Equations) -> Bundle[Array]:
    """The same times v."""
    x, power = eom.state, without_unknowns(eom.solved, [eom.power])
    v = along("v", x)
    seeds: dict[Expr, Expr] = dict(zip(x, v, strict=True))
    roots = [*forward(eom.solved, x, v), *(tangent(p, seeds, at_rest=True) for p in power)]
    own = (*ports(eom.derived), Port("v", v, noun="direction"))
    return Bundle("products", own, _first, {"x": Shaped((len(x) + 1,), _regular(eom, roots))})


def _regular(eom: Equations, roots: list[Expr]) -> tuple[Expr, ...]:
    return tuple(with_regular_rates(eom.solved, roots))


def by_inputs(now: Routines, t: float, x: Array) -> Array:
    """∂(q̇, u̇, P)/∂r, in which rates are affine as loads are; else differences that steer well enough."""
    r = now.inputs(t, x)
    own = now.rates(t, x, now.p, r)
    steps = np.maximum(np.abs(r), np.abs(r).max(initial=0) or 1.0) * _STEP
    return np.column_stack(
        [(now.rates(t, x, now.p, r + h * e) - own) / h for h, e in zip(steps, np.eye(len(r)), strict=True)]
    )


def gains(now: Routines, t: float, x: Array) -> Array:
    """∂r/∂x of inputs that follow from the state, by differences."""
    r = now.inputs(t, x)
    steps = np.maximum(np.abs(x), np.abs(x).max(initial=0) or 1.0) * _STEP
    return np.column_stack([(now.inputs(t, x + h * e) - r) / h for h, e in zip(steps, np.eye(len(x)), strict=True)])


def is_long(now: Routines) -> bool:
    """Whether J is taken as products."""
    return now.eom.operations.total * now.width > _LONG


def derivatives(now: Routines, t: float, y: Array) -> Given:
    """What a kernel is told of J."""
    eom, long = now.eom, is_long(now)
    routine = eom.numeric(now.settings).routine(products if long else entries).flat
    at = t, y[: now.width], now.p, now.inputs(t, y)
    own, none = entry(routine), entry(now.rates)
    given: Given = {"long": int(long), "jac": none if long else own, "along": own if long else none}
    return given | {"hj": hoisted(routine, *at, *([np.zeros(now.width)] if long else []))}


def exact(now: Routines) -> Callable[[float, Array], Array]:
    """J(t, y). What has no derivative at a state, as a root that ends there, counts as not changing: steps are judged without J."""
    eom, n = now.eom, now.width
    numeric, unit = eom.numeric(now.settings), np.eye(n)
    long = is_long(now)

    def by_entries(t: float, x: Array) -> Array:
        return numeric.routine(entries)(t, x, now.p, now.inputs(t, x))

    def by_products(t: float, x: Array) -> Array:
        return numeric.routine(products)(t, x, now.p, now.inputs(t, x), unit).T

    following = any(getattr(f, "of_state", False) for f in now.drives)

    def j(t: float, y: Array) -> Array:
        whole = np.zeros((n + 1, n + 1))
        found = (by_products if long else by_entries)(t, y[:n])
        if following:
            found = found + by_inputs(now, t, y[:n]) @ gains(now, t, y[:n])
        whole[:, :n] = np.where(np.isfinite(found), found, 0.0)
        return whole

    return j

# SPDX-License-Identifier: BSD-3-Clause
"""∂(q̇, u̇, P)/∂(q, u, ∫P dt) of a motion, exact, for methods that solve for a step: Radau, BDF, LSODA.

Written out entry by entry where that is short; of large systems as products with all unit vectors in one native loop, whose code is as
long as a few right-hand sides.
"""

from collections.abc import Callable, Sequence

import numpy as np

from kane.dynamics.readings.singular import with_regular_rates
from kane.dynamics.readings.values import without_unknowns
from kane.dynamics.slopes import forward, slopes
from kane.equations.equations import Equations
from kane.equations.on_demand import along
from kane.equations.routines import ports
from kane.expr.differentiation import tangent, weighted
from kane.expr.node import ONE, Expr, postorder
from kane.expr.symbols import Symbol
from kane.motion.collocated import Given
from kane.motion.compiled_equations import Routines
from kane.motion.drives import following, follows, law_of
from kane.motion.laws import SharedLaw, law_ports
from kane.numeric.arrays import Array, Mask
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
    return _written(eom, "slopes", _slopes(eom, eom.state))


def closed(eom: Equations, *values: Expr) -> Bundle[Array]:
    """The same where inputs are these expressions of the state: with what they change."""
    x, r = eom.state, eom.inputs
    own, by_input = _slopes(eom, x), _slopes(eom, r)
    gained = [[tangent(value, {s: ONE}, at_rest=True) for s in x] for value in values]
    for i in range(len(x) + 1):
        for j in range(len(x)):
            for k in range(len(r)):
                own[i * len(x) + j] += by_input[i * len(r) + k] * gained[k][j]
    return _written(eom, "closed", own, law_ports(eom, values))


def _slopes(eom: Equations, symbols: Sequence[Symbol]) -> list[Expr]:
    power = without_unknowns(eom.solved, [eom.power])
    return [*slopes(eom.solved, symbols).entries, *weighted(power, [ONE], symbols)]


def _written(eom: Equations, name: str, roots: list[Expr], own: Sequence[Port] = ()) -> Bundle[Array]:
    n = len(eom.state)
    return Bundle(name, own or ports(eom.derived), _first, {"x": Shaped((n + 1, n), _regular(eom, roots))})


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
    """∂r/∂x of inputs that are functions of the state, by differences."""
    r = now.inputs(t, x)
    steps = np.maximum(np.abs(x), np.abs(x).max(initial=0) or 1.0) * _STEP
    return np.column_stack([(now.inputs(t, x + h * e) - r) / h for h, e in zip(steps, np.eye(len(x)), strict=True)])


def is_long(now: Routines) -> bool:
    """Whether J is taken as products."""
    return now.eom.operations.total * now.width > _LONG


def pattern(now: Routines) -> Mask | None:
    """Which entries of J may be other than zero: those of symbols that rates hold; None where inputs follow from the state."""
    if any(getattr(f, "of_state", False) for f in now.drives):
        return None
    return now.eom.numeric(now.settings).value(_held)


def _held(eom: Equations) -> Mask:
    place = {s: 1 << k for k, s in enumerate(eom.state)}
    roots = without_unknowns(eom.solved, [*eom.right_hand_side, eom.power])
    held: dict[Expr, int] = {}
    for node in postorder(roots):
        own = place.get(node, 0)  # type: ignore[call-overload]  # most nodes are no symbols
        for part in node.args:
            own |= held[part]
        held[node] = own
    n = len(eom.state)
    whole = np.zeros((n + 1, n + 1), dtype=bool)
    whole[:, :n] = [[bool(held[root] >> k & 1) for k in range(n)] for root in roots]
    return whole


def derivatives(now: Routines, t: float, y: Array, law: SharedLaw | None) -> Given:
    """What a kernel is told of J."""
    numeric, long, p = now.eom.numeric(now.settings), is_long(now), now.p
    if law is not None and follows(now.drives):
        routine, p = numeric.routine(closed, *law.values).flat, law.parameters(p)
    else:
        routine = numeric.routine(products if long else entries).flat
    at = t, y[: now.width], p, now.inputs(t, y)
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

    def by_law(t: float, x: Array) -> Array:
        return by_values(t, x, p, now.inputs(t, x))

    law = None if long or not follows(now.drives) else law_of(now.drives, now.eom.inputs)
    if law is not None:
        by_values, p = numeric.routine(closed, *law.values), law.parameters(now.p)
    by_law_alone = not law and following(now.drives)

    def j(t: float, y: Array) -> Array:
        whole = np.zeros((n + 1, n + 1))
        found = (by_law if law else by_products if long else by_entries)(t, y[:n])
        if by_law_alone:
            found = found + by_inputs(now, t, y[:n]) @ gains(now, t, y[:n])
        whole[:, :n] = np.where(np.isfinite(found), found, 0.0)
        return whole

    return j

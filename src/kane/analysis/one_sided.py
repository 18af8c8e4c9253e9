# SPDX-License-Identifier: BSD-3-Clause
"""One-sided derivatives of the equations at a state on switching surfaces, and a test whether the sides differ.

A combination of signs s_i = ±1 of switching functions c_i is a side if it can be entered: a direction d exists with s_i ∇c_i·d > 0 for
all i. x |x| and guarded quotients have equal derivatives on both sides, however they are written. A length |v| = √(v·v) has none at
v = 0, but |v| v has: differentiation takes that of √0 as zero, and derivatives at displaced states decide whether this is right.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple, TypeVar

import numpy as np

from kane.analysis.flow import Flow, flow_at, output_slopes
from kane.analysis.local import Outputs, RoutineSource, SwitchValues, all_switches, turning, unknowns
from kane.analysis.state_checks import StateArrays
from kane.dynamics.readings.unsolved import unsolved
from kane.equations.compiled import Numeric, ports
from kane.equations.equations import Equations
from kane.errors import CornerError, SingularError, cut
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import Expr, postorder
from kane.expr.ops import GONE, SQRT
from kane.expr.piecewise import SwitchedQuantity, on_sides, side_symbols
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import balance
from kane.numeric.scale import EQUAL, ROUNDED, ROUNDED_SUM, SIX_DIGITS, UNRELATED
from kane.program.from_expressions import Bundle, Shaped

R = TypeVar("R")
Signs = tuple[float, ...]


class SidedBundles:
    """Bundles of equations with the signs of some switching functions as symbols, evaluated by the reference evaluator."""

    def __init__(self, numeric: Numeric[Equations], quantities: Sequence[Expr]) -> None:
        self.numeric = numeric
        self.sides = side_symbols(quantities)
        self._memo: dict[Expr, Expr] = {}
        self._runs: dict[Any, Callable[..., Any]] = {}

    def on(self, signs: Signs) -> RoutineSource:
        """The routines that evaluate the equations on one side."""

        def run(make: Callable[..., Bundle[R]], *arguments: Any) -> Callable[..., R]:
            key = (make, *arguments)
            if key not in self._runs:
                bundle = self.numeric.value(make, *arguments)
                groups = {
                    name: Shaped(g.shape, tuple(on_sides(root, self.sides, self._memo) for root in g.roots))
                    for name, g in bundle.groups.items()
                }
                own = Bundle(bundle.name, bundle.ports, bundle.record, groups)
                self._runs[key] = _reference(own, *self.sides.values())
            return lambda *given: self._runs[key](*given, signs)

        return run


def _reference(bundle: Bundle[R], *more: Symbol) -> Callable[..., R]:
    """A bundle as a function of numbers for its ports and for further symbols, by the reference evaluator."""
    run = bundle.reference([*(s for port in bundle.ports for s in port.symbols), *more])
    return lambda *given: run([*np.concatenate([np.atleast_1d(v) for v in given])])


_MOST = 6
"""Largest number of switches for which all sides are examined; for more, all on one side, and each one alone on the other."""
_NEAR = (2.0**-16, 2.0**-24, 2.0**-32)
"""Distances from the switching surface at which derivatives are evaluated that have no value on it."""


@dataclass(frozen=True, eq=False)
class Piece:
    """The flow, its outputs and their derivatives on the side `signs` of the switches.

    `gradients` (switches × (ξ_I, u_I, r)) are those of the switching functions, zero if the constraints fix one; `away` is a direction
    into the side, and `blur` an error bound for derivatives that are limits.
    """

    flow: Flow
    signs: Signs
    outputs: Array
    output_slopes: Array
    gradients: Array
    away: Array
    blur: Array | float = 0.0

    @cached_property
    def level(self) -> Array:
        """ẋ and the outputs."""
        return np.append(self.flow.rest, self.outputs)

    @cached_property
    def slopes(self) -> Array:
        """The derivatives [A B; C D]."""
        return np.vstack([np.hstack([self.flow.a, self.flow.b]), self.output_slopes])

    @property
    def finite(self) -> bool:
        """Whether all values and derivatives are finite."""
        return bool(np.isfinite(self.slopes).all() and np.isfinite(self.level).all())


def piece_of(flow: Flow, outputs: Outputs) -> Piece:
    """A flow at which no switch is considered, as a piece."""
    return Piece(flow, (), *output_slopes(flow, outputs), np.zeros((0, 0)), np.zeros(0))


class Corner(NamedTuple):
    """A flow on switching surfaces: `at` indexes the functions of `turning` that are zero, within the tolerances `slack`."""

    flow: Flow
    outputs: Outputs
    at: tuple[int, ...]
    slack: Array


def pieces(corner: Corner, quantities: Sequence[Expr]) -> tuple[Piece, ...]:
    """The one-sided flows at the corner, for switching functions `quantities`."""
    table = SidedBundles(corner.flow.numeric, quantities)
    found = (_piece(corner, signs, table.on(signs)) for signs in _patterns(len(corner.at)))
    return tuple(p for p in found if p is not None)


def _patterns(count: int) -> list[Signs]:
    if count <= _MOST:
        return list(product((1.0, -1.0), repeat=count))
    rows: list[Signs] = []
    for side in (1.0, -1.0):
        rows.append((side,) * count)
        rows += [tuple(-side if j == k else side for j in range(count)) for k in range(count)]
    return rows


def _piece(corner: Corner, signs: Signs, run: RoutineSource) -> Piece | None:
    """The flow on a side, as a limit if it has no derivative at the corner itself; None if no direction leads into the side."""
    state = corner.flow.state
    first = _built(corner, state, signs, run)
    if first is None or first.finite:
        return first
    near = beside(corner.flow, first.away, lambda x, r: _built(corner, replace(state, x=x, r=r), signs, run))
    return first if near is None else replace(near, gradients=first.gradients, away=first.away)


def beside(flow: Flow, d: Array, at: Callable[[Array, Array], Piece | None]) -> Piece | None:
    """The limit along d of the pieces `at` displaced states; None if it is not finite."""
    n = len(flow.state.x)
    changes = [flow.moves @ (h * d) for h in _NEAR]
    near = [at(flow.state.x + c[:n], flow.state.r + c[n:]) for c in changes]
    found = [p for p in near if p is not None and p.finite]
    if len(found) < len(_NEAR):
        return None
    level, slopes = (_limit([getattr(p, what) for p in found]) for what in ("level", "slopes"))
    m = len(flow.rest)
    limit = replace(found[-1].flow, state=flow.state, rest=level[:m], a=slopes[:m, :m], b=slopes[:m, m:])
    blur = np.abs(found[-1].slopes - found[-2].slopes)
    return replace(found[-1], flow=limit, outputs=level[m:], output_slopes=slopes[m:], blur=blur)


def _limit(series: Sequence[Array]) -> Array:
    """The limit of c + a hᵖ from three h in geometric progression (Aitken's Δ² process); the last value if they do not converge."""
    first, second, last = series
    one, two = second - first, last - second
    with np.errstate(all="ignore"):
        limit = last - two**2 / (two - one)
    limit = np.where((np.abs(two) < np.abs(one)) & np.isfinite(limit), limit, last)
    return np.where(np.abs(limit) <= SIX_DIGITS * np.abs(first), 0.0, limit)


def _built(corner: Corner, state: StateArrays, signs: Signs, run: RoutineSource) -> Piece | None:
    flow = corner.flow
    with np.errstate(invalid="ignore"):
        try:
            here = flow_at(flow.numeric, state, flow.choice, run)
        except SingularError:
            return None
        level, slopes = output_slopes(here, corner.outputs)
        own, pick = run(turning, *corner.outputs.roots)(*state.arguments, here.z), list(corner.at)
        gradients = _leaving(own.slopes[pick], np.vstack([here.moves, here.answers]))
    side, c = np.array(signs), own.quantities[pick]
    off = np.abs(c) > np.maximum(GONE * own.sizes[pick], corner.slack)
    if (off & (side * c < 0)).any():  # other switches force this one to its other side
        return None
    gradients = np.where(off[:, None], 0.0, gradients)
    away = _direction(side[:, None] * gradients)
    return None if away is None else Piece(here, signs, level, slopes, gradients, away)


def _leaving(rows: Array, moves: Array) -> Array:
    """∇c along the allowed changes, with rounding residues set to zero; `moves` need not be finite where c does not depend on it."""
    terms = np.where(rows[:, :, None] == 0, 0.0, rows[:, :, None] * moves[None])
    found = terms.sum(axis=1)
    return np.asarray(np.where(np.abs(found) <= ROUNDED * np.abs(terms).sum(axis=1), 0.0, found))


def _direction(rows: Array) -> Array | None:
    """A direction d with row·d > 0 for all nonzero rows; None if none exists."""
    rows = rows[np.abs(rows).max(axis=1, initial=0) > 0]
    width = rows.shape[1]
    if not len(rows):
        return np.zeros(width)
    scaled = balance(rows, order=(0, 1))
    d = np.asarray(np.linalg.lstsq(scaled.matrix, np.ones(len(rows)))[0], dtype=np.float64)
    if not (scaled.matrix @ d > 0.5).all():
        from scipy.optimize import linprog

        above = np.hstack([-scaled.matrix, np.ones((len(rows), 1))])
        best = linprog([*[0.0] * width, -1.0], above, np.zeros(len(rows)), bounds=[(-1, 1)] * width + [(None, 1)])
        found = np.asarray(best.x if best.success else np.zeros(width + 1), dtype=np.float64)
        if not found[-1] > UNRELATED:
            return None
        d = found[:-1]
    d = d / scaled.columns[0]
    return np.asarray(d / np.abs(d).max())


_AS_ZERO = 1e-4
"""Fraction of the tolerance of a steady state within which a switching function counts as zero there."""


class Sides(NamedTuple):
    """The one-sided flows at a corner, and its switches."""

    corner: Corner
    switches: tuple[SwitchedQuantity, ...]
    pieces: tuple[Piece, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the states and inputs."""
        flow = self.corner.flow
        return (*flow.states, *(r.name for r in flow.numeric.equations.inputs))


def sides_at(flow: Flow, outputs: Outputs, tolerance: float) -> Sides | None:
    """The one-sided flows for switches that are zero at the flow's state; None if there are none.

    A switching function is zero within the rounding of its terms and, at a state that is steady up to a `tolerance`, within its error.
    """
    numeric = flow.numeric
    table = numeric.value(all_switches, *outputs.roots)
    if not table:
        return None
    own = numeric.value(_watch, *outputs.roots)(*flow.state.arguments, flow.z)
    c, zero = np.abs(own.quantities), GONE * own.sizes
    if tolerance > 0 and np.isfinite(flow.a).all():
        change = own.slopes @ np.vstack([flow.moves, flow.answers])[:, : len(flow.a)]
        zero = np.maximum(zero, _AS_ZERO * tolerance * np.abs(change @ np.linalg.pinv(flow.a)) @ flow.terms)
    at = tuple(np.flatnonzero(c <= zero).tolist())
    if not at:
        return None
    corner = Corner(flow, outputs, at, zero[list(at)])
    standing = tuple(table[k] for k in at)
    return Sides(corner, standing, pieces(corner, [s.quantity for s in standing]))


def _watch(eom: Equations, *outputs: Expr) -> Callable[..., SwitchValues]:
    return _reference(turning(eom, *outputs))


# Differences between sides -----------------------------------------------------------------------------------------------


class Difference(NamedTuple):
    """Indices of the switches at which the sides differ, and which of ẋ and the outputs jump."""

    switches: tuple[int, ...]
    jumps: Mask

    def __bool__(self) -> bool:
        return bool(self.switches)


def difference(sides: Sides) -> Difference:
    """The differences between the one-sided flows."""
    every = sides.pieces
    if not every:
        return Difference((), np.zeros(0, dtype=bool))
    slopes, level = different_slopes(every), _different_levels(sides)
    count = len(every)
    pairs = [(i, j) for i in range(count) for j in range(i) if slopes[i, j] or level[i, j].any()]
    turned = [
        [k for k, (a, b) in enumerate(zip(every[i].signs, every[j].signs, strict=True)) if a != b] for i, j in pairs
    ]
    least = min(map(len, turned), default=0)
    found = {k for some in turned if len(some) == least for k in some}
    return Difference(tuple(sorted(found)), np.asarray(level.any(axis=(0, 1))))


def different_slopes(every: Sequence[Piece]) -> Mask:
    """Which pairs of pieces have different derivatives (pieces × pieces)."""
    alike = np.array([p.flow.states == every[0].flow.states for p in every])
    own = [p.slopes if ok else every[0].slopes for p, ok in zip(every, alike, strict=True)]
    table = np.array(own)
    finite = np.isfinite(table)
    scale = balance(np.where(finite, np.abs(table), 0.0).max(axis=0))
    scaled = table / (scale.rows * scale.columns)
    blur = np.array([np.broadcast_to(p.blur, table.shape[1:]) for p in every]) / (scale.rows * scale.columns)
    with np.errstate(invalid="ignore"):
        apart = ~(np.abs(scaled[:, None] - scaled[None]) <= ROUNDED_SUM + blur[:, None] + blur[None])
    both = ~finite[:, None] & ~finite[None]
    return np.asarray(
        (apart & ~both).any(axis=(2, 3)) | (alike[:, None] != alike[None]) | ~alike[:, None] & ~alike[None]
    )


def _different_levels(sides: Sides) -> Mask:
    """Which of ẋ and the outputs differ between pieces (pieces × pieces × values).

    Differences are not counted if the rounding error of the switching functions, times the difference of derivatives, explains them.
    """
    every = sides.pieces
    level = np.array([p.level for p in every])
    shape = every[0].slopes.shape
    slopes = np.array([p.slopes if p.slopes.shape == shape else every[0].slopes for p in every])
    apart = np.abs(level[:, None] - level[None])
    noise = EQUAL * (np.abs(level[:, None]) + np.abs(level[None]))
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.array([np.abs(p.gradients) for p in every]).max(axis=0)
        step = np.where(reach > 0, sides.corner.slack[:, None] / reach, 0.0).max(axis=0, initial=0)
        noise = noise + 10 * np.nan_to_num(np.abs(slopes[:, None] - slopes[None]) @ step)
        return np.asarray(apart > noise)


class Lengths(NamedTuple):
    """The squares s of all lengths √s, and the sizes of their terms."""

    squares: Array
    sizes: Array


def lengths(eom: Equations, *outputs: Expr) -> tuple[Expr, ...]:
    """The square roots √s in the unsolved equations and in outputs."""
    u = unsolved(eom.derived)
    order = postorder((*u.places, *u.residual, *outputs))
    return tuple(n for n in order if n.op is SQRT and not is_constant_in_time(n.args))


def _measured(eom: Equations, *outputs: Expr) -> Callable[..., Lengths]:
    z, memo = unknowns(eom), Sizes()
    squares = [n.args[0] for n in lengths(eom, *outputs)]
    groups = {"squares": squares, "sizes": [size(s, memo) for s in squares]}
    return _reference(Bundle("lengths", (*ports(eom.derived), z), Lengths, groups))


def check_cones(flow: Flow, outputs: Outputs) -> None:
    """Raise CornerError if a length is zero at the flow's state and derivatives at displaced states depend on the direction."""
    table = flow.numeric.value(lengths, *outputs.roots)
    if not table:
        return
    own = flow.numeric.value(_measured, *outputs.roots)(*flow.state.arguments, flow.z)
    standing = [n for n, s, size in zip(table, own.squares, own.sizes, strict=True) if s <= (2 * GONE) ** 2 * size]
    if not standing:
        return
    here = piece_of(flow, outputs)
    width = flow.moves.shape[1]
    mixed = np.sqrt(1.0 + np.arange(width))
    for d in (*np.eye(width), *-np.eye(width), mixed, -mixed, mixed * (-1.0) ** np.arange(width)):
        there = _tends(flow, outputs, d)
        if there is None or different_slopes((here, there)).any():
            what = ", ".join(f"{cut(str(n), 80)} = 0" for n in standing[:3])
            raise CornerError(
                f"Expected a state at which the equations have one derivative, got one at which {what}: derivatives nearby "
                "depend on the direction in which the state is left. Choose a nearby state, or give the length a small eps, "
                "sqrt(v.dot(v) + eps^2)."
            )


def _tends(flow: Flow, outputs: Outputs, d: Array) -> Piece | None:
    """The limit of derivatives and values along d at displaced states; None if it is not finite."""

    def at(x: Array, r: Array) -> Piece | None:
        try:
            return piece_of(flow_at(flow.numeric, replace(flow.state, x=x, r=r), flow.choice, flow.run), outputs)
        except SingularError:
            return None

    with np.errstate(invalid="ignore", divide="ignore"):
        return beside(flow, d, at)

# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of the equations on switching surfaces: the common one, that on a given side, or an error that names the switches.

A combination of signs s_i = ±1 of switching functions c_i is a side if it can be entered: a direction d exists with s_i ∇c_i·d > 0 for
all i. x |x| and guarded quotients have equal derivatives on both sides, however they are written. A length |v| = √(v·v) has none at
v = 0, but |v| v has: differentiation takes that of √0 as zero, and derivatives at displaced states decide whether this is right.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple, TypeVar

import numpy as np

from kane import expect
from kane.analysis.flow import Flow, Preference, flow_at, output_slopes
from kane.analysis.local import Outputs, RoutineSource, SwitchValues, all_switches, turning, unknowns
from kane.analysis.state_checks import StateArrays
from kane.dynamics.readings.unsolved import unsolved
from kane.equations.compiled import Numeric, ports
from kane.equations.equations import Equations
from kane.errors import CornerError, SingularError, ValueMissingError, cut, warn
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import Expr, postorder
from kane.expr.ops import GONE, SQRT
from kane.expr.piecewise import SwitchedQuantity, on_sides, side_symbols
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import balance
from kane.numeric.sampling import finite_number
from kane.numeric.scale import EPS, EQUAL, ROUNDED, ROUNDED_SUM, SIX_DIGITS, UNRELATED
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


_TOLD = 3

Side = Mapping[Any, float]


def differentiable(flow: Flow, outputs: Outputs, tolerance: float, side: Side | None = None) -> Piece:
    """The flow and its outputs with their derivatives, on the given `side` if the sides differ.

    `tolerance` is that of a steady state, 0 for other states.

    Raises
    ------
    CornerError
        if the sides differ and none is given, or the direction leads into none of them
    """
    if side is not None:
        check_side((*flow.states, *(r.name for r in flow.numeric.equations.inputs)), side)
    own = piece_of(flow, outputs)
    sides = sides_at(flow, outputs, tolerance)
    if sides is not None and difference(sides):
        if side is None:
            raise corner_error(sides)
        own = one_side(sides, side)
    elif sides is not None and sides.pieces and different_slopes((own, sides.pieces[0])).any():
        # differentiation at the corner itself may be wrong: it yields sign² x for the expression x |x|
        own = sides.pieces[0]
    elif own.finite:
        check_cones(flow, outputs)
    if not own.finite:
        raise SingularError(_not_finite(own))
    return own


def _not_finite(piece: Piece) -> str:
    flow = piece.flow
    rows = [*(f"{s}'" for s in flow.states), *(f"output {k + 1}" for k in range(len(piece.outputs)))]
    i, j = np.argwhere(~np.isfinite(np.column_stack([piece.slopes, piece.level])))[0]
    what = f"a derivative of {rows[i]}" if j < piece.slopes.shape[1] else rows[i]
    return (
        f"Expected equations with finite derivatives at this state, got infinity or NaN as {what}: a root, a power or a "
        "quotient has no derivative here. Choose a nearby state."
    )


def check_side(names: Sequence[str], side: Side) -> dict[str, float]:
    """The direction by name; raises ValueMissingError for names that are not states or inputs (`names`)."""
    expected = f"side= as a direction in states and inputs ({', '.join(names)}), such as {{{names[0]!r}: 1}}"
    expect.instance(side, Mapping, expected, error=ValueMissingError)
    told = {(k.name if isinstance(k, Symbol) else k): finite_number("direction", str(k), v) for k, v in side.items()}
    unknown = [str(n) for n in told if n not in names]
    came, cure = ", ".join(unknown) or "none", "Choose by independent= which of the perturbations are states."
    expect.that(not unknown and any(told.values()), expected, came=came, cure=cure, error=ValueMissingError)
    return told


def one_side(sides: Sides, side: Side) -> Piece:
    """The one-sided flow into which the direction leads.

    Raises
    ------
    CornerError
        if the direction stays on the surface of a switch at which the sides differ
    """
    d = np.array([check_side(sides.names, side).get(n, 0.0) for n in sides.names])
    along = _led_into(sides.pieces, d)
    first = along[0] if along else None
    left = difference(Sides(sides.corner, sides.switches, tuple(along)))
    if first is None or left or not first.finite:
        open_ = left.switches or range(len(sides.switches))
        what = ", ".join(cut(str(sides.switches[k].quantity)) for k in open_)
        raise CornerError(
            f"Expected side= as a direction in which {what} becomes positive or negative, got one along which it stays zero, "
            f"or where derivatives are not finite: {dict(side)!r}. {_offer(sides)}"
        )
    return first


def _led_into(every: Sequence[Piece], d: Array) -> list[Piece]:
    """The one-sided flows into which a direction leads, or along whose boundary."""
    return [p for p in every if (p.signs * (p.gradients @ d) >= -EPS * (np.abs(p.gradients) @ np.abs(d))).all()]


def warn_of_jumps(numeric: Numeric[Equations], state: StateArrays, tolerance: float) -> None:
    """Warn if accelerations jump at a steady state, which then need not persist after small disturbances."""
    if not numeric.value(all_switches):
        return
    try:
        sides = sides_at(flow_at(numeric, state, Preference()), Outputs((), ()), tolerance)
    except SingularError:
        return
    found = difference(sides) if sides else None
    if sides and found and found.jumps.any():
        warn(
            "Expected a steady motion that persists after small disturbances, got one at which "
            f"{difference_text(sides, found)}: {jumping(sides, found)}. It persists only if the accelerations on both sides "
            "lead back to it, as with dry friction at rest."
        )


# Messages ----------------------------------------------------------------------------------------------------------------


def corner_error(sides: Sides) -> CornerError:
    """The error that names the switches at which the derivatives differ, with its cure."""
    found = difference(sides)
    what = difference_text(sides, found)
    if found.jumps.any():
        error = CornerError(
            f"Expected a state at which the equations have a value and a derivative, got one at which {what}: "
            f"{jumping(sides, found)}. {_offer(sides, 'steady=False')} Or make it smooth: kn.friction(…, smooth=…), "
            "kn.dry_friction(…, smooth=…), tanh(c/eps)."
        )
    else:
        error = CornerError(
            f"Expected a state at which the equations have one derivative, got one on a corner: {what}, and the derivatives "
            f"on its sides differ. {_offer(sides)} Or choose a nearby state."
        )
    error.names = sides.names
    return error


def difference_text(sides: Sides, found: Difference) -> str:
    """The switches at which sides differ, with their switching functions and declarations, in words."""
    eom = sides.corner.flow.numeric.equations
    texts = []
    for k in found.switches[:_TOLD]:
        s = sides.switches[k]
        node, place = _declaration_of(eom, sides.corner.outputs, s.nodes)
        texts.append(f"{cut(str(node), 80)}{place} switches at {cut(str(s.quantity))} = 0")
    more = len(found.switches) - _TOLD
    return "; ".join(texts) + (f"; and {more} more" if more > 0 else "")


def _declaration_of(eom: Equations, outputs: Outputs, nodes: Sequence[Expr]) -> tuple[Expr, str]:
    """The node among `nodes` that a declaration contains, and the name of that declaration."""
    wanted = set(nodes)
    loads = eom.solved.regular.declared_loads
    declared: list[tuple[str, Iterable[Expr]]] = [
        *((f" in the {x.name}", (e for _, v in (*x.forces, *x.torques) for e in v.scalars())) for x in loads),
        *((f" in the constraint {c.name!r}", [c.expr]) for c in eom.system.holonomic),
        *((f" in the output {n!r}", [e]) for n, e in zip(outputs.names, outputs.roots, strict=True)),
    ]
    for place, roots in declared:
        for node in postorder(roots):
            if node in wanted:
                return node, place
    return nodes[0], ""


def jumping(sides: Sides, found: Difference) -> str:
    """The quantities that jump, with their values, in words."""
    flow, every = sides.corner.flow, sides.pieces
    names = [*(f"{s}'" for s in flow.states), *sides.corner.outputs.names]
    texts = []
    for k in np.flatnonzero(found.jumps)[:_TOLD]:
        values = [p.level[k] for p in every]
        texts.append(f"{names[k]} jumps between {min(values):.6g} and {max(values):.6g}")
    return ", ".join(texts)


def _offer(sides: Sides, also: str = "") -> str:
    """Advice of directions that lead into a single side, along one state or input if possible."""
    names, tail = sides.names, f", {also}" if also else ""

    def leads(d: Array) -> bool:
        into = _led_into(sides.pieces, d)
        return bool(into) and into[0].finite and not difference(Sides(sides.corner, sides.switches, tuple(into)))

    for j, name in enumerate(names):
        d = np.eye(len(names))[j]
        if leads(d) and leads(-d):
            one, other = ({name: sign} for sign in (1, -1))
            return f"For a one-sided derivative give the direction in which the state is left: side={one} or side={other}{tail}."
    for p in sides.pieces:
        d = np.round(p.away, 1)
        if leads(d):
            such = {n: float(v) for n, v in zip(names, d, strict=True) if v}
            return (
                f"For a one-sided derivative give the direction in which the state is left, such as side={such}{tail}."
            )
    return "No direction has a finite one-sided derivative."

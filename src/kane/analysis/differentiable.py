# SPDX-License-Identifier: BSD-3-Clause
"""The derivative of a flow at a state on switching surfaces: the common one, that on a given side, or an error naming the switches."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from kane import expect
from kane.analysis.flow import Flow, Preference, flow_at
from kane.analysis.local import Outputs, all_switches
from kane.analysis.one_sided import (
    Difference,
    Piece,
    Sides,
    check_cones,
    difference,
    different_slopes,
    piece_of,
    sides_at,
)
from kane.analysis.state_checks import StateArrays
from kane.equations.compiled import Numeric
from kane.equations.equations import Equations
from kane.errors import CornerError, SingularError, ValueMissingError, cut, warn
from kane.expr.node import Expr, postorder
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.numeric.sampling import finite_number
from kane.numeric.scale import EPS

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

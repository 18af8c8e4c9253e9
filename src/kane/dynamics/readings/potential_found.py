# SPDX-License-Identifier: BSD-3-Clause
"""A potential energy found from the forces: V with F_r = −Σ_s ∂V/∂q_s W_sr, or the reason why there is none.

(Kane & Levinson 1985, sec. 5.1.) Whatever the speeds are, the forces Q_s of the rates tell: V exists where ∂Q_s/∂q_t = ∂Q_t/∂q_s.
Under constraints forces of these may be added first (`potential_held`). What is found is differentiated back.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from kane import show
from kane.dynamics.derivation import Derived
from kane.dynamics.readings.line_integral import NODES, line_integral
from kane.dynamics.readings.potential_held import check_allowed, held
from kane.dynamics.readings.rate_forces import Place, by_rates, differs, measured, places, rows_in_rates
from kane.errors import KaneError, PotentialError, cut
from kane.expr.build import neg
from kane.expr.differentiation import diff
from kane.expr.evaluation import free_symbols
from kane.expr.immutable import Immutable
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.size import size
from kane.expr.symbols import Coordinate, QuasiRate, Rate, Reaction, Speed, Symbol, input_of
from kane.expr.visit import substituted
from kane.model.loads import Load
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED_CHAIN

_LEAST = 2
"""Places at which numbers must be finite."""

Exprs = tuple[Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class FoundPotential(Immutable):
    """V of some loads, an expression of coordinates, and `how` it was integrated.

    Attributes
    ----------
    value : V, with F_r = −Σ_s ∂V/∂q_s W_sr, or F̃_r likewise
    how : "closed form", or by which rule and along which coordinates
    loads : whose forces it is that of
    """

    value: Expr
    how: str
    loads: tuple[Load, ...]

    _repr_latex_ = show.latex

    def __repr__(self) -> str:
        return f"FoundPotential({cut(self.value)}; {self.how})"


def find_potential(derived: Derived, loads: Sequence[Any] | None = None) -> FoundPotential:
    """See Equations.find_potential."""
    if loads is not None and (isinstance(loads, str) or not isinstance(loads, Iterable)):
        loads = (loads,)
    own = derived.system.all_loads() if loads is None else tuple(_own(derived, x) for x in loads)
    q = derived.system.coordinates
    forces = _of_coordinates(by_rates(derived, own), own)
    sets = [s.coordinates for s in derived.system.euler_parameters]
    at = places([*forces, *q], unit=sets)
    gap = _gap(forces, q, at)
    if gap is None:
        return _integrated(forces, q, own, at)
    if not derived.constraints.constraints and not sets:
        raise PotentialError(_reason(forces, q, own, *gap))
    rows = rows_in_rates(derived)
    check_allowed(derived, forces, rows, _names(own))
    for kept, changed in held(forces, rows, q, at[0]):
        try:
            if not _moved_by(changed, [s for s in q if s not in set(kept)], at) and _gap(changed, kept, at) is None:
                return _integrated(changed, kept, own, at)
        except KaneError:
            continue
    raise PotentialError(
        f"Expected a potential energy under the constraints, got none for {_names(own)}: they may let one exist, but no forces of "
        "constraints were found that leave it over. Declare it: Load(…, potential=V) is compared with the forces."
    )


def _own(derived: Derived, load: Any) -> Load:
    system = derived.system
    listed, written = (*system.gravities, *system.loads), system.all_loads()
    name = load.name if isinstance(load, Load) else load if isinstance(load, str) else None
    for x, meant in zip(listed, written, strict=True):
        if load is x or name == meant.name:
            return meant
    names = ", ".join(x.name for x in written) or "none"
    raise PotentialError(f"Expected some of the loads of the system ({names}), got {cut(repr(load))}.")


def _names(loads: Sequence[Load]) -> str:
    return " and ".join(repr(x.name) for x in loads) or "no loads"


def _of_coordinates(forces: Exprs, loads: Sequence[Load]) -> Exprs:
    """The forces without rates and speeds, on which they must not depend."""
    moving = [
        s for s in free_symbols(forces) if isinstance(s, Rate | QuasiRate | Speed | Reaction) and input_of(s) is None
    ]
    at = places([*forces, *moving])
    for s in moving:
        if differs([[diff(f, s)] for f in forces], at)[1].any():
            kind = "the reaction" if isinstance(s, Reaction) else "the speed" if isinstance(s, Speed) else "the rate"
            raise PotentialError(
                f"Expected forces that follow from the coordinates, got {_names(loads)}, which depend on {kind} {s}: they have no "
                "potential energy. Name the other loads, eom.find_potential([…]); what these do is power."
            )
    still: dict[Expr, Expr] = dict.fromkeys(moving, ZERO)
    return tuple(substituted(f, still) for f in forces)


def _gap(forces: Sequence[Expr], q: Sequence[Symbol], at: Sequence[Place]) -> tuple[int, int, int] | None:
    """The pair of coordinates whose cross derivatives differ most, and the place; None where none do."""
    pairs = list(combinations(range(len(q)), 2))
    if not pairs:
        return None
    values, wrong = differs([[diff(forces[i], q[j]), neg(diff(forces[j], q[i]))] for i, j in pairs], at)
    _check_finite(values)
    if not wrong.any():
        return None
    share = np.where(wrong, np.abs(values), -1.0)
    place, pair = np.unravel_index(int(np.argmax(share)), share.shape)
    return int(place), *pairs[int(pair)]


def _moved_by(forces: Exprs, others: Sequence[Symbol], at: Sequence[Place]) -> bool:
    values, wrong = differs([[diff(f, s)] for f in forces for s in others], at)
    _check_finite(values)
    return bool(wrong.any())


def _check_finite(values: Array) -> None:
    if np.isfinite(values).all(axis=1).sum() < _LEAST:
        raise PotentialError(
            "Expected forces with finite derivatives, got infinity or NaN nearly everywhere that was looked at, with coordinates "
            "between -1.2 and 1.2. Declare the potential: Load(…, potential=V)."
        )


def _reason(forces: Exprs, q: Sequence[Coordinate], loads: Sequence[Load], place: int, i: int, j: int) -> str:
    a, b = diff(forces[i], q[j]), diff(forces[j], q[i])
    at = places([*forces, *q])[place]
    left, right = measured([a, b], [at])[0]
    where = ", ".join(f"{s} = {at[s]:.4g}" for s in q if s in at)
    return (
        f"Expected forces with a potential energy, got {_names(loads)}, which have none: with Q the forces by rates, "
        f"∂Q_{q[i]}/∂{q[j]} = {left:.6g} but ∂Q_{q[j]}/∂{q[i]} = {right:.6g} at {where}, so that their work depends on the way. Name "
        "the other loads, eom.find_potential([…]); what these do is power."
    )


# Integrated --------------------------------------------------------------------------------------------------------------


def _integrated(
    forces: Sequence[Expr], q: Sequence[Coordinate], loads: tuple[Load, ...], at: Sequence[Place]
) -> FoundPotential:
    """V along lines, in a few orders of the coordinates and from two bases; the first that holds, in closed form if there is one."""
    by_rule: FoundPotential | None = None
    for base in (ZERO, ONE):
        for order in (range(len(q)), range(len(q) - 1, -1, -1)):
            try:
                found = line_integral([neg(forces[i]) for i in order], [q[i] for i in order], base)
            except KaneError:
                continue
            if not _holds(found.value, forces, q, at):
                continue
            if not found.by_rule:
                return FoundPotential(found.value, "closed form", loads)
            along = ", ".join(s.name for s in found.by_rule)
            by_rule = by_rule or FoundPotential(found.value, f"Gauss's rule of {NODES} points along {along}", loads)
    if by_rule is not None:
        return by_rule
    raise PotentialError(
        f"Expected forces that can be integrated, got {_names(loads)}: they have a potential energy, but neither a closed form nor "
        f"Gauss's rule of {NODES} points gives it. Declare it: Load(…, potential=V)."
    )


def _holds(v: Expr, forces: Sequence[Expr], q: Sequence[Symbol], at: Sequence[Place]) -> bool:
    """Whether −∂V/∂q are the forces; what Gauss's rule leaves is small beside all terms, not beside their sum."""
    slopes, memo = [diff(v, s) for s in q], dict[Expr, tuple[Expr, ...]]()
    values, wrong = differs(list(zip(slopes, forces, strict=True)), at)
    sizes = measured([size(e, memo) for pair in zip(slopes, forces, strict=True) for e in pair], at)
    finite = np.isfinite(values).all(axis=1)
    whole = np.nan_to_num(sizes).reshape(len(at), len(q), 2).sum(axis=2)
    return int(finite.sum()) >= _LEAST and not (wrong & (np.abs(values) > ROUNDED_CHAIN * whole))[finite].any()

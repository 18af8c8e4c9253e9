# SPDX-License-Identifier: BSD-3-Clause
"""A potential energy from the forces: V with F_r = −Σ_s ∂V/∂q_s W_sr, or why there is none; a declared one against its forces.

(Kane & Levinson 1985, sec. 5.1.) Whatever the speeds are, the forces Q_s of the rates decide: V exists where ∂Q_s/∂q_t =
∂Q_t/∂q_s. It is integrated along lines, one a coordinate,

    V = −Σ_k ∫ Q_k(q₁, …, q_{k−1}, s, b, …, b) ds        from the base b to q_k

in closed form or by Gauss's rule, and differentiated back. Constraints C q̇ + c = 0 let forces be changed: Q + Cᵀλ does the same
work. Along motions that they allow dQ + Σ λ_k dC_k must vanish. Where no λ does that, at some configuration, there is no V. Else λ
is such that some coordinates have no force, or solved for from that condition.

A declared potential is compared at random states, Σ F·∂v/∂q̇ + Σ T·∂ω/∂q̇ = −∂V/∂q; where there are constraints, at configurations
that satisfy them, but for what is along a constraint's force.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, islice
from typing import Any, NamedTuple

import numpy as np

from kane import show
from kane.dynamics.derivation import Derived
from kane.dynamics.in_rates import InRates
from kane.dynamics.readings.contributions import Place, by_rates, differs, measured, sample_points, states
from kane.errors import KaneError, PotentialError, cut, warn
from kane.expect import is_list
from kane.expr.build import add, mul, neg, sub, sum_of
from kane.expr.differentiation import diff, gradient
from kane.expr.evaluation import free_symbols, price
from kane.expr.forms.collect import expanded, factored
from kane.expr.forms.integration import antiderivative
from kane.expr.matrix import invert
from kane.expr.node import ONE, ZERO, Expr, Exprs, constant
from kane.expr.ops import Immutable
from kane.expr.regular import size
from kane.expr.symbols import Coordinate, QuasiRate, Rate, Reaction, Speed, Symbol, input_of
from kane.expr.visit import substituted
from kane.model.loads import Load
from kane.numeric.arrays import Array, Mask
from kane.numeric.polynomials import gauss
from kane.numeric.rank import singular
from kane.numeric.scale import ROUNDED_CHAIN, ROUNDED_ROOT, SIX_DIGITS, STATE_RANK, bounded

NODES = 20
"""Of Gauss's rule."""


class LineIntegral(NamedTuple):
    """A potential, and the symbols along which Gauss's rule was taken."""

    value: Expr
    by_rule: tuple[Symbol, ...]


def line_integral(slopes: Sequence[Expr], symbols: Sequence[Symbol], base: Expr = ZERO) -> LineIntegral:
    """V from its `slopes` in the `symbols`, zero where these are the base, but for a constant of the first part."""
    total, by_rule = ZERO, []
    for k, (p, x) in enumerate(zip(slopes, symbols, strict=True)):
        own = substituted(p, dict.fromkeys(symbols[k + 1 :], base))
        part = antiderivative(own, x)
        if part is None:
            part = _by_gauss(own, x, base)
            by_rule.append(x)
        elif any(s in set(symbols[:k]) for s in free_symbols([part])):
            part = sub(part, substituted(part, {x: base}))
        total = add(total, part)
    return LineIntegral(_short(total), tuple(by_rule))


def _by_gauss(e: Expr, x: Symbol, base: Expr) -> Expr:
    """∫ e dx from the base by Gauss's rule."""
    reach, total = sub(x, base), ZERO
    for place, weight in zip(*gauss(NODES), strict=True):
        at = add(base, mul(constant(float(place)), reach))
        total = add(total, mul(constant(float(weight)), substituted(e, {x: at})))
    return mul(reach, total)


def _short(e: Expr) -> Expr:
    """What cancels between the parts left out, where that is shorter."""
    terms = expanded(e)
    if terms is None:
        return e
    forms = [e, factored(terms)]
    return min(forms, key=lambda form: price([form]))


Rows = list[list[Expr]]
Held = tuple[tuple[Coordinate, ...], Exprs]

_SETS, _FEW = 24, 4
"""Sets of coordinates that are tried as those that V does without, and as those that the others give."""


def check_allowed(derived: Derived, forces: Exprs, rows: Rows, names: str) -> None:
    """Raise where no λ makes dQ + Σ λ_k dC_k vanish along the motions that the constraints allow, at some configuration.

    Where λ = 0 is the only one, at all of them, Q itself would have to do, and does not.
    """
    q = derived.system.coordinates
    n, whole = len(q), [*forces, *(x for row in rows for x in row), *q]
    own = states(derived, whole)
    c = measured([x for row in rows for x in row], own).reshape(len(own), len(rows), n)
    tables = [measured([diff(f[i], x) for i in range(n) for x in q], own) for f in (forces, *rows)]
    alone: list[int] = []
    for k in range(len(own)):
        turns = [t[k].reshape(n, n) - t[k].reshape(n, n).T for t in tables]
        if not np.isfinite(turns).all() or not np.isfinite(c[k]).all():
            continue
        free = singular(c[k]).kernel(STATE_RANK).T
        inside = np.triu_indices(free.shape[1], 1)
        within = [(free.T @ t @ free)[inside] for t in turns]
        bound = ROUNDED_ROOT * np.linalg.norm(
            (np.abs(free).T @ (2 * np.abs(tables[0][k].reshape(n, n))) @ np.abs(free))[inside]
        )
        others = np.array(within[1:]).reshape(len(rows), -1).T
        weights, _, rank, _ = np.linalg.lstsq(others, within[0], rcond=None)
        if np.linalg.norm(within[0] - others @ weights) > bound:
            raise PotentialError(_not_allowed(names, q, own[k]))
        alone.append(k if rank == len(rows) and np.linalg.norm(others @ weights) <= bound else -1)
    if alone and min(alone) >= 0:
        raise PotentialError(_not_allowed(names, q, own[0]))


def _not_allowed(names: str, q: Sequence[Coordinate], at: Place) -> str:
    where = ", ".join(f"{s} = {at[s]:.4g}" for s in q)
    return (
        f"Expected forces with a potential energy, got {names}, which have none along the motions that the constraints allow: "
        f"near {where} their work depends on the path, whatever constraint forces are added. Pass only the other loads, "
        "eom.find_potential([…]); the work of these counts as power."
    )


def conservative_candidates(forces: Exprs, rows: Rows, q: Sequence[Coordinate], at: Place) -> Iterator[Held]:
    """Forces Q + Cᵀλ that may have a potential energy, and whose they are; first with λ for which some have none."""
    for gone, kept, inverse in _inverses(rows, len(q)):
        weights = [sum_of(mul(x, forces[i]) for x, i in zip(line, gone, strict=True)) for line in inverse]
        yield tuple(q[i] for i in kept), _added(forces, rows, weights, kept)
    yield from _by_multipliers(forces, rows, q, at)


def _inverses(rows: Rows, n: int) -> Iterator[tuple[tuple[int, ...], list[int], list[list[Expr]]]]:
    """Sets of coordinates that the others give, the others, and the inverse of their columns of C, transposed."""
    for gone in islice(combinations(reversed(range(n)), len(rows)), _SETS):
        try:
            inverse = invert([[row[i] for row in rows] for i in gone]).rows
        except KaneError:
            continue
        yield gone, [i for i in range(n) if i not in gone], inverse


def _by_multipliers(forces: Exprs, rows: Rows, q: Sequence[Coordinate], at: Place) -> Iterator[Held]:
    """With the λ that dQ + Σ λ_k dC_k = 0 gives along as many pairs of allowed directions as there are λ."""
    n = len(q)
    for gone, kept, inverse in islice(_inverses(rows, n), _FEW):
        allowed = [_direction(i, gone, inverse, rows, n) for i in kept]
        pairs = list(combinations(allowed, 2))
        table = [[_turn(row, x, y, q) for row in rows] for x, y in pairs]
        numbers = measured([x for line in table for x in line], [at]).reshape(len(pairs), len(rows))
        chosen = _independent(numbers, len(rows))
        if chosen is None:
            continue
        try:
            solved = invert([table[k] for k in chosen]).rows
        except KaneError:
            continue
        right = [_turn(forces, *pairs[k], q) for k in chosen]
        weights = [sum_of(mul(x, r) for x, r in zip(line, right, strict=True)) for line in solved]
        yield tuple(q), _added(forces, rows, weights, range(n))


def _added(forces: Exprs, rows: Rows, weights: Sequence[Expr], kept: Sequence[int]) -> Exprs:
    """Q − Cᵀ w of some coordinates."""
    return tuple(sub(forces[i], sum_of(mul(row[i], w) for row, w in zip(rows, weights, strict=True))) for i in kept)


def _direction(i: int, gone: Sequence[int], inverse: Rows, rows: Rows, n: int) -> list[Expr]:
    """The rates of all coordinates, where that of one is 1 and the others that are not given are 0."""
    result = [ONE if k == i else ZERO for k in range(n)]
    for j, g in enumerate(gone):
        result[g] = neg(sum_of(mul(line[j], row[i]) for line, row in zip(inverse, rows, strict=True)))
    return result


def _turn(form: Sequence[Expr], x: Sequence[Expr], y: Sequence[Expr], q: Sequence[Coordinate]) -> Expr:
    """Σ (∂w_t/∂q_s − ∂w_s/∂q_t) x_s y_t."""
    return sum_of(
        mul(sub(diff(form[t], q[s]), diff(form[s], q[t])), sub(mul(x[s], y[t]), mul(x[t], y[s])))
        for s, t in combinations(range(len(q)), 2)
        if not (x[s] is y[t] is x[t] is y[s] is ZERO)
    )


def _independent(table: Array, count: int) -> list[int] | None:
    """As many independent rows as there are columns, the largest first."""
    left, chosen = table.copy(), list[int]()
    for _ in range(count):
        sizes = np.linalg.norm(left, axis=1) if len(left) else np.zeros(0)
        k = int(np.argmax(sizes)) if len(sizes) else -1
        if k < 0 or not sizes[k] > ROUNDED_ROOT * np.abs(table).max():
            return None
        chosen.append(k)
        along = left[k] / sizes[k]
        left = left - np.outer(left @ along, along)
    return chosen


_LEAST = 2
"""Places at which numbers must be finite."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundPotential(Immutable):
    """The potential energy of loads, from `eom.find_potential`.

    Attributes
    ----------
    value : V, an expression in coordinates with F_r = −Σ_s ∂V/∂q_s W_sr, or the same of F̃_r under constraints
    how : "closed form", or the quadrature rule and the coordinates that it was used for
    loads : the loads whose potential energy it is
    """

    value: Expr
    how: str
    loads: tuple[Load, ...]

    _repr_latex_ = show.latex

    def __repr__(self) -> str:
        return f"FoundPotential({cut(self.value)}; {self.how})"


def find_potential(derived: Derived, loads: Sequence[Any] | None = None) -> FoundPotential:
    """See Equations.find_potential."""
    if loads is not None and not is_list(loads):
        loads = (loads,)
    own = derived.system.all_loads() if loads is None else tuple(_load_named(derived, x) for x in loads)
    q = derived.system.coordinates
    forces = _of_coordinates(by_rates(derived, own), own)
    sets = [s.coordinates for s in derived.system.euler_parameters]
    at = sample_points([*forces, *q], unit=sets)
    gap = _gap(forces, q, at)
    if gap is None:
        return _integrated(forces, q, own, at)
    if not derived.constraints.constraints and not sets:
        raise PotentialError(_reason(forces, q, own, *gap))
    rows = [list(row) for row in InRates(derived).rows]
    check_allowed(derived, forces, rows, _names(own))
    for kept, changed in conservative_candidates(forces, rows, q, at[0]):
        try:
            moved = [[diff(f, s)] for f in changed for s in q if s not in set(kept)]
            if not _differ(moved, at)[1].any() and _gap(changed, kept, at) is None:
                return _integrated(changed, kept, own, at)
        except KaneError:
            continue
    raise PotentialError(
        f"Expected a potential energy under the constraints, got none for {_names(own)}: one may exist, but no constraint "
        "forces were found with which the forces have one. Declare it: Load(…, potential=V) is compared with the forces."
    )


def _load_named(derived: Derived, load: Any) -> Load:
    system = derived.system
    written = system.all_loads()
    same = zip((*system.gravities, *system.loads), derived.loads, derived.as_declared.loads, written, strict=True)
    name = load.name if isinstance(load, Load) else load if isinstance(load, str) else None
    found = [group[-1] for group in same if any(load is x for x in group)]
    function = load.scalar if isinstance(load, Load) else None  # of which the system has made forces
    found = found or [x for x in written if x.name == name and (function is None or function is x.scalar)]
    if len(found) == 1:
        return found[0]
    names = ", ".join(x.name for x in written) or "none"
    got = f"{name!r}, the name of {len(found)} of them. Give the load itself" if found else cut(repr(load))
    raise PotentialError(f"Expected some of the loads of the system ({names}), got {got}.")


def _names(loads: Sequence[Load]) -> str:
    return " and ".join(repr(x.name) for x in loads) or "no loads"


def _of_coordinates(forces: Exprs, loads: Sequence[Load]) -> Exprs:
    """The forces without rates and speeds, on which they must not depend."""
    moving = [
        s for s in free_symbols(forces) if isinstance(s, Rate | QuasiRate | Speed | Reaction) and input_of(s) is None
    ]
    at = sample_points([*forces, *moving])
    for s in moving:
        if differs([[diff(f, s)] for f in forces], at)[1].any():
            kind = "the reaction" if isinstance(s, Reaction) else "the speed" if isinstance(s, Speed) else "the rate"
            raise PotentialError(
                f"Expected forces that follow from the coordinates, got {_names(loads)}, which depend on {kind} {s}: they have no "
                "potential energy. Pass only the other loads, eom.find_potential([…]); the work of these counts as power."
            )
    still: dict[Expr, Expr] = dict.fromkeys(moving, ZERO)
    return tuple(substituted(f, still) for f in forces)


def _gap(forces: Sequence[Expr], q: Sequence[Symbol], at: Sequence[Place]) -> tuple[int, int, int] | None:
    """The pair of coordinates whose cross derivatives differ most, and the place; None where none do."""
    pairs = list(combinations(range(len(q)), 2))
    if not pairs:
        return None
    values, wrong = _differ([[diff(forces[i], q[j]), neg(diff(forces[j], q[i]))] for i, j in pairs], at)
    if not wrong.any():
        return None
    share = np.where(wrong, np.abs(values), -1.0)
    place, pair = np.unravel_index(int(np.argmax(share)), share.shape)
    return int(place), *pairs[int(pair)]


def _differ(groups: Sequence[Sequence[Expr]], at: Sequence[Place]) -> tuple[Array, Mask]:
    """`differs`, of numbers that must be finite at most places."""
    values, wrong = differs(groups, at)
    if np.isfinite(values).all(axis=1).sum() < _LEAST:
        raise PotentialError(
            "Expected forces with finite derivatives, got infinity or NaN at nearly all sampled states, with coordinates between "
            "-1.2 and 1.2. Declare the potential: Load(…, potential=V)."
        )
    return values, wrong


def _reason(forces: Exprs, q: Sequence[Coordinate], loads: Sequence[Load], place: int, i: int, j: int) -> str:
    a, b = diff(forces[i], q[j]), diff(forces[j], q[i])
    at = sample_points([*forces, *q])[place]
    left, right = measured([a, b], [at])[0]
    where = ", ".join(f"{s} = {at[s]:.4g}" for s in q if s in at)
    return (
        f"Expected forces with a potential energy, got {_names(loads)}, which have none: with Q the forces by rates, "
        f"∂Q_{q[i]}/∂{q[j]} = {left:.6g} but ∂Q_{q[j]}/∂{q[i]} = {right:.6g} at {where}, so that their work depends on the path. Pass "
        "only the other loads, eom.find_potential([…]); the work of these counts as power."
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


def check_potentials(derived: Derived) -> None:
    """Warn of each load whose potential is not that of its forces: its work would be wrong, and so the energy."""
    for load in derived.system.loads:
        if load.potential is not None and _differs(derived, load, load.potential):
            warn(
                f"Expected the potential of {load.name!r} to be that of its forces, F·v + T·ω = −dV/dt, got another one: they differ "
                "at random states. The motion is right, its energy and work are not. Correct the potential's sign or factor, or leave "
                "it out: the work of the forces then counts as power."
            )


def _differs(derived: Derived, load: Load, v: Expr) -> bool:
    """Whether −∂V/∂q are others than the load's forces at some state, but for what is along a constraint's force."""
    q, rows = derived.system.coordinates, InRates(derived).rows
    exprs = [*by_rates(derived, [load]), *gradient(v, q), *rows.entries]
    at = states(derived, exprs, varied=False)
    values = {x: np.array([place[x] for place in at]) for x in at[0]}
    found = [[np.broadcast_to(x, len(at)) for x in pair] for pair in bounded(exprs, values)]
    for numbers, errors in np.moveaxis(np.array(found), -1, 0).swapaxes(1, 2):
        (pushed, steep), c = numbers[: 2 * len(q)].reshape(2, -1), numbers[2 * len(q) :].reshape(rows.shape)
        gap, whole = pushed + steep, SIX_DIGITS * (np.abs(pushed) + np.abs(steep))
        whole += np.nan_to_num(errors[: 2 * len(q)].reshape(2, -1).sum(axis=0), posinf=0.0)
        finite = np.isfinite(numbers).all()
        if finite and len(c):
            gap, whole = gap - np.linalg.lstsq(c.T, gap, rcond=None)[0] @ c, whole.max(initial=0)
        if finite and (np.abs(gap) > whole).any():
            return True
    return False

# SPDX-License-Identifier: BSD-3-Clause
"""Dependent speeds determined at all configurations, and constraints with linearly dependent rows, redundant or contradictory.

Speeds are determined everywhere if their block A_D of the constraints has a constant determinant; with redundant rows, if the volume
√det(A_Dᵀ A_D) is constant. Of several such sets that with the shortest equations is taken: with the fewest nonzero entries of A_n and
of the mass matrix BᵀMB of the independent speeds, where entries that vary with the configuration count as the operations they take.

If xᵀ A = 0 for some x, A u + b = 0 has a solution only if xᵀ b = 0. Then one of the constraints follows from the others; otherwise
they contradict each other. Configuration constraints f(q, t) = 0 are compared at configurations that satisfy them; if none is found,
the dependence of their rows says nothing of f.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import combinations
from math import comb
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.dynamics.constraints.manifold import Configurations, manifold
from kane.dynamics.constraints.partition import Compared
from kane.errors import ModelError, ReactionError, warn
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, constant_value
from kane.expr.symbols import Coordinate, Parameter, Time, input_of
from kane.kinematics.velocity_constraints import ConstraintRows
from kane.model.constraints import Constraint, constraint_of
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.rank import balance, dependencies, indeterminate, within
from kane.numeric.sampling import HIGH, LOW, SEED, values_of
from kane.numeric.scale import EQUAL, ROUNDED_ROOT, TAKES_PART

_FOLLOWS = 1e-5
"""Share of the product of the lengths of its columns that a volume must have: what is below has lost the digits that tell."""
_WELL = 0.25
"""What that share must be of the best set's, at least: a set that is nearly singular everywhere is no choice because it is shorter."""
_FEWEST = 3
"""Configurations that tell what is the same everywhere, at least."""
_ENTRIES, _EXCHANGES = 10_000, 200
"""Numbers in the matrices, and exchanges of one speed for another, up to which sets are looked for."""
_ROUNDS, _SETS = 12, 24
"""How many exchanges lead to a set that follows everywhere, and how many of these sets are compared, at most."""
_MINORS, _NEARLY = 2000, 1e-6
"""How many sets are looked at where no exchange leads on, and the share by which volumes may differ of what is measured then."""
_CHANGING = 3
"""Operations that an entry counts for that changes with the configuration; a constant one counts for one."""

Set = tuple[int, ...]


def steady_speeds(
    compared: Compared, a: Matrix, dependent: Sequence[int], kept: Sequence[int], mass: Callable[[], Matrix]
) -> Set | None:
    """Dependent speeds determined at all configurations, including those `kept`, with the shortest equations; None if none are found.

    The search begins with the speeds `dependent`; `mass` gives the mass matrix, by which the lengths of equations are estimated.
    """
    numbers = _at_any_time(compared, a)

    @cache
    def inertia() -> Array:
        whole, at = mass(), compared.at  # M may hold symbols that the constraints do not
        return replace(at, values={**values_of(free_symbols(whole.entries), SEED), **at.values}).matrices(whole)

    return steadiest(numbers, dependent, kept, lambda s: price(numbers, inertia(), s))


def follow_everywhere(compared: Compared, a: Matrix, dependent: Sequence[int]) -> bool:
    """Whether the volume of the dependent block is the same at all configurations."""
    return steady(_at_any_time(compared, a), dependent)


def _at_any_time(compared: Compared, matrix: Matrix) -> Array:
    """A at the configurations, each with a random time and random inputs, so that equal values do not depend on these."""
    free = [s for s in free_symbols(matrix.entries) if not isinstance(s, Coordinate | Parameter)]
    if not free:
        return compared.a
    rng = np.random.default_rng(SEED)
    at = compared.at
    return replace(at, values={**at.values, **{s: rng.uniform(LOW, HIGH, at.count) for s in free}}).matrices(matrix)


def steady(a: Array, dependent: Collection[int]) -> bool:
    """Whether the volume of the columns `dependent` is the same in all of several matrices (k × m × n)."""
    return len(a) >= _FEWEST and bool(_spreads(_scaled(a), [tuple(sorted(dependent))])[0] <= EQUAL)


def steadiest(a: Array, dependent: Collection[int], kept: Collection[int], price: Callable[[Set], float]) -> Set | None:
    """The set of least `price` among those of constant volume in several matrices (k × m × n); None if none is found.

    A descent from the `dependent` speeds, which exchanges one speed at a time, none of those `kept`, so that the volume varies less.
    """
    a = _scaled(a)
    now = tuple(sorted(dependent))
    if not now or len(a) < _FEWEST or a.size > _ENTRIES or len(now) * (a.shape[2] - len(now)) > _EXCHANGES:
        return None
    now, least = _least_varying(a, now, kept)
    found = [now] if least <= EQUAL else _by_minors(a, now, kept)
    for each in found:
        others = [s for s in _exchanged(each, a.shape[2], kept) if s not in found]
        if len(found) >= _SETS or not others:
            break
        found += [s for s, x in zip(others, _spreads(a, others), strict=True) if x <= EQUAL]
    if len(found) < 2:
        return next(iter(found), None)
    share = _volumes(a, found)[1].min(axis=1)  # the first of least price of those that follow well beside the best
    return min((s for s, x in zip(found, share, strict=True) if x >= _WELL * share.max()), key=price)


def _least_varying(a: Array, now: Set, kept: Collection[int]) -> tuple[Set, float]:
    """The end of a descent by exchanges of one speed, each of which makes the volume vary less, and its variation."""
    least = float(_spreads(a, [now])[0])
    for _ in range(_ROUNDS):
        others = [] if least <= EQUAL else _exchanged(now, a.shape[2], kept)
        if not others:
            break
        spreads = _spreads(a, others)
        rounded = np.round(spreads, 6)  # what only rounding tells apart is a tie, which the order decides
        place = int(np.argmin(rounded))
        if not rounded[place] < least:
            break
        now, least = others[place], float(spreads[place])
    return now, least


def _by_minors(a: Array, now: Set, kept: Collection[int]) -> list[Set]:
    """Sets of constant volume that contain `kept`: of all sets, or of `_MINORS` sets with few exchanges from `now`.

    With R = A_D⁻¹ A the volume of a set is that of `now` times a minor of R, of the speeds removed and added. Nearly all sets are
    ruled out by minors at two configurations, those at which the volume of `now` differs most.
    """
    (volume,), (share,) = _volumes(a, [now])
    apart = [k for k in np.argsort(volume).tolist() if share[k] > _FOLLOWS]
    ends = apart[:: max(len(apart) - 1, 1)]
    if len(ends) < 2:
        return []
    ratios = np.linalg.pinv(a[ends][:, :, list(now)]) @ a[ends]
    there = np.abs(ratios).max(axis=0) > EQUAL
    going = [i for i, u in enumerate(now) if u not in kept and there[i].sum() > 1]  # 1 is itself
    coming = [j for j in np.flatnonzero(there.any(axis=0)).tolist() if j not in now]
    found: list[Set] = []
    left = _MINORS
    for order in range(1, min(len(going), len(coming)) + 1):
        left -= comb(len(going), order) * comb(len(coming), order)
        if left < 0:
            break
        i, j = (np.array(list(combinations(places, order))) for places in (going, coming))
        minors = np.abs(np.linalg.det(ratios[:, i[:, None, :, None], j[None, :, None, :]]))
        first, last = minors * volume[ends, None, None]
        alike = np.argwhere(np.abs(first - last) < _NEARLY * np.maximum(first, last)).tolist()
        sets = [tuple(sorted({*now} - {now[x] for x in i[r].tolist()} | {*j[c].tolist()})) for r, c in alike]
        found += [s for s, x in zip(sets, _spreads(a, sets), strict=True) if x <= EQUAL] if sets else []
    return found[:_SETS]


def price(a: Array, mass: Array, dependent: Set) -> float:
    """An estimate of the operations in A_n and BᵀMB, from A and M at several configurations (k × m × n, k × n × n)."""
    n = a.shape[2]
    free = [i for i in range(n) if i not in dependent]
    a_n = -np.linalg.pinv(a[:, :, list(dependent)]) @ a[:, :, free]
    b = np.zeros((len(a), n, len(free)))
    b[:, free, range(len(free))] = 1.0
    b[:, list(dependent)] = a_n
    bt = np.swapaxes(b, 1, 2)
    upper = np.triu_indices(len(free))
    sizes = np.abs(bt) @ np.abs(mass) @ np.abs(b)
    return _filled(a_n, np.abs(a_n).max(axis=(0, 2), keepdims=True)) + _filled(
        (bt @ mass @ b)[:, *upper], sizes[:, *upper]
    )


def _filled(x: Array, sizes: Array) -> float:
    """The weighted count of entries (k × …): zero if they vanish beside their `sizes`, more if they vary."""
    size = np.broadcast_to(sizes, x.shape).max(axis=0)
    there, changing = np.abs(x).max(axis=0) > EQUAL * size, np.ptp(x, axis=0) > EQUAL * size
    return float((there + (_CHANGING - 1) * (there & changing)).sum())


def _scaled(a: Array) -> Array:
    """Rows and columns divided by their largest entries at any of the configurations, so that units do not matter.

    Small entries are kept, since a configuration may be near a pole of q̇, beside which the others are small without being rounding.
    """
    return balance(a, np.abs(a).max(axis=0, initial=0), rounding=0.0).matrix


def _spreads(a: Array, sets: Sequence[Set]) -> npt.NDArray[np.float64]:
    """The variation of the logarithm of each set's volume over the configurations; infinite for poorly determined sets."""
    volume, share = _volumes(a, sets)
    spread = np.log(np.maximum(volume, 1e-300)).std(axis=1)
    follows = (share > _FOLLOWS).sum(axis=1)
    return np.where(follows == len(a), spread, np.where(follows > 1, spread + 1.0, np.inf))


def _volumes(a: Array, sets: Sequence[Set]) -> tuple[Array, Array]:
    """The volume of each set at each configuration (sets × k), and its ratio to the product of the lengths of its columns."""
    block = np.moveaxis(a[:, :, np.array(sets)], 2, 0)  # sets × k × m × d
    square = block.shape[2] == block.shape[3]
    volume = np.abs(np.linalg.det(block)) if square else np.linalg.svd(block, compute_uv=False).prod(axis=-1)
    lengths = np.sqrt((block**2).sum(axis=2)).prod(axis=-1)
    share = np.where(lengths > 0, volume / np.where(lengths > 0, lengths, 1.0), 0.0)
    return volume, share


def _exchanged(now: Set, count: int, kept: Collection[int]) -> list[Set]:
    """The sets with one speed exchanged for another."""
    others = [j for j in range(count) if j not in now]
    return [tuple(sorted({*now, j} - {i})) for i in now if i not in kept for j in others]


_STEADY = (Coordinate, Time)


def _check_affine(system: System) -> None:
    """Raises a ModelError if two configuration constraints with the same constant gradient contradict each other."""
    conditions = manifold(system)
    plain = [
        k
        for k, (f, row) in enumerate(zip(conditions.f, conditions.gradient.rows, strict=True))
        if all(constant_value(g) is not None for g in row) and all(isinstance(s, _STEADY) for s in free_symbols([f]))
    ]
    if len(plain) < 2:
        return
    values = values_of(free_symbols(conditions.f[k] for k in plain), SEED)
    g = np.asarray(evaluate(conditions.gradient.take(plain), values), dtype=float)
    f = np.array(evaluate([conditions.f[k] for k in plain], values), dtype=float)
    size = np.abs(g).max(axis=1)  # numbers as they were written: however small, none is rounding's
    against = _against(g / size[:, None], f / size)
    names = [conditions.names[k] for k, x in zip(plain, against, strict=True) if x]
    if names:
        raise ModelError(
            f"Expected consistent configuration constraints, got {', '.join(map(repr, names))}, which contradict each "
            "other at every configuration. Leave one of them out, or correct it."
        )


def check_determinate(system: System, rows: ConstraintRows, compared: Compared, left_out: Sequence[int]) -> None:
    """Warns of linearly dependent rows, by name, and if no configuration was found.

    At the configurations `compared` the rows `left_out` follow from the others; a reaction is determined if its column of A_a adds
    nothing to the rank of A. ModelError if motion constraints contradict each other for all parameters, ReactionError if a reaction
    is not determined.
    """
    numbers, found = compared.a, compared.at
    if found.missed:
        _check_affine(system)
    a = numbers[0]
    dependent = [c for c, x in zip(rows.constraints, indeterminate(a), strict=True) if x]
    contrary = [] if found.missed else _contrary(rows, a, found.at(0))
    if any(contrary):
        also = any(_contrary(rows, numbers[-1], found.at(-1)))
        told = _contradiction([c for c, x in zip(rows.constraints, contrary, strict=True) if x], rows, also)
    else:
        if dependent:
            _check_asked(system, dependent, a, found.matrices(rows.a_auxiliary)[0])
        told = _not_closed(system, dependent, found) if found.missed else _redundancy(left_out, rows, a)
    if told:
        warn(told)


def _redundancy(left_out: Sequence[int], rows: ConstraintRows, a: Array) -> str:
    if not left_out:
        return ""
    speeds = a.shape[1]
    free = speeds - (len(a) - len(left_out))
    driven = " except as the constraints prescribe" if any(x is not ZERO for x in rows.b) else ""
    rest = (
        "The motion is determined nevertheless; the individual constraint forces are not."
        if free
        else f"The constraints leave none of {speeds} speeds free: nothing can move{driven}, and the individual constraint forces are "
        "not determined."
    )
    told = []
    for together in _groups(a):
        named = _named([rows.constraints[k] for k in together])
        count = len(set(together) & set(left_out))
        many = f"{count} of these {len(together)} {'is' if count == 1 else 'are'}" if len(together) > 1 else "it is"
        told.append(f"The {named}: {many} redundant")
    gone = ", ".join(repr(rows.constraints[k].name) for k in left_out)
    zero = f"multipliers of {gone} are" if len(left_out) > 1 else f"multiplier of {gone} is"
    return f"{'. '.join(told)}. The {zero} taken as zero. {rest}"


def _groups(a: Array) -> list[list[int]]:
    """Groups of linearly dependent rows: the rows that take part in a common x with xᵀ A = 0."""
    x = dependencies(a)
    joined = np.abs(x.T @ x) > TAKES_PART
    groups: list[list[int]] = []
    for k in np.flatnonzero(joined.diagonal()).tolist():
        group = {k}
        while (more := set(np.flatnonzero(joined[sorted(group)].any(axis=0)).tolist())) - group:
            group |= more
        if sorted(group) not in groups:
            groups.append(sorted(group))
    return groups


def _check_asked(system: System, dependent: Sequence[Constraint], a: Array, released: Array) -> None:
    undetermined = [r for r, column in zip(system.reactions, released.T, strict=True) if not within(a, column)]
    if undetermined:
        held = [constraint_of(r) for r in undetermined]
        asked = [str(r) if c is None else f"{r} ({c.name})" for r, c in zip(undetermined, held, strict=True)]
        raise ReactionError(
            f"Expected reactions that are uniquely determined, got {', '.join(asked)}: the {_named(dependent)}, so that the "
            f"individual constraint forces are not determined. {_without(system, a, [c for c in held if c is not None])}"
        )


def _without(system: System, a: Array, asked: Sequence[Constraint]) -> str:
    """Words for the cure: which constraints, if possible none of `asked`, to leave out for the other rows to be independent."""
    order = sorted(range(len(a)), key=lambda k: system.constraints[k] not in asked)
    kept: list[int] = []
    for k in order:
        if not len(dependencies(a[[*kept, k]])):
            kept.append(k)
    left = [k for k in order if k not in kept]
    names = ", ".join(repr(system.constraints[k].name) for k in left)
    if any(system.constraints[k] in asked for k in left):
        return f"Leave out {names} and ask only for the other reactions, or model the compliance of the parts."
    return f"Leave out {names}, so that the other constraints carry the load, or model the compliance of the parts."


def _not_closed(system: System, dependent: Sequence[Constraint], found: Configurations) -> str:
    """Words for the warning that no configuration was found, with the possible reasons."""
    if found.drawn and not dependent:
        return ""
    (worst, left), *more = found.missed
    parameters = any(isinstance(s, Parameter) for s in free_symbols(c.expr for c in system.holonomic))
    assumed = [f"random values of {', '.join(found.drawn)}"] if found.drawn else []
    when = ", ".join(f"{t:.3g}" for t in found.times)
    assumed += ["parameters at their defaults"] if parameters and not found.drawn else []
    return (
        f"Expected configuration constraints that some configuration satisfies, got none from {found.starts} starts"
        f"{f' at each of t = {when}' if when else ''}"
        f"{f' with {assumed[0]}' if assumed else ''}: the largest residual is {left:.3g}, of {worst!r}"
        f"{', then ' + ', '.join(repr(name) for name, _ in more[:3]) if more else ''}. "
        f"{f'The {_named(dependent)} at a random configuration too. ' if dependent else ''}"
        "They may contradict each other, or the parts may not fit together: correct the lengths, or leave out a constraint. "
        "kn.assemble(eom, q=…, parameters=…) tries other values or starts."
    )


def _named(dependent: Sequence[Constraint]) -> str:
    names = ", ".join(repr(c.name) for c in dependent)
    return (
        f"constraints {names} depend on each other" if len(dependent) > 1 else f"constraint {names} is always satisfied"
    )


def _contradiction(constraints: Sequence[Constraint], rows: ConstraintRows, elsewhere: bool) -> str:
    """Words for a warning of contradictory motion constraints; a ModelError if no parameter or input enters them."""
    held = [k for k, c in enumerate(rows.constraints) if c in set(constraints)]
    symbols = free_symbols(x for k in held for x in (*rows.a.rows[k], rows.b[k]))
    chosen = [s.name for s in symbols if isinstance(s, Parameter) or input_of(s) is not None]
    names = ", ".join(repr(c.name) for c in constraints)
    wrong = f"constraints that speeds can satisfy together, got {names}, which give the same combination of speeds different values"
    if not chosen and elsewhere:
        raise ModelError(f"Expected {wrong}. Leave one of them out, or correct it.")
    values = f"{', '.join(chosen)} (defaults, where declared)" if chosen else "coordinates"
    return (
        f"Expected {wrong} at the values of {values} used for the comparison. Give values at which they agree, leave one of the "
        "constraints out, or correct it."
    )


def _contrary(rows: ConstraintRows, a: Array, values: Mapping[Any, float]) -> list[bool]:
    """Whether each constraint takes part in a contradiction, xᵀ A = 0 with xᵀ b ≠ 0."""
    if all(x is ZERO for x in rows.b):
        return [False] * len(rows.b)
    return _against(a, np.array(evaluate(list(rows.b), values_of(free_symbols(rows.b), SEED, values)), dtype=float))


def _against(a: Array, right: Array) -> list[bool]:
    """Whether each row of A takes part in an x with xᵀ A = 0 and xᵀ `right` ≠ 0."""
    size = balance(a).rows[:, 0]
    scaled = right / size
    combinations = dependencies(a)
    terms = combinations * scaled
    reach = np.abs(combinations * np.maximum(np.abs(scaled), 1.0)).max(axis=1, initial=0)
    broken = combinations[np.abs(terms.sum(axis=1)) > ROUNDED_ROOT * reach]
    return [bool(x) for x in np.abs(broken).max(axis=0, initial=0) > TAKES_PART]

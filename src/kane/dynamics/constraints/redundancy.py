# SPDX-License-Identifier: BSD-3-Clause
"""Constraints whose rows depend on each other: redundant, or contradictory.

Where xᵀ A = 0 for some x, A u + b = 0 can hold only if xᵀ b = 0 too. Then one of the constraints follows from the others; otherwise
no speeds satisfy them. Configuration constraints f(q, t) = 0 are compared where they hold; where no such place was found, their
rows say nothing of f.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.dynamics.constraints.configurations import Configurations
from kane.dynamics.constraints.manifold import manifold
from kane.errors import ModelError, ReactionError, warn
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, constant_value
from kane.expr.symbols import Coordinate, Parameter, Time, input_of
from kane.kinematics.constraints import ConstraintRows
from kane.model.constraints import Constraint
from kane.model.reactions import constraint_of
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.rank import balance, dependencies, indeterminate, within
from kane.numeric.sampling import SEED, values_of
from kane.numeric.scale import ROUNDED_ROOT, TAKES_PART

_STEADY = (Coordinate, Time)


def _check_affine(system: System) -> None:
    """Constraints with one and the same gradient everywhere contradict each other everywhere, or nowhere."""
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
            f"Expected configuration constraints that can hold together, got {', '.join(map(repr, names))}, which contradict each "
            "other at every configuration. Leave one of them out, or correct it."
        )


def check_determinate(
    system: System, rows: ConstraintRows, numbers: Array, found: Configurations, left_out: Sequence[int]
) -> None:
    """Rows that depend on each other are named; what they leave undetermined, at a cut or a multiplier, is no reaction.

    That no configuration was found is said too, unless it may be for values that are not known here. `numbers` are A at the
    configurations `found`, of which the rows `left_out` follow from the others: a reaction is determined where its column of A_a
    adds nothing to the rank of A. Errors are motion constraints that contradict each other whatever the parameters, and reactions
    that are not determined.
    """
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
    driven = " but as the constraints prescribe" if any(x is not ZERO for x in rows.b) else ""
    rest = (
        "The motion is determined all the same; the forces that hold the parts are not, one by one."
        if free
        else f"The constraints leave none of {speeds} speeds free: nothing can move{driven}, and the forces that hold the parts are "
        "not determined one by one."
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
    """Rows that depend on each other, group by group: those that a vector x with xᵀ A = 0 joins."""
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
            f"Expected reactions that the motion determines, got {', '.join(asked)}: the {_named(dependent)}, so that the forces that "
            f"hold the parts are not determined one by one. {_without(system, a, [c for c in held if c is not None])}"
        )


def _without(system: System, a: Array, asked: Sequence[Constraint]) -> str:
    """Which constraints to leave out, those that are asked for kept, so that the rows of the others are independent."""
    order = sorted(range(len(a)), key=lambda k: system.constraints[k] not in asked)
    kept: list[int] = []
    for k in order:
        if not len(dependencies(a[[*kept, k]])):
            kept.append(k)
    left = [k for k in order if k not in kept]
    names = ", ".join(repr(system.constraints[k].name) for k in left)
    if any(system.constraints[k] in asked for k in left):
        return f"Model what gives way, or leave out {names} and ask for the others only."
    return f"Leave out {names}, so that the others carry what they held, or model what gives way."


def _not_closed(system: System, dependent: Sequence[Constraint], found: Configurations) -> str:
    """No configuration was found: of rows that depend on each other nothing more is known, nor where lengths were drawn at random."""
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
        f"{f' with {assumed[0]}' if assumed else ''}: {worst!r} resists most, by {left:.3g}"
        f"{', then ' + ', '.join(repr(name) for name, _ in more[:3]) if more else ''}. "
        f"{f'The {_named(dependent)} at a random configuration too. ' if dependent else ''}"
        "They may contradict each other, or the parts not reach: correct the lengths, or leave out what is too much. "
        "kn.assemble(eom, q=…, parameters=…) says whether other values or starts do."
    )


def _named(dependent: Sequence[Constraint]) -> str:
    names = ", ".join(repr(c.name) for c in dependent)
    return f"constraints {names} depend on each other" if len(dependent) > 1 else f"constraint {names} holds by itself"


def _contradiction(constraints: Sequence[Constraint], rows: ConstraintRows, elsewhere: bool) -> str:
    """An error where they contradict each other whatever the values of parameters and inputs, and at another configuration too."""
    held = [k for k, c in enumerate(rows.constraints) if c in set(constraints)]
    symbols = free_symbols(x for k in held for x in (*rows.a.rows[k], rows.b[k]))
    chosen = [s.name for s in symbols if isinstance(s, Parameter) or input_of(s) is not None]
    names = ", ".join(repr(c.name) for c in constraints)
    wrong = f"constraints that speeds can satisfy together, got {names}, which hold the same combination of speeds at different values"
    if not chosen and elsewhere:
        raise ModelError(f"Expected {wrong}. Leave one of them out, or correct it.")
    values = f"{', '.join(chosen)} (defaults, where there are any)" if chosen else "coordinates"
    return (
        f"Expected {wrong} with the values of {values} that they were compared at. Give values at which they agree, leave one of the "
        "constraints out, or correct it."
    )


def _contrary(rows: ConstraintRows, a: Array, values: Mapping[Any, float]) -> list[bool]:
    """Which constraints take part in a contradiction, xᵀ b ≠ 0."""
    if all(x is ZERO for x in rows.b):
        return [False] * len(rows.b)
    return _against(a, np.array(evaluate(list(rows.b), values_of(free_symbols(rows.b), SEED, values)), dtype=float))


def _against(a: Array, right: Array) -> list[bool]:
    """Which rows of A take part in some x with xᵀ A = 0 for which xᵀ right is not zero."""
    size = balance(a).rows[:, 0]
    scaled = right / size
    combinations = dependencies(a)
    terms = combinations * scaled
    reach = np.abs(combinations * np.maximum(np.abs(scaled), 1.0)).max(axis=1, initial=0)
    broken = combinations[np.abs(terms.sum(axis=1)) > ROUNDED_ROOT * reach]
    return [bool(x) for x in np.abs(broken).max(axis=0, initial=0) > TAKES_PART]

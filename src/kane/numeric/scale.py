# SPDX-License-Identifier: BSD-3-Clause
"""The tolerances of the library, each named by what it decides; a module with one of its own says there why none of these does.

All are shares of a size that belongs to the question (the largest entry, the terms of a sum, a span), so that units do not matter.
Doubles carry sixteen digits; each group says how many of them its numbers have lost before they are compared.

Values of expressions, and how far rounding may carry them: a value that is no larger than its bound counts as zero.

|Δ(a b)| ≤ |a| |Δb| + |b| |Δa| + |Δa| |Δb| and so on, each result and 2⁻⁵¹ of it (Higham 2002, Accuracy and Stability of Numerical
Algorithms, sec. 3.1); constants that were computed while the expression was built bring their own bounds along. So a sum is judged
beside the terms that cancel in it, in any units, also where they cancel everywhere. The bounds are of the first order of what happens,
not sharp: terms that depend on each other are taken for independent ones. Turned from link to link a vector's bound doubles with each,
so that it says nothing after fifty. So in long expressions a bound is no larger than a thousand times what random changes of all
results by their rounding change the root by (Vignes 2004, Discrete stochastic arithmetic, Numerical Algorithms 37).
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from kane.expr.node import EPS as EPS
from kane.expr.node import Expr, error_of, nodes, number_of, postorder
from kane.expr.ops import ADD, CONST, COS, DIV, MUL, NEG, OPS, PI, REGULAR, SIN, SQRT, SUB, SYMBOL, WHERE, Op
from kane.numeric.sampling import SEEDS, draw, unit

# Zero: the number beside those it was computed from.
LAST_DIGIT = 1e-15
"""A cosine, an angle, or a residual beside its terms that no further operation improves: few spacings of numbers at 1."""
ROUNDED_TERMS = 16 * EPS
"""Share of the terms of a quantity, evaluated once, that rounding may leave of it."""
ROUNDED = 1e-13
"""An entry beside the largest of its matrix, a coefficient or residual beside its terms: some hundred roundings add up to it."""
ROUNDED_CHAIN = 1e-12
"""A measure number beside the largest, where it came through products along a chain of bodies."""
ROUNDED_SUM = 1e-11
"""A sum beside its terms, each a long expression, at all of several states drawn at random."""
UNRELATED = 1e-9
"""A slope or share through which one quantity might depend on another: below, it does not, in the digits a difference leaves."""
ROUNDED_ROOT = 1e-7
"""What comes through a root, a singular position or a double eigenvalue: half of the digits are gone."""

# Equal: two numbers that came different ways, and numbers that were typed.
EQUAL = 1e-9
"""Two numbers beside the larger, computed in two ways or at two places where the same is expected of them."""
DECLARED = 1e-9
"""What a declaration must satisfy (perpendicular, of unit length, triangle inequality): constants have ten digits."""
GIVEN = 1e-8
"""The same of direction cosines, Euler parameters and whole states: files give eight digits of them."""
RIGHT_ANGLE = 1e-10
"""Difference, rad, of a typed angle from a multiple of π/2 below which it is that multiple: files give eleven digits of it."""
NO_SIZE = 1e-8
"""Radius of gyration, m, below which the inertia that a file gives of a body is a rounded zero."""
SIX_DIGITS = 1e-6
"""Agreement of what was solved for, integrated or differentiated by differences: six digits are right in what may be shown."""

# Closing: the residual of a constraint beside its terms.
CLOSED_FULLY = 1e-13
"""Residual at which Newton's steps end: what is left is rounding's."""
CLOSED = 1e-10
"""Residual at which a configuration counts as closed, also where convergence is linear because branches meet."""
SOLVED = 1e-9
"""Residual at which conditions count as met that are solved for among values: trims, branches of solutions."""
CLOSED_NEARLY = 1e-6
"""The same where nothing closes better: near a singular position f falls with the square of what is missing."""
ONE_POSITION = 1e-5
"""Distance up to which two closed configurations are one: at a dead centre steps end a root of `CLOSED` from it."""
FIXED_SHARE = 1e-12
"""Singular value of a Jacobian beside the largest, below which Newton's steps move nothing along it."""

# Rank: a singular value beside the largest, or a pivot beside its candidates, of a balanced matrix.
MOTION_RANK = 1e-4
"""Constraints along a motion. Where a linkage comes through a position at which they lose rank, what rounding leaves of f becomes f/σ
in q and f/σ² in u, however short the steps: f = c ≠ 0 does not go through there, but turns off. Combinations that are as small
everywhere are enlarged before (`Mixed`): nothing turns off there."""
SURE_RANK = 1e-5
"""Rows at a state above this are independent without a second look by elimination."""
NEAR_SINGULAR = 1e-6
"""Reciprocal condition at which speeds no longer follow from others: by chance no configuration lies so near to a singular one, and
beside a false pole of the speeds the derivatives lose half as many digits again as the solution."""
DERIVE_RANK = 1e-8
"""Constraints at a configuration that Newton's method has closed: which of them hold, and which follow from the others."""
STATE_RANK = 1e-9
"""Whether conditions determine the values that are solved for; seven digits of these would be right."""
SPEEDS_RANK = 1e-10
"""The definitions of speeds at a point drawn at random, where nothing is small but what vanishes everywhere."""
INVERSE_RANK = 1e-11
"""The equations of inverse dynamics; five digits of the unknowns would be right."""
SOLVE_RANK = 1e-12
"""Any other square matrix that is solved with; four digits of the solution would be right."""
SURELY_REGULAR = 1e-6
"""Pivots of a positive matrix with ones on its diagonal above which it is regular by `SOLVE_RANK`, whatever they hide."""
TAKES_PART = 1e-6
"""Share of its largest entry above which an entry of a null vector is not zero."""

# Dependent speeds: the quality of a choice, 1/‖B⁻¹‖ over ‖A‖, 1 at best.
PIVOT = 0.15
"""Share of the largest entry left that a pivot must have: growth by elimination stays within one digit a few rows on."""
POOR = 0.02
"""Quality below which other dependent speeds are sought: their accelerations have lost two digits."""
UNUSABLE = 1e-3
"""Quality below which a state between two steps is read off with other dependent speeds than it was stepped with."""
BETTER = 4.0
"""How many times better another choice must be: changes cost time, and must not go to and fro."""

# Time: a distance in time beside the span, the step, or the times themselves.
SAME_TIME = 1e-12
"""Two times are one: an event is located to this share of a step, phases below it are none."""
NEAR_TIME = 1e-9
"""Two times of different origin are one: a breakpoint and a jump, an event and the end of a span."""
SOON = 1e-6
"""After this share of a step a quantity shows by its slope where it is going."""
LATER = 1e-3
"""After this share of a step it shows by its value."""

# Motion: what a motion may miss.
CHANGES_SIDE = 1e-6
"""Share of its usual size below which the quantity of a switch or event is at its threshold: it is located no better."""
LEAPS = 1e-6
"""Share of its range by which a function that jumps differs from the integral of its derivative, or on both sides of an instant."""
STEEP = 1e-3
"""Share of its largest Chebyshev coefficient above which the last ones of a taper tell of a step: its integrals are off by as much."""


ROUNDING = 2.0**-51
_LONG = 1000
"""Nodes from which on values are changed at random: below, a chain is too short for bounds to grow."""
_CHANGES, _AMPLE = 8, 1024.0
"""How often; and how many times as far as these lead rounding may carry a value: errors of many results may all be of one sign."""
Bounded = tuple[Any, Any]
"""A value and its bound, numbers or arrays."""


def bounded(roots: Iterable[Expr], values: Mapping[Any, Any], share: float = ROUNDING) -> list[Bounded]:
    """Value and bound of each root, every symbol off by a `share` of its value at most; infinity or NaN where nothing bounds it."""
    known: dict[Expr, Bounded] = {}
    wanted = list(roots)
    order = postorder(wanted)
    with np.errstate(all="ignore"):
        for node in order:
            op, args = node.op, node.args
            if not args:
                known[node] = _leaf(node, values, share)
            elif op is MUL:
                (a, s), (b, t) = known[args[0]], known[args[1]]
                z = a * b
                known[node] = z, abs(a) * t + abs(b) * s + s * t + abs(z) * ROUNDING
            elif op is ADD or op is SUB:
                (a, s), (b, t) = known[args[0]], known[args[1]]
                z = a + b if op is ADD else a - b
                known[node] = z, s + t + abs(z) * ROUNDING
            elif op is NEG:
                a, s = known[args[0]]
                known[node] = -a, s
            else:
                known[node] = _passed_on(op, [known[x] for x in args])
        if len(order) < _LONG:
            return [known[r] for r in wanted]
        changed = _changed(order, values, share)
        return [(x, np.fmin(error, _AMPLE * _furthest(x, changed[r]))) for r in wanted for x, error in (known[r],)]


def _passed_on(op: Op, parts: Sequence[Bounded]) -> Bounded:
    """Of another operation; Python's floats, which are the soonest to compute with, stay such."""
    if not all(type(x) is float and type(s) is float for x, s in parts):
        z = op.numpy(*[x for x, _ in parts])
        return z, _RULES.get(op, _by_differences(op))(z, *parts)
    if op is DIV:
        (a, s), (b, t) = parts
        least = abs(b) - t
        if least > 0:
            z = a / b
            return z, (s + abs(z) * t) / least + abs(z) * ROUNDING
    z, error = _passed_on(op, [(np.float64(x), np.float64(s)) for x, s in parts])
    return float(z), float(error)


def _changed(order: Sequence[Expr], values: Mapping[Any, Any], share: float) -> dict[Expr, Any]:
    """Values with each result changed by its rounding, and each leaf within its bound, at random: arrays with one more axis."""
    changes = np.random.default_rng(SEEDS[0]).uniform(-1.0, 1.0, (len(order), _CHANGES))
    found: dict[Expr, Any] = {}
    for node, by, factor in zip(order, changes, 1.0 + ROUNDING * changes, strict=True):
        if node.args:
            found[node] = node.op.numpy(*[found[x] for x in node.args]) * factor
        else:
            x, error = _leaf(node, values, share)
            found[node] = np.asarray(x)[..., None] + np.asarray(error)[..., None] * by
    return found


def _furthest(x: Any, changed: Any) -> Any:
    return np.abs(changed - np.asarray(x)[..., None]).max(axis=-1)


def vanish(
    exprs: Iterable[Expr], groups: Iterable[Sequence[Any]] = (), known: Mapping[Any, float] | None = None
) -> list[bool]:
    """Which of the expressions are zero but for rounding whatever their symbols are: at all of several states drawn at random.

    `groups` are Euler parameters; parameters are drawn, too, but for those that are `known`.
    """
    roots, known = list(exprs), known or {}
    symbols, left = [node for node in nodes(roots) if node.op is SYMBOL], dict.fromkeys(roots)
    for seed in SEEDS:
        if not left:
            break
        values = unit({s: known[s] if s in known else draw(seed, s) for s in symbols}, groups)
        sizes = zip(left, bounded(left, values), strict=True)
        left = {e: None for e, (x, error) in sizes if abs(x) <= error < np.inf}
    return [e in left for e in roots]


def _leaf(node: Expr, values: Mapping[Any, Any], share: float) -> Bounded:
    if node.op is CONST:
        return float(number_of(node)), float(error_of(node))
    if node.op is PI:
        return np.float64(math.pi), math.pi * ROUNDING
    x: Any = values[node]
    if not isinstance(x, np.ndarray):
        x = float(x)
    return x, abs(x) * share


def _by_differences(op: Op) -> Callable[..., Any]:
    """The rule of an operation whose arguments are moved by their bounds, one at a time, both ways."""

    def rule(z: Any, *parts: Bounded) -> Any:
        total = abs(z) * ROUNDING
        for k, (_, s) in enumerate(parts):
            ends = [op.numpy(*[y + d * (i == k) for i, (y, _) in enumerate(parts)]) for d in (-s, s)]
            total = total + np.fmax(abs(ends[0] - z), abs(ends[1] - z))
        return total

    return rule


def _quotient(z: Any, above: Bounded, below: Bounded) -> Any:
    least = abs(below[0]) - below[1]
    return np.where(least > 0, (above[1] + abs(z) * below[1]) / least, np.inf)[()] + abs(z) * ROUNDING


_RULES: dict[Op, Callable[..., Any]] = {
    NEG: lambda z, a: a[1],
    OPS["abs"]: lambda z, a: a[1],
    DIV: _quotient,
    SIN: lambda z, a: np.minimum(abs(np.cos(a[0])) * a[1] + a[1] ** 2 / 2, 2.0) + abs(z) * ROUNDING,
    COS: lambda z, a: np.minimum(abs(np.sin(a[0])) * a[1] + a[1] ** 2 / 2, 2.0) + abs(z) * ROUNDING,
    SQRT: lambda z, a: np.fmin(a[1] / z, np.sqrt(a[1])) + z * ROUNDING,
    OPS["min"]: lambda z, a, b: np.maximum(a[1], b[1]),
    OPS["max"]: lambda z, a, b: np.maximum(a[1], b[1]),
    OPS["less"]: lambda z, a, b: 0.0,
    OPS["sign"]: lambda z, a: 0.0,
    OPS["floor"]: lambda z, a: 0.0,
    REGULAR: lambda z, a, size: a[1],
    WHERE: lambda z, condition, a, b: np.where(condition[0], a[1], b[1])[()],
}
"""The bound of z = op(a, …) from the values and bounds of its arguments; of others by differences."""

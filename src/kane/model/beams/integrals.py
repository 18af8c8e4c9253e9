# SPDX-License-Identifier: BSD-3-Clause
"""Modal integrals of a beam, by Gauss's quadrature, once.

With shares r of the mass per length and e of a stiffness, numbers without units (ξ = x/L, ' = d/dξ):

    ∫ r f_k f_l dξ        ∫ e φ''_i φ''_j dξ        H_ij(ξ) = ∫₀^ξ φ'_i φ'_j dη

H is the foreshortening: −qᵀ H q/(2L) is what a point of an axis that keeps its length moves towards the root. Its moments with the
mass, ∫ r H dξ and ∫ r ξ H dξ, are by Fubini ∫ m₀ φ'_i φ'_j dξ and ∫ m₁ φ'_i φ'_j dξ, with m₀ = ∫_ξ¹ r dη and m₁ = ∫_ξ¹ r η dη.
"""

from collections.abc import Callable, Sequence

import numpy as np

from kane.errors import ModelError
from kane.model.beams.shapes import ModeShapes
from kane.numeric.arrays import Array
from kane.numeric.legendre import Rule, gauss
from kane.numeric.scale import EQUAL, STATE_RANK, TAKES_PART

Share = Callable[[Array], Array]

_POINTS = 40
"""Points of a piece between two breaks, beyond twice the number of functions."""
_BITS = 44
"""Sums of numbers that are rounded to 2^-44 of 1 are exact: what cancels in sums, cancels to zero."""


def fine(shapes: Sequence[ModeShapes]) -> Rule:
    """A rule for products of all these functions."""
    breaks = sorted({b for s in shapes for b in s.breaks} | {0.0, 1.0})
    pieces = len(breaks) - 1
    most = max((s.count for s in shapes), default=1)
    return gauss(max(8, (_POINTS + 2 * most) // (1 if pieces == 1 else 4)), breaks)


def rounded(a: Array) -> Array:
    """Numbers of order 1 with few bits, so that they cancel where they should."""
    whole: Array = np.ldexp(np.round(np.ldexp(a, _BITS)), -_BITS)
    return whole


def check_independent(who: str, shapes: ModeShapes, rule: Rule) -> None:
    """A ModelError names the functions that the others make, and the rank."""
    values = np.sqrt(rule.weights)[:, None] * shapes.evaluate(rule.places, 0)
    lengths = np.linalg.norm(values, axis=0)
    zero = [k + 1 for k in np.nonzero(lengths == 0)[0]]
    if zero:
        raise ModelError(f"Expected modes of {who} that bend it, got mode {zero[0]}, which is zero. Leave it out.")
    _, singular, turned = np.linalg.svd(values / lengths)
    rank = int((singular > STATE_RANK * singular[0]).sum())
    if rank < shapes.count:
        parts = np.abs(turned[rank:]).max(axis=0)
        blamed = ", ".join(str(k + 1) for k in np.nonzero(parts > TAKES_PART)[0])
        raise ModelError(
            f"Expected independent modes of {who}, got {shapes.count} of rank {rank}: modes {blamed} depend on each other. Leave out "
            f"{shapes.count - rank} of these."
        )


def foreshortening(shapes: ModeShapes, xi: float) -> Array:
    """H(ξ) (n × n)."""
    breaks = [b for b in shapes.breaks if b < xi]
    if not breaks:
        return np.zeros((shapes.count, shapes.count))
    points = (_POINTS + 2 * shapes.count) // (1 if len(breaks) == 1 else 4)
    rule = gauss(max(points, 8), (*breaks, xi))
    slopes = shapes.evaluate(rule.places, 1)
    return rule.gram(slopes, slopes)


def moments_beyond(share: Share, places: Array) -> tuple[Array, Array]:
    """m₀ and m₁ at each place."""
    inner = gauss(_POINTS)
    x = places[:, None] + np.multiply.outer(1 - places, inner.places)
    weights = np.multiply.outer(1 - places, inner.weights) * share(x)
    return weights.sum(axis=1), (weights * x).sum(axis=1)


def stations(shapes: Sequence[ModeShapes], bending: Sequence[ModeShapes], share: Share) -> Rule:
    """Gauss's rule with the fewest points that has ∫ r f_k f_l of all functions and foreshortenings."""
    target, sizes = _products(fine(shapes), shapes, bending, share)

    def enough(points: int) -> bool:
        error = np.abs(_products(gauss(points), shapes, bending, share)[0] - target)
        return bool((error <= EQUAL * np.multiply.outer(sizes, sizes)).all())

    few, most = 1, 4 * max((s.count for s in shapes), default=1) + 40
    while most - few > 1:
        middle = (few + most) // 2
        few, most = (few, middle) if enough(middle) else (middle, most)
    return gauss(most)


def _products(
    rule: Rule, shapes: Sequence[ModeShapes], bending: Sequence[ModeShapes], share: Share
) -> tuple[Array, Array]:
    values = [np.ones((len(rule.places), 1)), rule.places[:, None]]
    values += [s.evaluate(rule.places, 0) for s in shapes]
    for s in bending:
        h = np.array([foreshortening(s, x) for x in rule.places])
        rows, columns = np.triu_indices(s.count)
        values.append(h[:, rows, columns])
    whole = np.hstack(values)
    squares = rule.gram(whole, whole, share(rule.places))
    return squares, np.sqrt(np.diag(squares))

# SPDX-License-Identifier: BSD-3-Clause
"""Fewer operations: factors out of sums, shared pairs, one reciprocal a divisor, in an order that waits little.

Results change by rounding errors, so that the pass belongs to compilation with contraction. Taking out a factor never raises the
running error bound; sums in another order may, where terms cancel. So the bounds of both are compared at several points, and the code
stays as it was where the bound of a result would be more than twice as large in the mean of the points, or four times at one.
"""

import math

from kane.numeric.sample import draw, value_of
from kane.program.passes.factor import factored
from kane.program.passes.nary import flattened
from kane.program.passes.pairs import paired
from kane.program.passes.reciprocal import divided
from kane.program.passes.rounding import rounding
from kane.program.passes.spell import spelled
from kane.program.passes.verify import verified
from kane.program.program import Code

IN_THE_MEAN, AT_ONE = 2.0, 4.0
"""By what factors the bound on a result's error may grow: in the geometric mean of the points, and at any of them."""
EPS = 2.0**-52
_WIDE = 2.0
"""States are drawn once as everywhere, then of both signs up to this size."""


def optimized(code: Code) -> Code:
    """The code with fewer operations, or as it is where its results would be less exact."""
    result = rewritten(code)
    return result if _as_exact(code, result) else code


def rewritten(code: Code) -> Code:
    """The code with fewer operations."""
    flat = flattened(code)
    factored(flat)
    paired(flat)
    divided(code, flat)
    return verified(spelled(code, flat), "optimize")


def _as_exact(code: Code, result: Code) -> bool:
    """Whether every result is judged at one point at least, is the same but for rounding, and nearly as exact as before."""
    growths: list[list[float]] = [[] for routine in code.routines for _ in routine.results]
    for point in points(code):
        both = zip(growths, rounding(code, point), rounding(result, point), strict=True)
        for found, (value, error), (new, new_error) in both:
            size = error + abs(value)
            if math.isfinite(size):
                growth = (new_error + abs(new)) / size if size else 1.0
                found.append(growth if abs(new - value) <= EPS * (size + new_error) else math.inf)
    return all(found and max(found) <= AT_ONE and _mean(found) <= IN_THE_MEAN for found in growths)


def _mean(growths: list[float]) -> float:
    return math.prod(growths) ** (1.0 / len(growths))


def points(code: Code) -> list[list[float]]:
    """Three points: values of the inputs, those with a default at it."""
    states = {s for port in code.ports if not port.hoisted for s in port.symbols if s.default is None}
    usual = [value_of(s, 0) for s in code.inputs]
    wide = [
        [draw(seed, s, -_WIDE, _WIDE) if s in states else v for s, v in zip(code.inputs, usual, strict=True)]
        for seed in (1, 2)
    ]
    return [usual, *wide]

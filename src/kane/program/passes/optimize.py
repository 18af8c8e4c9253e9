# SPDX-License-Identifier: BSD-3-Clause
"""Fewer operations: factors out of sums, shared pairs, one reciprocal a divisor, in an order that waits little.

Code of moderate length is rewritten a second time with parameters taken out of products and sums before (`content.py`), and the
shorter of both is taken.

Results change by rounding errors, so that the pass belongs to compilation with contraction. Taking out a factor never raises the
running error bound; sums in another order may, where terms cancel. So the bounds of both are compared at several points, and the code
stays as it was where the bound of a result would be more than twice as large in the mean of the points, or four times at one.
"""

import math

from kane.expr.ops import DIV
from kane.numeric.sampling import draw, value_of
from kane.program.passes.content import without_content
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
_MODERATE = 3_000
"""Instructions up to which both forms are tried: longer code would take long to rewrite twice."""
_DIVISION = 8
"""Operations that take as long as a division."""
_SELDOM = 8
"""Operations of parameters that weigh as much as one with the state."""
_WIDE = 2.0
"""States are drawn once as everywhere, then of both signs up to this size."""


def optimized(code: Code) -> Code:
    """The code with fewer operations, or as it is where its results would be less exact."""
    return next((result for result in _forms(code) if _as_exact(code, result)), code)


def rewritten(code: Code) -> Code:
    """The code with fewer operations."""
    return _forms(code)[0]


def _forms(code: Code) -> list[Code]:
    """The code with fewer operations, and with parameters taken out before where no routine grows by that: the shorter one first."""
    plain = _shared(code)
    if len(code.ops) > _MODERATE:
        return [plain]
    other = _shared(without_content(code))
    if any(new > old for new, old in zip(_operations(other), _operations(code), strict=True)):
        return [plain]
    return sorted((plain, other), key=_cost)


def _shared(code: Code) -> Code:
    """The code with common factors taken out of sums, and with shared pairs."""
    flat = flattened(code)
    factored(flat)
    paired(flat)
    divided(code, flat)
    return verified(spelled(code, flat), "optimize")


def _operations(code: Code) -> list[int]:
    """Operations of each routine, of parameters included."""
    found = []
    for routine in code.routines:
        body = code.below(set(routine.results), True)
        read = {a for i in body for a in code.args[i - code.first]}.union(routine.results)
        found.append(sum(code.ops[i - code.first].cost for i in (*body, *code.below(read, False))))
    return found


def _cost(code: Code) -> int:
    """How long one evaluation of all results takes, in additions with the state; those of parameters run once a set of values."""
    body = code.below({i for routine in code.routines for i in routine.results}, True)
    own = sum(_DIVISION if code.ops[i - code.first] is DIV else code.ops[i - code.first].cost for i in body)
    hoisted = code.below({a for i in body for a in code.args[i - code.first]}, False)
    return _SELDOM * own + sum(code.ops[i - code.first].cost for i in hoisted)


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

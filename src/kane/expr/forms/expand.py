# SPDX-License-Identifier: BSD-3-Clause
"""Short expressions multiplied out: sums of products, with like terms joined, squares of sines and cosines too.

    (b u₁ + u₂)² + (b u₁ − u₂)²  →  2 b² u₁² + 2 u₂²        m u₁ s² + m u₁ c²  →  m u₁        a − a s²  →  a c²

What cancels is gone then, where no single step of building sees it. A tangent is s/c until the end. What would become long stays a
factor, and arguments of functions are left as they are.
"""

from collections.abc import Mapping
from fractions import Fraction

from kane.expr.build import NODE_BUILDERS
from kane.expr.evaluation import price
from kane.expr.forms.collect import Powers, Term, factored, ordered
from kane.expr.node import Expr, Number, constant_value
from kane.expr.ops import ADD, COS, DIV, MUL, NEG, SIN, SUB, TAN
from kane.expr.surd import times
from kane.expr.visit import fold

MOST = 48
"""Terms up to which a sum is multiplied out."""
_ROUNDING = 2.0**-50
"""Share of its terms' numbers at which a sum of them is what rounding left of zero."""

Polynomial = dict[Powers, Number]
_Known = dict[Expr, Polynomial | None]


def expanded(e: Expr) -> list[Term] | None:
    """The terms of e; None where they are many."""
    known: _Known = {}
    found = fold(e, known, lambda node: _of(node, known))
    return None if found is None else [(n, _with_tangents(f)) for f, n in _without_squares(found).items()]


def _of(node: Expr, known: _Known) -> Polynomial | None:
    """The terms of a node by those of its arguments."""
    value = constant_value(node)
    if value is not None:
        return {(): value} if value else {}
    op, args = node.op, node.args
    if op is ADD or op is SUB:
        a, b = known[args[0]], known[args[1]]
        return None if a is None or b is None else _few(_sum(a, b, 1 if op is ADD else -1))
    if op is NEG:
        a = known[args[0]]
        return None if a is None else {f: -n for f, n in a.items()}
    if op is MUL:
        a, b = (_factor(x, known) for x in args)
        if len(a) * len(b) > MOST:
            a, b = (_atom(args[0]), b) if len(a) > len(b) else (a, _atom(args[1]))
        return _few(_times(a, b))
    if op is DIV:
        return _few(_times(_factor(args[0], known), _inverse(args[1], known)))
    if op is TAN:
        sine, cosine = (NODE_BUILDERS[name](args[0]) for name in ("sin", "cos"))
        return {_powers({sine: 1, cosine: -1}): 1} if sine.op is SIN and cosine.op is COS else _atom(node)
    return _atom(node)


def _few(a: Polynomial) -> Polynomial | None:
    return a if len(a) <= MOST else None


def _atom(node: Expr) -> Polynomial:
    return {((node, 1),): 1}


def _factor(node: Expr, known: _Known) -> Polynomial:
    found = known[node]
    return _atom(node) if found is None else found


def _inverse(node: Expr, known: _Known) -> Polynomial:
    """1/node: of a sum what its terms share is taken out first, 1/(m + I/R²) = R²/(m R² + I)."""
    below = _factor(node, known)
    if not below:
        return {((node, -1),): 1}
    if len(below) > 1:
        terms = [dict(f) for f in below]
        shared = {f: min(p.get(f, 0) for p in terms) for f in dict.fromkeys(f for p in terms for f in p)}
        inverse = _powers({f: -k for f, k in shared.items()})
        whole = factored([(n, f) for f, n in _times(below, {inverse: 1}).items()])
        if inverse or price([whole]) < price([node]):
            node = whole
        return {_powers(dict(inverse) | {node: dict(inverse).get(node, 0) - 1}): 1}
    ((factors, n),) = below.items()
    number: Number = Fraction(1, n) if isinstance(n, int) else 1 / n
    return {tuple((f, -k) for f, k in factors): number}


def _powers(powers: Mapping[Expr, int]) -> Powers:
    return tuple((f, powers[f]) for f in ordered(powers) if powers[f])


def _sum(a: Polynomial, b: Polynomial, sign: int) -> Polynomial:
    total = dict(a)
    for f, n in b.items():
        x = _added(total.pop(f, 0), sign * n)
        if x:
            total[f] = x
    return total


def _added(a: Number, b: Number) -> Number:
    """a + b, and zero where rounding alone is left."""
    total: Number = a + b
    return 0 if abs(float(total)) <= _ROUNDING * abs(float(b)) else total


def _times(a: Polynomial, b: Polynomial) -> Polynomial:
    total: Polynomial = {}
    for f, n in a.items():
        for g, k in b.items():
            powers = dict(f)
            for x, p in g:
                powers[x] = powers.get(x, 0) + p
            key = _powers(powers)
            value = _added(total.pop(key, 0), times(n, k))
            if value:
                total[key] = value
    return total


def _without_squares(a: Polynomial) -> Polynomial:
    """B x + S x s² + C x c² as short as there can be: (B + t) x + (S − t) x s² + (C − t) x c²."""
    found, waiting = a, True
    while waiting:
        waiting = False
        for f in found:
            better = next((p for x in _squares(f) if (p := _fewer(found, x)) is not None), None)
            if better is not None:
                found, waiting = better, True
                break
    return found


def _squares(f: Powers) -> list[tuple[Powers, Powers, Powers]]:
    """x, x s² and x c² for each square of a sine or cosine in a product."""
    found = []
    for x, k in f:
        if k >= 2 and (x.op is SIN or x.op is COS):
            sine, cosine = (NODE_BUILDERS[name](x.args[0]) for name in ("sin", "cos"))
            rest = dict(f) | {x: k - 2}
            above, beside = (_powers({**rest, y: rest.get(y, 0) + 2}) for y in (sine, cosine))
            found.append((_powers(rest), above, beside))
    return found


def _fewer(a: Polynomial, of: tuple[Powers, Powers, Powers]) -> Polynomial | None:
    """The polynomial with fewer of the terms x, x s² and x c², or of the squares; None where these are as few as can be."""
    plain, sine, cosine = (a.get(f, 0) for f in of)
    ways = [(_added(plain, t), _added(sine, -t), _added(cosine, -t)) for t in (sine, cosine, -plain)]
    best = min(ways, key=_length)
    if _length(best)[0] >= _length((plain, sine, cosine))[0]:
        return None
    ours = set(of)  # a set compares hashes first: expressions refuse ==
    left = {f: n for f, n in a.items() if f not in ours}
    return left | {f: n for f, n in zip(of, best, strict=True) if n}


def _length(numbers: tuple[Number, Number, Number]) -> tuple[int, int]:
    """Of x, x s² and x c² the terms that there are, those with squares twice; then the changes of sign."""
    plain, sine, cosine = map(bool, numbers)
    return plain + 2 * (sine + cosine), len({n > 0 for n in numbers if n})


def _with_tangents(f: Powers) -> Powers:
    """s/c as tangents."""
    powers = dict(f)
    for x, k in f:
        if x.op is COS and k < 0:
            sine, tangent = (NODE_BUILDERS[name](x.args[0]) for name in ("sin", "tan"))
            shared = min(powers.get(sine, 0), -k)
            if shared > 0:
                powers[sine] -= shared
                powers[x] += shared
                powers[tangent] = powers.get(tangent, 0) + shared
    return _powers(powers)

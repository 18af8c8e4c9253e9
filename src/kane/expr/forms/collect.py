# SPDX-License-Identifier: BSD-3-Clause
"""Sums of products, collected: like terms joined, and the factor that most terms have taken out, as one writes a short equation.

    R u₂ u₃ + R u₂ u₃/2 − R u₂² tan q₂/4 + g sin q₂  →  g sin q₂ + R u₂ (3 u₃/2 − u₂ tan q₂/4)

What a product and parameters that it is divided by have in common is cancelled: (2 m R²/5) (Ω u/R)/R is 2 m Ω u/5; and what a
quotient in it is divided by: (u₂/cos q₂) (R u₁ cos q₂) is R u₁ u₂. Sums that are factors of a product are collected, those within the
terms of a sum are left as they are. What all this costs is for the caller to compare.

Several sums a x + b y of the same x and y, with numbers a and b, are made of each other:

    x − y,  2 x − y,  3 x/2 − y/4  →  s = x − y,  t = s + x,  x + t/4

Short expressions may be multiplied out before: sums of products, with like terms joined, squares of sines and cosines too.

    (b u₁ + u₂)² + (b u₁ − u₂)²  →  2 b² u₁² + 2 u₂²        m u₁ s² + m u₁ c²  →  m u₁        a − a s²  →  a c²

What cancels is gone then, where no single step of building sees it. A tangent is s/c until the end. What would become long stays a
factor, and arguments of functions are left as they are.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from fractions import Fraction
from functools import cmp_to_key, reduce
from itertools import combinations
from operator import attrgetter
from typing import Any, NamedTuple

from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sub, sum_of
from kane.expr.evaluation import Together, price
from kane.expr.node import ONE, ZERO, Expr, Number, constant, constant_value, number_of, postorder, precedes
from kane.expr.numbers import times
from kane.expr.ops import ADD, CONST, COS, DIV, MUL, NEG, SIN, SUB, TAN
from kane.expr.symbols import Parameter
from kane.expr.visit import fold, imaged, remembered, replaced_in

_MOST = 12
"""Terms, and factors of a term, up to which a sum is collected."""

_KEY = attrgetter("key")
_ORDER: Callable[[Expr], Any] = cmp_to_key(lambda a, b: -1 if precedes(a, b) else 1)

Powers = tuple[tuple[Expr, int], ...]
Term = tuple[Number, Powers]
"""A number, and factors in their order with their powers, which may be below zero."""


def ordered(factors: Iterable[Expr]) -> list[Expr]:
    """Factors in the order in which they stand in a product."""
    result = sorted(factors, key=_KEY)
    before = None
    for f in result:
        if f.key == before or f.op is CONST:
            return sorted(result, key=_ORDER)
        before = f.key
    return result


def collected(e: Expr) -> Expr:
    """The sum or product e collected; e itself where it is neither, or a long one."""
    if e.op is NEG:
        return neg(collected(e.args[0]))
    return _collected(e) if e.op in _COLLECTED else e


_COLLECTED = frozenset((ADD, SUB, MUL, DIV))


@remembered
def _collected(e: Expr) -> Expr:
    terms = terms_of(e)
    if terms is None:
        return e
    if len(terms) > 1:
        return factored(terms)
    return factored(
        [(n, tuple((collected(f) if f.op is ADD or f.op is SUB else f, k) for f, k in factors)) for n, factors in terms]
    )


def quotient(e: Expr, divisor: Expr) -> Expr | None:
    """e / divisor collected, for a product of parameters that each term of e holds; None else, and where e is a long sum."""
    number, factors = _product(divisor)
    terms = terms_of(e)
    if not terms or any(k < 0 or not isinstance(f, Parameter) for f, k in factors):
        return None
    found: list[Term] = []
    for n, powers in terms:
        held = dict(powers)
        for f, k in factors:
            held[f] = held.get(f, 0) - k
            if held[f] < 0:
                return None
        found.append((_over(n, number), tuple([(f, k) for f, k in held.items() if k])))
    return factored(found)


def _over(number: Number, divisor: Number) -> Number:
    """A quotient of numbers, exact where it can be."""
    if divisor == 1 or divisor == -1:
        return number if divisor == 1 else -number
    if isinstance(number, int | Fraction) and isinstance(divisor, int | Fraction):
        return Fraction(number) / divisor
    return number / divisor


def terms_of(e: Expr) -> list[Term] | None:
    """The terms of e as they stand, like ones joined; None where they are many."""
    found: dict[Powers, Number] = {}
    waiting: list[tuple[Expr, int]] = [(e, 1)]
    count = 0
    while waiting:
        x, sign = waiting.pop()
        if x.op is ADD or x.op is SUB:
            waiting += [(x.args[1], sign if x.op is ADD else -sign), (x.args[0], sign)]
        elif x.op is NEG:
            waiting.append((x.args[0], -sign))
        else:
            count += 1
            number, factors = _product(x)
            if count > _MOST or len(factors) > _MOST:
                return None
            number = number if sign > 0 else -number
            found[factors] = found[factors] + number if factors in found else number
    return [(n, f) for f, n in found.items() if n != 0]


def _product(e: Expr) -> Term:
    """The number and the factors that e is the product of."""
    number: Number = 1
    divisor: Number = 1
    powers: dict[Expr, int] = {}
    waiting = [(e, 1)]
    quotients = False
    while waiting:
        x, power = waiting.pop()
        op = x.op
        if op is MUL:
            a, b = x.args
            waiting += ((a, power), (b, power))
        elif op is CONST and x is not ZERO:
            value = number_of(x)
            number, divisor = (times(number, value), divisor) if power > 0 else (number, times(divisor, value))
        elif op is DIV and _of_parameters(x.args[1]):  # a tangent stays one
            waiting += ((x.args[0], power), (x.args[1], -power))
        elif op is NEG:
            number = -number
            waiting.append((x.args[0], power))
        else:
            powers[x] = powers.get(x, 0) + power
            quotients = quotients or op is DIV
    if quotients:
        _cancel(powers)
    return _over(number, divisor), factor_powers(powers)


def _cancel(powers: dict[Expr, int]) -> None:
    """Quotients whose divisor is a factor, too, are replaced by what is divided."""
    for x in [x for x in powers if x.op is DIV]:
        top, below = x.args
        times = min(powers[x], powers.get(below, 0))
        if times > 0:
            powers[top] = powers.get(top, 0) + times
            powers[x] -= times
            powers[below] -= times


def _of_parameters(e: Expr) -> bool:
    """Whether e is a product of parameters and numbers."""
    if e.op is MUL:
        return _of_parameters(e.args[0]) and _of_parameters(e.args[1])
    return e.op is CONST or isinstance(e, Parameter)


def factored(terms: Sequence[Term]) -> Expr:
    """The factor that most terms have, times what is left of them, plus the other terms likewise; a divisor that all have below."""
    if not terms:
        return ZERO
    if len(terms) == 1:
        ((number, factors),) = terms
        return _times(number, factors)
    above: dict[Expr, int] = {}
    below: dict[Expr, int] = {}
    for _, factors in terms:
        for f, k in factors:
            held = above if k > 0 else below
            held[f] = held.get(f, 0) + 1
    for f, k in terms[0][1]:
        if k < 0 and below[f] == len(terms):
            return div(factored([(n, _raised(p, f, 1)) for n, p in terms]), f)
    common = max(above, key=above.__getitem__, default=None)
    if common is None or above[common] < 2:
        return sum_of(_times(number, factors) for number, factors in terms)
    own: list[Term] = []
    others: list[Term] = []
    for n, p in terms:
        if any(f is common and k > 0 for f, k in p):
            own.append((n, _raised(p, common, -1)))
        else:
            others.append((n, p))
    return add(factored(others), mul(common, factored(own)))


def _raised(powers: Powers, factor: Expr, by: int) -> Powers:
    """The product with one factor's power changed."""
    return tuple([(f, k + by if f is factor else k) for f, k in powers if f is not factor or k + by])


def _times(number: Number, factors: Powers) -> Expr:
    above, below = ONE, ONE
    for f, k in factors:
        for _ in range(abs(k)):
            above, below = (mul(above, f), below) if k > 0 else (above, mul(below, f))
    product = above if number == 1 else mul(constant(number), above)
    return product if below is ONE else div(product, below)


_MOST_SUMS = 8
"""Sums of the same terms up to which they are compared."""

Pair = tuple[Number, Number]
"""a and b."""


class _Combination(NamedTuple):
    """α p + β q, its operations first."""

    cost: int
    alpha: Fraction
    beta: Fraction
    p: Expr
    q: Expr

    def made(self) -> Expr:
        """The expression."""
        if abs(self.alpha) == abs(self.beta):
            return mul(constant(self.alpha), (add if self.alpha == self.beta else sub)(self.p, self.q))
        return add(mul(constant(self.alpha), self.p), mul(constant(self.beta), self.q))


def combined(roots: Sequence[Expr], kept: Set[Expr] = frozenset()) -> tuple[Expr, ...]:
    """`roots` with their sums of two terms made of each other, `kept` ones apart, where all together take fewer operations."""
    replaced: dict[Expr, Expr] = {}
    together = Together.of(roots)
    for (x, y), sums in _alike(together.order).items():
        if 1 < len(sums) <= _MOST_SUMS:
            replaced |= _chain(x, y, sums)
    return together.or_shorter(replaced_in(together, replaced, kept, together.order)) if replaced else together


def joined(roots: Sequence[Expr]) -> tuple[Expr, ...]:
    """`roots` as each reads by itself: like terms in sums of sums joined, where it gets no longer: 3 x/2 − y/4 for x + (2 x − y)/4."""
    alike, images = _with_like_terms(roots), dict[Expr, Expr]()

    def image(node: Expr) -> Expr:
        own = imaged(node, images)
        if (own is node and node not in alike) or (own.op is not ADD and own.op is not SUB):
            return own
        found = list(_numbered_terms(own))
        terms = _summed(found)
        return reduce(add, (mul(constant(a), x) for x, a in terms.items()), ZERO) if len(terms) < len(found) else own

    if not alike:
        return tuple(roots)
    made = [fold(e, images, image) for e in roots]
    return tuple([x if x is e or price([x]) <= price([e]) else e for x, e in zip(made, roots, strict=True)])


def _with_like_terms(roots: Sequence[Expr]) -> set[Expr]:
    """Sums with like terms among theirs and those of the sums in them; a sum in one without has none."""
    alike, plain = set[Expr](), set[Expr]()
    for node in reversed(postorder(roots)):
        if node.op is ADD or node.op is SUB or (node.op is NEG and node in plain):
            terms = [] if node in plain else [x for x, _ in _numbered_terms(node)]
            if len(set(terms)) < len(terms):
                alike.add(node)
            else:
                plain.update(node.args)
    return alike


def _summed(found: Iterable[tuple[Expr, Number]]) -> dict[Expr, Number]:
    """The terms with the sums of their numbers."""
    terms: dict[Expr, Number] = {}
    for x, a in found:
        terms[x] = terms.get(x, 0) + a
    return terms


def _alike(order: Sequence[Expr]) -> dict[tuple[Expr, Expr], dict[Pair, Expr]]:
    """Sums among nodes by their two terms, with rational numbers."""
    result: dict[tuple[Expr, Expr], dict[Pair, Expr]] = {}
    for node in order:
        if node.op is ADD or node.op is SUB:
            terms = _summed(_numbered_terms(node))
            if len(terms) == 2 and all(isinstance(a, int | Fraction) and a for a in terms.values()):
                x, y = sorted(terms, key=lambda e: e.key)
                result.setdefault((x, y), {})[terms[x], terms[y]] = node
    return result


def _numbered_terms(e: Expr) -> Iterator[tuple[Expr, Number]]:
    """Terms with their numbers, of sums of sums, too."""
    waiting: list[tuple[Expr, Number]] = [(e, 1)]
    while waiting:
        x, a = waiting.pop()
        if x.op is ADD or x.op is SUB:
            waiting += [(x.args[0], a), (x.args[1], a if x.op is ADD else -a)]
        elif x.op is NEG:
            waiting.append((x.args[0], -a))
        elif x.op is MUL and x.args[0].op is CONST and isinstance(number_of(x.args[0]), int | Fraction):
            waiting.append((x.args[1], a * number_of(x.args[0])))
        else:
            yield x, a


def _chain(x: Expr, y: Expr, sums: Mapping[Pair, Expr]) -> dict[Expr, Expr]:
    """Each sum by terms or sums that come before it, the one that takes least first."""
    known: dict[Pair, Expr] = {(1, 0): x, (0, 1): y}
    left, replaced = dict(sums), {}
    while left:
        ways = {pair: min(_combinations(pair, known), key=lambda way: way.cost) for pair in left}
        pair = min(ways, key=lambda own: ways[own].cost)
        node = left.pop(pair)
        known[pair] = ways[pair].made()
        if known[pair] is not node:
            replaced[node] = known[pair]
    return replaced


def _combinations(wanted: Pair, known: Mapping[Pair, Expr]) -> Iterator[_Combination]:
    (a, b) = wanted
    for ((c, d), p), ((e, f), q) in combinations(known.items(), 2):
        determinant = Fraction(c * f - d * e)
        if determinant:
            alpha, beta = Fraction(a * f - b * e) / determinant, Fraction(c * b - d * a) / determinant
            factors = {abs(alpha), abs(beta)} if alpha and beta else set()  # one for both where they are alike
            cost = 1 + len(factors - {1})
            yield _Combination(cost, alpha, beta, p, q)


# Expanded forms ------------------------------------------------------------------------------------------------------


MOST = 48
"""Terms up to which a sum is multiplied out."""
_ROUNDING = 2.0**-50
"""Share of its terms' numbers at which a sum of them is what rounding left of zero."""

Polynomial = dict[Powers, Number]
Expansions = dict[Expr, Polynomial | None]


def expanded(e: Expr, known: Expansions | None = None) -> list[Term] | None:
    """The terms of e; None where they are many. `known` keeps those of its parts for other expressions."""
    known = {} if known is None else known
    found = fold(e, known, lambda node: _of(node, known))
    return None if found is None else [(n, _with_tangents(f)) for f, n in _without_squares(found).items()]


def _of(node: Expr, known: Expansions) -> Polynomial | None:
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
        return _few(_polynomial_product(a, b))
    if op is DIV:
        return _few(_polynomial_product(_factor(args[0], known), _inverse(args[1], known)))
    if op is TAN:
        sine, cosine = (NODE_BUILDERS[name](args[0]) for name in ("sin", "cos"))
        return {factor_powers({sine: 1, cosine: -1}): 1} if sine.op is SIN and cosine.op is COS else _atom(node)
    return _atom(node)


def _few(a: Polynomial) -> Polynomial | None:
    return a if len(a) <= MOST else None


def _atom(node: Expr) -> Polynomial:
    return {((node, 1),): 1}


def _factor(node: Expr, known: Expansions) -> Polynomial:
    found = known[node]
    return _atom(node) if found is None else found


def _inverse(node: Expr, known: Expansions) -> Polynomial:
    """1/node: of a sum what its terms share is taken out first, 1/(m + I/R²) = R²/(m R² + I)."""
    below = _factor(node, known)
    if not below:
        return {((node, -1),): 1}
    if len(below) > 1:
        terms = [dict(f) for f in below]
        shared = {f: min(p.get(f, 0) for p in terms) for f in dict.fromkeys(f for p in terms for f in p)}
        inverse = factor_powers({f: -k for f, k in shared.items()})
        whole = factored([(n, f) for f, n in _polynomial_product(below, {inverse: 1}).items()])
        if inverse or price([whole]) < price([node]):
            node = whole
        return {factor_powers(dict(inverse) | {node: dict(inverse).get(node, 0) - 1}): 1}
    ((factors, n),) = below.items()
    number: Number = Fraction(1, n) if isinstance(n, int) else 1 / n
    return {tuple((f, -k) for f, k in factors): number}


def factor_powers(powers: Mapping[Expr, int]) -> Powers:
    """The factors with powers other than zero, in their order."""
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
    if not a:
        return b
    total: Number = a + b
    return 0 if abs(float(total)) <= _ROUNDING * abs(float(b)) else total


def _polynomial_product(a: Polynomial, b: Polynomial) -> Polynomial:
    total: Polynomial = {}
    for f, n in a.items():
        for g, k in b.items():
            key = _together(f, g) if f and g else f or g
            value = _added(total.pop(key, 0), times(n, k))
            if value:
                total[key] = value
    return total


def _together(f: Powers, g: Powers) -> Powers:
    powers = dict(f)
    for x, p in g:
        powers[x] = powers.get(x, 0) + p
    return factor_powers(powers)


def _without_squares(a: Polynomial) -> Polynomial:
    """B x + S x s² + C x c² as short as there can be: (B + t) x + (S − t) x s² + (C − t) x c²."""
    result, waiting = a, True
    while waiting:
        waiting = False
        for f in result:
            better = next((p for x in _squares(f) if (p := _fewer(result, x)) is not None), None)
            if better is not None:
                result, waiting = better, True
                break
    return result


def _squares(f: Powers) -> list[tuple[Powers, Powers, Powers]]:
    """x, x s² and x c² for each square of a sine or cosine in a product."""
    result = []
    for x, k in f:
        if k >= 2 and (x.op is SIN or x.op is COS):
            sine, cosine = (NODE_BUILDERS[name](x.args[0]) for name in ("sin", "cos"))
            rest = dict(f) | {x: k - 2}
            above, beside = (factor_powers({**rest, y: rest.get(y, 0) + 2}) for y in (sine, cosine))
            result.append((factor_powers(rest), above, beside))
    return result


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
    return factor_powers(powers)

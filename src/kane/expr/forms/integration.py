# SPDX-License-Identifier: BSD-3-Clause
"""Antiderivatives in closed form, of what energies of mechanics are made of.

    ∫ xᵏ Π sin(aᵢ x + bᵢ) cos(aⱼ x + bⱼ) dx,   ∫ xᵏ exp(a x + b) dx,   ∫ g′ gᵖ dx with g any expression, p any half of an integer

Sums are multiplied out first, and terms that share a power of one g looked at together. What is none of these has None: nothing is
guessed, and whoever asks differentiates back.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import reduce

from kane.expr.build import NODE_BUILDERS, add, cos, div, mul, neg, sin, sub, sum_of
from kane.expr.differentiation import affine, diff
from kane.expr.evaluation import free_symbols
from kane.expr.forms.collect import Powers, Term, expanded, factor_powers, factored
from kane.expr.node import ONE, ZERO, Expr, constant
from kane.expr.ops import ADD, COS, DIV, MUL, NEG, OPS, SIN, SQRT, SUB, TAN
from kane.expr.symbols import Parameter, Symbol
from kane.expr.visit import fold, imaged

_EXP, _MAX, _LOG, _ABS = OPS["exp"], OPS["max"], NODE_BUILDERS["log"], NODE_BUILDERS["abs"]
_MOST = 6
"""Powers up to which products of sines and cosines are written as sums, and powers of x integrated by parts."""


def antiderivative(e: Expr, x: Symbol) -> Expr | None:
    """F with ∂F/∂x = e, without a constant; None where the table does not reach."""
    whole, roots = _with_roots(e, x)
    terms = expanded(whole)
    if terms is None:
        return _apart(e, x)
    free: list[Term] = []
    groups: dict[Powers, list[Term]] = {}
    for n, powers in terms:
        plain = _without_tangents(powers)
        hard = tuple((f, k) for f, k in plain if f in roots or _is_hard(f, k, x))
        left = tuple((f, k) for f, k in plain if not (f in roots or _is_hard(f, k, x)))
        (groups.setdefault(hard, []) if hard else free).append((n, left))
    found = [_easy(term, x) for term in free] + [_by_substitution(h, own, roots, x) for h, own in groups.items()]
    return None if any(f is None for f in found) else sum_of([f for f in found if f is not None])


def _with_roots(e: Expr, x: Symbol) -> tuple[Expr, dict[Expr, Expr]]:
    """`e` with symbols for roots of what holds x, and of sums with x that are divided by; each symbol by what it is the root of."""
    symbols: dict[Expr, Expr] = {}
    images: dict[Expr, Expr] = {}

    def root(of: Expr) -> Expr:
        if of not in symbols:
            symbols[of] = Parameter.declare(f"root{len(symbols)}", description="stands for a root")
        return symbols[of]

    def below(node: Expr) -> Expr:
        if node.op is MUL:
            return mul(*map(below, node.args))
        return mul(root(node), root(node)) if node.op in (ADD, SUB) and _holds(node, x) else images[node]

    def image(node: Expr) -> Expr:
        if node.op is SQRT and _holds(node, x):
            return root(node.args[0])
        return div(images[node.args[0]], below(node.args[1])) if node.op is DIV else imaged(node, images)

    whole = fold(e, images, image)
    return whole, {s: of for of, s in symbols.items()}


def _apart(e: Expr, x: Symbol) -> Expr | None:
    """Of a long sum, term by term."""
    if e.op not in (ADD, SUB, NEG):
        return None
    found = [own for y in e.args if (own := antiderivative(y, x)) is not None]
    return NODE_BUILDERS[e.op.name](*found) if len(found) == len(e.args) else None


def _without_tangents(powers: Powers) -> Powers:
    found: dict[Expr, int] = {}
    for f, k in powers:
        for g, sign in ((sin(f.args[0]), 1), (cos(f.args[0]), -1)) if f.op is TAN else ((f, 1),):
            found[g] = found.get(g, 0) + sign * k
    return factor_powers(found)


def _slope(e: Expr, x: Symbol) -> Expr | None:
    """a of an argument a x + b, free of x; None where it is no such."""
    own = diff(e, x)
    return None if _holds(own, x) else own


def _holds(e: Expr, x: Symbol) -> bool:
    return x in set(free_symbols([e]))


def _is_hard(f: Expr, k: int, x: Symbol) -> bool:
    """Whether a factor holds x, and is no power of x, sine, cosine or exponential of a x + b."""
    if f is x or not _holds(f, x):
        return f is x and k < 0
    plain = 0 < k <= _MOST if f.op is SIN or f.op is COS else f.op is _EXP and k > 0
    return not plain or _slope(f.args[0], x) is None


def _easy(term: Term, x: Symbol) -> Expr | None:
    n, powers = term
    outside = factored([(n, tuple((f, k) for f, k in powers if not _holds(f, x)))])
    own = [(f, k) for f, k in powers if _holds(f, x)]
    degree = sum(k for f, k in own if f is x)
    waves = [(f, k) for f, k in own if f.op is SIN or f.op is COS]
    growing = [(f, k) for f, k in own if f.op is _EXP]
    if degree > _MOST * 4 or (waves and growing) or len(growing) > 1 or (degree > _MOST and (waves or growing)):
        return None
    if growing:
        ((f, k),) = growing
        return mul(outside, _exponential(f, k, degree, x))
    return mul(outside, _waves(waves, degree, x) if waves else div(_power(x, degree + 1), constant(degree + 1)))


def _power(e: Expr, k: int) -> Expr:
    return reduce(mul, [e] * k, ONE)


def _exponential(f: Expr, k: int, degree: int, x: Symbol) -> Expr:
    """∫ xᵈ exp(ψ)ᵏ by parts."""
    slope = mul(constant(k), diff(f.args[0], x))
    wave, total, factor = _power(f, k), ZERO, div(ONE, slope)
    for d in range(degree, -1, -1):
        total = add(total, mul(factor, mul(_power(x, d), wave)))
        factor = neg(div(mul(constant(d), factor), slope))
    return total


Wave = tuple[Fraction, Mapping[Expr, int], bool]
"""A number, the multiples of arguments that are summed, and whether it is the sine of the sum."""


def _waves(own: Sequence[tuple[Expr, int]], degree: int, x: Symbol) -> Expr:
    short = _one_angle(own, x) if degree == 0 else None
    if short is not None:
        return short
    sums: list[Wave] = [(Fraction(1), {}, False)]
    for f, k in own:
        for _ in range(k):
            sums = [w for old in sums for w in _times(old, f.args[0], f.op is SIN)]
    return sum_of([_wave(w, degree, x) for w in _joined(sums)])


def _one_angle(own: Sequence[tuple[Expr, int]], x: Symbol) -> Expr | None:
    """∫ sᵐ c = sᵐ⁺¹/((m + 1) a),  ∫ cᵐ s = −cᵐ⁺¹/((m + 1) a)."""
    if len({f.args[0] for f, _ in own}) != 1:
        return None
    s, c = (dict(own).get(g(own[0][0].args[0]), 0) for g in (sin, cos))
    slope, angle = diff(own[0][0].args[0], x), own[0][0].args[0]
    if c == 1:
        return div(_power(sin(angle), s + 1), mul(constant(s + 1), slope))
    if s == 1:
        return neg(div(_power(cos(angle), c + 1), mul(constant(c + 1), slope)))
    return None


def _times(old: Wave, angle: Expr, is_sine: bool) -> list[Wave]:
    """Products as sums: cos A cos B = ½ (cos(A − B) + cos(A + B)) and its like."""
    n, parts, sine = old
    half = n / 2
    more, less = ({**parts, angle: parts.get(angle, 0) + k} for k in (1, -1))
    if not is_sine:
        return [(half, more, sine), (half, less, sine)]
    return [(half, more, True), (-half, less, True)] if not sine else [(half, less, False), (-half, more, False)]


def _joined(sums: Sequence[Wave]) -> list[Wave]:
    """Waves of one argument once, its sign put in order."""
    found: dict[tuple[tuple[tuple[Expr, int], ...], bool], Fraction] = {}
    for n, parts, sine in sums:
        own = list(factor_powers(parts))
        if own and own[0][1] < 0:
            own, n = [(a, -k) for a, k in own], -n if sine else n
        if own or not sine:
            key = tuple(own), sine
            found[key] = found.get(key, Fraction(0)) + n
    return [(n, dict(own), sine) for (own, sine), n in found.items() if n]


def _wave(w: Wave, degree: int, x: Symbol) -> Expr:
    """∫ xᵈ sin ψ, ∫ xᵈ cos ψ by parts."""
    n, parts, sine = w
    angle = sum_of([mul(constant(k), a) for a, k in parts.items()])
    own, rest = affine(angle, [x])
    slope = own.get(x)
    if slope is None:
        level = sin(rest) if sine else cos(rest)
        return mul(mul(constant(n), level), div(_power(x, degree + 1), constant(degree + 1)))
    total, factor = ZERO, constant(n)
    for d in range(degree, -1, -1):
        factor = div(neg(factor) if sine else factor, slope)
        total = add(total, mul(factor, mul(_power(x, d), cos(angle) if sine else sin(angle))))
        factor, sine = neg(mul(constant(d), factor)), not sine
    return total


def _by_substitution(hard: Powers, terms: Sequence[Term], roots: Mapping[Expr, Expr], x: Symbol) -> Expr | None:
    """∫ c g′ gᵖ dx = c gᵖ⁺¹/(p + 1), c log |g| where p = −1; g under a root has half its power."""
    if len(hard) != 1:
        return None
    ((f, k),) = hard
    base, power = (roots[f], Fraction(k, 2)) if f in roots else (f, Fraction(k))
    above = sum_of([factored([term]) for term in terms])
    share = _multiple(above, diff(_moving(base), x), x)
    if share is None:
        return None
    if power == -1:
        return mul(share, _LOG(_ABS(base)))
    raised = power + 1
    value = _power(base, abs(raised.numerator) // raised.denominator)
    if raised.denominator == 2:
        value = mul(value, NODE_BUILDERS["sqrt"](base))
    return div(mul(share, value if raised > 0 else div(ONE, value)), constant(raised))


def _moving(base: Expr) -> Expr:
    """What max(y, 0) is where it is not zero."""
    return next((y for y in base.args if y is not ZERO), base) if base.op is _MAX and ZERO in set(base.args) else base


def _multiple(e: Expr, of: Expr, x: Symbol) -> Expr | None:
    """c with e = c · of, free of x; None where there is none."""
    known = expanded(of)
    own = expanded(e)
    if not known or not own:
        return None
    n, first = known[0]
    for k, powers in own:
        left = dict(powers)
        for f, p in first:
            left[f] = left.get(f, 0) - p
        rest = factor_powers(left)
        if any(_holds(f, x) for f, _ in rest):
            continue
        number = k / n if isinstance(k, float) or isinstance(n, float) else Fraction(k) / n
        share = factored([(number, rest)])
        left_over = expanded(sub(e, mul(share, of)))
        if left_over is not None and not left_over:
            return share
    return None

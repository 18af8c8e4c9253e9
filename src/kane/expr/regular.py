# SPDX-License-Identifier: BSD-3-Clause
"""Guards of divisors that may vanish: `regular(d, size)` is d, or NaN if |d| is within rounding of zero beside its size.

The guard replaces d as a divisor, so that a quotient by a vanishing d is NaN in every language. It does not count as an operation and
is not shown in formulas.

The size of an expression is an estimate of its largest value: |sin x| and |cos x| count as 1, a sum as its largest term, a product as
the product of the sizes of its factors. In most cases it depends on parameters alone, not on the angles at which the expression
vanishes. Absolute values and comparisons cost no operation.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce
from typing import TypeAlias

from kane.expr.build import NODE_BUILDERS, div, mul
from kane.expr.evaluation import free_symbols
from kane.expr.node import (
    ONE,
    ZERO,
    Expr,
    constant,
    constant_value,
    intern_pair,
    intern_single,
    nodes,
    postorder,
    precedes,
    weight,
)
from kane.expr.ops import ABS, ADD, CONST, COS, DIV, MAX, MUL, NEG, OPS, REGULAR, SIN, SQRT, SUB
from kane.expr.symbols import Parameter, Symbol, time
from kane.expr.visit import fold, imaged

_MOST = 12
"""Terms of a sum that are looked at one by one; where there are more, its two sides are."""
Sizes = dict[Expr, tuple[Expr, ...]]
"""Of each expression those whose largest absolute value is its size."""


def size(e: Expr, memo: Sizes, late: bool = False) -> Expr:
    """The size of `e`; a `memo` shared between calls keeps the sizes of common subexpressions.

    If `late`, that of sin ω t is at least |ω t|, to which rounding of the time is proportional.
    """
    terms = fold(e, memo, lambda node: _of_node(node, [memo[a] for a in node.args], late))
    return largest(terms)


def largest(terms: Iterable[Expr]) -> Expr:
    """The largest absolute value of terms; 0 without any."""
    sizes = [x if _is_size(x) else NODE_BUILDERS["abs"](x) for x in _distinct(terms)]
    return reduce(NODE_BUILDERS["max"], sizes) if sizes else ZERO


def _is_size(x: Expr) -> bool:
    """Whether `x` consists of absolute values and roots combined by products, quotients and maxima."""
    left, met = [x], {x}
    while left:
        node = left.pop()
        if node.op is MUL or node.op is DIV or node.op is MAX:
            left += [a for a in node.args if a not in met]
            met.update(node.args)
        elif not (node.op is ABS or node.op is SQRT or node.op is CONST):
            return False
    return True


def is_unbounded(e: Expr) -> bool:
    """Whether `e` contains symbols other than parameters outside of sines and cosines, so that its size depends on the state."""
    met, waiting = {e}, [e]
    while waiting:
        node = waiting.pop()
        if isinstance(node, Symbol):
            if not isinstance(node, Parameter):
                return True
        elif node.op is not SIN and node.op is not COS:
            waiting += [a for a in node.args if a not in met]
            met.update(node.args)
    return False


def never_zero(e: Expr) -> bool:
    """Whether the form of `e` shows that it is nonzero for all values: a number, or a sum of terms of one sign.

    Parameters may be 0. False does not mean that `e` vanishes somewhere.
    """
    while e.op is NEG or e.op is DIV:
        e = e.args[0]
    if _is_of_either_sign(e):
        return False
    memo: dict[Expr, _Sign] = {}
    return fold(e, memo, lambda node: _sign(node, [memo[a] for a in node.args]))[1]


def _is_of_either_sign(e: Expr, depth: int = 0) -> bool:
    """Whether a look at the first factors and terms shows that no sign is known, and so neither that `e` vanishes nowhere."""
    op, args = e.op, e.args
    if op in _SIGNED or depth > _DEPTH:
        return False
    if op is NEG:
        return _is_of_either_sign(args[0], depth + 1)
    if op is MUL or op is DIV or op is ADD or op is SUB:
        a, b = args
        return (op is not MUL or a is not b) and (_is_of_either_sign(a, depth + 1) or _is_of_either_sign(b, depth + 1))
    return True


_Sign: TypeAlias = tuple[int, bool]
"""1, −1 or, where it is not known, 0; and whether it is known not to vanish."""
_POSITIVE = {OPS["exp"], OPS["cosh"], OPS["pi"]}
_SIGNED = {*_POSITIVE, ABS, SQRT, CONST}
_DEPTH = 12


def _sign(node: Expr, parts: Sequence[_Sign]) -> _Sign:
    op, value = node.op, constant_value(node)
    if value is not None:
        return ((1 if value > 0 else -1), value != 0)
    if op in _POSITIVE:
        return 1, True
    if op is ABS or op is SQRT:
        return 1, parts[0][1]
    if op is NEG:
        return -parts[0][0], parts[0][1]
    if op is MUL or op is DIV:
        (a, p), (b, q) = parts
        square = op is MUL and node.args[0] is node.args[1]
        return 1 if square else a * b, p and (q or op is DIV)
    if op is ADD or op is SUB:
        (a, p), (b, q) = parts
        b = b if op is ADD else -b
        return (a, p or q) if a == b and a else (0, False)
    return 0, False


def _of_node(node: Expr, parts: Sequence[tuple[Expr, ...]], late: bool) -> tuple[Expr, ...]:
    op = node.op
    if op is CONST:
        return (constant(weight(node)),)
    if op is NEG or op is REGULAR:
        return parts[0]
    if op is SIN or op is COS:
        return (ONE, *parts[0]) if late and time in free_symbols(node) else (ONE,)
    if op is ADD or op is SUB:
        terms = _distinct([*parts[0], *parts[1]])
        return terms if len(terms) <= _MOST else _distinct(node.args)
    if op is MUL:
        return _product(*parts)
    if op is DIV:
        above = parts[0] if len(parts[0]) == 1 else (largest(parts[0]),)
        return (div(above[0], node.args[1]),)
    return (node,)


def _product(a: tuple[Expr, ...], b: tuple[Expr, ...]) -> tuple[Expr, ...]:
    """One multiplication at most: numbers scale every term, otherwise the largest are multiplied."""
    for one, other in ((a, b), (b, a)):
        if len(one) == 1 and (one[0].op is CONST or len(other) == 1):
            return _distinct(mul(one[0], x) for x in other)
    return (mul(largest(a), largest(b)),)


def _distinct(terms: Iterable[Expr]) -> tuple[Expr, ...]:
    """Each once, without signs, and of numbers the largest."""
    kept: dict[Expr, None] = {}
    number = 0.0
    for x in terms:
        value = constant_value(x)
        if value is None:
            while x.op is NEG or x.op is ABS:
                x = x.args[0]
            kept[x] = None
        else:
            number = max(number, abs(float(value)))
    return (*([constant(number)] if number else []), *kept)


Guards = Mapping[Expr, Expr]
"""The size of each divisor that may vanish."""
Part = Callable[[], Iterable[Expr]]


def guards(divisors: Iterable[tuple[Expr, Expr]], before: Iterable[Expr], after: Iterable[Expr]) -> dict[Expr, Expr]:
    """The guards of divisors, by size, and of factors of them that remain as divisors after others cancel.

    Parameters
    ----------
    divisors : each with its size
    before, after : what went into the solution, and what came out: a factor counts if it divides in the latter alone
    """
    return guards_by_parts(divisors, (lambda: before,), (lambda: after,))


def guards_by_parts(
    divisors: Iterable[tuple[Expr, Expr]], before: Sequence[Part], after: Sequence[Part]
) -> dict[Expr, Expr]:
    """The same where what went in, and what came out, comes in parts, which are made only as far as they decide."""
    own = {denominator(d): bound for d, bound in divisors}
    factors_of_own = [e for d in own for e in factors(d) if e not in own and not never_zero(e)]
    left, new = set(factors_of_own), set[Expr]()
    for part in before[:1]:
        left = left and left - _divided_by(part())
    for part in after:
        new |= left & _divided_by(part()) if left - new else new
    for part in before[1:]:
        new = new and new - _divided_by(part())
    memo: Sizes = {}
    own.update((e, size(e, memo)) for e in factors_of_own if e in new)
    return own


def extended(by: Guards, roots: Iterable[Expr]) -> Guards:
    """`by` with the divisors in `roots`, and their sizes, that have a divisor of `by` as a factor."""
    memo: Sizes = {}
    return {d: size(d, memo) for d in denominators(roots) if any(f in by for f in factors(d))} | dict(by)


def factors(divisor: Expr) -> list[Expr]:
    """The denominator that a divisor gives, and its factors."""
    found: dict[Expr, None] = {}
    waiting = [denominator(divisor)]
    while waiting:
        e = waiting.pop()
        found[e] = None
        if e.op is MUL:
            waiting += [denominator(f) for f in e.args]
    return list(found)


def denominators(roots: Iterable[Expr]) -> set[Expr]:
    """The divisors in `roots`."""
    return {node.args[1] for node in nodes(roots) if node.op is DIV}


def _divided_by(roots: Iterable[Expr]) -> set[Expr]:
    return {f for d in denominators(roots) for f in factors(d)}


def denominator(divisor: Expr) -> Expr:
    """The denominator in which x / divisor is written: without sign, and a of a divisor a/b, since x / (a/b) is x b / a."""
    while divisor.op is NEG or divisor.op is DIV:
        divisor = divisor.args[0]
    return divisor


def guarding(by: Guards) -> Callable[[Expr], Expr]:
    """A function that guards the divisors `by`, and products with them, in expressions; shared subexpressions are rewritten once."""
    known, images = set[Expr](), dict[Expr, Expr]()  # of what changes
    unchanged = images.keys().isdisjoint

    def below(node: Expr) -> Expr:
        if node in by:
            return NODE_BUILDERS["regular"](images.get(node, node), by[node])
        return mul(*map(below, node.args)) if node.op is MUL else images.get(node, node)

    def guarded(root: Expr) -> Expr:
        for node in postorder((root,), known):
            args = node.args
            if node.op is DIV:
                x, divisor = images.get(args[0], args[0]), below(args[1])
                if divisor is not args[1] or x is not args[0]:
                    images[node] = div(x, divisor)
            elif not unchanged(args):
                own = [images.get(x, x) for x in args]
                alike = _alike(node, own)
                images[node] = NODE_BUILDERS[node.op.name](*own) if alike is None else alike
        return images.get(root, root)

    return guarded if by else (lambda root: root)


def _alike(node: Expr, args: Sequence[Expr]) -> Expr | None:
    """The product, sum or negative of guarded arguments, which cancel as little as the others did; None where a sign is new."""
    for a, b in zip(args, node.args, strict=True):
        if a.op is not b.op:
            return None
    if node.op is NEG:
        return intern_single(NEG, args[0])
    if node.op is MUL or node.op is ADD:
        a, b = args
        a, b = (a, b) if precedes(a, b) else (b, a)
        return intern_pair(node.op, a, b, a.key, b.key)
    return None


def unguarded(roots: Sequence[Expr]) -> Sequence[Expr]:
    """`roots` without guards, as shown in formulas."""
    if not guards_below(roots):
        return roots
    images: dict[Expr, Expr] = {}

    def image(node: Expr) -> Expr:
        return images[node.args[0]] if node.op is REGULAR else imaged(node, images)

    return [fold(root, images, image) for root in roots]


def guards_below(roots: Iterable[Expr]) -> list[Expr]:
    """The guards in `roots`."""
    return [node for node in postorder(roots) if node.op is REGULAR]

# SPDX-License-Identifier: BSD-3-Clause
"""Divisors that may vanish: `regular(d, size)` is d, and NaN where nothing but rounding is left of it beside its size.

It stands where d is divided by, so that what is divided by a vanished d is NaN in every language; nothing is added to what is counted
as operations. In formulas it is not shown: it changes no value that there is.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

from kane.expr.build import NODE_BUILDERS, div, mul
from kane.expr.node import Expr, intern_pair, intern_single, nodes, postorder, precedes
from kane.expr.ops import ADD, DIV, MUL, NEG, REGULAR
from kane.expr.size import Sizes, never_zero, size
from kane.expr.visit import fold, imaged

Guards = Mapping[Expr, Expr]
"""The size of each divisor that may vanish."""
Part = Callable[[], Iterable[Expr]]


def guards(divisors: Iterable[tuple[Expr, Expr]], before: Iterable[Expr], after: Iterable[Expr]) -> dict[Expr, Expr]:
    """Divisors by their sizes, and such factors of them as are left alone where the others cancel.

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
    """`by` with those divisors in `roots`, by their sizes, that hold some of its own as factors."""
    memo: Sizes = {}
    return {d: size(d, memo) for d in denominators(roots) if any(f in by for f in factors(d))} | dict(by)


def factors(divisor: Expr) -> list[Expr]:
    """The denominator that a divisor makes, and what that is the product of."""
    found: dict[Expr, None] = {}
    waiting = [denominator(divisor)]
    while waiting:
        e = waiting.pop()
        found[e] = None
        if e.op is MUL:
            waiting += [denominator(f) for f in e.args]
    return list(found)


def denominators(roots: Iterable[Expr]) -> set[Expr]:
    """What `roots` divide by."""
    return {node.args[1] for node in nodes(roots) if node.op is DIV}


def _divided_by(roots: Iterable[Expr]) -> set[Expr]:
    return {f for d in denominators(roots) for f in factors(d)}


def denominator(divisor: Expr) -> Expr:
    """What x / divisor is written with as its denominator: signs are taken out, and x / (a/b) is x b / a."""
    while divisor.op is NEG or divisor.op is DIV:
        divisor = divisor.args[0]
    return divisor


def guarding(by: Guards) -> Callable[[Expr], Expr]:
    """Puts guards where expressions divide by what may vanish, or by its products; what expressions share is rewritten once."""
    images: dict[Expr, Expr] = {}

    def below(node: Expr) -> Expr:
        if node in by:
            return NODE_BUILDERS["regular"](images[node], by[node])
        return mul(*map(below, node.args)) if node.op is MUL else images[node]

    def image(node: Expr) -> Expr:
        args = node.args
        if node.op is DIV:
            divisor = below(args[1])
            return node if divisor is args[1] and images[args[0]] is args[0] else div(images[args[0]], divisor)
        for a in args:
            if images[a] is not a:
                own = [images[x] for x in args]
                alike = _alike(node, own)
                return NODE_BUILDERS[node.op.name](*own) if alike is None else alike
        return node

    return (lambda root: fold(root, images, image)) if by else (lambda root: root)


def _alike(node: Expr, args: Sequence[Expr]) -> Expr | None:
    """The product, sum or negative of guarded arguments, which cancel as little as the others did; None where a sign is new."""
    for a, b in zip(args, node.args, strict=True):
        if a.op is not b.op:
            return None
    if node.op is NEG:
        return intern_single(NEG, args[0])
    if node.op is MUL or node.op is ADD:
        a, b = args
        return intern_pair(node.op, a, b) if precedes(a, b) else intern_pair(node.op, b, a)
    return None


def unguarded(roots: Sequence[Expr]) -> Sequence[Expr]:
    """`roots` as formulas: without guards."""
    if not guards_below(roots):
        return roots
    images: dict[Expr, Expr] = {}

    def image(node: Expr) -> Expr:
        return images[node.args[0]] if node.op is REGULAR else imaged(node, images)

    return [fold(root, images, image) for root in roots]


def guards_below(roots: Iterable[Expr]) -> list[Expr]:
    """The guards that `roots` pass through."""
    return [node for node in postorder(roots) if node.op is REGULAR]

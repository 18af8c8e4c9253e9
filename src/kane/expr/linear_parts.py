# SPDX-License-Identifier: BSD-3-Clause
"""Affine forms: e = Σ c_s s + r with c_s and r free of the symbols s."""

from collections.abc import Callable, Iterable

from kane.errors import ExpressionError, NotAffineError, cut
from kane.expr.build import add, div, mul, neg, sub, where
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.ops import ADD, DIV, MUL, NEG, SUB, WHERE
from kane.expr.visit import fold, rebuilt

Affine = tuple[dict[Expr, Expr], Expr]
"""Coefficients by symbol, without zeros, and the remainder."""


def affine(root: Expr, symbols: Iterable[Expr]) -> Affine:
    """Coefficients and remainder of `root` in `symbols`.

    Raises
    ------
    NotAffineError
        if `root` is not affine in them; the message shows the subexpression at fault.
    """
    if isinstance(symbols, Expr) or not isinstance(symbols, Iterable):
        raise ExpressionError(f"Expected a list of symbols, got {cut(repr(symbols))}. Write [{cut(symbols)}].")
    return affine_forms([as_expr(root)], symbols)[0]


def affine_forms(
    roots: Iterable[Expr], symbols: Iterable[Expr], known: dict[Expr, Affine] | None = None
) -> list[Affine]:
    """`affine` of several expressions, shared subexpressions treated once; calls for the same symbols may share what is `known`."""
    wanted = list(roots)
    forms: dict[Expr, Affine] = {} if known is None else known
    if not forms:
        forms.update((s, ({s: ONE}, ZERO)) for s in symbols)
    for root in wanted:
        fold(root, forms, lambda node: _combine(node, [forms[a] for a in node.args]))
    return [forms[r] for r in wanted]


def _combine(node: Expr, parts: list[Affine]) -> Affine:
    form = combined(node, parts)
    if form is None:
        inside = ", ".join(sorted({str(s) for c, _ in parts for s in c}))
        raise NotAffineError(f"Expected an expression affine in {inside}, got {cut(node, 120)}.")
    return form


def combined(node: Expr, parts: list[Affine]) -> Affine | None:
    """The form of a node from those of its arguments; None where it is not affine."""
    # A coefficient can cancel, so that a part without coefficients is its remainder, not the node it came from.
    if not any(c for c, _ in parts):
        return {}, rebuilt(node, [r for _, r in parts])
    op = node.op
    if op is ADD or op is SUB:
        (ca, ra), (cb, rb) = parts
        join = add if op is ADD else sub
        total = dict(ca)
        for s, c in cb.items():
            total[s] = join(total.get(s, ZERO), c)
        return {s: c for s, c in total.items() if c is not ZERO}, join(ra, rb)
    if op is NEG:
        return _scale(parts[0], neg)
    if op is MUL:
        (ca, ra), (cb, rb) = parts
        if not ca:
            return _scale(parts[1], lambda x: mul(ra, x))
        if not cb:
            return _scale(parts[0], lambda x: mul(x, rb))
    if op is DIV and not parts[1][0]:
        below = parts[1][1]
        return _scale(parts[0], lambda x: div(x, below))
    if op is WHERE and not parts[0][0]:
        (_, condition), (ca, ra), (cb, rb) = parts
        both = {s: where(condition, ca.get(s, ZERO), cb.get(s, ZERO)) for s in (*ca, *cb)}
        return {s: c for s, c in both.items() if c is not ZERO}, where(condition, ra, rb)
    return None


def _scale(form: Affine, f: Callable[[Expr], Expr]) -> Affine:
    scaled = {s: f(c) for s, c in form[0].items()}
    return {s: c for s, c in scaled.items() if c is not ZERO}, f(form[1])

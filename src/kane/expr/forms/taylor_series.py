# SPDX-License-Identifier: BSD-3-Clause
"""Taylor's expansion of expressions about a point, coefficients exact.

e ≈ Σ_k 1/k! (δ·∂)ᵏ e,   δ = x − x₀
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import factorial
from typing import Any

from kane import expect
from kane.errors import ArgumentError, ExpressionError, cut
from kane.expr.build import add, mul, sub
from kane.expr.differentiation import leaves, tangent
from kane.expr.evaluation import price
from kane.expr.forms.collect import expanded, factored
from kane.expr.node import ZERO, Expr, as_expr, constant
from kane.expr.piecewise import on_either_side
from kane.expr.symbols import Parameter
from kane.expr.visit import substituted

_MOST = 12


def taylor(e: Any, about: Mapping[Any, Any], order: int = 2) -> Expr:
    """Taylor polynomial of `e` about a point, such as that of V to second order about an equilibrium.

    Parameters
    ----------
    e : an expression
    about : the point: a number or an expression of parameters for each symbol, or name, to expand in; other symbols stay
    order : degree of the polynomial, from 0 to 12

    Returns
    -------
    Expr
        a polynomial in x − x₀, where x are the symbols in `about` and x₀ their values

    Raises
    ------
    ArgumentError
        if `order` is not an integer from 0 to 12, or a value contains symbols to expand in
    ExpressionError
        if `e` contains no symbol of a given name, or a switch (|x|, max, where, …) at the point leaves it without derivatives
    """
    root = as_expr(e)
    order = expect.whole(order, f"an order from 0 to {_MOST}", least=0, most=_MOST, error=ArgumentError)
    expect.instance(about, Mapping, "the point of expansion by symbol, {symbol: value}", error=ArgumentError)
    symbols = leaves([root], about)
    expect.different(symbols, "one value for each symbol", error=ArgumentError)
    at = dict(zip(symbols, map(as_expr, about.values()), strict=True))
    if any(tangent(x, dict.fromkeys(symbols, as_expr(1))) is not ZERO for x in at.values()):
        raise ArgumentError(
            f"Expected values free of {', '.join(map(str, symbols))} to expand about, got {', '.join(map(cut, at.values()))}. Give "
            "numbers, or expressions of parameters."
        )
    steps: dict[Expr, Expr] = {
        s: Parameter.declare(f"delta_{s}", description="stands for a deviation") for s in symbols
    }
    moved = {d: sub(s, at[s]) for s, d in steps.items()}

    def series(roots: Sequence[Expr], there: Mapping[Expr, Expr]) -> list[Expr]:
        total, (term,) = ZERO, roots
        for k in range(order + 1):
            if k:
                term = tangent(term, steps)
            total = add(total, mul(constant(Fraction(1, factorial(k))), substituted(term, {**there, **moved})))
        terms = expanded(total)
        return [total if terms is None else min((total, factored(terms)), key=lambda form: price([form]))]

    (result,), corner = on_either_side([root], at, series)
    came = (
        ""
        if corner is None
        else f"a corner: {cut(str(corner.nodes[0]), 80)} switches at {cut(str(corner.quantity))} = 0"
    )
    cure = "Expand about a nearby point."
    expect.that(not came, "a point at which all derivatives exist", came=came, cure=cure, error=ExpressionError)
    return result

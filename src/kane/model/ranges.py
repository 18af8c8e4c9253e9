# SPDX-License-Identifier: BSD-3-Clause
"""Quantities that must lie in a range, such as sizes and stiffnesses, judged at the default values of their parameters.

What has no value there, such as a parameter without a default or a function of coordinates, passes.
"""

from typing import Any

from kane import expect
from kane.errors import ModelError, cut
from kane.expr.node import Expr, as_expr, constant_value
from kane.numeric.sampling import default_of

SIGN = "Check its sign, or the default."


def positive(given: Any, expected: str, cure: str = SIGN) -> Expr:
    """An expression; raises ModelError if it is not above zero at default parameters."""
    return in_range(given, f"{expected} above zero", cure, above=True)


def not_negative(given: Any, expected: str, cure: str = SIGN) -> Expr:
    """An expression; raises ModelError if it is negative at default parameters."""
    return in_range(given, f"{expected} at or above zero", cure, above=False)


def in_range(given: Any, expected: str, cure: str = SIGN, *, above: bool) -> Expr:
    """An expression that is positive, if `above`, or not negative, with all that is `expected` in words."""
    e = as_expr(given)
    value = default_of(e)
    if value is not None and not (value > 0 or (value == 0 and not above)):
        came = f"{value:g}" if constant_value(e) is not None else f"{cut(e)} = {value:g}"
        raise expect.refusal(ModelError, expected, came, cure)
    return e

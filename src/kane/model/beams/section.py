# SPDX-License-Identifier: BSD-3-Clause
"""What is so much per length, or as stiff, along a beam: a value at the root, and a share of it at each ξ = x/L."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from kane.errors import ModelError, cut
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import Expr, as_expr, constant_value
from kane.expr.symbols import Parameter
from kane.numeric.arrays import Array

_GRID = np.linspace(0, 1, 101)


class Tapered(NamedTuple):
    """`value` · `share(ξ)`."""

    value: Expr
    share: Callable[[Array], Array]


def tapered(value: Any, share: Callable[[Array], Any]) -> Tapered:
    """A mass per length, or a stiffness, that changes along a beam: `value` times a function of ξ = x/L.

    `kn.tapered(EI, lambda xi: (1 - 0.5 * xi) ** 3)` is EI at the root and EI/8 at the tip.
    """
    if not callable(share):
        raise ModelError(
            f"Expected a function of ξ = x/L as the taper, got {cut(repr(share))}. For example lambda xi: 1 - 0.5 * xi."
        )

    def shares(x: Array) -> Array:
        return np.broadcast_to(np.asarray(share(x), dtype=float), np.shape(x))

    along = shares(_GRID)
    if not (along[:-1] > 0).all() or not np.isfinite(along).all() or along[-1] < 0:
        worst = _GRID[int(np.argmin(np.where(np.isfinite(along), along, -np.inf)))]
        raise ModelError(
            f"Expected a taper above zero from the root to the tip, got {float(shares(np.array([worst]))[0]):g} at ξ = {worst:g}. The "
            "function gives the share of the value at the root."
        )
    return Tapered(as_expr(value), shares)


def section(who: str, what: str, given: Any, which: str = "") -> Tapered:
    """A property of a beam, uniform unless it is tapered; a ModelError for one that is not above zero, or varies in time."""
    whole = given if isinstance(given, Tapered) else Tapered(as_expr(given), np.ones_like)
    return whole._replace(value=measure(who, what, whole.value, which))


UNITS = {
    "length": ("L", "m"), "mass_per_length": ("rhoA", "kg/m"), "EI": ("EI", "N*m^2"), "EA": ("EA", "N"), "GJ": ("GJ", "N*m^2"),
    "polar": ("Ip", "kg*m"), "shear": ("kGA", "N"), "rotary": ("rhoI", "kg*m"),
}  # fmt: skip
"""Symbol and unit of the parameters that numbers become."""


def measure(who: str, what: str, given: Any, which: str = "") -> Expr:
    """A value above zero in parameters; a number becomes a parameter of the beam, so that its unit is known and it may be changed."""
    value = as_expr(given)
    check_positive(who, what, value)
    number = constant_value(value)
    if number is None:
        return value
    symbol, unit = UNITS[what]
    return Parameter.declare(f"{symbol}{which}_{'_'.join(who.split())}", float(number), unit, f"{what} of {who}")


def check_positive(who: str, what: str, value: Expr) -> None:
    """A ModelError for what is not above zero where the defaults of the parameters tell."""
    varying = [str(s) for s in free_symbols([value]) if not isinstance(s, Parameter)]
    if not is_constant_in_time([value]) or varying:
        raise ModelError(f"Expected {what} of {who} in parameters and numbers, got {cut(value)}. Use a kn.parameter.")
    number = value.default if isinstance(value, Parameter) else constant_value(value)
    if number is not None and not float(number) > 0:
        came = f"{number:g}" if constant_value(value) is not None else f"{cut(value)} = {number:g}"
        raise ModelError(f"Expected {what} of {who} above zero, got {came}. Check its sign, or the default.")

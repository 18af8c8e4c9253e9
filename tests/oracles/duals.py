# SPDX-License-Identifier: BSD-3-Clause
"""Values and derivatives of expressions by dual numbers, a + b ε with ε² = 0: rules of their own, on numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.expr import constant_value, postorder


def _function(f: Any, slope: Any) -> Any:
    return lambda x: (f(x[0]), slope(x[0]) * x[1])


def _product(x: Any, y: Any) -> Any:
    return x[0] * y[0], x[1] * y[0] + y[1] * x[0]


def _quotient(x: Any, y: Any) -> Any:
    return x[0] / y[0], (x[1] * y[0] - x[0] * y[1]) / y[0] ** 2


def _power(x: Any, y: Any) -> Any:
    value = x[0] ** y[0]
    own = y[0] * x[0] ** (y[0] - 1) * x[1]
    return value, own + value * np.log(x[0]) * y[1] if y[1].any() else own


def _root(x: Any) -> Any:
    value = np.sqrt(x[0])
    return value, x[1] / (2 * value) if x[1].any() else x[1]


def _angle(y: Any, x: Any) -> Any:
    return np.arctan2(y[0], x[0]), (x[0] * y[1] - y[0] * x[1]) / (x[0] ** 2 + y[0] ** 2)


RULES: dict[str, Any] = {
    "add": lambda x, y: (x[0] + y[0], x[1] + y[1]),
    "sub": lambda x, y: (x[0] - y[0], x[1] - y[1]),
    "neg": lambda x: (-x[0], -x[1]),
    "mul": _product,
    "div": _quotient,
    "pow": _power,
    "sqrt": _root,
    "sin": _function(np.sin, np.cos),
    "cos": _function(np.cos, lambda x: -np.sin(x)),
    "tan": _function(np.tan, lambda x: 1 / np.cos(x) ** 2),
    "asin": _function(np.arcsin, lambda x: 1 / np.sqrt(1 - x**2)),
    "atan": _function(np.arctan, lambda x: 1 / (1 + x**2)),
    "atan2": _angle,
    "tanh": _function(np.tanh, lambda x: 1 / np.cosh(x) ** 2),
    "exp": _function(np.exp, np.exp),
    "log": _function(np.log, lambda x: 1 / x),
    "abs": _function(np.abs, np.sign),
    "sign": lambda x: (np.sign(x[0]), 0 * x[1]),
    "less": lambda x, y: (float(x[0] < y[0]), 0 * x[1]),
    "min": lambda x, y: x if x[0] < y[0] else y,
    "max": lambda x, y: y if x[0] < y[0] else x,
    "where": lambda c, x, y: x if c[0] else y,
    "regular": lambda x, size: x if abs(x[0]) > 2.0**-43 * size[0] else (np.nan, np.nan * x[1]),
}


def values_and_slopes(roots: Sequence[Any], values: Mapping[Any, float], by: Sequence[Any]) -> tuple[Any, Any]:
    """The roots, and their derivatives by the symbols `by` (roots × by), at numbers for every symbol."""
    seeds = dict(zip(by, np.eye(len(by)), strict=True))
    none = np.zeros(len(by))
    found: dict[Any, Any] = {}
    with np.errstate(all="ignore"):
        for node in postorder(roots):
            if node in values:
                found[node] = (np.float64(values[node]), seeds.get(node, none))
            elif not node.args:
                number = np.pi if node.op.name == "pi" else constant_value(node)
                found[node] = (np.float64(number), none)
            else:
                found[node] = RULES[node.op.name](*(found[a] for a in node.args))
    return np.array([found[r][0] for r in roots]), np.array([found[r][1] for r in roots]).reshape(len(roots), len(by))

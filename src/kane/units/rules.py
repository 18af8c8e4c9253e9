# SPDX-License-Identifier: BSD-3-Clause
"""The unit of an expression from those of its symbols: one rule an operation.

None means unknown: a symbol below carries no unit, and nothing is checked there. Numbers are of dimension one, 0 fits
any unit, angles are of dimension one.
"""

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from kane.errors import UnitError, cut
from kane.expr.node import Expr, as_expr, constant_value
from kane.expr.ops import OPS, SYMBOL
from kane.expr.piecewise import Piecewise
from kane.expr.visit import fold
from kane.units.algebra import ANY, NUMBER, ONE, Unit, power, product, quotient
from kane.units.parser import parse
from kane.units.text import spelled

Known = dict[Expr, Unit | None]
Rule = Callable[..., Unit]

_HALF = Fraction(1, 2)
_SLACK = 1e-9
_FINEST = 10_000


def infer(root: Expr, units: Known) -> Unit | None:
    """The unit of `root`, None where a symbol without one is below; `units` is filled on the way. Errors are those of `unit_of`."""

    def combine(node: Expr) -> Unit | None:
        if node.op is SYMBOL:
            text: str = node.unit  # type: ignore[attr-defined]  # the operation says that it is a Symbol
            return parse(text) if text else None
        own = [units[a] for a in node.args]
        if isinstance(node.op, Piecewise):
            return _of_table(node, node.op, own[0])
        return None if None in own else RULES[node.op](node, *own)

    return fold(root, units, combine)


def _of_table(node: Expr, op: Piecewise, argument: Unit | None) -> Unit | None:
    """The unit that a table declares, over that of its argument where it is a derivative."""
    declared = parse(op.of) if op.of else None
    if argument not in (None, ANY) and declared is not None and not agree(argument, declared):
        raise UnitError(
            f"Expected an argument in {op.of} of {op.label}, got {_said(node.args[0], argument)} in {cut(node)}."
        )
    argument = argument if declared is None else declared
    if not op.unit or (op.order and argument is None):
        return None
    return quotient(parse(op.unit), power(argument, Fraction(op.order))) if op.order else parse(op.unit)


def agree(a: Unit, b: Unit) -> bool:
    """Whether quantities in these units can be added as they are."""
    return a is b or (a.exponents == b.exponents and math.isclose(a.scale, b.scale, rel_tol=_SLACK))


def _common(node: Expr, terms: tuple[Expr, ...], units: tuple[Unit, ...]) -> Unit:
    """The one unit of all the terms."""
    first, shared = terms[0], units[0]
    for term, unit in zip(terms[1:], units[1:], strict=True):
        if shared is ANY or (shared is NUMBER and agree(shared, unit)):
            first, shared = (first, shared) if unit is ANY else (term, unit)
        elif unit is not ANY and not agree(shared, unit):
            raise UnitError(
                f"Expected terms of one unit in {cut(node)}, got {_said(first, shared)} and {_said(term, unit)}. "
                f"{_cure(shared, unit)}"
            )
    return shared


def _said(e: Expr, unit: Unit) -> str:
    return f"{cut(e, 40)} [{'a number' if unit is NUMBER else spelled(unit, e)}]"


def _cure(a: Unit, b: Unit) -> str:
    if NUMBER in (a, b):
        return 'Give the number a unit: kn.parameter(name, value, "unit").'
    if a.exponents == b.exponents:
        return "Give both in one unit."
    return "Correct the expression, or the unit of a symbol in it."


def _compared(node: Expr, *units: Unit) -> Unit:
    _common(node, node.args, units)
    return ONE


def _bare(node: Expr, *units: Unit) -> Unit:
    for e, unit in zip(node.args, units, strict=True):
        if not agree(unit, ONE):
            cure = "Give angles in rad." if unit.is_bare else "Divide by a quantity of the same unit."
            raise UnitError(
                f"Expected an angle (rad) or a ratio in {node.op.name}(…), got {_said(e, unit)} in {cut(node)}. {cure}"
            )
    return ONE


def _power(node: Expr, base: Unit, exponent: Unit) -> Unit:
    value = constant_value(node.args[1])
    if value is None:
        return _bare(node, base, exponent)
    try:
        return power(base, Fraction(value).limit_denominator(_FINEST))
    except OverflowError:
        raise UnitError(f"Expected a power whose unit has a finite scale, got {cut(node)}.") from None


RULES: dict[object, Rule] = {
    OPS[name]: rule
    for names, rule in (
        ("const", lambda node: ANY if constant_value(node) == 0 else NUMBER),
        ("pi", lambda node: NUMBER),
        ("add sub min max", lambda node, *units: _common(node, node.args, units)),
        ("where", lambda node, condition, *units: _common(node, node.args[1:], units)),
        ("less atan2", _compared),
        ("mul", lambda node, a, b: product(a, b)),
        ("div", lambda node, a, b: quotient(a, b)),
        ("neg abs", lambda node, a: a),
        ("regular", lambda node, a, size: a),
        ("sign", lambda node, a: ONE),
        ("sqrt", lambda node, a: power(a, _HALF)),
        ("pow", _power),
        ("sin cos tan asin acos atan sinh cosh tanh exp log floor", _bare),
    )
    for name in names.split()
}
"""The unit of each operation from the node and the units of its arguments."""


def unit_of(expr: Any, known: Known | None = None) -> str:
    """The unit of an expression, such as "m/s^2", from the units of its symbols; "" where one of them has none.

    A symbol's own unit is as it was declared. Numbers are of dimension one, 0 fits any unit; an angle is in "rad", a ratio in
    "1". `known` gives units to symbols that have none.

    Raises
    ------
    UnitError
        if terms of different units are added or compared, or a function takes what is not of dimension one
    """
    e = as_expr(expr)
    unit = infer(e, dict(known or {}))
    return "" if unit is None or unit is ANY else spelled(unit, e)

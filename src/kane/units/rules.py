# SPDX-License-Identifier: BSD-3-Clause
"""The unit of an expression from those of its symbols: one rule an operation.

None means unknown: a symbol below carries no unit, and nothing is checked there. Numbers are of dimension one, 0 fits
any unit, angles are of dimension one.

A unit as text, in the spelling of the symbols at hand where one of them has that unit.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product as choices
from typing import Any

from kane.errors import UnitError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, as_expr, constant_value, postorder
from kane.expr.ops import OPS, SYMBOL
from kane.expr.piecewise import Piecewise
from kane.expr.visit import fold
from kane.units.algebra import ANY, NONE, NUMBER, ONE, Exponent, Unit, power, product, quotient
from kane.units.parser import parse

_NAMED = {parse(p + s): p + s for s in "NJW" for p in ("", "m", "k", "M")} | {
    parse(text): text for text in ("N/m", "N*s/m", "N*m*s")
}
_USUAL = (("kg", "g", "t"), ("m", "mm", "cm", "km"), ("s", "ms", "min", "h"), ("A",), ("K",), ("mol",), ("cd",))
_SI = tuple(names[0] for names in _USUAL)
_LINEAR = {"add", "sub", "neg", "symbol", "const", "pi"}


def spelled(unit: Unit, e: Expr | None = None) -> str:
    """A unit as text that `parse` reads; a symbol's spelling where one in `e` has this unit, for an angle in rad too."""
    leaves = () if e is None else free_symbols((e,))
    written = {parse(s.unit): s.unit for s in reversed(leaves) if s.unit}
    own = written.get(unit, "")
    if unit.is_bare and unit.scale == 1:
        linear = e is not None and all(_keeps_angles(node) for node in postorder((e,)))
        return own if own and linear else "1"
    plain = f"{unit.scale:.6g} {_joined(_SI, unit.exponents)}"
    return own or _NAMED.get(unit) or next(_composed(unit, written), plain)


def _keeps_angles(node: Expr) -> bool:
    return node.op.name in _LINEAR or (node.op.name == "mul" and node.args[0].op.name in ("const", "pi"))


def _composed(unit: Unit, written: Mapping[Unit, str]) -> Iterator[str]:
    """Products of base units that have its scale, those of the symbols at hand first, then those of SI."""
    options: list[list[str]] = []
    for i, names in enumerate(_USUAL):
        base = (*NONE[:i], 1, *NONE[i + 1 :])
        options.append([*(t for u, t in written.items() if u.exponents == base), *names] if unit.exponents[i] else [""])
    for chosen in choices(*options):
        scale = math.prod(parse(n).scale ** float(e) for n, e in zip(chosen, unit.exponents, strict=True) if e)
        if math.isclose(scale, unit.scale, rel_tol=1e-9):
            yield _joined(chosen, unit.exponents)


def _joined(names: Sequence[str], exponents: tuple[Exponent, ...]) -> str:
    pairs = list(zip(names, exponents, strict=True))
    above = "*".join(_powered(n, e) for n, e in pairs if e > 0)
    below = "".join(f"/{_powered(n, -e)}" for n, e in pairs if e < 0)
    return (above or "1") + below


def _powered(name: str, exponent: Exponent) -> str:
    if exponent == 1:
        return name
    return f"{name}^({exponent})" if isinstance(exponent, Fraction) else f"{name}^{exponent}"


def unit_text(unit: str) -> str:
    """A unit with raised exponents: m/s², N·m."""
    return re.sub(r"\^(-?\d+)", lambda m: m[1].translate(_RAISED), unit).replace("*", "·").replace(" ", " ")


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


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

# SPDX-License-Identifier: BSD-3-Clause
"""Expressions to SymPy and back. SymPy is imported on the first call; text is never parsed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

from kane.errors import ExpressionError
from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, power
from kane.expr.node import ONE, ZERO, Expr, Number, as_expr, constant, constant_value, pi, postorder
from kane.expr.ops import ADD, CONST, DIV, MUL, NEG, PI, SUB, Op
from kane.expr.symbols import Parameter, Rate, Symbol, Time


def to_sympy(expr: Expr, *, functions_of_time: bool = False) -> Any:
    """`expr` as a SymPy expression; rational constants and pi stay exact.

    Parameters
    ----------
    expr
        What to convert.
    functions_of_time
        False: every symbol becomes `sympy.Symbol(name)`, a rate the symbol "q1'". True: all but parameters and time
        become functions q1(t), and rates their derivatives, as `sympy.physics.mechanics` has them.

    Raises
    ------
    ExpressionError
        if two different symbols of `expr` have one name.
    """
    order = postorder((as_expr(expr),))
    _refuse_namesakes(order)
    inner = _flattened(order)
    functions = _to_functions()
    made: dict[Expr, Any] = {}
    for node in order:
        if node in inner:
            continue
        if isinstance(node, Symbol):
            made[node] = _symbol(node, functions_of_time)
        elif not node.args:
            made[node] = _number(constant_value(node))
        elif node.op in _FAMILY:
            made[node] = _flat(node, made, inner)
        else:
            made[node] = functions[node.op.name](*[made[a] for a in node.args])
    return made[order[-1]]


_FAMILY = {ADD: 1, SUB: 1, NEG: 1, MUL: 2, DIV: 2}


def _flattened(order: Sequence[Expr]) -> set[Expr]:
    """Sums in one sum and products in one product: written into it, for SymPy is slow at adding one by one."""
    uses = Counter(a for node in order for a in node.args)
    return {
        a
        for node in order
        for a in node.args
        if uses[a] == 1 and a.op in _FAMILY and _FAMILY[a.op] == _FAMILY.get(node.op)
    }


def _flat(root: Expr, made: Mapping[Expr, Any], inner: set[Expr]) -> Any:
    import sympy

    parts = []
    stack = [(root, False)]
    while stack:
        node, turned = stack.pop()  # turned: subtracted or divided by
        if node is root or node in inner:
            second = turned ^ (node.op in (SUB, DIV))
            stack.extend(zip(node.args, (turned ^ (node.op is NEG), second), strict=False))
        elif turned:
            parts.append(-made[node] if _FAMILY[root.op] == 1 else 1 / made[node])
        else:
            parts.append(made[node])
    return sympy.Add(*parts) if _FAMILY[root.op] == 1 else sympy.Mul(*parts)


def _refuse_namesakes(order: Sequence[Expr]) -> None:
    named: dict[str, Symbol] = {}
    for node in order:
        if isinstance(node, Symbol) and named.setdefault(node.name, node) is not node:
            kinds = type(named[node.name]).__name__, type(node).__name__
            raise ExpressionError(
                f"Expected one symbol for each name, got two different ones called {node.name!r} "
                f"({' and '.join(kinds)}): SymPy would take them for the same. Give one of them another name."
            )


@lru_cache(maxsize=1)
def _to_functions() -> dict[str, Callable[..., Any]]:
    import sympy

    same = "sqrt sin cos tan asin acos atan atan2 sinh cosh tanh exp log sign"
    return {name: getattr(sympy, name) for name in same.split()} | {
        "pow": sympy.Pow,
        "abs": sympy.Abs,
        "min": sympy.Min,
        "max": sympy.Max,
        "less": sympy.StrictLessThan,
        "where": lambda c, x, y: sympy.Piecewise((x, c), (y, True)),
    }


def _symbol(symbol: Symbol, functions_of_time: bool) -> Any:
    import sympy

    if not functions_of_time or isinstance(symbol, Parameter | Time):
        return sympy.Symbol(symbol.name)
    t = sympy.Symbol("t")
    if isinstance(symbol, Rate) and isinstance(symbol.place, Symbol):
        return _symbol(symbol.place, True).diff(t)
    return sympy.Function(symbol.name)(t)


def _number(value: Number | None) -> Any:
    import sympy

    if value is None:
        return sympy.pi
    if isinstance(value, Fraction):
        return sympy.Rational(value.numerator, value.denominator)
    return sympy.Integer(value) if isinstance(value, int) else sympy.Float(value)


def from_sympy(expression: Any, symbols: Mapping[Any, Expr]) -> Expr:
    """A SymPy expression as ours.

    Parameters
    ----------
    expression
        A SymPy expression or a number. Text is refused: SymPy's parser evaluates it as code.
    symbols
        What each SymPy symbol stands for, by the symbol or by its name; q1(t) is looked up under q1. Rates, "q1'"
        and the derivative of q1(t), follow from q1.

    Raises
    ------
    ExpressionError
        for a symbol that is not in `symbols`, and for what the graph has no operation for.
    """
    import sympy

    if isinstance(expression, str):
        raise ExpressionError(
            f"Expected a SymPy expression, got text: {expression!r:.80}. Text is not parsed here, for SymPy's parser "
            "runs it as code; build the expression from symbols."
        )
    if not isinstance(expression, sympy.Basic):
        return as_expr(expression)
    found: dict[int, Any] = {}  # by id: comparing deep SymPy trees would recurse
    stack = [expression]
    while stack:
        node = stack[-1]
        if id(node) in found:
            stack.pop()
            continue
        leaf = _leaf(node, symbols)
        if leaf is not None:
            found[id(node)] = leaf
            continue
        waiting = [a for a in node.args if id(a) not in found]
        if waiting:
            stack.extend(waiting)
        else:
            found[id(node)] = _combine(node, [found[id(a)] for a in node.args])
    result = found[id(expression)]
    if isinstance(result, Expr):
        return result
    raise ExpressionError(f"Expected a number-valued SymPy expression, got {type(expression).__name__}.")


def _leaf(node: Any, symbols: Mapping[Any, Expr]) -> Any:
    """What `node` stands for if nothing below it matters, else None."""
    import sympy
    from sympy.core.function import AppliedUndef

    if node in symbols and not node.is_number:
        return symbols[node]
    if isinstance(node, sympy.Symbol):
        return _named(node.name, symbols)
    if isinstance(node, AppliedUndef):
        return _named(node.func.__name__, symbols)
    if isinstance(node, sympy.Derivative):
        base, (variable, times) = node.expr, node.variable_count[0]
        if isinstance(base, AppliedUndef) and base.args == (variable,) and len(node.variable_count) == 1:
            result = _leaf(base, symbols)
            for _ in range(int(times)):
                result = result.dt
            return result
        raise ExpressionError(f"Expected the derivative of a function of time such as q(t), got {node!s:.80}.")
    if isinstance(node, sympy.Integer):
        return constant(int(node))
    if isinstance(node, sympy.Rational):
        return constant(Fraction(int(node.p), int(node.q)))
    if isinstance(node, sympy.Float):
        return constant(float(node))
    if node is sympy.pi:
        return pi
    if node is sympy.E:
        return NODE_BUILDERS["exp"](ONE)
    if node is sympy.true or node is sympy.false:
        return _Condition(bool(node))
    if not node.args or isinstance(node, sympy.core.containers.Tuple):
        raise ExpressionError(f"Expected a real, finite expression, got {node!s:.80} ({type(node).__name__}).")
    return None

# SPDX-License-Identifier: BSD-3-Clause
"""Conversion of expressions to SymPy and back. SymPy is imported on first use; strings are never parsed."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from fractions import Fraction
from functools import lru_cache, reduce
from typing import Any

from kane.errors import ExpressionError, cut
from kane.expr.build import NODE_BUILDERS, add, div, mul, power
from kane.expr.node import ONE, ZERO, Expr, Number, as_expr, constant, constant_value, pi, postorder
from kane.expr.numbers import Surd
from kane.expr.ops import ADD, DIV, LESS, MUL, NEG, SUB, WHERE
from kane.expr.piecewise import lowered
from kane.expr.regular import unguarded
from kane.expr.symbols import Parameter, Rate, Symbol, Time, time


def to_sympy(expr: Expr, *, functions_of_time: bool = False) -> Any:
    """Convert an expression to SymPy; rational constants and pi stay exact.

    Parameters
    ----------
    expr : the expression
    functions_of_time : with False every symbol becomes `sympy.Symbol(name)`, a rate the symbol "q1'"; with True symbols other than
        parameters and time become functions q1(t), and rates their derivatives, as in `sympy.physics.mechanics`.

    Raises
    ------
    ExpressionError
        if two different symbols of `expr` have the same name, or with `functions_of_time` a symbol other than time is named t.
    """
    import sympy

    order = postorder(lowered(unguarded((as_expr(expr),))))
    _refuse_namesakes([time, *order] if functions_of_time else order)
    inner = _flattened(order)
    functions = _to_functions()
    converted: dict[Expr, Any] = {}

    def convert(node: Expr) -> Any:
        if isinstance(node, Symbol):
            return _symbol(node, functions_of_time)
        if not node.args:
            return _number(constant_value(node))
        if node.op in _FAMILY:
            return _flat(node, converted, inner)
        if node.op is WHERE:
            condition, *values = node.args
            return functions["where"](_relation(condition, converted), *[converted[a] for a in values])
        return functions[node.op.name](*[converted[a] for a in node.args])

    with ExitStack() as rest:
        for node in order:
            if node in inner:
                continue
            try:
                converted[node] = convert(node)
            except RecursionError:  # SymPy inspects deep arguments recursively: unevaluated from here on
                rest.enter_context(sympy.evaluate(False))
                converted[node] = convert(node)
    whole = order[-1]
    return _relation(whole, converted) if whole.op is LESS else converted[whole]


def _relation(comparison: Expr, converted: Mapping[Expr, Any]) -> Any:
    """A comparison as a relational of SymPy, for use as a condition; elsewhere it is the number 1 or 0."""
    import sympy

    return sympy.StrictLessThan(*[converted[a] for a in comparison.args])


_FAMILY = {ADD: 1, SUB: 1, NEG: 1, MUL: 2, DIV: 2}


def _flattened(order: Sequence[Expr]) -> set[Expr]:
    """Sums and products to merge into the sum or product that reads them, because SymPy is slow at binary operations."""
    uses = Counter(a for node in order for a in node.args)
    return {
        a
        for node in order
        for a in node.args
        if uses[a] == 1 and a.op in _FAMILY and _FAMILY[a.op] == _FAMILY.get(node.op)
    }


def _flat(root: Expr, converted: Mapping[Expr, Any], inner: set[Expr]) -> Any:
    import sympy

    parts = []
    stack = [(root, False)]
    while stack:
        node, turned = stack.pop()  # turned: subtracted or divided by
        if node is root or node in inner:
            second = turned ^ (node.op in (SUB, DIV))
            stack.extend(zip(node.args, (turned ^ (node.op is NEG), second), strict=False))
        elif turned:
            parts.append(-converted[node] if _FAMILY[root.op] == 1 else 1 / converted[node])
        else:
            parts.append(converted[node])
    return sympy.Add(*parts) if _FAMILY[root.op] == 1 else sympy.Mul(*parts)


def _refuse_namesakes(order: Sequence[Expr]) -> None:
    named: dict[str, Symbol] = {}
    for node in order:
        if isinstance(node, Symbol) and named.setdefault(node.name, node) is not node:
            kinds = type(named[node.name]).__name__, type(node).__name__
            raise ExpressionError(
                f"Expected one symbol for each name, got two different ones called {node.name!r} "
                f"({' and '.join(kinds)}): SymPy would identify them. Give one of them another name."
            )


@lru_cache(maxsize=1)
def _to_functions() -> dict[str, Callable[..., Any]]:
    import sympy

    same = "sqrt sin cos tan asin acos atan atan2 sinh cosh tanh exp log sign floor"
    return {name: getattr(sympy, name) for name in same.split()} | {
        "pow": sympy.Pow,
        "abs": sympy.Abs,
        "min": sympy.Min,
        "max": sympy.Max,
        "less": lambda x, y: sympy.Piecewise((1, sympy.StrictLessThan(x, y)), (0, True)),
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
    if isinstance(value, Surd):
        return _number(value.ratio) * sympy.sqrt(value.radicand)
    return sympy.Integer(value) if isinstance(value, int) else sympy.Float(value)


def from_sympy(expression: Any, symbols: Mapping[Any, Expr]) -> Expr:
    """Convert a SymPy expression to an expression of kane.

    Parameters
    ----------
    expression : a SymPy expression or a number. Strings are refused, because SymPy's parser evaluates them as code.
    symbols : the expression for each SymPy symbol, by the symbol or its name; q1(t) is looked up under q1. Rates, "q1'" and the
        derivative of q1(t), follow from q1. Values at other times, q1(t − 1) or q1(0), need entries of their own.

    Raises
    ------
    ExpressionError
        for a symbol that is not in `symbols`, or a function for which kane has no operation.
    """
    import sympy

    if isinstance(expression, str):
        raise ExpressionError(
            f"Expected a SymPy expression, got text: {cut(repr(expression), 80)}. Text is not parsed here, for SymPy's parser "
            "runs it as code; build the expression from symbols."
        )
    if not isinstance(expression, sympy.Basic):
        return as_expr(expression)
    if isinstance(expression, sympy.StrictLessThan | sympy.StrictGreaterThan):
        sides = (expression.lts, expression.gts)
        return NODE_BUILDERS["less"](*[from_sympy(side, symbols) for side in sides])
    converted: dict[int, Any] = {}  # by id, because comparing deep SymPy trees recurses
    stack = [expression]
    while stack:
        node = stack[-1]
        if id(node) in converted:
            stack.pop()
            continue
        leaf = _leaf(node, symbols)
        if leaf is not None:
            converted[id(node)] = leaf
            continue
        waiting = [a for a in node.args if id(a) not in converted]
        if waiting:
            stack.extend(waiting)
        else:
            converted[id(node)] = _combine(node, [converted[id(a)] for a in node.args])
    result = converted[id(expression)]
    if isinstance(result, Expr):
        return result
    raise ExpressionError(f"Expected a SymPy expression with a real value, got {cut(expression, 80)}.")


_Choice = Callable[[Expr, Expr], Expr]
"""A condition, as the function that selects between the values for true and false."""


def _leaf(node: Any, symbols: Mapping[Any, Expr]) -> Expr | _Choice | None:
    """The value of `node` if it can be converted without its arguments, else None."""
    import sympy
    from sympy.core.function import AppliedUndef

    if isinstance(node, sympy.Symbol):
        return _declared(node, node.name, symbols)
    if isinstance(node, AppliedUndef):
        return _function(node, symbols)
    if isinstance(node, sympy.Derivative):
        return _derivative(node, symbols)
    if isinstance(node, sympy.Rational):
        return constant(Fraction(int(node.p), int(node.q)))
    if isinstance(node, sympy.Float):
        return constant(float(node))
    if not node.args:
        if node in _constants():
            return _constants()[node]
        raise ExpressionError(f"Expected a real, finite SymPy expression, got one with {cut(node, 80)} in it.")
    return None


@lru_cache(maxsize=1)
def _constants() -> dict[Any, Expr | _Choice]:
    import sympy

    e = NODE_BUILDERS["exp"](ONE)
    return {sympy.pi: pi, sympy.E: e, sympy.true: lambda x, y: x, sympy.false: lambda x, y: y}


def _declared(node: Any, name: str, symbols: Mapping[Any, Expr]) -> Expr:
    for key in (node, name):
        if key in symbols:
            return symbols[key]
    if name.endswith("'"):
        base: Expr = _declared(name[:-1], name[:-1], symbols).dt
        return base
    names = ", ".join(str(key) for key in symbols) or "none"
    raise ExpressionError(f"Expected every SymPy symbol in `symbols`, got none for {name!r}. Known here: {names}.")


def _function(node: Any, symbols: Mapping[Any, Expr]) -> Expr:
    """The value of q(t), looked up by the name q; raises for values at other times, q(t − τ) or q(0), unless they are in `symbols`."""
    import sympy

    if node in symbols:
        return symbols[node]
    at, *more = node.args
    if more or not isinstance(at, sympy.Symbol) or symbols.get(at, symbols.get(at.name, time)) is not time:
        raise ExpressionError(f"Expected functions of the time alone, such as q(t), got {cut(node, 80)}.")
    return _declared(node, node.func.__name__, symbols)


def _derivative(node: Any, symbols: Mapping[Any, Expr]) -> Expr:
    from sympy.core.function import AppliedUndef

    if node in symbols:
        return symbols[node]
    base, (variable, order), *more = node.args
    if more or not order.is_Integer or not isinstance(base, AppliedUndef) or base.args != (variable,):
        raise ExpressionError(f"Expected derivatives of functions of time such as q(t), got {cut(node, 80)}.")
    rate = _function(base, symbols)
    for _ in range(int(order)):
        rate = rate.dt
    return rate


def _combine(node: Any, args: list[Any]) -> Any:
    kind = type(node).__name__
    rule = _FROM.get(kind) or NODE_BUILDERS.get(kind)
    if rule is None:
        raise ExpressionError(f"Expected operations that kane has, got SymPy's {kind} in {cut(node, 80)}.")
    return rule(*args)


def _product(*factors: Expr) -> Expr:
    below = [f.args[1] for f in factors if f.op is DIV and f.args[0] is ONE]
    above = [f for f in factors if f.op is not DIV or f.args[0] is not ONE]
    product = reduce(mul, above, ONE)
    return div(product, reduce(mul, below)) if below else product


def _power(base: Expr, exponent: Expr) -> Expr:
    value = constant_value(exponent)
    if isinstance(value, Fraction) and value.denominator == 2:  # x^(3/2) was x sqrt(x)
        return power(NODE_BUILDERS["sqrt"](base), constant(value.numerator))
    return power(base, exponent)


def _less(a: Expr, b: Expr) -> _Choice:
    condition = NODE_BUILDERS["less"](a, b)
    return lambda x, y: NODE_BUILDERS["where"](condition, x, y)


def _not(c: _Choice) -> _Choice:
    return lambda x, y: c(y, x)


def _and(*conditions: _Choice) -> _Choice:
    return lambda x, y: reduce(lambda inner, c: c(inner, y), reversed(conditions), x)


def _or(*conditions: _Choice) -> _Choice:
    return lambda x, y: reduce(lambda inner, c: c(x, inner), reversed(conditions), y)


def _differ(a: Expr, b: Expr) -> _Choice:
    return _or(_less(a, b), _less(b, a))


def _piecewise(*cases: tuple[Expr, _Choice]) -> Expr:
    *first, (value, last) = cases
    if last(ONE, ZERO) is not ONE:
        raise ExpressionError(
            "Expected a Piecewise that is defined everywhere, got one without a last case: add (value, True)."
        )
    for case, condition in reversed(first):
        value = condition(case, value)
    return value


_FROM: dict[str, Callable[..., Any]] = {
    "Add": lambda *terms: reduce(add, terms, ZERO),
    "Mul": _product,
    "Pow": _power,
    "Abs": NODE_BUILDERS["abs"],
    "floor": NODE_BUILDERS["floor"],
    "Min": lambda *args: reduce(NODE_BUILDERS["min"], args),
    "Max": lambda *args: reduce(NODE_BUILDERS["max"], args),
    # SymPy's symbols may be complex, those of kane are real: Abs(exp(m)) is returned as exp(re(m)).
    "re": lambda x: x,
    "im": lambda x: ZERO,
    "conjugate": lambda x: x,
    "sec": lambda x: div(ONE, x.cos()),
    "csc": lambda x: div(ONE, x.sin()),
    "cot": lambda x: div(x.cos(), x.sin()),
    "coth": lambda x: div(ONE, x.tanh()),
    "Heaviside": lambda x, at_zero: _less(x, ZERO)(ZERO, _less(ZERO, x)(ONE, at_zero)),
    "ExprCondPair": lambda *case: case,
    "Piecewise": _piecewise,
    "StrictLessThan": _less,
    "StrictGreaterThan": lambda a, b: _less(b, a),
    "LessThan": lambda a, b: _not(_less(b, a)),
    "GreaterThan": lambda a, b: _not(_less(a, b)),
    "Equality": lambda a, b: _not(_differ(a, b)),
    "Unequality": _differ,
    "And": _and,
    "Or": _or,
    "Not": _not,
    "ITE": lambda c, a, b: lambda x, y: c(a(x, y), b(x, y)),  # a Piecewise in a condition
}

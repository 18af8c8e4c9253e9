# SPDX-License-Identifier: BSD-3-Clause
"""Forward and reverse differentiation on the graph (Griewank & Walther 2008), Jacobians, time derivatives, and affine forms.

The affine form of e in symbols s is e = Σ c_s s + r with c_s and r free of the symbols.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

from kane import expect
from kane.errors import ExpressionError, NotAffineError, alike, cut, warn
from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sub, sum_of, where
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, TWO, ZERO, Expr, as_expr, as_exprs, postorder
from kane.expr.ops import ADD, COS, DIV, MAX, MIN, MUL, NEG, SIN, SQRT, SUB, SYMBOL, WHERE
from kane.expr.regular import never_zero
from kane.expr.symbols import (
    Coordinate,
    Input,
    Parameter,
    QuasiRate,
    Rate,
    Reaction,
    Speed,
    StateVariable,
    Symbol,
    Time,
    rate,
)
from kane.expr.visit import fold, rebuilt

_CHOICES = frozenset((WHERE, MIN, MAX))
less, _abs = NODE_BUILDERS["less"], NODE_BUILDERS["abs"]
Tangents = Mapping[Expr, Expr] | Callable[[Expr], Expr]


def partials(node: Expr) -> tuple[Expr, ...]:
    """∂node/∂(each argument)."""
    rule = node.op.derivative
    if rule is None:
        raise ExpressionError(f"The operation {node.op.name!r} has no derivative.")
    return tuple(as_expr(p) for p in rule(node, *node.args))


def tangent(root: Expr, seeds: Tangents, memo: dict[Expr, Expr] | None = None, *, at_rest: bool = False) -> Expr:
    """Forward differentiation: the directional derivative of `root` with the derivatives of leaves in `seeds`.

    A `memo` shared between calls with the same seeds keeps the derivatives of common subexpressions. With `at_rest` the derivative of
    √s is zero where that of s is, not 0/0: that of |v| v is finite at v = 0, and that of |v| the mean over all sides.
    """
    derivatives: dict[Expr, Expr] = {} if memo is None else memo
    seed = seeds if callable(seeds) else (lambda leaf: seeds.get(leaf, ZERO))

    def through(node: Expr) -> Expr:
        if node.op is SYMBOL:
            return seed(node)
        change = _through(node, derivatives)
        if at_rest and node.op is SQRT and change.args:
            return where(less(ZERO, _abs(derivatives[node.args[0]])), change, ZERO)
        return change

    return fold(root, derivatives, through)


def _through(node: Expr, derivatives: Mapping[Expr, Expr]) -> Expr:
    op, args = node.op, node.args
    if op is ADD:
        return add(derivatives[args[0]], derivatives[args[1]])
    if op is SUB:
        return sub(derivatives[args[0]], derivatives[args[1]])
    if op is NEG:
        return neg(derivatives[args[0]])
    if op is MUL:
        x, y = args
        if x is y:
            return mul(TWO, mul(x, derivatives[x]))
        return add(mul(derivatives[x], y), mul(x, derivatives[y]))
    if all(derivatives[a] is ZERO for a in args):
        return ZERO
    if op is DIV and args[0].op is SIN and args[1].op is COS and args[0].args[0] is args[1].args[0]:
        return div(derivatives[args[0].args[0]], mul(args[1], args[1]))  # tan x, written as sin x / cos x
    if op in _CHOICES:
        return _chosen(node, [derivatives[a] for a in args])
    total = ZERO
    for a, p in zip(args, partials(node), strict=True):
        total = add(total, mul(p, derivatives[a]))
    return total


def _chosen(node: Expr, changes: Sequence[Expr]) -> Expr:
    """The derivative of a choice: that of the chosen branch alone, as that of the other may be infinite.

    If both arguments of `max` or `min` are equal, that of the first, a number if there is one, as with `where(0 < x, x, 0)`.
    """
    if node.op is WHERE:
        return where(node.args[0], changes[1], changes[2])
    x, y = node.args
    second = less(x, y) if node.op is MAX else less(y, x)
    return where(second, changes[1], changes[0])


def diff(root: Expr, symbol: Symbol | str) -> Expr:
    """∂root/∂symbol; the symbol may be given by name. By the time it is partial, too: see `doubt_partial`."""
    (by,) = leaves([root], [symbol])
    doubt_partial(root, lambda: [as_expr(root)], by)
    return tangent(as_expr(root), {by: ONE})


def doubt_partial(what: object, parts: Callable[[], Iterable[Expr]], by: Expr) -> None:
    """Warn of a partial derivative by the time of what does not hold it, but coordinates and the like: it is zero."""
    if not isinstance(by, Time):
        return
    held = [s for s in postorder(parts()) if isinstance(s, Symbol) and not isinstance(s, Parameter | Reaction)]
    if held and by not in set(held):
        warn(
            f"Expected an expression that contains {by} for the partial derivative with respect to it, got {cut(what)}: that is "
            f"zero, although {cut(', '.join(map(str, held)))} may vary. Use kn.time_derivative(e) for the derivative along a motion, "
            "q.dt for that of a symbol, v.dt(frame) for that of a vector."
        )


def leaves(roots: Iterable[Expr], symbols: Expr | str | Iterable[Expr | str]) -> tuple[Expr, ...]:
    """The symbols, those given by name looked up in the expressions.

    Raises
    ------
    ExpressionError
        if something else stands among them, or a name is that of none, or of several, of the symbols in the expressions
    """
    wanted = (symbols,) if isinstance(symbols, Expr) or not expect.is_list(symbols) else tuple(symbols)
    known = tuple(s for s in wanted if isinstance(s, Symbol))
    if len(known) == len(wanted):
        return known
    own = [n for n in postorder(map(as_expr, roots)) if isinstance(n, Symbol)]
    found = [[n for n in own if n.name == s] if isinstance(s, str) else [s] for s in wanted]
    for s, at in zip(wanted, found, strict=True):
        if len(at) != 1 or not isinstance(at[0], Symbol):
            names = dict.fromkeys(n.name for n in own)
            raise ExpressionError(
                f"Expected a symbol, or the name of one in the expression ({', '.join(names) or 'none'}), got {cut(repr(s))}."
                f"{alike(str(s), names)}"
            )
    return tuple(at[0] for at in found)


def gradient(root: Expr, symbols: Iterable[Expr | str]) -> tuple[Expr, ...]:
    """∂root/∂symbol for all `symbols`, by reverse-mode differentiation."""
    wanted = leaves([root], symbols)
    own = as_expr(root)
    if any(node.op in _CHOICES for node in postorder((own,))):  # backwards, 0 times infinity would be met
        return tuple(tangent(own, {s: ONE}) for s in wanted)
    return pullback([own], [ONE], wanted)


def pullback(roots: Sequence[Expr], weights: Sequence[Expr], symbols: Sequence[Expr]) -> tuple[Expr, ...]:
    """Reverse derivative: Σ_i weights[i] ∂roots[i]/∂symbol for every symbol, in one sweep from the roots to the leaves.

    The weights are constant. An infinite partial derivative may be multiplied by zero here; `weighted` avoids that.
    """
    order = postorder(roots)
    depends = set(symbols)
    for node in order:
        if any(a in depends for a in node.args):
            depends.add(node)
    adjoint: dict[Expr, Expr] = {}
    for root, weight in zip(roots, weights, strict=True):
        if root in depends:
            adjoint[root] = add(adjoint.get(root, ZERO), weight)
    for node in reversed(order):
        bar = adjoint.get(node)
        if bar is None or bar is ZERO or not node.args:
            continue
        for a, p in zip(node.args, partials(node), strict=True):
            if a in depends:
                adjoint[a] = add(adjoint.get(a, ZERO), mul(bar, p))
    return tuple(adjoint.get(s, ZERO) for s in symbols)


def weighted(roots: Sequence[Expr], weights: Sequence[Expr], symbols: Sequence[Expr]) -> tuple[Expr, ...]:
    """Σ_i weights[i] ∂roots[i]/∂symbol for every symbol: by one reverse sweep, or forwards, one symbol at a time, if that may fail.

    In reverse, the branch not chosen, or a square root that vanishes where its argument has no slope, would give 0 times infinity.
    """
    if not any(node.op in _CHOICES or (node.op is SQRT and _moves(node)) for node in postorder(roots)):
        return pullback(roots, weights, symbols)
    columns = []
    for s in symbols:
        memo: dict[Expr, Expr] = {}
        pairs = zip(roots, weights, strict=True)
        columns.append(sum_of(mul(w, tangent(root, {s: ONE}, memo, at_rest=True)) for root, w in pairs))
    return tuple(columns)


def _moves(node: Expr) -> bool:
    """Whether a node is a square root that may vanish during a motion."""
    return not never_zero(node.args[0]) and not all(
        isinstance(s, Parameter) for s in postorder(node.args) if isinstance(s, Symbol)
    )


def jacobian(roots: Sequence[Expr], symbols: Sequence[Expr | str]) -> Matrix:
    """The matrix J[i, j] = ∂roots[i]/∂symbols[j], by forward or reverse mode, whichever has fewer sweeps."""
    roots = as_exprs("the functions of a Jacobian matrix", roots)
    symbols = leaves(roots, symbols)
    if len(roots) < len(symbols):
        return Matrix([gradient(r, symbols) for r in roots], (len(roots), len(symbols)))
    columns = []
    for s in symbols:
        memo: dict[Expr, Expr] = {}
        columns.append([tangent(r, {s: ONE}, memo) for r in roots])
    return Matrix(list(zip(*columns, strict=True)), (len(roots), len(symbols)))


def _leaf_rate(leaf: Expr) -> Expr:
    if isinstance(leaf, Coordinate | Speed | StateVariable | Input | Rate | QuasiRate):
        return rate(leaf)
    if isinstance(leaf, Time):
        return ONE
    if isinstance(leaf, Reaction):
        raise ExpressionError(
            f"The time derivative of the reaction {leaf} has no name: it is known only along a motion."
        )
    return ZERO


def time_derivative(root: Expr) -> Expr:
    """Total time derivative of an expression; the rates q', u', … of coordinates, speeds, states and inputs are symbols in it."""
    return tangent(as_expr(root), _leaf_rate)


def euler_parameter_rates(e: Sequence[Expr], w: Sequence[QuasiRate | Expr]) -> tuple[Expr, Expr, Expr, Expr]:
    """ė0…ė3 from the measure numbers w of the angular velocity along the frame's own axes.

    ė0 = −½ e·w,  ė = ½ (e0 w + e × w)  (Kane, Likins, Levinson 1983, Spacecraft Dynamics, sec. 1.13).
    """
    e0, e1, e2, e3 = e
    w1, w2, w3 = w
    half = as_expr(0.5)
    return (
        -half * (e1 * w1 + e2 * w2 + e3 * w3),
        half * (e0 * w1 - e3 * w2 + e2 * w3),
        half * (e3 * w1 + e0 * w2 - e1 * w3),
        half * (-e2 * w1 + e1 * w2 + e0 * w3),
    )


Affine = tuple[dict[Expr, Expr], Expr]
"""Coefficients by symbol, without zeros, and the remainder."""


def affine(root: Expr, symbols: Iterable[Expr]) -> Affine:
    """The coefficients c (by symbol) and the remainder r of an affine expression: `root` = Σ c[s] s + r.

    Raises
    ------
    NotAffineError
        if `root` is not affine in `symbols`; the message shows the nonlinear subexpression
    """
    cure = f"Write [{cut(symbols)}]." if isinstance(symbols, Expr) else ""
    wanted = expect.instances(symbols, Expr, "a list of symbols", cure, error=ExpressionError)
    return affine_forms([as_expr(root)], wanted)[0]


def affine_forms(
    roots: Iterable[Expr], symbols: Iterable[Expr], known: dict[Expr, Affine] | None = None
) -> list[Affine]:
    """`affine` of several expressions; `known` keeps the forms of subexpressions between calls with the same symbols."""
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
    """The affine form of a node from those of its arguments; None if it is not affine."""
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

# SPDX-License-Identifier: BSD-3-Clause
"""Iterative traversal of the graph in topological order, each node once (`fold`), substitution, and memoization per derivation.

`kn.substitute` replaces symbols, nodes or names in expressions, vectors, matrices and lists of them.

Results of pure functions marked `remembered` are cached during one derivation (`remembering`), in which formulations need the same
changes of basis and products many times. Nothing is cached outside, so that nodes do not live longer.
"""

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from functools import partial, wraps
from typing import Any, ParamSpec, TypeVar, cast

from kane.errors import ExpressionError, ValueMissingError, alike, cut
from kane.expr.build import NODE_BUILDERS
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, as_expr, postorder
from kane.expr.symbols import Symbol

R = TypeVar("R")


def fold(root: Expr, values: dict[Expr, R], combine: Callable[[Expr], R]) -> R:
    """`values[root]`, after `values[node] = combine(node)` for every node below it without a value, in topological order.

    When `combine` is called, `values` has the results of the node's arguments. Nodes with a value at the start are not visited.
    """
    if root in values:
        return values[root]
    stack: list[Expr | None] = [root]
    while stack:
        node = stack.pop()
        if node is None:  # what is below the node before it is known
            node = stack.pop()
            if node is not None and node not in values:
                values[node] = combine(node)
        elif node not in values:
            ready = True
            for a in node.args:
                if a not in values:
                    if ready:
                        stack += (node, None)
                        ready = False
                    stack.append(a)
            if ready:
                values[node] = combine(node)
    return values[root]


def substituted(root: Expr, replacements: Mapping[Expr, Expr], memo: dict[Expr, Expr] | None = None) -> Expr:
    """`root` with every key of `replacements` replaced; unchanged subexpressions stay the same objects."""
    images: dict[Expr, Expr] = {} if memo is None else memo
    images.update(replacements)
    return fold(root, images, lambda node: imaged(node, images))


def substituting(replacements: Mapping[Expr, Expr]) -> Callable[[Expr], Expr]:
    """`substituted` with these replacements, as a function with a memo."""
    return partial(substituted, replacements=replacements, memo={})


def replaced_in(
    roots: Sequence[Expr],
    replacements: Mapping[Expr, Expr],
    kept: Set[Expr] = frozenset(),
    order: Iterable[Expr] | None = None,
) -> tuple[Expr, ...]:
    """`substituted` of several `roots`, whose nodes are listed in topological `order`; nodes in `kept` are not changed."""
    given = {*kept, *replacements}
    images = {e: image for e, image in replacements.items() if image is not e and e not in kept}
    unchanged = images.keys().isdisjoint
    for node in () if not images else postorder(roots) if order is None else order:
        if not unchanged(node.args) and node not in given:
            image = NODE_BUILDERS[node.op.name](*[images.get(x, x) for x in node.args])
            if image is not node:
                images[node] = image
    return tuple([images.get(r, r) for r in roots])


def imaged(node: Expr, images: Mapping[Expr, Expr]) -> Expr:
    """The operation of `node` on the images of its arguments, `node` itself if they are its own arguments."""
    for a in node.args:
        if images[a] is not a:
            return NODE_BUILDERS[node.op.name](*[images[x] for x in node.args])
    return node


def rebuilt(node: Expr, args: Sequence[Expr]) -> Expr:
    """The operation of `node` on `args`, `node` itself if they are its own arguments."""
    for x, y in zip(args, node.args, strict=True):
        if x is not y:
            return NODE_BUILDERS[node.op.name](*args)
    return node


def substitute(what: Any, replacements: Mapping[Any, Any]) -> Any:
    """`what` with every key of `replacements` replaced by its value, all at once; returns `what` itself if nothing is replaced.

    Parameters
    ----------
    what : an expression, a Vector, a Matrix, or a list of these
    replacements : an expression or number for each symbol, name of a symbol, or other expression

    Raises
    ------
    ValueMissingError
        if a name is none of the symbols in it
    """
    if not isinstance(replacements, Mapping):
        raise ValueMissingError(
            f"Expected replacements as a dict {{symbol or name: expression}}, got {cut(repr(replacements))}."
        )
    roots: list[Expr] = []

    def noted(e: Expr) -> Expr:
        roots.append(e)
        return e

    _each(what, noted)
    names: dict[str, list[Symbol]] = {}
    for s in free_symbols(roots) if any(isinstance(key, str) for key in replacements) else ():
        names.setdefault(s.name, []).append(s)
    images: dict[Expr, Expr] = {}
    for key, value in replacements.items():
        if isinstance(key, str) and key not in names:
            raise ValueMissingError(
                f"Expected names of symbols to replace ({', '.join(names) or 'none'}), got {key!r}.{alike(key, names)}"
            )
        for own in names[key] if isinstance(key, str) else [as_expr(key)]:
            images[own] = as_expr(value)
    memo: dict[Expr, Expr] = {}
    return _each(what, lambda e: substituted(e, images, memo))


def _each(what: Any, change: Any) -> Any:
    """`what` with `change` applied to each of its expressions."""
    if isinstance(what, list | tuple):
        return type(what)([_each(x, change) for x in what])
    if hasattr(what, "map"):  # a vector, a matrix
        return what.map(change)
    try:
        return change(as_expr(what))
    except ExpressionError as error:
        raise ExpressionError(
            f"Expected an expression, Vector, Matrix or a list of these to substitute in, got {cut(repr(what))}."
        ) from error


P = ParamSpec("P")
Result = TypeVar("Result")


class _DerivationMemo(threading.local):
    """The cache of this thread's derivation, by function and arguments; None outside a derivation."""

    found: dict[tuple[Any, ...], Any] | None = None


_scope = _DerivationMemo()


@contextmanager
def remembering() -> Iterator[None]:
    """A context in which `remembered` functions of this thread compute each result once; nested contexts share one cache."""
    outer = _scope.found
    if outer is None:
        _scope.found = {}
    try:
        yield
    finally:
        _scope.found = outer


def remembered(function: Callable[P, Result]) -> Callable[P, Result]:
    """Caches a pure function during a derivation; its arguments are positional, hashable and immutable, its result not None."""

    def known(*args: Any) -> Any:
        table = _scope.found
        if table is None:
            return call(*args)
        key = (call, *args)
        result = table.get(key)
        if result is None:
            result = table[key] = call(*args)
        return result

    call: Callable[..., Any] = function
    return cast(Callable[P, Result], wraps(function)(known))

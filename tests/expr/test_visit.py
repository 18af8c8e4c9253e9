# SPDX-License-Identifier: BSD-3-Clause
"""Visits of the graph: each node once, its arguments before, however deep, and what is known is not visited again."""

from __future__ import annotations

from hypothesis import given

import kane as kn
from kane import Expr, Parameter, free_symbols
from kane.expr import NODE_BUILDERS, fold, imaged, is_constant_in_time, postorder, rebuilt, substituted
from tests.expr.expressions import DEEP, Program, programs


def by_recursion(root: Expr, seen: dict[Expr, None]) -> None:
    for a in root.args:
        by_recursion(a, seen)
    seen.setdefault(root)


@given(programs())
def test_postorder_is_that_of_a_recursion_from_the_first_argument_on(program: Program) -> None:
    seen: dict[Expr, None] = {}
    roots = program.nodes()
    for root in roots:
        by_recursion(root, seen)
    assert all(a is b for a, b in zip(postorder(roots), seen, strict=True))


@given(programs())
def test_a_second_postorder_lists_what_the_first_has_not(program: Program) -> None:
    roots = program.nodes()
    known: set[Expr] = set()
    listed = [node for root in roots for node in postorder((root,), known)]
    assert all(a is b for a, b in zip(listed, postorder(roots), strict=True))
    assert known == {*listed}


@given(programs())
def test_a_fold_combines_each_node_once_after_its_arguments(program: Program) -> None:
    values: dict[Expr, int] = {}
    met: list[Expr] = []

    def depth(node: Expr) -> int:
        met.append(node)
        return 1 + max((values[a] for a in node.args), default=0)

    for root in program.nodes():
        fold(root, values, depth)
        fold(root, values, depth)
    assert len(met) == len(set(met)) == len(values)


@given(programs())
def test_what_does_not_change_stays_the_same_object(program: Program) -> None:
    for root in program.nodes():
        assert substituted(root, {}) is root
        assert rebuilt(root, root.args) is root
        assert imaged(root, {a: a for a in root.args}) is root
        symbols = free_symbols([root])
        assert is_constant_in_time([root]) == all(isinstance(s, Parameter) for s in symbols)


def test_a_fold_within_a_fold_shares_what_is_known() -> None:
    q = kn.coordinate("q")
    inner, values = kn.sin(q) + 2, dict[Expr, int]()

    def count(node: Expr) -> int:
        if node is q:
            inside: int = fold(kn.time, values, count)
            return inside
        return 1 + sum(values[a] for a in node.args)

    assert fold(inner, values, count) == 4
    assert kn.time in values


def test_a_deep_graph_is_folded_without_recursion() -> None:
    q = kn.coordinate("q")
    deep: Expr = q
    for _ in range(DEEP):
        deep = NODE_BUILDERS["exp"](deep)
    values: dict[Expr, int] = {}
    assert fold(deep, values, lambda node: 1 + sum(values[a] for a in node.args)) == DEEP + 1

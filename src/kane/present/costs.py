# SPDX-License-Identifier: BSD-3-Clause
"""The operation receipt: by operation and tier, and what each group of results adds to those before it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from kane.equations.equations import Equations
from kane.expr.count import count_operations
from kane.expr.node import Expr, postorder
from kane.expr.symbols import Parameter, Symbol

# + − × ÷ √ first, then the functions by name
_SIGNS = {"add": "+", "sub": "−", "mul": "×", "div": "÷", "sqrt": "√", "pow": "power"}


@dataclass(frozen=True, slots=True)
class Costs:
    """`lines`: (operation, of parameters alone, with the state, both). `groups`: (results, on their own, added to those above)."""

    lines: tuple[tuple[str, int, int, int], ...]
    total: tuple[int, int, int]
    groups: tuple[tuple[str, int, int], ...]


def costs(eom: Equations) -> Costs:
    """What one evaluation of the right-hand side and the reactions costs."""
    roots = (*eom.right_hand_side, *eom.solved.reactions)
    hoisted = dict(count_operations(_of_parameters(roots)).by_operation)
    counts = dict(eom.operations.by_operation)
    lines = tuple(
        (_SIGNS.get(kind, kind), hoisted.get(kind, 0), counts[kind] - hoisted.get(kind, 0), counts[kind])
        for kind in dict.fromkeys((*_SIGNS, *counts))
        if kind in counts
    )
    whole = eom.operations
    return Costs(lines, (whole.parameter, whole.state, whole.total), tuple(_groups(eom, roots)))


def _of_parameters(roots: Iterable[Expr]) -> list[Expr]:
    """The nodes that depend on nothing but parameters."""
    alone: dict[Expr, bool] = {}
    for node in postorder(list(roots)):
        alone[node] = isinstance(node, Parameter) if isinstance(node, Symbol) else all(alone[a] for a in node.args)
    return [node for node, yes in alone.items() if yes]


def _groups(eom: Equations, roots: Iterable[Expr]) -> Iterator[tuple[str, int, int]]:
    """Only nodes that the whole evaluation has count as added, so that the additions sum to its total."""
    whole = set(postorder(list(roots)))
    solved = ((r"$\dot{u}$, solved", eom.solved.accelerations), ("reactions, solved", eom.solved.reactions))
    if eom.operations.total == count_operations(eom.right_hand_side).total:  # u̇ is found by way of the reactions
        solved = solved[::-1]
    parts: tuple[tuple[str, tuple[Expr, ...]], ...] = (
        (r"$\dot{q} = W u + X$", eom.rates),
        ("$M$, the mass matrix", eom.mass_matrix.entries),
        ("$f$, the right side", eom.forcing),
        *solved,
    )
    reached: dict[Expr, None] = {}
    before = 0
    for title, exprs in parts:
        if not exprs:
            continue
        reached.update((node, None) for node in postorder(list(exprs)) if node in whole)
        after = count_operations(list(reached)).total
        yield title, count_operations(list(exprs)).total, after - before
        before = after

# SPDX-License-Identifier: BSD-3-Clause
"""Irreducible blocks of a square matrix: what of its rows and columns must be solved together (block triangular form)."""

from collections.abc import Sequence

import numpy as np

from kane.errors import SingularError
from kane.expr.node import ZERO, Expr

Rows = Sequence[Sequence[Expr]]


def structural_rank(rows: Rows, width: int) -> int:
    """Largest number of nonzero entries no two of which share a row or column."""
    return sum(c >= 0 for c in matched_columns(rows)) if rows and width else 0


def matched_columns(rows: Rows) -> list[int]:
    """A column for each row, no two the same, -1 where there is none left: maximum matching by augmenting paths.

    The blocks here have a few rows; a library's matching would cost more to import than to run.
    """
    supports = [[c for c, x in enumerate(row) if x is not ZERO] for row in rows]
    owner = _forced(supports)
    for i in sorted(set(range(len(rows))) - set(owner.values())):
        _augment(supports, owner, i)
    match = [-1] * len(rows)
    for c, i in owner.items():
        match[i] = c
    return match


def _forced(supports: Sequence[Sequence[int]]) -> dict[int, int]:
    """Rows by the only column that others leave them: all of a triangular matrix, for which augmenting paths would be long."""
    users: dict[int, list[int]] = {}
    for i, support in enumerate(supports):
        for c in support:
            users.setdefault(c, []).append(i)
    left = [len(support) for support in supports]
    owner: dict[int, int] = {}
    single = [i for i, count in enumerate(left) if count == 1]
    for i in single:
        for c in [c for c in supports[i] if c not in owner]:  # none where another row has taken it
            owner[c] = i
            for j in users[c]:
                left[j] -= 1
                if left[j] == 1:
                    single.append(j)
    return owner


def _augment(supports: Sequence[Sequence[int]], owner: dict[int, int], start: int) -> None:
    """A column for the row `start`, others moved on for it: depth first, without recursion; nothing where there is no path."""
    tried: set[int] = set()
    path = [(start, iter(supports[start]))]
    taken: list[int] = []
    while path:
        row, columns = path[-1]
        c = next((c for c in columns if c not in tried), None)
        if c is None:
            path.pop()
            if taken:
                taken.pop()
            continue
        tried.add(c)
        taken.append(c)
        if c not in owner:
            for (row, _), column in zip(path, taken, strict=True):
                owner[column] = row
            return
        path.append((owner[c], iter(supports[owner[c]])))


def blocks(rows: Rows, match: list[int]) -> list[list[int]]:
    """Rows that must be solved together: those that reach each other, each row pointing at the owners of its columns."""
    owner = {c: i for i, c in enumerate(match)}
    n = len(rows)
    reach = np.eye(n, dtype=bool)
    for i, row in enumerate(rows):
        for c, x in enumerate(row):
            if x is not ZERO:
                reach[i, owner[c]] = True
    for _ in range(n.bit_length()):
        reach = (reach.astype(np.float32) @ reach.astype(np.float32)) > 0
    together = reach & reach.T
    found: dict[int, list[int]] = {}
    for i in range(n):
        found.setdefault(int(np.argmax(together[i])), []).append(i)
    return list(found.values())


def in_order(rows: Rows) -> list[tuple[list[int], list[int]]]:
    """Rows and columns of the irreducible blocks, each after those whose unknowns its rows hold too.

    Raises
    ------
    SingularError
        if no choice of entries gives every row a column of its own
    """
    match = matched_columns(rows)
    if -1 in match:
        rank = sum(c >= 0 for c in match)
        raise SingularError(f"Expected an invertible matrix, got structural rank {rank} of {len(rows)}.")
    waiting = [(block, [match[i] for i in block]) for block in blocks(rows, match)]
    order: list[tuple[list[int], list[int]]] = []
    done: set[int] = set()
    while waiting:
        for block, own in waiting:
            if all(c in done or c in own for i in block for c, x in enumerate(rows[i]) if x is not ZERO):
                break
        waiting.remove((block, own))
        order.append((block, own))
        done.update(own)
    return order

# SPDX-License-Identifier: BSD-3-Clause
"""M, f and G of M u̇ = f + G R, from partial velocities and biases.

    M_rs = Σ m v_r·v_s + ω_r·I·ω_s
    f_r  = Σ v_r·(F − m a_b) + Σ ω_r·(T − I·α_b − ω × I·ω)

Bodies that share a partial velocity share its scalar product: Σ_k V·X_k = V·Σ_k X_k. Sums run from the last body to the
first, so that along a chain every partial sum is one node used many times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from kane.dynamics.bodies import Moving
from kane.expr.affine import affine_forms
from kane.expr.build import add
from kane.expr.evaluate import free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Reaction
from kane.space.vector import Parts, Vector

Rows = list[list[Expr]]
Masses = dict[Vector, Expr]


class Blocks(NamedTuple):
    """M (n × n), f (n) and G (n × reactions) of the generalized speeds; M_a, f_a and G_a of the auxiliary ones."""

    mass: Matrix
    forcing: tuple[Expr, ...]
    coupling: Matrix
    mass_a: Matrix
    forcing_a: tuple[Expr, ...]
    coupling_a: Matrix


def blocks(
    mass: Rows,
    right: Sequence[Expr],
    auxiliary: Sequence[Expr],
    reactions: Sequence[Reaction],
    pairs: Mapping[tuple[Expr, Expr], Expr],
) -> Blocks:
    """The rows of M and of f + G R, those of the auxiliary speeds last and with the reactions that these bring into evidence."""
    n, r = len(mass) - len(auxiliary), len(reactions)
    forcing, coupling = _reaction_form(right, reactions)
    evident = [
        [add(c, pairs.get((s, x), ZERO)) for c, x in zip(row, reactions, strict=True)]
        for s, row in zip(auxiliary, coupling[n:], strict=True)
    ]
    return Blocks(
        Matrix(mass[:n], (n, n)),
        tuple(forcing[:n]),
        Matrix(coupling[:n], (n, r)),
        Matrix(mass[n:], (len(auxiliary), n)),
        tuple(forcing[n:]),
        Matrix(evident, (len(auxiliary), r)),
    )


def _reaction_form(right: Sequence[Expr], reactions: Sequence[Reaction]) -> tuple[list[Expr], Rows]:
    """f and G of f + G R."""
    if not reactions or not any(isinstance(s, Reaction) for s in free_symbols(right)):
        return list(right), [[ZERO] * len(reactions) for _ in right]
    forms = affine_forms(right, reactions)
    return [rest for _, rest in forms], [[c.get(r, ZERO) for r in reactions] for c, _ in forms]


def mass_rows(bodies: Sequence[Moving], speeds: Sequence[Expr], auxiliary: Sequence[Expr]) -> Rows:
    """M_rs for r in `speeds`, then `auxiliary`, and s in `speeds`; the square block is symmetric."""
    symbols = [*speeds, *auxiliary]
    n = len(speeds)
    shift = _shift_groups(bodies, symbols, n)
    turn = _turn_groups(bodies, symbols, n)
    rows: list[list[Expr]] = []
    carried: dict[tuple[Any, ...], Vector] = {}
    for i in range(len(symbols)):
        line = []
        for j in range(n):
            if j < i < n:
                line.append(rows[j][i])
                continue
            moved, turned = ZERO, ZERO
            for v, group in shift.get((i, j), {}).items():
                moved = add(moved, v.dot(_carried(group, carried)))
            for w, h in turn.get((i, j), {}).items():
                turned = add(turned, w.dot(h))
            line.append(add(moved, turned))
        rows.append(line)
    return rows


def _carried(group: Masses, known: dict[tuple[Any, ...], Vector]) -> Vector:
    """Σ m v_s of one group; the same group met again is the same vector."""
    name = tuple(group.items())
    found = known.get(name)
    if found is None:
        found = Vector()
        for v, mass in group.items():
            found = found + v * mass
        known[name] = found = found.gathered()
    return found


def _unique(vectors: dict[Parts, Vector], v: Vector) -> Vector:
    """One object for equal vectors, so that they can be compared by identity."""
    return vectors.setdefault(v.parts, v)


def _shift_groups(
    bodies: Sequence[Moving], symbols: Sequence[Expr], n: int
) -> dict[tuple[int, int], dict[Vector, Masses]]:
    """For each pair of speeds, v_r → (v_s → Σ m) over the bodies that both move."""
    vectors: dict[Parts, Vector] = {}
    groups: dict[tuple[int, int], dict[Vector, Masses]] = {}
    for b in reversed(bodies):
        mass, partials = b.body.mass, b.center.partials
        moved = [(i, _unique(vectors, partials[s])) for i, s in enumerate(symbols) if s in partials]
        for i, v in moved:
            for j, w in moved:
                if j < n and (i <= j or i >= n):
                    group = groups.setdefault((i, j), {}).setdefault(v, {})
                    group[w] = add(group[w], mass) if w in group else mass
    return groups


def _turn_groups(
    bodies: Sequence[Moving], symbols: Sequence[Expr], n: int
) -> dict[tuple[int, int], dict[Vector, Vector]]:
    """For each pair of speeds, ω_r → Σ I·ω_s over the bodies that both turn."""
    vectors: dict[Parts, Vector] = {}
    groups: dict[tuple[int, int], dict[Vector, Vector]] = {}
    for b in reversed(bodies):
        if b.rotation is None or b.inertia is None:
            continue
        partials = b.rotation.partials
        turned = [(i, _unique(vectors, partials[s])) for i, s in enumerate(symbols) if s in partials]
        spun = [(j, b.inertia.times(w)) for j, w in turned if j < n]
        for i, v in turned:
            for j, h in spun:
                if i <= j or i >= n:
                    group = groups.setdefault((i, j), {})
                    group[v] = (group[v] + h).gathered() if v in group else h
    return groups

# SPDX-License-Identifier: BSD-3-Clause
"""M, f and G of M u̇ = f + G R, from partial velocities and biases.

    M_rs = Σ m v_r·v_s + ω_r·I·ω_s
    f_r  = Σ v_r·(F − m a_b) + Σ ω_r·(T − I·α_b − ω × I·ω)

Bodies that share a partial velocity share its scalar product: Σ_k V·X_k = V·Σ_k X_k. Sums run from the last body to the
first, so that along a chain every partial sum is one node used many times.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from kane.dynamics.bodies import Moving
from kane.dynamics.terms import sum_of
from kane.expr.build import add
from kane.expr.common_factor import Contents, content, divider, over_number
from kane.expr.evaluation import free_symbols
from kane.expr.irreducible import blocks as connected
from kane.expr.linear_parts import affine_forms
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.ops import CONST
from kane.expr.symbols import Reaction
from kane.kinematics.motion import Motion
from kane.space.vector import Parts, Vector

Rows = list[list[Expr]]
Place = tuple[int, int]

_FEW = 6
"""Equations up to which what their terms have in common is looked for."""


class Blocks(NamedTuple):
    """M (n × n), f (n) and G (n × reactions) of the generalized speeds; M_a, f_a and G_a of the auxiliary ones.

    `evident` is G_a without the loads that hold reactions.
    """

    mass: Matrix
    forcing: tuple[Expr, ...]
    coupling: Matrix
    mass_a: Matrix
    forcing_a: tuple[Expr, ...]
    coupling_a: Matrix
    evident: Matrix


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
    evident = Matrix([[pairs.get((s, x), ZERO) for x in reactions] for s in auxiliary], (len(auxiliary), r))
    return Blocks(
        Matrix(mass[:n], (n, n)),
        tuple(forcing[:n]),
        Matrix(coupling[:n], (n, r)),
        Matrix(mass[n:], (len(auxiliary), n)),
        tuple(forcing[n:]),
        Matrix(coupling[n:], (len(auxiliary), r)) + evident,
        evident,
    )


def _reaction_form(right: Sequence[Expr], reactions: Sequence[Reaction]) -> tuple[list[Expr], Rows]:
    """f and G of f + G R."""
    if not reactions or not any(isinstance(s, Reaction) for s in free_symbols(right)):
        return list(right), [[ZERO] * len(reactions) for _ in right]
    forms = affine_forms(right, reactions)
    return [rest for _, rest in forms], [[c.get(r, ZERO) for r in reactions] for c, _ in forms]


def mass_rows(bodies: Sequence[Moving], speeds: Sequence[Expr], auxiliary: Sequence[Expr]) -> Rows:
    """M_rs for r in `speeds`, then `auxiliary`, and s in `speeds`; the square block is symmetric."""
    symbols, n = [*speeds, *auxiliary], len(speeds)
    vectors: dict[Parts, Vector] = {}
    shifts: dict[Place, dict[Vector, dict[Vector, Expr]]] = {}  # v_r → (v_s → Σ m) over the bodies that both move
    turns: dict[Place, dict[Vector, Vector]] = {}  # ω_r → Σ I·ω_s over the bodies that both turn
    for b in reversed(bodies):
        met = _numbered(b.center, symbols, vectors)
        for motion, mass in b.momenta:
            moved = met if motion is b.center else _numbered(motion, symbols, vectors)
            for i, j in _pairs(met, moved, n):
                masses = shifts.setdefault((i, j), {}).setdefault(met[i], {})
                v = moved[j]
                masses[v] = add(masses[v], mass) if v in masses else mass
        if b.rotation is None:
            continue
        turned = _numbered(b.rotation.motion, symbols, vectors)
        momenta = {j: b.rotation.inertia.times(w) for j, w in turned.items() if j < n}
        for i, j in _pairs(turned, turned, n):
            group, w = turns.setdefault((i, j), {}), turned[i]
            group[w] = (group[w] + momenta[j]).gathered() if w in group else momenta[j]
    rows: Rows = []
    carried: dict[tuple[Any, ...], Vector] = {}
    for i in range(len(symbols)):
        line = [rows[j][i] for j in range(i)] if i < n else []
        for j in range(len(line), n):
            shift = sum_of([v.dot(_carried(masses, carried)) for v, masses in shifts.get((i, j), {}).items()])
            line.append(add(shift, sum_of([w.dot(h) for w, h in turns.get((i, j), {}).items()])))
        rows.append(line)
    return rows


def _numbered(motion: Motion, symbols: Sequence[Expr], vectors: dict[Parts, Vector]) -> dict[int, Vector]:
    """The partial velocities by the speeds' numbers; equal ones are one object, so that they can be compared by identity."""
    partials = motion.partials
    return {i: vectors.setdefault(partials[s].parts, partials[s]) for i, s in enumerate(symbols) if s in partials}


def _pairs(met: Iterable[int], moved: Iterable[int], n: int) -> list[Place]:
    """The entries on and above the diagonal, and those of auxiliary rows, to which a body adds."""
    return [(i, j) for i in met for j in moved if j < n and (i <= j or i >= n)]


def _carried(masses: Mapping[Vector, Expr], vectors: dict[tuple[Any, ...], Vector]) -> Vector:
    """Σ m v_s of one group; the same group met again is the same vector."""
    key = tuple(masses.items())
    if key not in vectors:
        vectors[key] = sum((v * mass for v, mass in masses.items()), start=Vector()).gathered()
    return vectors[key]


def primitive(blocks: Blocks) -> Blocks:
    """M, f and G of the speeds without the parameters that all terms of equations with common u̇ hold; M stays symmetric.

    An equation with one u̇, which a number multiplies, is divided by that, too.
    """
    count = len(blocks.forcing)
    memo: Contents = {}
    divided = divider(memo)
    mass, coupling = ([list(row) for row in m.rows] for m in (blocks.mass, blocks.coupling))
    forcing, changed = list(blocks.forcing), False
    for rows in connected(blocks.mass.rows, list(range(count))):
        if len(rows) > _FEW:
            continue
        common = content((x for i in rows for x in (*mass[i], *coupling[i], forcing[i])), memo)
        if not common:
            continue
        changed = True
        for i in rows:
            mass[i] = [divided(x, common) for x in mass[i]]
            coupling[i] = [divided(x, common) for x in coupling[i]]
            forcing[i] = divided(forcing[i], common)
        i = rows[0]
        number = mass[i][i]
        if len(rows) == 1 and number.op is CONST and all(x is ZERO for x in coupling[i]):
            mass[i][i], forcing[i] = ONE, over_number(forcing[i], number)
    if not changed:
        return blocks
    return blocks._replace(
        mass=Matrix(mass, (count, count)), forcing=tuple(forcing), coupling=Matrix(coupling, blocks.coupling.shape)
    )

# SPDX-License-Identifier: BSD-3-Clause
"""The seven steps of the method as records: titles, and named results to print."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kane.expr.build import add
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Speed
from kane.model.reactions import constraint_of
from kane.space.vector import Vector

if TYPE_CHECKING:
    from kane.equations.equations import Equations

Item = tuple[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One step: its number, title, a sentence on what it does, and its results as (name, expression or vector)."""

    number: int
    title: str
    text: str
    items: tuple[Item, ...]

    def __str__(self) -> str:
        lines = [f"Step {self.number}. {self.title}", f"   {self.text}"]
        lines += [f"   {name} = {value}" for name, value in self.items]
        return "\n".join(lines)

    __repr__ = __str__


def seven_steps(eom: Equations) -> tuple[Step, ...]:
    """Coordinates, velocities that matter, speeds, kinematics, active forces, inertia forces, equations."""
    return (
        Step(1, "Coordinates", "The configuration is described by these.", _coordinates(eom)),
        Step(
            2,
            "Velocities that matter",
            "Angular velocities of the frames and velocities of the points, in the rates of the coordinates.",
            _velocities_in_rates(eom),
        ),
        Step(
            3,
            "Generalized speeds",
            "u = Y q' + z, chosen so that these velocities become short; solved, q' = W u + X.",
            tuple((u.name, d) for u, d in eom.system.speeds.items())
            + tuple((f"{q.name}'", r) for q, r in zip(eom.coordinates, eom.rates, strict=True)),
        ),
        Step(
            4,
            "Kinematics in the speeds",
            "Angular velocities, velocities, their partial velocities, and accelerations."
            + (" The constraints A u + b = 0 give the dependent speeds, u_D = A_n u_I + b_n." if eom.embedding else ""),
            _kinematics(eom) + _constrained(eom),
        ),
        Step(
            5,
            "Generalized active forces",
            "F_r = sum of v_r . F + w_r . T over all loads." + (_NONHOLONOMIC if eom.embedding else ""),
            _forces(eom, "F", eom.Fr, eom.Fr_nh),
        ),
        Step(
            6,
            "Generalized inertia forces",
            "F*_r = sum of v_r . (-m a) + w_r . (-I . alpha - w x I . w) over all bodies.",
            _forces(eom, "F*", eom.Fr_star, eom.Fr_star_nh),
        ),
        Step(
            7,
            "Equations of motion",
            "F_r + F*_r = 0, ordered as M u' = f; the auxiliary equations give the reactions."
            if eom.embedding is None
            else "~F_r + ~F*_r = 0, or M u' = f + A^T lambda with A u + b = 0; the auxiliary equations give the reactions.",
            _equations(eom),
        ),
    )


_NONHOLONOMIC = " Of the independent speeds, ~F_r = F_r + sum of A_n[D, r] F_D over the dependent ones D."


def shown_speeds(eom: Equations) -> tuple[Expr, ...]:
    """The rows that hold partial velocities: speeds and auxiliary speeds of cuts. That of a constraint only lets it give way."""
    return (*eom.speeds, *(s for s in eom.auxiliary_speeds if constraint_of(s) is None))


def _coordinates(eom: Equations) -> tuple[Item, ...]:
    return tuple((q.name, q.description or "coordinate") for q in eom.coordinates)


def _velocities_in_rates(eom: Equations) -> tuple[Item, ...]:
    inertial = eom.system.inertial
    frames = [(f"w_{f.name}", f.angular_velocity(inertial)) for f in eom.frames if f is not inertial]
    points = [(f"v_{p.name}", p.velocity(inertial)) for p in eom.points if p.parent is not None]
    return (*frames, *points)


def _kinematics(eom: Equations) -> tuple[Item, ...]:
    items: list[Item] = []
    for f in eom.frames:
        if f is eom.system.inertial:
            continue
        items.append((f"w_{f.name}", eom.angular_velocities[f]))
        items += _present(f"w_{f.name}", eom.partial_angular_velocities[f])
        items.append((f"alpha_{f.name}", eom.angular_accelerations[f]))
    for p in eom.points:
        if p.parent is None:
            continue
        items.append((f"v_{p.name}", eom.velocities[p]))
        items += _present(f"v_{p.name}", eom.partial_velocities[p])
        items.append((f"a_{p.name}", eom.point_accelerations[p]))
    return tuple(items)


def _constrained(eom: Equations) -> tuple[Item, ...]:
    free, names = eom.independent_speeds, [c.name for c in eom.constraints.constraints]
    rows = zip(names, eom.A.rows, eom.b, strict=True)
    given = zip(eom.dependent_speeds, eom.A_n.rows, eom.b_n, strict=True)
    return (
        *((f"(A u + b)[{name}]", add(dot(row, eom.speeds), b)) for name, row, b in rows),
        *((u.name, add(dot(row, free), b)) for u, row, b in given),
    )


def _forces(eom: Equations, name: str, plain: Sequence[Expr], embedded: Sequence[Expr]) -> tuple[Item, ...]:
    """F_r of every row, and ~F_r of the independent ones where there are dependent ones."""
    rows = shown_speeds(eom)
    of_row: dict[Expr, Expr] = dict(zip(eom.all_speeds, plain, strict=True))
    items = [(f"{name}_{s!s}", of_row[s]) for s in rows]
    if eom.embedding is not None:
        total: dict[Expr, Expr] = dict(zip((*eom.independent_speeds, *eom.auxiliary_speeds), embedded, strict=True))
        other = [s for s in rows if s in total and (isinstance(s, Speed) or total[s] is not of_row[s])]
        items += [(f"~{name}_{s!s}", total[s]) for s in other]
    return tuple(items)


def _present(name: str, partials: Any) -> list[Item]:
    return [(f"{name},{s.name}", v) for s, v in partials.items() if isinstance(v, Vector) and not v.is_zero]


def _equations(eom: Equations) -> tuple[Item, ...]:
    items: list[Item] = []
    for i, r in enumerate(eom.speeds):
        for j in range(i, len(eom.speeds)):
            entry: Expr = eom.mass_matrix[i, j]
            if entry is not ZERO:
                items.append((f"M[{r.name}, {eom.speeds[j].name}]", entry))
    items += [(f"f[{r.name}]", f) for r, f in zip(eom.speeds, eom.forcing, strict=True)]
    for i, s in enumerate(eom.auxiliary_speeds):
        if constraint_of(s) is not None:
            continue
        row = eom.auxiliary_mass_matrix.rows[i]
        items += [
            (f"M[{s.name}, {u.name}]", entry) for u, entry in zip(eom.speeds, row, strict=True) if entry is not ZERO
        ]
        items.append((f"f[{s.name}]", eom.auxiliary_forcing[i]))
    held = {r: constraint_of(r) for r in eom.reactions}
    items += [(r.name, eom.multipliers[c]) for r, c in held.items() if c is not None]
    return tuple(items)

# SPDX-License-Identifier: BSD-3-Clause
"""The seven steps of the method as records: titles, and named results to print."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from kane.dynamics.derived import Derived
from kane.dynamics.solved import Solved
from kane.expr.build import add
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Speed
from kane.kinematics.motion import Motion, acceleration_form, velocity_form
from kane.model.reactions import constraint_of
from kane.model.system import System

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


def seven_steps(solved: Solved) -> tuple[Step, ...]:
    """Coordinates, velocities that matter, speeds, kinematics, active forces, inertia forces, equations."""
    derived, constrained = solved.derived, solved.embedding is not None
    system = derived.system
    return (
        Step(1, "Coordinates", "The configuration is described by these.", _coordinates(system)),
        Step(
            2,
            "Velocities that matter",
            "Angular velocities of the frames and velocities of the points, in the rates of the coordinates.",
            _velocities_in_rates(system),
        ),
        Step(
            3,
            "Generalized speeds",
            "u = Y q' + z, chosen so that these velocities become short; solved, q' = W u + X.",
            tuple((u.name, d) for u, d in system.speeds.items())
            + tuple((f"{q.name}'", r) for q, r in zip(system.coordinates, derived.rates, strict=True)),
        ),
        Step(
            4,
            "Kinematics in the speeds",
            "Angular velocities, velocities, their partial velocities, and accelerations."
            + (" The constraints A u + b = 0 give the dependent speeds, u_D = A_n u_I + b_n." if constrained else ""),
            _kinematics(derived) + _constrained(solved),
        ),
        Step(
            5,
            "Generalized active forces",
            "F_r = sum of v_r . F + w_r . T over all loads." + (_NONHOLONOMIC if constrained else ""),
            _forces(solved, "F", derived.Fr, solved.Fr_nh),
        ),
        Step(
            6,
            "Generalized inertia forces",
            "F*_r = sum of v_r . (-m a) + w_r . (-I . alpha - w x I . w) over all bodies.",
            _forces(solved, "F*", derived.Fr_star, solved.Fr_star_nh),
        ),
        Step(
            7,
            "Equations of motion",
            "F_r + F*_r = 0, ordered as M u' = f; the auxiliary equations give the reactions."
            if not constrained
            else "~F_r + ~F*_r = 0, or M u' = f + A^T lambda with A u + b = 0; the auxiliary equations give the reactions.",
            _equations(solved),
        ),
    )


_NONHOLONOMIC = " Of the independent speeds, ~F_r = F_r + sum of A_n[D, r] F_D over the dependent ones D."


def shown_speeds(derived: Derived) -> tuple[Expr, ...]:
    """The rows that hold partial velocities: speeds and auxiliary speeds of cuts. That of a constraint only lets it give way."""
    return (*derived.speeds, *(s for s in derived.auxiliary_speeds if constraint_of(s) is None))


def _coordinates(system: System) -> tuple[Item, ...]:
    return tuple((q.name, q.description or "coordinate") for q in system.coordinates)


def _velocities_in_rates(system: System) -> tuple[Item, ...]:
    inertial = system.inertial
    frames = [(f"w_{f.name}", f.angular_velocity(inertial)) for f in system.frames if f is not inertial]
    points = [(f"v_{p.name}", p.velocity(inertial)) for p in system.points if p.parent is not None]
    return (*frames, *points)


def _kinematics(derived: Derived) -> tuple[Item, ...]:
    items: list[Item] = []
    for f in derived.system.frames:
        if f is not derived.system.inertial:
            items += _motion(derived, derived.kinematics.frame(f), f"w_{f.name}", f"alpha_{f.name}")
    for p in derived.system.points:
        if p.parent is not None:
            items += _motion(derived, derived.kinematics.point(p), f"v_{p.name}", f"a_{p.name}")
    return tuple(items)


def _motion(derived: Derived, motion: Motion, velocity: str, acceleration: str) -> list[Item]:
    partials = [(s, motion.partials[s]) for s in derived.all_speeds if s in motion.partials]
    return [
        (velocity, velocity_form(motion)),
        *((f"{velocity},{s!s}", v) for s, v in partials if not v.is_zero),
        (acceleration, acceleration_form(motion)),
    ]


def _constrained(solved: Solved) -> tuple[Item, ...]:
    e, rows, speeds = solved.embedding, solved.derived.constraints, solved.derived.speeds
    if e is None:
        return ()
    names = [c.name for c in rows.constraints]
    return (
        *((f"(A u + b)[{name}]", add(dot(row, speeds), b)) for name, row, b in zip(names, rows.a, rows.b, strict=True)),
        *(
            (u.name, add(dot(row, solved.independent_speeds), b))
            for u, row, b in zip(solved.dependent_speeds, e.a_n, e.b_n, strict=True)
        ),
    )


def _forces(solved: Solved, name: str, plain: Sequence[Expr], embedded: Sequence[Expr]) -> tuple[Item, ...]:
    """F_r of every row, and ~F_r of the independent ones where there are dependent ones."""
    derived = solved.derived
    rows = shown_speeds(derived)
    of_row: dict[Expr, Expr] = dict(zip(derived.all_speeds, plain, strict=True))
    items = [(f"{name}_{s!s}", of_row[s]) for s in rows]
    if solved.embedding is not None:
        total: dict[Expr, Expr] = dict(
            zip((*solved.independent_speeds, *derived.auxiliary_speeds), embedded, strict=True)
        )
        other = [s for s in rows if s in total and (isinstance(s, Speed) or total[s] is not of_row[s])]
        items += [(f"~{name}_{s!s}", total[s]) for s in other]
    return tuple(items)


def _equations(solved: Solved) -> tuple[Item, ...]:
    derived, items = solved.derived, list[Item]()
    speeds, blocks = derived.speeds, derived.blocks
    for i, (r, row) in enumerate(zip(speeds, blocks.mass, strict=True)):
        items += [(f"M[{r.name}, {s.name}]", x) for s, x in zip(speeds[i:], row[i:], strict=True) if x is not ZERO]
    items += [(f"f[{r.name}]", f) for r, f in zip(speeds, derived.forcing, strict=True)]
    for a, row, f in zip(derived.auxiliary_speeds, blocks.mass_a, derived.auxiliary_forcing, strict=True):
        if constraint_of(a) is None:
            items += [(f"M[{a.name}, {u.name}]", x) for u, x in zip(speeds, row, strict=True) if x is not ZERO]
            items.append((f"f[{a.name}]", f))
    held = {r: constraint_of(r) for r in derived.reactions}
    items += [(r.name, solved.multipliers[c]) for r, c in held.items() if c is not None]
    return tuple(items)

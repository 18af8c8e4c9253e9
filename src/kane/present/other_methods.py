# SPDX-License-Identifier: BSD-3-Clause
"""Comparison of Kane's method with Lagrange's and the Newton–Euler equations for the system of a report.

    m a − F − R = 0 of every body, and so (F − m a)·∂v/∂u_r + … = F_r + F*_r = −Σ R·v_r − Σ S·ω_r = 0     (Yoo 2004, eq. 5, 6 and 9)

R and S, unknowns of the Newton–Euler equations, do no work in motions that satisfy the constraints: partial velocities eliminate them
before anything is solved. This is verified numerically with u̇ from Lagrange's equations, which do not use partial velocities.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kane.dynamics.formalisms import Formulation
from kane.dynamics.readings.contributions import Place, measured, states
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.errors import ModelError, cut
from kane.expr.evaluation import count_operations
from kane.expr.node import Expr
from kane.expr.symbols import rate
from kane.model.bodies import deforming, parts_of
from kane.numeric.rank import least_squares
from kane.numeric.scale import ROUNDED_SUM
from kane.present.first_screen import terms
from kane.present.languages.catalogue import N_, tr, trn
from kane.present.overview import PageTable
from kane.program.from_expressions import Task, build_program, receipt

_LARGEST = 400
"""Number of operations up to which a report has this chapter by default."""


@dataclass(frozen=True, slots=True)
class WhyKane:
    """A table of methods with their unknowns, and sentences on results at random states."""

    table: PageTable
    found: tuple[str, ...]
    text: str
    note: str


_TEXT = N_(
    r"By Newton and Euler each body has $m\mathbf{a} = \mathbf{F} + \mathbf{R}$ and "
    r"$\mathbf{I}\cdot\boldsymbol{\alpha} + \boldsymbol{\omega}\times\mathbf{I}\cdot\boldsymbol{\omega} = \mathbf{T} "
    r"+ \mathbf{S}$, and the constraint forces $\mathbf{R}$, $\mathbf{S}$ are unknowns beside its accelerations. They "
    r"do no work in motions that the constraints admit, $\sum \mathbf{R}\cdot\mathbf{v}_r + \sum "
    r"\mathbf{S}\cdot\boldsymbol{\omega}_r = 0$: multiplied by the partial velocities and added up, the same "
    r"equations are $F_r + F^*_r = \sum (\mathbf{F} - m\mathbf{a})\cdot\mathbf{v}_r + \dots = 0$, and contain none "
    r"of them. Lagrange's equations contain none either, but differentiate the kinetic energy, and have a multiplier for "
    r"each constraint of the coordinates."
)
_NOTE = N_(
    "Operations for the rates of the state, accelerations and multipliers, with the same expressions, elimination and counting; "
    "as compiled, after the optimization that all compiled code has. Newton's and Euler's equations are counted, not solved."
)


_HEAD = (
    N_("method"), N_("accelerations"), N_("constraint forces"), N_("equations"), N_("operations"), N_("as compiled"),
)  # fmt: skip


def is_small(eom: Equations) -> bool:
    """Whether the chapter takes little time."""
    return eom.operations.total <= _LARGEST and not eom.system.modes_change


def why_kane(eom: Equations) -> WhyKane:
    """The chapter for these equations."""
    rows = [_row(eom, tr("Kane"), len(eom.independent_speeds), 0, eom.right_hand_side, eom.derived.state)]
    try:
        other = eom.by("lagrange first kind")
        held = len(other.unknowns) - len(eom.coordinates)
        name = tr("Lagrange, with multipliers") if held else tr("Lagrange")
        rows.append(_row(eom, name, len(eom.coordinates), held, other.right_hand_side, other.state))
        found = tuple(_agreement(eom, other))
    except ModelError as error:
        found = (tr("Lagrange's equations do not apply to this system: %(error)s", error=cut(str(error), 300)),)
    head = tuple(map(tr, _HEAD))
    return WhyKane(PageTable("", head, (*rows, *_newton_euler(eom))), found, tr(_TEXT), tr(_NOTE))


def _row(
    eom: Equations, name: str, accelerations: int, forces: int, roots: Sequence[Expr], state: Sequence[Any]
) -> tuple[str, ...]:
    """The row of a method: operations for the rates of its state, and forces, as written and as compiled."""
    task = Task("rates", roots, (len(roots),), [f"{k}" for k in range(len(roots))])
    t, x, *given = ports(eom.derived)
    code = build_program("method", (t, replace(x, symbols=tuple(state)), *given), [task], True, optimize=True)
    counts = (count_operations(roots).total, receipt(code)["rates"].total)
    return name, *map(str, (accelerations, forces, accelerations + forces, *counts))


def _newton_euler(eom: Equations) -> list[tuple[str, ...]]:
    """The row of Newton–Euler: six accelerations of a rigid body, three of a particle, a constraint force for each lost freedom."""
    if deforming(eom.system.bodies):
        return []
    free = sum(3 if part.frame is None or part.inertia is None else 6 for part in parts_of(eom.system.bodies))
    forces = free - len(eom.independent_speeds)
    return (
        [(tr("Newton and Euler, body by body"), *map(str, (free, forces, free + forces)), "–", "–")]
        if forces >= 0
        else []
    )


# Numerical verification -----------------------------------------------------------------------------------------------


def _agreement(eom: Equations, other: Formulation) -> Iterator[str]:
    """Sentences on the agreement of accelerations, and on the contribution of constraint forces to F_r + F*_r, by another method."""
    u_dot = tuple(map(rate, eom.speeds))
    shares = list(terms(eom))
    forces = dict(_constraint_forces(eom))
    roots = (
        *eom.accelerations,
        *other.accelerations,
        *eom.A.entries,
        *eom.b,
        *(q.expr for q in shares),
        *forces.values(),
    )
    at = [_on_constraints(eom, place) for place in states(eom.derived, [*roots, *eom.speeds, *eom.rates], varied=False)]
    own, others = measured(eom.accelerations, at), measured(other.accelerations, at)
    kept = np.flatnonzero(np.isfinite(own).all(axis=1) & np.isfinite(others).all(axis=1))
    if not len(kept):
        return
    own, others = own[kept], others[kept]
    at = [at[k] | dict(zip(u_dot, row, strict=True)) for k, row in zip(kept.tolist(), others.tolist(), strict=True)]
    size = np.maximum(np.abs(own).max(axis=1), 1.0)
    off = float((np.abs(others - own).max(axis=1) / size).max())
    yield trn(
        r"At %(n)s state drawn at random $\dot{u}$ by Lagrange's equations, which contain no partial velocities, differs from that "
        "by Kane's by at most %(off)s of its size.",
        r"At %(n)s states drawn at random $\dot{u}$ by Lagrange's equations, which contain no partial velocities, differs from that "
        "by Kane's by at most %(off)s of its size.",
        len(at),
        off=f"{off:.1e}",
    )
    balances = _newton_euler(eom)
    if balances and balances[0][2] == "0":
        return
    values = measured([q.expr for q in shares], at)
    largest = float(np.abs(values).max(initial=0.0))
    if not largest > 0:  # nothing moves, or nothing acts
        return
    groups = [q.group for q in shares]
    left = max(float(np.abs(values[:, [g == group for g in groups]].sum(axis=1)).max()) for group in set(groups))
    words = tr(" and ").join(_largest(forces, at))
    acting = tr("There the constraints act on the bodies with %(forces)s.", forces=words) + " " if words else ""
    yield acting + tr(
        r"In $F_r + F^*_r$ with Lagrange's $\dot{u}$ their residual is %(left)s of the largest term: the partial velocities eliminate "
        "them before anything is solved.",
        left=f"{left / largest:.1e}",
    )


def _largest(forces: Mapping[str, Expr], at: Sequence[Place]) -> Iterator[str]:
    """The largest of the forces R and of the torques S."""
    for sign, what, unit in (("R", N_("forces of up to %(most)s"), "N"), ("S", N_("torques of up to %(most)s"), "N·m")):
        own = [e for name, e in forces.items() if name[0] == sign]
        most = float(np.nanmax(np.abs(measured(own, at)), initial=0.0))
        if most > ROUNDED_SUM:
            yield tr(what, most=f"{most:.3g} {unit}")


def _on_constraints(eom: Equations, place: Place) -> Place:
    """The state with speeds projected to the constraints, and the rates of the coordinates."""
    u = np.array([place[s] for s in eom.speeds])
    if len(eom.b):
        a = measured(eom.A.entries, [place]).reshape(eom.A.shape)
        u = u - least_squares(a, (a * u).sum(axis=1) + measured(eom.b, [place])[0])
    place = place | dict(zip(eom.speeds, u.tolist(), strict=True))
    rates = measured(eom.rates, [place])[0]
    return place | dict(zip(map(rate, eom.coordinates), rates.tolist(), strict=True))


def _constraint_forces(eom: Equations) -> Iterator[tuple[str, Expr]]:
    """R of mass centres and S of bodies by name; none if loads act elsewhere, which would be part of a body's balance."""
    other = eom.by("newton-euler")
    n = len(eom.coordinates)
    names = [str(s) for s in other.unknowns[n:]]
    places = {p for part in parts_of(eom.system.bodies) for p in (part.mass_center, part.inertia and part.frame) if p}
    if len(names) == 3 * len(places):
        yield from zip(names, other.right_hand_side[2 * n :], strict=True)

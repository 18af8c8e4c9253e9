# SPDX-License-Identifier: BSD-3-Clause
"""Loads that contribute to no generalized active force, each with the reason (Kane & Levinson 1985, sec. 4.5).

With motion constraints the generalized forces are the nonholonomic ones, of the independent speeds. And the inertia force and inertia
torque of each body, R* = −m a and T* = −(I·α + ω × I·ω) (sec. 4.11).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from kane.dynamics.derivation import Derived
from kane.dynamics.readings.contributions import vanish
from kane.dynamics.solved import Solved
from kane.dynamics.terms import Term, sum_of
from kane.errors import Attributes
from kane.expr.node import ZERO, Expr
from kane.model.bodies import Body
from kane.model.force_systems import ForceSystem
from kane.model.loads import Load
from kane.space.frame import Frame
from kane.space.point import Point


@dataclass(frozen=True, slots=True, eq=False)
class Noncontributing(Attributes):
    """A load that is in no generalized active force, and why."""

    load: Load
    reason: str

    def __repr__(self) -> str:
        return f"{self.load.name}: {self.reason}"


def noncontributing(solved: Solved) -> tuple[Noncontributing, ...]:
    """See Equations.noncontributing."""
    derived, speeds = _in_independent_speeds(solved), solved.independent_speeds
    found = []
    for load, terms in derived.active_terms.items():
        reason = _reason(derived, terms, speeds)
        if reason:
            found.append(Noncontributing(load, reason))
    return tuple(found)


def _in_independent_speeds(solved: Solved) -> Derived:
    """The motions in the independent speeds, with all loads: also those along what constraints hold."""
    shown, e = solved.derived.as_declared, solved.embedding
    if e is None:
        return shown
    return replace(shown, kinematics=shown.kinematics.with_following(e.following(solved.derived.speeds), {}))


def _reason(derived: Derived, terms: Sequence[Term], speeds: Sequence[Expr]) -> str:
    """Why F_r is zero for every speed, "" where it is not."""
    shares = [[_share(term, u) for u in speeds] for term in terms]
    if not vanish([sum_of(column) for column in zip(*shares, strict=True)], derived):
        return ""
    places = ", ".join(dict.fromkeys(term.place.name for term in terms))
    moving = [term for term in terms if any(not v.is_zero for u, v in term.motion.partials.items() if u in set(speeds))]
    if not moving:
        return f"no speed moves {places}: all partial velocities there are zero"
    if vanish([x for row in shares for x in row], derived):
        return f"perpendicular to the partial velocities of {places}"
    return f"what is contributed at {places} adds up to zero: action and reaction, where nothing moves along them"


def _share(term: Term, speed: Expr) -> Expr:
    partial = term.motion.partials.get(speed)
    return ZERO if partial is None else partial.dot(term.vector)


def inertia_forces(derived: Derived, body: Body) -> ForceSystem:
    """See Equations.inertia_forces."""
    terms = derived.inertia_terms[body]
    return ForceSystem(
        tuple((t.place, t.vector) for t in terms if isinstance(t.place, Point)),
        tuple(t.vector for t in terms if isinstance(t.place, Frame)),
    )

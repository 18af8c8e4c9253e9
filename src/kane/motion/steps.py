# SPDX-License-Identifier: BSD-3-Clause
"""The state of an integration on constraints: projection, and changes of the dependent speeds.

The dependent speeds are chosen by A at a state and the largest entries that A has had. Where the rank of the constraints drops at a
configuration, the accelerations are those nearest to M⁻¹ f in the mass metric under the remaining constraints.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kane.dynamics.constraints.partition import Partition, choose, quality
from kane.dynamics.poles import AdmittedSpeeds, moving_pivots
from kane.equations.compiled import Numeric
from kane.equations.equations import Equations, repartition
from kane.errors import ReactionError, SimulationError
from kane.expr.node import ZERO
from kane.model.declarations import Event
from kane.motion.hybrid.automaton import stepped
from kane.motion.kinks import Dense, Kink, kinks
from kane.motion.projection import (
    Mixes,
    Numbers,
    RankHistory,
    Tolerances,
    constraint_numbers,
    constraint_projection,
    crosses,
    is_constrained,
    looked_at,
    missed,
    mixes,
)
from kane.motion.right_hand_side import Routines, exact
from kane.motion.solution.solution import SolutionSegment
from kane.motion.start import regular_otherwise
from kane.numeric.arrays import Array
from kane.numeric.rank import Mixed, balanced, combinations, mobility, sizes, sure_rows
from kane.numeric.scale import BETTER, MOTION_RANK, POOR, UNUSABLE
from kane.program.native.machine import Settings

_WELL = 2.5
"""Multiple of the least quality of dependent speeds at which a kernel resumes a motion."""
_TAKES_PART = 0.01
"""Share of the largest coefficient above which a constraint is named among those that lose rank together."""


class Stepper:
    """One motion of the equations `first`: `rate(t, y)` and `keep(t, y)` with y = (q, u, a, ∫P dt).

    Mutable: `now`, the routines with the present dependent speeds; `lost`, whether rank is lost; `side`, the sign of the determinant
    of the dependent block; `reach` (m × n), the largest entries of A so far; `mixes`, combinations that replace its rows when rank is
    decided. `segments` and `changes` record the changes.
    """

    def __init__(
        self, eom: Equations, p: Array, drives: Sequence[Callable[[Any], Any]], settings: Settings | None = None
    ) -> None:
        self.first, self.numeric = eom, eom.numeric(settings)
        own = [constraint_numbers] if is_constrained(eom) else []
        self.now = stepped(eom, p, drives, settings, *own)
        self.projection = constraint_projection(self.numeric)
        self.kinks = kinks(self.numeric) if self.projection else None
        self.segments: list[SolutionSegment] = []
        self.changes: list[tuple[Event, float]] = []
        self.lost = False
        self.side = 0.0
        self.reach: Array = np.zeros((len(eom.b), len(eom.speeds)))
        self.mixes: Mixes = (None, None)
        self.admitted: AdmittedSpeeds | None = None
        self._slopes: tuple[Equations | None, Callable[[float, Array], Array]] = (None, lambda t, y: y)

    @property
    def eom(self) -> Equations:
        """The equations with the present dependent speeds."""
        return self.now.eom

    def rate(self, t: float, y: Array) -> Array:
        """(q̇, u̇, ȧ, P) at t and y."""
        if not self.lost:
            return self.now.rate(t, y)
        assert self.projection is not None
        numbers = self.projection.numbers(t, y[: self.now.width], self.now.p, self.now.inputs(t, y))
        return self.now.least_rate(t, y, numbers.m, numbers.a, self.reach, self.mixes[1])

    def slopes(self, t: float, y: Array) -> Array:
        """J = ∂(q̇, u̇, ȧ, P)/∂y with the present dependent speeds."""
        eom, found = self._slopes
        if eom is not self.eom:
            found = exact(self.now)
            self._slopes = self.eom, found
        return found(t, y)

    def keep(self, t: float, y: Array) -> tuple[Array, Numbers | None]:
        """y projected onto the constraints, and their numbers there, whose sizes are included in `reach`."""
        if self.projection is None:
            return y, None
        width = self.now.width
        x, numbers = self.projection.project(t, y[:width], self.now.p, self.now.inputs(t, y), self.reach, self.mixes)
        self.reach = np.maximum(self.reach, np.abs(numbers.a))
        if self.mixes != (None, None):
            c = len(numbers.f)
            configuration, motion = self.mixes
            self.mixes = configuration and configuration.grown(numbers.a[:c]), motion and motion.grown(numbers.a)
        return np.append(x, y[width:]), numbers

    def turned(self, numbers: Numbers | None) -> str:
        """The closures that projection has moved to a branch other than the intended one, as text; "" if there are none."""
        return "" if numbers is None or self.projection is None else self.projection.turned(numbers)

    def missed(self, t: float, y: Array, numbers: Numbers | None, tolerances: Tolerances) -> str:
        """The constraint that is violated at the projected y by more than the tolerances allow, as text; "" if there is none."""
        if numbers is None:
            return ""
        x = y[: self.now.width]
        return missed(self.eom, numbers, x, self.reach, tolerances, lambda: self.now.values(t, y))

    def sample(self, t: float, y: Array) -> tuple[Array, Equations]:
        """y projected onto the constraints, and equations whose dependent speeds are determined there.

        The present ones may be singular at a state within a step.
        """
        kept, numbers = self.keep(t, y)
        if numbers is None or not self._chosen_from(numbers):
            return kept, self.eom
        return kept, determined(self.numeric, self.eom, numbers, self.reach, self.mixes[1])

    def regularize(self, t: float, y: Array) -> bool:
        """Changes the dependent speeds if W has a pole with the present ones but not with others; returns whether it did."""
        other = self.regular(t, y)
        if other is None:
            return False
        self._take(other, t)
        # the new equations may have other rows
        self.reach, self.mixes = np.zeros_like(self.reach), (None, None)
        return True

    def regular(self, t: float, y: Array) -> Equations | None:
        """Equations with other dependent speeds, determined at y, whose W is farther from a pole there; None if there are none."""
        values = self.now.values(t, y)
        if self.admitted is None and self.eom.embedding is not None and moving_pivots(self.eom.derived):
            self.admitted = AdmittedSpeeds(self.eom.derived, values)
        if self.admitted is None:
            return None
        return regular_otherwise(self.eom, values, self.admitted, self.numeric.value)

    def settle(self, t: float, y: Array, numbers: Numbers | None, pole: bool = True) -> bool:
        """Changes the dependent speeds where the present ones are poorly determined; returns whether these, or `lost`, have changed.

        `pole`: whether W may have a pole near y.
        """
        before = (self.eom, self.lost)
        if pole and self.regularize(t, y):
            y, numbers = self.keep(t, y)
        if numbers is None or not self._chosen_from(numbers):
            return before[0] is not self.eom
        assert self.eom.embedding is not None
        assert self.projection is not None
        lost = self._loses_rank(numbers)
        if lost:
            given = self.now.p, self.now.inputs(t, y)
            self.mixes = mixes(self.projection, t, y[: self.now.width], given, numbers, self.reach)
        other = better(numbers.a, self.eom.embedding.partition, self.reach, not self.segments, self.mixes[1])
        if other is not None:
            self._take(self.numeric.value(repartition, other), t)
        if lost or other is not None:
            lost = self._loses_rank(numbers)
        if lost and not self.lost:
            self._check_coupling(t)
            told = f"the accelerations of least size are used where {self._losing(numbers)} lose rank"
            self._note(t, "rank of the constraints drops", told)
        self.lost = lost
        self.side = 0.0 if lost else self._side(numbers)
        if before[0] is not self.eom or not self.segments:
            self.segments.append(SolutionSegment(t, self.eom))
        return before != (self.eom, self.lost)

    def jumped(self, numbers: Numbers | None) -> bool:
        """Whether the dependent block was singular since `settle` was last called: its determinant has changed sign.

        Its inverse was unbounded in between, which the error estimates of the solver need not have detected.
        """
        if not self.side or numbers is None or not np.all(np.isfinite(numbers.a)):
            return False
        return self.side * self._side(numbers) < 0 and not self._loses_rank(numbers)

    def bent(self, dense: Dense, start: float, end: float, tolerances: Tolerances) -> Kink | None:
        """The first corner in a step across which positions or velocities would have to jump; None if there is none."""
        if self.kinks is None:
            return None
        return self.kinks.ahead(dense, start, end, lambda t: (self.now.p, self.now.inputs(t, dense(t))), tolerances)

    def crosses(self, dense: Callable[[Any], Array], start: float, end: float, rank_alone: bool = False) -> bool:
        """Whether a step crosses a state at which rank is lost, or at which the dependent block is singular.

        Such a state at an end of the step is detected by `settle`. With `rank_alone` only loss of rank counts.
        """
        embedding, kept = self.eom.embedding, self.projection
        if embedding is None or kept is None:
            return False

        def along(t: Array) -> RankHistory:
            a = kept.numbers(t, dense(t)[: self.now.width].T, self.now.p, self.now.inputs(t, dense(t).T)).a
            found = looked_at(t, a, embedding.partition, self.reach, self.mixes[1])
            return found._replace(side=np.ones_like(found.side)) if rank_alone else found

        return crosses(along, start, end)

    def _chosen_from(self, numbers: Numbers) -> bool:
        """Whether there are dependent speeds, and A is finite."""
        return self.eom.embedding is not None and bool(np.all(np.isfinite(numbers.a)))

    def _side(self, numbers: Numbers) -> float:
        """The sign of the determinant of the dependent block of A."""
        assert self.eom.embedding is not None
        partition = self.eom.embedding.partition
        block = balanced(numbers.a, self.reach)[np.ix_(partition.rows, partition.dependent)]
        return float(np.linalg.slogdet(block)[0])

    def _loses_rank(self, numbers: Numbers) -> bool:
        return share_of_rank(numbers.a, len(self.eom.dependent_speeds), self.reach, self.mixes[1]) < MOTION_RANK

    def _losing(self, numbers: Numbers) -> str:
        """The constraints in the combinations of rows that lose rank here, as text."""
        assert self.eom.embedding is not None
        places = list(self.eom.embedding.partition.rows)
        rows, values = combinations(numbers.a[places], self.reach[places])
        shares = np.abs(rows[values <= MOTION_RANK * values[:1]]) * self.reach[places].max(axis=1)
        parts = shares.max(axis=0, initial=0) > _TAKES_PART * shares.max(initial=0)
        constraints = self.eom.derived.constraints.constraints
        return ", ".join(f"{constraints[k].name!r}" for k, x in zip(places, parts, strict=True) if x)

    def _take(self, eom: Equations, t: float) -> None:
        """Changes to equations with other dependent speeds at t."""
        others = [constraint_numbers] if eom.solved.twin is not self.eom.solved.twin else []
        now = stepped(eom, self.now.p, self.now.drives, self.now.settings, *others)
        if others:
            self.projection = constraint_projection(eom.numeric(self.now.settings))
        self.go_over(now, t, begun=False)

    def go_over(self, now: Routines, t: float, begun: bool = True) -> None:
        """Changes to compiled equations with other dependent speeds at t; if `begun`, a segment begins there."""
        self.now = now
        if begun:
            self.side = 0.0
            self.segments.append(SolutionSegment(t, self.eom))
        names = ", ".join(u.name for u in self.eom.dependent_speeds)
        self._note(t, f"dependent speeds {names}", "the dependent speeds were changed")

    def _note(self, t: float, name: str, message: str) -> None:
        self.changes.append((Event(name, ZERO, terminal=False, message=message), t))

    def _check_coupling(self, t: float) -> None:
        if any(x is not ZERO for row in self.eom.blocks.coupling for x in row):
            raise SimulationError(
                f"Expected constraints of constant rank, got a drop at t = {t:.6g}, where loads that contain reactions leave "
                "the accelerations undetermined. Start elsewhere, or leave out the loads that depend on reactions."
            )


def better(a: Array, present: Partition, reach: Array, may_grow: bool, mix: Mixed | None = None) -> Partition | None:
    """Other dependent speeds if the present ones are poorly determined by A (m × n), and those much better; None otherwise.

    Choices with more rows than the present one are admitted if the rank `may_grow`, at the start. They are taken there if more rows
    are certainly independent: the motion is on another branch than the configurations that were compared in the derivation.
    """
    now = quality(a, present, reach)
    short = may_grow and bool(present.redundant) and len(sure_rows(a, reach, mix)) > len(present.rows)
    if now >= POOR and not short:
        return None
    other = choose(a, reach=reach)
    more = len(other.rows) - len(present.rows)
    if short and more > 0:
        return other
    allowed = more == 0 or (more > 0 and may_grow)
    return other if allowed and quality(a, other, reach) > BETTER * now else None


def determined(
    first: Numeric[Equations], present: Equations, numbers: Numbers, reach: Array, mix: Mixed | None = None
) -> Equations:
    """Equations whose dependent speeds are determined at a state: the present ones, or others derived from the `first`.

    Where rank is lost, only as many speeds are dependent as A determines.
    """
    assert present.embedding is not None
    partition = present.embedding.partition
    rank = len(sure_rows(numbers.a, reach, mix))
    reach = np.maximum(reach, sizes(numbers.a, mobility(numbers.m, reach)))
    if rank >= len(partition.rows) and quality(numbers.a, partition, reach) >= UNUSABLE:
        return present
    try:
        return first.value(repartition, choose(numbers.a, reach=reach).first(min(rank, len(partition.rows))))
    except ReactionError:
        return present


def share_of_rank(a: Array, rank: int, reach: Array, mix: Mixed | None = None) -> float:
    """The singular value number `rank` of the balanced A (m × n), relative to the largest; NaN if A is zero."""
    values = combinations(a, reach, mix)[1]
    with np.errstate(invalid="ignore"):
        return float(values[rank - 1] / values[0])


def unheld(stepper: Stepper) -> str:
    """Why only Python can keep the constraints satisfied, as text; "" if a kernel can."""
    if stepper.projection is None:
        return ""
    if stepper.kinks is not None:
        return "constraints have corners"
    if stepper.lost or stepper.mixes != (None, None):
        return "constraints lose rank"
    return "W has false poles" if stepper.eom.solved.twin is not None else ""


def regular(stepper: Stepper, numbers: Numbers | None, share: float = _WELL) -> bool:
    """Whether the dependent speeds are determined so well that a kernel can continue: with a quality above `share` of the least."""
    embedding = stepper.eom.embedding
    if embedding is None or numbers is None:
        return True
    return quality(numbers.a, embedding.partition, stepper.reach) > share * POOR

# SPDX-License-Identifier: BSD-3-Clause
"""`Solved`: u̇, reactions and multipliers by one formulation, with the divisors and guards of the solution."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from kane.dynamics.constraints.manifold import contacts, touches
from kane.dynamics.constraints.partition import Embedding, Watch, watch
from kane.dynamics.derivation import Derived
from kane.dynamics.forcing import generalized_by_motion, mass_rows
from kane.dynamics.lazy import Lately, LazyMapping, read
from kane.expr.build import add, mul, neg, sub
from kane.expr.evaluation import Operations, Walk, count_operations, free_symbols, is_constant_in_time, price
from kane.expr.forms.collect import joined
from kane.expr.forms.shorter import shortened
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr, Exprs, constant
from kane.expr.ops import Immutable
from kane.expr.regular import Guards, Sizes, extended, factors, guarding, largest, never_zero, size, unguarded
from kane.expr.symbols import Speed, Symbols, rate
from kane.expr.visit import substituting
from kane.kinematics.velocities import Motion
from kane.model.constraints import Constraint
from kane.numeric.sampling import SEED, sample
from kane.numeric.scale import CLOSED, SIX_DIGITS
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

_READINGS = 64


class Pivot(NamedTuple):
    """The determinant `value` of the block that some dependent speeds are solved from, and the size beside which it counts as zero."""

    speeds: tuple[Speed, ...]
    value: Expr
    size: Expr


class AffineConstraints(NamedTuple):
    """Constraints A u + b = 0, one per row."""

    constraints: tuple[Constraint, ...]
    a: Matrix
    b: Exprs


class Reading(NamedTuple):
    """A numerical reading: `walk` evaluates the first `asked` expressions, then A u + b of the constraints `names`, then its limits.

    `concerned` are the indices of expressions that redundant rows could change, or without constraints a singular M.
    """

    walk: Walk
    asked: int
    names: tuple[str, ...]
    concerned: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Solved(Immutable):
    """u̇ and R by one formulation (`route`) with one choice of dependent speeds, and the divisors of the solution.

    `pivots` are those of the mass matrix. The reactions are solved from `reaction_matrix`; `bare_reaction_matrix` is without the loads
    that depend on reactions, and a change of sign of the ratio of their determinants is Painlevé's case.

    If W has false poles, `twin` is the solution in other speeds, of which those in `vanishing` are zero, and numbers are computed from
    it. `shorter_rates` are q̇ on the constraints, if shorter than W u + X. `routes` gives the operations of all formulations compared,
    by name; `asked` is the one asked for. `lightened` is the system without loads along constraint forces. `of_rows` are the
    multipliers by row, if the formulation computes them.
    """

    route: str
    derived: Derived
    embedding: Embedding | None
    accelerations: Exprs
    reactions: Exprs
    pivots: Exprs
    reaction_matrix: Matrix
    bare_reaction_matrix: Matrix
    twin: "Solved | None" = None
    vanishing: Mapping[Expr, Expr] = field(default_factory=dict)
    shorter_rates: Exprs | None = None
    routes: Mapping[str, int] = field(default_factory=dict)
    asked: str | None = None
    lightened: Derived | None = None
    of_rows: Mapping[int, Expr] | None = None

    regular = read[Derived](lambda s: s.twin.derived if s.twin else s.derived, "What is read in numbers.")
    rates = read[Exprs](
        lambda s: s.written(s.regular.rates) if s.shorter_rates is None else s.shorter_rates,
        "q̇ as functions of the state, which satisfies the constraints.",
    )
    state_rates = read[Exprs](
        lambda s: s.written(s.regular.state_rates), "ȧ of the further states as functions of the state."
    )
    right_hand_side = read[Exprs](
        lambda s: (*s.rates, *s.accelerations, *s.state_rates), "ẋ = (q̇, u̇, ȧ) as functions of the state."
    )
    shown = read[tuple[Exprs, Exprs]](
        lambda s: (joined(s.accelerations), joined(s.reactions)),
        "u̇ and the reactions, each written on its own; in the right-hand side they share more.",
    )
    price = read[int](
        lambda s: price((*(s.shorter_rates or s.derived.rates), *s.accelerations, *s.reactions)),
        "Operations of q̇, u̇ and the reactions, by which routes are compared.",
    )
    operations = read[Operations](
        lambda s: count_operations((*s.right_hand_side, *s.reactions)),
        "Number of operations of one evaluation of the whole right-hand side, with the solution for u̇.",
    )

    @read
    def rate_guards(self) -> Guards:
        """The divisors of W in q̇ = W u + X that may vanish up to rounding, and the sizes beside which they count as zero.

        Left out are those whose size depends on the state, as that of x² does, since they vanish exactly.
        """
        memo: Sizes = {}
        pivots = [p for p in self.regular.kinematical.pivots if not is_constant_in_time([p])]
        parts = dict.fromkeys(f for p in pivots for f in factors(p) if not (never_zero(f) or is_constant_in_time([f])))
        sizes = {f: size(f, memo) for f in parts}
        return {f: bound for f, bound in sizes.items() if is_constant_in_time([bound])}

    @read
    def free_pivots(self) -> Guards:
        """The pivots of M of a system without constraints that may vanish, and their sizes.

        The size is that of their terms or, for the long sums of recursions, that at a random state.
        """
        own = [] if self.embedding else [p for p in self.pivots if free_symbols([p]) and not never_zero(p)]
        if self.route == "classical":
            memo: Sizes = {}
            return {p: size(p, memo) for p in own}
        groups = [s.coordinates for s in self.derived.system.euler_parameters]
        return {p: constant(abs(x)) for p, x in zip(own, sample(own, SEED, groups), strict=True)}

    rate_symbols = read[Mapping[Expr, frozenset[Expr]]](
        lambda s: {d: frozenset(free_symbols([d, bound])) for d, bound in s.rate_guards.items()},
        "The symbols of each of `rate_guards`.",
    )

    readings = read[Lately[tuple[Exprs, frozenset[Expr]], Reading]](
        lambda s: Lately(_READINGS), "What was evaluated lately, by the expressions and by what was given."
    )
    walks = read[Lately[Exprs, Walk]](lambda s: Lately(_READINGS), "What was walked lately for it.")

    # Constraints ---------------------------------------------------------------------------------------------------------

    dependent_speeds = read[tuple[Speed, ...]](
        lambda s: Symbols(
            s.derived.speeds[s.embedding.partition.dependent[k]] for k in (s._dependent_indices if s.embedding else ())
        ),
        "The dependent speeds u_D: those declared as dependent in their order, then further ones in the order of the speeds.",
    )
    independent_speeds = read[tuple[Speed, ...]](
        lambda s: Symbols(s.derived.speeds[i] for i in s.embedding.independent) if s.embedding else s.derived.speeds,
        "The independent speeds u_I, one for each degree of freedom.",
    )
    A_n = read[Matrix](
        lambda s: s.embedding.a_n.take(s._dependent_indices) if s.embedding else Matrix([], (0, len(s.derived.speeds))),
        "A_n of u_D = A_n u_I + b_n, a row for each of `dependent_speeds`.",
    )
    b_n = read[Exprs](
        lambda s: tuple(s.embedding.b_n[k] for k in s._dependent_indices) if s.embedding else (),
        "b_n of u_D = A_n u_I + b_n, for each of `dependent_speeds`.",
    )

    @read
    def _dependent_indices(self) -> tuple[int, ...]:
        """The indices of `dependent_speeds` in the partition, which is in the order of elimination."""
        solved_for = self.embedding.partition.dependent if self.embedding else ()
        named = {u: k for k, u in enumerate(self.derived.system.dependent_speeds)}
        rank = [(named.get(u, len(named)), i) for i, u in enumerate(self.derived.speeds)]
        return tuple(sorted(range(len(solved_for)), key=lambda k: rank[solved_for[k]]))

    @read
    def speeds_by_independent(self) -> Exprs:
        """All speeds as functions of u_I: u_I, and u_D = A_n u_I + b_n."""
        dependent = map(add, self.A_n @ self.independent_speeds, self.b_n)
        values: dict[Speed, Expr] = {u: u for u in self.independent_speeds}
        values.update(zip(self.dependent_speeds, dependent, strict=True))
        return tuple(values[u] for u in self.derived.speeds)

    @read
    def held(self) -> AffineConstraints:
        """The constraints as A u + b = 0, or, if W has false poles, as u_D − A_n u_I − b_n = 0, which has none."""
        e, rows = self.embedding, self.derived.constraints
        if e is None or self.twin is None:
            return AffineConstraints(rows.constraints, rows.a, rows.b)
        own = dict(zip(e.independent, range(len(e.independent)), strict=True))
        a = [
            [ONE if j == d else neg(e.a_n[k, own[j]]) if j in own else ZERO for j in range(rows.a.shape[1])]
            for k, d in enumerate(e.partition.dependent)
        ]
        return AffineConstraints(
            tuple(rows.constraints[r] for r in e.partition.rows), Matrix(a), tuple(map(neg, e.b_n))
        )

    speed_residuals = read[Exprs](
        lambda s: tuple(add(dot(a, s.derived.speeds), b) for a, b in zip(s.held.a, s.held.b, strict=True)),
        "A u + b, one of each of the constraints `held`.",
    )

    @read
    def speed_limits(self) -> Mapping[int, Expr]:
        """The limits of |A u + b| due to rounding, by the numbers of the constraints `held`."""
        speeds, (_, rows, rests) = self.derived.speeds, self.held
        fastest = largest(speeds)
        memo: Sizes = {}

        def limit(k: int) -> Expr:
            a, b = rows.take([k]).entries, rests[k]
            left = add(size(self.speed_residuals[k], memo), mul(largest(size(x, memo) for x in a), fastest))
            return add(mul(constant(SIX_DIGITS), largest([*map(mul, a, speeds), b])), mul(constant(CLOSED), left))

        return LazyMapping(range(len(rests)), limit)

    @read
    def redundant(self) -> tuple[Constraint, ...]:
        """Redundant constraints: those that follow from the others at the configurations examined. Their multipliers are zero."""
        rows = self.embedding.partition.redundant if self.embedding else ()
        return tuple(self.derived.constraints.constraints[r] for r in rows)

    @read
    def left_out(self) -> Watch | None:
        """The test whether the `redundant` constraints follow from the others at a state; None if there are none."""
        d = self.derived
        return watch(self.embedding, d.compared, d.conditions) if self.embedding else None

    @read
    def solved_for(self) -> frozenset[Expr]:
        """The solved expressions: u̇, reactions, A_n and b_n, except leaves of the graph."""
        e = self.embedding
        solved = (*self.accelerations, *self.reactions, *self.shown[0], *self.shown[1])
        return frozenset(x for x in (*solved, *(e.a_n.entries if e else ()), *(e.b_n if e else ())) if x.args)

    @read
    def dependent_pivots(self) -> tuple[Pivot, ...]:
        """Denominators of A_n and b_n that may vanish, each with the dependent speeds that are solved for with it."""
        e, speeds = self.embedding, self.derived.speeds
        if e is None:
            return ()
        return tuple(
            Pivot(tuple(speeds[e.partition.dependent[k]] for k in d.unknowns), d.value, d.size) for d in e.divisors
        )

    @read
    def multipliers(self) -> Mapping[Constraint, Expr]:
        """Multipliers λ of M u̇ = f + Aᵀ λ, the forces or torques of constraints, by constraint, in u̇ and reactions."""
        e, d = self.embedding, self.derived
        if e is None:
            return {}
        if self.twin is not None:
            return dict(zip(self.twin.multipliers, self.written(self.twin.multipliers.values()), strict=True))
        if self.of_rows is not None:
            return {c: self.of_rows.get(r, ZERO) for r, c in enumerate(d.constraints.constraints)}
        left = d.mass_matrix.take(e.partition.dependent) @ [rate(u) for u in d.speeds]
        residual = [sub(x, d.forcing[i]) for x, i in zip(left, e.partition.dependent, strict=True)]
        return dict(zip(d.constraints.constraints, e.multipliers(residual), strict=True))

    # Nonholonomic: in the independent speeds -----------------------------------------------------------------------------

    @read
    def nonholonomic(self) -> Derived:
        """The system in the independent speeds, along the declared frames, with velocities from contact points."""
        d, e = self.lightened or self.derived, self.embedding
        if e is None:
            return d.as_declared
        held = contacts(touches(d.constraints.constraints, e.partition.rows, d.kinematics), {}, d.kinematics)
        shown = d.as_declared
        return replace(shown, kinematics=shown.kinematics.with_following(e.following(d.speeds), held))

    partial_velocities_nh = read[Mapping[Point, Mapping[Expr, Vector]]](
        lambda s: LazyMapping(s.derived.system.points, lambda p: s._partials(s.nonholonomic.kinematics.point(p))),
        "Nonholonomic partial velocities ṽ_r = v_r + Σ_D v_D A_n[D, r] of each point, for the independent speeds.",
    )
    partial_angular_velocities_nh = read[Mapping[Frame, Mapping[Expr, Vector]]](
        lambda s: LazyMapping(s.derived.system.frames, lambda f: s._partials(s.nonholonomic.kinematics.frame(f))),
        "Nonholonomic partial angular velocities ω̃_r of each frame, for the independent speeds.",
    )
    mass_matrix_nh = read[Matrix](
        lambda s: Matrix([s.short(row) for row in mass_rows(s.nonholonomic.bodies, s.independent_speeds, ())]),
        "M̃ = BᵀMB of the independent speeds, M̃_rs = Σ m ṽ_r·ṽ_s + ω̃_r·I·ω̃_s.",
    )
    forcing_nh = read[Exprs](
        lambda s: s.short([generalized_by_motion(s.nonholonomic.left, u) for u in s.independent_speeds]),
        "f̃ of M̃ u̇_I = f̃, if no load contains a reaction: Σ ṽ_r·(F − m ã_b) + ω̃_r·(T − I·α̃_b − ω × I·ω).",
    )
    Fr_nh = read[Exprs](
        lambda s: s._nonholonomic(s.nonholonomic.Fr, s.derived.as_declared.Fr),
        "Nonholonomic generalized active forces F̃_r = F_r + Σ_D A_n[D, r] F_D of the independent, then the auxiliary speeds.",
    )
    Fr_star_nh = read[Exprs](
        lambda s: s._nonholonomic(s.nonholonomic.Fr_star, s.derived.as_declared.Fr_star),
        "Nonholonomic generalized inertia forces F̃*_r, those of the independent speeds in u̇_I.",
    )

    def _partials(self, motion: Motion) -> Mapping[Expr, Vector]:
        return LazyMapping(self.independent_speeds, lambda u: motion.partials.get(u, Vector()))

    def mapped(self, change: Callable[[Expr], Expr]) -> "Solved":
        """The solution with `change` applied to every solved expression."""
        return replace(
            self,
            accelerations=tuple(map(change, self.accelerations)),
            reactions=tuple(map(change, self.reactions)),
            pivots=tuple(map(change, self.pivots)),
            reaction_matrix=self.reaction_matrix.map(change),
            bare_reaction_matrix=self.bare_reaction_matrix.map(change),
            of_rows=self.of_rows and {r: change(x) for r, x in self.of_rows.items()},
        )

    def guarded(self) -> "Solved":
        """The solution, NaN where a divisor of the constraints vanishes; to be applied last, after all cancellation."""
        e = self.embedding
        if e is None:
            return self
        return replace(self.mapped(guarding(e.guards_in_use)), embedding=e.guarded())

    def written(self, roots: Iterable[Expr]) -> Exprs:
        """Expressions of `regular`, with the vanishing speeds set to zero."""
        return tuple(map(substituting(self.vanishing), roots) if self.vanishing else roots)

    def _nonholonomic(self, own: Exprs, every: Exprs) -> Exprs:
        """Generalized forces of the independent speeds from `own`, and of the auxiliary speeds from `every`."""
        e, n = self.embedding, len(self.derived.speeds)
        if e is None:
            return every
        dependent = [every[i] for i in e.partition.dependent]
        return (*self.short([own[i] for i in e.independent]), *map(add, every[n:], e.a_na.T @ dependent))

    def short(self, exprs: Sequence[Expr]) -> Exprs:
        """Expressions on the constraints in the shortest of a few forms, some with u_D in terms of u_I."""
        e = self.embedding
        if e is None:
            return tuple(exprs)
        plain, values = unguarded(exprs), unguarded(self.speeds_by_independent)
        by: dict[Expr, Expr] = {u: x for u, x in zip(self.derived.speeds, values, strict=True) if u is not x}
        found = shortened(plain, list(map(substituting(by), plain)))
        return tuple(map(guarding(extended(e.guards, found)), found))

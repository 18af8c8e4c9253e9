# SPDX-License-Identifier: BSD-3-Clause
"""The candidates among which the shortest formulation is sought: each a choice of speeds and of a form of the equations.

    speeds      declared, rates of constraints in the places of dependent ones, velocities of the mass centre
    embedding   after M and f are assembled, or before, in motions that satisfy the constraints
    about       the mass centre, or a point at rest
    bias        inertia forces by accelerations, by the momenta that M has, by the power, by a sum of squares
    dependent   u̇_D by A_n and c_D, by the definitions of the speeds that rates of constraints replaced, or by one differentiation

In u̇_D = A_n u̇_I + c_D the term of each speed is differentiated separately. With u̇_I substituted first, one differentiation gives

    A_D u̇_D = −(d/dt)(A u + b) at u̇_D = 0

along the tree, from the accelerations of the constrained points and frames, or from the rates A_q q̇ + b_q as written, with q̈ of each
coordinate.

If no load depends on a reaction, reactions follow from the accelerations, as by hand once u̇ is known:

    G_a R = ρ_a + A_naᵀ ρ_D,   ρ_s = Σ v_s·(m a − F) + Σ ω_s·(I·α + ω × I·ω − T)

with a and α of each body summed first: there is one product with partial velocities per reaction, not one per entry of M_a.

Last, q̇, u̇ and the reactions are rewritten if they take fewer operations together: dependent speeds replace the expressions that the
constraints give for them, common subexpressions are shared, and lengths are scaled by parameters. Long equations are left as they
are, since the forms differ by little in them:

    Ṙ s₁ + R s s₁  →  … u₅ where the constraints give u₅ = R s s₁;   g sin q + R w,  R x  →  R ((g/R) sin q + w),  R x
    q̇ collected: ẋ = R (u₂ tan q₂ − u₃) cos q₁ for R u₂ cos q₁ tan q₂ − R u₃ cos q₁
    short quotients: I Ω u/(m R² + I) for I Ω u/(R² (m + I/R²))
    ė = ½ Gᵀ ω with ω/2: three halves in the place of four, for each set of Euler parameters
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Literal, NamedTuple

from kane.dynamics.constraints.manifold import PointConstraints, contacts
from kane.dynamics.constraints.partition import Embedding, embedding
from kane.dynamics.derivation import Derived
from kane.dynamics.forcing import LoadTerm, Moving, generalized_by_motion, moving_parts
from kane.dynamics.formulation import classical
from kane.dynamics.formulation.change_of_speeds import ConstraintRates, by_definitions, twins
from kane.dynamics.solved import Solved
from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sum_of
from kane.expr.differentiation import affine_forms
from kane.expr.evaluation import Prices, Together, exceeds, free_symbols, is_constant_in_time, price
from kane.expr.forms.collect import collected, combined
from kane.expr.forms.scales import scaled
from kane.expr.forms.shorter import Products, named, shared
from kane.expr.forms.shorter import with_short_quotients as shortened
from kane.expr.matrix import Matrix
from kane.expr.node import TWO, ZERO, Expr, Exprs, nodes
from kane.expr.ops import ADD, DIV, MUL, NEG, OPS, REGULAR, SUB
from kane.expr.regular import extended, factors
from kane.expr.square_system import square
from kane.expr.symbols import QuasiRate, rate
from kane.expr.visit import remembered, substituting
from kane.kinematics.velocities import ContactPoint, Following, Kinematics, Motion
from kane.kinematics.velocity_constraints import drift_of
from kane.model.declarations import constraint_rate
from kane.space.frame import Point
from kane.space.rotation import Basis
from kane.space.vector import Vector

_STILL = Motion({}, Vector())
"""That of the mass centre of a body about a point at rest, which brings no acceleration."""
LARGE = 800
"""Operations of u̇ above which fewer ways are tried: they differ by little there, and each takes its time."""
_FEW = 6
"""Bodies up to which the accelerations of each are looked for."""


def reactions(
    derived: Derived,
    e: Embedding | None,
    moving: classical.BodyMotions,
    u_dot: Mapping[Expr, Expr],
    matrix: Matrix,
    w: ConstraintRates | None,
    differentiated: bool,
) -> Iterator[tuple[Expr, ...]]:
    """Forms of R, with scalar products along the frames of the partial velocities; several if `differentiated`.

    Accelerations are those of the bodies of `moving` at `u_dot`, or derivatives of velocities if `differentiated`; partial velocities
    are those of all speeds of `derived`. The vanishing speeds of `w` are set to zero.
    """

    def whole(bodies: Sequence[Moving]) -> list[LoadTerm]:
        return [
            LoadTerm(term.place, term.vector.map(w.held) if w else term.vector, derived.kinematics.of(term.place))
            for term in derived.left_by(moving.kinematics, bodies, u_dot)
            if not term.vector.is_zero
        ]

    def solved(
        terms: Sequence[LoadTerm],
        about: Sequence[LoadTerm] | None = None,
        product: Callable[[Vector, Vector], Expr] = _dot_along,
    ) -> tuple[Expr, ...]:
        found = classical.solved_reactions(matrix, _remainders(derived, e, terms, about or terms, product))
        return tuple(map(w.held, found) if w else found)

    def about_rest(bodies: Sequence[Moving]) -> tuple[Expr, ...]:
        pivoted = classical.about_points_at_rest(bodies, derived.kinematics)
        resting = pivoted and whole([f if m is f else f._replace(center=_STILL) for m, f in zip(*pivoted, strict=True)])
        return solved(whole(bodies), resting, Vector.dot)

    if not differentiated:
        yield solved(whole(moving.bodies))
    elif not exceeds(u_dot.values(), LARGE):  # of long systems the ways differ by little
        known = moving.kinematics.with_following(_given(derived, u_dot), {})
        for frame in dict.fromkeys(f for b in moving.bodies if b.rotation for f in b.rotation.frame.lineage):
            yield solved(whole([_along(b, frame, known) for b in moving.bodies]))
        if len(moving.bodies) <= _FEW:
            yield _along_inertial(derived, moving, u_dot, about_rest)


def _given(derived: Derived, u_dot: Mapping[Expr, Expr]) -> dict[Expr, Following]:
    return {u: Following({}, ZERO, u_dot.get(u, ZERO)) for u in derived.speeds}


def _along_inertial(
    derived: Derived,
    moving: classical.BodyMotions,
    u_dot: Mapping[Expr, Expr],
    reactions_of: Callable[[Sequence[Moving]], tuple[Expr, ...]],
) -> tuple[Expr, ...]:
    """R with the accelerations of mass centres along the inertial frame, each if that is shorter."""
    cost = Prices((*derived.rates, *u_dot.values()))
    known = derived.kinematics.with_following(_given(derived, u_dot), moving.kinematics.contacts)
    bodies, best = list(moving.bodies), reactions_of(moving.bodies)
    least = cost(best)
    for k, b in enumerate(moving_parts(derived.inertias, known)):
        other = b._replace(center=b.center.with_bias(b.center.bias.express(derived.system.inertial)))
        tried = [*bodies[:k], other, *bodies[k + 1 :]]
        found = reactions_of(tried)
        if (price_of := cost(found)) < least:
            bodies, best, least = tried, found, price_of
    return best


def _along(b: Moving, frame: Basis, known: Kinematics) -> Moving:
    """The body with the acceleration of its centre as the derivative of v along a frame."""
    if b.rotation is None or frame not in b.rotation.frame.lineage:
        return b
    a = known.turning(b.center.total.express(frame))
    return b._replace(center=Motion({}, Vector(), lambda: a))


def _remainders(
    derived: Derived,
    e: Embedding | None,
    whole: Sequence[LoadTerm],
    about: Sequence[LoadTerm],
    product: Callable[[Vector, Vector], Expr],
) -> tuple[Expr, ...]:
    """ρ_a + A_naᵀ ρ_D by auxiliary speed; ρ_D is computed from the terms `about` points at rest."""

    def rho(s: Expr, terms: Sequence[LoadTerm] = about) -> Expr:
        return neg(generalized_by_motion(terms, s, product))

    own = [rho(a, whole) for a in derived.auxiliary_speeds]
    if e is None or not e.partition.dependent:
        return tuple(own)
    held = [
        rho(derived.speeds[d]) if any(x is not ZERO for x in e.a_na.rows[k]) else ZERO
        for k, d in enumerate(e.partition.dependent)
    ]
    return (Matrix.column(own) + _carried(e, tuple(held))).entries


@remembered
def _carried(e: Embedding, held: tuple[Expr, ...]) -> Matrix:
    """A_naᵀ ρ_D, as −A_aᵀ λ with A_Dᵀ λ = ρ_D if that has no other divisors."""
    if {d.value for d in e.transposed.divisors} <= {d.value for d in e.divisors}:
        multipliers = e.transposed.solve(held)
        return -(e.rows.a_auxiliary.take(e.partition.rows).T @ Matrix.column(multipliers))
    return e.a_na.T @ Matrix.column(held)


def _dot_along(partial: Vector, v: Vector) -> Expr:
    """The scalar product, with v first expressed along the frame of the partial velocity, where other reactions need it too."""
    return partial.dot(v.express(partial.parts[0][0]) if len(partial.parts) == 1 else v)


_TAN = OPS["tan"]


class Variant(NamedTuple):
    """A form of the equations in given speeds."""

    embedding: Literal["after", "before"]
    about: Literal["mass centre", "point at rest"] = "mass centre"
    bias: Literal["accelerations", "momenta", "power", "squares"] = "accelerations"


ASSEMBLED = (Variant("after"),)
"""Forms for loads that depend on reactions."""
LONG = (Variant("before"),)
"""Forms for long equations, in which candidates differ by little and take long to derive."""
DECLARED = (Variant("before"), Variant("after", bias="power"), Variant("before", "point at rest", "momenta"))
"""Forms in the declared speeds, besides the assembled equations."""
BY_RATES = (Variant("after"), Variant("before", bias="momenta"), Variant("before", bias="squares"))
"""Forms with rates of constraints as speeds."""


SPEEDS = ("mass centre", "rates of constraints", "absolute")
"""Speeds beside the declared ones: velocities of the mass centre, rates of constraints, rates of absolute angles."""
DEPENDENT = ("A_n", "definitions", "tree", "rates")
"""Forms of the dependent u̇: by A_n and c_D, by definitions, and by one differentiation, along the tree or of rates as written."""


class Tried(NamedTuple):
    """The choices that the search tries; `benchmarks/ablation.py` leaves single entries out to measure their benefit."""

    speeds: tuple[str, ...] = SPEEDS
    declared: tuple[Variant, ...] = DECLARED
    by_rates: tuple[Variant, ...] = BY_RATES
    dependent: tuple[str, ...] = DEPENDENT


TRIED = Tried()


class Candidate(NamedTuple):
    """A solution in the speeds of `solution.derived`, the motions used, and rates of constraints among the speeds, which vanish."""

    solution: Solved
    moving: classical.BodyMotions | None
    w: ConstraintRates | None = None


def by_rates(
    derived: Derived,
    e: Embedding,
    touching: Sequence[PointConstraints],
    coupled: bool,
    large: bool,
    tried: Tried = TRIED,
) -> Iterator[list[Candidate]]:
    """Candidates with rates of constraints as speeds, a list for each choice of rates."""
    if "rates of constraints" not in tried.speeds:
        return
    choices = ASSEMBLED if coupled else LONG if large else tried.by_rates
    for twin, w in twins(derived, e.partition, touching):
        own = embedding(twin.constraints, e.partition)
        own = own.guarded() if large and not coupled else own  # of what is long next to nothing cancels
        particles = {p: replace(c, directions={}) for p, c in twin.kinematics.contacts.items()}
        every = _candidates(choices, twin, own, particles, coupled)
        yield [Candidate(w.solution(c.solution), c.moving, w) for c in every]


def in_declared_speeds(
    derived: Derived, e: Embedding, touching: Sequence[PointConstraints], large: bool, tried: Tried = TRIED
) -> Iterator[Candidate]:
    """Candidates in the declared speeds, with velocities from contact points."""
    return _candidates(LONG if large else tried.declared, derived, e, contacts(touching, {}, derived.kinematics), False)


def _candidates(
    choices: Sequence[Variant], d: Derived, e: Embedding, particles: Mapping[Point, ContactPoint], coupled: bool
) -> Iterator[Candidate]:
    motions = cache(lambda: classical.embedded_motions(d, e, particles))
    for choice in choices:
        if choice.bias in ("power", "squares"):
            if classical.homogeneous(d, e):
                yield Candidate((classical.power if choice.bias == "power" else classical.squares)(d, e), all_speeds(d))
        elif choice.embedding == "after":
            yield Candidate(classical.unguarded_classical(d, e.partition, e), None if coupled else all_speeds(d))
        else:
            moving = motions()
            resting = choice.about == "point at rest"
            bodies = classical.about_points_at_rest(moving.bodies, moving.kinematics) if resting else None
            yield Candidate(classical.embedded(d, e, moving, bodies, carried=choice.bias == "momenta"), moving)


def all_speeds(derived: Derived) -> classical.BodyMotions:
    """The motions of bodies in all speeds."""
    return classical.BodyMotions(derived.speeds, derived.kinematics, derived.bodies)


# Dependent speeds --------------------------------------------------------------------------------------------------------


def with_dependent(
    derived: Derived, e: Embedding, candidate: Candidate, large: bool, ways: Sequence[str] = DEPENDENT
) -> Iterator[Exprs]:
    """u̇ of all speeds in several forms, with u̇_D from u̇_I of a candidate."""
    solution, w = candidate.solution, candidate.w
    own = [solution.accelerations[i] for i in e.independent]
    if "A_n" in ways and (w is None or not large or candidate.moving is None):
        yield e.every(own)
    if w is not None and "definitions" in ways:
        yield by_definitions(derived, solution.derived, solution.accelerations, w)
    if not large:
        yield from _differentiated(derived, e, own, ways)


def _differentiated(derived: Derived, e: Embedding, u_dot: Sequence[Expr], ways: Sequence[str]) -> Iterator[Exprs]:
    """u̇ of all speeds with u̇_D by one differentiation, along the tree and of rates as written, from u̇_I = `u_dot`."""
    own = dict(zip(e.independent, u_dot, strict=True))
    usual = derived.kinematics
    given = usual.with_following({u: Following({}, ZERO, own.get(i, ZERO)) for i, u in enumerate(derived.speeds)}, {})
    held = [derived.constraints.constraints[r] for r in e.partition.rows]
    solver = square(derived.constraints.a.take(e.partition.rows, e.partition.dependent).rows)

    def solved(right: Sequence[Expr]) -> Exprs:
        values = own | dict(zip(e.partition.dependent, solver.solve(list(map(neg, right))), strict=True))
        return tuple(values[i] for i in range(len(values)))

    if "tree" in ways:
        yield solved([drift_of(c, given, usual) for c in held])
    rates = [constraint_rate(c) for c in held]
    if "rates" in ways and not any(isinstance(s, QuasiRate) for s in free_symbols(rates)):
        by_speeds: dict[Expr, Expr] = {
            rate(q): x for q, x in zip(derived.system.coordinates, derived.rates, strict=True)
        }
        yield solved(list(map(given.drift, map(substituting(by_speeds), rates))))


# Reactions ---------------------------------------------------------------------------------------------------------------


def with_reactions(
    candidate: Candidate, u_dot: Exprs, derived: Derived, e: Embedding | None, differentiated: bool = False
) -> Solved:
    """The solution with this u̇ and the reactions in the shortest form beside it, by `differentiated` velocities or not."""
    s, w = candidate.solution, candidate.w
    values: dict[Expr, Expr] = dict(zip(s.derived.speeds, u_dot if w is None else s.accelerations, strict=True))
    every = [s.reactions] if len(s.reactions) == len(s.derived.reactions) else []
    if s.derived.reactions and candidate.moving is not None:
        every += reactions(s.derived, s.embedding, candidate.moving, values, s.reaction_matrix, w, differentiated)
    rates = derived.rates
    best = _cheapest(every, (*rates, *u_dot), derived, e if differentiated else None)
    whole = replace(s, accelerations=u_dot, reactions=best)
    if e is None or s.embedding is None:
        return whole
    known = e.watching({**s.embedding.guards_in_use, **e.guards_in_use})
    if w is None:
        return replace(whole, derived=derived, embedding=known)
    own = tuple(map(w.held, s.derived.rates))
    if any(x is not y for x, y in zip(own, rates, strict=True)) and divisors(own) <= divisors(rates):
        cost = Prices((*u_dot, *best))
        whole = replace(whole, shorter_rates=own if cost(own) < cost(rates) else None)
    return replace(whole, route="contacts", derived=derived, embedding=known)


def _cheapest(every: Sequence[Exprs], beside: Exprs, derived: Derived, e: Embedding | None) -> Exprs:
    """The expressions with the fewest operations; ties are decided by their operations after shortening, if `e` is given."""
    if len(every) == 1:
        return every[0]
    prices = list(map(Prices(beside), every))
    least = min(prices)
    equal = list({tuple(map(id, x)): x for p, x in zip(prices, every, strict=True) if p == least}.values())[::-1]
    if e is None or len(equal) == 1:
        return equal[0]
    return min(equal, key=lambda x: price(short_forms((*x, *beside), derived, e)))


# What solutions divide by ------------------------------------------------------------------------------------------------


def divisors(exprs: Sequence[Expr]) -> set[Expr]:
    """The divisors of expressions, with their factors, and the cosines of tangents."""
    below = nodes(exprs)
    found = {f for node in below if node.op is DIV for f in factors(node.args[1])}
    found |= {f for node in found if node.op is REGULAR for f in factors(node.args[0])}
    return found | {NODE_BUILDERS["cos"](node.args[0]) for node in below if node.op is _TAN}


def of_embedding(e: Embedding) -> set[Expr]:
    """Divisors that A_n = −A_D⁻¹ A_I certainly has: those of A_I that A_D does not have, as A_D⁻¹ is nonzero where A_D is finite."""
    a = e.rows.a.take(e.partition.rows)
    return divisors(a.take(columns=e.independent).entries) - divisors(a.take(columns=e.partition.dependent).entries)


class Poles:
    """The divisors of the usual solution, computed as far as needed, the cheapest to compute first.

    A candidate must not have divisors of W that the usual solution does not have. Nothing is computed for a candidate without
    divisors of W.
    """

    def __init__(self, *known: Callable[[], set[Expr]]) -> None:
        self._open, self._known = list(known), set[Expr]()

    def fewer(self, derived: Derived, exprs: Sequence[Expr]) -> bool:
        """Whether all divisors of W in expressions are divisors of the usual solution."""
        pivots = {f for p in derived.kinematical.pivots for f in factors(p)}
        moving = {f for f in pivots if not is_constant_in_time([f])}
        divided = moving & divisors(exprs) if moving else moving
        while self._open and not divided <= self._known:
            self._known |= self._open.pop(0)()
        return divided <= self._known


# Short forms ---------------------------------------------------------------------------------------------------------


SHORT = 200
"""Operations above which equations stay as they are."""


def with_short_forms(s: Solved) -> Solved:
    """The solution with shorter u̇, reactions and q̇; to be applied before guards."""
    n, rates = len(s.accelerations), s.rates
    found = short_forms((*s.accelerations, *s.reactions, *rates), s.derived, s.embedding)
    own = found[len(found) - len(rates) :]
    return replace(
        s,
        accelerations=found[:n],
        reactions=found[n : len(found) - len(rates)],
        shorter_rates=s.shorter_rates if all(x is y for x, y in zip(own, rates, strict=True)) else own,
    )


def short_forms(exprs: Sequence[Expr], derived: Derived, e: Embedding | None) -> tuple[Expr, ...]:
    """The expressions rewritten to take fewer operations together; unchanged if they are long."""
    best = Together(exprs)
    if exceeds(best, SHORT):
        return best
    given = _by_constraints(derived, e)
    kept = frozenset(e.guards_in_use) if e else frozenset()
    products = Products(kept)
    ways: dict[str, Callable[[Together], tuple[Expr, ...]]] = {
        "named": lambda x: named(x, given, kept),
        "shared": lambda x: shared(x, kept, products),
        "combined": lambda x: combined(x, kept),
        "scaled": lambda x: scaled(x, kept),
    }
    final: dict[str, Together] = {}
    for name in ("named", "shared", "combined", "scaled", "shared"):
        if final.get(name) is not best:  # else nothing has changed since
            best = final[name] = best.or_shorter(ways[name](best))
    return best


def _by_constraints(derived: Derived, e: Embedding | None) -> dict[Expr, Expr]:
    """The dependent speeds by the expressions that the constraints give for them."""
    if e is None:
        return {}
    own = [derived.speeds[i] for i in e.independent]
    given = map(add, e.a_n @ own, e.b_n)
    return {collected(x): derived.speeds[d] for x, d in zip(given, e.partition.dependent, strict=True) if x.args}


_SUMS = {ADD, SUB, MUL, NEG}


def with_short_rates(s: Solved) -> Solved:
    """The solution with each q̇ in the form that adds the fewest operations to u̇, the reactions and the other q̇."""
    rates, price = list(s.rates), None
    sums = [i for i, x in enumerate(rates) if x.op in _SUMS and any(a.args for a in x.args)]
    for i in sums:
        found = collected(rates[i])
        if found is not rates[i]:
            price = price or Prices((*s.accelerations, *s.reactions))
            tried = [*rates[:i], found, *rates[i + 1 :]]
            rates = tried if price(tried) < price(rates) else rates
    changed = any(x is not y for x, y in zip(rates, s.rates, strict=True))
    return replace(s, shorter_rates=tuple(rates)) if changed else s


def with_short_quotients(s: Solved) -> Solved:
    """The solution with short quotients, if these reduce the operations of u̇, reactions and q̇; to be applied before guards."""
    solved = (*s.accelerations, *s.reactions)
    found = shortened(solved, s.shorter_rates or s.derived.rates)
    if all(x is y for x, y in zip(solved, found, strict=True)):
        return s
    n, e = len(s.accelerations), s.embedding
    if e is not None:
        e = e.watching(extended(e.guards_in_use, found))
    return replace(s, accelerations=found[:n], reactions=found[n:], embedding=e)


def with_half_speeds(s: Solved) -> Solved:
    """The solution with ω/2 shared in ė of Euler parameters, if q̇ then takes fewer operations beside u̇."""
    if not s.derived.system.euler_parameters:
        return s
    place: dict[Expr, int] = {q: i for i, q in enumerate(s.derived.system.coordinates)}
    rates = list(s.rates)
    for group in s.derived.system.euler_parameters:
        own = [place[e] for e in group.coordinates]
        forms = affine_forms([mul(TWO, rates[i]) for i in own], s.derived.speeds)
        if any(rest is not ZERO for _, rest in forms):
            continue
        for i, (form, _) in zip(own, forms, strict=True):
            rates[i] = sum_of(mul(c, div(u, TWO)) for u, c in form.items())
    beside = (*s.accelerations, *s.reactions)
    return replace(s, shorter_rates=tuple(rates)) if price((*rates, *beside)) < price((*s.rates, *beside)) else s

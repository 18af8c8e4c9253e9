# SPDX-License-Identifier: BSD-3-Clause
"""Other methods than Kane's for the same system: equations in their own unknowns and variables, solved, and u̇ from them.

Every method ends in M x = f + Aᵀ λ, A x + c = 0, solved for x, and for λ where it is asked for:

    x = B x_I + d,   (BᵀMB) x_I = Bᵀ(f − M d),   A_Dᵀ λ = (M x − f)_D

Lagrange's equations: of the second kind without multipliers, and with the multipliers of all constraints.

    d/dt(∂T/∂q̇_s) − ∂T/∂q_s = Q_s + Σ_k A_ks λ_k                (Whittaker 1937, ch. II and VIII)

T is differentiated as a function of q and q̇. Where constraints are left, the equations without multipliers are those of Maggi, the
same multiplied by a basis B of the motions that the constraints admit, Σ_s B_sr (… )_s = 0.

Hamilton's canonical equations, with forces that have no potential, and constraints.

    p = ∂T/∂q̇ = M q̇ + g,  H(q, p) = ½ (p − g)ᵀ M⁻¹ (p − g) − T₀,  q̇ = ∂H/∂p,  ṗ = −∂H/∂q + Q + Aᵀ λ

(Hamilton 1835; Whittaker 1937, ch. X). All forces are in Q, those with a potential too: H is that of the kinetic energy. λ follows
from A q̈ + c = 0, with q̈ the derivative of ∂H/∂p.

The equations of Boltzmann and Hamel: Lagrange's, for the declared generalized speeds as rates of quasi-coordinates.

    d/dt(∂T*/∂u_r) + Σ_a (∂T*/∂u_a) Σ_s W_sr (d/dt(∂u_a/∂q̇_s) − ∂u_a/∂q_s) − Σ_s W_sr ∂T*/∂q_s = F_r + Σ_k A_kr λ_k

with T*(q, u); what is in brackets gives Hamel's coefficients γ (Hamel 1904; Neimark & Fufaev 1972, ch. III, sec. 5).

Newton's and Euler's equations of every body, with all constraint forces unknown, in the rates of the coordinates.

    m a − F − R = 0,   I·α + ω × I·ω − T − S = 0     for each body, and R = −F, S = −T where loads act elsewhere
    Σ R·∂v/∂q̇_s + Σ S·∂ω/∂q̇_s = Σ_k A_ks λ_k        constraint forces of ideal joints do no work in admitted motions

R and S, six for each rigid body, are what Kane's method never brings in (Schiehlen 1990, *Advanced Multibody System Dynamics*).

Virtual work and virtual power in generalized coordinates.

Σ (F − m a)·∂r/∂q_s = 0           work: rigid bodies as sets of particles with the same mass, mass centre and inertia,
                                  for an orientation has no r (Yoo 2004, eq. 5)
Σ (F − m a)·∂v/∂q̇_s + Σ (T − I·α − ω × I·ω)·∂ω/∂q̇_s = 0     power (Yoo 2004, eq. 6; Jourdain 1909)

Kane's equations, F̃_r + F̃*_r = 0 (Kane & Levinson 1985, sec. 6.1), are in the form in which the others are compared with them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, NamedTuple

from kane import expect, show
from kane.dynamics.forcing import blocks
from kane.dynamics.formulation.classical import holds_reactions
from kane.dynamics.formulation.recursive import is_regular
from kane.dynamics.in_rates import InRates, LinearConstraints
from kane.dynamics.lazy import read
from kane.dynamics.readings.energy import kinetic_energy_in_speeds
from kane.dynamics.solved import Solved
from kane.errors import ModelError, SingularError, cut
from kane.expr.build import add, mul, neg, sub
from kane.expr.differentiation import affine_forms, gradient, jacobian, time_derivative
from kane.expr.evaluation import Operations, count_operations
from kane.expr.matrix import Matrix, dot, ldl
from kane.expr.node import ZERO, Expr, Exprs, as_expr, constant
from kane.expr.ops import Immutable
from kane.expr.symbols import Reaction, Speed, rate, word
from kane.expr.visit import substituted, substituting
from kane.model.bodies import Part
from kane.space.frame import Frame, Point
from kane.space.rotation import Triple
from kane.space.vector import Vector


@dataclass(frozen=True, eq=False, repr=False)
class Formulation(Immutable):
    """The equations of motion of a system by one method, from `eom.by`.

    `equations` are expressions in the `unknowns` that must be zero. Solved for the unknowns, and without the quantities that
    `eliminated` lists, they give `right_hand_side`, the rates of the variables `state` of the method. `accelerations` are u̇ of
    the declared generalized speeds that follow, in q and u, for comparison between methods.
    """

    method: str
    source: str
    state: Exprs
    unknowns: Exprs
    eliminated: tuple[str, ...]
    equations_by: Callable[[], Exprs]
    right_hand_side_by: Callable[[], Exprs]
    accelerations_by: Callable[[], Exprs]

    equations = read[Exprs](lambda f: f.equations_by(), "Expressions in the unknowns that must be zero.")
    right_hand_side = read[Exprs](lambda f: f.right_hand_side_by(), "The rates of the state.")
    accelerations = read[Exprs](lambda f: f.accelerations_by(), "u̇ of the declared generalized speeds, in q and u.")
    operations = read[Operations](
        lambda f: count_operations(f.right_hand_side), "Operations of one evaluation of the right-hand side."
    )

    def __reduce__(self) -> tuple[Callable[..., "Formulation"], tuple[Any, ...]]:
        written = (self.equations, self.right_hand_side, self.accelerations)
        known = (partial(tuple, exprs) for exprs in written)
        return Formulation, (self.method, self.source, self.state, self.unknowns, self.eliminated, *known)

    def __repr__(self) -> str:
        gone = f"; eliminated: {', '.join(self.eliminated)}" if self.eliminated else ""
        return f"Formulation({self.method}: {len(self.unknowns)} unknowns{gone})"

    def __str__(self) -> str:
        lines = [f"0 = {e}" for e in self.equations]
        return "\n".join([f"{self.method} ({self.source}), in {', '.join(map(str, self.unknowns))}", *lines])

    _repr_html_ = show.html


_SINGULAR = (
    "Expected every coordinate to move a mass, got a mass matrix of the q̇ that is singular everywhere: a coordinate moves none, or "
    "some depend on each other, as Euler parameters do. Use Kane's method, eom.by('kane'), or Lagrange's, eom.by('lagrange')."
)


class SolvedUnknowns(NamedTuple):
    """x and λ."""

    x: Exprs
    multipliers: Exprs


def solve_held(
    mass: Matrix, right: Sequence[Expr], held: LinearConstraints | None, with_multipliers: bool = False
) -> SolvedUnknowns:
    """x with M x = right + Aᵀ λ, A x + c = 0."""
    if held is None:
        return SolvedUnknowns(tuple(definite(mass.rows, right)), ())
    e = held.embedding
    inner = e.reduced(blocks([list(row) for row in mass.rows], right, (), (), {}))
    x = e.every(definite(inner.mass.rows, inner.forcing) if e.independent else ())
    if not with_multipliers:
        return SolvedUnknowns(x, ())
    residual = [sub(dot(mass.rows[d], x), right[d]) for d in held.dependent]
    return SolvedUnknowns(x, tuple(e.transposed.solve(residual)))


def definite(rows: Sequence[Sequence[Expr]], right: Sequence[Expr]) -> list[Expr]:
    """x with M x = right, M symmetric and positive definite; a ModelError where a pivot is zero everywhere."""
    try:
        factors = ldl(rows)
    except SingularError:
        raise ModelError(_SINGULAR) from None
    if not is_regular(factors.pivots):
        raise ModelError(_SINGULAR)
    return factors.solve(right)


def on_constraints(left: Sequence[Expr], held: LinearConstraints | None, x: Sequence[Expr]) -> Exprs:
    """What must vanish: `left`; of constraints Bᵀ `left`, without multipliers, and A x + c."""
    if held is None:
        return tuple(left)
    return (*held.embedding.transposed_times(Matrix.column(left)).entries, *constrained(held, x))


def constrained(held: LinearConstraints, x: Sequence[Expr]) -> Exprs:
    """A x + c."""
    return tuple(add(dot(row, x), c) for row, c in zip(held.a.rows, held.drift, strict=True))


def elimination_notes(held: LinearConstraints | None, how: str = "a basis of the admitted motions") -> tuple[str, ...]:
    """What is said of multipliers that are eliminated."""
    if held is None:
        return ()
    count = len(held.names)
    return (f"{count} multiplier{'s' * (count > 1)}, by {how}",)


def solved_for(
    unknowns: Sequence[Expr], left: Sequence[Expr], held: LinearConstraints | None, with_multipliers: bool = False
) -> SolvedUnknowns:
    """The unknowns with `left` = Aᵀ λ, which is affine in them, and A x + c = 0."""
    forms = affine_forms(left, unknowns)
    mass = Matrix([[form.get(x, ZERO) for x in unknowns] for form, _ in forms])
    return solve_held(mass, [neg(rest) for _, rest in forms], held, with_multipliers)


def in_accelerations(
    s: InRates,
    name: str,
    source: str,
    inertia: Callable[[], Exprs],
    gone: tuple[str, ...] = (),
    multipliers: tuple[Expr, ...] = (),
) -> Formulation:
    """The formulation `inertia` − Q = Aᵀ λ in the unknowns q̈ and, where they are named, the multipliers λ."""
    left = cache(lambda: tuple(sub(e, q) for e, q in zip(inertia(), s.forces, strict=True)))
    solution = cache(lambda: solved_for(s.accelerations, left(), s.held, bool(multipliers)))

    def equations() -> Exprs:
        if s.held is None or not multipliers:
            return on_constraints(left(), s.held, s.accelerations)
        with_forces = (sub(e, dot(column, multipliers)) for e, column in zip(left(), s.held.a.T, strict=True))
        return (*with_forces, *constrained(s.held, s.accelerations))

    return Formulation(
        name,
        source,
        (*s.coordinates, *s.rates),
        (*s.accelerations, *multipliers),
        gone if multipliers else (*gone, *elimination_notes(s.held)),
        equations,
        lambda: (*s.rates, *solution().x, *solution().multipliers),
        lambda: s.speeds_rates(solution().x),
    )


# Lagrange, Hamilton, Boltzmann and Hamel ---------------------------------------------------------------------------------

_LAGRANGE = "Lagrange 1788; Whittaker 1937, ch. II and VIII"


def second_kind(s: InRates) -> Formulation:
    """Without multipliers."""
    return in_accelerations(s, "Lagrange, second kind", _LAGRANGE, lambda: s.lagrange_terms(s.kinetic_energy))


def first_kind(s: InRates) -> Formulation:
    """With a multiplier for each constraint, which is solved for, too."""
    return in_accelerations(
        s, "Lagrange, first kind", _LAGRANGE, lambda: s.lagrange_terms(s.kinetic_energy), (), multipliers_of(s)
    )


def multipliers_of(s: InRates) -> tuple[Reaction, ...]:
    """λ of each constraint."""
    names = s.held.names if s.held is not None else ()
    return tuple(Reaction.declare(f"lambda{k}", None, "", f"multiplier of {name}") for k, name in enumerate(names, 1))


def canonical(s: InRates) -> Formulation:
    """q̇ and ṗ by q and p."""
    h = _Canonical(s)
    gone = ("q̇, by p = ∂T/∂q̇", *elimination_notes(s.held, "derivatives of the constraints"))
    multipliers = multipliers_of(s)

    def equations() -> Exprs:
        left = [sub(rate(p), x) for p, x in zip(h.p, h.active, strict=True)]
        rates = tuple(sub(q, v) for q, v in zip(s.rates, h.velocities, strict=True))
        if s.held is None:
            return (*rates, *left)
        left = [sub(e, dot(column, multipliers)) for e, column in zip(left, s.held.a.T, strict=True)]
        return (*rates, *left, *s.held.rates)

    return Formulation(
        "Hamilton",
        "Hamilton 1835; Whittaker 1937, ch. X",
        (*s.coordinates, *h.p),
        (*s.rates, *map(rate, h.p), *multipliers),
        gone,
        equations,
        lambda: (*h.velocities, *h.forces),
        lambda: s.speeds_rates(h.in_rates(h.accelerations)),
    )


@dataclass(frozen=True, eq=False)
class _Canonical:
    """What is written in q and p."""

    s: InRates

    p = read[tuple[Speed, ...]](
        lambda h: tuple(
            Speed.declare(f"p_{q.name}", None, "", f"generalized momentum of {q.name}") for q in h.s.coordinates
        ),
        "p.",
    )
    momenta = read[Exprs](lambda h: gradient(h.s.kinetic_energy, h.s.rates), "∂T/∂q̇ in q and q̇.")

    @read
    def mass(self) -> tuple[Matrix, Exprs]:
        """M and g of p = M q̇ + g."""
        forms = affine_forms(self.momenta, self.s.rates)
        rows = [[form.get(r, ZERO) for r in self.s.rates] for form, _ in forms]
        return Matrix(rows), tuple(rest for _, rest in forms)

    @read
    def velocities(self) -> Exprs:
        """q̇ = M⁻¹ (p − g)."""
        m, g = self.mass
        return tuple(definite(m.rows, [sub(p, x) for p, x in zip(self.p, g, strict=True)]))

    @read
    def hamiltonian(self) -> Expr:
        """½ (p − g)·q̇ − T₀."""
        _, g = self.mass
        still = substituted(self.s.kinetic_energy, dict.fromkeys(self.s.rates, ZERO))
        return sub(mul(constant(0.5), dot([sub(p, x) for p, x in zip(self.p, g, strict=True)], self.velocities)), still)

    @read
    def by_momenta(self) -> dict[Expr, Expr]:
        """q̇ by q and p."""
        return dict(zip(self.s.rates, self.velocities, strict=True))

    @read
    def active(self) -> Exprs:
        """−∂H/∂q + Q."""
        slopes = gradient(self.hamiltonian, self.s.coordinates)
        own = [substituted(q, self.by_momenta) for q in self.s.forces]
        return tuple(add(neg(h), q) for h, q in zip(slopes, own, strict=True))

    @read
    def _solution(self) -> tuple[Exprs, Exprs]:
        """q̈ and λ of M q̈ = −∂H/∂q + Q + Aᵀλ + M (what is left of d/dt M⁻¹(p − g) at ṗ = 0)."""
        m, _ = self.mass
        still: dict[Expr, Expr] = dict.fromkeys(map(rate, self.p), ZERO)
        changes = [substituted(substituted(time_derivative(v), still), self.by_momenta) for v in self.velocities]
        right = [add(f, x) for f, x in zip(self.active, m @ changes, strict=True)]
        held = self.s.held
        if held is not None:
            held = replace(
                held,
                a=held.a.map(lambda e: substituted(e, self.by_momenta)),
                drift=tuple(substituted(e, self.by_momenta) for e in held.drift),
            )
        x, multipliers = solve_held(m, right, held, with_multipliers=True)
        return x, multipliers

    accelerations = read[Exprs](lambda h: h._solution[0], "q̈.")

    @read
    def forces(self) -> Exprs:
        """ṗ."""
        held = self.s.held
        if held is None:
            return self.active
        return tuple(add(f, dot(column, self._solution[1])) for f, column in zip(self.active, held.a.T, strict=True))

    def in_rates(self, exprs: Exprs) -> Exprs:
        """Expressions in q and q̇."""
        values: dict[Expr, Expr] = dict(zip(self.p, self.momenta, strict=True))
        return tuple(map(substituting(values), exprs))


def boltzmann_hamel(s: InRates) -> Formulation:
    """By the declared speeds."""
    d, p = s.derived, s.partition
    if d.system.euler_parameters:
        raise ModelError(
            "Expected independent coordinates, got Euler parameters: Hamel's coefficients are defined for independent ones. Orient "
            "the frame by three angles, or use eom.by('lagrange')."
        )
    u_dot = tuple(map(rate, d.speeds))
    held = None
    gone = ("Hamel's coefficients γ, from derivatives of Y",)
    if p is not None and p.rows:
        own = sorted(p.rows)
        rows = d.constraints
        held = LinearConstraints(
            rows.a.take(own),
            tuple(rows.drift[r] for r in own),
            tuple(p.dependent),
            tuple(rows.constraints[r].name for r in own),
            tuple(d.constraint_rates[r] for r in own),
        )

    left = cache(lambda: _hamel_left(s))
    solution = cache(lambda: solved_for(u_dot, left(), held).x)
    return Formulation(
        "Boltzmann–Hamel",
        "Hamel 1904; Neimark & Fufaev 1972, ch. III",
        (*s.coordinates, *d.speeds),
        u_dot,
        (*gone, *elimination_notes(held)),
        lambda: on_constraints(left(), held, u_dot),
        lambda: (*d.rates, *solution()),
        solution,
    )


def _hamel_left(s: InRates) -> Exprs:
    """The left sides less F_r, in u̇."""
    d = s.derived
    energy = kinetic_energy_in_speeds(d.bodies)
    n = len(d.speeds)
    slopes = gradient(energy, (*d.speeds, *s.coordinates))
    momenta, sideways = slopes[:n], slopes[n:]
    by_speeds = substituting(s.by_speeds)
    brackets = [list(map(by_speeds, s.lagrange_terms(definition))) for definition in d.system.speeds.values()]
    found = []
    for r, (p, force) in enumerate(zip(momenta, d.Fr[:n], strict=True)):
        column = [row[r] for row in d.W.rows]
        total = sub(by_speeds(time_derivative(p)), dot(column, sideways))
        for a, bracket in zip(momenta, brackets, strict=True):
            total = add(total, mul(a, dot(column, bracket)))
        found.append(sub(total, force))
    return tuple(found)


# Newton and Euler, virtual work and power --------------------------------------------------------------------------------


def newton_euler(s: InRates) -> Formulation:
    """With the constraint force at every place."""
    e = _Everywhere(s)
    count = 3 * len(e.balances)
    return Formulation(
        "Newton–Euler",
        "Newton 1687; Euler 1776; Schiehlen 1990",
        (*s.coordinates, *s.rates),
        (*s.accelerations, *e.unknown),
        (f"{count} measure numbers of constraint forces and torques, by their power",),
        lambda: e.equations,
        lambda: (*s.rates, *e.accelerations, *e.forces),
        lambda: s.speeds_rates(e.accelerations),
    )


@dataclass(frozen=True, eq=False)
class _Everywhere:
    """Inertia less loads at every place: mass centres and frames of bodies, and where else loads act."""

    s: InRates

    @read
    def balances(self) -> dict[Point | Frame, Vector]:
        """m a − F, I·α + ω × I·ω − T by place, in q̈."""
        found: dict[Point | Frame, Vector] = {}
        for place, v in self.s.inertia():
            found[place] = found.get(place, Vector()) + v
        for place, v in self.s.acting():
            found[place] = found.get(place, Vector()) - v
        return {place: v.gathered() for place, v in found.items()}

    @read
    def measured(self) -> Exprs:
        """The balances along the axes of the inertial frame, of torques along those of their frame."""
        inertial = self.s.derived.system.inertial
        return tuple(
            x
            for place, v in self.balances.items()
            for x in v.components(place if isinstance(place, Frame) else inertial)
        )

    @read
    def unknown(self) -> tuple[Reaction, ...]:
        """R and S by place and axis."""
        return tuple(
            Reaction.declare(
                f"{'S' if isinstance(place, Frame) else 'R'}_{word(place.name)}_{axis}", None, "", "of the constraints"
            )
            for place in self.balances
            for axis in "xyz"
        )

    @read
    def _works(self) -> Exprs:
        """What balances do for each rate."""
        return self.s.power_by(iter(self.balances.items()))

    @read
    def equations(self) -> Exprs:
        """The balances, and that constraint forces do no work."""
        own = [sub(b, r) for b, r in zip(self.measured, self.unknown, strict=True)]
        inertial, places = self.s.derived.system.inertial, list(self.balances)
        vectors = []
        for k, place in enumerate(places):
            x, y, z = self.unknown[3 * k : 3 * k + 3]
            vectors.append((place, Vector(((place if isinstance(place, Frame) else inertial, (x, y, z)),))))
        return (*own, *on_constraints(self.s.power_by(iter(vectors)), self.s.held, self.s.accelerations))

    @read
    def accelerations(self) -> Exprs:
        """q̈."""
        return solved_for(self.s.accelerations, self._works, self.s.held).x

    @read
    def forces(self) -> Exprs:
        """R and S."""
        values: dict[Expr, Expr] = dict(zip(self.s.accelerations, self.accelerations, strict=True))
        return tuple(map(substituting(values), self.measured))


def virtual_power(s: InRates) -> Formulation:
    """By partial velocities and partial angular velocities for q̇."""
    return in_accelerations(s, "virtual power", "Jourdain 1909; Yoo 2004, eq. 6", lambda: s.power_by(s.inertia()))


def virtual_work(s: InRates) -> Formulation:
    """By positions of particles."""
    count = sum(1 for part in s.parts for _ in _particles(part))
    gone = (f"rigid bodies, by {count} particles that move as they do",)
    return in_accelerations(s, "virtual work", "d'Alembert 1743; Yoo 2004, eq. 5", lambda: _works(s), gone)


def _particles(part: Part) -> Iterator[tuple[Expr, Vector]]:
    """Masses and places from the mass centre of particles a metre off, with the same mass, mass centre and central inertia.

    With E = ½ tr(I) 1 − I: E_ii/2 at ± e_i, E_ij/4 at ±(e_i + e_j), −E_ij/4 at ±(e_i − e_j), the rest of the mass at the centre.
    """
    left = part.mass
    if part.frame is not None and part.inertia is not None:
        axes = (part.frame.x, part.frame.y, part.frame.z)
        rows = [[a.dot(part.inertia.dot(b)) for b in axes] for a in axes]
        half = mul(constant(0.5), add(add(rows[0][0], rows[1][1]), rows[2][2]))
        for i in range(3):
            e = sub(half, rows[i][i])
            left = sub(left, e)
            for sign in (1, -1):
                yield e / 2, axes[i] * as_expr(sign)
            for j in range(i):
                if rows[i][j] is not ZERO:
                    e = neg(rows[i][j])
                    for sign in (1, -1):
                        yield e / 4, (axes[i] + axes[j]) * as_expr(sign)
                        yield neg(e / 4), (axes[i] - axes[j]) * as_expr(sign)
    yield left, Vector()


def _works(s: InRates) -> Exprs:
    """Σ m a·∂r/∂q."""
    total = [ZERO] * len(s.coordinates)
    for part in s.parts:
        for r, carried in _carried(s, part):
            columns = jacobian(list(r), s.coordinates).T
            for mass, x in carried:
                a = [s.own(time_derivative(s.own(time_derivative(c)))) for c in x]
                for k, column in enumerate(columns):
                    total[k] = add(total[k], mul(mass, dot(column, a)))
    return tuple(total)


def _carried(s: InRates, part: Part) -> Iterator[tuple[Triple, list[tuple[Expr, Triple]]]]:
    """Places of particles, each with the masses and places that its m a is a sum of."""
    if part.momenta:
        yield _position(s, part.mass_center), [(mass, _position(s, p)) for p, mass in part.momenta]
        return
    for mass, arm in _particles(part):
        r = _position(s, part.mass_center, arm)
        yield r, [(mass, r)]


def _position(s: InRates, point: Point, arm: Vector = Vector()) -> Triple:  # noqa: B008, vectors are frozen
    inertial, root = s.derived.system.inertial, point.root()
    if root.frame is not inertial:
        raise ModelError(
            f"Expected positions from a point of {inertial.name}, got {point.name} placed from {root.name} of {root.frame}."
        )
    return (point.position(root) + arm).components(inertial)


# The methods by name -----------------------------------------------------------------------------------------------------


def kane(solved: Solved) -> Formulation:
    """By the declared generalized speeds, the dependent ones from the start by the others."""
    d = solved.derived
    count = len(solved.dependent_speeds)
    gone = (f"{count} dependent speed{'s' * (count > 1)}, by u_D = A_n u_I + b_n",) if count else ()
    own = len(solved.independent_speeds)
    return Formulation(
        "Kane",
        "Kane & Levinson 1985, sec. 6.1",
        d.state,
        tuple(map(rate, solved.independent_speeds)),
        gone,
        lambda: tuple(map(add, solved.Fr_nh[:own], solved.Fr_star_nh[:own])),
        lambda: solved.right_hand_side,
        lambda: solved.accelerations,
    )


OTHERS: Mapping[str, Callable[[InRates], Formulation]] = {
    "lagrange": second_kind,
    "lagrange first kind": first_kind,
    "hamilton": canonical,
    "boltzmann-hamel": boltzmann_hamel,
    "newton-euler": newton_euler,
    "virtual work": virtual_work,
    "virtual power": virtual_power,
}
"""Formulations in coordinates, by name."""

METHODS = ("kane", *OTHERS)
"""The names."""


def formulation(solved: Solved, method: str) -> Formulation:
    """The equations of what is solved by Kane's method, by the method of this name."""
    expect.one_of(method, METHODS, "a method,")
    if method == "kane":
        return kane(solved)
    if solved.derived.states:
        raise ModelError(
            f"Expected a system without further states for {cut(method)!r}, got "
            f"{', '.join(map(str, solved.derived.states))}, which are not part of the equations of motion. Declare them as inputs, "
            "kn.input, to compare methods."
        )
    if holds_reactions(solved.derived):
        raise ModelError(
            "Expected loads that contain no reaction, got friction or another one that does: methods that eliminate constraint forces "
            "from the start do not determine it. Kane's, with the reaction in evidence, solves for both: use eom itself."
        )
    partition = None if solved.embedding is None else solved.embedding.partition
    return OTHERS[method](InRates(solved.derived, partition))

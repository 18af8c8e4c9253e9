# SPDX-License-Identifier: BSD-3-Clause
"""Changes of speeds: generalized speeds in which the equations are shorter, or regular at false poles of W.

Results are transformed back to the declared speeds.

*Absolute rates.* If frames rotate about parallel axes by θ₁, θ₁ + θ₂, …, the rate of each angle moves every later link. With
Ω = θ̇₁ + θ̇₂ + … instead of the last of these rates each speed rotates one link. The declared speeds and u̇ are sums and differences.

*Rates of constraints.* Dependent speeds are replaced by the rates w = A_q q̇ + b_q of constraints (no slip, contact, a blade): in the
speeds (u_I, w) the constraints are w = 0, and q̇ follows from [Y_I; A_q]. If the w are all components of the velocity of a contact
point Ĉ of a body, velocities of the body are computed from it,

    v^X = v^Ĉ + ω × r = Σ n w + ω × r

(Kane & Levinson 1985, sec. 2.7 and 2.13). The declared dependent speeds are u_D = Y_D q̇ + z_D at these rates,
u_D = A_n u_I + A_na u_a + b_n with w = −A_a u_a; u_D of the state occur only in loads that were declared with them.

*Velocities of the mass centre.* If speeds u_k translate the only body along directions n_k fixed in the inertial frame, they are
replaced by w_k = v^C*·n_k of its mass centre C*. The other partial velocities of C* are then perpendicular to all n_k, the rows of
the w_k in M contain the mass alone, and the acceleration of C* along n_k is ẇ_k. Loads are written in the declared speeds, and

    u̇_k = ẇ_k − n_k·(Σ v_r u̇_r + a_b)        with v_r of the other speeds and a_b of C*.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from itertools import combinations
from typing import NamedTuple

from kane.dynamics.constraints.manifold import PointConstraints, contacts
from kane.dynamics.constraints.partition import DependentSpeeds, Embedding, Partition, embedding
from kane.dynamics.derivation import Derived, by_other_speeds, check_mass
from kane.dynamics.forcing import blocks, generalized_by_motion, mass_rows
from kane.dynamics.formulation.classical import block_solution, classical
from kane.dynamics.solved import Solved
from kane.errors import KaneError
from kane.expr.build import add, mul, neg, sub
from kane.expr.differentiation import affine_forms
from kane.expr.evaluation import is_constant_in_time
from kane.expr.matrix import Matrix, determinant, dot
from kane.expr.node import ONE, ZERO, Expr, Exprs, constant_value, nodes
from kane.expr.symbols import Speed, rate
from kane.expr.visit import substituted, substituting
from kane.kinematics.velocities import velocity_form
from kane.kinematics.velocity_constraints import ConstraintRows, constraint_rows
from kane.model.declarations import constraint_rate
from kane.space.frame import Point
from kane.space.vector import Vector

Row = dict[int, Expr]
"""Numbers by the places of speeds."""

_UNITS = {ONE, neg(ONE)}


class Absolute(NamedTuple):
    """A system `derived` in absolute rates, their `values` in the declared speeds, and the declared speeds in them, by index."""

    derived: Derived
    values: Mapping[Expr, Expr]
    rows: Mapping[int, Row]

    def declared(self, found: Solved, d: Derived, partition: Partition | None) -> Solved:
        """The solution `found`, transformed to the speeds of `d`."""
        state = substituting(self.values)
        by_state = found.mapped(state)
        own, rates, e = by_state.accelerations, found.shorter_rates, found.embedding
        return replace(
            by_state,
            derived=d,
            accelerations=tuple(_combination(self.rows[i], own) if i in self.rows else x for i, x in enumerate(own)),
            embedding=embedding(d.constraints, partition).watching(e.guards_in_use) if e and partition else None,
            shorter_rates=rates and tuple(map(state, rates)),
        )


def absolute(d: Derived, partition: Partition | None) -> Absolute | None:
    """The system in absolute rates; None if no frame rotates about the axis of its base by a rate that is a speed."""
    sums = _sums_of_rates(d)
    rows = _inverse(sums)
    while sums and (lost := _exchanged(rows, d, partition)):
        del sums[lost[0]]
        rows = _inverse(sums)
    if not sums:
        return None
    names = {k: Speed.declare(f"Omega_{d.speeds[k].name}", None, "", "absolute rate") for k in sums}
    declared = list(d.system.speeds.values())
    definitions = {
        names.get(i, u): _combination(sums[i], declared) if i in sums else declared[i] for i, u in enumerate(d.speeds)
    }
    twin = by_other_speeds(d, definitions, d.constraints, matched=d.kinematical.nontrivial)
    constraints = constraint_rows(d.constraints.constraints, twin.kinematics, d.auxiliary_speeds)
    return Absolute(
        replace(twin, constraints=constraints), {names[k]: _combination(row, d.speeds) for k, row in sums.items()}, rows
    )


def _sums_of_rates(d: Derived) -> dict[int, Row]:
    """The sums Ω of speeds, by the index of the last speed in each."""
    places: dict[Expr, int] = {rate: i for i, rate in enumerate(d.system.speeds.values())}
    seen: set[Expr] = set()
    result: dict[int, Row] = {}
    for basis in dict.fromkeys(d.kinematics.aligned.rates(f)[0] for f in d.system.frames):
        o = basis.orientation
        if o is None or o.axis is None:
            continue
        ((form, _),) = affine_forms([o.rates[o.axis]], d.kinematical.rates)
        new = [rate for rate in form if rate not in seen]
        seen.update(new)
        row = {places[rate]: c for rate, c in form.items() if rate in places}
        if len(new) == 1 and len(row) == len(form) > 1 and new[0] in places and all(c in _UNITS for c in row.values()):
            result[places[new[0]]] = dict(sorted(row.items()))
    return result


def _inverse(sums: Mapping[int, Row]) -> dict[int, Row]:
    """The replaced speeds in absolute rates and the other speeds: u_k = ±(Ω_k − Σ c_j u_j)."""
    rows: dict[int, Row] = {}
    for k, total in sums.items():
        row = {k: ONE}
        for j, c in total.items():
            if j != k:
                for i, x in rows.get(j, {j: ONE}).items():
                    row[i] = sub(row.get(i, ZERO), mul(c, x))
        rows[k] = {i: mul(total[k], x) for i, x in row.items() if x is not ZERO}
    return rows


def _exchanged(rows: Mapping[int, Row], d: Derived, partition: Partition | None) -> list[int]:
    """The independent speeds whose replacement would change the determinants that the dependent speeds are solved by."""
    if partition is None:
        return []
    dependent, a = set(partition.dependent), d.constraints.a.take(partition.rows)
    return [
        k
        for k, row in rows.items()
        if k not in dependent
        and not dependent.isdisjoint(row)
        and any(x is not ZERO for x in a.take(columns=[k]).entries)
    ]


def _combination(row: Row, values: Sequence[Expr]) -> Expr:
    return reduce(add, (mul(c, values[i]) for i, c in row.items()), ZERO)


@dataclass(frozen=True, slots=True, eq=False)
class ConstraintRates:
    """The rates w of constraints as speeds: `rows` are constraints by the index of the speed replaced, `speeds` the w by row."""

    rows: Mapping[int, int]
    speeds: Mapping[int, Speed]
    vanishing: Mapping[Expr, Expr]
    _memo: dict[Expr, Expr] = field(default_factory=dict)

    def held(self, e: Expr) -> Expr:
        """An expression at w = ẇ = 0, on the constraints."""
        return substituted(e, self.vanishing, self._memo)

    def solution(self, found: Solved) -> Solved:
        """A solution at w = ẇ = 0; the same object if it contains no w."""
        roots = (*found.accelerations, *found.reactions, *found.pivots, *found.reaction_matrix.entries)
        return (
            found.mapped(self.held)
            if nodes((*roots, *found.bare_reaction_matrix.entries)) & self.vanishing.keys()
            else found
        )

    def definitions(self, derived: Derived) -> dict[Speed, Expr]:
        """The definitions of the speeds, with those replaced by w, in the rates of the coordinates."""
        constraints = derived.constraints.constraints
        result: dict[Speed, Expr] = {}
        for i, (u, definition) in enumerate(derived.system.speeds.items()):
            row = self.rows.get(i)
            result[u if row is None else self.speeds[row]] = (
                definition if row is None else constraint_rate(constraints[row])
            )
        return result

    def row(self, constraint: int, count: int) -> list[Expr]:
        """The row w = 0 of a constraint in `count` speeds; zeros for a constraint without a rate."""
        return [ONE if self.rows.get(j) == constraint else ZERO for j in range(count)]


def constraint_rates(rows: Mapping[int, int]) -> ConstraintRates:
    """New speeds for the rates of constraints, `rows` by the index of the speed replaced."""
    w = {r: Speed.declare(f"w{k + 1}", None, "", "rate of a constraint") for k, r in enumerate(rows.values())}
    return ConstraintRates(rows, w, {x: ZERO for s in w.values() for x in (s, rate(s))})


def twins(
    derived: Derived, partition: Partition, held: Sequence[PointConstraints]
) -> Iterator[tuple[Derived, ConstraintRates]]:
    """The system with rates of motion constraints as speeds: of all of them together, then of those of each point alone."""
    constraints = derived.constraints.constraints
    moving = [t for t in held if any(constraints[r].kind == "motion" for r in t.rows)]
    for chosen in (moving, *([t] for t in moving if len(moving) > 1)) if moving else ():
        rows = _given(derived.constraints.a, partition, [r for t in chosen for r in t.rows])
        if rows is not None:
            w = constraint_rates(rows)
            try:
                yield _by_contacts(derived, w, chosen), w
            except KaneError:  # these speeds do not determine the rates
                continue


def _given(a: Matrix, partition: Partition, rows: Sequence[int]) -> dict[int, int] | None:
    """Dependent speeds, with a row for each, that some constraints determine with constant divisors; None if there are none."""
    for dependent in combinations(partition.dependent, len(rows)):
        size = determinant(a.take(rows, dependent).rows)
        if size is not ZERO and is_constant_in_time([size]):
            return dict(zip(dependent, rows, strict=True))
    return None


def _by_contacts(derived: Derived, w: ConstraintRates, chosen: Sequence[PointConstraints]) -> Derived:
    """The system in speeds with w, with the rows w = 0 and contact points of the constraints `chosen`."""
    known = contacts(chosen, w.speeds, derived.kinematics)
    twin = by_other_speeds(derived, w.definitions(derived), derived.constraints, known)
    constraints, (m, n) = derived.constraints.constraints, derived.constraints.a.shape
    others = [r for r in range(m) if r not in w.speeds]
    rows = constraint_rows([constraints[r] for r in others], twin.kinematics, derived.auxiliary_speeds)
    a = [w.row(r, n) for r in range(m)]
    for k, r in enumerate(others):
        a[r] = list(map(w.held, rows.a.rows[k]))

    def every(own: Exprs) -> Exprs:
        by_row = dict(zip(others, own, strict=True))
        return tuple(w.held(by_row.get(r, ZERO)) for r in range(m))

    own = replace(derived.constraints, a=Matrix(a, (m, n)), b=every(rows.b), differentiated=lambda: every(rows.drift))
    return replace(twin, constraints=own)


def by_definitions(derived: Derived, twin: Derived, u_dot: Exprs, w: ConstraintRates) -> Exprs:
    """u̇ of all declared speeds; those replaced by w follow from the derivatives of their definitions."""
    values, speeds = list(u_dot), derived.speeds
    forms = twin.kinematical.forms([derived.system.speeds[speeds[i]] for i in w.rows])
    for i, form in zip(w.rows, forms, strict=True):
        value, rest = ZERO, form.rest
        for j, u in enumerate(speeds):
            if j not in w.rows and u in form.coefficients:
                c = form.coefficients[u]
                value, rest = add(value, mul(c, u_dot[j])), add(rest, mul(c, u))
        values[i] = add(value, w.held(twin.kinematics.drift(rest)))
    return tuple(values)


def constraint_speeds(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ and the reactions without false poles of W; without constraints by the classical formulation."""
    if partition is None:
        return classical(derived, partition)
    w = constraint_rates(dict(zip(partition.dependent, partition.rows, strict=True)))
    twin = classical(_by_constraints(derived, w), partition)
    e = _embedding_by_rates(derived, partition, twin.derived, w)
    found = twin.mapped(w.held)
    own = [found.accelerations[i] for i in e.independent]
    return replace(
        found,
        route="constraint speeds",
        derived=derived,
        embedding=e,
        accelerations=e.every(own),
        twin=twin,
        vanishing=w.vanishing,
    )


def _by_constraints(derived: Derived, w: ConstraintRates) -> Derived:
    """The system with the dependent speeds replaced by the rates of the constraints."""
    rows = derived.constraints
    m, n = rows.a.shape
    nothing = (ZERO,) * m
    held = ConstraintRows(
        rows.constraints, Matrix([w.row(r, n) for r in range(m)], (m, n)), rows.a_auxiliary, nothing, lambda: nothing
    )
    return by_other_speeds(derived, w.definitions(derived), held)


def _embedding_by_rates(derived: Derived, partition: Partition, twin: Derived, w: ConstraintRates) -> Embedding:
    """The embedding of the declared dependent speeds: A_n and b_n from Y_D q̇ + z_D with q̇ of `twin`."""
    speeds = derived.speeds
    free = partition.independent(len(speeds))
    definitions = [derived.system.speeds[speeds[d]] for d in partition.dependent]
    forms = twin.kinematical.forms(definitions)
    released = derived.constraints.a_auxiliary.take(partition.rows)  # w = −A_a u_a
    by_w = Matrix([[f.coefficients.get(s, ZERO) for s in w.speeds.values()] for f in forms])
    a_n = Matrix([[f.coefficients.get(speeds[i], ZERO) for i in free] for f in forms], (len(forms), len(free)))
    own = [speeds[i] for i in free]
    b_n = tuple(f.rest for f in forms)
    drift = tuple(w.held(twin.kinematics.drift(add(dot(row, own), b))) for row, b in zip(a_n, b_n, strict=True))
    solution = DependentSpeeds(a_n, -(by_w @ released), b_n, lambda: drift)
    return Embedding(derived.constraints, partition, free, lambda: solution)


def by_mass_centre(derived: Derived) -> tuple[Derived, Solved] | None:
    """The system in velocities of the mass centre, and its solution; None if no speeds translate the only body.

    The solution has no guards of divisors.
    """
    moved = _translating(derived)
    if moved is None:
        return None
    centre, directions = moved
    names = {u: Speed.declare(f"w{k + 1}", None, "", "velocity of the mass centre") for k, u in enumerate(directions)}
    velocity = centre.velocity(derived.system.inertial)
    definitions = {
        names.get(u, u): velocity.dot(directions[u]) if u in directions else e for u, e in derived.system.speeds.items()
    }
    twin = by_other_speeds(derived, definitions, derived.constraints)
    left = derived.left_by(twin.kinematics, twin.bodies)
    right = [generalized_by_motion(left, s) for s in twin.all_speeds]
    mass = mass_rows(twin.bodies, twin.speeds, twin.auxiliary_speeds)
    equations = blocks(mass, right, twin.auxiliary_speeds, twin.reactions, twin.pairs)
    check_mass(derived.system, derived.speeds, equations.mass)
    solution = block_solution(equations)
    own = velocity_form(derived.kinematics.point(centre))
    values: dict[Expr, Expr] = {names[u]: own.dot(n) for u, n in directions.items()}
    by_declared = substituting(values)
    u_dot: dict[Expr, Expr] = dict(zip(derived.speeds, map(by_declared, solution.accelerations), strict=True))
    solution = solution._replace(
        accelerations=_declared_accelerations(derived, centre, directions, u_dot),
        reactions=tuple(map(by_declared, solution.reactions)),
    )
    return twin, Solved("mass centre", derived, None, *solution)


def _translating(derived: Derived) -> tuple[Point, dict[Speed, Vector]] | None:
    """The mass centre of the only body, and the speeds that translate it, with their directions; None if there are none."""
    if len(derived.bodies) != 1:
        return None
    ((_, part, centre, rotation, shared),) = derived.bodies
    if rotation is None or shared:
        return None
    turns, shifts = rotation.motion.partials, centre.partials
    directions = {u: shifts[u] for u in derived.speeds if u in shifts and u not in turns and _fixed(derived, shifts[u])}
    found = list(directions.values())
    apart = all(a.dot(b) is (ONE if a is b else ZERO) for a in found for b in found)
    others = any(u in shifts for u in derived.speeds if u in turns)
    return (part.mass_center, directions) if found and apart and others else None


def _fixed(derived: Derived, v: Vector) -> bool:
    """Whether a vector has a constant direction in the inertial frame."""
    return all(
        f is derived.system.inertial and all(constant_value(x) is not None for x in triple) for f, triple in v.parts
    )


def _declared_accelerations(
    derived: Derived, centre: Point, directions: Mapping[Speed, Vector], u_dot: Mapping[Expr, Expr]
) -> Exprs:
    """u̇ of the declared speeds, u̇_k = ẇ_k − n_k·(Σ v_r u̇_r + a_b) for those replaced."""
    motion = derived.kinematics.point(centre)
    others = sum(
        (v * u_dot[s] for s, v in motion.partials.items() if s in u_dot and s not in directions), start=motion.bias
    ).gathered()
    return tuple(sub(u_dot[u], directions[u].dot(others)) if u in directions else u_dot[u] for u in derived.speeds)

# SPDX-License-Identifier: BSD-3-Clause
"""`constraint_forces`: forces of constraints, by multipliers and by auxiliary speeds (Kane & Levinson 1985, sec. 4.9 and 7.7).

    M u̇ = f + Aᵀ λ        and        F_a + F*_a = 0 of a speed u_a that the constraint is released by: its force is λ

`impact`: speeds after a collision, by generalized impulses and momenta (Kane & Levinson 1985, sec. 6.8 and 6.9).

    M̃ Δu = J_nᵀ ν + J_tᵀ τ,    v_n′ = −e v_n,    |τ| ≤ μ ν and v_t′ = 0, or τ = −μ′ ν v_t′/|v_t′|

v is the velocity of the striking point relative to the struck one, v′ that after the collision; the configuration does not change. J
are nonholonomic partial velocities, so that constraints remain satisfied. Slip after the collision is opposed by the impulse of
friction; if several impulses satisfy this, the smallest is taken, which does not depend on the choice of tangential axes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Unpack

import numpy as np

from kane import expect
from kane.analysis.many.poses import Poses, poses
from kane.equations.equations import Equations, check_equations, derive
from kane.equations.instances import package
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import ArgumentError, Attributes, KaneError, SimulationError, SingularError, cut, listed_warnings
from kane.expr.symbols import Reaction, Speed
from kane.model.constraints import Constraint, check_unit, constraint_of, reaction
from kane.numeric.arrays import Array
from kane.numeric.rank import null_direction
from kane.numeric.sampling import finite_number
from kane.numeric.scale import EQUAL, ROUNDED_CHAIN, ROUNDED_ROOT, SOLVE_RANK, TAKES_PART
from kane.space.frame import Point
from kane.space.vector import Vector


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ConstraintForces(Attributes):
    """The force or torque of each constraint at a state, by two methods that must agree.

    Attributes
    ----------
    by_multipliers : multipliers λ of the equations, by constraint
    by_auxiliary_speeds : the same forces, each brought into evidence by an auxiliary speed
    """

    by_multipliers: Mapping[Constraint, float]
    by_auxiliary_speeds: Mapping[Constraint, float]

    def __repr__(self) -> str:
        rows = (
            f"{c.name}: {x:.9g} by multipliers, {self.by_auxiliary_speeds[c]:.9g} by an auxiliary speed"
            for c, x in self.by_multipliers.items()
        )
        return f"ConstraintForces({'; '.join(rows)})"


@by_keyword
def constraint_forces(
    eom: Equations, state: State | Any | None = None, **values: Unpack[StateValues]
) -> ConstraintForces | Any:
    """Forces and torques of constraints at a state, by multipliers and by auxiliary speeds.

    Parameters
    ----------
    eom : Equations
        with constraints whose forces have known points, such as `kn.distance`, `kn.no_slip`, `kn.coincident`
    state : a `kn.State` instead of the values that follow
    q, u : a state on the constraints; dependent speeds may be left out
    parameters, inputs, t, states : as in `eom.evaluate`

    If values are arrays, or a Dataset from `kn.assemble`, the result is an xarray Dataset over instance and constraint.

    Raises
    ------
    SimulationError
        if no constraint has forces with known points
    ReactionError
        if reactions at cuts already bring some of these forces into evidence
    """
    check_equations(eom)
    placed, own, others = eom.numeric().value(_in_evidence)

    def forces(at: State) -> tuple[Array, Array]:
        evident = others.evaluate(list(own.values()), at)
        return eom.evaluate([eom.multipliers[c] for c in placed], at), evident

    many = poses(eom, state, values)
    if many is not None:
        return _of_many(many, forces, [c.name for c in placed])
    multipliers, evident = forces(state_of(state, **values))
    return ConstraintForces(
        dict(zip(placed, map(float, multipliers), strict=True)), dict(zip(placed, map(float, evident), strict=True))
    )


class _Evidence(NamedTuple):
    """Constraints whose forces have known points, their reactions, and equations of motion in which these reactions appear."""

    placed: tuple[Constraint, ...]
    own: Mapping[Constraint, Reaction]
    others: Equations


def _in_evidence(eom: Equations) -> _Evidence:
    """Equations with a reaction for each constraint force, derived once for a system."""
    placed = tuple(c for c in eom.system.constraints if c.placed and c not in set(eom.redundant))
    expected, came = "constraints whose forces act at known points", "none: scalar equations have none"
    cure = "Declare them with kn.distance, kn.no_slip, kn.coincident, …."
    expect.that(placed, expected, came=came, cure=cure, error=SimulationError)
    known: dict[Constraint, Reaction] = {c: r for r in eom.reactions if (c := constraint_of(r)) is not None}
    own = {c: known[c] if c in known else reaction(f"lambda_{k}", constraint=c) for k, c in enumerate(placed)}
    added = [r for c, r in own.items() if c not in known]
    others = derive(eom.system.replace(reactions=(*eom.reactions, *added), dependent_speeds=eom.dependent_speeds))
    return _Evidence(placed, own, others)


def _of_many(many: Poses, forces: Callable[[State], tuple[Array, Array]], names: Sequence[str]) -> Any:
    """The forces at all states as a Dataset; a state without finite forces is evaluated alone for the cause."""
    with listed_warnings() as warned:
        found = np.array([[np.broadcast_to(x, many.count) for x in both] for both in forces(many.of_state())])
    causes, lost = dict(many.failed), ~np.isfinite(found).all(axis=(0, 1))
    # a warning names only the first state, so that all are evaluated alone
    for k in [k for k in many.open if warned or lost[k]]:
        try:
            found[:, :, k] = forces(many.state(k))
        except KaneError as error:
            causes[k] = str(error)
    found[:, :, list(causes)] = np.nan
    told = {"by_multipliers": "by multipliers", "by_auxiliary_speeds": "by an auxiliary speed"}
    xarray = package("xarray")
    own = {
        name: xarray.Variable(
            ("instance", "constraint"), x.T, {"long_name": f"force or torque of a constraint, {text}"}
        )
        for (name, text), x in zip(told.items(), found, strict=True)
    }
    return many.dataset(own, causes, {"constraint": list(names)})


@dataclass(frozen=True, slots=True, eq=False)
class Impact(Attributes):
    """The result of a collision, from `kn.analysis.impact`.

    Attributes
    ----------
    u : values of all speeds after the collision, by symbol
    impulse : impulse on the striking point (3), along the inertial axes, N s
    normal : its component along the normal, N s
    slips : whether the points slip on each other after the collision
    lost : loss of kinetic energy, J
    """

    u: Mapping[Speed, float]
    impulse: Array
    normal: float
    slips: bool
    lost: float


@by_keyword
def impact(
    eom: Equations,
    point: Point,
    normal: Vector,
    state: State | None = None,
    *,
    restitution: float,
    friction: float | tuple[float, float] = 0.0,
    other: Point | None = None,
    **values: Unpack[StateValues],
) -> Impact:
    """Speeds and impulse after a collision of a particle of a body with a particle of another body, or with a surface at rest.

    Parameters
    ----------
    eom : Equations
    point : the striking particle, made with `fixed_in`
    normal : unit vector perpendicular to the surface, from the struck side to `point`
    state : a `kn.State` before the collision instead of the values that follow
    restitution : coefficient of restitution e, from 0 to 1: v_n′ = −e v_n
    friction : coefficient of friction μ, or (μ, μ′) of stick and slip; 0 for smooth surfaces
    other : the struck particle; by default the surface is at rest
    q, u : the state before the collision; dependent speeds may be left out
    parameters, inputs, t, states : as in `eom.evaluate`

    Raises
    ------
    ArgumentError
        if e is not from 0 to 1, or a coefficient of friction is negative
    SimulationError
        if the points do not approach each other, or no impulse along the normal can change their relative velocity
    """
    check_equations(eom)
    check_unit(normal, "normal of the impact")
    e, coefficients = _coefficients(restitution, friction)
    at = state_of(state, **values)
    speeds = eom.independent_speeds
    before, axis, partials, mass = _numbers(eom, point, other, normal, at)
    idle = null_direction(mass, SOLVE_RANK)
    massless = (u.name for u, x in zip(speeds, () if idle is None else idle, strict=False) if abs(x) > TAKES_PART)
    cure = "Give mass to the parts that they move."
    expect.none(massless, "speeds that all move some mass", "none moved by {}", cure, error=SingularError)
    inverse = partials.T @ np.linalg.solve(mass, partials)
    v_n, reach = float(axis @ before), float(axis @ inverse @ axis)
    came = f"a velocity of {v_n:.6g} along the normal from the struck to the striking point"
    cure = "Reverse the normal; otherwise there is no impact."
    expect.that(v_n < 0, "points that approach each other", came=came, cure=cure, error=SimulationError)
    moves = reach > ROUNDED_CHAIN * np.abs(inverse).max(initial=0.0)
    expected = "an impulse that moves the point along the normal"
    came, cure = "a constraint that prevents this", "Free the point, or strike another one."
    expect.that(moves, expected, came=came, cure=cure, error=SimulationError)
    pushed, slips = _impulse(axis, before, inverse, e, coefficients)
    change = np.linalg.solve(mass, partials @ pushed)
    own = np.array(eom.evaluate(list(speeds), at), dtype=float)
    after = dict(zip(speeds, (own + change).tolist(), strict=True))
    whole = eom.evaluate(list(eom.speeds), replace(at, u=after))
    k, k_after = (float(eom.evaluate(eom.kinetic_energy, x)) for x in (at, replace(at, u=after)))
    speeds_after = dict(zip(eom.speeds, map(float, whole), strict=True))
    return Impact(speeds_after, pushed, float(axis @ pushed), slips, k - k_after)


def _coefficients(restitution: Any, friction: Any) -> tuple[float, tuple[float, float]]:
    e = finite_number("coefficient", "restitution", restitution)
    pair = friction if isinstance(friction, tuple) else (friction, friction)
    mu = tuple(finite_number("coefficient", "friction", x) for x in pair)
    if not 0 <= e <= 1 or len(mu) != 2 or min(mu) < 0:
        raise ArgumentError(
            f"Expected a coefficient of restitution from 0 to 1 and of friction from 0 on, one or two, got {cut(restitution)} and "
            f"{cut(friction)}."
        )
    return e, (mu[0], mu[1])


def _numbers(eom: Equations, point: Any, other: Any, normal: Vector, state: State) -> tuple[Array, Array, Array, Array]:
    """The relative velocity and the normal (3), the partial velocities (speeds × 3), and M̃."""
    frame, speeds = eom.system.inertial, eom.independent_speeds
    known = eom.solved.nonholonomic.kinematics
    for p in (point,) if other is None else (point, other):
        expect.instance(p, Point, "a point that strikes", "Make one by body.fixed_in(…).", error=ArgumentError)
    own = known.point(point).partials
    others = {} if other is None else known.point(other).partials
    rows = [own.get(r, Vector()) - others.get(r, Vector()) for r in speeds]
    velocity = point.velocity(frame) - (Vector() if other is None else other.velocity(frame))
    before, axis, *partials = eom.evaluate([velocity, normal, *rows], state)
    expect.that(np.shape(before) == (3,), "the numbers of one state", came="arrays", error=ArgumentError)
    mass = eom.evaluate(eom.mass_matrix_nh if eom.dependent_speeds else eom.mass_matrix, state)
    table = np.array(partials, dtype=float).reshape(len(speeds), 3)
    return np.asarray(before), np.asarray(axis), table, np.asarray(mass)


def _impulse(n: Array, before: Array, inverse: Array, e: float, friction: tuple[float, float]) -> tuple[Array, bool]:
    """The impulse (3), and whether there is slip after it."""
    across = np.linalg.svd(n[None, :])[2][1:]
    axes = np.vstack([n, across])
    felt = axes @ inverse @ axes.T
    v = axes @ before
    wanted = np.array([-(1 + e) * v[0], -v[1], -v[2]])
    stuck = np.linalg.lstsq(felt, wanted, rcond=SOLVE_RANK)[0]
    size = np.abs(stuck).max(initial=0.0)
    holds = np.abs(felt @ stuck - wanted).max() <= EQUAL * np.abs(wanted).max()
    if holds and np.hypot(*stuck[1:]) <= friction[0] * stuck[0] + ROUNDED_CHAIN * size:
        return np.asarray(stuck @ axes), False

    if friction[1] == 0:
        return np.asarray(wanted[0] / felt[0, 0] * n), True
    along = _opposed(felt, v, float(wanted[0]), friction[1])
    after = v + along @ felt
    slips = np.flatnonzero((along[:, 0] >= 0) & ((along[:, 1:] * after[:, 1:]).sum(axis=1) <= 0))
    if len(slips):
        return np.asarray(along[slips[np.argmin(along[slips, 0])]] @ axes), True
    raise SimulationError(
        "Expected a direction of slip that the impulse of friction opposes, got none, and sticking would need more friction "
        "than is available: the two coefficients are inconsistent. Give one coefficient."
    )


_IN_TANGENTS = np.array([[1, 0, 2, 0, 1], [-1, 0, 0, 0, 1], [0, -2, 0, -2, 0], [1, 0, -6, 0, 1], [0, 4, 0, -4, 0]])
"""1, cos α, −sin α, cos 2α and −sin 2α, each times (1 + t²)², as polynomials in t = tan(α/2)."""


def _opposed(felt: Array, v: Array, wanted: float, mu: float) -> Array:
    """The impulses (k × 3) with friction opposite or along the slip after them that change the normal velocity by `wanted`.

    The component of the slip across a direction, times the denominator of the impulse, is of degree two in its cosine and sine: five
    values determine it. It is a polynomial of degree four in the tangent of half the angle from a direction where it is large.
    """

    def parts(angle: Array) -> tuple[Array, Array]:
        along = np.stack([np.ones_like(angle), -mu * np.cos(angle), -mu * np.sin(angle)], axis=-1)
        return along, along @ felt[0]

    angles = 2 * np.pi * np.arange(5) / 5
    along, divided = parts(angles)
    slip = divided[:, None] * v + wanted * along @ felt
    across = slip[:, 2] * np.cos(angles) - slip[:, 1] * np.sin(angles)
    start = angles[np.abs(across).argmax()] + np.pi
    one, two = np.fft.fft(across)[1:3] * 2 * np.exp([1j * start, 2j * start])
    t = np.roots(np.array([across.sum(), one.real, one.imag, two.real, two.imag]) @ _IN_TANGENTS)
    t = t[np.abs(t.imag) <= ROUNDED_ROOT * (1 + np.abs(t) ** 2)].real
    along, divided = parts(start + 2 * np.arctan(t))
    return np.asarray((wanted / divided)[:, None] * along)

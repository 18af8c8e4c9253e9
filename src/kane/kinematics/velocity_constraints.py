# SPDX-License-Identifier: BSD-3-Clause
"""Constraints at velocity level, A u + A_a u_a + b = 0 (Kane & Levinson 1985, sec. 2.13), and their bias Ȧ u + ḃ.

The row of a constraint whose forces F and torques T are known is Σ F·v_r + Σ T·ω_r, from partial velocities; that of another one is
its time derivative (of a motion constraint the constraint itself) written in speeds. The bias is the derivative of the scalar
A u + b at u̇ = 0, never taken from a particle's acceleration.

With many speeds, rows are computed by an inward sweep: the wrench (n, f) that the constraint forces transmit through each joint has
the power n·ω + f·ṙ of the joint's relative motion, a form in speeds. A row of n entries then takes O(n) operations; by partial
velocities, each along its own path to the point, it takes O(n²).
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from kane.errors import ModelError, NotAffineError, cut
from kane.expr.build import add, mul, neg
from kane.expr.differentiation import affine_forms, time_derivative
from kane.expr.evaluation import exceeds, free_symbols, is_constant_in_time, price
from kane.expr.forms.collect import collected
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.regular import Sizes, size
from kane.expr.symbols import AuxiliarySpeed, QuasiRate, Rate, Speed
from kane.kinematics.aligned import Aligned
from kane.kinematics.freedoms import Shift, Unsuited
from kane.kinematics.links import tree_of
from kane.kinematics.segments import Segments, joint_tree, segments
from kane.kinematics.speeds import ScalarForm
from kane.kinematics.velocities import Kinematics
from kane.model.constraints import Constraint, constraint_of
from kane.numeric.scale import GIVEN, vanish
from kane.space.frame import Frame, Point
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.vector import Vector
from kane.tree.sweeps import Carry, inward
from kane.tree.triples import summed
from kane.tree.values import NO_WRENCH, SpatialForce

Wrenches = dict[int, SpatialForce]
"""Wrenches on steps by number, along B."""


class Placed(NamedTuple):
    """A force at r from the origin of a step, with its moment, or a torque (`moment` alone), along B."""

    segment: int
    r: Triple
    moment: Triple
    force: Triple


def placed(
    aligned: Aligned, found: Segments, forces: Iterable[tuple[Point, Vector]], torques: Iterable[tuple[Frame, Vector]]
) -> Iterator[Placed]:
    """Forces at points and torques on frames, as acting on steps; those on the ground are left out."""
    for point, force in forces:
        number, arm = found.place(point)
        if number and not force.is_zero:
            f = aligned.vector(force).components(found.basis[number])
            r = summed(arm.components(found.basis[number]), found.steps[number].shift)
            yield Placed(number, r, cross3(r, f), f)
    for frame, torque in torques:
        number = found.of(aligned.rates(frame)[0])
        if number and not torque.is_zero:
            yield Placed(number, NOTHING, aligned.vector(torque).components(found.basis[number]), NOTHING)


def together(acting: Iterable[Placed]) -> Wrenches:
    """The resultant wrench on each step."""
    result: Wrenches = {}
    for number, _, n, f in acting:
        result[number] = result.get(number, NO_WRENCH).plus(SpatialForce(n, f))
    return result


def stands(c: Constraint, found: Segments) -> bool:
    """Whether a constraint has known forces, all at points fixed in steps or in the ground."""
    return c.placed and all(_is_fixed(p, found) for p, _ in c.forces)


def _is_fixed(point: Point, found: Segments) -> bool:
    """Whether a point is fixed in a step; a particle of a body only if its position is along the step's own basis."""
    number, arm = found.place(point)
    fixed = point.body is None or all(f is found.basis[number] for f, _ in arm.parts)
    return fixed and is_constant_in_time(arm.scalars())


def rows_along_tree(constraints: Sequence[Constraint], kinematics: Kinematics) -> dict[Constraint, ScalarForm]:
    """The rows of constraints whose forces act at points fixed in steps of a tree; empty if the system has no such tree."""
    aligned = kinematics.aligned
    try:
        tree = tree_of(kinematics.speeds.system, aligned, [p for c in constraints for p, _ in c.forces])
        found = segments(tree, kinematics)
        standing = [c for c in constraints if stands(c, found)]
        acting = [(c, together(placed(aligned, found, c.forces, c.torques))) for c in standing]
    except Unsuited:
        return {}
    return {c: _Pull(found, wrenches).row(c.own) for c, wrenches in acting}


class _Pull(Carry[SpatialForce]):
    """The inward sweep for the power of wrenches on segments, as a form in speeds."""

    def __init__(self, found: Segments, wrenches: Wrenches) -> None:
        tree = joint_tree(found.steps)
        super().__init__(tree.segments)
        self.steps = found.steps
        self.number = {k: i for i, k in enumerate(tree.joint)}
        self.wrenches = {tree.home[i]: tree.wrench(i, w) for i, w in wrenches.items()}
        self.coefficients: dict[Expr, Expr] = {}
        self.rest: Expr = ZERO

    def row(self, own: Expr) -> ScalarForm:
        """The power of the wrenches plus `own`."""
        self.rest = own
        inward(self.tree, self)
        return ScalarForm({u: c for u, c in self.coefficients.items() if c is not ZERO}, self.rest)

    def local(self, i: int) -> SpatialForce | None:
        return self.wrenches.get(i)

    def inner(self, i: int, v: SpatialForce) -> SpatialForce:
        if i in self.number:
            step = self.steps[self.number[i]]
            self.power(step.spin, v.n)
            if step.late:
                self.power(step.slide, v.f)
        return v

    def outer(self, i: int, v: SpatialForce) -> SpatialForce:
        step = self.steps[self.number[i]] if i in self.number else None
        if step is not None and not step.late:
            before = self.steps[step.parent].turn if step.joins else None
            self.power(step.slide, v.f if before is None else before.down(v.f))
        return v

    def power(self, shift: Shift, along: Triple) -> None:
        """Adds the power of a moment on a rotation, or of a force on a slide."""
        for form, x in zip(shift.forms, along, strict=False):
            if x is ZERO:
                continue
            self.rest = add(self.rest, mul(x, form.rest))
            for u, c in form.coefficients.items():
                self.coefficients[u] = add(self.coefficients.get(u, ZERO), mul(c, x))


_LARGE = 16
"""The number of speeds from which on rows are computed by the inward sweep."""
_SHORT = 20
"""Operations of A and b up to which their own derivative is compared; of longer ones the bias from velocities shares operations."""


@dataclass(frozen=True, eq=False)
class ConstraintRows:
    """A (m × n), A_a (m × auxiliary speeds) and b (m) of m constraints; `differentiated` computes Ȧ u + ḃ (m)."""

    constraints: tuple[Constraint, ...]
    a: Matrix
    a_auxiliary: Matrix
    b: tuple[Expr, ...]
    differentiated: Callable[[], tuple[Expr, ...]] = field(repr=False)

    @cached_property
    def drift(self) -> tuple[Expr, ...]:
        """The bias Ȧ u + ḃ, computed when first read."""
        return self.differentiated()


def constraint_rows(
    constraints: Iterable[Constraint], kinematics: Kinematics, auxiliary: Sequence[AuxiliarySpeed]
) -> ConstraintRows:
    """The rows of constraints in the speeds of the system. ModelError if one is not affine in the rates, or restricts no speed."""
    speeds: Sequence[Expr] = kinematics.speeds.speeds
    listed = tuple(constraints)
    large = bool(listed) and len(speeds) >= _LARGE and not auxiliary
    along = rows_along_tree(listed, kinematics) if large else {}
    sets = [s.coordinates for s in kinematics.speeds.system.euler_parameters]
    forms = _cleared([(c, along.get(c) or (placed_form if c.placed else _bare)(c, kinematics)) for c in listed], sets)
    for c, form in forms:
        if any(s in form.coefficients for s in speeds):
            continue
        # identically satisfied, as in a plane loop closed in space: redundant, not an error
        if not (c.placed and form.rest is ZERO and all(vanish([c.expr], sets))):
            raise ModelError(
                f"Expected the constraint {c.name!r} to restrict the motion, got {cut(c.expr)}, whose rate contains no speed."
            )
    released = {a: constraint_of(a) for a in auxiliary}
    return ConstraintRows(
        tuple(c for c, _ in forms),
        Matrix([[form.coefficients.get(u, ZERO) for u in speeds] for _, form in forms], (len(forms), len(speeds))),
        Matrix(
            [[_released(form, c, a, released[a]) for a in auxiliary] for c, form in forms], (len(forms), len(auxiliary))
        ),
        tuple(form.rest for _, form in forms),
        lambda: tuple(_drift(c, form, kinematics) for c, form in forms),
    )


def _cleared(
    forms: Sequence[tuple[Constraint, ScalarForm]], sets: Sequence[Sequence[Expr]]
) -> list[tuple[Constraint, ScalarForm]]:
    """The forms without coefficients that are zero up to rounding, as the tilts of an axis shared by several pins."""
    numbers = [x for _, form in forms for x in (*form.coefficients.values(), form.rest)]
    gone = iter(vanish(numbers, sets))
    cleared = []
    for c, form in forms:
        kept = {s: x for s, x in form.coefficients.items() if not next(gone)}
        cleared.append((c, form._replace(coefficients=kept, rest=ZERO if next(gone) else form.rest)))
    return cleared


def _drift(c: Constraint, form: ScalarForm, kinematics: Kinematics) -> Expr:
    """Ȧ u + ḃ from velocity biases or, for short A and b, by differentiating these, whichever has fewer operations."""
    if not c.placed:
        return kinematics.drift(_total(form))
    known = (*form.coefficients.values(), form.rest)
    result = _placed_drift(c, kinematics, kinematics)
    if exceeds(known, _SHORT):
        return result
    return min(result, collected(kinematics.drift(_total(form))), key=lambda x: price((*known, x)))


def drift_of(constraint: Constraint, given: Kinematics, usual: Kinematics) -> Expr:
    """d/dt (A u + b) with the accelerations of `given` and the velocities of `usual`."""
    if constraint.placed:
        return _placed_drift(constraint, given, usual)
    return given.drift(_total(_bare(constraint, usual)))


def _acting(constraint: Constraint) -> list[tuple[Point | Frame, Vector]]:
    return [*constraint.forces, *constraint.torques]


def _placed_drift(constraint: Constraint, given: Kinematics, usual: Kinematics) -> Expr:
    """d/dt (Σ F·v + Σ T·ω) at u̇ = 0."""
    total = given.drift(constraint.own)
    for place, v in _acting(constraint):
        total = add(total, add(given.velocity_bias(place).dot(v), usual.of(place).total.dot(usual.turning(v))))
    return total


def _released(form: ScalarForm, constraint: Constraint, auxiliary: Expr, held: Constraint | None) -> Expr:
    """The entry of A_a, −1 for an auxiliary speed of the constraint itself, which relaxes it to A u + b = u_a."""
    if held is not None:
        return neg(ONE) if held is constraint else ZERO
    return form.coefficients.get(auxiliary, ZERO)


def _total(form: ScalarForm) -> Expr:
    """The value of a form at zero auxiliary speeds."""
    own = {s: c for s, c in form.coefficients.items() if not isinstance(s, AuxiliarySpeed)}
    return ScalarForm(own, form.rest).total()


def placed_form(constraint: Constraint, kinematics: Kinematics) -> ScalarForm:
    """The form Σ F·v + Σ T·ω in speeds, by partial velocities. ModelError if it is not the rate of a configuration constraint."""
    coefficients: dict[Expr, Expr] = {}
    rest = constraint.own
    for place, v in _acting(constraint):
        motion = kinematics.of(place)
        for s, partial in motion.partials.items():
            coefficients[s] = add(coefficients.get(s, ZERO), partial.dot(v))
        rest = add(rest, motion.rest.dot(v))
    form = ScalarForm({s: c for s, c in coefficients.items() if c is not ZERO}, rest)
    _check_rate(constraint, form, kinematics)
    return form


def _check_rate(constraint: Constraint, form: ScalarForm, kinematics: Kinematics) -> None:
    """Checks at a random state that Σ F·v + Σ T·ω is the rate of a configuration constraint at moving particles; else ModelError."""
    wandering = [
        p
        for p, _ in constraint.forces
        if p.body is not None and not is_constant_in_time([x for _, r in p.offset.parts for x in r])
    ]
    if constraint.kind != "configuration" or not wandering:
        return
    sample, total, rate = kinematics.sample, _total(form), time_derivative(constraint.expr)
    power, wanted = float(sample.numbers([total])[0]), sample.at_speeds(rate)
    if abs(power - wanted) <= GIVEN * max(abs(power), abs(wanted)):
        return
    # the pseudoinverse of Y may be ill-conditioned where W in symbols is not
    rate, memo = kinematics.speeds.in_speeds(rate, {}), Sizes()
    wanted = float(sample.numbers([rate])[0])
    if abs(power - wanted) > GIVEN * max(map(float, sample.numbers([size(total, memo), size(rate, memo)]))):
        raise ModelError(
            f"Expected the rate of the configuration constraint {constraint.name!r} to follow from the velocities of its points, got "
            f"{wanted:.6g} for the rate and {power:.6g} from the velocities at a random state: the position of {wandering[0].name} in "
            f"its body changes. Constrain a geometric point, made with .at(…), or list kn.no_slip(…) in nonholonomic=."
        )


def _bare(constraint: Constraint, kinematics: Kinematics) -> ScalarForm:
    """The form of a configuration constraint's rate, or of a motion constraint itself. ModelError if it is not affine in speeds."""
    speeds = kinematics.speeds
    e = constraint.expr
    if constraint.kind == "configuration":
        moving = [str(s) for s in free_symbols([e]) if isinstance(s, Rate | QuasiRate | Speed)]
        if moving:
            raise ModelError(
                f"Expected the configuration constraint {constraint.name!r} in coordinates and time, got {', '.join(moving)} in it. "
                "List it in nonholonomic=."
            )
        e = time_derivative(e)
    whole = speeds.in_speeds(e, {})
    try:
        ((row, rest),) = affine_forms([whole], speeds.speeds)
    except NotAffineError as error:
        raise ModelError(
            f"Expected the motion constraint {constraint.name!r} affine in the speeds, A u + b = 0, got {cut(e, 120)}. {error} "
            "Choose coordinates in which it is affine (a heading with v·n = 0 across it, in place of a condition on |v|), or enforce "
            "it approximately by loads against its gradient, −c f ∂f/∂u with a large c."
        ) from error
    return ScalarForm(row, rest)

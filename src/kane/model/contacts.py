# SPDX-License-Identifier: BSD-3-Clause
"""Contacts with friction and impacts: one declaration, from which the equations of every mode are derived.

A contact has a gap g(q, t), slip velocities v_k, and laws (Coulomb, with μ_s ≥ μ_k):

    separated  g > 0                       no force
    sticks     g = 0, v = 0                |F| ≤ μ_s N
    slips      g = 0, N ≥ 0                F = −μ_k N v/|v| − c v

N and F are the multipliers of g = 0 and v_k = 0, which are constraints (see `kane.model.constraints`) of the system in a closed mode.
A contact that the choice of coordinates keeps closed has no gap, and N is a declared reaction. Friction of a given magnitude, as in a
clutch, has neither a gap nor N: |F| ≤ size. μ_k may be a function of |v|, in which a symbol represents |v|. Rolling and drilling
resistance are proportional to the N of another contact, and act while that one is closed.

A contact slips either in the mode `STRAIGHT`, along a constant direction d, or along v itself: v/|v| is undefined where slip begins
or ends. In the plane all slip is straight.

If several contacts stick by the same constraint, as the corners of a block do, the first has the constraint and the others are
`HELD`: rigid bodies determine only the sum of their friction. It is shared in proportion to μ_s N; they stick while |ΣF| ≤ Σ μ_s N.

If a body stands on a plane at more points than rigid bodies determine forces for, its contacts are a `Stand`: a subset of the
constraints is imposed, and all contacts share the multipliers by constant weights (`kane.equations.contact_shares`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import pairwise
from typing import Any, NamedTuple

from kane import expect
from kane.errors import ExpressionError, ModelError, cut
from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sqrt, sub, sum_of
from kane.expr.differentiation import time_derivative
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, Parameter, Rate, Reaction, word
from kane.expr.visit import substituted
from kane.model.constraints import Constraint, check_unit, configuration_constraint, motion_constraint, reaction
from kane.model.joints.contact import Contact
from kane.model.joints.joint import Joint
from kane.numeric.sampling import default_of, not_negative, positive
from kane.space.frame import Frame, Point, frames_of
from kane.space.vector import Vector

SHARED = 3
"""Largest number of independent constraints, of gaps or of slips, between a rigid body and a plane."""
LAWS = ("stronge", "poisson", "newton", "moreau")


class ContactMode(IntEnum):
    """The mode of a contact: SEPARATED, STICK or SLIP; a contact without friction has the mode STICK while it is closed.

    STRAIGHT: it slips in a fixed direction, near zero slip. HELD: it sticks together with the nearest contact before it in the list
    that has friction and the mode STICK. If several contacts hold one rigid body on a plane, their constraints are redundant: a
    contact is then HELD if its slip vanishes with those of the others, ACROSS if this is so for one direction of slip, and the other
    has a constraint of its own, CARRIED… if its gap, and without slip its slip too, stays zero with those of the others.
    """

    SEPARATED = 0
    STICK = 1
    STRAIGHT = 2
    SLIP = 3
    HELD = 4
    ACROSS = 5
    CARRIED = 6
    CARRIED_STRAIGHT = 7
    CARRIED_SLIP = 8

    @property
    def slips(self) -> bool:
        """Whether the contact slips."""
        return self in _SLIPS or self in _SLIPS.values()

    @property
    def straight(self) -> bool:
        """Whether the contact slips in a fixed direction."""
        return self in _SLIPS

    @property
    def carried(self) -> bool:
        """Whether other contacts keep the gap of this one closed."""
        return self >= ContactMode.CARRIED

    def slipping(self, straight: bool) -> "ContactMode":
        """The mode with the same slip, in a fixed direction (`straight`) or not."""
        return next(a if straight else b for a, b in _SLIPS.items() if self in (a, b))

    def with_others(self) -> "ContactMode":
        """The corresponding mode if other contacts keep the gap closed."""
        return _CARRIED.get(self, ContactMode.CARRIED)

    def word(self, contact: "ContactLaw") -> str:
        """The name shown for the mode: "separated", "stick" or "slip"; "closed" without friction, also for a taut rope."""
        if self is ContactMode.SEPARATED:
            return "separated"
        return "slip" if self.slips else "stick" if contact.slips else "closed"


_SLIPS = {ContactMode.STRAIGHT: ContactMode.SLIP, ContactMode.CARRIED_STRAIGHT: ContactMode.CARRIED_SLIP}
"""The modes of slip in a fixed direction, and the corresponding ones of slip along v."""
_CARRIED = {ContactMode.STRAIGHT: ContactMode.CARRIED_STRAIGHT, ContactMode.SLIP: ContactMode.CARRIED_SLIP}

Modes = tuple[ContactMode, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ContactLaw(Immutable):
    """A contact with its laws of friction and impact, from `kn.contact` or `kn.joints.stop`, `rope`, `stiction`, ….

    Attributes
    ----------
    name : name of the contact
    gap : the constraint g ≥ 0; None if coordinates keep the contact closed, or if friction needs no normal force
    slips : the slip velocities, one or two, that vanish in the mode STICK
    normal_force : N, the multiplier of the gap, or a reaction of the system; None if friction has a given magnitude
    friction_forces : F_k along each slip velocity, on the particle in contact
    static, kinetic : μ_s and μ_k, functions of `speed` if desired; magnitudes, N or N m, if there is no normal force
    speed : the symbol of the slip speed |v| in μ_k
    viscous : c of the force −c v that is added in the mode SLIP
    restitution : coefficient of restitution e of impacts
    law : law of restitution: "stronge" (energetic), "poisson", "newton", or "moreau", Newton's for all contacts at once
    direction : symbols of the direction d_k of slip in the mode STRAIGHT
    slowest : symbol of the slip speed below which the mode is STRAIGHT
    place : the geometry of the contact, if it was made by `kn.contact`
    pressed_by : the contact whose normal force acts in the friction law, if it is a different one
    slack : symbol of a gap below zero, of the size of rounding, that counts as closed
    across : the constraint of the slip perpendicular to `direction`, and its multiplier; None if there is one slip velocity
    shares : weights of the multipliers in N and in each F_k, if several contacts hold one rigid body on a plane
    """

    name: str
    gap: Constraint | None
    slips: tuple[Constraint, ...]
    normal_force: Reaction | None
    friction_forces: tuple[Reaction, ...]
    static: Expr
    kinetic: Expr
    speed: Parameter
    viscous: Expr
    restitution: Expr
    law: str
    direction: tuple[Parameter, ...]
    slowest: Parameter
    slack: Parameter
    across: tuple[Constraint, Reaction] | None
    shares: tuple[tuple[Parameter, ...], ...]
    place: Contact | None = None
    pressed_by: "ContactLaw | None" = None

    def __repr__(self) -> str:
        friction = f", μ = {self.kinetic_at(self.speed)}" if self.slips else ""
        return f"ContactLaw({self.name!r}{friction}, e = {self.restitution})"

    @property
    def rows(self) -> tuple[Constraint, ...]:
        """The constraints `gap`, if there is one, and `slips`."""
        return (*(() if self.gap is None else (self.gap,)), *self.slips)

    @property
    def between(self) -> tuple[Frame | None, Frame, str] | None:
        """The two bodies in contact and the normal, if the second body has a plane there; else None."""
        home = () if self.place is None else frames_of(self.place.normal)
        if self.place is None or len(home) != 1:
            return None
        return self.place.particle.body, home[0], str(self.place.normal)

    @property
    def sized(self) -> bool:
        """Whether friction has a given magnitude instead of depending on a normal force."""
        return self.gap is None and self.normal_force is None

    @property
    def pressing(self) -> Expr:
        """The normal force N; 1 if friction has a given magnitude."""
        return ONE if self.normal_force is None else self.normal_force

    @property
    def most(self) -> Expr:
        """μ_s N, the largest friction force in the mode STICK."""
        return mul(self.static, self.pressing)

    def sliding_friction(self, mode: ContactMode) -> dict[Expr, Expr]:
        """The friction forces of a slipping contact, {F_k: expression}."""
        size = neg(mul(self.kinetic_at(self.onward if mode.straight else sqrt(self.square)), self.pressing))
        drags = [mul(self.viscous, c.expr) for c in self.slips]
        each = zip(self.friction_forces, self.along(mode), drags, strict=True)
        return {f: sub(mul(size, d), drag) for f, d, drag in each}

    def kinetic_at(self, speed: Expr) -> Expr:
        """μ_k at a slip speed."""
        return substituted(self.kinetic, {self.speed: speed})

    @property
    def numbers(self) -> tuple[Expr, Expr, Expr]:
        """μ_s, μ_k and e, with μ_k at the slip speed |v|."""
        return self.static, self.kinetic_at(sqrt(self.square)), self.restitution

    def along(self, mode: ContactMode) -> tuple[Expr, ...]:
        """The measure numbers of the unit vector along the slip."""
        return self.direction if mode.straight else tuple(c.expr / sqrt(self.square) for c in self.slips)

    @property
    def onward(self) -> Expr:
        """The slip velocity along `direction`."""
        return sum_of(mul(d, c.expr) for d, c in zip(self.direction, self.slips, strict=True))

    @property
    def square(self) -> Expr:
        """The square of the slip speed, |v|²."""
        return sum_of(mul(c.expr, c.expr) for c in self.slips)


class Friction(NamedTuple):
    """The friction arguments of a contact: μ_k, a number or a function of the slip speed; μ_s or None; c."""

    kinetic: Any = 0
    static: Any = None
    viscous: Any = 0


SMOOTH = Friction()


def stribeck(kinetic: Any, static: Any, speed: Any) -> Callable[[Any], Expr]:
    """Stribeck friction μ(v) = μ_k + (μ_s − μ_k) exp(−(v/v_s)²), for `mu=` of a contact, or the size of `stiction` and `clutch`.

    Parameters
    ----------
    kinetic : μ_k, the value at slip speeds v ≫ v_s; in `stiction` and `clutch` a force (N) or torque (N m)
    static : μ_s ≥ μ_k, the value at rest
    speed : v_s > 0, m/s or rad/s

    Notes
    -----
    Armstrong-Hélouvry, B., Dupont, P., Canudas de Wit, C. (1994), A survey of models, analysis tools and compensation methods for
    the control of machines with friction, Automatica 30, 1083-1138, sec. 2.1.
    """
    scale = positive(speed, "a speed v_s of Stribeck's friction")
    slow, fast = as_expr(static), not_negative(kinetic, "μ_k of Stribeck's friction")
    not_negative(sub(slow, fast), "μ_s − μ_k of Stribeck's friction", "Swap them: stribeck(kinetic, static, speed).")

    def mu(v: Any) -> Expr:
        share = NODE_BUILDERS["exp"](neg(mul(div(v, scale), div(v, scale))))
        return add(mul(slow, share), mul(fast, sub(ONE, share)))  # exactly μ_s at rest

    return mu


def _coefficient(name: str, what: str, given: Any) -> Expr:
    """The number or expression `given` as an expression; ExpressionError if it is neither."""
    try:
        return as_expr(given)
    except ExpressionError as error:
        cure = "Give a finite number, a parameter or an expression of these."
        raise expect.refusal(
            ExpressionError, f"a coefficient as {what} of the contact {name!r}", cut(repr(given)), cure
        ) from error


def _law(
    name: str,
    gap: Constraint | None,
    slips: Sequence[Constraint],
    normal: Reaction | None,
    friction: Friction = SMOOTH,
    restitution: Any = 0,
    law: str = LAWS[0],
) -> ContactLaw:
    """A contact with its symbols; raises unless coefficients are admissible for the default values of parameters."""
    expect.instance(name, str, "a text as the name of a contact")
    expect.that(name, "a name of a contact", name)
    label = word(name)
    speed = Parameter.declare(f"s_{label}", 0.0, "", f"speed of the slip of {name}")
    given = friction.kinetic(speed) if callable(friction.kinetic) else friction.kinetic
    kinetic = _coefficient(name, "friction", given)
    static = substituted(kinetic, {speed: ZERO})
    if friction.static is not None:
        static = _coefficient(name, "static=", friction.static)
    e, viscous = _coefficient(name, "restitution=", restitution), _coefficient(name, "viscous=", friction.viscous)
    check_numbers(name, *(default_of(x) for x in (static, kinetic, e)), sized=gap is None and normal is None)
    not_negative(viscous, f"viscous= of {name!r}")
    expect.one_of(law, LAWS, f"law= of {name!r} to be")
    smooth = kinetic is ZERO and static is ZERO and viscous is ZERO
    rows = () if smooth else tuple(c for c in slips if c.expr is not ZERO)
    if normal is None and gap is not None:
        normal = reaction(f"N_{label}", constraint=gap)
    marks = [""] if len(rows) == 1 else [f"_{k}" for k in range(1, len(rows) + 1)]
    directions = tuple(Parameter.declare(f"d_{label}{k}", 0.0, "", f"direction of the slip of {name}") for k in marks)
    slowest = Parameter.declare(f"v_{label}", 0.0, "", f"slip below which {name} slips straight on")
    slack = Parameter.declare(f"g_{label}", 0.0, "", f"rounding of the gap of {name}")
    across = _across(name, label, rows, directions) if len(rows) == 2 else None
    shares = tuple(
        tuple(Parameter.declare(f"w_{label}_{j}{k}", 0.0, "", f"share of {name}") for k in range(SHARED))
        for j in range(1 + len(rows))
    )
    forces = tuple(reaction(f"F_{label}{k}", constraint=c) for k, c in zip(marks, rows, strict=True))
    return ContactLaw(
        name, gap, rows, normal, forces, static, kinetic, speed, viscous, e, law, directions, slowest, slack, across, shares
    )  # fmt: skip


def _across(
    name: str, label: str, rows: Sequence[Constraint], directions: Sequence[Expr]
) -> tuple[Constraint, Reaction]:
    """The constraint −d₂ v₁ + d₁ v₂ = 0 of the slip perpendicular to `direction`, and its multiplier."""
    ways = (neg(directions[1]), directions[0])
    each = list(zip(ways, rows, strict=True))
    row = replace(
        rows[0],
        name=f"{name} across",
        expr=sum_of(mul(d, c.expr) for d, c in each),
        own=sum_of(mul(d, c.own) for d, c in each),
        forces=tuple((p, v * d) for d, c in each for p, v in c.forces),
        torques=tuple((f, v * d) for d, c in each for f, v in c.torques),
    )
    return row, reaction(f"F_{label}_across", constraint=row)


def check_numbers(
    name: str, static: float | None, kinetic: float | None, e: float | None, *, sized: bool = False
) -> None:
    """Raises unless 0 ≤ μ_k ≤ μ_s and 0 ≤ e ≤ 1; None is an unknown value."""
    for what, value in (("a size" if sized else "mu = μ_k", kinetic), ("static = μ_s", static)):
        right = value is None or value >= 0
        expect.that(
            right, f"{what} ≥ 0 of the contact {name!r}", came=f"{value}", cure="Give 0 for a frictionless contact."
        )
    ordered = static is None or kinetic is None or kinetic <= static
    cure = "Swap them, or give mu= alone for both."
    expect.that(ordered, f"μ_k ≤ μ_s of the contact {name!r}", came=f"μ_k = {kinetic} and μ_s = {static}", cure=cure)
    right = e is None or 0 <= e <= 1
    cure = "Give 0 for an impact without rebound, 1 for one without loss."
    expect.that(right, f"a restitution from 0 to 1 of the contact {name!r}", came=f"{e}", cure=cure)


def contact(
    at: Contact,
    mu: Any = 0,
    *,
    static: Any = None,
    viscous: Any = 0,
    restitution: Any = 0,
    law: str = LAWS[0],
    normal: Reaction | None = None,
    name: str = "",
) -> ContactLaw:
    """A contact that can stick or roll, slip, separate and collide, with Coulomb friction; list it in `System(contacts=[…])`.

    Parameters
    ----------
    at : geometry of the contact, from `kn.joints.point_on_plane`, `disk_on_plane`, `sphere_on_plane`, `torus_on_plane`, …
    mu : coefficient of sliding friction μ_k, or a function of the slip speed v ≥ 0 that returns it: `lambda v: …`, `stribeck(…)`
    static : coefficient of static friction μ_s ≥ μ_k; by default μ_k at v = 0
    viscous : c ≥ 0, N s/m, of a force −c v in addition to −μ_k N v/|v| while the contact slips
    restitution : coefficient of restitution e, from 0 to 1
    law : law of restitution. "stronge" (energetic), "poisson" (impulses) and "newton" (velocities) treat one contact after the other,
        with slip that may end and reverse during the impact (Routh); "moreau" demands v_n⁺ ≥ −e v_n⁻ of all contacts at once, with
        friction opposite to the slip after the impact (Moreau 1988)
    normal : the normal force as a reaction, if coordinates keep the contact closed; the motion then ends where it falls to zero
    name : by default that of `at`

    Raises
    ------
    ModelError
        if 0 ≤ μ_k ≤ μ_s or 0 ≤ e ≤ 1 does not hold, or if the gap does not depend on coordinates and `normal` is not given
    """
    cure = "Make one with kn.joints.point_on_plane, sphere_on_plane, …, or list what has a law already in contacts=[…] directly."
    expect.instance(at, Contact, "the geometry of a contact", cure)
    label = expect.label(name) or at.name
    moves = any(isinstance(s, Coordinate | Rate) for s in free_symbols([at.height.expr]))
    if normal is None and not moves:
        apart = not free_symbols([at.height.expr]) and at.height.expr is not ZERO
        why = (
            "these bodies never touch. Leave the contact out"
            if apart
            else "they keep it closed, so that the normal force is unknown. Bring it into evidence and pass it: "
            "normal=kn.reaction(name, at=…, along=…)"
        )
        raise ModelError(
            f"Expected a gap of the contact {label!r} that depends on coordinates, got {at.height.expr}: {why}."
        )
    gap = None if normal is not None else at.height
    return replace(_law(label, gap, at.rolling, normal, Friction(mu, static, viscous), restitution, law), place=at)


def rolling_resistance(by: ContactLaw, arm: Any, *, static: Any = None, viscous: Any = 0, name: str = "") -> ContactLaw:
    """Rolling resistance: a couple of magnitude ρ N opposite to the angular velocity, or up to ρ_s N on a wheel at rest.

    N is the normal force of a contact. The couple acts between its two bodies about axes in the plane of contact while the contact
    is closed, slipping or not; it has no impulse in impacts. List the contact and the resistance in `System(contacts=[…])`.

    Parameters
    ----------
    by : the contact, from `kn.contact`
    arm : ρ, m, the offset of the normal force from the centre: the coefficient of rolling resistance times the radius
    static : ρ_s ≥ ρ, m; by default `arm`
    viscous : c, N m s/rad, of a couple −c ω in addition while the wheel rolls
    name : by default "rolling of <contact>"

    Raises
    ------
    ModelError
        if `by` is not from `kn.contact`, or its bodies have no relative rotation about these axes

    Notes
    -----
    Johnson, K. L. (1985), Contact Mechanics, Cambridge University Press, sec. 9.1.
    """
    place = _pressing(by)
    axes = [row.forces[0][1] for row in place.rolling]
    return _resistance(name or f"rolling of {by.name}", by, place, axes, Friction(arm, static, viscous))


def drilling_resistance(
    by: ContactLaw, arm: Any, *, static: Any = None, viscous: Any = 0, name: str = ""
) -> ContactLaw:
    """Drilling (spin) resistance: a couple |M| ≤ δ N about the normal of a contact. `arm` is δ, m; else as `rolling_resistance`.

    A Hertzian contact of radius a that spins without sliding has δ = 3 π μ a/16 (Johnson 1985, sec. 7.4, complete slip).
    """
    place = _pressing(by)
    return _resistance(name or f"drilling of {by.name}", by, place, [place.normal], Friction(arm, static, viscous))


def _pressing(by: ContactLaw) -> Contact:
    expect.instance(by, ContactLaw, "a contact with a normal force", "Make one with kn.contact(…).")
    place = by.place
    if place is None:
        raise ModelError(f"Expected a contact of kn.contact(…), which has a normal force at a point, got {by.name!r}.")
    return place


def _resistance(name: str, by: ContactLaw, place: Contact, axes: Sequence[Vector], friction: Friction) -> ContactLaw:
    body = place.particle.body
    ground = place.ground
    base = None if ground is None else ground.body
    base = place.particle.root().frame if base is None else base
    w = Vector() if body is None else body.angular_velocity(base)
    rows = [
        replace(motion_constraint(f"{name} {k}", w.dot(axis)), torques=((body, axis), (base, -axis)), unit="N*m")
        for k, axis in enumerate(axes, 1)
        if body is not None and w.dot(axis) is not ZERO
    ]
    expect.that(rows, f"a body that turns about axes of {name!r}", came="none of its rates in it")
    return replace(_law(name, None, rows, by.normal_force, friction), pressed_by=by)


def stop(name: str, gap: Any, *, restitution: Any = 0, law: str = LAWS[0]) -> ContactLaw:
    """A one-sided stop, frictionless: `gap`, an expression in coordinates and time such as q_max − q, stays ≥ 0.

    The multiplier of the gap, `normal_force`, is the generalized force of the closed stop. `restitution` and `law` as in
    `kn.contact`.
    """
    row = gap if isinstance(gap, Constraint) else configuration_constraint(name, gap)
    _check_moves(name, row.expr)
    return _law(name, row, (), None, restitution=restitution, law=law)


def rope(name: str, points: Sequence[Point], length: Any, *, restitution: Any = 0, law: str = LAWS[0]) -> ContactLaw:
    """A massless, inextensible rope of length L (m) through `points` in order, slack or taut: Σ|r_i+1 − r_i| ≤ L.

    Points between the ends are frictionless pulleys without size. `normal_force` is the tension (N). `restitution` and `law`, as in
        `kn.contact`, apply when the rope becomes taut.
    """
    through = _rope_points(name, points)
    return _law(name, _rope_row(name, through, length), (), None, restitution=restitution, law=law)


def capstan(
    name: str,
    points: Sequence[Point],
    length: Any,
    mu: Any,
    *,
    drum: Point,
    angle: Any,
    static: Any = None,
    surface: Any = 0,
    restitution: Any = 0,
    law: str = LAWS[0],
) -> ContactLaw:
    """A rope, see `rope`, wound round a drum with friction: it sticks while T₂/T₁ lies between e^(−μ_s θ) and e^(μ_s θ).

    While it slips the ratio is e^(±μ θ). With N = (T₁ + T₂)/2 and F = T₁ − T₂ this is Coulomb's law |F| ≤ 2 tanh(μ θ/2) N: N is
    `normal_force`, F `friction_forces[0]`, T₁ = N + F/2 the tension before the drum and T₂ = N − F/2 that behind it.

    Parameters
    ----------
    name : name of the contact
    points : points of the rope, in order, with `drum` between its ends; others between are frictionless pulleys
    length : length of the rope, m, without the part wound round the drum
    mu : coefficient of sliding friction, or a function of the slip speed
    drum : the centre of the drum, whose radius is neglected
    angle : angle of wrap θ ≥ 0, rad; 2 π per turn
    static : coefficient of static friction
    surface : velocity of the drum's surface towards the last point, m/s, for a winch
    restitution, law : of the impact when the rope becomes taut, as in `kn.contact`

    Notes
    -----
    Euler, L. (1769), Remarques sur l'effet du frottement dans l'équilibre, Mém. Acad. Sci. Berlin 18, 265-278; Eytelwein.
    """
    through = _rope_points(name, points)
    expect.that(drum in through[1:-1], f"the drum of {name!r} among the points between the rope's ends", drum)
    wound = not_negative(angle, f"an angle of {name!r}")

    def pressed(x: Any) -> Expr:
        """2 tanh(μ θ/2)."""
        return mul(as_expr(2), NODE_BUILDERS["tanh"](div(mul(as_expr(x), wound), as_expr(2))))

    at = through.index(drum)
    (before, pulled), (behind, held) = (_rope_parts(part) for part in (through[: at + 1], through[at:]))
    ends: dict[Point, Vector] = {}
    for pulls, share in ((pulled, 1), (held, -1)):
        for p, v in pulls.items():
            ends[p] = ends.get(p, Vector()) + v * share / 2
    running = as_expr(surface)
    slip = sub(div(sub(time_derivative(behind), time_derivative(before)), as_expr(2)), running)
    row = replace(motion_constraint(f"{name} slip", slip), forces=tuple(ends.items()), unit="N", own=neg(running))
    friction = Friction(
        (lambda v: pressed(mu(v))) if callable(mu) else pressed(mu), None if static is None else pressed(static)
    )
    return _law(name, _rope_row(name, through, length), (row,), None, friction, restitution, law)


def _rope_points(name: str, points: Sequence[Point]) -> list[Point]:
    through = list(expect.items(points, f"points of the rope {name!r}", "Write [P, Q]."))
    expect.instances(through, Point, f"points of the rope {name!r}")
    expect.that(len(through) > 1, f"two points or more of the rope {name!r}", came=str(len(through)))
    return through


def _rope_parts(through: Sequence[Point]) -> tuple[Expr, dict[Point, Vector]]:
    """The length of the polygon through points, and the force on each of them at unit tension."""
    pulls: dict[Point, Vector] = {}
    length = ZERO
    for p, q in pairwise(through):
        r = q.position(p)
        size = r.magnitude()
        length = add(length, size)
        for point, v in ((p, r / size), (q, -(r / size))):
            pulls[point] = pulls.get(point, Vector()) + v
    return length, pulls


def _rope_row(name: str, through: Sequence[Point], length: Any) -> Constraint:
    """The constraint of the gap L − Σ|r_i+1 − r_i|."""
    taut, pulls = _rope_parts(through)
    left = sub(as_expr(length), taut)
    _check_moves(name, left)
    return Constraint(name, "configuration", left, tuple(pulls.items()), (), "N", time_derivative(as_expr(length)))


def _check_moves(name: str, gap: Expr) -> None:
    moving = any(isinstance(s, Coordinate) for s in free_symbols([gap]))
    cure = "Give an expression that must stay at or above zero, such as x_max - x."
    expect.that(moving, f"a gap of {name!r} that depends on coordinates", came=str(gap), cure=cure)


def stiction(
    joint: Joint, size: Any, *, static: Any = None, viscous: Any = 0, normal: Reaction | None = None, name: str = ""
) -> ContactLaw:
    """Dry friction in a pin or slider: `size` opposite to the joint's rate while it moves, up to `static` while it sticks.

    Parameters
    ----------
    joint : a pin or a slider
    size : magnitude of the torque (N m) or force (N) of sliding, or a function of the rate; with `normal`, the coefficient μ_k
    static : largest magnitude while the joint sticks; by default `size` at rest
    viscous : c of a torque −c ω (N m s/rad) or force −c v (N s/m) in addition while the joint moves
    normal : the normal reaction N, which must stay positive, for a friction of μ N
    name : by default "stiction in <joint>"
    """
    kind = getattr(joint, "kind", None)
    expect.that(
        kind in ("pin", "slider"), "stiction in a pin or slider joint", joint, "Use kn.joints.clutch for two frames."
    )
    label = expect.label(name) or f"stiction in {joint.name}"
    if kind == "pin":
        return clutch(label, joint.frame, joint.parent, joint.axis, size, static=static, viscous=viscous, normal=normal)
    rate = joint.velocity.dot(joint.axis)
    row = replace(motion_constraint(label, rate), forces=((joint.point, joint.axis), (joint.at, -joint.axis)), unit="N")
    return _law(label, None, (row,), normal, Friction(size, static, viscous))


def clutch(
    name: str,
    frame: Frame,
    other: Frame,
    axis: Vector,
    size: Any,
    *,
    static: Any = None,
    viscous: Any = 0,
    normal: Reaction | None = None,
) -> ContactLaw:
    """A clutch, a brake or a belt pulley: a friction torque between two frames about a unit vector `axis`, slipping or stuck.

    `size` (N m) is its magnitude while the frames slip, or a function of their relative rate; `static` the largest while they
    stick, by default `size` at rest. Both may contain inputs, such as the clamping force. `viscous` and `normal` are as in
    `stiction`.
    """
    for x in (frame, other):
        expect.instance(x, Frame, f"two frames of {name!r}")
    check_unit(axis, f"axis of {name!r}")
    rate = frame.angular_velocity(other).dot(axis)
    expect.that(rate is not ZERO, f"frames of {name!r} that turn about {axis}", came="none of their rates in it")
    row = replace(motion_constraint(name, rate), torques=((frame, axis), (other, -axis)), unit="N*m")
    return _law(name, None, (row,), normal, Friction(size, static, viscous))


def contact_rows(contacts: Sequence[ContactLaw]) -> list[Constraint]:
    """The constraints of all contacts; ModelError if gaps are equal, laws of restitution differ, or a `pressed_by` is not listed."""
    gaps: dict[Expr, str] = {}
    for c in contacts:
        if c.gap is None:
            continue
        if c.gap.expr in gaps:
            raise ModelError(
                f"Expected contacts at different points, got {gaps[c.gap.expr]!r} and {c.name!r} with the same gap. Leave one out."
            )
        gaps[c.gap.expr] = c.name
    law_of(contacts)
    for c in contacts:
        missing = c.pressed_by is not None and c.pressed_by not in contacts
        expect.that(not missing, f"the contact whose normal force {c.name!r} depends on listed, too", c.pressed_by)
    return [row for c in contacts for row in c.rows]


def law_of(contacts: Sequence[ContactLaw]) -> str:
    """The law of restitution of all impacts; without restitution, the sequential laws are the same.

    Raises
    ------
    ModelError
        if contacts have different laws, as impacts at one instant follow one law
    """
    laws = {c.law: c.name for c in contacts if c.gap is not None and (c.restitution is not ZERO or c.law == LAWS[-1])}
    if len(laws) > 1:
        told = " and ".join(f"law={law!r} of {name!r}" for law, name in laws.items())
        raise ModelError(
            f"Expected one law of restitution for all contacts, got {told}. Give all the same law=, as impacts may coincide."
        )
    return next(iter(laws), LAWS[0])


def slip_parameters(contacts: Sequence[ContactLaw]) -> tuple[Parameter, ...]:
    """The parameters that the modes of contacts set: directions of slip, slip speeds below which slip is straight, and shares."""
    own = (p for c in contacts if c.slips for p in (*c.direction, c.slowest))
    return (*own, *(p for c in contacts if c.place is not None for row in c.shares for p in row))


def laws_of(contacts: Sequence[ContactLaw]) -> list[Expr]:
    """The coefficients μ_s, μ_k, e and c of all contacts."""
    return [x for c in contacts for x in (*c.numbers, c.viscous)]


def given_modes(contacts: Sequence[ContactLaw], given: Any) -> Modes:
    """The modes of all contacts, in order, from a sequence or from a mapping by contact or name."""
    if not isinstance(given, Mapping):
        modes = expect.items(given, f"modes of all {len(contacts)} contacts")
        expect.that(len(modes) == len(contacts), f"modes of all {len(contacts)} contacts", came=str(len(modes)))
        return tuple(_mode(c, m) for c, m in zip(contacts, modes, strict=True))
    named = {c.name: c for c in contacts}
    told: dict[str, ContactMode] = {}
    for key, mode in given.items():
        name = key.name if isinstance(key, ContactLaw) else key
        expect.that(name in named, f"contacts among {', '.join(named) or 'none'}", key)
        told[name] = _mode(named[name], mode)
    return tuple(_mode_of(c, told) for c in contacts)


def _mode(contact: ContactLaw, given: Any) -> ContactMode:
    """The mode that `given` denotes: a mode, its number or its name; a contact without friction also has the mode "closed"."""
    names = {m.name.lower(): m for m in ContactMode} | ({} if contact.slips else {"closed": ContactMode.STICK})
    found = [m for name, m in names.items() if given in (name, m.value)]
    expect.that(found, f"a mode of the contact {contact.name!r} among {', '.join(names)}", given)
    return found[0]


def _mode_of(c: ContactLaw, told: Mapping[str, ContactMode]) -> ContactMode:
    """The mode of a contact: given, else STICK without a gap and SEPARATED with one; SEPARATED if the contact that presses it is."""
    presses = c.pressed_by
    if presses is not None and _mode_of(presses, told) is ContactMode.SEPARATED:
        return ContactMode.SEPARATED
    return told.get(c.name, ContactMode.STICK if c.gap is None else ContactMode.SEPARATED)

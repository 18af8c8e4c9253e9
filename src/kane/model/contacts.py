# SPDX-License-Identifier: BSD-3-Clause
"""Contacts with friction and impacts: one declaration, of which the equations of every mode are derived.

A contact has a gap g(q, t) ≥ 0, velocities of slip v_k = 0, and laws (Coulomb, with μ_s ≥ μ_k):

    separated  g > 0                       no force
    sticks     g = 0, v = 0                |F| ≤ μ_s N
    slips      g = 0, N ≥ 0                F = −μ_k N v/|v|

N and F are multipliers of the rows g and v_k: constraints of a mode's system, whose forces, places and reactions are those of
`kane.model.constraints`. Where coordinates keep a contact closed by themselves it has no gap, and N is a reaction that is declared.
Friction of a given size, as in a clutch, has neither: |F| ≤ size.

In a mode a contact slips either `STRAIGHT`, along a direction d that is a number, or along v itself: v/|v| has no value where a slip
begins or ends. In the plane all slip is straight.

Where several contacts stick by one row, as the corners of a block, the first has the row and the others are `HELD` with it: rigid
bodies tell the sum of their friction alone. It is shared in proportion to μ_s N, and holds while |ΣF| ≤ Σ μ_s N.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import pairwise
from typing import Any

from kane import expect
from kane.errors import ModelError
from kane.expr.build import add, div, mul, neg, sqrt, sub, sum_of
from kane.expr.differentiation import time_derivative
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, Parameter, Rate, Reaction, word
from kane.expr.visit import substituted
from kane.model.constraints import Constraint, configuration_constraint, motion_constraint, reaction
from kane.model.declarations import Event
from kane.model.joints.contact import Contact
from kane.model.joints.joint import Joint
from kane.model.loads import Load
from kane.model.system_checks import listed
from kane.numeric.sampling import SEEDS, sample
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

LAWS = ("stronge", "poisson", "newton")
_NO_FRICTION = 1e-300
"""What is shared where Σ μ_s N is zero: nothing."""


class ContactMode(IntEnum):
    """What a contact does in a mode of a system; a contact without friction STICKs where it is closed.

    HELD: it sticks with the last one before it in the list that rubs and has the mode STICK.
    """

    SEPARATED = 0
    STICK = 1
    STRAIGHT = 2
    SLIP = 3
    HELD = 4

    @property
    def word(self) -> str:
        """As it is shown: separated, stick or slip."""
        return ("separated", "stick", "slip", "slip", "stick")[self]


Modes = tuple[ContactMode, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ContactLaw(Immutable):
    """A contact with its laws, from `kn.contact`, `kn.stop`, `kn.rope` or `kn.stiction`.

    Attributes
    ----------
    name : its name
    gap : g ≥ 0, None where coordinates keep it closed, or nothing presses
    slips : velocities of slip that vanish where it sticks
    normal_force : N, the multiplier of the gap or a reaction of the system; None where friction has a given size
    friction_forces : F_k along each slip, on the particle in contact
    static, kinetic : μ_s and μ_k; sizes, N or N m, where nothing presses
    restitution : e of impacts
    law : which restitution it is: "stronge" (energetic), "poisson" or "newton"
    direction : the numbers d_k that a straight slip goes along
    slowest : the slip below which it is straight
    slack : by how much the gap is below zero where it closes: what rounding leaves of one that has opened without speed
    """

    name: str
    gap: Constraint | None
    slips: tuple[Constraint, ...]
    normal_force: Reaction | None
    friction_forces: tuple[Reaction, ...]
    static: Expr
    kinetic: Expr
    restitution: Expr
    law: str
    direction: tuple[Parameter, ...]
    slowest: Parameter
    slack: Parameter

    def __repr__(self) -> str:
        friction = f", μ = {self.kinetic}" if self.slips else ""
        return f"ContactLaw({self.name!r}{friction}, e = {self.restitution})"

    @property
    def rows(self) -> tuple[Constraint, ...]:
        """Its gap, if it has one, and its slips."""
        return (*(() if self.gap is None else (self.gap,)), *self.slips)

    @property
    def pressing(self) -> Expr:
        """N, 1 where friction has a given size."""
        return ONE if self.normal_force is None else self.normal_force

    @property
    def most(self) -> Expr:
        """μ_s N, up to which it sticks."""
        return mul(self.static, self.pressing)

    def sliding_friction(self, mode: ContactMode) -> dict[Expr, Expr]:
        """F_k by their symbols where it slips."""
        size = neg(mul(self.kinetic, self.pressing))
        return {f: mul(size, d) for f, d in zip(self.friction_forces, self.along(mode), strict=True)}

    def along(self, mode: ContactMode) -> tuple[Expr, ...]:
        """The unit vector of the slip."""
        if mode is ContactMode.STRAIGHT:
            return self.direction
        return tuple(c.expr / sqrt(self.square) for c in self.slips)

    @property
    def square(self) -> Expr:
        """|v|²."""
        return sum_of(mul(c.expr, c.expr) for c in self.slips)


def _law(
    name: str,
    gap: Constraint | None,
    slips: Sequence[Constraint],
    normal: Reaction | None,
    friction: tuple[Any, Any],
    restitution: Any = 0,
    law: str = LAWS[0],
) -> ContactLaw:
    """A law whose numbers are admissible where parameters have their defaults."""
    expect.instance(name, str, "a text as the name of a contact")
    expect.that(name, "a name of a contact", name)
    kinetic = as_expr(friction[0])
    static = kinetic if friction[1] is None else as_expr(friction[1])
    e = as_expr(restitution)
    check_numbers(name, *(_default(x) for x in (static, kinetic, e)))
    expect.that(law in LAWS, f"law= of {name!r}, one of {', '.join(LAWS)}", law)
    rows = () if kinetic is ZERO and static is ZERO else tuple(c for c in slips if c.expr is not ZERO)
    label = word(name)
    if normal is None and gap is not None:
        normal = reaction(f"N_{label}", constraint=gap)
    marks = [""] if len(rows) == 1 else [f"_{k}" for k in range(1, len(rows) + 1)]
    directions = tuple(Parameter.declare(f"d_{label}{k}", 0.0, "", f"direction of the slip of {name}") for k in marks)
    return ContactLaw(
        name,
        gap,
        rows,
        normal,
        tuple(reaction(f"F_{label}{k}", constraint=c) for k, c in zip(marks, rows, strict=True)),
        static,
        kinetic,
        e,
        law,
        directions,
        Parameter.declare(f"v_{label}", 0.0, "", f"slip below which {name} slips straight on"),
        Parameter.declare(f"g_{label}", 0.0, "", f"rounding of the gap of {name}"),
    )


def _default(e: Expr) -> float | None:
    """The value at parameters' defaults, None where one has none."""
    symbols = free_symbols([e])
    if any(not isinstance(s, Parameter) or s.default is None for s in symbols):
        return None
    return float(sample([e], SEEDS[0])[0])


def check_numbers(name: str, static: float | None, kinetic: float | None, e: float | None) -> None:
    """Refuse coefficients that are no friction, or no restitution."""
    for what, value in (("μ_s", static), ("μ_k", kinetic)):
        right = value is None or value >= 0
        expect.that(right, f"{what} ≥ 0 of the contact {name!r}", came=f"{value}", cure="Give 0 where it is smooth.")
    ordered = static is None or kinetic is None or kinetic <= static
    cure = "Exchange them, or give mu= alone for both."
    expect.that(ordered, f"μ_k ≤ μ_s of the contact {name!r}", came=f"μ_k = {kinetic} and μ_s = {static}", cure=cure)
    right = e is None or 0 <= e <= 1
    cure = "0 is an impact without rebound, 1 one without loss."
    expect.that(right, f"a restitution from 0 to 1 of the contact {name!r}", came=f"{e}", cure=cure)


def contact(
    at: Contact,
    mu: Any = 0,
    *,
    static: Any = None,
    restitution: Any = 0,
    law: str = LAWS[0],
    normal: Reaction | None = None,
    name: str = "",
) -> ContactLaw:
    """A contact that sticks or rolls, slips, separates and hits, by one declaration: list it in `System(contacts=[…])`.

    Parameters
    ----------
    at : where bodies touch: from `kn.joints.point_on_plane`, `disk_on_plane`, `sphere_on_plane`, `torus_on_plane`, `sphere_on_sphere`
    mu : coefficient of sliding friction μ_k
    static : coefficient of static friction μ_s ≥ μ_k; μ_k unless given
    restitution : e, from 0 to 1
    law : of restitution: "stronge" (of energies), "poisson" (of impulses) or "newton" (of velocities)
    normal : the normal force as a reaction, where the coordinates keep the contact closed: the motion ends where it falls to zero
    name : by default that of the place

    Raises
    ------
    ModelError
        if 0 ≤ μ_k ≤ μ_s or 0 ≤ e ≤ 1 does not hold, or nothing presses: no gap that can open, and no normal reaction
    """
    expect.instance(at, Contact, "a place of contact", "Make one with kn.joints.point_on_plane, sphere_on_plane, ….")
    label = name or at.name
    moves = any(isinstance(s, Coordinate | Rate) for s in free_symbols([at.height.expr]))
    if normal is None and not moves:
        raise ModelError(
            f"Expected a gap of the contact {label!r} that coordinates change, got {at.height.expr}: they keep it closed, and nothing "
            "tells what presses. Bring the normal force into evidence and give it: normal=kn.reaction(name, at=…, along=…)."
        )
    gap = None if normal is not None else at.height
    return _law(label, gap, at.rolling, normal, (mu, static), restitution, law)


def stop(name: str, gap: Any, *, restitution: Any = 0, law: str = LAWS[0]) -> ContactLaw:
    """A one-sided stop: an expression of coordinates and time that stays at or above zero, such as q_max − q.

    Its multiplier, `normal_force`, is the generalized force that holds it.
    """
    row = gap if isinstance(gap, Constraint) else configuration_constraint(name, gap)
    _check_moves(name, row.expr)
    return _law(name, row, (), None, (0, None), restitution, law)


def rope(name: str, points: Sequence[Point], length: Any, *, restitution: Any = 0, law: str = LAWS[0]) -> ContactLaw:
    """A massless rope of the given length through points in order, slack or taut: Σ|r_i+1 − r_i| ≤ L.

    Points between the ends are pulleys without friction and of no size. `normal_force` is the tension.
    """
    through = expect.items(points, f"points of the rope {name!r}", "Write [P, Q].")
    expect.instances(through, Point, f"points of the rope {name!r}")
    expect.that(len(through) > 1, f"two points or more of the rope {name!r}", came=str(len(through)))
    pulls: dict[Point, Vector] = {}
    left = as_expr(length)
    for p, q in pairwise(through):
        r = q.position(p)
        size = r.magnitude()
        left = sub(left, size)
        for point, v in ((p, r / size), (q, -(r / size))):
            pulls[point] = pulls.get(point, Vector()) + v
    _check_moves(name, left)
    row = Constraint(name, "configuration", left, tuple(pulls.items()), (), "N", time_derivative(as_expr(length)))
    return _law(name, row, (), None, (0, None), restitution, law)


def _check_moves(name: str, gap: Expr) -> None:
    moving = any(isinstance(s, Coordinate) for s in free_symbols([gap]))
    cure = "Write what must stay at or above zero, as x_max - x."
    expect.that(moving, f"a gap of {name!r} that coordinates change", came=str(gap), cure=cure)


def stiction(
    joint: Joint, size: Any, *, static: Any = None, normal: Reaction | None = None, name: str = ""
) -> ContactLaw:
    """Dry friction in a pin or slider that sticks: up to `static` it holds the joint, and of `size` it is against its rate.

    Parameters
    ----------
    joint : a pin or a slider
    size : of the torque (N m) or force (N) where it slips; with `normal`, the coefficient μ_k
    static : up to which it sticks; `size` unless given
    normal : the reaction that presses, which must stay positive; friction is μ N then
    name : by default "stiction in <joint>"
    """
    kind = getattr(joint, "kind", None)
    expect.that(kind in ("pin", "slider"), "stiction in a pin or slider joint", joint, "Use kn.clutch for two frames.")
    label = name or f"stiction in {joint.name}"
    if kind == "pin":
        return clutch(label, joint.frame, joint.parent, joint.axis, size, static=static, normal=normal)
    rate = joint.velocity.dot(joint.axis)
    row = replace(motion_constraint(label, rate), forces=((joint.point, joint.axis), (joint.at, -joint.axis)), unit="N")
    return _law(label, None, (row,), normal, (size, static))


def clutch(
    name: str,
    frame: Frame,
    other: Frame,
    axis: Vector,
    size: Any,
    *,
    static: Any = None,
    normal: Reaction | None = None,
) -> ContactLaw:
    """A clutch, a brake or a belt's pulley: a torque between two frames about an axis, of a given size where they slip.

    `size` and `static` may hold inputs: a clutch that is pressed.
    """
    for x in (frame, other):
        expect.instance(x, Frame, f"two frames of {name!r}")
    rate = frame.angular_velocity(other).dot(axis)
    expect.that(rate is not ZERO, f"frames of {name!r} that turn about {axis}", came="none of their rates in it")
    row = replace(motion_constraint(name, rate), torques=((frame, axis), (other, -axis)), unit="N*m")
    return _law(name, None, (row,), normal, (size, static))


def listed_contacts(given: Any) -> tuple[ContactLaw, ...]:
    """Contacts of different names and places."""
    contacts: tuple[ContactLaw, ...] = listed("contacts", given, ContactLaw, "kn.contact, kn.stop, …", named=True)
    gaps: dict[Expr, str] = {}
    for c in contacts:
        if c.gap is None:
            continue
        if c.gap.expr in gaps:
            raise ModelError(
                f"Expected contacts at different places, got {gaps[c.gap.expr]!r} and {c.name!r} with one gap. Leave one out."
            )
        gaps[c.gap.expr] = c.name
    return contacts


def slip_parameters(contacts: Sequence[ContactLaw]) -> tuple[Parameter, ...]:
    """The numbers that modes of contacts have beside the parameters: directions of slip, and the slowest slips."""
    return tuple(p for c in contacts if c.slips for p in (*c.direction, c.slowest))


def laws_of(contacts: Sequence[ContactLaw]) -> list[Expr]:
    """Their coefficients."""
    return [x for c in contacts for x in (c.static, c.kinetic, c.restitution)]


def given_modes(contacts: Sequence[ContactLaw], given: Any) -> Modes:
    """The modes of all contacts, in order, of those that are given by contact or name."""
    if not isinstance(given, Mapping):
        every = tuple(ContactMode(m) for m in given)
        expect.that(len(every) == len(contacts), f"modes of all {len(contacts)} contacts", came=str(len(every)))
        return every
    names = {c.name: c for c in contacts}
    told: dict[str, ContactMode] = {}
    for key, mode in given.items():
        name = key.name if isinstance(key, ContactLaw) else key
        expect.that(name in names, f"contacts among {', '.join(names) or 'none'}", key)
        kinds = {m.name.lower(): m for m in ContactMode}
        right = isinstance(mode, ContactMode) or mode in kinds
        expect.that(right, f"a mode of the contact {name!r} among {', '.join(kinds)}", mode)
        told[name] = mode if isinstance(mode, ContactMode) else kinds[mode]
    return tuple(told.get(c.name, resting(c)) for c in contacts)


def resting(c: ContactLaw) -> ContactMode:
    """The mode of a contact that is told nothing of."""
    return ContactMode.STICK if c.gap is None else ContactMode.SEPARATED


# Modes ---------------------------------------------------------------------------------------------------------------------


def additions(contacts: Sequence[ContactLaw], modes: Modes) -> dict[str, list[Any]]:
    """What modes add to a system's arguments: constraints, friction, reactions, and events that end them."""
    found: dict[str, list[Any]] = {name: [] for name in ("holonomic", "nonholonomic", "loads", "reactions", "events")}
    for c, mode, group in zip(contacts, modes, groups(contacts, modes), strict=True):
        for name, items in _added(c, mode, group):
            found[name] += items
    return found


Group = tuple[ContactLaw, ...]


def groups(contacts: Sequence[ContactLaw], modes: Modes) -> list[Group]:
    """For each contact those that stick by its row, itself first; () of those that are held with another."""
    found: list[Group] = []
    leader = 0
    for k, (c, mode) in enumerate(zip(contacts, modes, strict=True)):
        found.append(() if mode is ContactMode.HELD else (c,))
        if mode is ContactMode.STICK and c.slips:
            leader = k
        elif mode is ContactMode.HELD:
            found[leader] = (*found[leader], c)
    return found


def _added(c: ContactLaw, mode: ContactMode, group: Group) -> Iterator[tuple[str, Iterable[Any]]]:
    yield "events", _endings(c, mode, group)
    if mode is ContactMode.SEPARATED:
        return
    yield "holonomic", [c.gap] if c.gap else []
    yield "reactions", [] if c.normal_force is None else [c.normal_force]
    if mode is ContactMode.STICK:
        yield "nonholonomic", c.slips
        yield "reactions", c.friction_forces
    elif mode is not ContactMode.HELD:
        yield "loads", [friction(c, mode)]


def friction(c: ContactLaw, mode: ContactMode) -> Load:
    """The friction of a contact that slips."""
    sizes = c.sliding_friction(mode)
    forces: list[tuple[Point, Vector]] = []
    torques: list[tuple[Frame, Vector]] = []
    for row, f in zip(c.slips, c.friction_forces, strict=True):
        forces += [(p, v * sizes[f]) for p, v in row.forces]
        torques += [(frame, v * sizes[f]) for frame, v in row.torques]
    return Load(f"friction of {c.name}", tuple(forces), tuple(torques))


def _endings(c: ContactLaw, mode: ContactMode, group: Group) -> Iterator[Event]:
    """The events that end a mode of a contact."""

    def event(what: str, quantity: Expr, direction: int = -1) -> Event:
        return Event(f"{c.name} {what}", quantity, 0.0, direction, True)

    if mode is ContactMode.SEPARATED:
        assert c.gap is not None
        yield event("closes", add(c.gap.expr, c.slack))
        return
    if c.normal_force is not None:
        yield event("opens", c.normal_force)
    if mode is ContactMode.STICK and c.slips:
        held = sum_of(other.most for other in group)
        square = sum_of(mul(f, f) for f in c.friction_forces)
        yield event("slips", sub(mul(held, held), square))
    elif mode is ContactMode.STRAIGHT:
        onward = sum_of(mul(d, v.expr) for d, v in zip(c.direction, c.slips, strict=True))
        yield event("sticks", onward)
        if len(c.slips) > 1:
            yield event("turns", sub(onward, c.slowest), 1)
    elif mode is ContactMode.SLIP:
        yield event("slows", sub(sqrt(c.square), c.slowest))


def in_mode(contacts: Sequence[ContactLaw], modes: Modes, exprs: Sequence[Expr]) -> Sequence[Expr]:
    """Expressions with N and F of the contacts as their modes have them, where these are no unknowns."""
    if not modes:
        return exprs
    forces: dict[Expr, Expr] = {}
    for c, mode, group in zip(contacts, modes, groups(contacts, modes), strict=True):
        if mode is ContactMode.SEPARATED:
            own = (*(() if c.normal_force is None else (c.normal_force,)), *c.friction_forces)
            forces |= dict.fromkeys(own, ZERO)
        elif mode in (ContactMode.STRAIGHT, ContactMode.SLIP):
            forces |= c.sliding_friction(mode)
        whole = add(sum_of(other.most for other in group), as_expr(_NO_FRICTION))
        for other in group if len(group) > 1 else ():
            pairs = zip(other.friction_forces, c.friction_forces, strict=True)
            forces |= {f: mul(total, div(other.most, whole)) for f, total in pairs}
    return [substituted(e, forces) for e in exprs] if forces else exprs

# SPDX-License-Identifier: BSD-3-Clause
"""Constraints: configuration constraints f(q, t) = 0 and motion constraints f(q, q̇, t) = 0, affine in the rates.

A constraint declared with points or frames has known forces: `forces` on points and `torques` on frames act for a multiplier of one,
and their power is the constraint's rate,

    ḟ = Σ F·v + Σ T·ω      (a motion constraint's f itself),

on and off the constraint, except for the contribution of lengths that depend on time. Rows A of A u + b = 0 thus come from partial
velocities, the multiplier is a force or torque, and all reactions of the system take it into account.

Noncontributing forces are brought into evidence by named reactions or by explicit auxiliary speeds. A reaction cuts the tree:
everything connected through its point or frame is the far side, and gets the auxiliary velocity u_a n. The reaction is a pair, +R n on
the far side and −R n on the near one. It has an effect only if it is listed in `System(reactions=…)`.

Declared directions are unit vectors, each fixed in one frame.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

from kane import expect
from kane.errors import ModelError, ReactionError, UnitError, cut
from kane.expr.build import neg
from kane.expr.differentiation import time_derivative
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Parameter, Rate, Reaction, Speed, Time, input_of
from kane.numeric.sampling import SEED, positive, sample
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame, Point, frames_of
from kane.space.vector import Parts, Vector
from kane.units.rules import parse, unit_of


def length(v: Vector) -> float:
    """|v| at default parameters and a random configuration; 1 if a parameter has no default."""
    square = v.dot(v)
    symbols = free_symbols([square])
    if any(isinstance(s, Parameter) and s.default is None for s in symbols):
        return 1.0
    return math.sqrt(sample([square], SEED)[0])


def is_unit(v: Vector) -> bool:
    """Whether |v| = 1."""
    return abs(length(v) - 1) <= DECLARED


def check_unit(v: object, what: str) -> None:
    """Raise a ModelError unless `v` is a unit vector."""
    if not isinstance(v, Vector) or v.is_zero:
        raise ModelError(
            f"Expected a unit vector as the {what}, got {cut(repr(v))}. Write it along axes of a frame, such as N.z."
        )
    if not is_unit(v):
        raise ModelError(f"Expected a unit vector as the {what}, got {v} of length {length(v):.6g}. Use .normalized().")


def home_of(v: Vector, what: str) -> Frame:
    """The frame in which the unit vector `v` is fixed; raises ModelError if `v` is not of unit length, or not fixed in one frame."""
    check_unit(v, what)
    frames = frames_of(v)
    if len(frames) != 1 or not is_constant_in_time(v.scalars()):
        raise ModelError(
            f"Expected the {what} fixed in the one frame that it is written in, got {v}. Make a frame that turns with it and write "
            "it there."
        )
    return frames[0]


Kind = Literal["configuration", "motion"]


@dataclass(frozen=True, slots=True, eq=False)
class ClosureBranch(Immutable):
    """The intended orientation of the closure `name` among those at which all `rows` vanish.

    `cosine` is that of the angle of `what` from this orientation: 1 there, at most 0 at the others.
    """

    name: str
    what: str
    cosine: Expr
    rows: tuple[Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Constraint(Immutable):
    """A constraint f = 0, with the forces and torques that its multiplier exerts per unit.

    `expr` is f, `kind` "configuration" or "motion", `unit` that of the multiplier, and `normal` the normal of the plane for a
    rolling body. `own` is the part of ḟ (or f) beyond the power of the forces and torques; `branch` distinguishes the intended
    orientation from others that satisfy the same equations.
    """

    name: str
    kind: Kind
    expr: Expr
    forces: tuple[tuple[Point, Vector], ...] = ()
    torques: tuple[tuple[Frame, Vector], ...] = ()
    unit: str = ""
    own: Expr = ZERO
    branch: ClosureBranch | None = None
    normal: Vector | None = None

    @property
    def placed(self) -> bool:
        """Whether the constraint has forces or torques: whether the points and frames at which they act are known."""
        return bool(self.forces or self.torques)

    def __repr__(self) -> str:
        f = cut(self.expr)
        return f"Constraint({self.name!r}: {f if f.endswith('…') else f'{f} = 0'}, {self.kind})"


Constraints = tuple[Constraint, ...]


def as_constraints(declared: Any, kind: Kind) -> Constraints:
    """Constraints from one or several of them, or from scalar expressions that must vanish."""
    constraints: list[Constraint] = []
    for item in _each(declared):
        if isinstance(item, Constraint):
            if item.kind != kind:
                other = {"configuration": "holonomic", "motion": "nonholonomic"}[item.kind]
                raise ModelError(f"Expected {kind} constraints here, got {item.name!r}: list it in {other}=.")
            constraints.append(item)
        elif isinstance(item, Vector):
            raise ModelError(
                f"Expected a scalar that must vanish as a {kind} constraint, got the vector {item}. Use .dot(…)."
            )
        else:
            word = "holonomic" if kind == "configuration" else "nonholonomic"
            constraints.append(Constraint(f"{word} {len(constraints) + 1}", kind, as_expr(item)))
    return tuple(constraints)


def _each(declared: Any) -> Iterator[Any]:
    """Declared items, one by one, out of nested lists."""
    if expect.is_list(declared) and not isinstance(declared, Expr):
        for item in declared:
            yield from _each(item)
    else:
        yield declared


def _directions(name: str, along: Sequence[Vector] | Vector) -> Iterable[tuple[str, Vector]]:
    """Unit vectors with the names of their constraints, which are numbered, or x, y and z for three."""
    expected = f"one unit vector or several as the direction of {name!r}"
    vectors = [along] if isinstance(along, Vector) else expect.items(along, expected)
    expect.that(vectors, expected, along)
    marks = {1: [""], 3: [" x", " y", " z"]}.get(len(vectors)) or [f" {k}" for k in range(1, len(vectors) + 1)]
    return zip((name + mark for mark in marks), vectors, strict=True)


def _points(what: str, p: Any, q: Any) -> None:
    for x in (p, q):
        expect.instance(x, Point, f"points to {what}", "Leave the second out where it is the ground at rest.")
        if x.body is None:
            _check_rides(what, x)


def _check_rides(what: str, p: Point) -> None:
    """Raise ModelError for a geometric point without a body: its position in a frame depends on coordinates that orient the frame."""
    for f, r in p.offset.parts:
        turns = set(free_symbols(x for g in f.lineage if g.orientation is not None for x in g.orientation.scalars()))
        both = [str(s) for s in free_symbols(r) if isinstance(s, Coordinate) and s in turns]
        if both:
            raise ModelError(
                f"Expected points of bodies to {what}, got {p.name}, which moves in {f.name} as {', '.join(both)} turns it. Use "
                f"the particle of the body at that position: {p.parent.name if p.parent else 'P'}.fixed_in({f.name}, …)."
            )


def coincident(p: Point, q: Point, along: Sequence[Vector] | Vector, *, name: str = "") -> Constraints:
    """Points `p` and `q` coincide along given unit vectors: configuration constraints (r^p − r^q)·n = 0, one for each n.

    Write n in a frame of the body of `q`, or in the inertial frame: n turns with it. The multiplier is the force along n that the
    body of `q` exerts on that of `p` at the point p.

    Parameters
    ----------
    p, q : the points
    along : one unit vector, or several, each fixed in the frame that it is written in
    name : by default "p = q"; several directions are numbered
    """
    _points("keep together", p, q)
    apart = p.position(q)
    constraints = []
    label = expect.label(name) or f"{p.name} = {q.name}"
    for title, n in _directions(label, along):
        home = home_of(n, f"direction of {label!r}")
        arm = Vector() if home.parent is None else apart.cross(n)
        torques = () if arm.is_zero else ((home, -arm),)
        constraints.append(Constraint(title, "configuration", apart.dot(n), ((p, n), (q, -n)), torques, "N"))
    return tuple(constraints)


def touching(p: Point, ground: Point, *, normal: Vector, name: str = "") -> Constraint:
    """A body touches the plane through `ground` with the normal n: the configuration constraint (r^p − r^ground)·n = 0.

    `p`, made with `fixed_in`, is the particle of the body that is nearest to the plane. The point of contact moves parallel to the
    plane, so that the rate of the constraint is the velocity of the particle along n. `ground` and n are at rest, or fixed in the
    body that carries the plane. The multiplier is the contact force on `p` along n.
    """
    _points("touch", p, ground)
    (height,) = coincident(p, ground, normal, name=name or f"{p.name} on the plane")
    return height


def distance(p: Point, q: Point, length: Any, *, name: str = "") -> Constraint:
    """A massless rod of the given length: (r·r − L²)/(2 L) = 0 with r = r^p − r^q; the multiplier is its thrust on `p` along r/L.

    The length may depend on parameters, inputs and time, not on coordinates.
    """
    _points("keep at a distance", p, q)
    r, size = p.position(q), positive(length, f"a length of {p.name} {q.name}")
    moving = (s for s in free_symbols([size]) if isinstance(s, Coordinate | Rate | Speed) and input_of(s) is None)
    expected = f"a length of {p.name} {q.name} in parameters, inputs and time"
    came, cure = (
        "{} in it: the rod would also act on what changes its length",
        "Use kn.configuration_constraint(name, f).",
    )
    expect.none(moving, expected, came, cure)
    of_time = all(isinstance(s, Time) for s in free_symbols([size]))  # numbers in a function of time have unknown units
    unit = "" if of_time else unit_of(size)
    if unit and parse(unit).exponents != parse("m").exponents:
        raise UnitError(
            f"Expected a length (m) of {p.name} {q.name}, got {cut(size)} [{unit}]. Correct it, or the unit of a symbol in it."
        )
    pull, f = r / size, (r.dot(r) / size - size) / 2
    own = ZERO if is_constant_in_time([size]) else neg(time_derivative(size) * (f / size + 1))
    label = expect.label(name) or f"|{p.name} {q.name}|"
    return Constraint(label, "configuration", f, ((p, pull), (q, -pull)), (), "N", own)


def perpendicular(a: Vector, b: Vector, *, name: str = "") -> Constraint:
    """Unit vectors, each fixed in the frame it is written in, stay perpendicular: a·b = 0; the multiplier is a torque along a × b."""
    label = expect.label(name) or f"{a} ⟂ {b}"
    left, right = (home_of(v, f"direction of {label!r}") for v in (a, b))
    normal = a.cross(b)
    return Constraint(label, "configuration", a.dot(b), (), ((left, normal), (right, -normal)), "N*m")


def parallel(a: Vector, b: Vector, *, across: tuple[Vector, Vector], name: str = "") -> tuple[Constraint, Constraint]:
    """Two unit vectors stay parallel: `a` is perpendicular to the two vectors `across`, fixed in b's frame and perpendicular to b."""
    label = expect.label(name) or f"{a} ∥ {b}"
    expected = f"across=two unit vectors for {label!r}"
    first, second = expect.pair(across, expected)
    check_unit(b, f"direction of {label!r}")
    for v in (first, second):
        check_unit(v, f"direction across {label!r}")
        expect.that(is_unit(b.cross(v)), f"{expected}, perpendicular to {b}", v)
    expect.that(length(first.cross(second)) > DECLARED, f"{expected}, not along each other", across)
    return perpendicular(a, first, name=f"{label} 1"), perpendicular(a, second, name=f"{label} 2")


def no_slip(p: Point, q: Point | None = None, *, along: Sequence[Vector] | Vector, name: str = "") -> Constraints:
    """Particles in contact do not slip: motion constraints (v^p − v^q)·e = 0, one for each unit vector e in `along`.

    `p` and `q` are particles made with `fixed_in`, at the same place now; without `q` the ground is at rest. The multiplier is the
    force on `p` along e.
    """
    _points("keep from slipping", p, p if q is None else q)
    inertial = p.root().frame
    slip = p.velocity(inertial)
    if q is not None:
        slip = slip - q.velocity(inertial)
    label = expect.label(name) or f"no slip of {p.name}"
    constraints = []
    for title, e in _directions(label, along):
        check_unit(e, f"direction of {label!r}")
        pair = ((p, e),) if q is None else ((p, e), (q, -e))
        constraints.append(Constraint(title, "motion", slip.dot(e), pair, (), "N"))
    return tuple(constraints)


def rolling(
    p: Point, q: Point | None = None, *, normal: Vector, along: Vector | None = None, name: str = ""
) -> Constraints:
    """Rolling: the particles in contact, `p` and `q`, have no relative velocity in the plane perpendicular to `normal`.

    Two motion constraints: along `along`, a unit vector in the plane, and along normal × along. By default `along` is an axis of
    the frame that `normal` is written in, or normal × the only axis perpendicular to it. The choice of coordinates, or a
    configuration constraint such as `touching`, must keep the bodies in contact. Without `q` the ground is at rest.
    """
    _points("roll", p, p if q is None else q)
    label = expect.label(name) or f"rolling of {p.name}"
    check_unit(normal, f"normal of {label!r}")
    if along is None:
        frame = home_of(normal, f"normal of {label!r}")
        axes = [a for a in (frame.x, frame.y, frame.z) if a.dot(normal) is ZERO]
        if len(axes) == 1:  # an incline
            axes = [normal.cross(axes[0]), axes[0]]
        if len(axes) != 2:
            raise ModelError(f"Expected along=unit vector in the plane across {normal} for {label!r}, got none.")
    else:
        axes = [along, normal.cross(along)]
    return tuple(replace(c, normal=normal) for c in no_slip(p, q, along=axes, name=label))


_NAME = "a text as the name of a constraint"


def configuration_constraint(name: str, f: Any) -> Constraint:
    """A named configuration constraint f(q, t) = 0. Prefer `coincident`, `distance`, …, whose forces have known points."""
    return Constraint(expect.name(name, _NAME), "configuration", as_expr(f))


def motion_constraint(name: str, f: Any) -> Constraint:
    """A named motion constraint f(q, q̇, t) = 0, affine in q̇. Prefer `no_slip` or `rolling`, whose forces have known points."""
    return Constraint(expect.name(name, _NAME), "motion", as_expr(f))


class Cut(NamedTuple):
    """The place of a reaction or auxiliary speed: a point or a frame, and a direction."""

    at: Point | Frame
    parts: Parts

    @property
    def along(self) -> Vector:
        """The direction as a vector."""
        return Vector(self.parts)


def _cut(kind: str, name: str, at: Point | None, frame: Frame | None, along: Vector | None) -> Cut:
    expected = f"{kind} {name!r} at=point for a force or frame=frame for a torque"
    came = "neither" if at is None else "both"
    expect.that((at is None) != (frame is None), expected, came=came, error=ReactionError)
    place: Any = frame if at is None else at
    expected = f"at=Point or frame=Frame for {kind} {name!r}"
    expect.instance(place, Frame if at is None else Point, expected, error=ReactionError)
    if place.parent is None:
        raise ReactionError(
            f"Expected a point or frame of {kind} {name!r} that has a near side, got {place!r}, which is a root. Make the cut "
            f"explicit: {place.name}.{'at' if at is not None else 'rotate'}(…)."
        )
    geometric, came = getattr(place, "body", None) is None, f"{place.name}, a particle of a body, which has no far side"
    expect.that(geometric, f"a geometric point for {kind} {name!r}", came=came, error=ReactionError)
    expected = f"along=unit vector for {kind} {name!r}"
    if not isinstance(along, Vector) or along.is_zero:
        raise expect.refusal(ReactionError, expected, cut(repr(along)))
    if not is_unit(along):
        raise ReactionError(
            f"Expected {expected}, got {cut(repr(along))} of length {length(along):.6g}: the reaction would not be measured in "
            "units of force. Use along.normalized()."
        )
    return Cut(place, along.parts)


def reaction(
    name: str,
    at: Point | None = None,
    along: Vector | None = None,
    frame: Frame | None = None,
    unit: str = "",
    *,
    constraint: Constraint | None = None,
) -> Reaction:
    """A noncontributing force (`at` a point) or torque (on a `frame`) to bring into evidence: its measure number along a unit vector.

    The near side, towards the root of the tree, exerts it on the far side. With `constraint` it is the multiplier of that
    constraint. With neither it is an unknown without a place, for use with explicit auxiliary speeds. List it in
    `System(reactions=[…])`.
    """
    if constraint is not None:
        other: object = constraint
        alone = isinstance(other, Constraint) and all(x is None for x in (at, frame, along))
        expected = f"constraint=one Constraint, and neither at= nor frame=, for the reaction {name!r}"
        expect.that(alone, expected, other, error=ReactionError)
        return Reaction.declare(name, None, unit or constraint.unit, "", constraint)
    if at is None and frame is None and along is None:
        return Reaction.declare(name, None, unit, "", None)
    place = _cut("the reaction", name, at, frame, along)
    return Reaction.declare(name, None, unit or ("N" if at is not None else "N*m"), "", place)


def auxiliary_speed(
    name: str, at: Point | None = None, along: Vector | None = None, frame: Frame | None = None
) -> AuxiliarySpeed:
    """An auxiliary speed u_a: it adds u_a n to the velocity of all that follows the point (or frame) in the tree, and is always zero.

    n is the unit vector `along`. List it in `System(auxiliary_speeds=…)`, with a `kn.reaction(name)` for the force (torque) that it
    brings into evidence, and declare this force as a load.
    """
    cut = _cut("the auxiliary speed", name, at, frame, along)
    return AuxiliarySpeed.declare(name, None, "m/s" if at is not None else "rad/s", "", cut)


def cut_of(symbol: Expr) -> Cut | None:
    """The cut of a reaction or auxiliary speed; None for one without a place."""
    place = getattr(symbol, "place", None)
    return place if isinstance(place, Cut) else None


def constraint_of(symbol: Expr) -> Constraint | None:
    """The constraint of which a reaction is the multiplier; None for other symbols."""
    place = getattr(symbol, "place", None)
    return place if isinstance(place, Constraint) else None

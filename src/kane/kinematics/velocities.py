# SPDX-License-Identifier: BSD-3-Clause
"""Partial velocities and bias accelerations of every frame and point (Kane & Levinson 1985, sec. 2.14).

    ω = Σ ω_r u_r + ω_t,   α = Σ ω_r u̇_r + α_b        v = Σ v_r u_r + v_t,   a = Σ v_r u̇_r + a_b

Partial velocities are built along the tree of frames and points, never by differentiation of an expanded velocity. The bias α_b, a_b
is the acceleration at u̇ = 0.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from kane.expr.differentiation import tangent, time_derivative
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.ops import CONST
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Speed, Symbol, Time, input_of, rate
from kane.kinematics.aligned import AS_DECLARED, Aligned
from kane.kinematics.speeds import Forms, Matching, Sample, ScalarForm, Speeds
from kane.model.constraints import cut_of
from kane.space.frame import Point
from kane.space.rotation import NOTHING, Basis, Triple
from kane.space.vector import Vector
from kane.tree.triples import triple

Partials = dict[Expr, Vector]


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """The rotation of a frame, or the translation of a point, in the inertial frame.

    `partials` are the partial velocities by speed, auxiliary speeds included, and `rest` the remainder free of speeds; `spin` is the
    angular velocity of a frame. `made` computes the bias, after that of `before`, the motion of the parent.
    """

    partials: Partials
    rest: Vector
    made: Callable[[], Vector] = Vector
    spin: Vector | None = None
    before: "Motion | None" = None
    _bias: Vector | None = field(default=None, init=False)

    @property
    def bias(self) -> Vector:
        """The acceleration at u̇ = 0, computed when first read, ancestors first."""
        if self._bias is None:
            waiting: list[Motion] = []
            motion: Motion | None = self
            while motion is not None and motion._bias is None:
                waiting.append(motion)
                motion = motion.before
            for m in reversed(waiting):
                object.__setattr__(m, "_bias", m.made())
        assert self._bias is not None
        return self._bias

    def with_bias(self, bias: Vector) -> "Motion":
        """The motion with another acceleration at u̇ = 0."""
        return replace(self, made=lambda: bias, before=None)

    @property
    def total(self) -> Vector:
        """The velocity at zero auxiliary speeds: `spin` of a frame; of a point the sum of its linear form."""
        return velocity_form(self).gathered() if self.spin is None else self.spin

    @property
    def is_still(self) -> bool:
        """Whether the velocity is zero at zero auxiliary speeds."""
        return self.rest.is_zero and all(isinstance(s, AuxiliarySpeed) for s in self.partials)


_STILL = Motion({}, Vector(), spin=Vector())


@dataclass(frozen=True, slots=True, eq=False)
class ContactPoint:
    """A particle of a body that touches the particle `other` (None: the ground) and has the velocity Σ n w relative to it.

    `directions` are the n by speeds w, which constraints make zero.
    """

    particle: Point
    body: Basis
    other: Point | None
    directions: Mapping[Speed, Vector]


class Following(NamedTuple):
    """A dependent speed, u = Σ row · u_I + rest, and its u̇ at u̇_I = 0, `bias`."""

    row: Mapping[Expr, Expr]
    rest: Expr
    bias: Expr


class _Swing(NamedTuple):
    """An arm fixed or sliding in a rotating frame: the frame's motion, the arm, and the forms of its rates; None if it is fixed."""

    spin: Motion
    arm: Vector
    forms: Forms | None


@dataclass(frozen=True, slots=True, eq=False)
class Kinematics:
    """The motions of all frames and points of one system, memoised; every method is a pure function of the system and its speeds.

    `homes` is the frame along which the angular velocity of a body frame is written, if another. `contacts` are points whose velocity
    is computed from a contact point of their body. `cuts` are the auxiliary speeds by frame or point. Dependent speeds `following`
    others have no partial velocities; those of the others are then the nonholonomic ones, ṽ_r = v_r + Σ_D v_D A_n[D, r] (Kane &
    Levinson 1985, sec. 2.14).
    """

    speeds: Speeds
    cuts: dict[Basis | Point, tuple[tuple[AuxiliarySpeed, Vector], ...]]
    sample: Sample
    homes: dict[Basis, Basis] = field(default_factory=dict)
    aligned: Aligned = AS_DECLARED
    contacts: Mapping[Point, ContactPoint] = field(default_factory=dict)
    following: Mapping[Expr, Following] = field(default_factory=dict)
    matching: Matching = field(init=False)
    _frames: dict[Basis, Motion] = field(default_factory=dict)
    _points: dict[Point, Motion] = field(default_factory=dict)
    _drift: dict[Expr, Expr] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "matching", Matching(self.speeds, self.sample))

    # Scalars --------------------------------------------------------------------------------------------------------

    def drift(self, e: Expr, known: Mapping[Expr, Expr] | None = None) -> Expr:
        """de/dt at u̇ = 0, with q̇ = W u + X; `known` gives the derivatives of some subexpressions."""
        return ZERO if e.op is CONST else tangent(e, self._leaf_drift, {**known} if known else self._drift)

    def _leaf_drift(self, leaf: Expr) -> Expr:
        if isinstance(leaf, Time):
            return ONE
        if leaf in self.following:
            return self.following[leaf].bias
        return (
            rate(leaf)
            if isinstance(leaf, Symbol) and input_of(leaf) is not None
            else self.matching.rates.get(leaf, ZERO)
        )

    def _vectors(self, forms: Iterable[ScalarForm], frame: Basis) -> tuple[Partials, Vector]:
        """Partial velocities and remainder of a velocity with three measure numbers along a frame."""
        columns: dict[Expr, list[Expr]] = {}
        rests: list[Expr] = []
        for i, form in enumerate(forms):
            for s, c in form.coefficients.items():
                columns.setdefault(s, list(NOTHING))[i] = c
            rests.append(form.rest)
        partials = {s: Vector(((frame, triple(t)),)) for s, t in columns.items()}
        rest = Vector(((frame, triple(rests)),))
        for u, by in self.following.items():
            v = partials.pop(u, None)
            if v is not None:
                for s, c in by.row.items():
                    _accumulate(partials, s, v * c)
                rest = rest + v * by.rest
        return partials, rest

    def with_following(
        self,
        following: Mapping[Expr, Following],
        contacts: Mapping[Point, ContactPoint],
        vanishing: frozenset[Expr] = frozenset(),
    ) -> "Kinematics":
        """The motions with some speeds dependent (`following`) or zero (`vanishing`), without auxiliary speeds."""
        other = Kinematics(self.speeds, {}, self.sample, self.homes, self.aligned, contacts, following)
        object.__setattr__(other, "matching", self.matching.without(vanishing))
        return other

    # Frames ---------------------------------------------------------------------------------------------------------

    def frame(self, frame: Basis) -> Motion:
        """The rotation of a frame."""
        frame = self.aligned.owners.get(frame, frame)
        for f in reversed(frame.lineage):
            if f not in self._frames:
                self._frames[f] = self._rotation(f)
        return self._frames[frame]

    def _rotation(self, frame: Basis) -> Motion:
        o = frame.orientation
        if o is None:
            return _STILL
        base = self._frames[o.base]
        auxiliary: Partials = {s: v for s, v in base.partials.items() if isinstance(s, AuxiliarySpeed)}
        # Auxiliary speeds of the frames between this one and its base (coaxial rotations share a base) move this frame too.
        between: Basis | None = frame
        while between is not None and between is not o.base:
            for u, along in self.cuts.get(between, ()):
                auxiliary[u] = auxiliary.get(u, Vector()) + self.aligned.vector(along)
            between = between.parent
        matched = self._matched(frame, auxiliary)
        if matched is not None:
            return matched
        basis, rates = self.aligned.rates(frame)
        home = self.homes.get(frame, basis)
        own = self.matching.forms(rates)
        partials, rest = self._vectors(own, basis)
        for s, v in base.partials.items():
            if s not in auxiliary:
                partials[s] = (v + partials[s]).gathered() if s in partials else v
        partials.update(auxiliary)
        a, b, c = (f.total() for f in own)
        relative = Vector(((basis, (a, b, c)),))
        total = base.total.express(home) + relative.express(home)

        def bias() -> Vector:
            swing = relative.map(self.drift)
            return base.bias.express(home) + (base.total.cross(relative) + swing).express(home)

        return Motion(partials, base.rest + rest, bias, total, base)

    def _matched(self, place: Basis | Point, along_the_tree: Partials) -> Motion | None:
        """The motion along a frame in which its measure numbers match rows of Y; None if there is no such frame.

        The bias is the drift of the measure numbers plus ω × total.
        """
        found = self.matching.match(place) if self.speeds.nontrivial else None
        if found is None:
            return None
        target, forms = found
        partials, rest = self._vectors(forms, target)
        partials.update({s: v for s, v in along_the_tree.items() if isinstance(s, AuxiliarySpeed)})
        a, b, c = (f.total() for f in forms)
        aligned = self.aligned.vector
        along = Vector(((target, (a, b, c)),))
        total = aligned(along)

        def bias() -> Vector:
            own = aligned(along.map(self.drift))
            return (own if target is place else own + self.frame(target).total.cross(total)).gathered()

        return Motion({s: aligned(v) for s, v in partials.items()}, aligned(rest), bias, total)

    # Points ---------------------------------------------------------------------------------------------------------

    def of(self, place: Point | Basis) -> Motion:
        """The translation of a point or the rotation of a frame."""
        return self.point(place) if isinstance(place, Point) else self.frame(place)

    def point(self, point: Point) -> Motion:
        """The translation of a point."""
        for p in reversed(point.ancestry(self._points)):
            self._points[p] = self._translation(p)
        return self._points[point]

    def _translation(self, point: Point) -> Motion:
        if point.parent is None:
            return _STILL
        start = self._points[point.parent]
        partials, rest = dict(start.partials), start.rest
        swings: list[_Swing] = []
        for frame, offset in point.offset.parts:
            spin = self.frame(frame if point.body is None else point.body)
            f, r = self.aligned.triple(frame, offset)
            arm, forms = Vector(((f, r),)), None
            rest = _swept(partials, rest, spin, arm)
            if point.body is None and _moves(r):
                forms = self.matching.forms(triple(map(time_derivative, r)))
                slide, slide_rest = self._vectors(forms, f)
                for s, v in slide.items():
                    _accumulate(partials, s, v)
                rest = rest + slide_rest
            swings.append(_Swing(spin, arm, forms))
        for u, along in self.cuts.get(point, ()):
            _accumulate(partials, u, self.aligned.vector(along))
        if point in self.contacts:
            return self._through(self.contacts[point], partials)
        matched = self._matched(point, partials) if point.body is None else None
        if matched is not None:
            return matched
        partials = {s: v for s, v in partials.items() if not v.is_zero}

        def bias() -> Vector:
            total = self._swung(start.bias, swings)
            # the bias is multiplied by the partial velocities: write it along their frame if they have one
            frames = {f for s, v in partials.items() if not isinstance(s, AuxiliarySpeed) for f, _ in v.parts}
            return total.express(*frames) if len(frames) == 1 else total.gathered()

        return Motion(partials, rest.gathered(), bias, before=start)

    def _swung(self, bias: Vector, swings: Iterable[_Swing]) -> Vector:
        """The acceleration at u̇ = 0 at the end of a chain of arms, from that at its start."""
        for spin, arm, forms in swings:
            bias = bias + spin.bias.cross(arm) + spin.total.cross(spin.total.cross(arm))
            if forms is not None:
                ((f, r),) = arm.parts
                # unless it is a sum of whole speeds, the drift of r is shorter than the form's total, and is shared with other readers
                a, b, c = (form.total() if form.exact else self.drift(x) for form, x in zip(forms, r, strict=True))
                sliding = Vector(((f, (a, b, c)),))
                bias = bias + spin.total.cross(sliding) * 2 + sliding.map(self.drift)
        return bias

    def _through(self, contact: ContactPoint, along_the_tree: Partials) -> Motion:
        """v = v^Ĉ + ω × r of a point, from the known v^Ĉ of the contact point Ĉ of its body, at −r from the point."""
        particle, other = contact.particle, contact.other
        spin = self.frame(contact.body)
        touched = _STILL if other is None else self.point(other)
        partials = {s: v for s, v in touched.partials.items() if not isinstance(s, AuxiliarySpeed)}
        partials.update({w: self.aligned.vector(n) for w, n in contact.directions.items()})
        rest, shift = touched.rest, Vector()
        for frame, offset in particle.offset.parts:
            f, r = self.aligned.triple(frame, offset)
            arm = -Vector(((f, r),))
            rest = _swept(partials, rest, spin, arm)
            shift = shift + spin.total.cross(arm)
        partials.update({s: v for s, v in along_the_tree.items() if isinstance(s, AuxiliarySpeed)})

        def bias() -> Vector:
            own = self.turning(shift.gathered())
            return (own if other is None else own + self.velocity_bias(other)).gathered()

        return Motion({s: v for s, v in partials.items() if not v.is_zero}, rest.gathered(), bias)

    def turning(self, v: Vector) -> Vector:
        """dv/dt in the inertial frame at u̇ = 0."""
        total = Vector()
        for part in v.parts:
            along = Vector((part,))
            total = total + along.map(self.drift) + self.frame(part[0]).total.cross(along)
        return total.gathered()

    def velocity_bias(self, place: Point | Basis) -> Vector:
        """The time derivative of a velocity or angular velocity at u̇ = 0.

        It is the bias, except at a particle whose position r in its body changes: v = v^X + ω × r has the derivative
        a^X_b + α_b × r + ω × ṙ.
        """
        if not isinstance(place, Point) or place.body is None or place.parent is None:
            return self.of(place).bias
        spin, start = self.frame(place.body), self.point(place.parent)
        return (start.bias + spin.bias.cross(place.offset) + spin.total.cross(self.turning(place.offset))).gathered()


def _accumulate(partials: Partials, s: Expr, v: Vector) -> None:
    before = partials.get(s)
    partials[s] = v if before is None else (before + v).gathered()


def _swept(partials: Partials, rest: Vector, spin: Motion, arm: Vector) -> Vector:
    """Adds ω_r × arm to the partial velocities; the remainder plus ω_t × arm."""
    for s, v in spin.partials.items():
        _accumulate(partials, s, v.cross(arm))
    return rest if spin.rest.is_zero else rest + spin.rest.cross(arm)


def _moves(r: Triple) -> bool:
    return any(isinstance(s, Coordinate | Time) or input_of(s) is not None for s in free_symbols(r))


def velocity_form(motion: Motion) -> Vector:
    """The velocity Σ v_r u_r + v_t at zero auxiliary speeds."""
    return sum((v * s for s, v in motion.partials.items() if not isinstance(s, AuxiliarySpeed)), start=motion.rest)


def acceleration_form(motion: Motion) -> Vector:
    """The acceleration Σ v_r u̇_r + a_b at zero auxiliary speeds."""
    return sum((v * s.dt for s, v in motion.partials.items() if not isinstance(s, AuxiliarySpeed)), start=motion.bias)


def cuts_of(symbols: Iterable[AuxiliarySpeed]) -> dict[Basis | Point, tuple[tuple[AuxiliarySpeed, Vector], ...]]:
    """Auxiliary speeds and their directions, by the frame or point that they move."""
    places: dict[Basis | Point, tuple[tuple[AuxiliarySpeed, Vector], ...]] = {}
    for u in symbols:
        cut = cut_of(u)
        if cut is not None:  # None: an auxiliary speed of a constraint
            places[cut.at] = (*places.get(cut.at, ()), (u, cut.along))
    return places

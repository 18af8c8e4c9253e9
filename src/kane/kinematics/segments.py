# SPDX-License-Identifier: BSD-3-Clause
"""The segments of a kinematic tree, on which the recursions of `kane.tree` run: each slides and rotates relative to its parent.

With the basis A before its rotation and B after it, a segment has relative to its parent

    ω = Σ s_r w_r + …   along B,        ṙ = Σ s_r w_r + …   along A, or along B if the speeds are measured along B,

with joint speeds w = C u + … that are constant combinations of the generalized speeds. Rotations about parallel axes share one basis
A, in which the arms rotate (absolute angles, and sums of relative ones). The origin of a segment that does not slide is the point of
its axis at which the arm has no component along the axis.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

from kane.expr.build import sub
from kane.expr.differentiation import time_derivative
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ONE, ZERO, Expr
from kane.kinematics.freedoms import Forms, Freedom, Shift, Stages, Unsuited, are_coupled, by_rates, is_single
from kane.kinematics.links import Link, Tree, homes_of, turn_alike
from kane.kinematics.speeds import measured
from kane.kinematics.velocities import Kinematics
from kane.space.frame import Point
from kane.space.rotation import NOTHING, AlignedBasis, Basis, Triple, about_axis, path, turned_beyond
from kane.space.vector import Parts, Vector
from kane.tree.sweeps import Segment, Stage
from kane.tree.triples import Turn, Turns, along, is_zero, summed, triple, turned_down
from kane.tree.values import NO_MASS, NO_WRENCH, Change, Dof, Reflected, Rigid, SpatialForce, SpatialInertia


@dataclass(frozen=True, slots=True, eq=False)
class JointStep:
    """The motion of a link, or of one rotation of its joint, relative to the parent step, as declared.

    The constant rotations `lead` take the parent's basis B to A, along which is the position `arm` of the origin; `turn` takes A to
    B. If `joins`, A is the A of the parent, about a parallel axis, and arm and slide are along the parent's B. `shift` is the
    displacement of the origin along the axis, along B: points of the segment are at their position in the link + `shift`. `swift`, if
    not None, is the rate of rotation in A, as one speed. `late` if the slide is along B. `modes` are the rates of elastic coordinates
    for which this is the nearest step that carries everything they move.
    """

    parent: int
    lead: tuple[Change, ...]
    arm: Triple
    turn: Change | None
    joins: bool = False
    shift: Triple = NOTHING
    slide: Shift = field(default_factory=Shift)
    spin: Shift = field(default_factory=Shift)
    late: bool = False
    swift: Expr | None = None
    modes: tuple[Expr, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """The steps of a tree, parents first, number 0 the ground.

    `ends` is the last step of each link, `bases` the number of the step with a given basis B, `basis` the B of each step, and `places`
    the link and position of points.
    """

    steps: tuple[JointStep, ...]
    ends: tuple[int, ...]
    bases: Mapping[Basis, int]
    basis: tuple[Basis, ...]
    places: Mapping[Point, tuple[int, Vector]]

    def place(self, point: Point) -> tuple[int, Vector]:
        """The step that a point moves with, and its position from the link's origin."""
        link, arm = self.places[point]
        return self.ends[link], arm

    def of(self, basis: Basis) -> int:
        """The step with the angular velocity of a basis. Unsuited if there is none."""
        b: Basis | None = basis
        while b is not None:
            if b in self.bases:
                return self.bases[b]
            o = b.orientation
            alike = (other for other in self.bases if turn_alike(other, b))
            b = o.base if o is not None and is_zero(o.rates) else next(alike, None)
        raise Unsuited(f"a torque on {basis.name}, which is between the joints")


_SHARED = "coordinates that several joints share, or bodies that turn in others by several absolute angles"


def segments(tree: Tree, kinematics: Kinematics, shared: Collection[Expr] = ()) -> Segments:
    """The steps of a tree. Unsuited if a joint has no joint speeds of its own, other than rates in `shared`, which move several."""
    maker = _Maker(kinematics, Stages(kinematics, shared), homes_of(tree, shared))
    maker.count(tree.links)
    for link in tree.links:
        maker.add(link)
    return maker.finished(tree)


class _Turning(NamedTuple):
    """A rotation to a basis, and its ω along that basis."""

    turn: Change
    basis: Basis
    rates: Triple


def _turns_between(up: Sequence[Basis], down: Sequence[Basis], joins: bool) -> tuple[list[Change], list[_Turning]]:
    """The path from a parent's basis to a link's: leading constant rotations, and the rotations after them.

    `down` leads from the parent's basis back to a common base and `up` from there. Two rotations about the same axis of the common
    base are replaced by one, by the difference of their angles.
    """
    rest = [_Turning(Turn(f), f, _orientation_rates(f)) for f in reversed(up)]
    lead: list[Change] = []
    if not joins:
        lead = [Turn(f, inverse=True) for f in reversed(down)]
        if up and down and (between := _between(down[0], up[-1])) is not None:
            lead, rest[0] = lead[:-1], between
        while rest and is_zero(rest[0].rates):
            lead.append(rest.pop(0).turn)
    return lead, rest


def _between(a: Basis, b: Basis) -> _Turning | None:
    """The rotation from one basis to another if both are rotated about the same axis of the same base, else None."""
    angle = turned_beyond(b, a)
    if angle is None or b.orientation is None or b.orientation.axis is None:
        return None
    difference = about_axis(a, b.orientation.axis, angle)
    return _Turning(Turn(AlignedBasis(b.name, difference, {})), b, difference.rates)


class _Maker:
    def __init__(self, kinematics: Kinematics, stages: Stages, homes: Mapping[int, tuple[Expr, ...]]) -> None:
        self.kinematics, self.stages, self.homes = kinematics, stages, homes
        self.bearing: dict[int, tuple[Expr, ...]] = {}
        self.steps: list[JointStep] = []
        self.raw: list[tuple[Forms | None, Forms | None]] = []
        self.ends: list[int] = []
        self.basis: list[Basis] = []
        self.bases: dict[Basis, int] = {}
        self.early: dict[int, Forms | None] = {}
        self.alike: dict[tuple[int, Parts], int] = {}
        self.keys: dict[tuple[Basis, int, Parts], tuple[int, Parts]] = {}
        self.shared: dict[tuple[int, Triple], tuple[int, Triple]] = {}

    def count(self, links: Iterable[Link]) -> None:
        """Counts the links that slide relative to the same parent with the same velocity."""
        for link in links:
            if link.parent is not None:
                key = link.parent, link.offset.map(time_derivative).parts
                self.keys[link.basis, link.parent, link.offset.parts] = key
                self.alike[key] = self.alike.get(key, 0) + 1

    def add(self, link: Link) -> None:
        """Appends the steps of one link."""
        if link.parent is None:
            self._append(JointStep(0, (), NOTHING, None), link.basis)
        else:
            key = self.keys[link.basis, link.parent, link.offset.parts]
            self._below(self.ends[link.parent], link, self.alike[key] > 1)
        if len(self.ends) in self.homes:
            self.bearing[len(self.steps) - 1] = self.homes[len(self.ends)]
        self.ends.append(len(self.steps) - 1)

    def _below(self, parent: int, link: Link, alike: bool) -> None:
        base = self.basis[parent]
        up, down = path(link.basis, base)
        offset = link.offset.components(base)
        rates = triple(map(time_derivative, offset))
        arm = summed(offset, self.steps[parent].shift)  # `shift` is constant, so it does not enter `rates`
        if alike and not is_zero(rates):
            parent, arm = self._slid(parent, arm, rates, base)
            rates = NOTHING
            if not up and not down:
                self._append(JointStep(parent, (), arm, None), base)
                return
        joins = len(down) == 1 and bool(up) and self._coaxial(parent, up[-1]) and not self._screws(rates, up[-1])
        lead, rest = _turns_between(up, down, joins)
        if any(not is_zero(_orientation_rates(turn.basis)) for turn in lead):
            raise Unsuited(_SHARED)
        if lead and rest and self._screws(rates, rest[0].basis):
            rates = turned_down(lead, rates)  # `_turned` does the same with the arm
        elif not is_zero(rates) and (lead or not rest):
            parent = self._append(JointStep(parent, (), arm, None), base, slide=self.stages.raw(rates))
            arm, rates = NOTHING, NOTHING
            if not lead and not rest:
                return
        together = self._together(rest) if len(rest) > 1 and not joins else None
        if together is not None:
            whole = _Turning(Turns(tuple(step.turn for step in rest)), link.basis, together)
            self._turned(parent, tuple(lead), arm, rates, whole, joins)
            return
        for step in rest:
            if is_zero(step.rates):
                lead.append(step.turn)
                continue
            parent = self._turned(parent, tuple(lead), arm, rates, step, joins)
            lead, arm, rates, joins = [], NOTHING, NOTHING, False
            arm = self.steps[parent].shift
        if lead or not rest:
            self._append(JointStep(parent, tuple(lead), turned_down(lead, arm), None), link.basis)

    def _slid(self, parent: int, arm: Triple, rates: Triple, base: Basis) -> tuple[int, Triple]:
        """The step of a slide shared by several links, made at the first call, and the constant arm in it. Unsuited if it varies."""
        if (parent, rates) not in self.shared:
            number = self._append(JointStep(parent, (), arm, None), base, slide=self.stages.raw(rates))
            self.shared[parent, rates] = number, arm
        number, before = self.shared[parent, rates]
        beyond = triple(map(sub, arm, before))
        if not is_constant_in_time(beyond):
            raise Unsuited(_SHARED)
        return number, beyond

    def _coaxial(self, parent: int, f: Basis) -> bool:
        """Whether a basis is rotated in the basis A of the parent's rotation, about the same axis, at another rate."""
        turn, o = self.steps[parent].turn, f.orientation
        if turn is None or o is None or o.axis is None or turn.axis != o.axis or turn.base is not o.base:
            return False
        if parent in self.bearing:  # elastic coordinates are eliminated along the parent's own basis
            return False
        return turn.basis is self.basis[parent] and not is_zero(map(sub, o.rates, _orientation_rates(turn.basis)))

    def _screws(self, rates: Triple, f: Basis) -> bool:
        return are_coupled(self.stages.raw(rates), self.stages.raw(_orientation_rates(f)))

    def _together(self, rest: Sequence[_Turning]) -> Triple | None:
        """ω of several rotations along the last basis if its measure numbers are speeds; None if not, or if each has its own."""
        raw = [self.stages.raw(step.rates) for step in rest]
        if all(r is None or is_single(r) or r.is_new for r in raw):
            return None
        relative = Vector([(step.basis, step.rates) for step in rest])
        for measures in measured(relative, rest[-1].basis):
            whole = self.stages.raw(measures)
            if whole is not None and (is_single(whole) or whole.is_new):
                return measures
        return None

    def _turned(
        self, parent: int, lead: tuple[Change, ...], arm: Triple, rates: Triple, step: _Turning, joins: bool
    ) -> int:
        """Appends a step that slides at `rates` and rotates; its number."""
        (turn, basis, own), swift = step, None
        k = turn.axis
        if joins and k is not None:
            (form,) = self.kinematics.speeds.forms([own[k]])
            swift = form.total() if len(form.coefficients) == 1 else None
            own = along(k, sub(own[k], _orientation_rates(self.basis[parent])[k]))
        spin, slide, late = self.stages.raw(own), self.stages.raw(rates), False
        self.early[len(self.steps)] = slide
        screws = are_coupled(slide, spin)
        if screws and k is None:
            raise Unsuited("a joint that slides as it turns in space")
        if slide is not None and not (joins or slide.shared or is_single(slide) or screws):
            for measures in measured(Vector(((turn.base, rates),)), basis):
                other = self.stages.raw(measures)
                if other is not None and is_single(other):
                    slide, late = other, True
                    break
        arm, shift = turned_down(lead, arm), NOTHING
        if k is not None and slide is None:
            shift, arm = along(k, arm[k]), (*arm[:k], ZERO, *arm[k + 1 :])  # type: ignore[assignment]
        segment = JointStep(parent, lead, arm, turn, joins, shift, late=late, swift=swift)
        return self._append(segment, basis, slide, spin)

    def _append(self, segment: JointStep, basis: Basis, slide: Forms | None = None, spin: Forms | None = None) -> int:
        self.steps.append(segment)
        self.basis.append(basis)
        self.stages.take(slide, spin)
        self.raw.append((slide, spin))
        self.bases.setdefault(basis, len(self.steps) - 1)
        return len(self.steps) - 1

    def finished(self, tree: Tree) -> Segments:
        """The steps with their joint speeds."""
        before = {step.parent for step in self.steps if step.joins}
        late = [
            step.late and k not in before for k, step in enumerate(self.steps)
        ]  # parents of joined steps slide along A
        slides = [
            slide if own == step.late else self.early[k]
            for k, (step, own, (slide, _)) in enumerate(zip(self.steps, late, self.raw, strict=True))
        ]
        raw = [*slides, *(spin for _, spin in self.raw)]

        n = len(self.steps)

        @cache
        def stage(k: int, by_rates: bool) -> Shift:
            slide, spin = raw[k % n], raw[k % n + n]
            if slide is not None and spin is not None and are_coupled(slide, spin):
                return self.stages.coupled(spin, slide)[k < n]
            return self.stages.stage(raw[k], by_rates)

        modes = tuple(Freedom(NOTHING, {b: ONE}) for own in self.bearing.values() for b in own)

        def freedoms(k: int, by_rates: bool) -> tuple[Freedom, ...]:
            return modes if k == len(raw) else stage(k, by_rates).freedoms

        chosen = by_rates(len(raw) + 1, freedoms, self.kinematics.speeds)
        steps = tuple(
            replace(
                step,
                slide=stage(k, k in chosen),
                spin=stage(k + n, k + n in chosen),
                late=late[k],
                modes=self.bearing.get(k, ()),
            )
            for k, step in enumerate(self.steps)
        )
        return Segments(steps, tuple(self.ends), self.bases, tuple(self.basis), tree.places)


def _orientation_rates(f: Basis) -> Triple:
    assert f.orientation is not None
    return f.orientation.rates


class JointTree(NamedTuple):
    """The segments on which sweeps run.

    By the number of a step: `joint`, the segment that its joint moves, `home`, the segment with its body, and `last`, the rotation
    from the working basis of that to B; None if the working basis is B.
    """

    segments: tuple[Segment, ...]
    joint: tuple[int, ...]
    home: tuple[int, ...]
    last: tuple[Change | None, ...]

    def wrench(self, step: int, w: SpatialForce) -> SpatialForce:
        """A wrench given along B of a step, in the working basis of the segment with its body."""
        last = self.last[step]
        return w if last is None else w.turned(last)

    def along_b(self, step: int, v: Triple) -> Triple:
        """A vector given in the working basis, along B."""
        last = self.last[step]
        return v if last is None else last.down(v)


Elastic = Callable[[Triple, Expr], SpatialInertia]


def joint_tree(
    steps: Sequence[JointStep],
    bodies: Sequence[Rigid] = (),
    loads: Mapping[int, SpatialForce] = MappingProxyType({}),
    elastic: Mapping[int, Elastic] = MappingProxyType({}),
    *,
    along_b: bool = False,
    elastic_along_a: bool = False,
    reflected: Mapping[int, Reflected] = MappingProxyType({}),
) -> JointTree:
    """The segments of steps with `bodies`, `loads` and `elastic` parts, along B, and reflected inertias, by number of the joint speed.

    Rotations about parallel axes in sequence, and screws, have A as their working basis, in which arms and bodies rotate. Bodies and
    children are then on another segment, fixed in that and with the working basis B, if the step has children other than joined ones
    or if `along_b`; so are elastic parts unless `elastic_along_a`.
    """
    along_a = _along_a(steps)
    apart = {step.parent for step in steps[1:] if not step.joins}
    bent = {i for i, step in enumerate(steps) if step.modes or i in elastic}
    apart = apart - bent if elastic_along_a else apart | bent
    count = sum(len(step.slide.freedoms) + len(step.spin.freedoms) for step in steps)
    modes = {b: count + k for k, b in enumerate(b for step in steps for b in step.modes)}
    made, joint, home, last, number = list[Segment](), list[int](), list[int](), list[Change | None](), 0
    for i, step in enumerate(steps):
        joined = Segment(0)
        if i:
            parent = joint[step.parent] if step.joins else home[step.parent]
            joined = _joined(step, parent, steps[step.parent].turn if step.joins else None, number, modes, reflected)
            before = None if step.joins else last[step.parent]
            joined = joined if before is None else replace(joined, lead=(before, *joined.lead))
            number += len(joined.dofs)
        joint.append(len(made))
        body, load, own = bodies[i] if bodies else NO_MASS, loads.get(i, NO_WRENCH), elastic.get(i)
        after = step.turn if along_a[i] else None
        if after is None:
            joined = replace(joined, turn=step.turn)
        elif i in apart or along_b:
            made.append(joined)
            joined, after = Segment(len(made) - 1, lead=(after,)), None
        else:
            body, load = body.turned(after), load if load is NO_WRENCH else load.turned(after)
            own = None if own is None else _turned(own, after)
        made.append(replace(joined, body=body, load=load, modes=step.modes, elastic=own))
        home.append(len(made) - 1)
        last.append(after)
    return JointTree(tuple(made), tuple(joint), tuple(home), tuple(last))


def _turned(elastic: Elastic, turn: Change) -> Elastic:
    """The elastic inertia in the basis before a rotation."""
    return lambda w, square: elastic(turn.down(w), square).turned(turn)


def _along_a(steps: Sequence[JointStep]) -> list[bool]:
    """Whether the working basis of each step is A: of joined steps, of their parents, and of screws."""
    result = [step.joins or any(f.slide is not NOTHING for f in step.spin.freedoms) for step in steps]
    for step in steps:
        if step.joins:
            result[step.parent] = True
    return result


def _joined(
    step: JointStep,
    parent: int,
    before: Change | None,
    number: int,
    modes: Mapping[Expr, int],
    reflected: Mapping[int, Reflected],
) -> Segment:
    """The segment of a step, with joint speeds numbered from `number`; `before` takes arm and slide to A of the parent."""

    def up(v: Triple) -> Triple:
        return v if before is None else before.up(v)

    slide, spin = step.slide, step.spin
    axes = [(NOTHING, up(f.axis), f.row) for f in slide.freedoms] + [(f.axis, f.slide, f.row) for f in spin.freedoms]
    dofs = [Dof(*axis, k, reflected.get(k)) for k, axis in enumerate(axes, number)]
    slides, spins = dofs[: len(slide.freedoms)], dofs[len(slide.freedoms) :]
    sliding = Stage(tuple(slides), slide=up(slide.total), slide_drift=up(slide.drift))
    outer, late = (Stage(), sliding) if step.late else (sliding, Stage())
    inner = late._replace(dofs=(*late.dofs, *spins), spin=spin.total, spin_drift=spin.drift)
    spun, slid = dict(spin.shared), {b: up(v) for b, v in slide.shared}
    if step.turn is not None and step.turn.axis is None:
        spun = {b: step.turn.up(v) for b, v in spun.items()}
    shared = [Dof(spun.get(b, NOTHING), slid.get(b, NOTHING), {b: ONE}, modes[b]) for b in {**slid, **spun}]
    lead = () if step.joins else step.lead
    return Segment(parent, lead, up(step.arm), outer, None, inner, shared=tuple(shared), absolute=step.swift)

# SPDX-License-Identifier: BSD-3-Clause
"""A tree of links as recursions run along it: segments that slide and turn in the one before, each by speeds of its own.

Along the basis A before its turn and B after it a segment has, in the segment before,

    ω = Σ s_r w_r + …   along B,        ṙ = Σ s_r w_r + …   along A, or along B where the speeds are so

with joint speeds w of which the generalized speeds are constant combinations, w = C u + …. Turns about axes that are parallel keep one
basis A, in which the arms turn (absolute angles, and sums of relative ones). The origin of a segment lies on its axis where that is
nearest to the one before, so that the arm has no component along it.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from kane.expr.build import sub
from kane.expr.diff import time_derivative
from kane.expr.evaluate import is_constant_in_time
from kane.expr.node import ONE, ZERO, Expr
from kane.kinematics.motion import Kinematics
from kane.kinematics.speeds import ScalarForm
from kane.kinematics.tree import Link, Tree
from kane.space.point import Point
from kane.space.rotation import NOTHING, UNITS, Basis, Triple, path
from kane.space.spatial import Turn, along, summed
from kane.space.vector import Parts, Vector


class Unsuited(Exception):
    """What no recursion of this kind expresses, as its text says; another route does."""


_SHARED = "coordinates that several joints share, or bodies that turn in others by several absolute angles"
_SPEEDS = "speeds that are no constant combinations of those of the joints"


class Freedom(NamedTuple):
    """A joint speed: what it adds to ω or to ṙ, and its row in the generalized speeds."""

    axis: Triple
    row: Mapping[Expr, Expr]


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """A slide or a turn: freedoms, and what ṙ or ω is in speeds, with its drift."""

    freedoms: tuple[Freedom, ...] = ()
    total: Triple = NOTHING
    drift: Triple = NOTHING


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A step of the tree.

    From the basis B of the parent `lead` turns by constants to A, where the origin lies at `arm`; `turn` leads to B. One that `joins`
    works in the A of its parent, and has its arm and slide along the parent's B. `shift` is how far the origin was moved along the
    axis, along B: what is fixed in the segment is at its arm + `shift`. Where `swift` is not None it is the rate of turn in A, as
    one speed. `late` says that the slide is along B.
    """

    parent: int
    lead: tuple[Turn, ...]
    arm: Triple
    turn: Turn | None
    joins: bool = False
    shift: Triple = NOTHING
    slide: Stage = field(default_factory=Stage)
    spin: Stage = field(default_factory=Stage)
    late: bool = False
    swift: Expr | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """The segments, parents first, number 0 the ground.

    `ends` are the segments that the links of the tree are fixed in, `bases` those whose ω a basis has.
    """

    steps: tuple[Segment, ...]
    ends: tuple[int, ...]
    bases: Mapping[Basis, int]
    places: Mapping[Point, tuple[int, Vector]]

    def place(self, point: Point) -> tuple[int, Vector]:
        """The segment that a point moves with, and the arm from the link's origin."""
        link, arm = self.places[point]
        return self.ends[link], arm

    def of(self, basis: Basis) -> int:
        """The segment that turns as a basis does."""
        b: Basis | None = basis
        while b is not None:
            if b in self.bases:
                return self.bases[b]
            o = b.orientation
            b = o.base if o is not None and is_still(o.rates) else None
        raise Unsuited(f"a torque on {basis.name}, which is between the joints")


def is_still(rates: Iterable[Expr]) -> bool:
    """Whether nothing moves."""
    return all(x is ZERO for x in rates)


def segments(tree: Tree, kinematics: Kinematics) -> Segments:
    """The segments of a tree; Unsuited where its joints are not by speeds of their own."""
    maker = _Maker(kinematics, _Stages(kinematics))
    maker.count(tree.links)
    for link in tree.links:
        maker.add(link)
    return maker.finished(tree)


class _Raw(NamedTuple):
    """The forms in speeds of what a stage makes of rates."""

    forms: tuple[ScalarForm, ScalarForm, ScalarForm]


class _Stages:
    """Forms of what moves, and the freedoms that they have once all of them are known."""

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.users: dict[Expr, int] = {}

    def raw(self, rates: Triple) -> _Raw | None:
        """The forms of what changes with these rates, None of nothing."""
        if is_still(rates):
            return None
        x, y, z = self.kinematics.speeds.forms(rates)
        return _Raw((x, y, z))

    def taken(self, raw: _Raw | None) -> _Raw | None:
        """The same, kept."""
        for s in {u for form in raw.forms for u in form.coefficients} if raw else ():
            self.users[s] = self.users.get(s, 0) + 1
        return raw

    def stage(self, raw: _Raw | None) -> Stage:
        """The freedoms of forms: one an axis, or one a speed that nothing else moves by."""
        if raw is None:
            return Stage()
        rows = [(k, form.coefficients) for k, form in enumerate(raw.forms) if form.coefficients]
        speeds = dict.fromkeys(s for _, row in rows for s in row)
        if len(rows) <= 1 or _single(raw):
            freedoms = tuple(Freedom(UNITS[k], row) for k, row in rows)
        elif all(self.users[s] == 1 for s in speeds):
            columns = {s: [form.coefficients.get(s, ZERO) for form in raw.forms] for s in speeds}
            freedoms = tuple(Freedom((c[0], c[1], c[2]), {s: ONE}) for s, c in columns.items())
        else:
            raise Unsuited(_SPEEDS)
        if not all(is_constant_in_time(f.row.values()) for f in freedoms):
            raise Unsuited(_SPEEDS)
        a, b, c = (form.total() for form in raw.forms)
        drift = self.kinematics.drift
        return Stage(freedoms, (a, b, c), (drift(a), drift(b), drift(c)))


def _single(raw: _Raw) -> bool:
    """Whether each form is of one speed, and no two of the same."""
    rows = [form.coefficients for form in raw.forms if form.coefficients]
    return all(len(row) == 1 for row in rows) and len({s for row in rows for s in row}) == len(rows)


class _Maker:
    def __init__(self, kinematics: Kinematics, stages: _Stages) -> None:
        self.kinematics, self.stages = kinematics, stages
        self.steps: list[Segment] = []
        self.raw: list[tuple[_Raw | None, _Raw | None]] = []
        self.ends: list[int] = []
        self.basis: list[Basis] = []
        self.bases: dict[Basis, int] = {}
        self.early: dict[int, _Raw | None] = {}
        self.alike: dict[tuple[int, Parts], int] = {}
        self.shared: dict[tuple[int, Triple], tuple[int, Triple]] = {}

    def count(self, links: Iterable[Link]) -> None:
        """How many links slide in one in the same way."""
        for link in links:
            if link.parent is not None:
                key = link.parent, link.offset.map(time_derivative).parts
                self.alike[key] = self.alike.get(key, 0) + 1

    def add(self, link: Link) -> None:
        """The segments of one link."""
        if link.parent is None:
            self._append(Segment(0, (), NOTHING, None), link.basis)
        else:
            key = link.parent, link.offset.map(time_derivative).parts
            self._below(self.ends[link.parent], link, self.alike[key] > 1)
        self.ends.append(len(self.steps) - 1)

    def _below(self, parent: int, link: Link, alike: bool) -> None:
        base = self.basis[parent]
        up, down = path(link.basis, base)
        arm = summed(link.offset.components(base), self.steps[parent].shift)
        rates = (time_derivative(arm[0]), time_derivative(arm[1]), time_derivative(arm[2]))
        if alike and not is_still(rates):
            parent, arm = self._slid(parent, arm, rates, base)
            rates = NOTHING
            if not up and not down:
                self._append(Segment(parent, (), arm, None), base)
                return
        joins = len(down) == 1 and bool(up) and self._coaxial(parent, up[-1])
        lead = [] if joins else [Turn(f, inverse=True) for f in reversed(down)]
        rest = list(reversed(up))
        while rest and not joins and is_still(_orientation_rates(rest[0])):
            lead.append(Turn(rest.pop(0)))
        if any(not is_still(turn.orientation.rates) for turn in lead):
            raise Unsuited(_SHARED)
        if not is_still(rates) and (lead or not rest):
            parent = self._append(Segment(parent, (), arm, None), base, slide=self.stages.raw(rates))
            arm, rates = NOTHING, NOTHING
            if not lead and not rest:
                return
        for f in rest:
            if is_still(_orientation_rates(f)):
                lead.append(Turn(f))
                continue
            parent = self._turned(parent, tuple(lead), arm, rates, f, joins)
            lead, arm, rates, joins = [], NOTHING, NOTHING, False
            arm = self.steps[parent].shift
        if lead or not rest:
            self._append(Segment(parent, tuple(lead), _down(lead, arm), None), link.basis)

    def _slid(self, parent: int, arm: Triple, rates: Triple, base: Basis) -> tuple[int, Triple]:
        """The segment that slides so, which several links begin from, and the arm in it."""
        if (parent, rates) not in self.shared:
            number = self._append(Segment(parent, (), arm, None), base, slide=self.stages.raw(rates))
            self.shared[parent, rates] = number, arm
        number, before = self.shared[parent, rates]
        x, y, z = map(sub, arm, before)
        if not is_constant_in_time((x, y, z)):
            raise Unsuited(_SHARED)
        return number, (x, y, z)

    def _coaxial(self, parent: int, f: Basis) -> bool:
        turn, o = self.steps[parent].turn, f.orientation
        if turn is None or o is None or o.axis is None:
            return False
        return turn.basis is self.basis[parent] and turn.orientation.axis == o.axis and turn.orientation.base is o.base

    def _turned(self, parent: int, lead: tuple[Turn, ...], arm: Triple, rates: Triple, f: Basis, joins: bool) -> int:
        """A segment that slides and turns."""
        o, swift = f.orientation, None
        assert o is not None
        own = o.rates
        if joins and o.axis is not None:
            k, before = o.axis, self.basis[parent].orientation
            assert before is not None
            (form,) = self.kinematics.speeds.forms([own[k]])
            swift = form.total() if len(form.coefficients) == 1 else None
            own = along(k, sub(own[k], before.rates[k]))
        spin, slide, late = self.stages.raw(own), self.stages.raw(rates), False
        self.early[len(self.steps)] = slide
        if slide is not None and not joins and not _single(slide):
            for measures in _measures(Vector(((o.base, rates),)), f):
                other = self.stages.raw(measures)
                if other is not None and _single(other):
                    slide, late = other, True
                    break
        arm, shift = _down(lead, arm), NOTHING
        if o.axis is not None and slide is None:
            k = o.axis
            shift, arm = along(k, arm[k]), (*arm[:k], ZERO, *arm[k + 1 :])  # type: ignore[assignment]
        segment = Segment(parent, lead, arm, Turn(f), joins, shift, late=late, swift=swift)
        return self._append(segment, f, slide, spin)

    def _append(self, segment: Segment, basis: Basis, slide: _Raw | None = None, spin: _Raw | None = None) -> int:
        self.steps.append(segment)
        self.basis.append(basis)
        self.raw.append((self.stages.taken(slide), self.stages.taken(spin)))
        self.bases.setdefault(basis, len(self.steps) - 1)
        return len(self.steps) - 1

    def finished(self, tree: Tree) -> Segments:
        """The segments with their freedoms."""
        before = {step.parent for step in self.steps if step.joins}
        steps = []
        for k, (step, (slide, spin)) in enumerate(zip(self.steps, self.raw, strict=True)):
            late = step.late and k not in before  # what works along A slides along A
            way = slide if late == step.late else self.early[k]
            steps.append(replace(step, slide=self.stages.stage(way), spin=self.stages.stage(spin), late=late))
        return Segments(tuple(steps), tuple(self.ends), self.bases, tree.places)


def _orientation_rates(f: Basis) -> Triple:
    assert f.orientation is not None
    return f.orientation.rates


def _down(lead: Sequence[Turn], v: Triple) -> Triple:
    for turn in lead:
        v = turn.down(v)
    return v


def _measures(v: Vector, basis: Basis) -> Iterator[Triple]:
    """The measure numbers in the two ways in which a speed's definition may have come to them."""
    yield v.components(basis)
    x, y, z = (v.dot(Vector(((basis, unit),))) for unit in UNITS)
    yield x, y, z


def solved_rows(rows: Iterable[tuple[Mapping[Expr, Expr], Expr]], speeds: Sequence[Expr]) -> dict[Expr, Expr] | None:
    """u̇ of Σ c u̇ = λ, one after the other from rows that hold one more; None where they do not give all."""
    found: dict[Expr, Expr] = {}
    waiting = list(rows)
    if len(waiting) != len(speeds):
        return None
    while waiting:
        left = []
        for row, value in waiting:
            new = [s for s in row if s not in found]
            if len(new) > 1:
                left.append((row, value))
                continue
            if not new:
                return None
            for s, c in row.items():
                if s in found:
                    value = sub(value, _times(c, found[s]))
            found[new[0]] = _over(value, row[new[0]])
        if len(left) == len(waiting):
            return None
        waiting = left
    return found


def _times(c: Expr, x: Expr) -> Expr:
    return x if c is ONE else c * x


def _over(x: Expr, c: Expr) -> Expr:
    return x if c is ONE else x / c

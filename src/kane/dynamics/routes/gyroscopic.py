# SPDX-License-Identifier: BSD-3-Clause
"""What composite bodies leave of Kane's equations at no ẇ.

All that hangs on a segment moves, at no ẇ beyond it, as what carries the segment would move there, with ω, α and a of its origin, and
by what the joints below turn and slide besides. With the moments m, h and E of the composite body the first presses with

    n = J α + (E ω) × ω + h × a,        f = m a + α × h + ω × (ω × h)

and each joint below that turns by ω_r, with its own composite body, with

    n = (E (2 ω + ω_r)) × ω_r,        f = (2 ω + ω_r) × (ω_r × h)

besides, and with h × a_r, m a_r of the Coriolis acceleration 2 ω × ṙ + … of what slides. Only the second goes from segment to segment
to the base; a body's own ω × J ω is never formed. It is as if each joint were asked what it adds to the whole motion of all beyond it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from kane.dynamics.routes.articulated import Wrenches, parts
from kane.dynamics.routes.places import Composite, Place, Way, Wrench
from kane.expr.build import add, mul, neg, sub
from kane.expr.matrix import dot
from kane.expr.node import TWO, ZERO, Expr
from kane.kinematics.segments import Segment
from kane.space.mass_moments import HALF, Moments, sum_of
from kane.space.rotation import NOTHING, Triple, cross3, product
from kane.space.spatial import Inertia, centripetal, negative, summed, times, triple


def forces_left(
    way: Way,
    whole: Sequence[Composite[Moments]],
    loads: Wrenches,
    ground: Triple,
    count: int,
    bending: Mapping[int, Inertia],
) -> list[Expr]:
    """The generalized forces of the freedoms less the inertia forces at no ẇ."""
    on, right = way.on, [ZERO] * count
    moving = _motions(way, ground)
    pressing = [_loaded(way, i, loads) for i in range(len(on.steps))]
    for i, felt in bending.items():
        at = felt.at(*moving[i].work)
        pressing[i] = pressing[i].plus(Wrench(at.n, at.f))
        for b, column in at.columns.items():
            right[way.modes[b]] = sub(right[way.modes[b]], column.force)
    for i in reversed(range(1, len(on.steps))):
        joint = _joint(way, i, whole[i], moving[i])
        w = pressing[i] if joint.is_inner else way.entered(i, pressing[i])
        w = w.plus(_turning(joint)).plus(_sliding(joint.body, joint.sliding))
        for place in way.inner[i]:
            right[place.number] = neg(joint.felt(place, w))
        w = way.entered(i, w) if joint.is_inner else w
        outer = _along_a(way, i, whole[i], moving[i])
        for place in (*way.outer[i], *way.shared[i]):
            right[place.number] = sub(right[place.number], outer.felt(place, w))
        if on.steps[i].parent:
            w = w.plus(_sliding(whole[i].along_a, on.known[i].coriolis))
            pressing[on.steps[i].parent] = pressing[on.steps[i].parent].plus(way.left(i, w))
    return right


class Motion(NamedTuple):
    """α and a at no ẇ: of what carries the segment, at its origin as that slides, along A; of the segment, along the basis of work."""

    along_a: tuple[Triple, Triple]
    work: tuple[Triple, Triple]


def _motions(way: Way, ground: Triple) -> list[Motion]:
    on, still = way.on, (NOTHING, ground)
    own, found = [still], [Motion(still, still)]  # own along B
    for i, step in enumerate(on.steps):
        if i == 0:
            continue
        alpha, a = found[step.parent].work if step.joins else own[step.parent]
        for turn in step.lead:
            alpha, a = turn.down(alpha), turn.down(a)
        a = summed(a, summed(cross3(alpha, on.placed[i][0]), on.known[i].shift))
        along_a, turned = (alpha, a), step.turn is not None and not on.base[i]
        if step.turn is not None and turned:
            alpha, a = step.turn.down(alpha), step.turn.down(a)
        work = summed(alpha, on.known[i].spin), summed(a, on.known[i].sliding)
        found.append(Motion(along_a, work))
        own.append(work if turned or step.turn is None else (step.turn.down(work[0]), step.turn.down(work[1])))
    return found


def _loaded(way: Way, i: int, loads: Wrenches) -> Wrench:
    """What the loads on a segment press on it with, along the basis of work."""
    if i not in loads:
        return Wrench(NOTHING, NOTHING)
    n, f = map(negative, loads[i])
    turn = way.on.steps[i].turn
    return Wrench(n, f) if turn is None or not way.on.base[i] else Wrench(turn.up(n), turn.up(f))


@dataclass(frozen=True, eq=False)
class Joint:
    """A composite body where a segment is carried, along the basis of work where it `is_inner`, else along A.

    ω, α and a are those of what carries it, `turned` and `drift` ω and its derivative at no ẇ of the turn, `sliding` the acceleration
    of a slide along B; `axis` is the axis that it turns about, about which its moment of inertia is `about`.
    """

    body: Moments
    w: Triple
    alpha: Triple
    a: Triple
    square: Expr
    whole: Triple = NOTHING
    turned: Triple = NOTHING
    drift: Triple = NOTHING
    sliding: Triple = NOTHING
    axis: int | None = None
    about: Expr = ZERO
    is_inner: bool = False

    @cached_property
    def ew(self) -> Triple:
        """E ω."""
        return product(self.body.e, self.w)

    def felt(self, place: Place, w: Wrench) -> Expr:
        """The generalized force of a freedom, with the wrench `w` beside."""
        spin, slide = parts(place.freedom, place.turning)
        turns = sum_of(mul(s, add(w.n[k], self.moment(k))) for k, s in enumerate(spin) if s is not ZERO)
        if all(x is ZERO for x in slide):
            return turns
        return add(turns, dot(slide, summed(w.f, self.force)))

    def moment(self, k: int) -> Expr:
        """That of the motion of what carries it, about a basis axis."""
        i, j = (k + 1) % 3, (k + 2) % 3
        h, a = self.body.h, self.a
        if k == self.axis:
            accelerated = sub(
                mul(self.about, self.alpha[k]), sum_of(mul(self.body.e[k][b], self.alpha[b]) for b in (i, j))
            )
        else:
            accelerated = self.body.along(k, self.alpha)
        swung = sub(mul(self.w[j], self.ew[i]), mul(self.w[i], self.ew[j]))
        return add(accelerated, add(swung, sub(mul(h[i], a[j]), mul(h[j], a[i]))))

    @cached_property
    def force(self) -> Triple:
        """That of the motion of what carries it."""
        f = summed(times(self.body.m, self.a), cross3(self.alpha, self.body.h))
        return summed(f, centripetal(self.w, self.body.h, self.square))


def _joint(way: Way, i: int, whole: Composite[Moments], moving: Motion) -> Joint:
    """Along A where the segment turns about a basis axis, which a moment about that does not mind."""
    step, on = way.on.steps[i], way.on
    (alpha, a), w, square = moving.along_a, on.rates[i].before, on.rates[step.parent].square
    turn, k = step.turn, _axis(step)
    beyond = (on.rates[i].work, step.spin.total, step.spin.drift, on.known[i].sliding)
    if turn is not None and not on.base[i] and (k is None or step.late):
        return Joint(whole.work, turn.down(w), turn.down(alpha), turn.down(a), square, *beyond, is_inner=True)
    about = ZERO if k is None else whole.work.about(k)
    return Joint(whole.along_a, w, alpha, a, square, *beyond, k, about)


def _along_a(way: Way, i: int, whole: Composite[Moments], moving: Motion) -> Joint:
    on = way.on
    return Joint(whole.along_a, on.rates[i].before, *moving.along_a, on.rates[on.steps[i].parent].square)


def _axis(step: Segment) -> int | None:
    """The basis axis that a segment turns about by all it turns by."""
    k = None if step.turn is None else step.turn.axis
    if k is None or any(v[j] is not ZERO for v in (step.spin.total, step.spin.drift) for j in range(3) if j != k):
        return None
    return k


def _sliding(body: Moments, a: Triple) -> Wrench:
    """What a body presses with at an acceleration of its origin."""
    if a is NOTHING or all(x is ZERO for x in a):
        return Wrench(NOTHING, NOTHING)
    return Wrench(cross3(body.h, a), times(body.m, a))


def _turning(joint: Joint) -> Wrench:
    """What the turn of a joint adds."""
    body, turned, drift = joint.body, joint.turned, joint.drift
    if all(x is ZERO for x in turned):
        return Wrench(NOTHING, NOTHING)
    if joint.axis is not None:
        w = _about_axis(joint, joint.axis)
    else:
        twice = summed(joint.w, joint.whole)
        w = Wrench(cross3(product(body.e, twice), turned), cross3(twice, cross3(turned, body.h)))
    if all(x is ZERO for x in drift):
        return w
    return w.plus(Wrench(body.turned_by(drift), cross3(drift, body.h)))


def _about_axis(joint: Joint, k: int) -> Wrench:
    """The same about a basis axis."""
    i, j = (k + 1) % 3, (k + 2) % 3
    (h, e), w, u = (joint.body.h, joint.body.e), joint.w, joint.turned[k]
    n, f = [ZERO] * 3, [ZERO] * 3
    if w[i] is ZERO and w[j] is ZERO:
        both = sub(mul(joint.whole[k], joint.whole[k]), mul(w[k], w[k]))
        n[i], n[j] = mul(both, e[j][k]), neg(mul(both, e[i][k]))
    else:
        twice, half = mul(TWO, u), mul(HALF, u)
        both = mul(twice, add(w[k], half))
        n[i] = mul(twice, add(joint.ew[j], mul(e[j][k], half)))
        n[j] = neg(mul(twice, add(joint.ew[i], mul(e[i][k], half))))
        f[k] = mul(twice, add(mul(w[i], h[i]), mul(w[j], h[j])))
    f[i], f[j] = neg(mul(both, h[i])), neg(mul(both, h[j]))
    return Wrench(triple(n), triple(f))

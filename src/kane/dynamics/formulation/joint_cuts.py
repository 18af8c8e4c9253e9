# SPDX-License-Identifier: BSD-3-Clause
"""Joint cuts: the link whose joint transmits the constraint wrench that a reaction, with its auxiliary speed, brings into evidence.

A cut at a point, or of a frame, parts the tree if its far side is one link with all its descendants: the auxiliary speed then moves
this subtree as a rigid body, by v = n or by ω = n about the link's origin. Reactions at other cuts are found by partial velocities,
as in the classical formulation.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from kane.dynamics.derivation import Derived
from kane.expr.build import sub
from kane.expr.matrix import dot
from kane.expr.node import Expr
from kane.expr.symbols import AuxiliarySpeed
from kane.kinematics.aligned import Aligned
from kane.kinematics.links import Link, Tree, tree_of
from kane.kinematics.segments import Segments
from kane.model.constraints import Cut, constraint_of, cut_of
from kane.space.frame import Frame, Point
from kane.space.rotation import Basis, Triple, cross3
from kane.space.vector import Vector
from kane.tree.triples import turned_down
from kane.tree.values import SpatialForce

Places = Mapping[Point, tuple[int, Vector]]
Transmitted = Mapping[int, SpatialForce]
"""What the segment before exerts on a segment, about its origin and along A, by number."""


class ReactionDirection(NamedTuple):
    """A reaction's direction along A of the far segment: of a moment about the link's origin at `arm`, or of a force."""

    segment: int
    along: Triple
    turning: bool
    arm: Triple

    def measured(self, transmitted: Transmitted) -> Expr:
        """The component of the transmitted wrench along the direction."""
        n, f = transmitted[self.segment]
        if not self.turning:
            return dot(self.along, f)
        lever = cross3(self.arm, f)
        return dot(self.along, (sub(n[0], lever[0]), sub(n[1], lever[1]), sub(n[2], lever[2])))


def parted(
    derived: Derived, points: Iterable[Point], frames: Iterable[Frame] = ()
) -> tuple[Tree, list[int | None] | None]:
    """The tree with the places of `points` and links for `frames`, and the root link of each reaction's far side.

    That list is None if the far side of some reaction is not a subtree. A body fixed beyond a cut becomes a separate link.
    """
    aligned, wanted, turning = derived.kinematics.aligned, tuple(points), tuple(frames)
    tree = tree_of(derived.system, aligned, wanted, frames=turning)
    result = _parted(derived, tree)
    if result[1] is not None:
        return result
    at = {cut.at for a in derived.auxiliary_speeds if (cut := cut_of(a)) is not None}
    split = _parted(derived, tree_of(derived.system, aligned, wanted, {p for p in at if isinstance(p, Point)}, turning))
    return result if split[1] is None else split


def _parted(derived: Derived, tree: Tree) -> tuple[Tree, list[int | None] | None]:
    """The tree with points at the origin of a cut link assigned to the side of the cut that they are on, and the root links."""
    places, found = tree.places, list[int | None]()
    for a in derived.auxiliary_speeds:
        cut = cut_of(a)
        if cut is None and constraint_of(a) is not None:
            found.append(None)
            continue
        if cut is None:
            return tree, None
        for root in _roots(cut, tree.links, derived.kinematics.aligned):
            if isinstance(cut.at, Frame):
                moved = None if _reaches_out(derived, a, root, tree.links, places) else places
            else:
                moved = _moved(cut.at, root, tree.links, places)
            if moved is not None:
                places = moved
                found.append(root)
                break
        else:
            return tree, None
    return tree._replace(places=places), found


def _reaches_out(derived: Derived, a: AuxiliarySpeed, root: int, links: Sequence[Link], places: Places) -> bool:
    """Whether the auxiliary speed of a frame moves points that are not in the link's subtree, as a mass centre of several bodies."""
    inside, motion = _subtree(root, links), derived.kinematics.point
    outside = [p for p, (link, _) in places.items() if not inside[link]]
    outside += [part.mass_center for k, link in enumerate(links) if not inside[k] for part, _ in link.parts]
    return any(a in motion(p).partials for p in outside)


def _moved(at: Point, root: int, links: Sequence[Link], places: Places) -> Places | None:
    """The places with points beyond the cut assigned to the far link; None if such a point is not in its subtree."""
    inside, result = _subtree(root, links), dict(places)
    for point, (link, arm) in places.items():
        beyond = at in point.ancestry()
        if beyond == inside[link]:
            continue
        if not (beyond and _is_origin(links, root, link, arm)):
            return None
        result[point] = root, Vector()
    return result


def _is_origin(links: Sequence[Link], root: int, link: int, arm: Vector) -> bool:
    """Whether an arm in a link's parent, or in another link that slides in it in the same way, ends at the link's origin."""
    before = links[root].parent
    if link != before and links[link].parent == before and not links[link].parts:
        link, arm = before or 0, links[link].offset + arm
    return link == before and (arm - links[root].offset).gathered().is_zero


def crossings(derived: Derived, roots: Sequence[int | None], segments: Segments) -> list[ReactionDirection | None]:
    """The direction of each auxiliary speed's reaction in the segments, in order; None for those without a root link."""
    result: list[ReactionDirection | None] = []
    for a, root in zip(derived.auxiliary_speeds, roots, strict=True):
        cut = cut_of(a)
        if cut is None or root is None:
            result.append(None)
            continue
        number = segments.ends[root]
        step = segments.steps[number]
        along = derived.kinematics.aligned.vector(cut.along).components(segments.basis[step.parent])
        before = segments.steps[step.parent].turn
        if step.joins and before is not None:
            along = before.up(along)
        result.append(ReactionDirection(number, turned_down(step.lead, along), isinstance(cut.at, Frame), step.shift))
    return result


def _far(cut: Cut, links: Sequence[Link], aligned: Aligned) -> list[int] | None:
    """The number of bodies of each link on the far side; None if it is not determined by links."""
    at = cut.at
    if isinstance(at, Point):
        return [sum(at in part.mass_center.ancestry() for part, _ in link.parts) for link in links]
    if at.parent is None or aligned.rates(at)[0] is aligned.rates(at.parent)[0]:
        return None
    return [
        sum(at in ancestry(part.frame or aligned.owners.get(link.basis, link.basis)) for part, _ in link.parts)
        for link in links
    ]


def ancestry(frame: Basis) -> Iterator[Basis]:
    """The frame, its parent, … up to the root, including frames that a chain of coaxial rotations leaves out of the lineage."""
    f: Basis | None = frame
    while f is not None:
        yield f
        f = f.parent


def _roots(cut: Cut, links: Sequence[Link], aligned: Aligned) -> list[int]:
    """The links whose subtrees contain exactly the bodies of the far side."""
    far = _far(cut, links, aligned)
    beyond, every = list(far or ()), [len(link.parts) for link in links]
    if not any(beyond):
        return []
    total = sum(beyond)
    for k in reversed(range(1, len(links))):
        parent = links[k].parent or 0
        beyond[parent] += beyond[k]
        every[parent] += every[k]
    whole = [k for k, count in enumerate(beyond) if k and count == every[k] == total]
    if not whole or isinstance(cut.at, Point):
        return whole
    root = links[whole[-1]]
    above = links[root.parent or 0].basis  # if the parent rotates too, it does so elsewhere
    elsewhere = not root.offset.is_zero and cut.at in ancestry(aligned.owners.get(above, above))
    return [] if elsewhere else whole[-1:]


def _subtree(root: int, links: Sequence[Link]) -> list[bool]:
    inside: list[bool] = []
    for k, link in enumerate(links):
        inside.append(k == root or (link.parent is not None and inside[link.parent]))
    return inside

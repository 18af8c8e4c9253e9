# SPDX-License-Identifier: BSD-3-Clause
"""URDF, the Unified Robot Description Format: links, joints, mimics, limits and shapes.

Source: https://wiki.ros.org/urdf/XML, with the quaternions of version 1.1 (https://github.com/ros/urdfdom). A joint's origin is the
pose of its child link in the parent at zero; roll, pitch and yaw are about the fixed axes x, y, z.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from difflib import get_close_matches
from itertools import chain
from math import cos, hypot, isfinite, pi, sin
from pathlib import Path
from typing import Any, Literal

import numpy as np

from kane import expect
from kane.errors import ModelError, cut, none_of
from kane.interop.imported import Imported, Remarks
from kane.interop.robots.build import Options, Symbolic, built, plain
from kane.interop.robots.records import Coupling, Kind, LinkShape, Move, Placement, Robot, RobotLink
from kane.interop.robots.xml_text import Element, given, number_of, parsed
from kane.numeric.arrays import Array
from kane.numeric.scale import RIGHT_ANGLE
from kane.space.attitude_formulas import cosines_of

KINDS: Mapping[str, Kind | None] = {
    "revolute": "hinge",
    "continuous": "hinge",
    "prismatic": "slide",
    "floating": "free",
    "planar": "planar",
    "fixed": None,
}
PASSED = {
    "robot": {"material", "link", "joint"},
    "link": {"inertial", "visual", "collision"},
    "joint": {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"},
}
"""Child elements that are read, by parent."""
ATTRIBUTES = {
    "robot": {"name", "version"},
    "link": {"name"},
    "joint": {"name", "type"},
    "inertial": set[str](),
    "origin": {"xyz", "rpy", "quat_xyzw"},
    "mass": {"value"},
    "inertia": {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"},
    "parent": {"link"},
    "child": {"link"},
    "axis": {"xyz"},
    "limit": {"lower", "upper", "effort", "velocity"},
    "dynamics": {"damping", "friction"},
    "mimic": {"joint", "multiplier", "offset"},
}
"""Attributes that are read, by element."""
SLIP, SHORT_SLIP = 0.8, 0.65
"""Similarity above which an unknown tag, or attribute, is taken for a misspelling of a known one; less similar ones are extensions,
which are ignored."""


def from_urdf(
    source: str | bytes | Path,
    *,
    base: Literal["fixed", "free"] = "fixed",
    parameters: Symbolic = "all",
    gravity: Any = (0.0, 0.0, -9.81),
    efforts: bool = True,
    damping: bool = True,
    friction: bool = False,
    stops: bool = False,
    locked: Collection[str] = (),
    right_angles: float = RIGHT_ANGLE,
) -> Imported:
    """Read a robot described in URDF as a system.

    Coordinates are named q_<joint>, speeds u_<joint>, the inputs of efforts tau_<joint>; a link gives a frame and a body of its name
    and the point "<link> origin".

    Parameters
    ----------
    source : path of the file, or its text. No other file is opened: shapes only refer to files
    base : whether the root link is fixed in the inertial frame or moves freely in it by the joint "base"
    parameters : which numbers of bodies become parameters with these defaults: "all", "masses" or "none"
    gravity : measure numbers of the acceleration of free fall along the inertial axes, m/s²
    efforts : whether joints of one degree of freedom that do not mimic another one have inputs
    damping : whether the damping in <dynamics> acts
    friction : whether the dry friction in <dynamics> acts, as `kn.joints.stiction`
    stops : whether limits of position become stops
    locked : names of joints that are fixed at zero
    right_angles : tolerance, rad, within which angles of origins are rounded to multiples of π/2

    Returns
    -------
    Imported
        `extras` contain "limits", "efforts" and "rates" (of joints, by name), "shapes" and "names" (identifiers by names)

    Raises
    ------
    ModelError
        if the text is not URDF, contains unknown elements, or its links do not form a tree; the message names the line
    """
    text, name, _ = given(source, "URDF")
    root = parsed(text, name)
    if root.tag != "robot":
        raise root.wrong("<robot> as the root of a URDF", f"<{root.tag}>")
    expect.one_of(base, ("fixed", "free"), "base= to be")
    expect.flag(efforts, "efforts= to be True or False")
    fixed = frozenset(expect.items(locked, "locked= a list of names of joints"))
    reader = _UrdfReader(root, base, expect.number(right_angles, "right_angles= an angle, rad"), fixed)
    options = Options(parameters, stops, damping, friction)
    return built(reader.robot(_gravity(gravity), efforts), options)


def _gravity(given: Any) -> Array:
    values = expect.items(given, "gravity= three numbers")
    expect.that(len(values) == 3, "gravity= three numbers", given)
    return np.array([expect.number(x, "gravity= three numbers") for x in values])


class _UrdfReader:
    """The elements of one robot, by name."""

    def __init__(self, root: Element, base: str, right: float, locked: frozenset[str]) -> None:
        self.root, self.base, self.right, self.locked = root, base, right, locked
        self.remarks = Remarks()
        self.links = self._named("link")
        self.joints = self._named("joint")
        expect.none(sorted(locked - self.joints.keys()), "locked= names of joints")
        if not self.links:
            raise root.wrong("a <link> in <robot>", "none")
        self._remark_others()
        self.colors = {
            m.attributes.get("name", ""): c for m in root.all("material") if (c := self._color(m)) is not None
        }

    def _named(self, tag: str) -> dict[str, Element]:
        result: dict[str, Element] = {}
        for e in self.root.all(tag):
            name = e.text("name")
            if name in result:
                raise e.wrong(f"{tag}s of different names", f"{name!r} in line {result[name].line} too")
            result[name] = e
        return result

    def _remark_others(self) -> None:
        for e in (self.root, *self.links.values(), *self.joints.values()):
            for child in e.children:
                if child.tag in PASSED[e.tag]:
                    continue
                if child.tag.startswith("xacro:"):
                    raise child.wrong("a URDF without macros", f"<{cut(child.tag)}>", "Run xacro over it first.")
                if get_close_matches(child.tag, PASSED[e.tag], cutoff=SLIP):
                    known = none_of(sorted(PASSED[e.tag]), child.tag)
                    raise ModelError(f"Expected in <{e.tag}> one of {known} It stands in {child.where}.")
                label = child.attributes.get("name") or child.attributes.get("reference") or ""
                self.remarks.say("ignored", f"<{cut(child.tag)}> {cut(label)}".rstrip(), child.where)
            parts = [x for child in e.children for x in (child, *child.children * (child.tag == "inertial"))]
            for part in (e, *parts * (e is not self.root)):
                self._remark_attributes(part)

    def _remark_attributes(self, e: Element) -> None:
        known = ATTRIBUTES.get(e.tag, e.attributes.keys())
        for name in [a for a in e.attributes if a not in known and ":" not in a and a != "xmlns"]:
            if get_close_matches(name.lower(), known, cutoff=SHORT_SLIP):
                raise ModelError(
                    f"Expected as attributes of <{e.tag}> some of {none_of(sorted(known), name)} It stands in {e.where}."
                )
            self.remarks.say("ignored", f"{cut(name)}= of <{e.tag}>", e.where)

    # The tree ------------------------------------------------------------------------------------------------------

    def robot(self, gravity: Array, efforts: bool) -> Robot:
        """The robot's record."""
        order = self._ordered()
        numbers = {name: k for k, (name, _) in enumerate(order)}
        followed = {n for n, e in self.joints.items() if e.one("mimic") is not None}
        root = (Move("base", "free"),) if self.base == "free" else ()
        links = []
        for name, joint in order:
            e = self.links[name]
            parent = -1 if joint is None else numbers[self._end(joint, "parent")]
            moves, placement = (root, Placement()) if joint is None else self._joint(joint, efforts, followed)
            links.append(self._link(name, e, parent, placement, moves))
        couplings = [c for n, e in self.joints.items() if n in followed and (c := self._mimic(n, e)) is not None]
        shapes = tuple(s for name, e in self.links.items() for s in self._shapes(name, e))
        extras = {"efforts": self._bounds("effort"), "rates": self._bounds("velocity")}
        name = self.root.attributes.get("name", "robot")
        return Robot(
            name, tuple(links), gravity, tuple(couplings), shapes=shapes, remarks=self.remarks.all(), extras=extras
        )  # fmt: skip

    def _end(self, joint: Element, which: str) -> str:
        e = joint.one(which)
        if e is None:
            raise joint.wrong(f"a <{which}> of the joint {joint.text('name')!r}", "none")
        name = e.text("link")
        if name not in self.links:
            known = none_of([cut(x, 40) for x in list(self.links)[:20]], name)
            raise ModelError(
                f"Expected as <{which}> of the joint {joint.text('name')!r} one of the links {known} ({e.where})"
            )
        return name

    def _ordered(self) -> list[tuple[str, Element | None]]:
        """The links with the joints that carry them, parents first, otherwise in the order of the text."""
        carried: dict[str, Element] = {}
        below: dict[str, list[Element]] = {}
        for e in self.joints.values():
            child = self._end(e, "child")
            if child in carried:
                came = f"{child!r} of {carried[child].text('name')!r} and {e.text('name')!r} ({e.where})"
                cure = (
                    "A loop is closed by a constraint: leave this joint out and add kn.joints.close_pin to the system."
                )
                raise expect.refusal(ModelError, "links that are each the child of one joint", came, cure)
            carried[child] = e
            below.setdefault(self._end(e, "parent"), []).append(e)
        roots = [name for name in self.links if name not in carried]
        if len(roots) != 1:
            came = ", ".join(map(repr, roots[:5])) if roots else "a ring of joints, " + self._ring(carried)
            raise self.root.wrong("one link that is no joint's child", came)
        order: list[tuple[str, Element | None]] = []
        stack: list[tuple[str, Element | None]] = [(roots[0], None)]
        while stack:
            order.append(stack.pop())
            stack += [(self._end(e, "child"), e) for e in reversed(below.get(order[-1][0], []))]
        if len(order) < len(self.links):
            left = {name: e for name, e in carried.items() if name not in {n for n, _ in order}}
            raise self.root.wrong("joints that make a tree", "a ring of joints, " + self._ring(left))
        return order

    def _ring(self, carried: Mapping[str, Element]) -> str:
        """The names of the joints of a cycle."""
        here, seen = next(iter(carried)), dict[str, str]()
        while here not in seen:
            seen[here] = carried[here].text("name")
            here = self._end(carried[here], "parent")
        return ", ".join(cut(repr(x), 40) for x in list(seen.values())[list(seen).index(here) :][:6])

    # Parts ---------------------------------------------------------------------------------------------------------

    def _placement(self, e: Element | None) -> Placement:
        """The pose of an <origin>, which may be absent."""
        if e is None:
            return Placement()
        place = e.numbers("xyz", 3, (0, 0, 0))
        if "quat_xyzw" in e.attributes:
            return Placement(self._cosines(e), place)
        roll, pitch, yaw = (self._turn(x) for x in e.numbers("rpy", 3, (0, 0, 0)))
        about = (
            np.array([[1, 0, 0], [0, roll[0], -roll[1]], [0, roll[1], roll[0]]]),
            np.array([[pitch[0], 0, pitch[1]], [0, 1, 0], [-pitch[1], 0, pitch[0]]]),
            np.array([[yaw[0], -yaw[1], 0], [yaw[1], yaw[0], 0], [0, 0, 1]]),
        )
        return Placement(plain(about[2] @ about[1] @ about[0]), place)

    def _cosines(self, e: Element) -> Array:
        """The direction cosines of a quaternion (version 1.1), the scalar last."""
        x, y, z, w = e.numbers("quat_xyzw", 4)
        size = hypot(x, y, z, w)
        if "rpy" in e.attributes or not size > 0:
            raise e.wrong("rpy= or quat_xyzw= that is not zero of <origin>", "both" if size > 0 else "zero")
        return plain(cosines_of(np.array([w, x, y, z]) / size, unit=True))

    def _turn(self, angle: float) -> tuple[float, float]:
        """Cosine and sine, exact if the angle is nearly a multiple of π/2."""
        quarter = round(angle / (pi / 2)) if abs(angle) < 1e6 else 0
        if abs(angle - quarter * pi / 2) <= self.right:
            return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[quarter % 4]
        return cos(angle), sin(angle)

    def _link(self, name: str, e: Element, parent: int, placement: Placement, moves: tuple[Move, ...]) -> RobotLink:
        link = RobotLink(name, parent, placement, moves, where=e.where)
        inertial = e.one("inertial")
        if inertial is None:
            return link
        inertial.refuse_others("origin", "mass", "inertia")
        mass, moments = inertial.one("mass"), inertial.one("inertia")
        own = self._placement(inertial.one("origin"))
        if mass is None:
            raise inertial.wrong(f"a <mass> of the link {name!r}", "none")
        matrix = np.zeros((3, 3))
        if moments is not None:
            xx, xy, xz, yy, yz, zz = (moments.number(k, 0.0) for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
            matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        inertia = own.rotation @ matrix @ own.rotation.T
        return replace(
            link, mass=mass.number("value"), center=own.offset, inertia=(inertia + inertia.T) / 2, where=inertial.where
        )  # fmt: skip

    def _joint(self, e: Element, efforts: bool, followed: Collection[str]) -> tuple[tuple[Move, ...], Placement]:
        name, kind = e.text("name"), e.text("type")
        if kind not in KINDS:
            raise ModelError(f"Expected as type= of the joint {cut(name)!r} one of {none_of(KINDS, kind)} ({e.where})")
        placement, found = self._placement(e.one("origin")), KINDS[kind]
        if found is None or name in self.locked:
            return (), placement
        axis = self._axis(e) if found != "free" else np.array([1.0, 0, 0])
        dynamics = e.one("dynamics")
        damping, friction = (dynamics.number(k, 0.0) if dynamics else 0.0 for k in ("damping", "friction"))
        if damping < 0 or friction < 0:
            raise e.wrong(f"damping and friction ≥ 0 of the joint {name!r}", f"{damping:g} and {friction:g}")
        single = found in ("hinge", "slide")
        effort = efforts and single and name not in followed
        move = Move(
            name, found, axis, damping=damping, friction=friction, limits=self._limits(e, kind), effort=effort, where=e.where
        )  # fmt: skip
        if not single and efforts:
            self.remarks.say("inferred", f"the {kind} joint {cut(name)!r} has no efforts", e.where)
        return (move,), placement

    def _axis(self, e: Element) -> Array:
        own = e.one("axis")
        axis = np.array([1.0, 0.0, 0.0]) if own is None else own.numbers("xyz", 3, (1, 0, 0))
        size = hypot(*axis)
        if not (isfinite(size) and size > 0):
            raise e.wrong(f"an axis of the joint {e.text('name')!r} that is not zero", f"{axis}")
        return plain(axis / size)

    def _limits(self, e: Element, kind: str) -> tuple[float, float] | None:
        limit = e.one("limit")
        if limit is None or kind not in ("revolute", "prismatic"):
            return None
        low, high = (limit.number(k, 0.0, infinite=True) for k in ("lower", "upper"))
        if low > high:
            raise limit.wrong(f"lower ≤ upper limit of the joint {e.text('name')!r}", f"{low:g} and {high:g}")
        return low, high

    def _bounds(self, which: str) -> Mapping[str, float]:
        """Limits of effort or rate, by joint."""
        limits = ((n, limit) for n, e in self.joints.items() if (limit := e.one("limit")) is not None)
        return {n: limit.number(which, infinite=True) for n, limit in limits if which in limit.attributes}

    def _mimic(self, name: str, e: Element) -> Coupling | None:
        mimic = e.one("mimic")
        assert mimic is not None
        if KINDS.get(e.text("type")) is None or name in self.locked:
            self.remarks.say("ignored", f"<mimic> of {cut(name)!r}, which does not move", mimic.where)
            return None
        leader = mimic.text("joint")
        ways = {n: KINDS.get(j.text("type")) for n, j in self.joints.items()}
        if ways.get(leader) not in ("hinge", "slide") or ways[name] not in ("hinge", "slide") or leader == name:
            raise mimic.wrong(f"<mimic> of {name!r} to follow another pin or slider", cut(repr(leader)))
        factor, offset = mimic.number("multiplier", 1.0), mimic.number("offset", 0.0)
        still = leader in self.locked
        return Coupling(
            f"mimic {name}", "joint", name, "" if still else leader, (offset,) if still else (offset, factor), where=mimic.where
        )  # fmt: skip

    # Shapes --------------------------------------------------------------------------------------------------------

    def _shapes(self, link: str, e: Element) -> Iterator[LinkShape]:
        for part in chain(e.all("visual"), e.all("collision")):
            geometry = part.one("geometry")
            if geometry is None or not geometry.children:
                self.remarks.say("ignored", f"<{part.tag}> of {cut(link)!r} without a shape", part.where)
                continue
            shape, where = geometry.children[0], self._placement(part.one("origin"))
            sizes = {
                "box": ("size",),
                "sphere": ("radius",),
                "cylinder": ("radius", "length"),
                "capsule": ("radius", "length"),
                "mesh": ("scale",),
            }.get(shape.tag)
            if sizes is None:
                self.remarks.say("ignored", f"shape <{cut(shape.tag)}> of {cut(link)!r}", shape.where)
                continue
            words = [w for s in sizes for w in shape.attributes.get(s, "").split()][:3]
            yield LinkShape(
                link,
                "visual" if part.tag == "visual" else "collision",
                shape.tag,
                tuple(x for w in words if (x := number_of(w)) is not None),
                tuple(map(tuple, where.rotation.tolist())),
                tuple(where.offset.tolist()),
                cut(shape.attributes.get("filename", ""), 1000),
                self._material(part),
            )

    def _material(self, part: Element) -> tuple[float, ...] | None:
        m = part.one("material")
        return None if m is None else self._color(m) or self.colors.get(m.attributes.get("name", ""))

    def _color(self, material: Element) -> tuple[float, ...] | None:
        c = material.one("color")
        return None if c is None else tuple(c.numbers("rgba", 4).tolist())

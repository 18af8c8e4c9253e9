# SPDX-License-Identifier: BSD-3-Clause
"""Random sound drafts, kind by kind: trees, closed loops, wheels, sleds."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tests.systems.drafts import FORMULAS, Draft

UNITS = {"m": "kg", "l": "m", "a": "m", "r": "m", "g": "m/s^2", "k": "N/m", "c": "N*s/m", "F": "N", "T": "N*m", "w": "rad/s",
         "kt": "N*m/rad", "ct": "N*m*s/rad", "I": "kg*m^2", "b": "rad", "h": "m"}  # fmt: skip
RANGES = {
    "g": (9.5, 9.9),
    "k": (5.0, 50.0),
    "kt": (1.0, 10.0),
    "F": (-3.0, 3.0),
    "T": (-2.0, 2.0),
    "r": (0.1, 0.4),
    "b": (-1.0, 1.0),
}


@dataclass
class Pen:
    """What a draft is written with: the groups of its formulas, and random numbers."""

    rng: np.random.Generator
    groups: dict[str, dict[str, Any]] = field(default_factory=dict)

    def put(self, group: str, name: str, value: Any) -> str:
        """Enter one name."""
        self.groups.setdefault(group, {})[name] = value
        return name

    def parameter(self, stem: str, number: Any = "", value: float | None = None) -> str:
        """A parameter with the unit of its stem, and some value, or this one."""
        low, high = RANGES.get(stem, (0.3, 1.5))
        own = round(float(self.rng.uniform(low, high)), 3) if value is None else value
        return self.put("parameters", f"{stem}{number}", (own, UNITS[stem]))

    def coordinate(self, name: str, unit: str, start: float | None = None) -> str:
        """A coordinate with its start."""
        own = round(float(self.rng.uniform(0.2, 1.0)), 3) if start is None else start
        self.put("q", name, own)
        return self.put("coordinates", name, unit)

    def speed(self, name: str, unit: str, definition: str, start: bool = True) -> str:
        """A speed with its start."""
        if start:
            self.put("u", name, round(float(self.rng.uniform(-1.0, 1.0)), 3))
        return self.put("speeds", name, (unit, definition))

    def chance(self, share: float) -> bool:
        """True so often."""
        return bool(self.rng.random() < share)

    def one_of(self, *items: Any) -> Any:
        """Any of these."""
        return items[int(self.rng.integers(len(items)))]

    def gravity(self, along: str = "N.y") -> None:
        """Gravity against a direction."""
        self.put("loads", "gravity", f"kn.gravity(-{self.parameter('g')}*{along})")

    def rigid(self, name: str, frame: str, center: str, inertia: str, i: Any = "") -> str:
        """A rigid body; `inertia` is a call with the frame and the mass left open."""
        m = self.parameter("m", i)
        tensor = inertia.format(A=frame, m=m)
        return self.put(
            "bodies", name, f'kn.RigidBody("{name}", frame={frame}, mass_center={center}, mass={m}, inertia={tensor})'
        )

    def draft(self, kind: str) -> Draft:
        """What was written, without points and parameters that nothing uses."""
        for group in ("places", "parameters"):
            own = self.groups[group]
            for name in reversed(list(own)):
                texts = (str(x) for g in FORMULAS for n, x in self.groups.get(g, {}).items() if n != name)
                if not any(re.search(rf"(?<![\w\".]){name}(?![\w\"])", text) for text in texts):
                    del own[name]
        return Draft(kind, **self.groups)


def tree(rng: np.random.Generator) -> Draft:
    """One to three bodies, pinned to or sliding on each other, on what is at rest, moved or turned, with springs and dampers."""
    pen = Pen(rng)
    frame, point = _ground(pen)
    ends, centers, hinges = [(frame, point)], [], []
    for i in range(1, int(rng.integers(1, 4)) + 1):
        base, at = ends[int(rng.integers(len(ends)))]
        pen.coordinate(f"q{i}", "rad")
        if pen.chance(0.3):  # a slider
            pen.coordinate(f"q{i}", "m")
            center = pen.put("places", f"G{i}", f'{at}.at("G{i}", q{i}*{base}.{pen.one_of("x", "y", "z")})')
            pen.put("bodies", f"B{i}", f'kn.Particle("B{i}", {center}, {pen.parameter("m", i)})')
            ends.append((base, center))
        else:
            axis = f"{base}.{pen.one_of('z', 'z', 'y')}"
            hinges.append((own := _turned(pen, i, base, at, axis), base, axis, i))
            l = pen.parameter("l", i)
            center = pen.put("places", f"G{i}", f'{at}.at("G{i}", {l}/2*{own}.x)')
            end = pen.put("places", f"E{i}", f'{at}.at("E{i}", {l}*{own}.x)')
            if pen.chance(0.3):
                pen.put("bodies", f"B{i}", f'kn.Particle("B{i}", {center}, {pen.parameter("m", i)})')
            else:
                pen.rigid(f"B{i}", own, center, _inertia(pen, i, l), i)
            ends.append((own, end))
        centers.append(center)
    _definitions(pen, len(centers))
    pen.gravity()
    _loads(pen, centers, hinges)
    return pen.draft("tree")


def _ground(pen: Pen) -> tuple[str, str]:
    """Where a tree hangs: at rest, at a point that is shaken, on a table that turns."""
    if pen.chance(0.2):
        return "N", pen.put(
            "places", "S", f'O.at("S", {pen.parameter("a", 0)}*kn.sin({pen.parameter("w", 0)}*kn.time)*N.x)'
        )
    if pen.chance(0.2):
        return pen.put("places", "A0", f'N.rotate("A0", {pen.parameter("w", 0)}*kn.time, N.y)'), "O"
    return "N", "O"


def _turned(pen: Pen, i: int, base: str, at: str, axis: str) -> str:
    if pen.chance(0.3):
        pen.put("places", f"J{i}", f'kn.pin("J{i}", {at}, {base}, axis={axis}, coordinates=q{i})')
        return f"J{i}.frame"
    return pen.put("places", f"A{i}", f'{base}.rotate("A{i}", q{i}, {axis})')


def _inertia(pen: Pen, i: Any, l: str) -> str:
    kind = pen.one_of("rod", "box", "cylinder")
    if kind == "rod":
        return f"kn.rod({{A}}, {{m}}, {l}, {{A}}.x)"
    r = pen.parameter("r", i)
    if kind == "box":
        return f"kn.box({{A}}, {{m}}, {l}, {pen.parameter('a', i)}, {r})"
    return f"kn.solid_cylinder({{A}}, {{m}}, {r}, {l}, {{A}}.x)"


def _definitions(pen: Pen, count: int) -> None:
    """Rates, sums of the rates of angles, rates times lengths."""
    angles = [f"q{i}" for i in range(1, count + 1) if pen.groups["coordinates"][f"q{i}"] == "rad"]
    way = pen.one_of("rates", "rates", "sums", "lengths")
    for i in range(1, count + 1):
        q, unit, text = f"q{i}", "m/s", f"q{i}.dt"
        if q in angles:
            unit, before = "rad/s", [a for a in angles if a < q]
            if way == "sums" and before:
                text = f"{before[-1]}.dt + {text}"
            if way == "lengths":
                unit, text = "m/s", f"l{i}*{text}"
        pen.speed(f"u{i}", unit, text)


def _loads(pen: Pen, centers: list[str], hinges: list[tuple[str, str, str, int]]) -> None:
    """Some springs, dampers, forces and motors."""
    last = centers[-1]
    spring, damper, by_hand = (pen.chance(share) for share in (0.5, 0.4, 0.3))
    if spring or damper or by_hand:
        pen.put("places", "W", f'O.at("W", {pen.parameter("a", 9)}*N.y - {pen.parameter("l", 9)}*N.x)')
    if spring:
        pen.put(
            "loads",
            "spring",
            f'kn.linear_spring({last}, W, {pen.parameter("k", 1)}, {pen.parameter("l", 8)}, name="spring")',
        )
    if damper:
        pen.put("loads", "damper", f'kn.linear_damper({last}, W, {pen.parameter("c", 1)}, name="damper")')
    if by_hand:
        pen.put("loads", "elastic", f'kn.Force({last}, -{pen.parameter("k", 2)}*{last}.position(W), name="elastic")')
    for on, base, axis, i in hinges:
        if pen.chance(0.3):
            kt, b = pen.parameter("kt", i), pen.parameter("b", i)
            text = f'kn.torsional_spring({on}, {base}, q{i}, {kt}, {axis}, {b}, name="coil {i}")'
            pen.put("loads", f"coil {i}", text)
        if pen.chance(0.3):
            text = f'kn.torsional_damper({on}, {base}, {pen.parameter("ct", i)}, {axis}, name="brake {i}")'
            pen.put("loads", f"brake {i}", text)
        if pen.chance(0.2):
            pen.put("loads", f"motor {i}", f'kn.Torque({on}, {pen.parameter("T", i)}*{axis}, name="motor {i}")')
    if pen.chance(0.3):
        force = pen.parameter("F", 1) if pen.chance(0.5) else _input(pen)
        pen.put("loads", "pull", f'kn.Force({last}, {force}*N.{pen.one_of("x", "y")}, name="pull")')
    if pen.chance(0.3):
        pen.put("loads", "drag", f'kn.Force({last}, -{pen.parameter("c", 2)}*{last}.velocity(N), name="drag")')


def _input(pen: Pen) -> str:
    pen.put("forces", "F_in", round(float(pen.rng.uniform(-2, 2)), 2))
    return pen.put("inputs", "F_in", "N")


def free_body(rng: np.random.Generator) -> Draft:
    """A body that flies, or turns about a fixed point, by angles or by Euler parameters, with a spring to the ground."""
    pen, flies, angles = Pen(rng), bool(rng.random() < 0.5), bool(rng.random() < 0.5)
    at = "O"
    if flies:
        x, y, z = (pen.coordinate(n, "m") for n in "xyz")
        at = pen.put("places", "P", f'O.at("P", {x}*N.x + {y}*N.y + {z}*N.z)')
    if angles:
        for n in ("q1", "q2", "q3"):
            pen.coordinate(n, "rad")
        pen.put("places", "A", f'N.rotate_body("A", (q1, q2, q3), "{pen.one_of("xyz", "zyx", "zxy")}")')
    else:
        for n, value in zip(("e0", "e1", "e2", "e3"), (0.8, 0.0, 0.6, 0.0), strict=True):
            pen.coordinate(n, "1", value)
        pen.put("places", "A", 'N.rotate_euler_parameters("A", (e0, e1, e2, e3))')
    a = pen.parameter("a")
    center = pen.put("places", "G", f'{at}.at("G", {a}*A.z)')
    edges = [pen.parameter("a", i) for i in (1, 2, 3)]
    pen.rigid("body", "A", center, f"kn.box({{A}}, {{m}}, {', '.join(edges)})")
    for k, axis in enumerate("xyz", 1):
        pen.speed(f"u{k}", "rad/s", f"A.angular_velocity(N).dot(A.{axis})")
    for k, axis in enumerate("xyz" if flies else "", 4):
        pen.speed(f"u{k}", "m/s", f"P.velocity(N).dot({pen.one_of('A', 'N') if k == 4 else _frame_of(pen)}.{axis})")
    pen.gravity("N.z")
    spring, damper = pen.chance(0.6), pen.chance(0.6)
    if spring or damper:
        pen.put("places", "Q", f'{at}.at("Q", {pen.parameter("l")}*A.x)')
        pen.put("places", "W", f'O.at("W", -{pen.parameter("l", 9)}*N.y)')
    if spring:
        pen.put(
            "loads", "spring", f'kn.linear_spring(Q, W, {pen.parameter("k")}, {pen.parameter("l", 8)}, name="spring")'
        )
    if damper:
        pen.put("loads", "damper", f'kn.linear_damper(Q, W, {pen.parameter("c")}, name="damper")')
    if pen.chance(0.5):
        pen.put("loads", "motor", f'kn.Torque(A, {pen.parameter("T")}*A.z, name="motor")')
    return pen.draft("free body")


def _frame_of(pen: Pen) -> str:
    """The frame along which the velocity's first measure number is taken."""
    return "A" if "dot(A." in pen.groups["speeds"]["u4"][1] else "N"


def wheel(rng: np.random.Generator) -> Draft:
    """A disk or a sphere that rolls on the ground, by hand or as a joint; upright in a plane, or leaning."""
    kinds: list[Callable[[Pen], None]] = [_planar_wheel, _leaning_disk, _sphere, _declared_contact]
    pen = Pen(rng)
    kinds[int(rng.integers(len(kinds)))](pen)
    if pen.chance(0.4):
        pen.put("loads", "drag", f'kn.Force(C, -{pen.parameter("c")}*C.velocity(N), name="drag")')
    if pen.chance(0.4):
        pen.put("loads", "motor", f'kn.Torque(A, {pen.parameter("T")}*A.z, name="motor")')
    return pen.draft("wheel")


def _planar_wheel(pen: Pen) -> None:
    x, th, r = pen.coordinate("x", "m"), pen.coordinate("th", "rad"), pen.parameter("r")
    pen.put("places", "A", f'N.rotate("A", {th}, N.z)')
    pen.put("places", "C", f'O.at("C", {x}*N.x + {r}*N.y)')
    pen.put("places", "K", f'C.fixed_in(A, "K", -{r}*N.y)')
    pen.rigid("wheel", "A", "C", f"kn.thin_disk({{A}}, {{m}}, {r}, {{A}}.z)")
    pen.speed("u1", "rad/s", "th.dt")
    pen.speed("u2", "m/s", "x.dt", start=False)
    pen.put("nonholonomic", "contact", 'kn.no_slip(K, along=N.x, name="contact")')
    pen.gravity()
    if pen.chance(0.5):
        wall = pen.put("places", "W", f'O.at("W", -{pen.parameter("l")}*N.x)')
        pen.put(
            "loads",
            "spring",
            f'kn.linear_spring(C, {wall}, {pen.parameter("k")}, {pen.parameter("l", 8)}, name="spring")',
        )


def _leaning_disk(pen: Pen) -> None:
    r = pen.parameter("r")
    for n in ("q1", "q2", "q3"):
        pen.coordinate(n, "rad")
    for n in ("x", "y"):
        pen.coordinate(n, "m")
    pen.put("places", "Y", 'N.rotate("Y", q1, N.z)')
    pen.put("places", "L", 'Y.rotate("L", q2, Y.x)')
    pen.put("places", "A", 'L.rotate("A", q3, L.y)')
    pen.put("places", "P", 'O.at("P", x*N.x + y*N.y)')
    pen.put("places", "C", f'P.at("C", {r}*L.z)')
    pen.put("places", "K", f'C.fixed_in(A, "K", -{r}*L.z)')
    pen.rigid("wheel", "A", "C", f"kn.thin_disk({{A}}, {{m}}, {r}, {{A}}.y)")
    for k, axis in enumerate("xyz", 1):
        pen.speed(f"u{k}", "rad/s", f"A.angular_velocity(N).dot(L.{axis})")
    for k, n in enumerate("xy", 4):
        pen.speed(f"u{k}", "m/s", f"{n}.dt", start=False)
    pen.put("nonholonomic", "contact", 'kn.rolling(K, normal=N.z, name="contact")')
    pen.gravity("N.z")


def _sphere(pen: Pen) -> None:
    r = pen.parameter("r")
    for n in ("x", "y"):
        pen.coordinate(n, "m")
    for n in ("q1", "q2", "q3"):
        pen.coordinate(n, "rad")
    pen.put("places", "A", 'N.rotate_body("A", (q1, q2, q3), "xyz")')
    pen.put("places", "C", f'O.at("C", x*N.x + y*N.y + {r}*N.z)')
    pen.put("places", "K", f'C.fixed_in(A, "K", -{r}*N.z)')
    pen.rigid("ball", "A", "C", f"kn.solid_sphere({{A}}, {{m}}, {r})")
    for k, axis in enumerate("xyz", 1):
        pen.speed(f"u{k}", "rad/s", f"A.angular_velocity(N).dot(N.{axis})")
    for k, n in enumerate("xy", 4):
        pen.speed(f"u{k}", "m/s", f"{n}.dt", start=False)
    pen.put("nonholonomic", "contact", 'kn.rolling(K, normal=N.z, name="contact")')
    if pen.chance(0.5):
        pen.put("arguments", "dependent_speeds", "u4 u5")
    pen.gravity("N.z")


def _declared_contact(pen: Pen) -> None:
    """A sphere or torus held to the plane by a constraint: its height is a coordinate."""
    r = pen.parameter("r")
    for n in ("x", "y"):
        pen.coordinate(n, "m")
    lean = round(float(pen.rng.uniform(0.1, 0.6)), 3)
    pen.coordinate("q1", "rad")
    pen.coordinate("q2", "rad", lean)
    pen.coordinate("q3", "rad")
    pen.put("places", "Y", 'N.rotate("Y", q1, N.z)')
    pen.put("places", "L", 'Y.rotate("L", q2, Y.x)')
    pen.put("places", "A", 'L.rotate("A", q3, L.y)')
    pen.put("places", "C", 'O.at("C", x*N.x + y*N.y + z*N.z)')
    high = pen.groups["parameters"][r][0]
    if pen.chance(0.5):
        pen.put("places", "contact", f'kn.sphere_on_plane("contact", A, C, O, radius={r}, normal=N.z)')
        pen.rigid("ball", "A", "C", f"kn.solid_sphere({{A}}, {{m}}, {r})")
    else:
        pen.put("places", "contact", f'kn.disk_on_plane("contact", A, C, O, axis=A.y, radius={r}, normal=N.z)')
        pen.rigid("wheel", "A", "C", f"kn.thin_disk({{A}}, {{m}}, {r}, {{A}}.y)")
        high *= float(np.cos(lean))
    pen.coordinate("z", "m", high)
    for k, axis in enumerate("xyz", 1):
        pen.speed(f"u{k}", "rad/s", f"A.angular_velocity(N).dot(L.{axis})")
    for k, n in enumerate("xyz", 4):
        pen.speed(f"u{k}", "m/s", f"{n}.dt", start=False)
    pen.put("holonomic", "height", "contact.height")
    pen.put("nonholonomic", "rolling", "contact.rolling")
    if pen.chance(0.5):
        pen.put("arguments", "dependent_speeds", "u4 u5 u6")
    pen.gravity("N.z")


def loop(rng: np.random.Generator) -> Draft:
    """A four-bar linkage or a slider-crank: lengths and ground pin are those of a configuration that closes."""
    pen = Pen(rng)
    if pen.chance(0.5):
        _four_bar(pen)
    else:
        _slider_crank(pen)
    pen.gravity()
    if pen.chance(0.4):
        pen.put("loads", "motor", f'kn.Torque(A1, {pen.parameter("T")}*N.z, name="motor")')
    if pen.chance(0.4):
        pen.put("loads", "brake", f'kn.torsional_damper(A1, N, {pen.parameter("ct")}, N.z, name="brake")')
    if pen.chance(0.4):
        pen.put(
            "loads",
            "coil",
            f'kn.torsional_spring(A1, N, q1, {pen.parameter("kt")}, N.z, {pen.parameter("b")}, name="coil")',
        )
    return pen.draft("loop")


def _rods(pen: Pen, angles: list[float]) -> np.ndarray:
    """Rods pinned to each other from O on, each by its angle from N.x; where the last one ends."""
    at, place = "O", np.zeros(2)
    for i, angle in enumerate(angles, 1):
        pen.coordinate(f"q{i}", "rad", angle)
        l = pen.parameter("l", i)
        pen.put("places", f"A{i}", f'N.rotate("A{i}", q{i}, N.z)')
        center = pen.put("places", f"G{i}", f'{at}.at("G{i}", {l}/2*A{i}.x)')
        at = pen.put("places", f"E{i}", f'{at}.at("E{i}", {l}*A{i}.x)')
        pen.rigid(f"B{i}", f"A{i}", center, f"kn.rod({{A}}, {{m}}, {l}, {{A}}.x)", i)
        pen.speed(f"u{i}", "rad/s", f"q{i}.dt", start=i == 1)
        place = place + pen.groups["parameters"][l][0] * np.array([np.cos(angle), np.sin(angle)])
    return place


def _four_bar(pen: Pen) -> None:
    first = float(pen.rng.uniform(0.9, 1.6))
    angles = [first, first - float(pen.rng.uniform(0.6, 1.2)), first - float(pen.rng.uniform(2.0, 2.8))]
    end = _rods(pen, angles)
    pen.put("places", "H", f'O.at("H", {pen.parameter("l", 4, end[0])}*N.x + {pen.parameter("a", 4, end[1])}*N.y)')
    way = pen.one_of("coincident", "coincident", "rod")
    if way == "rod":  # the last rod as a massless one
        for group in ("bodies", "places", "coordinates", "speeds", "q", "u", "parameters"):
            for n in [n for n in pen.groups.get(group, {}) if n.endswith("3") and n != "l3"]:
                del pen.groups[group][n]
        pen.put("holonomic", "closing", 'kn.distance(E2, H, l3, name="closing")')
    else:
        pen.put("holonomic", "closing", 'kn.coincident(E3, H, along=(N.x, N.y), name="closing")')
    if pen.chance(0.5):
        pen.put("arguments", "dependent_speeds", "u2" if way == "rod" else "u2 u3")


def _slider_crank(pen: Pen) -> None:
    first = float(pen.rng.uniform(0.5, 1.3))
    end = _rods(pen, [first, -float(pen.rng.uniform(0.2, 0.8))])
    pen.coordinate("x", "m", end[0])
    pen.put("places", "H", f'O.at("H", x*N.x + {pen.parameter("a", 4, end[1])}*N.y)')
    pen.put("bodies", "piston", f'kn.Particle("piston", H, {pen.parameter("m", 3)})')
    pen.speed("u3", "m/s", "x.dt", start=False)
    pen.put("holonomic", "closing", 'kn.coincident(E2, H, along=(N.x, N.y), name="closing")')
    if pen.chance(0.5):
        pen.put("arguments", "dependent_speeds", "u2 u3")


def sled(rng: np.random.Generator) -> Draft:
    """A knife edge that slides along itself, alone or with a trailer."""
    pen = Pen(rng)
    for n in ("x", "y"):
        pen.coordinate(n, "m")
    pen.coordinate("q1", "rad")
    pen.put("places", "A1", 'N.rotate("A1", q1, N.z)')
    pen.put("places", "P", 'O.at("P", x*N.x + y*N.y)')
    pen.put("places", "G1", f'P.at("G1", {pen.parameter("a", 1)}*A1.x)')
    pen.rigid("sled", "A1", "G1", f"kn.inertia({{A}}, {pen.parameter('I', 1)}, I1, I1)", 1)
    pen.speed("u1", "rad/s", "q1.dt")
    way = pen.one_of("N", "A1")
    pen.speed("u2", "m/s", f"P.velocity(N).dot({way}.x)", start=True)
    pen.speed("u3", "m/s", f"P.velocity(N).dot({way}.y)", start=False)
    pen.put("nonholonomic", "edge", 'kn.no_slip(P, along=A1.y, name="edge")')
    dependent = "u3"
    if pen.chance(0.5):
        pen.coordinate("q2", "rad")
        pen.put("places", "A2", 'N.rotate("A2", q2, N.z)')
        pen.put("places", "H", f'P.at("H", -{pen.parameter("l", 2)}*A2.x)')
        pen.put("places", "G2", f'P.at("G2", -{pen.parameter("a", 2)}*A2.x)')
        pen.rigid("trailer", "A2", "G2", f"kn.inertia({{A}}, {pen.parameter('I', 2)}, I2, I2)", 2)
        pen.speed("u4", "rad/s", "q2.dt", start=False)
        pen.put("nonholonomic", "axle", 'kn.no_slip(H, along=A2.y, name="axle")')
        dependent = "u3 u4"
    if pen.chance(0.4) and way == "A1":
        pen.put("arguments", "dependent_speeds", dependent)
    if pen.chance(0.5):
        pen.put("loads", "push", f'kn.Force(P, {pen.parameter("F", 1)}*A1.x, name="push")')
    if pen.chance(0.5):
        pen.put("loads", "drag", f'kn.Force(G1, -{pen.parameter("c", 1)}*G1.velocity(N), name="drag")')
    if pen.chance(0.5):
        pen.put("loads", "motor", f'kn.Torque(A1, {pen.parameter("T", 1)}*N.z, name="motor")')
    return pen.draft("sled")


_JOINTS = {
    "pin": ("axis={e}", ("rad",)),
    "slider": ("axis={e}", ("m",)),
    "cylindrical": ("axis={e}", ("rad", "m")),
    "universal": ("axes=({e}, {f})", ("rad", "rad")),
    "planar": ("normal={e}", ("m", "m", "rad")),
    "ball": ('orientation="angles", sequence="{s}"', ("rad",) * 3),
    "free": ('orientation="angles", sequence="{s}"', ("m",) * 3 + ("rad",) * 3),
}
"""Arguments of a joint's function, and the units of its coordinates."""


def jointed(rng: np.random.Generator) -> Draft:
    """Two bodies on joints of any kind, whose coordinates and speeds are the joints' own."""
    pen, base, at = Pen(rng), "N", "O"
    joints: list[str] = []
    for i in range(1, int(rng.integers(1, 3)) + 1):
        kind = pen.one_of(*_JOINTS)
        more, units = _JOINTS[kind]
        e, f = (f"{base}.{k}" for k in rng.permutation(["x", "y", "z"])[:2])
        q, u = ([f"{stem}{i}_{k}" for k in range(1, len(units) + 1)] for stem in "qu")
        asked = more.format(e=e, f=f, s=pen.one_of("xyz", "zyx"))
        text = f'kn.{kind}("J{i}", {at}, {base}, {asked}, coordinates="{" ".join(q)}", speeds="{" ".join(u)}")'
        joints.append(pen.put("places", f"J{i}", text))
        for name, speed in zip(q, u, strict=True):
            pen.put("q", name, round(float(rng.uniform(0.2, 1.0)), 3))
            pen.put("u", speed, round(float(rng.uniform(-1.0, 1.0)), 3))
        base = pen.put("places", f"A{i}", f"J{i}.frame")
        center = pen.put("places", f"G{i}", f'J{i}.point.at("G{i}", {pen.parameter("a", i)}*A{i}.x)')
        edges = ", ".join(pen.parameter("l", f"{i}{k}") for k in "xyz")
        pen.rigid(f"B{i}", f"A{i}", center, f"kn.box({{A}}, {{m}}, {edges})", i)
        at = pen.put("places", f"E{i}", f'G{i}.at("E{i}", {pen.parameter("h", i)}*A{i}.y)')
    pen.gravity(f"N.{pen.one_of('x', 'y', 'z')}")
    pen.put("places", "W", f'O.at("W", {pen.parameter("l", 9)}*N.y - {pen.parameter("l", 8)}*N.z)')
    pen.put(
        "loads", "spring", f'kn.linear_spring({at}, W, {pen.parameter("k")}, {pen.parameter("l", 7)}, name="spring")'
    )
    if pen.chance(0.5):
        pen.put("loads", "drag", f'kn.Force({at}, -{pen.parameter("c")}*{at}.velocity(N), name="drag")')
    if pen.chance(0.5):
        pen.put("loads", "motor", f'kn.Torque({base}, {pen.parameter("T")}*{base}.x, name="motor")')
    return replace(pen.draft("jointed"), joints=tuple(joints))


KINDS: dict[str, Callable[[np.random.Generator], Draft]] = {
    "tree": tree,
    "free body": free_body,
    "wheel": wheel,
    "loop": loop,
    "sled": sled,
    "jointed": jointed,
}


def drafted(seed: int) -> Draft:
    """A random sound draft."""
    rng = np.random.default_rng(seed)
    return KINDS[list(KINDS)[seed % len(KINDS)]](rng)

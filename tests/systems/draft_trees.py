# SPDX-License-Identifier: BSD-3-Clause
"""Random sound drafts of trees: pinned, sliding, flying, on joints of any kind."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tests.systems.draft_pen import Pen
from tests.systems.drafts import Draft


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

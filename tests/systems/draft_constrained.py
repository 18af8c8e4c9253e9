# SPDX-License-Identifier: BSD-3-Clause
"""Random sound drafts with constraints: wheels, closed loops, sleds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.systems.draft_pen import Pen
from tests.systems.drafts import Draft


def wheel(rng: np.random.Generator) -> Draft:
    """A disk or a sphere that rolls on the ground, by hand or as a joint; upright in a plane, or leaning."""
    kinds: list[Callable[[Pen], None]] = [_planar_wheel, _leaning_disk, _sphere, _on_a_turntable, _declared_contact]
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


def _on_a_turntable(pen: Pen) -> None:
    """A sphere that rolls on a plate, which turns by itself or as it is driven."""
    if pen.chance(0.5):
        pen.put("places", "A0", f'N.rotate("A0", {pen.parameter("w", 0)}*kn.time, N.z)')
    else:
        pen.put("places", "A0", f'N.rotate("A0", {pen.coordinate("q0", "rad")}, N.z)')
        pen.rigid("plate", "A0", "O", f"kn.thin_disk({{A}}, {{m}}, {pen.parameter('a', 0)}, {{A}}.z)", 0)
        pen.speed("u0", "rad/s", "q0.dt")
    _sphere(pen)
    pen.put("places", "K0", 'O.fixed_in(A0, "K0", x*N.x + y*N.y)')
    pen.put("nonholonomic", "contact", 'kn.rolling(K, K0, normal=N.z, name="contact")')


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

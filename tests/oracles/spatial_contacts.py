# SPDX-License-Identifier: BSD-3-Clause
"""Bodies with contacts in space in redundant coordinates: Newton's and Euler's equations in plain NumPy, written without `kane`.

Each body has the place r of its mass centre and the rotation R of its axes, along the axes of the incline, and motion (v, ω). Joints,
the gaps that are closed and the slips that are none are rows J of constraints; a contact that slips pushes along n − μ d:

    [M  −Bᵀ] [a]   [f]
    [J   0 ] [λ] = [−J̇ v],     B = J but for contacts that slip, where B_n = J_n − μ d·J_t

Rows are written for any r and R; their rates are complex steps along the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

Array = Any
Triple = tuple[float, float, float]
G = 9.81
STEP = 1e-30


@dataclass(frozen=True)
class Solid:
    """A body; `joint` is "free", "ball" or "pin" to the body `to`, −1 the ground: `there` on that one, `here` from the mass centre.

    `inertia` is (xx, yy, zz, xy, yz, zx) along its axes, a pin is about the z axes of both.
    """

    mass: float
    inertia: tuple[float, ...]
    joint: str = "free"
    to: int = -1
    there: Triple = (0.0, 0.0, 0.0)
    here: Triple = (0.0, 0.0, 0.0)

    @property
    def width(self) -> int:
        return {"free": 6, "ball": 3, "pin": 1}[self.joint]


@dataclass(frozen=True)
class Touch:
    """A "point", a "sphere", the edge of a "disk" or a "torus" at `place` on a body, about its x axis, that touches a plane.

    The plane is the incline, or the one at `above` over the mass centre of the body `on`, across its z axis.
    """

    body: int
    shape: str
    place: Triple
    radius: float = 0.0
    crown: float = 0.0
    on: int = -1
    above: float = 0.0
    kinetic: float = 0.0
    static: float = 0.0


@dataclass(frozen=True)
class Scene:
    """Bodies and contacts on an incline turned by two angles; speeds are "rates", or along the axes of the "bodies"."""

    tilt: tuple[float, float]
    solids: tuple[Solid, ...]
    touches: tuple[Touch, ...]
    speeds: str = "rates"

    @property
    def width(self) -> int:
        return sum(s.width for s in self.solids)


def cross(r: Array) -> Array:
    x, y, z = r
    return np.array([[0 * x, -z, y], [z, 0 * x, -x], [-y, x, 0 * x]])


def about(axis: int, angle: Any) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    turned = np.eye(3, dtype=np.asarray(angle).dtype)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turned[i, i], turned[i, j], turned[j, i], turned[j, j] = c, -s, s, c
    return turned


class Poses(NamedTuple):
    """Places (n × 3) and rotations (n × 3 × 3) of all bodies."""

    r: Array
    R: Array


def posed(scene: Scene, q: Array) -> Poses:
    r, turned, k = list[Array](), list[Array](), 0
    for s in scene.solids:
        base_r = r[s.to] if s.to >= 0 else np.zeros(3)
        base = turned[s.to] if s.to >= 0 else np.eye(3)
        if s.joint == "pin":
            own = base @ about(2, q[k])
        else:
            a = q[k + s.width - 3 : k + s.width]
            own = base @ about(0, a[0]) @ about(1, a[1]) @ about(2, a[2])
        turned.append(own)
        r.append(q[k : k + 3] if s.joint == "free" else base_r + base @ np.array(s.there) - own @ np.array(s.here))
        k += s.width
    return Poses(np.array(r), np.array(turned))


def motions(scene: Scene, q: Array) -> Array:
    """The matrix of (v, ω) of all bodies (6n) by the speeds."""
    at, found, k = posed(scene, q), list[Array](), 0
    for i, s in enumerate(scene.solids):
        base = at.R[s.to] if s.to >= 0 else np.eye(3)
        own = found[s.to].copy() if s.to >= 0 else np.zeros((6, scene.width), dtype=np.asarray(q).dtype)
        turns = slice(k + s.width - (1 if s.joint == "pin" else 3), k + s.width)
        v, w = own[:3], own[3:]
        arm = base @ np.array(s.there)
        v -= cross(arm) @ w
        w[:, turns] += base[:, 2:] if s.joint == "pin" else _axes(scene, base, at.R[i], q[turns])
        if s.joint == "free":
            v[:, k : k + 3] = np.eye(3)
        else:
            v += cross(at.R[i] @ np.array(s.here)) @ w
        found.append(own)
        k += s.width
    return np.concatenate(found)


def _axes(scene: Scene, base: Array, own: Array, a: Array) -> Array:
    """The axes about which three speeds turn a body."""
    if scene.speeds == "bodies":
        return own
    x = np.eye(3)
    first = about(0, a[0])
    return base @ np.stack([x[0] + 0 * a[0], first @ x[1], first @ about(1, a[1]) @ x[2]], axis=1)


def rates(scene: Scene, q: Array, u: Array) -> Array:
    """q̇."""
    found, k = np.array(u, dtype=float), 0
    at = posed(scene, q)
    for i, s in enumerate(scene.solids):
        if scene.speeds == "bodies" and s.joint != "pin":
            turns = slice(k + s.width - 3, k + s.width)
            base = at.R[s.to] if s.to >= 0 else np.eye(3)
            axes = _axes(Scene(scene.tilt, (), ()), base, at.R[i], q[turns])
            found[turns] = np.linalg.solve(axes, at.R[i] @ u[turns])
        k += s.width
    return found


def moved(at: Poses, v: Array) -> Poses:
    """A complex step along a motion (6n)."""
    w = v.reshape(-1, 6)
    turned = [R + 1j * STEP * cross(own[3:]) @ R for R, own in zip(at.R, w, strict=True)]
    return Poses(at.r + 1j * STEP * w[:, :3], np.array(turned))


def touching(scene: Scene, touch: Touch, at: Poses) -> tuple[Any, Array]:
    """The gap, and the rows of its rate and of the slips (3 × 6n)."""
    R = at.R[touch.body]
    center = at.r[touch.body] + R @ np.array(touch.place)
    plane = at.R[touch.on] if touch.on >= 0 else np.eye(3)
    n = plane[:, 2]
    origin = at.r[touch.on] + touch.above * n if touch.on >= 0 else np.zeros(3)
    contact = center
    if touch.shape in ("disk", "torus"):
        axis = R[:, 0]
        down = -(n - axis * (n @ axis))
        contact = contact + touch.radius * down / np.sqrt(down @ down)
    if touch.shape in ("sphere", "torus"):
        contact = contact - (touch.radius if touch.shape == "sphere" else touch.crown) * n
    j = np.zeros((3, 6 * len(at.r)), dtype=contact.dtype)
    for sign, body in ((1, touch.body), (-1, touch.on)):
        if body >= 0:
            j[:, 6 * body : 6 * body + 6] += sign * np.hstack([np.eye(3), -cross(contact - at.r[body])])
    return (contact - origin) @ n, np.stack([n, plane[:, 0], plane[:, 1]]) @ j


def jointed(scene: Scene, at: Poses) -> Array:
    """The rows of all joints."""
    rows = [np.zeros((0, 6 * len(at.r)))]
    for i, s in enumerate(scene.solids):
        if s.joint == "free":
            continue
        j = np.zeros((5 if s.joint == "pin" else 3, 6 * len(at.r)), dtype=at.r.dtype)
        base = at.R[s.to] if s.to >= 0 else np.eye(3)
        j[:3, 6 * i : 6 * i + 6] = np.hstack([np.eye(3), -cross(at.R[i] @ np.array(s.here))])
        if s.to >= 0:
            j[:3, 6 * s.to : 6 * s.to + 6] -= np.hstack([np.eye(3), -cross(base @ np.array(s.there))])
        if s.joint == "pin":
            j[3:, 6 * i + 3 : 6 * i + 6] = base[:, :2].T
            if s.to >= 0:
                j[3:, 6 * s.to + 3 : 6 * s.to + 6] -= base[:, :2].T
        rows.append(j)
    return np.concatenate(rows)


class Inertia(NamedTuple):
    """M and f of all bodies (6n)."""

    mass: Array
    force: Array


def inertia(scene: Scene, at: Poses, v: Array) -> Inertia:
    size = 6 * len(scene.solids)
    mass, force = np.zeros((size, size)), np.zeros(size)
    a, b = scene.tilt
    down = (about(0, a) @ about(1, b)).T @ [0, 0, -G]
    for i, s in enumerate(scene.solids):
        xx, yy, zz, xy, yz, zx = s.inertia
        own = at.R[i] @ np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]) @ at.R[i].T
        k, w = 6 * i, v[6 * i + 3 : 6 * i + 6]
        mass[k : k + 3, k : k + 3], mass[k + 3 : k + 6, k + 3 : k + 6] = s.mass * np.eye(3), own
        force[k : k + 3], force[k + 3 : k + 6] = s.mass * down, -np.cross(w, own @ w)
    return Inertia(mass, force)


class Rows(NamedTuple):
    """Joints' rows, and all contacts' (k × 3 × 6n), with J̇ v of both, and the gaps (k)."""

    joints: Array
    joint_drift: Array
    contacts: Array
    drift: Array
    gaps: Array


def rows(scene: Scene, at: Poses, v: Array) -> Rows:
    on = moved(at, v)
    every = [touching(scene, t, on) for t in scene.touches]
    contacts = np.array([j for _, j in every])
    joints = jointed(scene, on)
    return Rows(
        joints.real,
        joints.imag @ v / STEP,
        contacts.real,
        contacts.imag @ v / STEP,
        np.array([np.real(g) for g, _ in every]),
    )


class Solved(NamedTuple):
    """u̇, N (k) and F (k × 2) of all contacts."""

    accelerations: Array
    normal: Array
    friction: Array


def solved(scene: Scene, q: Array, u: Array, modes: Sequence[str], along: Array) -> Solved:
    """The accelerations and forces of a mode; `along` (k × 2) are the directions of slip."""
    at, b = posed(scene, q), motions(scene, q)
    v = b @ u
    mass, force = inertia(scene, at, v)
    of = rows(scene, at, v)
    held, pushed, rest, owner = list(of.joints), list(of.joints), list(of.joint_drift), [(-1, 0)] * len(of.joints)
    for k, (touch, mode) in enumerate(zip(scene.touches, modes, strict=True)):
        if mode == "separated":
            continue
        j = of.contacts[k]
        slips = mode in ("straight", "slip")
        held.append(j[0])
        pushed.append(j[0] - touch.kinetic * along[k] @ j[1:] if slips else j[0])
        rest.append(of.drift[k, 0])
        owner.append((k, 0))
        if not slips:
            held += list(j[1:])
            pushed += list(j[1:])
            rest += list(of.drift[k, 1:])
            owner += [(k, 1), (k, 2)]
    n, m = len(v), len(held)
    left = np.zeros((n + m, n + m))
    left[:n, :n] = mass
    if m:
        left[n:, :n], left[:n, n:] = held, -np.array(pushed).T
    right = np.concatenate([force, -np.array(rest)])
    found = np.linalg.lstsq(left, right, rcond=1e-11)[0]
    assert np.abs(left @ found - right).max() < 1e-9 * (1 + np.abs(found).max())
    forces = np.zeros((len(scene.touches), 3))
    for (k, axis), value in zip(owner, found[n:], strict=True):
        if k >= 0:
            forces[k, axis] = value
            if modes[k] in ("straight", "slip"):
                forces[k, 1:] = -scene.touches[k].kinetic * along[k] * value
    turning = motions(scene, q + 1j * STEP * rates(scene, q, u)).imag @ u / STEP
    own, *_ = np.linalg.lstsq(b, found[:n] - turning, rcond=None)
    assert np.abs(b @ own + turning - found[:n]).max() < 1e-9 * (1 + np.abs(found).max())
    return Solved(own, forces[:, 0], forces[:, 1:])


def reduced(scene: Scene, q: Array, u: Array) -> tuple[Array, Array, Array, Array]:
    """W, b, the sizes of b's terms, and the velocities of all contacts' rows (3k), joints eliminated."""
    at = posed(scene, q)
    v = motions(scene, q) @ u
    mass, force = inertia(scene, at, v)
    of = rows(scene, at, v)
    inverse = np.linalg.inv(mass)
    j, p = of.contacts.reshape(-1, len(v)), of.joints
    free = inverse @ force
    spread = inverse @ j.T
    if len(p):
        back = inverse @ p.T @ np.linalg.inv(p @ inverse @ p.T)
        free = free - back @ (p @ free + of.joint_drift)
        spread = spread - back @ (p @ spread)
    terms = np.abs(j) @ (np.abs(inverse) @ np.abs(force)) + np.abs(of.drift).reshape(-1)
    b = j @ free + of.drift.reshape(-1)
    return j @ spread, b, np.maximum(terms, np.abs(b)), j @ v

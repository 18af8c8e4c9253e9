# SPDX-License-Identifier: BSD-3-Clause
"""Random states of touching bodies as W, b and friction: on planes, in corners and grooves, between walls, stacked; and dense ones.

Numbers are scaled so that the largest term of b and the largest W_ii are 1.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class State:
    name: str
    d: int
    W: np.ndarray
    b: np.ndarray
    terms: np.ndarray
    static: np.ndarray
    kinetic: np.ndarray
    sliding: np.ndarray

    @property
    def slides(self):
        return np.abs(self.sliding).max(axis=1) > 0


def cross(r):
    x, y, z = r
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def basis(n):
    """Normal and tangents, the first of these in the plane x z where the normal is."""
    n = np.asarray(n, float)
    t = np.array([n[2], 0, -n[0]])
    t /= np.linalg.norm(t)
    return np.array([n, t, np.cross(n, t)])


def box(rng, at, half=None):
    a, b, c = half = rng.uniform(0.3, 1.5, 3) if half is None else np.asarray(half)
    mass = 10 ** rng.uniform(-1, 1)
    return mass, mass / 3 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b]), np.asarray(at, float), half


def sphere(rng, at):
    mass = 10 ** rng.uniform(-1, 1)
    return mass, 0.4 * mass * np.eye(3), np.asarray(at, float), np.ones(3)


UP = np.array([0, 0, 1.0])


def ball(rng, d):
    return [sphere(rng, [0, 0, 1])], [(0, None, [0, 0, 0], UP)]


def groove(rng, d):
    normals = [np.array([s * np.sin(t), 0, np.cos(t)]) for s, t in zip((-1, 1), rng.uniform(0.2, 1.3, 2), strict=True)]
    return [sphere(rng, [0, 0, 0])], [(0, None, -n, n) for n in normals]


def corner(rng, d):
    normals = [np.array([1.0, 0, 0]), UP] + ([np.array([0, 1.0, 0.01]) / np.hypot(1, 0.01)] if d == 3 else [])
    return [sphere(rng, [0, 0, 0])], [(0, None, -n, n) for n in normals]


def rod(rng, d):
    t = rng.uniform(0.1, 1.5)
    e = np.array([np.cos(t), 0, np.sin(t)])
    m = 10 ** rng.uniform(-1, 1)
    body = m, m / 3 * (np.eye(3) - (0.99 * np.multiply.outer(e, e) if d == 3 else 0)), np.zeros(3), None
    wall = [(0, None, e, np.array([-1.0, 0, 0]))] if rng.random() < 0.6 else []
    return [body], [(0, None, -e, UP), *wall]


def block(rng, d):
    m = box(rng, [0, 0, 0])
    a, b, c = m[3]
    corners = [(-a, y, -c) for y in ((-b, b) if d == 3 else (0,))] + [(a, y, -c) for y in ((-b, b) if d == 3 else (0,))]
    walls = [(a, 0, rng.uniform(-c, c))] if d == 2 and rng.random() < 0.5 else []
    return [m], [(0, None, p, UP) for p in corners] + [(0, None, p, np.array([-1.0, 0, 0])) for p in walls]


def edge(rng, d):
    m = box(rng, [rng.uniform(-1, 1), 0, 0])
    _, b, c = m[3]
    return [m], [(0, None, [0, y, -c], UP) for y in ((-b, b) if d == 3 else (0,))]


def tripod(rng, d):
    angles = 2 * np.pi * np.arange(3) / 3 + rng.uniform(-0.3, 0.3, 3)
    feet = [[np.cos(t), np.sin(t), -1] for t in angles] if d == 3 else [[-1.0, 0, -1], [rng.uniform(0.2, 1), 0, -1]]
    return [box(rng, [0, 0, 0])], [(0, None, p, UP) for p in feet]


def stack(rng, d):
    low, high = box(rng, [0, 0, 0.5], [1, 1, 0.5]), box(rng, [rng.uniform(-0.3, 0.3), 0, 1.4], [0.7, 0.6, 0.4])
    if d == 3:
        return [low, high], [(0, None, [x, y, 0], UP) for x, y in ((-1, 0), (1, 0))] + [
            (1, 0, [x, y, 1], UP) for x, y in ((-0.5, 0.3), (0.5, -0.3))
        ]
    return [low, high], [(0, None, [x, 0, 0], UP) for x in (-1, 1)] + [(1, 0, [x, 0, 1], UP) for x in (-0.5, 0.5)]


def walls(rng, d):
    m = box(rng, [0, 0, 0])
    a, _, c = m[3]
    places = rng.uniform(-c, c, 2)
    return [m], [(0, None, [-a, 0, places[0]], [1.0, 0, 0]), (0, None, [a, 0, places[1]], [-1.0, 0, 0])]


def pegs(rng, d):
    m = box(rng, [0, 0, 0], [1, 0.1, 0.1])
    return [m], [(0, None, [rng.uniform(-1, 0), 0, -0.1], UP), (0, None, [rng.uniform(-2, -1), 0, 0.1], -UP)]


SCENES = (ball, groove, corner, rod, block, edge, tripod, stack, walls, pegs)


def scene(rng, d):
    """A state of one of the scenes: loads at random, some moving."""
    made = SCENES[rng.integers(len(SCENES))]
    bodies, contacts = made(rng, d)
    n, k = 6 * len(bodies), len(contacts)
    mass, f, jacobian = np.zeros((n, n)), np.zeros(n), np.zeros((d * k, n))
    tilt, azimuth = rng.uniform(-0.9, 0.9), rng.uniform(0, 2 * np.pi) if d == 3 else 0.0
    gravity = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), -np.cos(tilt)])
    in_plane = np.array([1.0, d == 3, 1.0])
    for i, (m, inertia, _, _) in enumerate(bodies):
        o = 6 * i
        mass[o : o + 3, o : o + 3], mass[o + 3 : o + 6, o + 3 : o + 6] = m * np.eye(3), inertia
        f[o : o + 3] = m * gravity
        if rng.random() < 0.6:
            push, point = rng.normal(size=3) * m * rng.uniform(0, 3) * in_plane, rng.normal(size=3) / 2 * in_plane
            f[o : o + 3] += push
            f[o + 3 : o + 6] += np.cross(point, push)
    for i, (a, b, point, normal) in enumerate(contacts):
        axes = basis(normal)[:d]
        for sign, body in ((1, a), (-1, b)):
            if body is not None:
                r = np.asarray(point) - bodies[body][2]
                jacobian[d * i : d * i + d, 6 * body : 6 * body + 6] += sign * np.hstack([axes, -axes @ cross(r)])
    if d == 2:
        kept = np.array([6 * i + j for i in range(len(bodies)) for j in (0, 2, 4)])
        mass, f, jacobian = mass[np.ix_(kept, kept)], f[kept], jacobian[:, kept]
    sliding = moving(rng, jacobian, k, d) if rng.random() < 0.4 else np.zeros((k, d - 1))
    return state(rng, made.__name__, jacobian, mass, f, sliding)


def moving(rng, jacobian, k, d):
    """Directions in which contacts slip at velocities that some of them allow."""
    rests = rng.random(k) < 0.4
    rows = [d * i + j for i in range(k) for j in range(d) if j == 0 or rests[i]]
    _, s, v = np.linalg.svd(jacobian[rows])
    free = v[int((s > 1e-10 * s[0]).sum()) :]
    slip = (jacobian @ (rng.normal(size=len(free)) @ free)).reshape(k, d)[:, 1:]
    speed = np.linalg.norm(slip, axis=1, keepdims=True)
    return np.where(speed > 1e-9, slip / np.where(speed > 1e-9, speed, 1.0), 0.0)


def dense(rng, d):
    """W = J M⁻¹ Jᵀ with J and M at random."""
    k = int(rng.integers(1, 5))
    n = d * k + int(rng.integers(-1, 3))
    a = rng.normal(size=(n, n))
    jacobian = rng.normal(size=(d * k, n))
    sliding = rng.normal(size=(k, d - 1))
    sliding /= np.linalg.norm(sliding, axis=1, keepdims=True)
    sliding[rng.random(k) < 0.75] = 0.0
    force = 3 * rng.normal(size=n) - 2 * jacobian[::d].sum(axis=0)
    return state(rng, "dense", jacobian, a @ a.T / n + 0.3 * np.eye(n), force, sliding)


def state(rng, name, jacobian, mass, f, sliding):
    inverse = np.linalg.inv(mass)
    w, b = jacobian @ inverse @ jacobian.T, jacobian @ (inverse @ f)
    terms = np.abs(jacobian) @ (np.abs(inverse) @ np.abs(f))
    static = rng.uniform(0, 1.2, len(sliding))
    kinetic = static if rng.random() < 0.5 else static * rng.uniform(0.3, 1, len(static))
    unit = terms.max()
    return State(name, len(b) // len(sliding), w / np.diag(w).max(), b / unit, terms / unit, static, kinetic, sliding)


def drawn(rng, d):
    return dense(rng, d) if rng.random() < 0.3 else scene(rng, d)

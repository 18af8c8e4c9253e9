# SPDX-License-Identifier: BSD-3-Clause
"""The camera of a sketch: normal to the plane of a planar system, or else the direction from which all is seen best.

The projection is orthographic. Azimuth and elevation maximize the least of several terms: apparent lengths of axes and displacements,
separation of frame axes, opening of rotations, disks neither on edge nor flat; with a slight preference for an elevation of 24°.
"""

from dataclasses import dataclass

import numpy as np

from kane.numeric.arrays import Array
from kane.present.scene.records import Posed, Scene, against_gravity
from kane.present.sketch.pose import Pose

_AZIMUTHS = np.radians(np.arange(-180.0, 180.0, 5.0))
_HEIGHTS = np.radians(np.arange(8.0, 50.0, 2.0))
_HEIGHT = np.radians(24.0)
_FLAT = 1e-9
_ROUND = ("disk", "ring", "cylinder", "torus")
_ENOUGH = 0.55


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Unit vectors to the right, up, and towards the eye; `plane` is true if the system moves normal to the last."""

    right: Array
    up: Array
    toward: Array
    plane: bool

    def flat(self, places: Array) -> Array:
        """Projected places (… × 3): right and up (… × 2)."""
        return np.stack([places @ self.right, places @ self.up], axis=-1)


def view_of(scene: Scene, pose: Pose) -> View:
    """The view of a scene in a pose."""
    up = against_gravity(scene, pose.posed.directions, np.array([0.0, 0.0, 1.0]))
    normal = _plane(scene, pose, up)
    if normal is not None:
        if abs(up @ normal) > 0.5:
            up = np.roll(np.abs(normal), 2)  # y above x, seen from above
        right = np.cross(up, normal)
        if right[int(np.argmax(np.abs(right)))] < -0.7:
            normal, right = -normal, -right
        return View(right, up, normal, True)
    return _searched(scene, pose, up)


def _plane(scene: Scene, pose: Pose, up: Array) -> Array | None:
    """The axis of the inertial frame that is normal to all motion; None if there is no such axis."""
    moved = {q: v + 0.37 + 0.11 * k for k, (q, v) in enumerate(pose.values.items())}
    one, other = pose.posed, scene.poses(moved)
    if _axial(scene, one):
        return None
    extent = max(float(np.ptp(one.positions, axis=0).max()), pose.size)
    order = sorted((2, 1, 0), key=lambda k: abs(up[k]) > 0.5)
    for k in order:
        levels = np.concatenate([one.positions[:, k], other.positions[:, k]])
        normal = np.eye(3)[k]
        turned = other.rotations @ one.rotations.swapaxes(-1, -2) @ normal
        if np.ptp(levels) <= _FLAT * extent and np.abs(turned - normal).max(initial=0.0) <= 1e-7:
            return np.asarray(normal)
    return None


def _axial(scene: Scene, posed: Posed) -> bool:
    """Whether several bodies rotate at one place, so that they would hide each other."""
    bodies = [i for i in scene.items if i.role == "body"]
    places = {tuple(np.round(posed.positions[i.at], 9)) for i in bodies if i.at is not None}
    return len({i.name for i in bodies}) > 1 and len(places) == 1


def _searched(scene: Scene, pose: Pose, up: Array) -> View:
    x = np.eye(3)[int(np.argmin(np.abs(up)))]
    x = x - up * (x @ up)
    x /= np.linalg.norm(x)
    y = np.cross(up, x)
    a, h = (m.ravel() for m in np.meshgrid(_AZIMUTHS, _HEIGHTS, indexing="ij"))
    toward = np.cos(h)[:, None] * (np.cos(a)[:, None] * x + np.sin(a)[:, None] * y) + np.sin(h)[:, None] * up
    right = np.cross(up, toward)
    right /= np.linalg.norm(right, axis=1)[:, None]
    above = np.cross(toward, right)
    worth = _worth(scene, pose, toward, right, above)
    worth = worth + 0.12 * np.exp(-(((h - _HEIGHT) / np.radians(20)) ** 2)) + 0.05 * (right @ np.eye(3)[0])
    best = int(np.argmax(np.round(worth, 9)))
    return View(right[best], above[best], toward[best], False)


def _worth(scene: Scene, pose: Pose, toward: Array, right: Array, above: Array) -> Array:
    """The least of the terms for each view, with a small contribution of their mean."""
    posed, terms = pose.posed, [np.full(len(toward), _ENOUGH)]

    def across(d: Array) -> Array:
        return np.sqrt(np.clip(1 - (toward @ unit(d)) ** 2, 0, 1))

    for t in scene.triads:
        axes = posed.rotations[t.frame].T
        terms += [across(d) for d in axes]
        seen = [(right @ d, above @ d) for d in axes]
        for i, k in ((0, 1), (1, 2), (0, 2)):
            (p, q), (r, s) = seen[i], seen[k]
            terms.append(1.4 * np.abs(p * s - q * r) / np.maximum(np.hypot(p, q) * np.hypot(r, s), 1e-9))
    for m in scene.movements:
        if m.kind == "turn" and m.axis is not None:
            terms.append(1.2 * np.abs(toward @ unit(posed.directions[m.axis])))
        elif m.kind == "shift":
            way = posed.positions[m.points[-1]] - posed.positions[m.points[0]]
            terms.append(across(way) if np.linalg.norm(way) > 0 else terms[0])
    for item in scene.items:
        if item.kind in _ROUND and item.frame is not None:
            facing = np.abs(toward @ posed.rotations[item.frame][:, 2])
            terms.append(np.minimum(1.5 * facing, 2.5 * (1 - facing)))
    terms.append(_apart(scene, posed, right, above))
    table = np.minimum(np.array(terms), _ENOUGH)
    return np.asarray(table.min(axis=0) + 0.35 * table.mean(axis=0))


def _apart(scene: Scene, posed: Posed, right: Array, above: Array) -> Array:
    """The least projected distance of distinct points, relative to the extent of all."""
    places = posed.positions[[m.at for m in scene.marks][:30]]
    i, k = np.triu_indices(len(places), 1)
    between = places[i] - places[k]
    size = np.linalg.norm(between, axis=1)
    between = between[size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)]
    if not len(between):
        return np.full(len(right), _ENOUGH)
    seen = np.hypot(right @ between.T, above @ between.T)
    return np.asarray(4.0 * seen.min(axis=1) / seen.max(axis=1))


def unit(d: Array) -> Array:
    """A direction scaled to unit length; a zero vector is returned unchanged."""
    size = float(np.linalg.norm(d))
    return d / size if size > 0 else d

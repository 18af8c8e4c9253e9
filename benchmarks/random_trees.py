# SPDX-License-Identifier: BSD-3-Clause
"""Trees of pins with general axes, tilts, offsets and inertias in numbers: what a robot's description usually holds."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

import kane as kn

Array = npt.NDArray[np.float64]

BRANCHES = (-1, -1, 1, 0, -1, -1, 4, -1, 1, 0, 6, -1, 5, -1, 5, 0, 13, 16, 3, 13)
"""The parent of each of 20 bodies, drawn among the ones before it and the ground (−1)."""
LIMBS = tuple(-1 if k % 6 == 0 else k - 1 for k in range(24))
"""Four limbs of six joints each on one base."""


def random_tree(parents: Sequence[int], seed: int, *, floating: bool = False) -> kn.System:
    """A body a pin, on the bodies `parents`; −1 is the ground, or a base that floats. Masses are parameters, all else is numbers."""
    rng = np.random.default_rng(seed)
    N, g = kn.Frame("N"), kn.parameter("g", 9.81, "m/s^2")
    base = (kn.Point("O", fixed_in=N), N)
    joints: list[kn.Joint] = []
    if floating:
        joints.append(kn.free("base", *base))
        base = (joints[0].point, joints[0].frame)
    links: list[tuple[kn.Point, kn.Frame]] = []
    for k, parent in enumerate(parents, 1):
        at, frame = base if parent < 0 else links[parent]
        seat = frame.rotate_matrix(f"A{k}", _rotation(rng))
        at = at.at(f"P{k}", _vector(frame, 0.3 * rng.normal(size=3)))
        n = rng.normal(size=3)
        joints.append(kn.pin(f"joint{k}", at, seat, axis=_vector(seat, n / np.linalg.norm(n))))
        links.append((joints[-1].point, joints[-1].frame))
    bodies = [_body(joint, rng) for joint in joints]
    return kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-g * N.z)])


def _body(joint: kn.Joint, rng: np.random.Generator) -> kn.RigidBody:
    """A body of four particles about a mass centre beside the joint."""
    arms = 0.1 * rng.normal(size=(4, 3))
    inertia = np.sum(arms**2) * np.eye(3) - arms.T @ arms
    (xx, xy, zx), (_, yy, yz), (_, _, zz) = inertia.tolist()
    return kn.RigidBody(
        joint.name,
        frame=joint.frame,
        mass_center=joint.point.at(f"{joint.name} center", _vector(joint.frame, 0.2 * rng.normal(size=3))),
        mass=kn.parameter(f"m_{joint.name}", 1.0, "kg"),
        inertia=kn.inertia(joint.frame, xx, yy, zz, xy, yz, zx),
    )


def _vector(frame: kn.Frame, v: Array) -> kn.Vector:
    x, y, z = map(float, v)
    return frame.x * x + frame.y * y + frame.z * z


def _rotation(rng: np.random.Generator) -> Array:
    """Direction cosines (3, 3)."""
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return np.asarray(q * np.linalg.det(q))

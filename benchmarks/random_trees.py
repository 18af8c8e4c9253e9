# SPDX-License-Identifier: BSD-3-Clause
"""Trees of pins with general axes, tilts, offsets and inertias in numbers: what a robot's description usually holds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import kane as kn

Array = npt.NDArray[np.float64]

BRANCHES = (-1, -1, 1, 0, -1, -1, 4, -1, 1, 0, 6, -1, 5, -1, 5, 0, 13, 16, 3, 13)
"""The parent of each of 20 bodies, drawn among the ones before it and the ground (−1)."""
LIMBS = tuple(-1 if k % 6 == 0 else k - 1 for k in range(24))
"""Four limbs of six joints each on one base."""


@dataclass(frozen=True)
class Link:
    """A body on a pin: the seat of the pin in the body `parent` (−1 the ground, or the base), the unit `axis` along the seat.

    `seat` are direction cosines, columns the seat's axes; at zero angle the body's axes are the seat's.
    """

    parent: int
    seat: Array
    at: Array
    axis: Array
    mass: float
    center: Array
    inertia: Array


def random_links(parents: Sequence[int], seed: int) -> list[Link]:
    """A body a pin, on the bodies `parents`: four particles about a mass centre beside the joint."""
    rng = np.random.default_rng(seed)
    joints = []
    for parent in parents:
        seat, at, n = _rotation(rng), 0.3 * rng.normal(size=3), rng.normal(size=3)
        joints.append((parent, seat, at, n / np.linalg.norm(n)))
    links = []
    for joint in joints:
        arms = 0.1 * rng.normal(size=(4, 3))
        inertia = np.sum(arms**2) * np.eye(3) - arms.T @ arms
        links.append(Link(*joint, mass=1.0, center=0.2 * rng.normal(size=3), inertia=inertia))
    return links


def planar_links(n: int) -> list[Link]:
    """n uniform rods of 1 kg and 1 m hanging along −y; each turns about z relative to the one before."""
    across = 1 / 12
    inertia, z = np.diag([across, 0.0, across]), np.array([0.0, 0.0, 1.0])
    return [
        Link(k - 1, np.eye(3), np.array([0.0, -1.0 if k else 0.0, 0.0]), z, 1.0, np.array([0.0, -0.5, 0.0]), inertia)
        for k in range(n)
    ]


def onto_z(axis: Array) -> Array:
    """A rotation that takes z to a unit vector."""
    other = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    return np.column_stack((x, np.cross(axis, x), axis))


def along_z(links: Sequence[Link]) -> list[Link]:
    """The same tree, each body and its seat turned so that its axis is z."""
    turned = [onto_z(link.axis) for link in links]
    above = [turned[link.parent] if link.parent >= 0 else np.eye(3) for link in links]
    z = np.array([0.0, 0.0, 1.0])
    return [
        Link(
            link.parent,
            a.T @ link.seat @ own,
            a.T @ link.at,
            z,
            link.mass,
            own.T @ link.center,
            own.T @ link.inertia @ own,
        )
        for link, own, a in zip(links, turned, above, strict=True)
    ]


def random_tree(parents: Sequence[int], seed: int, *, floating: bool = False, general: bool = False) -> kn.System:
    """`random_links` as a system, on the ground or on a base that floats.

    Masses are parameters, all else is numbers, but where it is `general`: there every number is a parameter, direction cosines too.
    """
    N, g = kn.Frame("N"), kn.parameter("g", 9.81, "m/s^2")
    base = (kn.Point("O", fixed_in=N), N)
    joints: list[kn.Joint] = []
    if floating:
        joints.append(kn.free("base", *base))
        base = (joints[0].point, joints[0].frame)
    links = along_z(random_links(parents, seed)) if general else random_links(parents, seed)
    given = _parameters if general else _numbers
    placed: list[tuple[kn.Point, kn.Frame]] = []
    for k, link in enumerate(links, 1):
        at, frame = base if link.parent < 0 else placed[link.parent]
        seat = frame.rotate_matrix(f"A{k}", given(f"R{k}_", link.seat))
        at = at.at(f"P{k}", _vector(frame, given(f"p{k}_", link.at)))
        joints.append(kn.pin(f"joint{k}", at, seat, axis=seat.z if general else _vector(seat, link.axis.tolist())))
        placed.append((joints[-1].point, joints[-1].frame))
    bodies = [_body(joint, link, given) for joint, link in zip(joints[-len(links) :], links, strict=True)]
    return kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-g * N.z)])


def _numbers(_name: str, values: Array) -> Any:
    return values.tolist()


def _parameters(name: str, values: Array) -> Any:
    """A parameter for each number."""
    flat = [kn.parameter(f"{name}{k}", float(v)) for k, v in enumerate(values.ravel(), 1)]
    return flat if values.ndim == 1 else [flat[3 * i : 3 * i + 3] for i in range(3)]


def _body(joint: kn.Joint, link: Link, given: Callable[[str, Array], Any]) -> kn.RigidBody:
    (xx, xy, zx), (_, yy, yz), (_, _, zz) = given(f"I_{joint.name}_", link.inertia)
    return kn.RigidBody(
        joint.name,
        frame=joint.frame,
        mass_center=joint.point.at(
            f"{joint.name} center", _vector(joint.frame, given(f"c_{joint.name}_", link.center))
        ),
        mass=kn.parameter(f"m_{joint.name}", link.mass, "kg"),
        inertia=kn.inertia(joint.frame, xx, yy, zz, xy, yz, zx),
    )


def _vector(frame: kn.Frame, v: Sequence[Any]) -> kn.Vector:
    x, y, z = v
    total: kn.Vector = frame.x * x + frame.y * y + frame.z * z
    return total


def _rotation(rng: np.random.Generator) -> Array:
    """Direction cosines (3, 3)."""
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return np.asarray(q * np.linalg.det(q))

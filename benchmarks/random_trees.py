# SPDX-License-Identifier: BSD-3-Clause
"""Trees of pins with general axes, tilts, offsets and inertias in numbers: what a robot's description usually holds.

Their operations are counted, so that the numbers are made without BLAS and LAPACK: these round as the machine has it.
"""

from __future__ import annotations

import math
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
class Mass:
    """Of a body: mass, mass centre from its joint and central inertia along its axes."""

    mass: float
    center: Array
    inertia: Array

    def turned(self, axes: Array) -> Mass:
        """Along other axes, the columns of `axes`."""
        return Mass(self.mass, product(axes.T, self.center), product(product(axes.T, self.inertia), axes))


@dataclass(frozen=True)
class Link:
    """A body on a pin: the seat of the pin in the body `parent` (−1 the ground, or the base), the unit `axis` along the seat.

    `seat` are direction cosines, columns the seat's axes; at zero angle the body's axes are the seat's.
    """

    parent: int
    seat: Array
    at: Array
    axis: Array
    body: Mass


def random_links(parents: Sequence[int], seed: int, *, floating: bool = False) -> tuple[Mass | None, list[Link]]:
    """The base, if it floats, and a body a pin, on the bodies `parents`."""
    rng = np.random.default_rng(seed)
    joints = []
    for parent in parents:
        seat, at, n = _rotation(rng), 0.3 * rng.normal(size=3), rng.normal(size=3)
        joints.append((parent, seat, at, n / _length(n)))
    base = _mass(rng) if floating else None
    return base, [Link(*joint, _mass(rng)) for joint in joints]


def _mass(rng: np.random.Generator) -> Mass:
    """Four particles about a mass centre beside the joint."""
    arms = 0.1 * rng.normal(size=(4, 3))
    inertia = sum((arms**2).ravel().tolist()) * np.eye(3) - product(arms.T, arms)
    return Mass(1.0, 0.2 * rng.normal(size=3), inertia)


def product(a: Array, b: Array) -> Array:
    """a b (m × n, n × p or n), every element summed from left to right, the same on all machines."""
    total = np.multiply.outer(a[:, 0], b[0])
    for k in range(1, len(b)):
        total = total + np.multiply.outer(a[:, k], b[k])
    return np.asarray(total)


def _length(v: Array) -> float:
    return math.sqrt(sum(x * x for x in v.tolist()))


def planar_links(n: int) -> list[Link]:
    """n uniform rods of 1 kg and 1 m hanging along −y; each turns about z relative to the one before."""
    rod = Mass(1.0, np.array([0.0, -0.5, 0.0]), np.diag([1 / 12, 0.0, 1 / 12]))
    z = np.array([0.0, 0.0, 1.0])
    return [Link(k - 1, np.eye(3), np.array([0.0, -1.0 if k else 0.0, 0.0]), z, rod) for k in range(n)]


def onto_z(axis: Array) -> Array:
    """A rotation that takes z to a unit vector."""
    other = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(other, axis)
    x /= _length(x)
    return np.column_stack((x, np.cross(axis, x), axis))


def along_z(links: Sequence[Link]) -> list[Link]:
    """The same tree, each body and its seat turned so that its axis is z."""
    turned = [onto_z(link.axis) for link in links]
    above = [turned[link.parent] if link.parent >= 0 else np.eye(3) for link in links]
    z = np.array([0.0, 0.0, 1.0])
    return [
        Link(link.parent, product(product(a.T, link.seat), own), product(a.T, link.at), z, link.body.turned(own))
        for link, own, a in zip(links, turned, above, strict=True)
    ]


def random_tree(parents: Sequence[int], seed: int, *, floating: bool = False, general: bool = False) -> kn.System:
    """`random_links` as a system, on the ground or on a base that floats.

    Masses are parameters, all else is numbers, but where it is `general`: there every number is a parameter, direction cosines too.
    """
    N, g = kn.Frame("N"), kn.parameter("g", 9.81, "m/s^2")
    base = (kn.Point("O", fixed_in=N), N)
    joints: list[kn.joints.Joint] = []
    if floating:
        joints.append(kn.free("base", *base))
        base = (joints[0].point, joints[0].frame)
    trunk, links = random_links(parents, seed, floating=floating)
    links = along_z(links) if general else links
    given = _parameters if general else _numbers
    placed: list[tuple[kn.Point, kn.Frame]] = []
    for k, link in enumerate(links, 1):
        at, frame = base if link.parent < 0 else placed[link.parent]
        seat = frame.rotate_matrix(f"A{k}", given(f"R{k}_", link.seat))
        at = at.at(f"P{k}", _vector(frame, given(f"p{k}_", link.at)))
        joints.append(kn.pin(f"joint{k}", at, seat, axis=seat.z if general else _vector(seat, link.axis.tolist())))
        placed.append((joints[-1].point, joints[-1].frame))
    masses = [*([] if trunk is None else [trunk]), *(link.body for link in links)]
    bodies = [_body(joint, mass, given) for joint, mass in zip(joints, masses, strict=True)]
    return kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-g * N.z)])


def _numbers(_name: str, values: Array) -> Any:
    return values.tolist()


def _parameters(name: str, values: Array) -> Any:
    """A parameter for each number."""
    flat = [kn.parameter(f"{name}{k}", float(v)) for k, v in enumerate(values.ravel(), 1)]
    return flat if values.ndim == 1 else [flat[3 * i : 3 * i + 3] for i in range(3)]


def _body(joint: kn.joints.Joint, body: Mass, given: Callable[[str, Array], Any]) -> kn.RigidBody:
    (xx, xy, zx), (_, yy, yz), (_, _, zz) = given(f"I_{joint.name}_", body.inertia)
    return kn.RigidBody(
        joint.name,
        frame=joint.frame,
        mass_center=joint.point.at(
            f"{joint.name} center", _vector(joint.frame, given(f"c_{joint.name}_", body.center))
        ),
        mass=kn.parameter(f"m_{joint.name}", body.mass, "kg"),
        inertia=kn.inertia(joint.frame, xx, yy, zz, xy, yz, zx),
    )


def _vector(frame: kn.Frame, v: Sequence[Any]) -> kn.Vector:
    x, y, z = v
    total: kn.Vector = frame.x * x + frame.y * y + frame.z * z
    return total


def _rotation(rng: np.random.Generator) -> Array:
    """Direction cosines (3, 3): the orthogonal factor of a random matrix by Householder's reflections, turned to be a rotation."""
    left, q = rng.normal(size=(3, 3)), np.eye(3)
    for k in range(2):
        normal = np.zeros(3)
        normal[k:] = left[k:, k]
        normal[k] += math.copysign(_length(normal), normal[k])
        normal /= _length(normal)
        left = left - 2 * np.multiply.outer(normal, product(left.T, normal))
        q = q - 2 * np.multiply.outer(product(q, normal), normal)
    return q  # of two reflections: a rotation

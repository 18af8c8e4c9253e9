# SPDX-License-Identifier: BSD-3-Clause
"""Random trees of joints of every kind: tilted and offset by numbers and parameters, loaded, some of them driven."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import kane as kn
from kane.numeric import zxz

KINDS = (
    "pin", "slider", "cylindrical", "screw", "planar", "universal", "ball", "free", "weld", "driven", "turning ball", "turning free",
)  # fmt: skip
PLAIN = ("pin", "slider", "pin", "cylindrical", "pin", "ball", "free", "weld", "driven")
"""Those whose speeds are joint speeds."""


def vector(frame: kn.Frame, v: Any) -> kn.Vector:
    x, y, z = map(float, v)
    return frame.x * x + frame.y * y + frame.z * z


def _axis(rng: np.random.Generator, frame: kn.Frame) -> kn.Vector:
    """A basis vector, a round one, or a general one."""
    kind = rng.integers(3)
    if kind == 0:
        return (frame.x, frame.y, frame.z)[rng.integers(3)]
    n = rng.normal(size=3) if kind == 1 else np.array([3.0, 0.0, 4.0])[rng.permutation(3)]
    return vector(frame, n / np.linalg.norm(n))


def _joint(rng: np.random.Generator, kind: str, name: str, at: kn.Point, seat: kn.Frame) -> kn.Joint:
    if kind in ("turning ball", "turning free"):
        of = kn.ball if kind == "turning ball" else kn.free
        return of(name, at, seat, orientation="angles")
    placed: dict[str, Callable[..., kn.Joint]] = {"ball": kn.ball, "free": kn.free, "weld": kn.weld}
    axial: dict[str, Callable[..., kn.Joint]] = {"pin": kn.pin, "slider": kn.slider, "cylindrical": kn.cylindrical}
    if kind in placed:
        return placed[kind](name, at, seat)
    if kind == "planar":
        return kn.planar(name, at, seat, normal=_axis(rng, seat))
    if kind == "universal":
        return kn.universal(name, at, seat, axes=(seat.x, seat.y))
    if kind == "screw":
        return kn.screw(name, at, seat, axis=_axis(rng, seat), pitch=0.3)
    return axial[kind](name, at, seat, axis=_axis(rng, seat))


def _by_parameters(cosines: Any, name: str) -> list[list[Any]]:
    """Direction cosines by parameters that are angles: of R_z(a) R_x(b) R_z(c)."""
    a, b, c = (kn.parameter(f"s{k}{name}", x) for k, x in zip("abc", zxz(cosines), strict=True))
    (ca, sa), (cb, sb), (cc, sc) = ((kn.cos(x), kn.sin(x)) for x in (a, b, c))
    return [
        [ca * cc - sa * cb * sc, -ca * sc - sa * cb * cc, sa * sb],
        [sa * cc + ca * cb * sc, -sa * sc + ca * cb * cc, -ca * sb],
        [sb * sc, sb * cc, cb],
    ]


def _seat(rng: np.random.Generator, name: str, at: kn.Point, frame: kn.Frame, given: bool) -> tuple[kn.Point, kn.Frame]:
    """Where a joint begins: offset by numbers or parameters, tilted or not; a general tilt is `given` by parameters or by numbers."""
    if rng.random() < 0.5:
        at = at.at(f"P{name}", vector(frame, rng.normal(size=3)))
    else:
        length = kn.parameter(f"l{name}", float(rng.uniform(0.5, 1.5)))
        at = at.at(f"P{name}", length * (frame.x, frame.y, frame.z)[rng.integers(3)])
    if rng.random() < 0.5:
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        rows = _by_parameters(q * np.linalg.det(q), name) if given else q * np.linalg.det(q)
        frame = frame.rotate_matrix(f"S{name}", rows)
    elif rng.random() < 0.3:
        tilt = kn.parameter(f"a{name}", 0.4)
        frame = frame.rotate(f"S{name}", tilt, (frame.x, frame.y, frame.z)[rng.integers(3)])
    return at, frame


def _body(rng: np.random.Generator, name: str, point: kn.Point, frame: kn.Frame) -> kn.RigidBody:
    arms = rng.uniform(-0.5, 0.5, (4, 3))
    (xx, xy, zx), (_, yy, yz), (_, _, zz) = (np.sum(arms**2) * np.eye(3) - arms.T @ arms).tolist()
    k = kn.parameter(f"k{name}", 1.0)
    return kn.RigidBody(
        f"body {name}",
        frame=frame,
        mass_center=point.at(f"C{name}", vector(frame, 0.4 * rng.normal(size=3))),
        mass=kn.parameter(f"m{name}", float(rng.uniform(0.5, 2.0))),
        inertia=kn.inertia(frame, k * xx, k * yy, k * zz, k * xy, k * yz, k * zx),
    )


def system(
    seed: int, bodies: int, kinds: Sequence[str] = KINDS, parents: Sequence[int] | None = None, meeting: float = 0.0
) -> kn.System:
    """A tree of `bodies`, drawn with the seed; its speeds are those of its joints. Of a share `meeting` the seat has no offset."""
    rng, other, third = (np.random.default_rng(k) for k in (seed, (seed, 1), (seed, 2)))
    N = kn.Frame("N")
    w, length, drag = kn.parameter("w", 1.3), kn.parameter("d", 0.3), kn.parameter("c", 0.3)
    places = [(kn.Point("O", fixed_in=N), N)]
    joints: list[kn.Joint] = []
    solids: list[kn.RigidBody] = []
    loads: list[Any] = [kn.gravity(vector(N, 10 * rng.normal(size=3)))]
    for i in range(1, bodies + 1):
        name = str(i)
        before, seat = places[rng.integers(len(places)) if parents is None else parents[i - 1]]
        at, seat = _seat(rng, name, before, seat, third.random() < 0.4)
        at = before if other.random() < meeting else at
        kind = str(rng.choice(kinds))
        if kind == "driven":
            seat = seat.rotate(f"D{i}", kn.sin(w * kn.time) + 0.2 * i, (seat.x, seat.y, seat.z)[rng.integers(3)])
            at = at.at(f"E{i}", seat.x * length * kn.cos(w * kn.time))
            kind = "pin"
        if kind == "weld" and i == bodies:  # no tree of welds alone
            kind = "slider"
        joint = _joint(rng, kind, f"j{i}", at, seat)
        joints.append(joint)
        places.append((joint.point, joint.frame))
        solids.append(_body(rng, name, joint.point, joint.frame))
        if rng.random() < 0.3:
            loads.append(
                kn.Force(
                    joint.point.at(f"F{i}", vector(joint.frame, rng.normal(size=3))), vector(N, rng.normal(size=3))
                )
            )
        if rng.random() < 0.3:
            torque = kn.input(f"T{i}") * joint.frame.z
            loads += [kn.Torque(joint.frame, torque), kn.Torque(seat, -torque)]
        if rng.random() < 0.2:
            C = solids[-1].mass_center
            loads.append(kn.Force(C, -drag * C.velocity(N)))
    return kn.System(N, bodies=solids, joints=joints, loads=loads)


def by_mixed_speeds(plain: kn.System, seed: int) -> kn.System:
    """The same by speeds that are combinations of those of the joints: constant ones, and ones that change with the motion."""
    rng = np.random.default_rng(seed)
    q = [x for x in plain.coordinates if x not in {e for s in plain.euler_parameters for e in s.coordinates}]
    w = list(plain.speeds.values())
    definitions = []
    for i, own in enumerate(w):
        u = own
        if rng.random() < 0.4:
            u = u * (2 + kn.sin(q[rng.integers(len(q))]) if q and rng.random() < 0.5 else float(rng.uniform(0.5, 2)))
        for j in rng.permutation(i)[: rng.integers(3)]:
            factor = kn.cos(q[rng.integers(len(q))]) if q and rng.random() < 0.5 else float(rng.choice([1.0, -0.5]))
            u = u + factor * w[j]
        if rng.random() < 0.2:
            u = u + kn.sin(kn.time)
        definitions.append(u)
    order = rng.permutation(len(w)) if rng.random() < 0.5 else range(len(w))
    return plain.redefined({u: definitions[k] for u, k in zip(plain.speeds, order, strict=True)})

# SPDX-License-Identifier: BSD-3-Clause
"""The systems whose operations are counted: name → system."""

from collections.abc import Callable, Sequence

import kane as kn
from benchmarks.random_trees import BRANCHES, LIMBS, random_tree
from kane.gallery import (
    andrews_squeezer,
    bricard,
    car_with_trailer,
    chaplygin_sleigh,
    flexible_arm,
    four_bar,
    muscle_arm,
    pendulums,
    pure_rolling_disk,
    rattleback,
    rolling_disk,
    rotating_beam,
    snakeboard,
    sphere_on_turntable,
    whipple_bicycle,
)


def arm(axes: str) -> kn.System:
    """A serial arm of revolute joints, one a letter of `axes`; all masses, lengths and inertias are parameters."""
    N = kn.Frame("N")
    end, frame = kn.Point("O", fixed_in=N), N
    g = kn.parameter("g", 9.81, "m/s^2")
    bodies = []
    for i, axis in enumerate(axes, 1):
        frame = frame.rotate(f"B{i}", kn.coordinate(f"q{i}", "rad"), getattr(frame, axis))
        m, length = kn.parameter(f"m{i}", 1.0, "kg"), kn.parameter(f"l{i}", 0.5, "m")
        inertia = kn.inertia(frame, *kn.parameters(f"Ix{i} Iy{i} Iz{i}", 0.1, "kg*m^2"))
        center = end.at(f"C{i}", length / 2 * frame.z)
        bodies.append(kn.RigidBody(f"link {i}", frame=frame, mass_center=center, mass=m, inertia=inertia))
        end = end.at(f"P{i}", length * frame.z)
    return kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.z)])


def wrist_arm(lengths: Sequence[float] = (0.3, 0, 0.4, 0, 0.4, 0, 0.1)) -> kn.System:
    """Seven pins about z, each seat turned by ±90° about x, as robots have them: axes meet in shoulder, elbow and wrist.

    Masses, mass centres, all six moments and products of inertia and lengths, but those that are 0, are parameters.
    """
    N, g = kn.Frame("N"), kn.parameter("g", 9.81, "m/s^2")
    at, frame, joints, bodies = kn.Point("O", fixed_in=N), N, [], []
    for k, length in enumerate(lengths, 1):
        if length:
            at = at.at(f"P{k}", kn.parameter(f"l{k}", length, "m") * frame.z)
        seat = frame if k == 1 else frame.rotate(f"A{k}", kn.pi / 2 if k % 2 else -kn.pi / 2, frame.x)
        joints.append(kn.pin(f"joint{k}", at, seat, axis=seat.z))
        at, frame = joints[-1].point, joints[-1].frame
        c = kn.parameters(f"cx{k} cy{k} cz{k}", 0.1, "m")
        center = at.at(f"C{k}", c[0] * frame.x + c[1] * frame.y + c[2] * frame.z)
        inertia = kn.inertia(
            frame,
            *kn.parameters(f"Ixx{k} Iyy{k} Izz{k}", 0.1, "kg*m^2"),
            *kn.parameters(f"Ixy{k} Iyz{k} Izx{k}", 0.01, "kg*m^2"),
        )
        m = kn.parameter(f"m{k}", 1.0, "kg")
        bodies.append(kn.RigidBody(f"link {k}", frame=frame, mass_center=center, mass=m, inertia=inertia))
    return kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-g * N.z)])


def disk_by_three_speeds() -> kn.System:
    """The purely rolling disk with its independent speeds alone, as textbooks write it."""
    disk = pure_rolling_disk.system()
    own = {u: e for u, e in disk.speeds.items() if u.name in ("u1", "u2", "u3")}
    return disk.replace(speeds=own, dependent_speeds=())


COUNTED: dict[str, Callable[[], kn.System]] = {
    "planar pendulum, absolute angles, 2 rods": lambda: pendulums.system(2),
    "planar pendulum, absolute angles, 10 rods": lambda: pendulums.system(10),
    "planar pendulum, relative angles, 10 rods": lambda: pendulums.system(10, relative=True),
    "planar pendulum on a cart, 10 rods": lambda: pendulums.system(10, cart=True),
    "rolling disk, sliding": rolling_disk.system,
    "7R arm": lambda: arm("zyzyzyz"),
    "7R arm with wrist, full inertias": wrist_arm,
    "7R arm, general axes": lambda: random_tree(range(-1, 6), 1),
    "7R arm, every number a parameter": lambda: random_tree(range(-1, 6), 1, general=True),
    "tree of 20 bodies, general axes": lambda: random_tree(BRANCHES, 1),
    "free-flyer of 30 freedoms, general axes": lambda: random_tree(LIMBS, 1, floating=True),
    "Whipple bicycle": whipple_bicycle.system,
    "Whipple bicycle, spins as speeds": lambda: whipple_bicycle.system("spins"),
    "rolling disk, pure rolling": pure_rolling_disk.system,
    "rolling disk, pure rolling, independent speeds alone": disk_by_three_speeds,
    "four-bar": four_bar.system,
    "Bricard mechanism": bricard.system,
    "Andrews squeezer": andrews_squeezer.system,
    "rattleback": rattleback.system,
    "sphere on a turntable": sphere_on_turntable.system,
    "Chaplygin sleigh": chaplygin_sleigh.system,
    "snakeboard": snakeboard.system,
    "car with trailer": car_with_trailer.system,
    "rotating beam, 5 modes": lambda: rotating_beam.system(modes=5),
    "rotating beam, spin-up, 5 modes": lambda: rotating_beam.system(spin_up=True, modes=5),
    "flexible arm, two links": flexible_arm.system,
    "forearm with a muscle": muscle_arm.system,
}

# SPDX-License-Identifier: BSD-3-Clause
"""Bricard's mechanism: five rods and the ground in a loop of six hinges, which by its count of constraints could not move.

The rods stand along edges of a cube at the start, each hinge across the two edges that meet there. A chain of five hinges has five
coordinates, and the sixth hinge holds it by five constraints; yet wherever they hold, one follows from the other four, and the
mechanism moves. `kn.derive` says so when it is given all five (`redundant=True`). Left to itself the system leaves out the first,
the place of the hinge along x, which the other four give all along the motion.
"""

import kane as kn

TITLE = "Bricard's mechanism"
SOURCES = (
    "Bricard, R. (1897), Mémoire sur la théorie de l'octaèdre articulé, Journal de mathématiques pures et appliquées 3, 113-148.",
    "IFToMM Technical Committee for Multibody Dynamics, Library of Computational Benchmark Problems, and González, M., Dopico, D., "
    "Lugrís, U. and Cuadrado, J. (2006), A benchmarking system for MBS simulation software, Multibody System Dynamics 16, 179-190: "
    "problem A04, rods of 1 m and 1 kg from rest, gravity along −y. The square section of 0.1 m is that of the implementation by "
    "Tagliapietra, L., Vivian, M., Ceseracciu, E. and Reggiani, M. (2015), Multi-Body Systems Benchmark in OpenSim.",
)
START = {"q": {f"q{k}": 0.0 for k in range(1, 6)}, "u": {f"u{k}": 0.0 for k in range(1, 6)}}


def system(*, redundant: bool = False) -> kn.System:
    """The mechanism; with `redundant` all five constraints of the last hinge, of which one follows from the others."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinates("q1:6", "rad")
    m = kn.parameter("m", 1.0, "kg", "mass of each rod")
    l = kn.parameter("l", 1.0, "m", "length of each rod")
    w = kn.parameter("w", 0.1, "m", "width of the rods' square section")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    bodies, frame, end = [], N, O
    # The hinge's axis and the rod's direction, both along the axes of the rod that is made.
    for k, (hinge, along, sense) in enumerate(
        [("y", "x", 1), ("z", "y", -1), ("x", "z", 1), ("y", "x", -1), ("z", "y", 1)]
    ):
        frame = frame.rotate(f"B{k + 1}", q[k], getattr(frame, hinge))
        way = sense * getattr(frame, along)
        center, end = end.at(f"B{k + 1}*", l / 2 * way), end.at(f"P{k + 1}", l * way)
        edges = [l if axis == along else w for axis in "xyz"]
        inertia = kn.solids.box(frame, m, *edges)
        bodies.append(kn.RigidBody(f"rod {k + 1}", frame=frame, mass_center=center, mass=m, inertia=inertia))
    place = kn.coincident(end, O.at("Q", l * N.z), along=(N.x, N.y, N.z), name="last hinge")
    axis = kn.parallel(frame.x, N.x, across=(N.y, N.z), name="last axis")
    return kn.System(
        N,
        bodies=bodies,
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        holonomic=[*place, *axis] if redundant else [*place, *axis][1:],
        coordinates=q,
    )

# SPDX-License-Identifier: BSD-3-Clause
"""A bearing: a cone on four spheres that roll in a race.

Kane, T. R., Levinson, D. A. (1985), Dynamics: Theory and Applications, McGraw-Hill, problem 10.3 (of K), with the radius of 3.10.
Solutions: https://github.com/pydy/pydy/tree/master/examples/Kane1985 (Ex3.10, Ex10.3).
"""

from typing import Any

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """The cone's half angle is 30°; a sphere touches the race below and outside, and the cone."""
    N = kn.Frame("R")
    O = kn.Point("O", fixed_in=N)
    turn = kn.coordinate("q")
    omega = kn.speed("omega")
    M, J, across, m, r = kn.parameters("M J I m r")
    C = N.rotate("C", turn, N.z)
    root = kn.sqrt(3)
    b = r * (3 / (root - 1))  # r (1 + sin θ)/(cos θ − sin θ)
    bodies = [kn.RigidBody("C", frame=C, mass_center=O, mass=M, inertia=kn.inertia(C, across, across, J))]
    speeds: dict[kn.Speed, Any] = {omega: turn.dt}
    held: list[kn.Constraint] = []
    for k in "1234":
        way = kn.coordinate(f"p{k}")
        A = N.rotate(f"A{k}", way, N.z)
        S = A.rotate_euler_parameters(f"S{k}", kn.coordinates([f"e{k}{i}" for i in range(4)]))
        center = O.at(f"S{k}*", b * A.y)
        bodies.append(kn.RigidBody(f"S{k}", frame=S, mass_center=center, mass=m, inertia=kn.solid_sphere(S, m, r)))
        w = S.angular_velocity(N)
        speeds |= dict(
            zip(kn.speeds([f"u{k}{i}" for i in "1234"]), (way.dt, w.dot(A.x), w.dot(A.y), w.dot(A.z)), strict=True)
        )
        outward = (root * A.y - A.z) / 2  # away from the cone
        below, outside, inside = (
            center.fixed_in(S, f"{name}{k}", arm)
            for name, arm in (("below", -r * A.z), ("outside", r * A.y), ("inside", -r * outward))
        )
        on_cone = O.fixed_in(C, f"cone{k}", b * A.y - r * outward)
        held += kn.no_slip(below, along=(A.x, A.y), name=f"below {k}")
        held += kn.no_slip(outside, along=A.x, name=f"outside {k}")
        held += kn.no_slip(inside, on_cone, along=A.x, name=f"inside {k}")
    dependent = tuple(u for u in speeds if u is not omega)
    system = kn.System(N, bodies=bodies, speeds=speeds, nonholonomic=held, dependent_speeds=dependent)
    return Problem(system, {"K": [(J + 18 * m * r**2 * (2 + root) / 5) * omega**2 / 2]})

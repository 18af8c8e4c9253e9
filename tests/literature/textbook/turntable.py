# SPDX-License-Identifier: BSD-3-Clause
"""A sphere on a turntable, its mass distributed evenly about the centre: it runs on a circle at I/(I + m R²) of the table's rate.

Weltner, K. (1979), Stable circular orbits of freely moving balls on rotating discs, Am. J. Phys. 47, 984-986; Neimark, J. I.,
Fufaev, N. A. (1972), Dynamics of Nonholonomic Systems, AMS.
"""

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """The centre by x and y; the speeds of the centre and the spin about the vertical are independent."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    e = kn.coordinates("e0:4")
    m, R, J, rate = kn.parameters("m R I Omega", 1.0)
    across, along, up = (kn.input(f"F_{k}") for k in "xyz")
    T = N.rotate("T", rate * kn.time, N.z)
    S = N.rotate_euler_parameters("S", e)
    C = O.at("P", x * N.x + y * N.y).at("C", R * N.z)
    on_sphere = C.fixed_in(S, "S^", -R * N.z)
    on_table = O.fixed_in(T, "T^", x * N.x + y * N.y)
    u_x, u_y, w_x, w_y, w_z = kn.speeds("u_x u_y w_x w_y w_z")
    w = S.angular_velocity(N)
    force = across * N.x + along * N.y + up * N.z
    system = kn.System(
        N,
        bodies=[kn.RigidBody("sphere", frame=S, mass_center=C, mass=m, inertia=kn.inertia(S, J, J, J))],
        speeds={u_x: x.dt, u_y: y.dt, w_x: w.dot(N.x), w_y: w.dot(N.y), w_z: w.dot(N.z)},
        loads=[kn.Force(on_sphere, force), kn.Force(on_table, -force)],
        nonholonomic=kn.rolling(on_sphere, on_table, normal=N.z),
        dependent_speeds=(w_x, w_y),
        coordinates=(x, y, *e),
    )
    circling = J / (J + m * R**2) * rate
    return Problem(system, {"u̇": [-circling * u_y, circling * u_x, 0]}, [across, along, up])

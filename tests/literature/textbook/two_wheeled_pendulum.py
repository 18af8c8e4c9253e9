# SPDX-License-Identifier: BSD-3-Clause
"""A body that balances on two wheels.

Yamamoto, Y. (2008), NXTway-GS model-based design: control of a self-balancing two-wheeled robot, MATLAB Central 19147, eqs. 3.18 to 3.20, without
the motors' inertia. The same formulas are held by several public repositories under that name.
"""

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """The mean angle θ of the wheels, the pitch ψ and the yaw φ; a torque on each wheel from the body."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, phi, psi, of_right, of_left = kn.coordinates("x y phi psi theta_R theta_L")
    m, M, R, L, W, g = kn.parameters("m M R L W g", 0.5)
    J_w, J_psi, J_phi = kn.parameters("J_w J_psi J_phi")
    right, left = kn.input("tau_R"), kn.input("tau_L")
    Y = N.rotate("Y", phi, N.z)
    B = Y.rotate("B", psi, Y.y)
    P = O.at("ground", x * N.x + y * N.y).at("P", R * N.z)
    inertia = kn.inertia(B, J_phi, J_psi, J_phi)
    bodies = [kn.RigidBody("body", frame=B, mass_center=P.at("G", L * B.z), mass=M, inertia=inertia)]
    loads: list[kn.Torque] = []
    held: list[kn.Constraint] = [*kn.no_slip(P, along=Y.y, name="across")]
    for name, angle, side, torque in (("right", of_right, -W / 2, right), ("left", of_left, W / 2, left)):
        frame = Y.rotate(name, angle, Y.y)
        center = P.at(f"center of {name}", side * Y.y)
        bodies.append(
            kn.RigidBody(name, frame=frame, mass_center=center, mass=m, inertia=kn.inertia(frame, 0, J_w, 0))
        )
        held += kn.no_slip(center.fixed_in(frame, f"{name}^", -R * Y.z), along=Y.x, name=name)
        loads += [kn.Torque(frame, torque * Y.y), kn.Torque(B, -torque * Y.y)]
    u, w, f, e, a, b = kn.speeds("u_theta u_psi u_phi e a b")
    v = P.velocity(N)
    system = kn.System(
        N,
        bodies=bodies,
        speeds={
            u: (of_right.dt + of_left.dt) / 2, w: psi.dt, f: phi.dt, e: (of_right.dt - of_left.dt) / 2, a: v.dot(Y.x), b: v.dot(Y.y)
        },
        loads=[kn.gravity(-g * N.z), *loads],
        nonholonomic=held,
        dependent_speeds=(e, a, b),
        coordinates=(x, y, phi, psi, of_right, of_left),
    )  # fmt: skip
    sin, cos = kn.sin(psi), kn.cos(psi)
    rolled, pitched = (2 * m + M) * R**2 + 2 * J_w, M * L**2 + J_psi
    turned = m * W**2 / 2 + J_phi + W**2 / (2 * R**2) * J_w + M * L**2 * sin**2
    coupled = M * L * R * cos
    published = {
        "F̃": [right + left, M * g * L * sin - right - left, W / (2 * R) * (right - left)],
        "F̃*": [
            -(rolled * u.dt + coupled * w.dt - M * L * R * w**2 * sin),
            -(coupled * u.dt + pitched * w.dt - M * L**2 * f**2 * sin * cos),
            -(turned * f.dt + 2 * M * L**2 * w * f * sin * cos),
        ],
        "M̃": [rolled, coupled, 0, coupled, pitched, 0, 0, 0, turned],
    }
    return Problem(system, published)

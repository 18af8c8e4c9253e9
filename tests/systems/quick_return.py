# SPDX-License-Identifier: BSD-3-Clause
"""A quick-return mechanism whose sliding block has no mass."""

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def quick_return():
    """A crank turns an arm by a block that slides along it: the block, in m, has no mass, crank and arm, in rad, have."""
    th, ps, s = kn.coordinate("th", "rad"), kn.coordinate("ps", "rad"), kn.coordinate("s", "m")
    crank, arm = N.rotate("crank", th, N.z), N.rotate("arm", ps, N.z)
    pivot = O.at("C", 0.25 * N.y)
    pin = kn.coincident(pivot.at("P", 0.1 * crank.x), O.at("block", s * arm.x), along=(N.x, N.y), name="pin")
    bodies = [
        kn.RigidBody("crank", frame=crank, mass_center=pivot, mass=1, inertia=kn.inertia(crank, 0.05, 0.05, 0.05)),
        kn.RigidBody("arm", frame=arm, mass_center=O.at("A", 0.3 * arm.x), mass=3, inertia=kn.rod(arm, 3, 0.6, axis=arm.x)),
    ]  # fmt: skip
    motor = kn.Torque(crank, 0.5 * N.z, name="motor")
    forces = [kn.reaction(f"B_{k}", constraint=c) for k, c in zip("xy", pin, strict=True)]
    return kn.derive(
        kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-9.81 * N.y), motor], holonomic=pin, reactions=forces)
    )  # fmt: skip


QUICK = quick_return()
START = {"q": {"th": 0.5, "ps": kn.guess(1.2), "s": kn.guess(0.3)}, "u": {"u_th": 6.0}}

# SPDX-License-Identifier: BSD-3-Clause
"""A disk thrown forward with backspin: it slides, turns aside, and in the end rolls.

Run it: `python examples/sliding_disk.py [picture.png]`.
"""

import sys
from pathlib import Path

import numpy as np

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q1, q2, q3, q4, q5 = kn.coordinates("q1:6")  # 1  yaw, lean, spin, contact point
u1, u2, u3, u4, u5 = kn.speeds("u1:6")
m = kn.parameter("m", 1.2, "kg", "mass of the disk")
R = kn.parameter("R", 0.3, "m", "radius")
g = kn.parameter("g", 9.81, "m/s^2")
mu = kn.parameter("mu_k", 0.1, "1", "coefficient of sliding friction")

Y = N.rotate("Y", q1, N.z)
B = Y.rotate("B", kn.pi / 2 - q2, Y.x)  # b2 up the disk's plane, b3 along its axis
C = B.rotate("C", q3, B.z)
P = O.at("P", q4 * N.x + q5 * N.y)  # trace of the contact
Cs = P.at("C*", R * B.y)  # mass centre
Ch = Cs.fixed_in(C, "C^", -R * B.y)  # the disk's particle in contact
disk = kn.RigidBody("disk", frame=C, mass_center=Cs, mass=m, inertia=kn.solids.thin_disk(C, m, R, axis=C.z))

w = C.angular_velocity(N)  # 2
normal = kn.reaction("N_z", at=P, along=N.z)  # brings the normal force into evidence
slip = Ch.velocity(N).reject(N.z)
system = kn.System(
    N,
    bodies=[disk],
    reactions=[normal],
    speeds={u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z), u4: q4.dt, u5: q5.dt},  # 3
    loads=[kn.gravity(-g * N.z), kn.friction(Ch, normal, mu)],
)
eom = kn.derive(system)  # 4 to 7: accelerations and N_z, solved together
sol = kn.simulate(
    eom,
    (0, 5),
    q={q1: 0, q2: 0.1, q3: 0, q4: 0, q5: 0},
    u={u1: 0, u2: 2, u3: 25, u4: 2, u5: 0},
)

assert sol.status == "event", sol.message  # rolling sets in
assert sol.energy_check.relative < 1e-8, sol.energy_check  # E − ∫P dt is constant
assert sol[normal].min() > 0  # the disk stays on the ground
assert sol[slip.magnitude()][-1] < 1.1e-4 * sol[slip.magnitude()].max()
print(sol)
print(sol.energy_check)


def picture(path: Path) -> None:
    """The disk's path seen from above with its outline now and then, and the normal force."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 3.9), layout="constrained", facecolor="white")
    above, force = figure.subplots(1, 2, width_ratios=(1, 1.15))
    center, contact = sol[Cs.position(O)], sol[P.position(O)]
    edge = [
        Cs.position(O) + R * (float(np.cos(a)) * B.x + float(np.sin(a)) * B.y) for a in np.linspace(0, 2 * np.pi, 49)
    ]
    outline = np.stack(sol[edge], axis=1)
    for i in np.searchsorted(sol.t, np.linspace(0, sol.t[-1], 14))[:14]:
        i = min(int(i), len(sol) - 1)
        above.fill(outline[i, :, 0], outline[i, :, 1], facecolor="#0b5cad22", edgecolor="#0b5cad", linewidth=0.8)
    above.plot(center[:, 0], center[:, 1], color="#0b5cad", linewidth=2, label="mass centre")
    above.plot(contact[:, 0], contact[:, 1], color="#c2410c", linewidth=1.4, label="contact")
    above.set(xlabel="x [m]", ylabel="y [m]", title="from above")
    above.set_aspect("equal", adjustable="datalim")
    above.legend(frameon=False, loc="upper left")
    force.plot(sol.t, sol[normal], color="#0b5cad", label="$N_z$")
    force.axhline(1.2 * 9.81, color="#777777", linewidth=1, linestyle="--", label="$mg$")
    force.set(xlabel="t [s]", ylabel="[N]", title="normal force, until rolling sets in")
    force.legend(frameon=False)
    for axes in (above, force):
        axes.grid(True, color="#e4e4e0", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=130, metadata={"Software": None})


if __name__ == "__main__" and len(sys.argv) > 1:
    picture(Path(sys.argv[1]))

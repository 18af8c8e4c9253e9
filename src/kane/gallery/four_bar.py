# SPDX-License-Identifier: BSD-3-Clause
"""The four-bar linkage: a crank, a coupler and a rocker, uniform rods pinned to each other and to the ground.

The three rods hang together from the ground pin O, pin by pin through A and B; two configuration constraints close the loop at
the ground pin G. The forces at O, A and B are brought into evidence by cuts, those at G are the multipliers of the constraints.
"""

import kane as kn

TITLE = "four-bar linkage with its pin reactions"
SOURCES = (
    "Uicker, J. J., Pennock, G. R. and Shigley, J. E. (2003), Theory of Machines and Mechanisms, 3rd ed., Oxford University Press "
    "(the linkage; the lengths and masses are this project's own, those of a crank and rocker).",
    "Kane, T. R. and Levinson, D. A. (1985), Dynamics: Theory and Applications, McGraw-Hill, sec. 4.9 (forces in evidence).",
)
START = {"q": {"q1": 1.2, "q2": kn.guess(0.4), "q3": kn.guess(-1.5)}, "u": {"u1": 5.0}}


def system() -> kn.System:
    """The linkage in a vertical plane; each angle is measured from the x axis, along the ground link from O to G."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1 = kn.coordinate("q1", "rad", "angle of the crank")
    q2 = kn.coordinate("q2", "rad", "angle of the coupler")
    q3 = kn.coordinate("q3", "rad", "angle of the rocker")
    a = kn.parameter("a", 0.4, "m", "length of the crank")
    b = kn.parameter("b", 1.0, "m", "length of the coupler")
    c = kn.parameter("c", 0.8, "m", "length of the rocker")
    d = kn.parameter("d", 1.1, "m", "distance of the ground pins")
    m1 = kn.parameter("m1", 0.8, "kg", "mass of the crank")
    m2 = kn.parameter("m2", 2.0, "kg", "mass of the coupler")
    m3 = kn.parameter("m3", 1.6, "kg", "mass of the rocker")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    bodies, pins, end = [], [], O
    for name, q, l, m, pin in (("crank", q1, a, m1, "O"), ("coupler", q2, b, m2, "A"), ("rocker", q3, c, m3, "B")):
        frame = N.rotate(name, q, N.z)
        start = end.at(f"{pin}'", 0)  # the pin as the rod feels it: where the tree is cut
        center, end = start.at(f"{name}*", l / 2 * frame.x), start.at(f"end of the {name}", l * frame.x)
        bodies.append(
            kn.RigidBody(name, frame=frame, mass_center=center, mass=m, inertia=kn.solids.rod(frame, m, l, frame.x))
        )
        pins += [kn.reaction(f"{pin}_x", at=start, along=N.x), kn.reaction(f"{pin}_y", at=start, along=N.y)]
    G = O.at("G", d * N.x)
    closing = kn.coincident(end, G, along=(N.x, N.y), name="pin G")
    pins += [kn.reaction("G_x", constraint=closing[0]), kn.reaction("G_y", constraint=closing[1])]
    return kn.System(
        N,
        bodies=bodies,
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        reactions=pins,
        holonomic=closing,
        coordinates=(q1, q2, q3),
    )

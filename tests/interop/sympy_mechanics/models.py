# SPDX-License-Identifier: BSD-3-Clause
"""Small models by SymPy's mechanics, one for each way of saying things there: each returns what is imported."""

from typing import Any

import sympy
import sympy.physics.mechanics as me

m, g, l, k, c, I1, I2, I3, a, b = sympy.symbols("m g l k c I1 I2 I3 a b", positive=True)
t = me.dynamicsymbols._t


def _base() -> tuple[Any, Any]:
    N, O = me.ReferenceFrame("N"), me.Point("O")
    O.set_vel(N, 0)
    return N, O


def _method(N: Any, q: Any, u: Any, bodies: Any, loads: Any, kd: Any = None, **more: Any) -> Any:
    kd = [x.diff() - s for x, s in zip(q, u, strict=True)] if kd is None else kd
    method = me.KanesMethod(N, q, u, kd_eqs=kd, **more)
    method.kanes_equations(bodies, loads)
    return method


def pendulum() -> Any:
    """Position and velocity agree; a torque that is a function of time."""
    q, u, T = me.dynamicsymbols("q u T")
    N, O = _base()
    B = N.orientnew("B", "Axis", [q, N.z])
    B.set_ang_vel(N, u * N.z)
    P = O.locatenew("P", l * B.x)
    P.v2pt_theory(O, N, B)
    body = me.RigidBody("rod", P, B, m, (me.inertia(B, I1, I2, I3), P))
    return _method(N, [q], [u], [body], [(P, m * g * N.x), (B, T * N.z)])


def velocity_alone() -> Any:
    """A point without any position."""
    q, u = me.dynamicsymbols("q u")
    N, _ = _base()
    P = me.Point("P")
    P.set_vel(N, u * N.x)
    return _method(N, [q], [u], [me.Particle("p", P, m)], [(P, (-k * q - c * u) * N.x)])


def oriented(how: str) -> Any:
    """A body turned about an axis of any direction, by a sequence, or by a matrix after a quarter turn."""
    q, u = me.dynamicsymbols("q1:4"), me.dynamicsymbols("u1:4")
    N, O = _base()
    if how == "axis":
        E, n = N.orientnew("E", "Axis", [q[0], (N.x + 2 * N.y + 2 * N.z) / 3]), 1
    elif how == "matrix":
        C = N.orientnew("C", "Axis", [sympy.pi / 2, N.x])
        D = C.orientnew("D", "Axis", [q[0], C.y])
        E, n = me.ReferenceFrame("E"), 1
        E.orient_explicit(D, sympy.Matrix([[0, 0, 1], [1, 0, 0], [0, 1, 0]]))
        E.set_ang_vel(D, 0)
    else:
        E, n = N.orientnew("E", *how.split()[:1], q, how.split()[1]), 3
    P = O.locatenew("P", a * E.x + b * E.z)
    P.v2pt_theory(O, N, E)
    body = me.RigidBody("body", P, E, m, (me.inertia(E, I1, I2, I3, I1 / 9, I2 / 8, I3 / 7), P))
    return _method(N, q[:n], u[:n], [body], [(P, m * g * N.z)])


def quaternion(four: bool) -> Any:
    """A free body by a quaternion: speeds along its axes, or its rates with a constraint."""
    e, x = me.dynamicsymbols("e0:4"), me.dynamicsymbols("x")
    v, w = me.dynamicsymbols("v"), me.dynamicsymbols("w1:5" if four else "w1:4")
    N, O = _base()
    B = me.ReferenceFrame("B")
    B.orient_quaternion(N, e)
    P = O.locatenew("P", x * N.x)
    P.set_vel(N, v * N.x)
    body = me.RigidBody("body", P, B, m, (me.inertia(B, I1, I2, I3), P))
    loads = [(B, k * N.z), (P, -c * x * N.x)]
    if four:
        length = e[0] ** 2 + e[1] ** 2 + e[2] ** 2 + e[3] ** 2 - 1
        rate = sum(p * s for p, s in zip(e, w, strict=True))
        kd = [x.diff() - v, *(p.diff() - s for p, s in zip((*e[1:], e[0]), (*w[1:], w[0]), strict=True))]
        return _method(
            N, [x, *e[1:]], [v, *w[1:]], [body], loads, kd, q_dependent=[e[0]], u_dependent=[w[0]],
            configuration_constraints=[length], velocity_constraints=[rate],
        )  # fmt: skip
    e0, e1, e2, e3 = e
    rows = sympy.Matrix([[-e1, -e2, -e3], [e0, -e3, e2], [e3, e0, -e1], [-e2, e1, e0]]) * sympy.Matrix(w) / 2
    B.set_ang_vel(N, w[0] * B.x + w[1] * B.y + w[2] * B.z)
    return _method(
        N, [x, *e], [v, *w], [body], loads, [x.diff() - v, *(p.diff() - r for p, r in zip(e, rows, strict=True))]
    )


def rotor() -> Any:
    """A rotor given by its angular velocity alone, about an axis of its carrier."""
    q, u = me.dynamicsymbols("q1:3"), me.dynamicsymbols("u1:3")
    N, O = _base()
    A = N.orientnew("A", "Axis", [q[0], N.z])
    A.set_ang_vel(N, u[0] * N.z)
    C = me.ReferenceFrame("C")
    C.set_ang_vel(A, u[1] * A.x)
    P = O.locatenew("P", l * A.x)
    P.v2pt_theory(O, N, A)
    body = me.RigidBody("rotor", P, C, m, (me.inertia(A, I1, I2, I2), P))
    return _method(N, q, u, [body], [(C, -c * u[1] * A.x)])


def spun() -> Any:
    """A rotor oriented by an angle that nobody gives, with a constant angular velocity in its carrier."""
    q, u, s = me.dynamicsymbols("q u s")
    N, O = _base()
    A = N.orientnew("A", "Axis", [q, N.z])
    A.set_ang_vel(N, u * N.z)
    C = A.orientnew("C", "Axis", [s, A.z])
    C.set_ang_vel(A, k * A.z)
    P = O.locatenew("P", l * A.x)
    P.v2pt_theory(O, N, A)
    body = me.RigidBody("rotor", P, C, m, (me.inertia(C, I1, I2, I3), P))
    return _method(N, [q], [u], [body], [(P, m * g * N.x)])


def pushed() -> Any:
    """A pendulum on a pin that is moved: its velocity and its acceleration are functions of their own names."""
    q, u, v, f = me.dynamicsymbols("q u v f")
    N, O = _base()
    A = N.orientnew("A", "Axis", [q, N.z])
    A.set_ang_vel(N, u * N.z)
    J = O.locatenew("J", 0 * N.x)
    J.set_vel(N, v * N.x)
    J.set_acc(N, f * N.x)
    P = J.locatenew("P", l * A.x)
    P.v2pt_theory(J, N, A)
    P.a2pt_theory(J, N, A)
    return _method(N, [q], [u], [me.Particle("p", P, m)], [(P, m * g * N.x)])


def tumbling() -> Any:
    """A body without orientation: Euler's equations, with a coordinate that no kinematical equation needs."""
    q, u = me.dynamicsymbols("q"), me.dynamicsymbols("u1:4")
    N, O = _base()
    C = me.ReferenceFrame("C")
    C.set_ang_vel(N, u[0] * C.x + u[1] * C.y + u[2] * C.z)
    body = me.RigidBody("body", O, C, m, (me.inertia(C, I1, I2, I3), O))
    return _method(N, [q], u, [body], [(C, -c * u[1] * C.x)], [q.diff() - u[0]])


def knife_edge() -> Any:
    """Fewer speeds than coordinates: two kinematical equations are a motion constraint and a definition."""
    x, y, h = me.dynamicsymbols("x y h")
    v, w = me.dynamicsymbols("v w")
    N, O = _base()
    B = N.orientnew("B", "Axis", [h, N.z])
    B.set_ang_vel(N, w * N.z)
    P = O.locatenew("P", x * N.x + y * N.y)
    P.set_vel(N, v * B.x)
    body = me.RigidBody("sled", P, B, m, (me.inertia(B, I1, I2, I3), P))
    kd = [x.diff() - v * sympy.cos(h), y.diff() - v * sympy.sin(h), h.diff() - w]
    return _method(N, [x, y, h], [v, w], [body], [(P, m * g * N.y)], kd)


def four_bar() -> Any:
    """A closed loop: configuration constraints and their rates, inertia about a pin."""
    q, u = me.dynamicsymbols("q1:4"), me.dynamicsymbols("u1:4")
    N, O = _base()
    links, bodies, P, frame = sympy.symbols("l1:4", positive=True), [], O, N
    for x, s, size in zip(q, u, links, strict=True):
        before, frame = frame, frame.orientnew(f"B{x.name}", "Axis", [x, N.z])
        frame.set_ang_vel(before, s * N.z)
        center = P.locatenew(f"C{x.name}", size / 2 * frame.x)
        center.v2pt_theory(P, N, frame)
        bodies.append(me.RigidBody(f"link{x.name}", center, frame, m, (me.inertia(frame, 0, 0, m * size**2 / 3), P)))
        end = P.locatenew(f"E{x.name}", size * frame.x)
        end.v2pt_theory(P, N, frame)
        P = end
    gap = P.pos_from(O) - a * N.x
    closed = [gap.dot(N.x), gap.dot(N.y)]
    moving = [P.vel(N).dot(N.x), P.vel(N).dot(N.y)]
    return _method(
        N, q[:1], u[:1], bodies, [(x.masscenter, -m * g * N.y) for x in bodies],
        [x.diff() - s for x, s in zip(q, u, strict=True)], q_dependent=q[1:], u_dependent=u[1:],
        configuration_constraints=closed, velocity_constraints=moving,
    )  # fmt: skip


def uneven(config: bool) -> Any:
    """A bead whose configuration constraint has no velocity constraint, or whose acceleration constraint lacks a term."""
    x, y, v, w = me.dynamicsymbols("x y v w")
    N, O = _base()
    P = O.locatenew("P", x * N.x + y * N.y)
    P.set_vel(N, v * N.x + w * N.y)
    bead, kd = [me.Particle("bead", P, m)], [x.diff() - v, y.diff() - w]
    if config:
        more = {"q_dependent": [y], "configuration_constraints": [y - x**2 / a]}
        return _method(N, [x], [v, w], bead, [(P, -k * x * N.x)], kd, **more)
    more = {"velocity_constraints": [w - x * v / a], "acceleration_constraints": [w.diff() - x * v.diff() / a]}
    return _method(N, [x, y], [v], bead, [(P, -k * x * N.x)], kd, u_dependent=[w], **more)


def twice_as_fast() -> Any:
    """A point whose velocity is not the rate of its position."""
    q, u = me.dynamicsymbols("q u")
    N, O = _base()
    P = O.locatenew("P", q * N.x)
    P.set_vel(N, 2 * u * N.x)
    return _method(N, [q], [u], [me.Particle("p", P, m)], [(P, -k * q * N.x)])


def tension() -> Any:
    """A pendulum whose rod's tension an auxiliary speed brings into evidence: S = m l u² + m g cos q."""
    q, u, ua, S = me.dynamicsymbols("q u ua S")
    N, O = _base()
    B = N.orientnew("B", "Axis", [q, N.z])
    B.set_ang_vel(N, u * N.z)
    P = O.locatenew("P", l * B.x)
    P.set_vel(N, l * u * B.y + ua * B.x)
    return _method(N, [q], [u], [me.Particle("p", P, m)], [(P, m * g * N.x - S * B.x)], u_auxiliary=[ua])


def joints() -> Any:
    """SymPy's System with joints, a spring, a damper and a motor."""
    wall, cart, arm = (me.RigidBody(name) for name in ("wall", "cart", "arm"))
    system = me.System.from_newtonian(wall)
    slide = me.PrismaticJoint("slide", wall, cart, joint_axis=wall.x)
    pin = me.PinJoint("pin", cart, arm, joint_axis=cart.z, child_point=-l * arm.y)
    system.add_joints(slide, pin)
    path = me.LinearPathway(wall.masscenter, arm.masscenter)
    system.add_actuators(
        me.LinearSpring(k, path, a), me.LinearDamper(c, path),
        me.TorqueActuator(me.dynamicsymbols("T"), pin.parent_interframe.z, arm.frame, pin.parent_interframe),
    )  # fmt: skip
    system.apply_uniform_gravity(-g * wall.y)
    return system


def lagrange() -> Any:
    """A pendulum on a spring by Lagrange's method, told its bodies."""
    q, r = me.dynamicsymbols("q r")
    N, O = _base()
    B = N.orientnew("B", "Axis", [q, N.z])
    P = O.locatenew("P", r * B.x)
    P.set_vel(N, P.pos_from(O).dt(N))
    body = me.Particle("p", P, m)
    body.potential_energy = k * (r - l) ** 2 / 2 - m * g * r * sympy.cos(q)
    method = me.LagrangesMethod(me.Lagrangian(N, body), [q, r], forcelist=[(P, -c * P.vel(N))], bodies=[body], frame=N)
    method.form_lagranges_equations()
    return method


def jointed() -> Any:
    """SymPy's older JointsMethod, whose classes warn that they will go."""
    wall, bob = me.Body("wall"), me.Body("bob")
    return me.JointsMethod(wall, me.PinJoint("pin", wall, bob, child_point=l * bob.y))


def pulled(how: str) -> Any:
    """A bob on a rod whose rope goes over an obstacle, or round a cylinder or sphere."""
    q, u, F = me.dynamicsymbols("q u F")
    N, O = _base()
    B = N.orientnew("B", "Axis", [q, N.z])
    B.set_ang_vel(N, u * N.z)
    P, end = O.locatenew("P", l * B.x), O.locatenew("E", a * B.x)
    P.v2pt_theory(O, N, B)
    end.v2pt_theory(O, N, B)
    start = O.locatenew("S", a * N.x)
    corner = O.locatenew("C", b * N.y + a * N.x)
    start.set_vel(N, 0)
    corner.set_vel(N, 0)
    ways = {
        "obstacle": lambda: me.ObstacleSetPathway(start, corner, P),
        "cylinder": lambda: me.WrappingPathway(start, end, me.WrappingCylinder(a, O, N.z)),
        "sphere": lambda: me.WrappingPathway(start, end, me.WrappingSphere(a, O)),
    }
    return _method(N, [q], [u], [me.Particle("bob", P, m)], me.ForceActuator(F, ways[how]()).to_loads())


def turntable() -> Any:
    """A particle on a table that turns, with speeds along the table, on a spring that hardens."""
    x, y, u, v = me.dynamicsymbols("x y u v")
    N, O = _base()
    table = N.orientnew("T", "Axis", [c * t, N.z])
    P = O.locatenew("P", x * table.x + y * table.y)
    O.set_vel(table, 0)
    P.set_vel(table, u * table.x + v * table.y)
    P.v1pt_theory(O, N, table)
    spring = me.DuffingSpring(b, k, me.LinearPathway(O, P), l)
    return _method(N, [x, y], [u, v], [me.Particle("bob", P, m)], spring.to_loads())

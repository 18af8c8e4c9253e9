# SPDX-License-Identifier: BSD-3-Clause
"""Where SymPy 1.14's mechanics gives a wrong answer without a word: kane is right there, or says what is wrong.

Each test shows first what SymPy answers, so that the claim itself is checked, and then the same model in kane.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sm
from sympy.physics import mechanics as me

import kane as kn

m, l, g, I = sm.symbols("m l g I", positive=True)
MASS, LENGTH, GRAVITY, INERTIA = 2.0, 0.5, 9.81, 0.3
VALUES = {m: MASS, l: LENGTH, g: GRAVITY, I: INERTIA}

# A bead on a circular wire, in Cartesian coordinates ----------------------------------------------------------------------

X, Y, U, V = me.dynamicsymbols("x y u v")


def bead_by_sympy(**arguments: Any) -> Any:
    """The bead's KanesMethod; the wire is in the arguments."""
    N, O = me.ReferenceFrame("N"), me.Point("O")
    O.set_vel(N, 0)
    P = O.locatenew("P", X * N.x + Y * N.y)
    P.set_vel(N, U * N.x + V * N.y)
    method = me.KanesMethod(
        N,
        q_ind=[X],
        q_dependent=[Y],
        kd_eqs=[X.diff() - U, Y.diff() - V],
        configuration_constraints=[X**2 + Y**2 - l**2],
        **arguments,
    )
    method.kanes_equations([me.Particle("bead", P, m)], [(P, -m * g * N.y)])
    return method


def bead(dependent: str = "") -> kn.Equations:
    """The bead by kane, the wire a configuration constraint and nothing more."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinate("x", "m"), kn.coordinate("y", "m")
    u, v = kn.speed("u", "m/s"), kn.speed("v", "m/s")
    mass, length = kn.parameter("m", MASS, "kg"), kn.parameter("l", LENGTH, "m")
    P = O.at("P", x * N.x + y * N.y)
    system = kn.System(
        N,
        bodies=[kn.Particle("bead", P, mass)],
        speeds={u: x.dt, v: y.dt},
        loads=[kn.gravity(-GRAVITY * N.y)],
        holonomic=[kn.distance(P, O, length, name="wire")],
        dependent_coordinates=[s for s in (x, y) if s.name == dependent],
        dependent_speeds=[s for s, name in ((u, "x"), (v, "y")) if name == dependent],
    )
    return kn.derive(system)


def on_the_wire(angle: float, rate: float) -> dict[str, dict[str, float]]:
    """State of the bead at an angle from the bottom."""
    c, s = np.cos(angle), np.sin(angle)
    return {"q": {"x": LENGTH * s, "y": -LENGTH * c}, "u": {"u": LENGTH * rate * c, "v": LENGTH * rate * s}}


def acceleration_on_the_wire(angle: float, rate: float) -> Any:
    c, s = np.cos(angle), np.sin(angle)
    along = -GRAVITY * s / LENGTH
    return LENGTH * np.array([along * c - rate**2 * s, along * s + rate**2 * c])


def test_configuration_constraint_without_its_velocity_constraint() -> None:
    """SymPy drops the wire: the bead falls freely."""
    method = bead_by_sympy(u_ind=[U, V])
    assert method.mass_matrix.LUsolve(method.forcing) == sm.Matrix([0, -g])

    eom = bead()
    assert len(eom.dependent_speeds) == 1
    for angle, rate in ((0.4, 0.0), (2.0, -3.0), (-1.0, 5.0)):
        found = eom.evaluate(eom.accelerations, **on_the_wire(angle, rate))
        np.testing.assert_allclose(found, acceleration_on_the_wire(angle, rate), rtol=1e-12)


def test_linearization_off_the_constraints() -> None:
    """SymPy linearizes about a place below the wire, and at one on it with a speed across it."""
    method = bead_by_sympy(u_ind=[U], u_dependent=[V], velocity_constraints=[X * U + Y * V])
    rest = {U.diff(): 0, V.diff(): 0}
    for place, stiffness in (
        ({X: 0, Y: -l, U: 0, V: 0}, g / l),
        ({X: 0, Y: -2 * l, U: 0, V: 0}, g / (2 * l)),
        ({X: 0, Y: -l, U: 0, V: 3}, g / l),
    ):
        A, _, _ = method.linearize(A_and_B=True, op_point=place | rest)
        assert sm.simplify(A - sm.Matrix([[0, 1], [-stiffness, 0]])) == sm.zeros(2)

    eom = bead()
    here = kn.linearize(eom, q={"x": 0.0, "y": -LENGTH}, u={"u": 0.0, "v": 0.0})
    np.testing.assert_allclose(here.A, [[0, 1], [-GRAVITY / LENGTH, 0]], atol=1e-12)
    with pytest.raises(
        kn.SimulationError,
        match=r"operating point on the constraints, got coordinates that miss wire by 0\.75\. .*assemble",
    ):
        kn.linearize(eom, q={"x": 0.0, "y": -2 * LENGTH}, u={"u": 0.0, "v": 0.0})
    with pytest.raises(
        kn.SimulationError, match=r"satisfy the constraints A u \+ b = 0, got some that miss 'wire' by -3"
    ):
        kn.linearize(eom, q={"x": 0.0, "y": -LENGTH}, u={"u": 0.0, "v": 3.0})


def test_singular_pivot_of_the_dependent_speed() -> None:
    """With v dependent, v = −x u / y has no meaning beside the centre: SymPy's numbers are inf and nan there."""
    method = bead_by_sympy(u_ind=[U], u_dependent=[V], velocity_constraints=[X * U + Y * V])
    side = {X: l, Y: 0, U: 0, V: 1}
    assert me.msubs(method.mass_matrix, side)[0, 1] is sm.zoo
    assert list(me.msubs(method.rhs(), side))[2:] == [sm.nan, sm.nan]
    mass = sm.lambdify([X, Y, m], method.mass_matrix)
    with np.errstate(divide="ignore"):
        assert np.isinf(mass(np.float64(LENGTH), np.float64(0), MASS)[0, 1])

    rate = 8.0  # all the way round: past the sides, where v cannot be the dependent speed, and past top and bottom
    whole = kn.simulate(bead("y"), (0.0, 2.0), **on_the_wire(np.pi / 2, rate), rtol=1e-10, atol=1e-12)
    assert np.ptp(np.unwrap(np.arctan2(whole["x"], -whole["y"]))) > 4 * np.pi
    assert whole.energy_check.drift < 1e-6 * whole.energy_check.scale
    states = {"q": {k: whole[k] for k in "xy"}, "u": {k: whole[k] for k in "uv"}}
    missed = np.abs(np.hypot(states["q"]["x"], states["q"]["y"]) - LENGTH).max()
    assert missed < 1e-10
    with pytest.warns(
        kn.KaneWarning, match=r"Expected finite results of rhs, got v, which the constraints give divided by y/l = 0"
    ):
        bead("y").compile().rhs(0.0, np.array([LENGTH, 0.0, 0.0, 1.0]))


# A pendulum whose velocities SymPy is told by hand ------------------------------------------------------------------------

Q, W = me.dynamicsymbols("q w")
UPRIGHT = MASS * GRAVITY * LENGTH / (INERTIA + MASS * LENGTH**2)


def pendulum_by_sympy(told: Any, kinematic: Any) -> Any:
    """q̈ of the pendulum, its frame's angular velocity told, by KanesMethod."""
    N, O = me.ReferenceFrame("N"), me.Point("O")
    O.set_vel(N, 0)
    A = N.orientnew("A", "Axis", [Q, N.z])
    A.set_ang_vel(N, told * N.z)
    C = O.locatenew("C", -l * A.y)
    C.v2pt_theory(O, N, A)
    body = me.RigidBody("rod", C, A, m, (me.inertia(A, 0, 0, I), C))
    method = me.KanesMethod(N, q_ind=[Q], u_ind=[W], kd_eqs=[kinematic])
    method.kanes_equations([body], [(C, -m * g * N.y)])
    rates = method.rhs()
    return me.msubs(rates[0].diff(W) * rates[1], VALUES)


def pendulum(sign: int, told: Any = None) -> tuple[kn.Equations, kn.Frame]:
    """The pendulum by kane with w = ± q', and an angular velocity told as a check."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q, w = kn.coordinate("q", "rad"), kn.speed("w", "rad/s")
    mass, length, inertia = kn.parameter("m", MASS, "kg"), kn.parameter("l", LENGTH, "m"), kn.parameter("I", INERTIA)
    A = N.rotate("A", q, N.z, angular_velocity=None if told is None else told(q, w) * N.z)
    C = O.at("C", -length * A.y)
    rod = kn.RigidBody("rod", frame=A, mass_center=C, mass=mass, inertia=kn.inertia(A, inertia, inertia, inertia))
    return kn.derive(kn.System(N, bodies=[rod], speeds={w: sign * q.dt}, loads=[kn.gravity(-GRAVITY * N.y)])), A


def test_the_pendulum_itself() -> None:
    """Both agree while nothing is wrong."""
    fall = pendulum_by_sympy(W, Q.diff() - W)
    assert float(fall.subs(Q, 0.7)) == pytest.approx(-UPRIGHT * np.sin(0.7), rel=1e-14)
    eom, _ = pendulum(1)
    found = eom.evaluate(eom.accelerations, q={"q": 0.7}, u={"w": 1.3})
    np.testing.assert_allclose(found, [-UPRIGHT * np.sin(0.7)], rtol=1e-14)


def test_angular_velocity_that_contradicts_the_orientation() -> None:
    """SymPy believes set_ang_vel, here twice q', and halves the pendulum's acceleration."""
    fall = pendulum_by_sympy(2 * W, Q.diff() - W)
    assert float(fall.subs(Q, 0.7)) == pytest.approx(-UPRIGHT * np.sin(0.7) / 2, rel=1e-14)

    with pytest.raises(
        kn.SpaceError,
        match=r"angular velocity of A in N that its orientation gives, q' A\.z, got 2\*q' N\.z\. Correct its sign or the angle",
    ):
        pendulum(1, lambda q, w: 2 * q.dt)
    with pytest.raises(kn.SpaceError, match=r"got -q' N\.z\. Correct its sign"):
        pendulum(1, lambda q, w: -q.dt)
    with pytest.raises(kn.SpaceError, match=r"q' A\.z, got w N\.z\. .*leave it out: it follows from the angle"):
        pendulum(1, lambda q, w: w)
    assert not hasattr(kn.Frame("N"), "set_ang_vel")


def test_kinematic_equation_with_the_wrong_sign() -> None:
    """SymPy takes q' = −w beside velocities written with q' = w: the pendulum falls up. In kane w = −q' is a choice of speeds."""
    fall = pendulum_by_sympy(W, Q.diff() + W)
    assert float(fall.subs(Q, 0.7)) == pytest.approx(+UPRIGHT * np.sin(0.7), rel=1e-14)

    found = {}
    for sign in (1, -1):
        eom, A = pendulum(sign)
        N = eom.system.inertial
        state = {"q": {"q": 0.7}, "u": {"w": sign * 1.3}}
        spin = eom.angular_velocities[A].dot(N.z)
        now = eom.evaluate([spin, eom.time_derivative(eom.rates[0]), eom.energy], **state)
        (own,) = eom.evaluate(eom.accelerations, **state)
        assert own == pytest.approx(-sign * UPRIGHT * np.sin(0.7), rel=1e-14)
        assert eom.evaluate([eom.time_derivative(eom.energy)], **state)[0] == pytest.approx(0, abs=1e-12)
        moved = kn.simulate(eom, (0.0, 2.0), **state, rtol=1e-11, atol=1e-12)
        found[sign] = [float(value) for value in (*now, moved["q"][-1])]
    assert found[1][:2] == pytest.approx([1.3, -UPRIGHT * np.sin(0.7)], rel=1e-14)
    assert found[-1] == pytest.approx(found[1], rel=1e-8)

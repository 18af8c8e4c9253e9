# SPDX-License-Identifier: BSD-3-Clause
"""Loads against hand formulas; pairs give no net force or moment; a potential's slope is the force."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.paths import Path, numbers

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinates("q1:7")
A = N.rotate("A", q[0], (N.x + 2 * N.y + 2 * N.z) / 3)
P = O.at("P", q[1] * N.x + q[2] * N.y + q[3] * N.z)
Q = O.at("Q", q[4] * A.x + q[5] * A.y + 1.5 * A.z)
k = kn.parameter("k", 7.0)
c = kn.parameter("c", 0.6)
free = kn.parameter("l0", 0.8)
PATH = Path(q, 31)
STATE = PATH.values()


def along(v, values=STATE):
    return numbers(v.components(N), values)


def net(load, values=STATE):
    """Resultant and moment about O."""
    force, moment = np.zeros(3), np.zeros(3)
    for point, f in load.forces:
        force += along(f, values)
        moment += np.cross(along(point.position(O), values), along(f, values))
    for _, t in load.torques:
        moment += along(t, values)
    return np.concatenate([force, moment])


p, s = along(P.position(O)), along(Q.position(O))
r = p - s
PAIRS = {
    "spring": kn.linear_spring(P, Q, k, free),
    "spring without length": kn.linear_spring(P, Q, k),
    "damper": kn.linear_damper(P, Q, c),
    "motor": kn.torque_pair(A, N, 3 * A.x),
    "pair": kn.action_reaction(P, Q, r @ r * P.position(Q)),
    "torsional spring": kn.torsional_spring(A, N, q[0], k, (N.x + 2 * N.y + 2 * N.z) / 3, rest=0.2),
    "torsional damper": kn.torsional_damper(A, N, c, (N.x + 2 * N.y + 2 * N.z) / 3),
}


@pytest.mark.parametrize("name", PAIRS)
def test_pairs_give_no_net_force_or_moment(name):
    assert net(PAIRS[name]) == pytest.approx(np.zeros(6), abs=1e-12)


def test_an_action_and_reaction_off_the_line_is_a_couple():
    load = kn.action_reaction(P, Q, 2 * N.x)
    assert net(load)[:3] == pytest.approx(np.zeros(3))
    assert net(load)[3:] == pytest.approx(np.cross(r, [2, 0, 0]))


def test_spring():
    length = np.linalg.norm(r)
    (on_p, f), (on_q, _) = PAIRS["spring"].forces
    assert (on_p, on_q) == (P, Q)
    assert along(f) == pytest.approx(-7 * (length - 0.8) * r / length)
    assert numbers([PAIRS["spring"].potential], STATE) == pytest.approx(7 * (length - 0.8) ** 2 / 2)
    assert along(PAIRS["spring without length"].forces[0][1]) == pytest.approx(-7 * r)


def test_damper():
    length = np.linalg.norm(r)
    v = along(P.velocity(N)) - along(Q.velocity(N))
    expected = -0.6 * (v @ r) / length * r / length
    assert along(PAIRS["damper"].forces[0][1]) == pytest.approx(expected)


def test_a_damper_along_a_track_is_regular_where_its_points_meet():
    (_, force), _ = kn.linear_damper(O.at("X", q[1] * N.x), O, c).forces
    assert str(force) == "-c*q2' N.x"
    with pytest.raises(kn.ModelError, match="two points apart for a damper, got X and O at the same position"):
        kn.linear_damper(O.at("X", 0), O, c)
    with pytest.raises(kn.ModelError, match="two points apart for a spring, got X and O at the same position"):
        kn.linear_spring(O.at("X", 0), O, c, 0.2)


def test_torsional():
    axis = np.array([1, 2, 2]) / 3
    assert along(PAIRS["torsional spring"].torques[0][1]) == pytest.approx(-7 * (PATH.q[0] - 0.2) * axis)
    assert along(PAIRS["torsional damper"].torques[0][1]) == pytest.approx(-0.6 * PATH.v[0] * axis)
    assert PAIRS["torsional damper"].potential is None


@pytest.mark.parametrize("name", ["spring", "spring without length", "torsional spring"])
def test_slope_of_the_potential_is_the_generalized_force(name):
    """−∂V/∂q = Σ F·∂v/∂q̇ + T·∂ω/∂q̇, coordinate by coordinate."""
    load = PAIRS[name]
    for x in q:
        slope = numbers([kn.diff(load.potential, x)], STATE)[0]
        force = 0.0
        for point, f in load.forces:
            partial = [kn.diff(e, x.dt) for e in point.velocity(N).components(N)]
            force += numbers(partial, STATE) @ along(f)
        for frame, t in load.torques:
            partial = [kn.diff(e, x.dt) for e in frame.angular_velocity(N).components(N)]
            force += numbers(partial, STATE) @ along(t)
        assert force == pytest.approx(-slope, abs=1e-12)


@pytest.mark.parametrize("name", ["damper", "torsional damper"])
def test_dampers_take_energy_away(name):
    for seed in range(5):
        values = Path(q, seed).values()
        power = sum(along(f, values) @ along(p.velocity(N), values) for p, f in PAIRS[name].forces)
        power += sum(along(t, values) @ along(b.angular_velocity(N), values) for b, t in PAIRS[name].torques)
        assert power <= 1e-14


@pytest.mark.parametrize("stiffness", [k * (1 + kn.time), k * (1 + q[1] ** 2), kn.input("s")])
def test_a_stiffness_that_changes_has_no_potential(stiffness):
    assert kn.linear_spring(P, Q, stiffness).potential is None
    assert kn.linear_spring(P, Q, k, stiffness).potential is None
    assert kn.torsional_spring(A, N, q[0], stiffness, N.x).potential is None
    assert kn.torsional_spring(A, N, q[0], k, N.x, rest=stiffness).potential is None


def test_names():
    assert kn.Force(P, N.x).name == "force on P"
    assert kn.Torque(A, N.x, name="motor").name == "motor"
    assert repr(kn.Force(P, N.x)) == "Load('force on P')"
    assert kn.gravity(-9.81 * N.z).name == "gravity"


def test_gravity_along_a_frame_that_nothing_else_needs():
    """The parameters of its orientation are those of the system: a fall down a slope takes g times its sine along it."""
    slope, g_0 = kn.parameter("slope", 0.3, "rad"), kn.parameter("g_0", 9.81, "m/s^2")
    G = kn.Point("G", fixed_in=N).at("G_1", kn.coordinate("s", "m") * N.x)
    load = kn.gravity(-g_0 * N.rotate("I", -slope, N.z).y)
    system = kn.System(N, bodies=[kn.Particle("p", G, 2.0)], speeds="rates", loads=[load])
    sol = kn.simulate(kn.derive(system), (0, 1), q=[0], u=[0], parameters={"slope": 0.2})
    assert sol.u[-1, 0] == pytest.approx(-9.81 * np.sin(0.2), abs=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kn.Force(A, N.x), r"force on a Point, got Frame\('A'.*kn.Torque"),
        (lambda: kn.Force("P", N.x), "force on a Point, got 'P'. Make one with at"),
        (lambda: kn.Force(P, 3), "force as a Vector, got 3. Write it along axes"),
        (lambda: kn.Torque(P, N.x), r"torque on a Frame, got Point\('P'.*kn.Force"),
        (lambda: kn.Torque("A", N.x), "torque on a Frame, got 'A'. Name the frame of a rigid body"),
        (lambda: kn.Torque(A, k), "torque as a Vector, got k"),
        (lambda: kn.gravity(9.81), "got 9.81. Give it a direction, downwards: -g\\*N.z"),
        (lambda: kn.action_reaction(P, A, N.x), "force on a Point, got Frame"),
        (lambda: kn.torque_pair(A, P, N.x), "torque on a Frame, got Point"),
        (
            lambda: kn.linear_spring(P, P, k),
            "two of Point for the spring, got P twice. Name a different one for the other end",
        ),
        (lambda: kn.torsional_damper(A, A, c, N.z), "two of Frame for the axis of the torsional damper, got A twice"),
        (lambda: kn.linear_spring(A, P, k), r"two of Point for the spring, got Frame\('A'"),
        (lambda: kn.linear_damper(P, A, c), r"two of Point for the damper, got Frame\('A'"),
        (
            lambda: kn.torsional_spring(A, P, q[0], k, N.x),
            r"two of Frame for the axis of the torsional spring, got Point\('P'",
        ),
        (
            lambda: kn.torsional_damper(P, A, c, N.x),
            r"two of Frame for the axis of the torsional damper, got Point\('P'",
        ),
        (
            lambda: kn.torsional_spring(A, N, q[0], k, 2 * N.x),
            "axis of the torsional spring between A and N, got 2 N.x of length 2",
        ),
        (
            lambda: kn.torsional_damper(A, N, c, N.x + N.y),
            "axis of the torsional damper between A and N, got .* of length 1.41",
        ),
    ],
)
def test_errors(make, message):
    with pytest.raises(kn.ModelError, match=message):
        make()

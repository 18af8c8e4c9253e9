# SPDX-License-Identifier: BSD-3-Clause
"""Constraints as declarations: a multiplier's power is the constraint's rate; what is refused, and why."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.model import as_constraints

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
QS = q1, q2, q3, q4, q5, q6 = kn.coordinates("q1:7")
A = N.rotate_body("A", (q1, q2, q3), "zxz")
B = A.rotate("B", q4, A.y)
P = O.at("P", q5 * N.x + q6 * A.y)
Q = P.at("Q", 0.7 * B.x + 0.2 * B.y)
G = O.at("G", 0.4 * N.x - 0.3 * N.y)
STATE = dict(zip(QS, (0.4, 0.9, -0.6, 1.1, 0.3, -0.8), strict=True))
RATES = {q.dt: v for q, v in zip(QS, (1.3, -0.7, 0.5, 0.9, -1.1, 0.6), strict=True)}
HELD = [
    *kn.coincident(Q, G, along=(N.x, N.y, N.z), name="ground's"),
    *kn.coincident(Q, P, along=A.z, name="a moving frame's"),
    *kn.coincident(P, G, along=(B.x, B.y), name="the body's own"),
    kn.distance(Q, G, 1.3),
    kn.perpendicular(B.x, N.z),
    *kn.parallel(B.z, N.x, across=(N.y, N.z)),
]  # fmt: skip


def numbers(e):
    return kn.evaluate(e, {**STATE, **RATES})


@pytest.mark.parametrize("c", HELD, ids=lambda c: c.name)
def test_the_power_of_a_multiplier_of_one_is_the_rate_of_the_constraint(c):
    """Off the constraint, too: nothing here is closed."""
    power = sum(f.dot(p.velocity(N)) for p, f in c.forces) + sum(t.dot(w.angular_velocity(N)) for w, t in c.torques)
    assert abs(numbers(c.expr)) > 0.01
    assert numbers(power) == pytest.approx(numbers(kn.time_derivative(c.expr)), abs=1e-13)


@pytest.mark.parametrize("c", HELD, ids=lambda c: c.name)
def test_forces_are_in_balance(c):
    """Internal forces: no resultant and no moment."""
    force = sum((f for _, f in c.forces), kn.Vector())
    moment = sum((p.position(O).cross(f) for p, f in c.forces), kn.Vector()) + sum(
        (t for _, t in c.torques), kn.Vector()
    )
    if c.name.startswith("ground's"):  # what ground feels has no place
        moment = kn.Vector()
    for v in (force, moment):
        assert np.abs([numbers(x) for x in v.components(N)]).max() < 1e-13


def test_no_slip_is_a_difference_of_particles_velocities():
    one, two = Q.fixed_in(B, "Q^"), Q.fixed_in(A, "Q'")
    (c,) = kn.no_slip(one, two, along=B.y)
    power = sum(f.dot(p.velocity(N)) for p, f in c.forces)
    assert numbers(c.expr) == pytest.approx(numbers(power), abs=1e-14)
    assert (c.kind, c.unit, c.placed) == ("motion", "N", True)


def test_rolling_takes_two_directions_across_the_normal():
    particle = Q.fixed_in(B, "Q^")
    x, y = kn.rolling(particle, normal=N.z)
    assert (x.expr, y.expr) == (particle.velocity(N).dot(N.x), particle.velocity(N).dot(N.y))
    assert (x.name, y.name) == ("rolling of Q^ 1", "rolling of Q^ 2")
    tilted = (0.6 * N.z + 0.8 * N.x).normalized()
    one, two = kn.rolling(particle, normal=tilted, along=N.y)
    assert numbers(one.expr) == pytest.approx(numbers(y.expr))
    assert numbers(two.expr) == pytest.approx(numbers(particle.velocity(N).dot(tilted.cross(N.y))))
    down, level = kn.rolling(particle, normal=tilted)  # an axis of the frame is across it
    assert numbers(down.expr) == pytest.approx(numbers(particle.velocity(N).dot(tilted.cross(N.y))))
    assert numbers(level.expr) == pytest.approx(numbers(y.expr))


def test_names_and_units():
    assert [c.name for c in kn.coincident(P, Q, along=(N.x, N.y, N.z))] == ["P = Q x", "P = Q y", "P = Q z"]
    assert [c.name for c in kn.coincident(P, Q, along=(N.x, N.z))] == ["P = Q 1", "P = Q 2"]
    assert kn.distance(P, Q, 1).name == "|P Q|"
    assert kn.distance(
        P, Q, 0.8 + 0.1 * kn.time
    ).placed  # of time and numbers alone: its numbers have units that nobody said
    assert (kn.distance(P, Q, 1).unit, kn.perpendicular(A.x, N.z).unit) == ("N", "N*m")
    assert kn.reaction("T", constraint=kn.perpendicular(A.x, N.z)).unit == "N*m"
    assert repr(kn.configuration_constraint("height", q5)) == "Constraint('height': q5 = 0, configuration)"
    assert not kn.motion_constraint("m", q5.dt).placed


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kn.coincident(P, N.x, along=N.x), r"Expected points to keep together, got N.x"),
        (lambda: kn.distance(A, P, 1), "Expected points to keep at a distance, got"),
        (lambda: kn.distance(P, Q, kn.parameter("m", 1, "kg")), r"Expected a length .m. of P Q, got m .kg.. Correct it"),
        (lambda: kn.distance(P, Q, kn.parameter("b", 1, "m") ** 2), r"got b\^2 .m\^2."),
        (lambda: kn.no_slip(A, along=N.x), "Expected points to keep from slipping, got"),
        (lambda: kn.coincident(P, Q, along=2 * N.x), r"direction of 'P = Q', got 2 N.x of length 2. Use .normalized\(\)"),
        (lambda: kn.coincident(P, Q, along=kn.Vector()), "Expected a unit vector as the direction of 'P = Q', got"),
        (lambda: kn.coincident(P, Q, along=0.6 * N.x + 0.8 * A.z), "of length|fixed in the one frame"),
        (lambda: kn.coincident(P, Q, along=kn.cos(q1) * N.x + kn.sin(q1) * N.y), "fixed in the one frame that it is wr"),
        (lambda: kn.perpendicular(A.x, 3 * N.z), "Expected a unit vector as the direction of"),
        (lambda: kn.no_slip(P, along=3 * N.z), r"direction of 'no slip of P', got 3 N.z of length 3"),
        (lambda: kn.rolling(P, normal=2 * N.z), "unit vector as the normal of 'rolling of P'"),
        (lambda: kn.rolling(P, normal=(2 * N.x + N.y + 2 * N.z) / 3), "Expected along=unit vector in the plane across "),
    ],
)  # fmt: skip
def test_bad_places_and_directions(make, message):
    with pytest.raises(kn.ModelError, match=message):
        make()


def test_scalars_and_nested_lists():
    close = kn.coincident(P, G, along=(N.x, N.y))
    found = as_constraints([close, q5 - q6], "configuration")
    assert found[:2] == close
    assert (found[2].name, found[2].expr) == ("holonomic 3", q5 - q6)
    (alone,) = as_constraints(q5.dt, "motion")
    assert alone.name == "nonholonomic 1"


def test_wrong_kinds():
    with pytest.raises(
        kn.ModelError, match=r"Expected configuration constraints here, got 'm': list it in nonholonomic="
    ):
        as_constraints(kn.motion_constraint("m", q5.dt), "configuration")
    with pytest.raises(kn.ModelError, match=r"Expected motion constraints here, got '\|P G\|': list it in holonomic="):
        as_constraints(kn.distance(P, G, 1), "motion")
    with pytest.raises(
        kn.ModelError, match=r"a scalar that must vanish as a motion constraint, got the vector .*Use \.dot"
    ):
        as_constraints(P.velocity(N), "motion")


class TestSystem:
    """What a system checks of its constraints before anything is derived."""

    x, y = kn.coordinates("x y")
    at = O.at("at", x * N.x + y * N.y)

    def system(self, **more):
        return kn.System(N, bodies=[kn.Particle("p", self.at, 1)], **({"speeds": "rates"} | more))

    def test_names_differ(self):
        with pytest.raises(
            kn.ModelError, match=r"constraints of different names, got '\|at O\|' more than once. Say name="
        ):
            self.system(holonomic=[kn.distance(self.at, O, 1), kn.distance(self.at, O, 2)])

    def test_a_reaction_s_constraint_is_the_system_s(self):
        stray = kn.distance(self.at, O, 1, name="stray")
        rod = kn.distance(self.at, O, 1, name="rod")
        with pytest.raises(
            kn.ReactionError, match=r"the constraint of the reaction T among the system's \(rod\), got 'stray'"
        ):
            self.system(holonomic=rod, reactions=[kn.reaction("T", constraint=stray)])

    def test_a_reaction_takes_one_constraint_and_no_other_place(self):
        rod = kn.distance(self.at, O, 1)
        with pytest.raises(
            kn.ReactionError,
            match="Expected constraint=one Constraint, and neither at= nor frame=, for the reaction 'T'",
        ):
            kn.reaction("T", at=self.at, along=N.x, constraint=rod)
        with pytest.raises(kn.ReactionError, match="Expected constraint=one Constraint"):
            kn.reaction("T", constraint=kn.coincident(self.at, G, along=(N.x, N.y)))

    def test_dependent_ones_are_the_system_s_and_no_more_than_constraints(self):
        rod = kn.distance(self.at, O, 1)
        with pytest.raises(
            kn.ModelError, match="Expected dependent_speeds= to list speeds of the system, each once, got w"
        ):
            self.system(holonomic=rod, dependent_speeds=[kn.speed("w")])
        with pytest.raises(kn.ModelError, match="Expected dependent_coordinates= to list coordinates of the system"):
            self.system(holonomic=rod, dependent_coordinates=[self.x, self.x])
        with pytest.raises(
            kn.ModelError, match="Expected at most 1 dependent coordinates, one a constraint, got 2 in dependent_c"
        ):
            self.system(holonomic=rod, dependent_coordinates=[self.x, self.y])

    def test_a_point_of_another_system(self):
        other = kn.Point("far", fixed_in=kn.Frame("M"))
        with pytest.raises(kn.SpaceError, match="points of one tree, got at and far, which have no common root"):
            kn.distance(self.at, other, 1)

    def test_a_coordinate_of_another_system(self):
        stray = kn.coordinate("stray")
        with pytest.raises(kn.ModelError, match="symbols of the system, got stray"):
            self.system(
                holonomic=kn.configuration_constraint("c", self.x - stray),
                speeds=dict(zip(kn.speeds("u v"), (self.x.dt, self.y.dt), strict=True)),
            )

    def test_kinds_and_names_are_read_off(self):
        rod, edge = kn.distance(self.at, O, 1), kn.motion_constraint("edge", self.x.dt)
        system = self.system(holonomic=rod, nonholonomic=edge)
        assert (system.holonomic, system.nonholonomic) == ((rod,), (edge,))
        assert system["edge"] is edge
        assert system.replace(nonholonomic=()).constraints == (rod,)


def test_a_point_that_wanders_in_its_body_is_refused() -> None:
    """The lowest point of a leaning wheel is another particle at each instant."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    lean, x = kn.coordinates("lean x")
    B = N.rotate("B", lean, N.x)
    hub = O.at("hub", x * N.y)
    lowest = hub.at("low", -kn.cos(lean) * B.z - kn.sin(lean) * B.y)
    with pytest.raises(
        kn.ModelError,
        match=r"got low, which moves in B as lean turns it.*hub.fixed_in\(B",
    ):
        kn.coincident(lowest, O, N.z)
    slider = hub.at("slider", x * B.y)  # x does not turn B
    assert kn.coincident(slider, O, N.z)[0].kind == "configuration"


def test_scalars_in_lists_of_lists_have_names_of_their_own():
    """Closures of a function of one's own, each a list of scalars, go into one list."""
    rows = as_constraints([[q5 - 1], [q6 - 2, [q4]]], "configuration")
    assert [c.name for c in rows] == ["holonomic 1", "holonomic 2", "holonomic 3"]
    assert all(c.expr is e for c, e in zip(rows, (q5 - 1, q6 - 2, q4), strict=True))


@pytest.mark.parametrize("length", [0, -1.3, kn.parameter("L", -0.5)])
def test_a_rod_has_a_length_above_zero(length):
    with pytest.raises(kn.ModelError, match="a length of Q G above zero, got "):
        kn.distance(Q, G, length)


@pytest.mark.parametrize(
    ("across", "message"),
    [
        ((N.x, N.y), "perpendicular to N.x, got N.x"),
        ((N.y, -N.y), "not along each other"),
        ((N.y, 2 * N.z), "unit vector as the direction across"),
    ],
)
def test_what_is_no_direction_across(across, message):
    with pytest.raises(kn.ModelError, match=message):
        kn.parallel(B.z, N.x, across=across)


class TestRepr:
    q, a = kn.coordinate("q"), kn.parameter("a")

    def test_a_short_one_is_an_equation(self):
        c = kn.configuration_constraint("short", self.q - self.a)
        assert repr(c) == "Constraint('short': q - a = 0, configuration)"

    @pytest.mark.slow
    @pytest.mark.parametrize("depth", [8, 4000])
    def test_a_long_one_is_cut_and_is_none(self, depth):
        f = self.q
        for _ in range(depth):
            f = (f * self.a + self.q).sin() + f
        text = repr(kn.motion_constraint("long", f))
        assert text.endswith(" …, motion)")
        assert "=" not in text
        assert len(text) < 100

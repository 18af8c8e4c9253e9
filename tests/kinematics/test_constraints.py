# SPDX-License-Identifier: BSD-3-Clause
"""A u + b = 0 and Ȧ u + ḃ: by places and as bare scalars, with speeds of any kind, moving walls, wandering contacts."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import car_with_trailer

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
QS = q1, q2, q3, q4, q5 = kn.coordinates("q1:6")
t = kn.time
Y = N.rotate("Y", q1, N.z)
L = Y.rotate("L", q2, Y.x)
C = L.rotate("C", q3, L.y)
P = O.at("P", q4 * N.x + q5 * N.y)
CENTER = P.at("C*", 0.3 * L.z)
RIM = CENTER.at("rim", 0.2 * C.x + 0.1 * C.y)
WALL = O.at("wall", kn.sin(t) * N.x + 0.1 * t**2 * N.z)
TURNTABLE = N.rotate("turntable", 0.7 * t + 0.2 * kn.cos(t), N.z)
BODY = kn.RigidBody("disk", frame=C, mass_center=CENTER, mass=1.2, inertia=kn.inertia(C, 0.1, 0.2, 0.15))
RATES = dict(zip(QS, (1.3, -0.7, 0.5, 0.9, -1.1), strict=True))
POINT = {"q": dict(zip(QS, (0.4, 0.9, -0.6, 0.3, -0.8), strict=True)), "t": 0.6}
OMEGA = C.angular_velocity(N)
SPEEDS = {
    "rates": "rates",
    "others": dict(
        zip(
            kn.speeds("u1:6"),
            (
                OMEGA.dot(L.x),
                OMEGA.dot(L.y),
                OMEGA.dot(L.z),
                CENTER.velocity(N).dot(Y.x),
                q5.dt + 2 * q4.dt + kn.sin(t),
            ),
            strict=True,
        )
    ),
}
CONFIGURATION = [
    *kn.coincident(RIM, WALL, along=(N.x, N.z), name="wall"),
    *kn.coincident(RIM, WALL, along=TURNTABLE.y, name="turntable"),
    *kn.coincident(RIM, P, along=C.z, name="own"),
    kn.distance(RIM, WALL, 0.8 + 0.1 * t),
    kn.perpendicular(C.x, TURNTABLE.x),
]
WANDERING = CENTER.fixed_in(C, "C^", -0.3 * N.z)
MOTION = [
    *kn.rolling(
        WANDERING, O.at("floor", P.position(O)).fixed_in(TURNTABLE, "F^"), normal=N.z, name="turntable's floor"
    ),
    *kn.no_slip(WANDERING, along=L.y, name="blade"),
    *kn.no_slip(RIM.fixed_in(C, "R^"), along=C.x, name="rim"),
]


def equations(speeds, **constraints):
    """Nothing is said of redundancy or of rank: one constraint at a time."""
    return kn.derive(kn.System(N, bodies=[BODY], speeds=SPEEDS[speeds], **constraints))


def evaluated(eom, exprs):
    """Numbers off the constraints, where `Equations.evaluate` gives none."""
    u = eom.speeds_from_rates(POINT["q"], RATES, t=POINT["t"])
    return np.array(function(eom, exprs, list(POINT["q"].values()), list(u.values()), POINT["t"]), dtype=float)


def function(eom, exprs, q, u, t):
    """Expressions as functions of q, u and t, with the accelerations of the equations."""
    values = dict(zip([*eom.coordinates, *eom.speeds, kn.time], [*q, *u, t], strict=True))
    values |= dict(zip([s.dt for s in eom.speeds], kn.evaluate(list(eom.accelerations), values), strict=True))
    return kn.evaluate([eom.in_speeds(e) for e in exprs], values)


@pytest.mark.slow
@pytest.mark.parametrize("speeds", SPEEDS)
@pytest.mark.parametrize("c", CONFIGURATION + MOTION, ids=lambda c: c.name)
def test_rows_from_partial_velocities_are_those_of_the_scalar(speeds, c):
    """Off the constraint; and Ȧ u + ḃ is the rate of A u + b without what u̇ gives."""
    kind = "holonomic" if c.kind == "configuration" else "nonholonomic"
    make = kn.configuration_constraint if c.kind == "configuration" else kn.motion_constraint
    placed, bare = equations(speeds, **{kind: c}), equations(speeds, **{kind: make("bare", c.expr)})
    for part in (lambda e: [*e.A.rows[0], *e.b], lambda e: e.constraints.drift):
        assert evaluated(placed, part(placed)) == pytest.approx(evaluated(bare, part(bare)), abs=1e-12)
    row = sum((a * u for a, u in zip(placed.A.rows[0], placed.speeds, strict=True)), placed.b[0])
    whole = c.expr if c.kind == "motion" else kn.time_derivative(c.expr)
    left, right = evaluated(placed, [row, whole])
    assert left == pytest.approx(right, abs=1e-13)
    rate, given = evaluated(placed, [placed.time_derivative(row), placed.constraints.drift[0]])
    u_dot, a = evaluated(placed, placed.accelerations), evaluated(placed, placed.A.rows[0])
    assert rate == pytest.approx(given + a @ u_dot, abs=1e-11)


def test_the_drift_is_the_rate_along_a_motion():
    """By differences: along a motion with given q̈ the value of A u + b changes at A u̇ + Ȧ u + ḃ."""
    eom = equations("rates", nonholonomic=MOTION[2])
    acceleration = np.array([0.3, -0.4, 0.8, 0.1, -0.9])
    q, u = np.array(list(POINT["q"].values())), np.array(list(RATES.values()))

    def value(h):
        state = {"q": q + h * u + h * h / 2 * acceleration, "u": u + h * acceleration, "t": POINT["t"] + h}
        *row, rest = function(eom, [*eom.A.entries, eom.b[0]], **state)
        return np.array(row) @ state["u"] + float(rest)

    h = 1e-4
    slope = (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h)
    *a, drift = function(eom, [*eom.A.entries, eom.constraints.drift[0]], q, u, POINT["t"])
    assert slope == pytest.approx(float(np.array(a) @ acceleration + drift), abs=1e-9)


@pytest.mark.parametrize(
    ("constraints", "message"),
    [
        (
            {"nonholonomic": kn.motion_constraint("square", q4.dt**2 - 1)},
            r"Expected the motion constraint 'square' affine in the speeds, A u \+ b = 0, got .*Choose coordinates in which",
        ),
        (
            {"holonomic": kn.configuration_constraint("late", q4.dt + q5)},
            r"Expected the configuration constraint 'late' in coordinates and time, got q4' in it. List it in nonholonomic=",
        ),
        (
            {"nonholonomic": kn.motion_constraint("still", q4 - q5)},
            r"Expected the constraint 'still' to restrict the motion, got",
        ),
        (
            {"holonomic": kn.configuration_constraint("clock", t - 1)},
            r"'clock' to restrict the motion, got t - 1|got -1 \+ t",
        ),
        (
            {"holonomic": kn.distance(WALL, O, 1)},
            r"'\|wall O\|' to restrict the motion, got .*, whose rate contains no speed",
        ),
    ],
    ids=["not affine", "rates in a configuration constraint", "no rate", "time alone", "nothing that moves"],
)
def test_what_is_refused(constraints, message):
    with pytest.raises(kn.ModelError, match=message):
        equations("rates", **constraints)


def test_a_plane_s_direction_held_in_space_is_redundant_not_wrong():
    """The trace P is in the ground's plane: held across it, nothing is held; a little off, nothing can be."""
    with pytest.warns(kn.KaneWarning, match=r"The constraint 'P = O 1' is always satisfied: it is redundant"):
        equations("rates", holonomic=[kn.coincident(P, O, along=(N.z, N.x))])
    with pytest.raises(kn.ModelError, match=r"to restrict the motion, got -0\.1, whose rate contains no speed"):
        equations("rates", holonomic=kn.coincident(P, O.at("above", 0.1 * N.z), along=N.z))


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
def test_a_particle_whose_place_changes_is_held_by_its_contact_alone(size):
    """At s b1 from the mass centre, s a coordinate: (r·n)˙ holds ṡ, the particle's velocity does not, however small they are."""
    turn, x, y, s = kn.coordinates("turn x y s")
    B = N.rotate("B", turn, N.z)
    center, size = O.at("center", x * N.x + y * N.y), kn.parameter("size", size)
    wandering = center.fixed_in(B, "wandering", size * s * B.x)
    slider = kn.Particle("slider", center.at("slider", size * s * B.x), 1)
    body = kn.RigidBody("b", frame=B, mass_center=center, mass=1, inertia=kn.inertia(B, 1, 1, 1))

    def derive(held):
        return kn.derive(kn.System(N, bodies=[body, slider], speeds="rates", holonomic=held))

    for held in (kn.coincident(wandering, O, N.x), kn.distance(wandering, O, 1.0)):
        with pytest.raises(
            kn.ModelError, match=r"got .* for the rate and .* from the velocities.*position of wandering in its body"
        ):
            derive(held)
    eom = derive(kn.coincident(slider.mass_center, O, N.x))
    a = np.ravel(eom.evaluate(eom.A, q={turn: 0.4, x: 0.0, y: 0.0, s: 0.7}))
    rates = {turn: -0.7 * np.sin(0.4) * size.default, x: 1.0, y: 0.0, s: np.cos(0.4) * size.default}
    np.testing.assert_allclose(a, [rates[q] for q in eom.coordinates], rtol=1e-14)


def test_short_rows_are_differentiated_as_they_stand():
    """A steered blade's: from velocities it holds ω²l and v ω twice, which cancel."""
    slope = str(kn.derive(car_with_trailer.system()).constraints.drift[1])
    assert slope == "-delta'*(u_v*cos(delta) + (l*w + u_s)*sin(delta))"

# SPDX-License-Identifier: BSD-3-Clause
"""Units of a system: every declaration is checked where all symbols carry units, and says so where it is wrong."""

from __future__ import annotations

import re

import pytest

import kane as kn
from kane.gallery import GALLERY, load
from kane.gallery.pendulums import system as chain
from tests.gallery.cases import CASES

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, q = kn.coordinate("x", "m"), kn.coordinate("q", "rad")
m, l, I = kn.parameter("m", 1.0, "kg"), kn.parameter("l", 1.0, "m"), kn.parameter("I", 1.0, "kg*m^2")
k, g, w = kn.parameter("k", 1.0, "N/m"), kn.parameter("g", 9.81, "m/s^2"), kn.parameter("w", 2.0, "rad/s")
F, T = kn.input("F", "N"), kn.input("T", "N*m")
free = kn.parameter("free", 1.0)
u1, u2 = kn.speeds("u1:3")
B = N.rotate("B", q, N.z)
P = O.at("P", x * N.x)


def make(point=P, frame=B, mass=m, inertia=None, **options):
    """A body on a slide that turns, all of whose symbols carry units."""
    dyadic = kn.inertia(frame, I, I, I) if inertia is None else inertia
    body = kn.RigidBody("body", frame=frame, mass_center=point, mass=mass, inertia=dyadic)
    options = {"speeds": "rates", "loads": [kn.gravity(-g * N.y), kn.linear_spring(point, O, k, l)]} | options
    return kn.System(N, bodies=[body], **options)


def particle(length, mass, *loads):
    """A particle on a line, in any units."""
    s = kn.coordinate("s", length)
    S = O.at("S", s * N.x)
    own = [kn.Force(S, kn.parameter(f"F{i}", 1.0, unit) * N.x) for i, unit in enumerate(loads)]
    return kn.System(N, bodies=[kn.Particle("p", S, kn.parameter("m", 1.0, mass))], speeds="rates", loads=own)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"point": O.at("P", q * N.x)}, "a length (m) as the position of P from O, got rad: q, with q [rad]. Correct the expression"),
        ({"point": O.at("P", (x + kn.time) * N.x)}, "Expected terms of one unit in x + t, got"),
        ({"point": O.at("P", (x + kn.time) * N.x)}, "This is in the position of P from O."),
        ({"point": O.at("P", 0.6 * kn.cos(q) * N.x)}, "a symbol in it; where 0.6 is a quantity, give it its unit: kn.parameter("),
        ({"frame": N.rotate("B", x, N.z)}, "an angle (rad) or a ratio as the orientation of B, got m: x, with x [m]"),
        ({"mass": l}, "a mass (kg) as the mass of body, got m: l"),
        ({"inertia": kn.inertia(B, m, I, I)}, "a moment of inertia (kg*m^2) as the inertia of body, got kg: m"),
        ({"inertia": kn.thin_disk(B, m, g, axis=B.z)}, "as the inertia of body, got kg*m^2/s^4"),
        ({"loads": [kn.gravity(-l * N.y)]}, "an acceleration (m/s^2) as the acceleration of 'gravity', got m: -l"),
        ({"loads": [kn.Force(P, T * N.x, name="push")]}, "a force (N) as the force of 'push' on P, got N*m: T"),
        ({"loads": [kn.Torque(B, F * N.z, name="turn")]}, "a torque (N*m) or energy (J) as the torque of 'turn' on B, got N: F"),
        ({"loads": [kn.linear_spring(P, O, g)]}, "a force (N) as the force of 'spring between P and O' on P, got m^2/s^2"),
        ({"loads": [kn.Load("own", potential=k * x)]}, "as the potential energy of 'own', got N: k*x"),
        ({"loads": [kn.linear_spring(P, O, k, w)]}, "Expected terms of one unit in"),
        ({"loads": [kn.Force(P, k * (x - 1.5) * N.x)]}, 'Give the number a unit: kn.parameter(name, value, "unit").'),
        ({"loads": [kn.Force(P, F * kn.sin(x) * N.x)]}, "Expected an angle (rad) or a ratio in sin(…), got x [m]"),
        (
            {"speeds": {kn.speed("v", "rad/s"): x.dt, u2: q.dt}},
            "Expected 1/s as the definition of v [rad/s], got m/s: x', with x' [m/s]",
        ),
        ({"speeds": {u1: x.dt + q.dt, u2: q.dt}}, "This is in the definition of u1."),
        ({"events": [kn.Event("stop", x - q)]}, "This is in the quantity of the event 'stop'."),
        (
            {"reactions": [kn.reaction("R", at=P, along=N.y, unit="N*m")]},
            "the unit of a force, such as N, at a point for the reaction R, got N*m. Correct unit=, or leave it out.",
        ),
        ({"reactions": [kn.reaction("R", frame=B, along=N.x, unit="N")]}, "the unit of a torque, such as N*m, on a frame"),
        ({"mass": kn.parameter("m", 1.0, "kgg")}, "got 'kgg'. Did you mean 'kg'?"),
        ({"mass": kn.parameter("m", 1.0, "kgg")}, "This is the unit of m."),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_named(changes, message):
    with pytest.raises(kn.UnitError, match=re.escape(message)):
        make(**changes)


def test_functions_of_time_beside_an_angle() -> None:
    """A number of a function of time has no unit; a parameter in its place, as the message has it, brings one."""
    angle = kn.coordinate("angle", "rad")
    with pytest.raises(kn.UnitError, match=r'Numbers in t\^2/2 have no unit,.* kn\.parameter\("c", 0\.5, "rad/s\^2"\)'):
        make(frame=N.rotate("B", angle + kn.time**2 / 2, N.z), point=O.at("P", x * N.x))
    c = kn.parameter("c", 0.5, "rad/s^2")
    make(
        frame=N.rotate("B", angle + c * kn.time**2, N.z),
        point=O.at("P", x * N.x),
        speeds={u1: x.dt, kn.speed("w", "rad/s"): angle.dt},
    )


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"mass": 2},
        {"mass": free},
        {"inertia": kn.inertia(B, 1, 2, I)},
        {"inertia": kn.parallel_axis(kn.inertia(B, I, I, I), m, l * B.x)},
        {"point": O.at("P", x * N.x + 3 * N.y), "loads": []},
        {"point": O.at("P", (x + free * kn.time) * N.x)},
        {"frame": N.rotate("B", q + kn.pi / 2, N.z)},
        {"frame": N.rotate("B", q + free, N.z)},
        {"frame": B.rotate("C", kn.sin(kn.time), B.x)},
        {"loads": [kn.Force(P, 9.81 * kn.time * N.x)]},
        {"loads": [kn.Force(P, F * kn.where(kn.less(x, 0), 1, 0) * N.x)]},
        {"loads": [kn.Force(P, k * kn.max(x, 0) * N.x), kn.Force(P, -u1 * x * N.x)], "speeds": {u1: x.dt, u2: q.dt}},
        {"loads": [kn.linear_spring(P, O, k, 0)]},
        {"loads": [kn.torsional_damper(B, N, kn.parameter("c", 1, "N*m*s/rad"), N.z)]},
        {"speeds": {kn.speed("v", "m/s"): x.dt - w * x, u2: q.dt * (2 + kn.cos(q))}},
        {"speeds": {kn.speed("p", "N*s"): m * x.dt, kn.speed("L", "J*s"): I * q.dt}},
        {"events": [kn.Event("stop", x - l)]},
        {"reactions": [kn.reaction("R", frame=B, along=N.x, unit="J/rad")]},
    ],
)
def test_what_fits_or_is_unknown_passes(changes):
    make(**changes)


@pytest.mark.parametrize("units", [
    ("m", "kg", "N"), ("mm", "t", "N"), ("mm", "kg", "mN"), ("ft", "lb"), ("mm", "g", "g*mm/s^2"), ("km", "t", "MN"), ("mm", "kg"),
])  # fmt: skip
def test_units_that_go_together(units):
    particle(*units)


@pytest.mark.parametrize(
    ("units", "message"),
    [
        (("m", "kg", "kN"), "got kN (F0), kg (m), m (s), s (the time): a factor 1000 is left over"),
        (("mm", "g", "N"), "N (F0)"),
        (("ft", "lb", "lbf"), "lbf (F0)"),
        (("mm", "t", "kg*m/s^2", "kN"), "kN (F1)"),
    ],
)
def test_units_that_leave_a_factor(units, message):
    with pytest.raises(kn.UnitError, match="Expected units that go together without factors") as caught:
        particle(*units)
    assert message in str(caught.value)


def test_millimetres_beside_metres():
    with pytest.raises(
        kn.UnitError, match=r"got mm \(a\), m \(x\): a factor 0\.001 is left over\. Give all in one choice"
    ):
        make(loads=[kn.linear_spring(P, O, k, kn.parameter("a", 150.0, "mm"))])


def test_degrees_and_revolutions():
    angle = kn.coordinate("angle", "deg")
    with pytest.raises(
        kn.UnitError, match=r"angles in rad and ratios in 1, got deg \(angle\): .* 1 deg = 0\.0174533\."
    ):
        make(frame=N.rotate("B", angle, N.z))
    with pytest.raises(kn.UnitError, match=r"got rpm \(n\), s \(the time\): a factor 0\.10472 is left over"):
        make(loads=[kn.Force(P, m * l * kn.parameter("n", 1.0, "rpm") * w * N.x)])


def test_a_system_without_units_is_not_checked():
    s, a = kn.coordinate("s"), kn.parameter("a")
    S = O.at("S", s * N.x)
    up = kn.reaction("R", at=S, along=N.y)
    loads = [kn.Force(S, (s + a * kn.time + kn.sin(s) - up) * N.x)]
    kn.System(N, bodies=[kn.Particle("p", S, a)], speeds="rates", loads=loads, reactions=[up])


@pytest.mark.parametrize("case", CASES, ids=str)
def test_every_choice_of_speeds_in_the_gallery_fits(case):
    for choice in case.speeds:
        case.build(choice)


class TestReading:
    @pytest.mark.slow
    @pytest.mark.parametrize("name", GALLERY)
    def test_units_of_what_is_derived(self, name):
        """Energies in J, their rates in W, and each speed's rate in its unit per second."""
        eom = kn.derive(load(name).system())
        assert eom.unit(eom.kinetic_energy) == "J"
        assert eom.unit(eom.energy) == "J"
        assert eom.unit(eom.time_derivative(eom.energy)) in ("W", "")  # "" for 0
        for u in eom.speeds:
            assert eom.unit(u) in ("m/s", "rad/s")
            assert eom.unit(u.dt) == eom.unit(u) + "^2"
        for r in eom.reaction_values:
            assert eom.unit(r) == "N"

    def test_a_speed_has_its_own_unit_or_its_definition_s(self):
        eom = kn.derive(chain(2, speeds="tips"))
        assert [eom.unit(u) for u in eom.speeds] == ["m/s", "m/s"]
        assert kn.unit_of(eom.speeds[0]) == ""
        assert kn.derive(make(speeds={kn.speed("p", "N*s"): m * x.dt, u2: q.dt})).unit(kn.speed("p", "N*s")) == "N*s"

    def test_sums_of_different_units_are_refused(self):
        eom = kn.derive(make())
        with pytest.raises(kn.UnitError, match="Expected terms of one unit"):
            eom.unit(x + l * q.dt)

    @pytest.mark.parametrize(
        "changes", [{"mass": 2}, {"mass": free}, {"point": O.at("P", x * N.x + 2 * N.y), "loads": []}]
    )
    def test_where_a_unit_is_missing_only_symbols_have_units(self, changes):
        """T = m v²/2 would be in m²/s² with the mass 2."""
        eom = kn.derive(make(**changes))
        assert eom.unit(eom.energy) == ""
        assert eom.unit(x) == "m"
        assert eom.unit(eom.speeds[0]) == "m/s"

    def test_a_speed_without_a_unit_is_not_checked(self):
        eom = kn.derive(make(speeds={u1: x.dt, u2: q.dt}, loads=[kn.Force(P, -u1 * N.x)]))
        assert eom.unit(eom.power) == "m^2/s^2"
        assert eom.unit(u1 + x) == ""

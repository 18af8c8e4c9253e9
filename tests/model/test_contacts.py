# SPDX-License-Identifier: BSD-3-Clause
"""Contacts that cannot be: each is refused by name, with what to do."""

import re

import pytest

import kane as kn


def ground():
    N = kn.Frame("N")
    return N, kn.Point("O", fixed_in=N)


def particle(mu=0.3, where=None, **laws):
    """A particle over a floor, or at `where`."""
    N, O = ground()
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + (y if where is None else where) * N.y)
    place = kn.joints.point_on_plane("floor", P, O, normal=N.y)
    return N, P, kn.contact(place, mu, **laws)


def system(N, P, *contacts):
    loads = [kn.gravity(-9.81 * N.y)]
    return kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", loads=loads, contacts=contacts)


COEFFICIENTS = [
    ({"mu": -0.1}, "mu = μ_k ≥ 0 of the contact 'floor'", "-0.1", "Give 0 for a frictionless contact"),
    (
        {"mu": 0.0, "static": -0.1},
        "static = μ_s ≥ 0 of the contact 'floor'",
        "-0.1",
        "Give 0 for a frictionless contact",
    ),
    ({"mu": 0.4, "static": 0.3}, "μ_k ≤ μ_s of the contact 'floor'", "μ_k = 0.4 and μ_s = 0.3", "Swap them"),
    (
        {"restitution": 1.1},
        "a restitution from 0 to 1 of the contact 'floor'",
        "1.1",
        "Give 0 for an impact without rebound",
    ),
    (
        {"restitution": -0.1},
        "a restitution from 0 to 1 of the contact 'floor'",
        "-0.1",
        "Give 0 for an impact without rebound",
    ),
    ({"law": "hertz"}, "law= of 'floor' to be one of stronge, poisson, newton, moreau", "'hertz'", ""),
]


@pytest.mark.parametrize(("given", "expected", "came", "cure"), COEFFICIENTS)
def test_coefficients_that_are_none(given, expected, came, cure):
    with pytest.raises(
        kn.ModelError, match=f"Expected .*{re.escape(expected)}, got .*{re.escape(came)}.*{re.escape(cure)}"
    ):
        particle(**given)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
@pytest.mark.parametrize("what", ["mu", "static", "restitution"])
def test_coefficients_are_finite(what, value):
    with pytest.raises(
        kn.ExpressionError, match=r"Expected .*of the contact 'floor', got (nan|inf)\. Give a finite number"
    ):
        particle(**{what: value})


@pytest.mark.parametrize("what", ["mu", "static", "restitution"])
def test_coefficients_are_checked_at_defaults_of_parameters(what):
    with pytest.raises(kn.ModelError, match="of the contact 'floor', got -1"):
        particle(**{what: kn.parameter("c", -1.0, "1")})


@pytest.mark.parametrize("what", ["mu", "static", "restitution"])
def test_coefficients_are_numbers_or_expressions(what):
    with pytest.raises(
        kn.ExpressionError, match=r"Expected .*of the contact 'floor', got 'rough'\. Give a finite number"
    ):
        particle(**{what: "rough"})


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"mu": -0.1}, "mu = μ_k ≥ 0"),
        ({"mu": 0.6}, "μ_k ≤ μ_s"),
        ({"e": 1.5}, "a restitution from 0 to 1"),
        ({"e": -0.5}, "a restitution from 0 to 1"),
    ],
)
def test_coefficients_given_to_a_motion(values, expected):
    mu, mus, e = kn.parameter("mu", 0.3, "1"), kn.parameter("mus", 0.4, "1"), kn.parameter("e", 0.5, "1")
    eom = kn.derive(system(*particle(mu, static=mus, restitution=e)))
    with pytest.raises(kn.KaneError, match=f"Expected {expected} of the contact 'floor', got"):
        kn.simulate(eom, (0, 1), q=[0, 1], u=[0, 0], parameters=values)


def test_a_contact_that_slips_does_not_stick():
    sticks = kn.derive(system(*particle()).in_modes({"floor": "stick"}))
    with pytest.raises(
        kn.SimulationError,
        match=r"miss floor 1 by 2\. A contact that sticks has no slip: choose a mode in which it slips",
    ):
        kn.simulate(sticks, (0, 1), q=[0, 0], u=[2, 0])


def test_impacts_follow_one_law():
    """Without restitution all laws say the same."""
    N, O = ground()
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)

    def floor_and_wall(first, e, second):
        floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), restitution=e, law=first)
        return system(N, P, floor, kn.joints.stop("wall", 1 - x, restitution=0.5, law=second))

    assert len(floor_and_wall("poisson", 0.3, "poisson").contacts) == 2
    assert len(floor_and_wall("newton", 0, "poisson").contacts) == 2
    assert len(floor_and_wall("stronge", 0, "moreau").contacts) == 2
    with pytest.raises(kn.ModelError, match=r"one law of restitution.*law='moreau' of 'floor'"):
        floor_and_wall("moreau", 0, "stronge")
    with pytest.raises(
        kn.ModelError, match=r"one law of restitution.*law='newton' of 'floor' and law='poisson' of 'wall'"
    ):
        floor_and_wall("newton", 0.3, "poisson")


def test_nothing_presses():
    """Where coordinates keep the contact closed the normal force is a reaction to be given."""
    with pytest.raises(
        kn.ModelError,
        match=r"Expected a gap of the contact 'floor' that depends on coordinates, got 0:.*normal=kn.reaction",
    ):
        particle(where=0)


def test_bodies_that_never_touch():
    with pytest.raises(
        kn.ModelError, match=r"that depends on coordinates, got 1: these bodies never touch. Leave the contact out"
    ):
        particle(where=1)


@pytest.mark.parametrize("gap", [1.0, kn.parameter("d", 0.2, "m"), kn.sin(kn.time)])
def test_a_gap_that_no_coordinate_changes(gap):
    with pytest.raises(
        kn.ModelError,
        match=r"Expected a gap of 'end' that depends on coordinates, got .* Give an expression that must stay",
    ):
        kn.joints.stop("end", gap)


def test_a_contact_over_a_floor_that_moves_alone():
    """The floor comes up by time to a point that no coordinate moves."""
    N, O = ground()
    floor = O.at("F", -kn.parameter("A", 0.1, "m") * kn.cos(kn.parameter("w", 1.0, "rad/s") * kn.time) * N.y)
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    with pytest.raises(kn.ModelError, match="Expected a gap of the contact 'floor' that depends on coordinates"):
        kn.contact(kn.joints.point_on_plane("floor", P, floor, normal=N.y), 0.3)


def test_a_rope_between_fixed_points():
    N, O = ground()
    with pytest.raises(kn.ModelError, match="Expected a gap of 'rope' that depends on coordinates"):
        kn.joints.rope("rope", [O, O.at("Q", N.x)], 1.0)
    with pytest.raises(kn.ModelError, match="Expected two points or more of the rope 'rope', got 1"):
        kn.joints.rope("rope", [O], 1.0)


def test_two_contacts_with_one_gap():
    N, P, floor = particle()
    stop = kn.joints.stop("stop", floor.gap.expr)
    with pytest.raises(
        kn.ModelError,
        match=r"Expected contacts at different points, got 'floor' and 'stop' with the same gap. Leave one out",
    ):
        system(N, P, floor, stop)


def test_two_contacts_with_one_gap_by_another_expression():
    """2 y closes where y does: rigid bodies do not tell how they share what presses."""
    N, P, floor = particle()
    y = floor.gap.expr
    eom = kn.derive(system(N, P, floor, kn.joints.stop("stop", 2 * y)))
    with pytest.raises(
        kn.SimulationError, match="Expected contacts with uniquely determined forces between rigid bodies, got 'stop'"
    ):
        kn.simulate(eom, (0, 1), q=[0, 0], u=[0, 0])


def test_two_contacts_with_one_name():
    N, P, floor = particle()
    stop = kn.joints.stop("floor", 1 - floor.gap.expr)
    with pytest.raises(kn.ModelError, match="'floor'"):
        system(N, P, floor, stop)


def test_a_contact_listed_where_none_is_expected():
    N, P, floor = particle()
    with pytest.raises(kn.ModelError, match=r"made by kn.contact\(place, mu\)"):
        system(N, P, kn.joints.point_on_plane("place", P, P.root(), normal=N.y))
    with pytest.raises(
        kn.ModelError, match=r"Expected the geometry of a contact, got .* has a law already in contacts="
    ):
        kn.contact(floor, 0.3)
    with pytest.raises(kn.ModelError, match=r"Expected the geometry of a contact, got .* Make one with kn.joints"):
        kn.contact(P, 0.3)


@pytest.mark.parametrize("gap", [-1e-6, -0.1])
def test_a_start_in_penetration(gap):
    """One body within the other is refused, however little, and moving out of it."""
    eom = kn.derive(system(*particle()))
    for v in (0, 1):
        with pytest.raises(
            kn.SimulationError,
            match=r"Expected a gap of the contact 'floor' at or above zero at the start, got -.*Move one of them",
        ):
            kn.simulate(eom, (0, 1), q=[0, gap], u=[0, v])


def test_modes_of_all_contacts_by_their_names():
    one = system(*particle())
    named, numbered = one.in_modes(["stick"]), one.in_modes({"floor": "stick"})
    assert named.modes == numbered.modes
    assert [c.name for c in named.constraints] == [c.name for c in numbered.constraints] == ["floor normal", "floor 1"]
    for wrong in (["stuck"], [77], {"floor": ["stick"]}):
        with pytest.raises(kn.ModelError, match="a mode of the contact 'floor' among separated, stick"):
            one.in_modes(wrong)
    with pytest.raises(kn.ModelError, match="modes of all 1 contacts, got None"):
        one.in_modes(None)


def test_the_modes_of_a_motion_are_those_of_a_system():
    """A hopper without friction stands; at rest its spring carries the upper mass."""
    N, O = ground()
    (y, s), k = kn.coordinates("y s"), 2000.0
    body = O.at("body", y * N.y)
    foot = body.at("foot", -s * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", foot, O, normal=N.y))
    loads = [kn.gravity(-9.81 * N.y), kn.linear_spring(body, foot, k, 0.5)]
    masses = [kn.Particle("body", body, 5.0), kn.Particle("foot", foot, 0.5)]
    eom = kn.derive(kn.System(N, bodies=masses, speeds="rates", loads=loads, contacts=[floor]))
    cure = r"without the forces of contacts\. Use .*kn\.derive\(eom\.system\.in_modes\({'floor': 'closed'}\)\)"
    for ask in (kn.equilibrium, kn.linearize):
        with pytest.raises(kn.SimulationError, match=cure):
            ask(eom, kn.State({y: 0.5, s: 0.5}, 0))
    (_, modes), *_ = kn.simulate(eom, (0, 0.1), q=[0.49, 0.49], u=0).mode_history
    assert modes == {"floor": "closed"}
    stands = kn.derive(eom.system.in_modes(modes))
    rest = kn.equilibrium(stands, q={y: kn.guess(0.5), s: kn.guess(0.5)})
    assert rest["y"] == pytest.approx(0.5 - 5 * 9.81 / k)
    assert stands.evaluate(floor.normal_force, rest) == pytest.approx(5.5 * 9.81)
    assert kn.linearize(stands, rest).eigenvalues[0] == pytest.approx(20j)


def test_a_start_that_its_mode_does_not_have():
    """Stick is asked for at a slip, or at an open gap."""
    stick = kn.derive(system(*particle()).in_modes({"floor": "stick"}))
    with pytest.raises(kn.SimulationError, match=r"start speeds that satisfy the constraints .* miss floor 1 by 1"):
        kn.simulate(stick, (0, 1), q=[0, 0], u=[1, 0])
    with pytest.raises(
        kn.SimulationError, match=r"start values that satisfy the constraints, .* miss floor normal by 0.5"
    ):
        kn.simulate(stick, (0, 1), q=[0, 0.5], u=[0, 0])


@pytest.mark.parametrize("speed", [0, 1])
def test_a_start_that_pulls_at_a_contact_without_a_gap(speed):
    """N < 0 from the start on, at rest or slipping."""
    N, O = ground()
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    normal = kn.reaction("N_P", at=P, along=N.y)
    table = kn.contact(kn.joints.point_on_plane("table", P, O, normal=N.y), 0.3, normal=normal)
    loads = [kn.gravity(-9.81 * N.y), kn.Force(P, 20 * N.y)]
    bodies = [kn.Particle("p", P, 1.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=[table]))
    with pytest.raises(
        kn.SimulationError, match="table opens, but no coordinate describes its gap: continue with a model"
    ):
        kn.simulate(eom, (0, 1), q=[0], u=[speed])


def test_stiction_in_a_joint_without_a_rate_of_its_own():
    N, O = ground()
    ball = kn.ball("ball", O, N)
    with pytest.raises(kn.ModelError, match=r"Expected stiction in a pin or slider joint, got .* Use kn.*clutch"):
        kn.joints.stiction(ball, 1.0)


def test_a_clutch_between_frames_that_do_not_turn():
    N, _ = ground()
    a = kn.coordinate("a")
    A = N.rotate("A", a, N.z)
    B = A.rotate("B", 0.3, A.z)
    with pytest.raises(kn.ModelError, match="Expected frames of 'clutch' that turn about"):
        kn.joints.clutch("clutch", A, B, A.z, 1.0)
    with pytest.raises(kn.ModelError, match="a size ≥ 0 of the contact 'clutch', got -1"):
        kn.joints.clutch("clutch", A, N, N.z, -1.0)
    with pytest.raises(kn.ModelError, match=r"unit vector as the axis of 'clutch', got 2 N.z of length 2"):
        kn.joints.clutch("clutch", A, N, 2 * N.z, 1.0)


def test_a_gap_of_unlike_units_is_named():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m")
    stop = kn.joints.stop("stop", x - kn.parameter("a", 1, "kg"))
    block = kn.Particle("block", O.at("block", x * N.x), 1)
    with pytest.raises(
        kn.UnitError, match=r"Expected terms of one unit in x - a, .*This is in the gap of the contact 'stop'"
    ):
        kn.System(N, bodies=[block], speeds="rates", contacts=[stop])

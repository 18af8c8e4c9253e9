# SPDX-License-Identifier: BSD-3-Clause
"""A start on the constraints: what is given stays, guesses choose the branch, what is left out follows or is asked for."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from tests.systems.four_bar import BAR, EOM, N, O

q1, q2, q3 = BAR.q
u1, u2, u3 = EOM.speeds


def corners(q):
    """Where the coupler and the rocker end."""
    ends = np.cumsum([length * np.exp(1j * q[k]) for length, k in zip((0.4, 1.0, 0.8), BAR.q, strict=True)])
    return ends[1:]


def assemble(**given):
    return kn.assemble(EOM, **given)


@pytest.mark.parametrize(("guess", "above"), [((0.8, -1.5), True), ((-1.0, 1.0), False)])
def test_guesses_choose_the_branch(guess, above):
    found = assemble(q={q1: 0.5, q2: kn.guess(guess[0]), q3: kn.guess(guess[1])})
    assert found.q[q1] == 0.5
    joint, tip = corners(found.q)
    assert tip == pytest.approx(1.1, abs=1e-12)
    assert (joint.imag > 0) == above
    assert found.residual < 1e-12


def test_what_is_left_out_follows_from_the_constraints():
    found = assemble(q={q1: 0.5}, u={u1: 2})
    assert corners(found.q)[1] == pytest.approx(1.1, abs=1e-12)
    assert (found.q[q1], found.u[u1]) == (0.5, pytest.approx(2))
    A = np.asarray(EOM.evaluate(EOM.A, q=found.q), dtype=float)
    np.testing.assert_allclose(A @ list(found.u.values()), 0, atol=1e-12)
    assert repr(found).startswith("Assembled(q1 = 0.5, q2 = ")


def test_speeds_from_rates():
    one = assemble(q={q1: 0.5, q2: kn.guess(0.8), q3: kn.guess(-1.5)}, rates={q1: 2})
    two = assemble(q=one.q, u={u1: 2})
    assert one.u == pytest.approx(two.u)


def test_without_speeds_the_system_rests_unless_the_constraints_move():
    assert list(assemble(q={q1: 0.5}).u.values()) == pytest.approx([0, 0, 0])
    x = kn.coordinate("x")
    p = O.at("p", x * N.x)
    held = kn.coincident(p, O.at("wall", 3 * kn.time * N.x), along=N.x, name="wall")
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", p, 1)], speeds="rates", holonomic=held))
    found = kn.assemble(eom, t=2)
    assert (found.q[x], found.u[eom.speeds[0]]) == (pytest.approx(6), pytest.approx(3))


def test_a_start_that_is_given_whole_is_moved_by_rounding_only():
    exact = assemble(q={q1: 0.5}).q
    off = {k: v + 3e-10 for k, v in exact.items()}
    moved = assemble(q=off).q
    assert max(abs(moved[k] - off[k]) for k in off) < 1e-9
    assert corners(moved)[1] == pytest.approx(1.1, abs=1e-13)


def test_a_start_that_contradicts_a_constraint_is_refused_with_how_much():
    q = dict(assemble(q={q1: 0.5}).q)
    q[q3] += 0.01
    with pytest.raises(
        kn.SimulationError,
        match=r"coordinates that miss close 1 by -?0\.00\d+, close 2 by -?0\.00\d+\. Leave some out, or mark",
    ):
        assemble(q=q)
    with pytest.raises(kn.SimulationError, match="miss close 1 by"):
        kn.simulate(EOM, (0, 1), q=q, u={u1: 0})


def test_speeds_that_contradict_a_constraint_are_refused_with_how_much():
    q = assemble(q={q1: 0.5}).q
    with pytest.raises(
        kn.SimulationError, match=r"start speeds that satisfy .*, got values that miss close 1 by .*, close 2 by"
    ):
        assemble(q=q, u={u1: 1, u2: 1, u3: 2})
    with pytest.raises(
        kn.SimulationError, match=r"start rates that satisfy .* Leave some out, or mark them with kn.guess"
    ):
        assemble(q=q, rates={q1: 1, q2: 1, q3: 1})


def test_parts_that_cannot_reach_each_other():
    far = BAR.system(holonomic=kn.coincident(BAR.tip, O.at("far", 3 * N.x), along=(N.x, N.y), name="far"))
    with pytest.warns(kn.KaneWarning, match="some configuration satisfies, got none from 1872 starts"):
        eom = kn.derive(far)
    with pytest.raises(
        kn.SimulationError,
        match=r"satisfies the constraints, got none from 2060 starts: the residual decreased from .* to .* and is largest in 'far \d'",
    ):
        kn.assemble(eom, q={q1: 0.5})
    with pytest.raises(kn.SimulationError, match="free more coordinates than q3, or correct the lengths"):
        assemble(q={q1: 0.5, q2: 0.3, q3: kn.guess(0)})


def test_what_is_not_determined_is_asked_for():
    with pytest.raises(
        kn.ValueMissingError, match=r"got 1 too few: q1, q2, q3 can still vary. Give 1 of them, or a guess for each"
    ):
        assemble(q={})
    with pytest.raises(
        kn.ValueMissingError, match=r"speeds that the constraints do not determine, got too few: .* Give 1 of them"
    ):
        assemble(q={q1: 0.5}, u={})
    with pytest.raises(kn.ValueMissingError, match="all rates that the constraints do not determine"):
        assemble(q={q1: 0.5}, rates={})


def test_a_tree_needs_all_coordinates():
    x = kn.coordinate("x")
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", O.at("p", x * N.x), 1)], speeds="rates"))
    with pytest.raises(kn.ValueMissingError, match="Expected a start value for all coordinates, got none for x"):
        kn.assemble(eom)


def test_bad_arguments():
    with pytest.raises(kn.SimulationError, match="Expected either u= or rates= to assemble with, got both"):
        assemble(q={q1: 0.5}, u={u1: 1}, rates={q1: 1})
    with pytest.raises(kn.KaneError, match="Expected"):
        kn.guess("near")
    with pytest.raises(kn.ValueMissingError, match="Expected values for coordinates of the system"):
        assemble(q={"q9": 1})


def test_more_constraints_than_coordinates_contradict_each_other():
    stay = [kn.distance(BAR.tip, O.at(f"p{k}", k * N.x + 2 * N.y), 1.5, name=f"stay {k}") for k in range(2)]
    with pytest.warns(kn.KaneWarning, match="depend on each other"):
        eom = kn.derive(BAR.system(holonomic=[*BAR.close, *stay]))
    with pytest.raises(
        kn.SimulationError, match=r"got none from 2060 starts: the residual decreased from .* is largest in"
    ):
        kn.assemble(eom, q={})


def test_euler_parameters_come_to_unit_length():
    e = kn.coordinates("e0:4")
    B = N.rotate_euler_parameters("B", e)
    body = kn.RigidBody("b", frame=B, mass_center=O.at("b*", 0.5 * B.x), mass=1, inertia=kn.inertia(B, 0.1, 0.2, 0.3))
    level = kn.perpendicular(B.x, N.z)
    eom = kn.derive(kn.System(N, bodies=[body], speeds="rates", holonomic=level))
    found = kn.assemble(eom, q={k: kn.guess(v) for k, v in zip(e, (0.7, 0.3, -0.4, 0.6), strict=True)})
    values = np.array([found.q[k] for k in e])
    assert values @ values == pytest.approx(1, abs=1e-13)
    assert eom.evaluate(level.expr, q=found.q) == pytest.approx(0, abs=1e-12)
    with pytest.raises(kn.SimulationError, match=r"miss unit length of \(e0, e1, e2, e3\) by -0.19"):
        kn.assemble(eom, q=dict(zip(e, (0.9, 0, 0, 0), strict=True)))


def test_guesses_from_which_no_step_closes_it_are_led_to_the_branch_that_there_is():
    """Bennett's loop, sin α / a = sin β / b: from a poor guess no step closes it."""
    a, b, alpha = 0.2, 0.3, 0.5
    beta = np.arcsin(b * np.sin(alpha) / a)
    frame, point, hinges, bodies = N, O.at("base", 0), [], []
    for k, (length, twist) in enumerate(((b, beta), (a, alpha), (b, beta)), start=1):
        hinge = kn.pin(f"J{k}", point, frame, axis=frame.z, child=f"L{k}", coordinates=f"q{k}", speeds=f"u{k}")
        hinges.append(hinge)
        inertia = kn.inertia(hinge.frame, 0.01, 0.01, 0.01)
        bodies.append(kn.RigidBody(f"l{k}", frame=hinge.frame, mass_center=hinge.point, mass=1, inertia=inertia))
        point, frame = (
            hinge.point.at(f"e{k}", length * hinge.frame.x),
            hinge.frame.rotate(f"t{k}", twist, hinge.frame.x),
        )
    last = N.rotate("K", -alpha, N.x)
    loop = kn.close_pin("J4", O.at("D", -a * N.x), last, point, frame, axis=last.z)
    with pytest.warns(kn.KaneWarning, match="redundant"):
        eom = kn.derive(kn.System(N, bodies=bodies, joints=hinges, holonomic=loop))
    for guesses in ({}, {"q2": kn.guess(-1.5), "q3": kn.guess(1.0)}):
        found = kn.assemble(eom, q={"q1": 1.0, **guesses})
        # opposite angles of the loop are equal but for sign
        assert list(found.q.values())[2] == pytest.approx(-1.0, abs=1e-9)


def test_of_mirror_images_one_is_taken_whatever_rounding_leaves():
    q, d = kn.coordinates("q1:3", "rad"), kn.parameter("d", 1.2, "m")
    point, bodies = O.at("pin", 0), []
    for k, angle in enumerate(q):
        frame = N.rotate(f"L{k}", angle, N.z)
        center, point = point.at(f"l{k}*", 0.5 * frame.x), point.at(f"end {k}", 1.0 * frame.x)
        bodies.append(kn.Particle(f"l{k}", center, 1.0))
    closing = kn.coincident(point, O.at("other pin", d * N.x), along=(N.x, N.y), name="closing")
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", holonomic=closing))
    for x in np.linspace(0.1, 1.9, 40):
        one, other = kn.assemble(eom, parameters={d: x}, all_branches=True)
        assert list(one.q.values()) == pytest.approx(np.arccos(x / 2) * np.array([1, -1]))
        assert list(other.q.values()) == pytest.approx(np.arccos(x / 2) * np.array([-1, 1]))


@pytest.mark.parametrize("about", ["x", "y", "z"])
def test_what_is_half_a_turn_away_is_one_branch(about):
    e, phi = kn.coordinates("e0:4"), kn.parameter("phi", 0.0, "rad")
    A, B = N.rotate("A", phi, getattr(N, about)), N.rotate_euler_parameters("B", e)
    body = kn.RigidBody("b", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, 1, 2, 3))
    held = [*kn.parallel(B.x, A.x, across=(A.y, A.z)), *kn.parallel(B.y, A.y, across=(A.x, A.z))]
    with pytest.warns(kn.KaneWarning, match="redundant"):
        eom = kn.derive(kn.System(N, bodies=[body], speeds="rates", holonomic=held))
    for beside in (-1e-9, 0.0, 1e-12):
        found = kn.assemble(eom, parameters={phi: np.pi + beside}, all_branches=True)
        assert len(found) == 4  # axes are parallel either way, and each orientation has Euler parameters of one sign


@pytest.mark.parametrize("q1", [0.0, np.pi, -np.pi])
def test_angles_half_a_turn_away_are_one_branch(q1):
    eom = kn.derive(load("slider_crank").system())
    found = kn.assemble(eom, q={"q1": q1}, all_branches=True)
    q2, x = np.array([list(one.q.values()) for one in found]).T[1:]
    assert q2 == pytest.approx([0, np.pi], abs=1e-12)
    assert x == pytest.approx(0.08 * np.cos(q1) + np.array([0.24, -0.24]))


def slide(metre=1.0, reverse=False):
    """A crank with an offset slider: angles and a length together, in a unit and an order of declaration."""
    a, b, x = kn.coordinate("a"), kn.coordinate("b"), kn.coordinate("x")
    A, B = N.rotate("A", a, N.z), N.rotate("B", b, N.z)
    P, S = O.at("P", 0.3 * metre * A.x), O.at("S", x * N.x + 0.1 * metre * N.y)
    closing = [*kn.coincident(P.at("Q", metre * B.x), S, along=(N.x, N.y))]
    bodies, order = [kn.Particle("p", P, 1.0), kn.Particle("s", S, 1.0)], -1 if reverse else 1
    return kn.derive(
        kn.System(N, bodies=bodies, speeds="rates", holonomic=closing[::order], coordinates=(a, b, x)[::order])
    )


@pytest.mark.parametrize("metre", [1.0, 1e2, 1e-2, 1e5, 1e-6])
@pytest.mark.parametrize("guess", [(1.87, -2.09, 2.13), (-2.04, 0.58, -2.34), (0.28, -1.84, 1.08), (-1.4, 2.08, -1.71)])
def test_the_nearest_to_more_guesses_than_needed_is_the_same_in_any_units_and_order(metre, guess):
    """The distance of angles and lengths together is that in rad and relative to the mechanism, wherever the guesses are."""

    def found(eom, metre):
        given = dict(zip("abx", [*guess[:2], guess[2] * metre], strict=True))
        q = {name: kn.guess(v) for name, v in given.items()}
        state = kn.assemble(eom, q=q, u={"u_a": kn.guess(1.0), "u_b": kn.guess(0), "u_x": kn.guess(0)})
        return [state["a"], state["b"], state["x"] / metre]

    expected = found(slide(), 1.0)
    np.testing.assert_allclose(found(slide(metre), metre), expected, atol=1e-6)
    np.testing.assert_allclose(found(slide(metre, reverse=True), metre), expected, atol=1e-6)


@pytest.mark.parametrize(("unit", "place"), [("", (0.0, 0.0)), ("m", (0.0, 0.0)), ("m", (0.3, 1.7))])
def test_the_nearest_is_where_the_way_to_the_guesses_is_across_the_motion(unit, place):
    """Of a particle on a circle, given beside it by two guesses: the end of the radius through them, however far they are."""
    x, y, r = kn.coordinate("x", unit), kn.coordinate("y", unit), kn.parameter("r", 0.7, unit)
    a, b = kn.parameter("a", place[0], unit), kn.parameter("b", place[1], unit)
    P, C = O.at("P", x * N.x + y * N.y), O.at("C", a * N.x + b * N.y)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", holonomic=[kn.distance(C, P, r)]))
    for far in (0.05, 1.1, 1.9, 40.0):
        at = far * np.array([np.cos(2.2), np.sin(2.2)])
        guesses = {x: kn.guess(place[0] + at[0]), y: kn.guess(place[1] + at[1])}
        found = kn.assemble(eom, q=guesses, u={"u_x": 0})
        np.testing.assert_allclose([found["x"], found["y"]], place + 0.7 / far * at, atol=1e-6)

# SPDX-License-Identifier: BSD-3-Clause
"""Rows that depend on each other: what is said is true of redundant, contradictory and singular constraints alike."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
A = O.at("A", 3 * N.x)
x, y = kn.coordinates("x y")
P = O.at("P", x * N.x + y * N.y)


def derived(*, point=P, **constraints):
    """The equations, and what was said."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", point, 2)], speeds="rates", **constraints))
    assert all(issubclass(w.category, kn.KaneWarning) and w.filename == __file__ for w in told)
    return eom, [str(w.message) for w in told]


DIFFERENT = "constraints that speeds can satisfy together, got 'one', 'two', which give the same combination of speeds different"


@pytest.mark.parametrize(
    ("one", "two"),
    [
        (x.dt - 1, x.dt - 2),
        (x.dt - 1, 1e6 * x.dt - 2e6 - 1),
        (x.dt + y.dt * kn.cos(x) - 1, 2 * x.dt + 2 * y.dt * kn.cos(x)),
        (x.dt - kn.sin(kn.time), x.dt - kn.cos(kn.time)),
    ],
)
def test_motion_constraints_that_contradict_each_other(one, two):
    held = [kn.motion_constraint("one", one), kn.motion_constraint("two", two)]
    with pytest.raises(kn.ModelError, match=f"{DIFFERENT} values. Leave one of them out"):
        derived(nonholonomic=held)


def test_motion_constraints_that_say_the_same():
    eom, (told,) = derived(
        nonholonomic=[kn.motion_constraint("one", x.dt - 1), kn.motion_constraint("two", 3 - 3 * x.dt)]
    )
    assert "'one', 'two' depend on each other: 1 of these 2 is redundant" in told
    assert np.array(eom.evaluate(list(eom.accelerations), q=[0, 0], u=[1, 5])) == pytest.approx([0, 0])


def test_where_it_depends_on_a_parameter_or_an_input():
    for speed in (kn.parameter("v"), kn.parameter("v", 3.0), kn.input("v")):
        held = [kn.motion_constraint("one", x.dt - speed), kn.motion_constraint("two", x.dt - 1)]
        _, (told,) = derived(nonholonomic=held)
        assert f"{DIFFERENT} values at the values of v (defaults, where declared)" in told
        assert "redundant" not in told
    held[0] = kn.motion_constraint("one", x.dt - kn.parameter("v", 1.0))
    assert "redundant" in derived(nonholonomic=held)[1][0]


def test_a_configuration_and_a_motion_constraint():
    driven = kn.configuration_constraint("one", x - kn.sin(kn.time))
    with pytest.raises(kn.ModelError, match=DIFFERENT):
        derived(holonomic=driven, nonholonomic=kn.motion_constraint("two", x.dt - 2))
    assert (
        "redundant" in derived(holonomic=driven, nonholonomic=kn.motion_constraint("two", x.dt - kn.cos(kn.time)))[1][0]
    )


def test_two_places_at_once():
    with pytest.raises(
        kn.ModelError,
        match="consistent configuration constraints, got 'P = A', 'P = O 1', which contradict each other at every configu",
    ):
        derived(holonomic=[*kn.coincident(P, A, N.x), *kn.coincident(P, O, (N.x, N.y))])
    assert (
        "redundant"
        in derived(holonomic=[*kn.coincident(P, O, N.x), kn.configuration_constraint("again", -2 * x)])[1][0]
    )


def test_in_any_units():
    """Micrometres beside gigametres: the sizes of rows that are written as numbers say nothing."""
    here, there = (
        kn.configuration_constraint("here", 1e9 * (x - 1)),
        kn.configuration_constraint("there", 1e-6 * (x - 2)),
    )
    with pytest.raises(kn.ModelError, match="got 'here', 'there', which contradict each other at every configuration"):
        derived(holonomic=[here, there])


def test_rods_that_do_not_reach():
    """Two rods too short to meet: independent rows, and no configuration; a third makes more constraints than coordinates."""
    length = kn.parameter("L", 1.0)
    rods = [kn.distance(P, O, 1.0, name="left"), kn.distance(P, A, length, name="right")]
    eom, (told,) = derived(holonomic=rods)
    assert "got none from 1872 starts with parameters at their defaults: " in told
    assert "kn.assemble(eom, q=…, parameters=…) tries other" in told
    assert not eom.redundant
    found = kn.assemble(eom, q={x: kn.guess(0.5), y: kn.guess(0.5)}, parameters={length: 2.5})
    assert np.hypot(found.q[x], found.q[y]) == pytest.approx(1)
    third = kn.distance(P, O.at("B", 2 * N.y), 0.3, name="third")
    _, (told,) = derived(holonomic=[*rods, third])
    assert "got none from 1872 starts" in told
    assert (
        "The constraints 'left', 'right', 'third' depend on each other at a random configuration too. They may contradict"
        in told
    )
    assert "redundant" not in told
    with pytest.raises(kn.SimulationError, match="Expected a configuration that satisfies the constraints, got none"):
        kn.assemble(eom, q={x: kn.guess(0.5), y: kn.guess(0.5)})


def test_lengths_without_defaults_are_nobody_s_fault():
    sides = [kn.distance(P, O, kn.parameter("a")), kn.distance(P, A, kn.parameter("b"))]
    eom, told = derived(holonomic=sides)
    assert (told, eom.redundant) == ([], ())
    _, (told,) = derived(holonomic=[*sides, kn.distance(P, O.at("B", 9 * N.y), kn.parameter("c"))])
    assert "got none from 1872 starts with random values of a, b, c: " in told
    assert "redundant" not in told


def test_rods_that_just_reach():
    """Tangent circles: the rows depend on each other at the only place there is, and neither rod is redundant."""
    eom, told = derived(holonomic=[kn.distance(P, O, 1.0, name="left"), kn.distance(P, A, 2.0, name="right")])
    assert not told
    with pytest.raises(kn.SingularError, match=r"No other choice is possible: .* a singular configuration"):
        eom.evaluate(list(eom.accelerations), q=[1, 0], u=[0, 0])


def test_a_loop_that_moves_is_redundant():
    """Three equal rods between parallel bodies: one of them follows from the other two, at every configuration."""
    bar = N.rotate("bar", 0, N.z)
    corner = P.at("C", 1 * bar.x)
    middle = P.at("M", 0.5 * bar.x)
    rods = [
        kn.distance(p, O.at(f"F{k}", k * 0.5 * N.x), 1.2, name=f"rod{k}") for k, p in enumerate((P, middle, corner))
    ]
    eom, (told,) = derived(point=middle, holonomic=rods)
    assert "'rod0', 'rod1', 'rod2' depend on each other: 2 of these 3 are redundant. The multipliers of" in told
    assert len(eom.redundant) == 2


def test_groups_that_have_nothing_to_do_with_each_other():
    """Two of x and three of y: each group with its own number."""
    held = [kn.configuration_constraint(f"{q}{k}", k * q - k) for q, n in ((x, 2), (y, 3)) for k in range(1, n + 1)]
    _, (told,) = derived(holonomic=held)
    assert (
        "The constraints 'x1', 'x2' depend on each other: 1 of these 2 is redundant. The constraints 'y1', 'y2', "
        in told
    )
    assert "'y3' depend on each other: 2 of these 3 are redundant. The multipliers of " in told


def test_what_to_leave_out_is_what_mends_it():
    """A reaction that is not determined: without the constraints named it is."""
    rods = [kn.distance(P, O, 1.0, name="left"), kn.distance(P, O, 1.0, name="again")]
    asked = kn.reaction("R", constraint=rods[1])
    with pytest.raises(
        kn.ReactionError, match=r"got R .again.: .* Leave out 'left', so that the other constraints carry"
    ):
        derived(holonomic=rods, reactions=[asked])
    eom, told = derived(holonomic=rods[1:], reactions=[asked])
    assert not told
    assert np.isfinite(eom.evaluate(eom.reaction_values, q=[0.6, 0.8], u=[0, 0])).all()


def test_a_drive_that_is_closed_at_the_start_only():
    """Rods of 1 and 2.2 from O and from a pin at 3 + 5 t: beyond t = 0.04 they do not reach, as at most times drawn."""
    moving = O.at("M", (3 + 5 * kn.time) * N.x)
    _, told = derived(holonomic=[kn.distance(P, O, 1.0, name="left"), kn.distance(P, moving, 2.2, name="right")])
    assert not told
    _, (told,) = derived(holonomic=[kn.distance(P, O, 1.0, name="left"), kn.distance(P, moving, 1.2, name="right")])
    assert re.search(r"got none from 1872 starts at each of t = 0\.\d+, 0\.\d+, 0: ", told)


def test_redundant_where_nothing_can_move():
    """Two rods and the first one again: as many independent constraints as speeds."""
    rods = [kn.distance(P, O, 1.0, name="left"), kn.distance(P, A, 2.5, name="right")]
    twice = [*rods, kn.distance(P, O, 1.0, name="again")]
    _, (told,) = derived(holonomic=twice)
    assert (
        "'left', 'again' depend on each other: 1 of these 2 is redundant. The multiplier of 'again' is taken as zero. The "
        "constraints leave none of 2 " in told
    )
    assert "speeds free: nothing can move, and the individual constraint forces are not determined." in told
    assert "all the same" not in told
    driven = kn.distance(P, O.at("M", 0.1 * kn.sin(kn.time) * N.x), 1.0, name="driven")
    same = kn.distance(P, O.at("M2", 0.1 * kn.sin(kn.time) * N.x), 1.0, name="again")
    _, (told,) = derived(holonomic=[driven, same, rods[1]])
    assert "nothing can move except as the constraints prescribe, and" in told
    _, (told,) = derived(holonomic=[rods[0], twice[2]])
    assert "The motion is determined nevertheless; the individual constraint forces are not." in told

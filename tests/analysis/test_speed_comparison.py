# SPDX-License-Identifier: BSD-3-Clause
"""Sets of speeds side by side: operations route by route, singular configurations, conditioning along a motion."""

from __future__ import annotations

import re

import numpy as np
import pytest

import kane as kn
from kane.gallery import load, rolling_disk


def pendulum(length_unit=1.0):
    """A spherical pendulum by two angles, its bob's velocity, and these speeds; lengths in units of `length_unit` metres."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2 = kn.coordinates("q1 q2", "rad")
    v1, v2 = kn.speeds("v1 v2")
    m, g = kn.parameter("m", 1.0, "kg"), kn.parameter("g", 9.81 / length_unit, "m/s^2")
    A = N.rotate("A", q1, N.x)
    B = A.rotate("B", q2, A.y)
    P = O.at("P", -kn.parameter("L", 1.0 / length_unit, "m") * B.z)
    v = P.velocity(N)
    system = kn.System(N, bodies=[kn.Particle("bob", P, m)], speeds="rates", loads=[kn.gravity(-g * N.z)])
    return system, {"velocity": {v1: v.dot(B.x), v2: v.dot(B.y)}}


def motion(system):
    return kn.simulate(kn.derive(system), (0, 1.5), q=[0.3, 1.2], u=[1.0, 0.0], samples=301)


def test_operations_are_those_of_the_equations():
    system, candidates = pendulum()
    found = kn.compare_speeds(system, candidates)
    for name, own in (("declared", system), ("velocity", system.replace(speeds=candidates["velocity"]))):
        eom = kn.derive(own)
        assert found[name].operations[eom.route] == eom.operations.total
        assert found[name].total == min(found[name].operations.values())
    by_recursion = kn.derive(system, route="recursive").operations.total
    assert found["declared"].operations["recursive"] == by_recursion
    assert "recursive" not in found["velocity"].operations  # W has a pole that the velocity has not
    assert found.shortest.total == min(s.total for s in found.sets)
    assert found["declared"].condition is None
    assert found["declared"].worst is None


def test_routes_that_are_asked_for_stand_beside_the_one_that_is_taken():
    system, candidates = pendulum()
    taken = kn.derive(system).route
    assert set(kn.compare_speeds(system, candidates, routes=()).sets[0].operations) == {taken}
    closed = load("four_bar").system()
    operations = kn.compare_speeds(closed, {}).sets[0].operations
    assert {"classical", "recursive", "composite"} < operations.keys()


def test_singular_configurations():
    system, candidates = pendulum()
    found = kn.compare_speeds(system, candidates)
    assert [str(e) for e in found["velocity"].singular] == ["cos(q2)"]
    disk = kn.compare_speeds(rolling_disk.model().system, {"rates": "rates"})
    assert [[str(e) for e in s.singular] for s in disk.sets] == [["cos(q2)"], []]


def test_the_condition_number_grows_towards_a_singular_configuration():
    system, candidates = pendulum()
    sol = motion(system)
    found = kn.compare_speeds(system, candidates, along=sol)
    own, other = found["declared"], found["velocity"]
    np.testing.assert_allclose(own.condition, 1.0)
    cosine = np.abs(np.cos(sol["q2"]))
    usual = np.median(1 / cosine)
    assert other.condition == pytest.approx(np.maximum(1 / cosine / usual, usual * cosine), rel=1e-9)
    worst, t = other.worst
    assert worst == other.condition.max()
    assert sol.t[np.argmin(cosine)] == t or worst > 1 / cosine.max()
    # M of the velocity's components is the unit matrix times m, of the rates it is diagonal
    np.testing.assert_allclose(other.mass_condition, 1.0)


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_units_do_not_matter(unit):
    found = []
    for u in (1.0, unit):
        system, candidates = pendulum(u)
        found.append(kn.compare_speeds(system, candidates, along=motion(system))["velocity"])
    assert found[0].condition == pytest.approx(found[1].condition, rel=1e-5)
    assert found[0].mass_condition == pytest.approx(found[1].mass_condition, rel=1e-5)


def test_it_is_a_table():
    system, candidates = pendulum()
    text = repr(kn.compare_speeds(system, candidates, along=motion(system)))
    assert re.search(r"^velocity +\d.*cos\(q2\) = 0$", text, re.M)
    assert "cond W" in text.splitlines()[0]
    html = kn.compare_speeds(system, candidates)._repr_html_()
    assert "velocity" in html
    assert "cos(q2) = 0" in html


def test_what_is_no_set_of_speeds_is_named():
    system, candidates = pendulum()
    v1, v2 = candidates["velocity"]
    first = candidates["velocity"][v1]
    with pytest.raises(kn.SpeedsError, match="Expected speeds of this system as 'twice'"):
        kn.compare_speeds(system, {"twice": {v1: first, v2: 2 * first}})
    with pytest.raises(kn.ModelError, match="other than 'declared'"):
        kn.compare_speeds(system, {"declared": "rates"})
    with pytest.raises(kn.ModelError, match="Did you mean velocity"):
        kn.compare_speeds(system, candidates)["velocty"]
    with pytest.raises(kn.ModelError, match="Expected routes among"):
        kn.compare_speeds(system, candidates, routes=["fast"])
    with pytest.raises(kn.ModelError, match="by name"):
        kn.compare_speeds(system, ["rates"])
    with pytest.raises(kn.ModelError, match="a motion as along=, got 3"):
        kn.compare_speeds(system, candidates, along=3)
    with pytest.raises(kn.ModelError, match="methods to compare"):
        kn.compare_methods(system, [])
    one = kn.compare_speeds(system, {}, routes="classical").sets[0]
    assert one.operations == kn.compare_speeds(system, {}, routes=["classical"]).sets[0].operations
    again = kn.compare_speeds(system, candidates, routes=iter(["classical"])).sets
    assert all("classical" in speeds.operations for speeds in again)
    for methods in (np.array(["kane", "lagrange"]), iter(["kane", "lagrange"])):
        assert list(kn.compare_methods(system, methods).formulations) == ["kane", "lagrange"]

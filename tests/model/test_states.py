# SPDX-License-Identifier: BSD-3-Clause
"""Further states as they are declared: what is missing, what may not be in their rates, where they may not be."""

import pickle

import pytest

import kane as kn
from tests.systems import states as made
from tests.systems.states import N, O, a, e, q, u

F = kn.reaction("R", at=made.HAND, along=made.ARM.x)


def system(**changes):
    return made.arm().replace(**changes)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"states": {}}, r"a rate for the state a, got none\. Declare it: System\(states={a: …}\)"),
        ({"states": [a]}, r"states= to be a dict"),
        ({"states": {q: u}}, r"states from kn\.state as keys of states=, got q \(Coordinate\)"),
        ({"states": {"a": u}}, r"states from kn\.state as keys"),
        ({"states": {a: u * N.x}}, r"a scalar as the rate of the state a, got .*\.dot\(unit vector\)"),
        ({"states": {a: u.dt}}, r"got the acceleration u', which is not known before .* high-pass"),
        ({"states": {a: F}}, r"got R \(Reaction\), which is not known"),
        ({"states": {a: a.dt}}, r"got the rate a', .* Write out the rate of a as in states="),
        ({"states": {a: kn.state("b")}}, r"a rate for the state b, got none"),
        ({"states": {a: kn.coordinate("p")}}, r"got p: no frame or point depends on it"),
        ({"loads": [kn.Torque(made.ARM, a.dt * N.z)]}, r"in states, not in their rates, got the rate a'"),
        ({"speeds": {u: q.dt + a}}, r"definitions of speeds without states, got a"),
        ({"nonholonomic": [kn.motion_constraint("c", q.dt - a)]}, r"constraints without states, got a in them\. Let states"),
        ({"states": {a: (e - a) * kn.parameter("a", 1.0)}}, r"one symbol of the name 'a'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(changes, told):
    with pytest.raises(kn.ModelError, match=told):
        system(**changes)


def test_states_place_nothing():
    turned = N.rotate("B", a, N.z)
    with pytest.raises(kn.ModelError, match="positions and orientations without states, got a"):
        kn.System(N, bodies=[kn.Particle("P", O.at("P", q * turned.x), 1)], speeds="rates", states={a: -a})


def test_units_are_those_of_rates():
    with pytest.raises(kn.UnitError, match=r"the rate of the state z \[m\*s\]"):
        made.cart().replace(states={made.z: made.v, made.w: -made.w / made.T})
    assert kn.derive(made.cart()).unit(made.z.dt) == "m*s/s"


def test_a_default_is_a_number():
    with pytest.raises(kn.ExpressionError, match="without a default write unit='N'"):
        kn.state("f", "N")
    assert kn.state("f").default == 0.0


def test_parameters_and_inputs_of_rates_are_the_systems():
    own = made.arm()
    assert {p.name for p in (made.ta, made.td)} <= {p.name for p in own.parameters}
    assert e in own.inputs
    assert list(own.states) == [a]


def test_systems_with_states_are_pickled():
    again = pickle.loads(pickle.dumps(made.cart()))
    assert [str(x) for x in again.states.values()] == [str(x) for x in made.cart().states.values()]
    assert list(again.states) == list(made.cart().states)

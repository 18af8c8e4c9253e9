# SPDX-License-Identifier: BSD-3-Clause
"""Names, symbols and expressions mean the same wherever quantities or values are asked for."""

from typing import Any

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q1, q2 = kn.coordinates("q1 q2", "rad")
u1, u2 = kn.speeds("u1 u2", "rad/s")
m, L, g = kn.parameter("m", 1.2, "kg"), kn.parameter("L", 0.5, "m"), kn.parameter("g", 9.81, "m/s^2")
T = kn.input("T", "N*m")
A = N.rotate("A", q1, N.z)
B = A.rotate("B", q2, A.z)
P = O.at("P", L * A.x)
Q = P.at("Q", L * B.x)
PULL = kn.reaction("R", at=P, along=A.x)
WEIGHT, MOTOR = kn.gravity(-g * N.y), kn.Torque(A, T * N.z, name="motor")
SYSTEM = kn.System(
    N,
    bodies=[kn.Particle("first", P, m), kn.Particle("second", Q, m)],
    speeds={u1: q1.dt, u2: q1.dt + q2.dt},
    loads=[WEIGHT, MOTOR],
    reactions=[PULL],
)
EOM = kn.derive(SYSTEM)
AT: dict[str, Any] = {"q": [0.3, 0.8], "u": [1.0, -2.0], "inputs": {T: 0.4}}
SYMBOLS = (q1, q2, u1, u2, m, L, g, T, PULL, q1.dt, u2.dt, kn.time)


@pytest.mark.slow
@pytest.mark.parametrize("symbol", SYMBOLS, ids=str)
def test_a_name_is_its_symbol(symbol):
    value = EOM.evaluate(symbol, **AT)
    assert EOM.evaluate(symbol.name, **AT) == value
    assert EOM.evaluate([symbol.name, Q.velocity(N)], **AT)[0] == value
    sol = kn.simulate(EOM, (0, 0.1), **AT, samples=3)
    assert np.array_equal(sol[symbol.name], sol[symbol])
    compiled = EOM.compile(outputs=[symbol.name])
    x = np.array([*AT["q"], *AT["u"]])
    assert compiled.outputs(0.0, x, r={"T": 0.4})[symbol.name] == pytest.approx(value, rel=1e-12)
    linear = kn.linearize(EOM, q=[-np.pi / 2, 0], outputs=[symbol.name])
    assert pytest.approx(kn.linearize(EOM, q=[-np.pi / 2, 0], outputs=[symbol]).D) == linear.D


@pytest.mark.parametrize("place", [kn.evaluate, kn.substitute])
def test_values_by_name(place):
    e = m * L * q1.dt + kn.sin(q2)
    values = {m: 2, L: 3, q1.dt: 4, q2: 0.5}
    by_name = {s.name: v for s, v in values.items()}
    assert float(place(e, by_name)) == float(place(e, values))
    assert float(place(e, values)) == pytest.approx(24 + np.sin(0.5))
    for wrong, message in (({"mm": 2}, "'mm'.*Did you mean m"), ({"k": 1}, "got .*'k'")):
        with pytest.raises(kn.ValueMissingError, match=message):
            place(e, by_name | wrong)


def test_another_symbol_of_a_name_is_no_value_of_this_one():
    """The default would be taken silently otherwise."""
    with pytest.raises(kn.ValueMissingError, match=r"another symbol of the name 'm'.*kn.parameter.'m', 1.2, unit='kg'"):
        kn.evaluate(m * q1, {q1: 1, kn.parameter("m", 2.0): 5})
    assert kn.evaluate(m * q1, {q1: 1, m: 5, kn.parameter("k"): 5}) == 5
    two = m + kn.parameter("m", 2.0)
    with pytest.raises(kn.ValueMissingError, match="one symbol and one value for the name 'm'"):
        kn.evaluate(two, {"m": 3})


def test_what_may_be_asked_for():
    velocity, inertia = Q.velocity(N), kn.rod(B, m, L, axis=B.x)
    assert EOM.evaluate(velocity, **AT).shape == (3,)
    assert np.array_equal(EOM.evaluate(velocity, **AT), EOM.evaluate(list(velocity.components(N)), **AT))
    assert EOM.evaluate(inertia, **AT).shape == (3, 3)
    many = AT | {"q": {"q1": np.linspace(0, 1, 5), "q2": 0.8}}
    assert EOM.evaluate(velocity, **many).shape == (5, 3)
    assert EOM.evaluate(inertia, **many).shape == (5, 3, 3)
    nested = EOM.evaluate([q1, [velocity, "u1"], EOM.mass_matrix], **AT)
    assert [np.shape(x) for x in (nested[0], nested[1][0], nested[1][1], nested[2])] == [(), (3,), (), (2, 2)]
    assert EOM.evaluate(np.array(2.0), **AT) == 2
    assert [float(x) for x in EOM.evaluate([np.array(2.0), np.float64(3)], **AT)] == [2, 3]
    for wrong in (None, {"q1"}, {"q1": 1}, object(), b"q1"):
        with pytest.raises(TypeError, match="Expected an expression, vector, name"):
            EOM.evaluate(wrong, **AT)
    for thing, cure in (
        (Q, r"its position\(…\), velocity\(N\)"),
        (B, r"its dcm\(N\)"),
        (EOM.system.bodies[0], "mass center"),
    ):
        with pytest.raises(TypeError, match=f"Expected an expression, vector, name.* Ask for .*{cure}"):
            EOM.evaluate(thing, **AT)
    with pytest.raises(kn.ValueMissingError, match=r"got 'q3'. Did you mean q2 or q1"):
        EOM.evaluate("q3", **AT)


def test_outputs():
    compiled = EOM.compile(outputs={"a": "q1", "v": Q.velocity(N), q2: q2, "table": [A.x, B.x]})
    found = compiled.outputs(0.0, np.array([0.3, 0.8, 1.0, -2.0]), r=[0.4])
    assert {name: np.shape(x) for name, x in found.items()} == {"a": (), "v": (3,), "q2": (), "table": (2, 3)}
    with pytest.raises(kn.ArgumentError, match="parts of one shape in the output 'mixed'"):
        EOM.compile(outputs={"mixed": [q1, A.x]})
    with pytest.raises(kn.ArgumentError, match="got 'q2' more than once"):
        EOM.compile(outputs={q2: q1, "q2": q2})
    with pytest.raises(kn.ArgumentError, match="a mapping from names to expressions, or a list of symbols"):
        EOM.compile(outputs=[2 * q1])
    linear = kn.linearize(EOM, q=[-np.pi / 2, 0], outputs={"v": Q.velocity(N)})
    assert linear.outputs == ("v.x", "v.y", "v.z")


@pytest.mark.parametrize("load", [WEIGHT, MOTOR])
def test_contributions_by_what_was_declared(load):
    value = EOM.Fr_contributions[u1, load]
    assert EOM.Fr_contributions["u1", load.name] is EOM.Fr_contributions[u1, load.name] is value
    assert ("u1", "engine") not in EOM.Fr_contributions
    with pytest.raises(kn.ValueMissingError, match=r"got .u1, engine"):
        EOM.Fr_contributions[u1, "engine"]
    assert EOM.Fr[0] is sum((EOM.Fr_contributions["u1", x] for x in (WEIGHT, MOTOR)), start=kn.Rational(0))
    assert EOM.contributions("u1").speed is u1
    assert len(EOM.mass_contributions("u1", u1)) == 2
    assert EOM.partial_velocities["Q"]["u2"] is EOM.partial_velocities[Q][u2]


def test_membership():
    rod = kn.configuration_constraint("rod", q1 - q2)
    held = kn.derive(SYSTEM.replace(reactions=(), holonomic=[rod], dependent_speeds="u2", dependent_coordinates=["q2"]))
    assert u2 in held.dependent_speeds
    assert "u2" in held.dependent_speeds
    assert u1 not in held.dependent_speeds
    assert kn.speed("u2") not in held.dependent_speeds
    assert held.system.dependent_coordinates.index("q2") == 0
    for symbols in (
        EOM.coordinates,
        EOM.speeds,
        EOM.all_speeds,
        EOM.parameters,
        EOM.inputs,
        EOM.reactions,
        EOM.independent_speeds,
    ):
        assert symbols[-1] in symbols
        assert symbols[-1].name in symbols
        assert symbols.index(symbols[-1].name) == len(symbols) - 1
        assert kn.time not in symbols
        assert symbols.count("t") == 0
    with pytest.raises(ValueError, match="Expected one of q1, q2, got q9"):
        EOM.coordinates.index("q9")
    assert SYSTEM.replace(coordinates="q2 q1").coordinates == (q2, q1)
    with pytest.raises(kn.ModelError, match=r"dependent_speeds= to list speeds of the system.*got u7"):
        SYSTEM.replace(holonomic=[rod], dependent_speeds=["u7"])


def test_inverse_and_points():
    inverse = kn.inverse(EOM, ["T", u2.dt])
    given = {"u1'": 1.0}
    point = kn.equilibrium(EOM, q=[kn.guess(-1.5), kn.guess(0)], inputs={T: 0}).replace(
        q={"q1": 0.3}, u={u2: 1}, inputs={"T": 2}
    )
    assert (point["q1"], point["u2"], point["T"], point[m]) == (0.3, 1, 2, 1.2)
    assert inverse(**point.arguments, given=given) == inverse(q=point.q, u=point.u, given=given)
    with pytest.raises(
        kn.ValueMissingError, match="Expected some of q, u, states, inputs, parameters, t to replace, got speed"
    ):
        point.replace(speed={u2: 1})
    with pytest.raises(kn.ValueMissingError, match="got one for 'q9'"):
        point.replace(q={"q9": 1})
    assert point.replace(t=2.0).arguments["t"] == 2


def test_a_motion_with_values_of_a_variant():
    """A parameter that this model does not hold is let pass by symbol; a name that it does not know is not."""
    spare = kn.parameter("k", 3.0)
    sol = kn.simulate(EOM, (0, 0.1), **AT, parameters={m: 2.0, spare: 1.0}, samples=3)
    assert sol["m"] == pytest.approx(2)
    with pytest.raises(kn.ValueMissingError, match="got one for 'k'"):
        kn.simulate(EOM, (0, 0.1), **AT, parameters={"k": 1.0})
    assert sol.energy == pytest.approx(sol[EOM.energy])
    numbers = [np.array(0.3), np.array(0.8)]
    again = kn.simulate(
        EOM, (0, 0.1), q=numbers, u=np.array([1.0, -2.0]), inputs={"T": np.array(0.4)}, parameters={"m": 2}, samples=3
    )
    assert np.array_equal(again.states, sol.states)

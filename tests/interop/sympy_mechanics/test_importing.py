# SPDX-License-Identifier: BSD-3-Clause
"""Models by SymPy's mechanics come in with SymPy's accelerations, in each way of saying things there."""

from functools import partial

import numpy as np
import pytest
import sympy
import sympy.physics.mechanics as me

import kane as kn
from kane.errors import ExpressionError, ModelError
from tests.interop.sympy_mechanics import models

WAYS = {
    "pendulum": models.pendulum,
    "velocity alone": models.velocity_alone,
    "about an axis": lambda: models.oriented("axis"),
    "body axes": lambda: models.oriented("Body ZXZ"),
    "space axes": lambda: models.oriented("Space 123"),
    "matrix": lambda: models.oriented("matrix"),
    "quaternion, three speeds": lambda: models.quaternion(False),
    "quaternion, four speeds": lambda: models.quaternion(True),
    "rotor": models.rotor,
    "spun": models.spun,
    "pushed": models.pushed,
    "tumbling": models.tumbling,
    "knife edge": models.knife_edge,
    "four-bar": models.four_bar,
    "tension": models.tension,
    "twice as fast": models.twice_as_fast,
    "joints": models.joints,
    "Lagrange": models.lagrange,
    "turntable": models.turntable,
    **{way: partial(models.pulled, way) for way in ("obstacle", "cylinder", "sphere")},
}


@pytest.mark.parametrize("way", WAYS)
def test_accelerations_are_sympys(way):
    found = kn.from_sympy_mechanics(WAYS[way]())
    (said,) = found.of_kind("checked")
    assert said.startswith("accelerations equal SymPy's")


def by_sympy(method, values):
    """u̇ by SymPy's own matrices, numbers put in by SymPy: a second route to the numbers."""
    mass, forcing = (x.xreplace(values).evalf() for x in (method.mass_matrix, method.forcing))
    return np.array(mass.LUsolve(forcing), dtype=float).ravel()


@pytest.mark.parametrize(
    "way", ["pendulum", "velocity alone", "about an axis", "body axes", "space axes", "matrix", "knife edge"]
)
def test_accelerations_by_a_second_route(way, rng):
    method = WAYS[way]()
    found = kn.from_sympy_mechanics(method, check=False)
    assert not found.of_kind("checked")
    for _ in range(3):
        numbers = {name: rng.uniform(0.3, 1.3) for name in found.symbols}
        atoms = (
            (method.mass_matrix.atoms() | method.forcing.atoms(sympy.Symbol, sympy.Function))
            | set(method.q)
            | set(method.u)
        )
        atoms |= method.mass_matrix.atoms(sympy.Function)
        values = {x: sympy.Float(numbers[x.name]) for x in atoms if getattr(x, "name", None) in numbers}
        expected = by_sympy(method, values)
        system = found.system
        state = {s: numbers.get(s.name, 0.0) for s in (*system.coordinates, *system.parameters, *system.inputs)}
        u = {s: numbers.get(s.name, 0.0) for s in system.speeds}
        got = found.eom.evaluate(
            [found.u[x.name].dt for x in method.u], q={s: state[s] for s in system.coordinates}, u=u,
            parameters={s: state[s] for s in system.parameters}, inputs={s: state[s] for s in system.inputs},
        )  # fmt: skip
        np.testing.assert_allclose(np.array(got, dtype=float), expected, rtol=1e-9, atol=1e-9)


def test_symbols_keep_names_and_assumptions():
    found = kn.from_sympy_mechanics(models.pendulum(), values={"m": 2.0, models.l: 0.5})
    assert (found.q["q"].name, found.u["u"].name) == ("q", "u")
    assert found.parameters["m"].default == 2.0
    assert found.parameters["l"].default == 0.5
    assert found.parameters["g"].description == "positive"
    assert [s.name for s in found.system.inputs] == ["T"]
    assert "T is an input" in found.of_kind("inferred")[0]


def test_it_simulates_as_what_it_is():
    """Small swings about the hanging position: ω² = m g l/(I + m l²)."""
    found = kn.from_sympy_mechanics(models.pendulum(), values={"m": 1, "g": 9.81, "l": 1, "I1": 1, "I2": 1, "I3": 1})
    sol = kn.simulate(found.eom, (0, 2), q={"q": 1e-4}, u={"u": 0}, inputs={"T": 0.0})
    np.testing.assert_allclose(sol[found.q["q"]], 1e-4 * np.cos(np.sqrt(9.81 / 2) * sol.t), atol=1e-8)


def test_an_auxiliary_speed_brings_the_tension():
    found = kn.from_sympy_mechanics(models.tension())
    (S,) = found.eom.reactions
    q, u = found.q["q"], found.u["u"]
    p = {"m": 2.0, "l": 0.7, "g": 9.8}
    value = found.eom.evaluate(S, q={q: 0.4}, u={u: 1.5}, parameters=p)
    assert float(value) == pytest.approx(2.0 * 0.7 * 1.5**2 + 2.0 * 9.8 * np.cos(0.4), rel=1e-12)


def test_quaternions_become_euler_parameters():
    found = kn.from_sympy_mechanics(models.quaternion(False))
    assert len(found.system.coordinates) == len(found.system.speeds) + 1
    assert not found.system.constraints
    assert "Euler parameters" in found.of_kind("read")[0]


def test_rates_of_configuration_constraints_are_dropped():
    found = kn.from_sympy_mechanics(models.four_bar())
    assert [c.kind for c in found.system.constraints] == ["configuration", "configuration"]
    assert sum("is left out" in text for text in found.of_kind("changed")) == 2


def test_bodies_and_loads_alone():
    """Coordinates are found in orientations and positions, u = q̇."""
    q, _ = me.dynamicsymbols("q u")
    N = me.ReferenceFrame("N")
    O = me.Point("O")
    O.set_vel(N, 0)
    B = N.orientnew("B", "Axis", [q, N.z])
    P = O.locatenew("P", models.l * B.x)
    P.v2pt_theory(O, N, B)
    found = kn.from_sympy_mechanics([me.Particle("p", P, models.m)], [(P, models.m * models.g * N.x)], frame=N)
    assert str(found.eom.accelerations[0]) == "-g*sin(q)/l"


def test_coordinates_between_frames_and_points_without_bodies_are_found():
    """A point mass on a universal joint on a cart: m (ẍ + l …) by the motion of the place itself."""
    x, a, b = me.dynamicsymbols("x a b")
    N, O = me.ReferenceFrame("N"), me.Point("O")
    O.set_vel(N, 0)
    cart = O.locatenew("cart", x * N.x)
    A = N.orientnew("A", "Axis", [a, N.z])
    B = A.orientnew("B", "Axis", [b, A.x])
    C = B.orientnew("C", "Axis", [0.3, B.z])
    P = cart.locatenew("P", models.l * C.y)
    loads = [(P, models.m * models.g * N.y), (cart, -models.k * x * N.x)]
    found = kn.from_sympy_mechanics(
        [me.Particle("c", cart, 2 * models.m), me.Particle("p", P, models.m)], loads, frame=N
    )
    assert list(found.q) == ["a", "b", "x"]
    assert not found.system.inputs
    t, numbers = me.dynamicsymbols._t, {models.m: 2.0, models.l: 0.7, models.g: 9.8, models.k: 5.0}
    place = sympy.Matrix(P.pos_from(O).to_matrix(N))
    energy = (
        models.m * (place.diff(t).dot(place.diff(t)) / 2 + x.diff() ** 2)
        + models.m * models.g * place[1]
        - models.k * x**2 / 2
    )
    state = {a: 0.4, b: -0.5, x: 0.2, a.diff(): 1.1, b.diff(): -0.6, x.diff(): 0.3}
    second = sympy.symbols("a2 b2 x2")
    rows = [energy.diff(q.diff()).diff(t) - energy.diff(q) for q in (a, b, x)]
    rows = [r.subs({q.diff(t, 2): s for q, s in zip((a, b, x), second, strict=True)}).subs(numbers) for r in rows]
    solved = sympy.solve(
        [r.subs({k: v for k, v in state.items() if k.is_Derivative}).subs(state) for r in rows], second
    )
    q, u = ({w.name: state[y] for w, y in zip(some, given, strict=True)} for some, given in (
        (found.system.coordinates, (a, b, x)), (found.system.speeds, (a.diff(), b.diff(), x.diff()))))  # fmt: skip
    p = {s.name: v for s, v in numbers.items()}
    got = found.eom.evaluate([w.dt for w in found.system.speeds], q=q, u=u, parameters=p)
    np.testing.assert_allclose(np.array(got, dtype=float), [float(solved[s]) for s in second], rtol=1e-10)


def test_what_a_model_has_no_use_for_is_refused():
    """Options were dropped without a word: values of no parameter, keywords of lists beside a method."""
    method = models.pendulum()
    (body,), N = method.bodies, method._inertial
    with pytest.raises(ModelError, match=r"values= of parameters of the model, got 'mm'. It has I1, I2, I3, g, l, m."):
        kn.from_sympy_mechanics(method, values={"mm": 1.0})
    with pytest.raises(ModelError, match="a finite number as the value of m, got 'heavy'"):
        kn.from_sympy_mechanics(method, values={models.m: "heavy"})
    made = kn.from_sympy_mechanics(method, values={models.m: sympy.pi / 4, "l": np.array(0.5)}).system
    assert {p.name: p.default for p in made.parameters if p.default} == {"m": np.pi / 4, "l": 0.5}
    for value in (models.l, sympy.I, sympy.oo, [1.0, 2.0]):
        with pytest.raises(ModelError, match="a finite number as the value of m, got"):
            kn.from_sympy_mechanics(method, values={models.m: value})
    with pytest.raises(ModelError, match="keywords for what a KanesMethod does not define, got 'frame'"):
        kn.from_sympy_mechanics(method, frame=N)
    for more, message in (
        ({"qs": []}, "keywords that KanesMethod takes, got 'qs'"),
        ({"bodies": [body]}, "no bodies= beside a list"),
        ({"kd_eqs": [method.u[0]]}, "speeds u= beside kd_eqs=, got none"),
    ):
        with pytest.raises(ModelError, match=message):
            kn.from_sympy_mechanics([body], frame=N, **more)
    with pytest.raises(ModelError, match="bodies in the list, got none"):
        kn.from_sympy_mechanics([], frame=N)


def test_loads_that_are_given_are_those_of_a_system():
    q, u = me.dynamicsymbols("q u")
    N, O = me.ReferenceFrame("N"), me.Point("O")
    O.set_vel(N, 0)
    P = O.locatenew("P", q * N.x)
    P.set_vel(N, u * N.x)
    system = me.System(N, O)
    system.add_bodies(me.Particle("b", P, models.m))
    system.q_ind, system.u_ind, system.kdes = [q], [u], [q.diff() - u]
    found = kn.from_sympy_mechanics(system, [(P, -models.k * q * N.x)])
    assert str(found.eom.accelerations[0]) == "-k*q/m"


def test_an_acceleration_of_another_name_is_told():
    found = kn.from_sympy_mechanics(models.pushed())
    assert "f is the rate of v, in an acceleration given by hand" in found.of_kind("inferred")


@pytest.mark.filterwarnings("ignore::sympy.utilities.exceptions.SymPyDeprecationWarning")
def test_joints_method_and_repr():
    found = kn.from_sympy_mechanics(models.jointed())
    assert repr(found).startswith("Imported(")
    assert "<table>" in found._repr_html_()


def test_a_wrong_angular_velocity_is_shown():
    q, u = me.dynamicsymbols("q u")
    N = me.ReferenceFrame("N")
    O = me.Point("O")
    O.set_vel(N, 0)
    B = N.orientnew("B", "Axis", [q, N.z])
    B.set_ang_vel(N, 2 * u * N.z)
    body = me.RigidBody("b", O, B, models.m, (me.inertia(B, 1, 1, 1), O))
    method = me.KanesMethod(N, [q], [u], kd_eqs=[q.diff() - u])
    method.kanes_equations([body], [(B, N.z)])
    with pytest.raises(ModelError, match=r"angular velocity of B in N that its orientation has.*2\*u\(t\)\*N\.z"):
        kn.from_sympy_mechanics(method)


def test_a_wrong_acceleration_is_shown():
    method = models.velocity_alone()
    q, u = method.q[0], method.u[0]
    N, P = method._inertial, method.bodies[0].point
    P.set_acc(N, (u.diff() + q) * N.x)
    other = me.KanesMethod(N, [q], [u], kd_eqs=[q.diff() - u])
    other.kanes_equations(method.bodies, method.forcelist)
    with pytest.raises(ModelError, match="acceleration that P was given is not the rate"):
        kn.from_sympy_mechanics(other)
    assert kn.from_sympy_mechanics(other, check=False).of_kind("ignored")


def test_matrices_that_were_changed_are_noticed():
    method = models.pendulum()
    method._k_d = 2 * method._k_d
    with pytest.raises(ModelError, match="matrices that were changed"):
        kn.from_sympy_mechanics(method)


@pytest.mark.parametrize(
    ("config", "cause"),
    [(True, "velocity constraints do not include the rates"), (False, "acceleration constraints that were given")],
)
def test_constraints_that_contradict_each_other_are_shown(config, cause):
    with pytest.raises(ModelError, match=cause):
        kn.from_sympy_mechanics(models.uneven(config))


def test_a_velocity_that_contradicts_the_position_is_shown():
    """It is moved by it, as SymPy's equations do, and the remark says so: 4 m u̇ = −2 k q."""
    found = kn.from_sympy_mechanics(models.twice_as_fast())
    (said,) = found.of_kind("changed")
    assert said.startswith("P moves with its velocity 2*u(t)*N.x, which is not the rate of its position from O")
    q, u = found.q["q"], found.u["u"]
    value = found.eom.evaluate(
        u.dt, q=dict.fromkeys(found.system.coordinates, 0.3), u={u: 0.2}, parameters={"m": 2.0, "k": 3.0}
    )
    assert q.name == "q"
    assert float(value) == pytest.approx(-3.0 * 0.3 / (2 * 2.0), rel=1e-12)


def test_what_is_no_model_is_named():
    q, u, f = me.dynamicsymbols("q u f")
    N = me.ReferenceFrame("N")
    with pytest.raises(ModelError, match="Expected a KanesMethod, LagrangesMethod, System or JointsMethod"):
        kn.from_sympy_mechanics(3)
    with pytest.raises(ModelError, match="a KanesMethod with its bodies"):
        kn.from_sympy_mechanics(me.KanesMethod(N, [q], [u], kd_eqs=[q.diff() - u]))
    with pytest.raises(ModelError, match="LagrangesMethod with its bodies"):
        kn.from_sympy_mechanics(me.LagrangesMethod(q.diff() ** 2, [q], frame=N))
    with pytest.raises(ModelError, match="the inertial frame="):
        kn.from_sympy_mechanics([me.Particle("p")])
    method = models.velocity_alone()
    method.kanes_equations(method.bodies, [(method.bodies[0].point, sympy.Function("h")(q) * method._inertial.x)])
    with pytest.raises(ExpressionError, match="functions of the time"):
        kn.from_sympy_mechanics(method)
    assert f not in kn.from_sympy_mechanics(models.pendulum()).symbols

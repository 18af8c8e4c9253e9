# SPDX-License-Identifier: BSD-3-Clause
"""Inverse dynamics as a linear function of inertial parameters: beside Pinocchio, along motions, and what is told by them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.fitting import regressor
from kane.gallery import load
from tests.examples import examples
from tests.oracles import kane_tree
from tests.oracles.tree import random_states, random_tree
from tests.peer import require
from tests.systems.plate import plate

pin = require("pinocchio")
from tests.oracles import pinocchio_tree  # noqa: E402


def unloaded(rng, bodies):
    tree = random_tree(rng, bodies)
    return replace(tree, bodies=tuple(replace(b, force=None, torque=None) for b in tree.bodies))


@pytest.mark.slow
@examples(0.25)
@given(st.integers(1, 5), st.integers(0, 2**32))
def test_inverse_dynamics_and_base_parameters_of_random_trees(bodies, seed):
    """Y π at random accelerations, and the rank of Y, are Pinocchio's."""
    rng = np.random.default_rng(seed)
    tree = unloaded(rng, bodies)
    model = kane_tree.derive(tree)
    r = regressor(model.eom)
    engine, carriers, numbers = pinocchio_tree.model_of(tree)
    data, k = engine.createData(), 3
    q, qdot = random_states(rng, tree, k)
    a = rng.normal(size=q.shape)
    order = model.order
    y = r.at(list(q[order]), list(qdot[order]), list(a[order]))
    forces = np.broadcast_to(r.forces(list(q[order]), list(qdot[order]), list(a[order])), y.shape[:2])
    np.testing.assert_array_equal(forces, 0.0)
    stacked = []
    for i in range(k):
        own = np.zeros((3, engine.nv))
        own[:, numbers] = q[:, i], qdot[:, i], a[:, i]
        wanted = pin.rnea(engine, data, *own)[numbers][order]
        found = y[i] @ r.numbers()
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12 * np.abs(y[i] * r.numbers()).sum(axis=1).max())
    for _ in range(40):
        of_one = pin.computeJointTorqueRegressor(engine, data, *rng.normal(size=(3, engine.nv)))
        stacked.append(np.reshape(of_one, (engine.nv, -1)))  # with one speed it comes as a vector
    bodies_only = [10 * (joint - 1) + i for body, joint in carriers.items() if body >= 0 for i in range(10)]
    whole = np.concatenate(stacked)[:, bodies_only]
    sizes = np.linalg.norm(whole, axis=0)
    seen = sizes > 1e-9 * sizes.max()
    assert r.base(seed=seed % 1000).rank == np.linalg.matrix_rank(whole[:, seen] / sizes[seen], 1e-9)


@pytest.mark.parametrize(
    "name", ["four_bar", "pure_rolling_disk", pytest.param("whipple_bicycle", marks=pytest.mark.slow), "slider_crank"]
)
def test_along_motions(name):
    """Y π = F̃ where equations hold: loops and rolling."""
    system = load(name)
    eom = kn.derive(system.system())
    sol = kn.simulate(eom, (0, 0.3), samples=7, **system.START)
    r = regressor(eom)
    count, n = len(eom.coordinates), len(eom.speeds)
    given = {"t": sol.t, "parameters": sol.parameters, "inputs": {s: f(0.0) for s, f in sol.inputs.items()}}
    accelerations = list(sol.rates()[:, count : count + n].T)
    y, f = (of(list(sol.q.T), list(sol.u.T), accelerations, **given) for of in (r.at, r.forces))
    pi = r.numbers(sol.parameters)
    assert y.shape == (7, len(eom.speeds) - len(eom.dependent_speeds), len(pi))
    terms = np.abs(y * pi).sum(axis=2).max()
    np.testing.assert_allclose(y @ pi, np.broadcast_to(f, y.shape[:2]), rtol=0, atol=1e-11 * terms)


def pendulums():
    """Two rods with torques at their pins."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    q, u = kn.coordinates("q1:3"), kn.speeds("u1:3")
    T = [kn.input("T1"), kn.input("T2")]
    O = kn.Point("O", fixed_in=N)
    A = N.rotate("A", q[0], N.z)
    B = A.rotate("B", q[1], N.z)
    P = O.at("P", 1.0 * A.x)
    m, I, s = kn.parameters("m1:3", 1.0), kn.parameters("I1:3", 0.1), kn.parameters("s1:3", 0.4)
    bodies = [
        kn.RigidBody("a", frame=A, mass_center=O.at("A*", s[0] * A.x), mass=m[0], inertia=kn.inertia(A, 1, 1, I[0])),
        kn.RigidBody("b", frame=B, mass_center=P.at("B*", s[1] * B.x), mass=m[1], inertia=kn.inertia(B, 1, 1, I[1])),
    ]
    loads = [kn.gravity(-g * N.y), kn.Torque(A, T[0] * N.z), kn.Torque(B, T[1] * N.z), kn.Torque(A, -T[1] * N.z)]
    return kn.derive(kn.System(N, bodies=bodies, speeds=dict(zip(u, (x.dt for x in q), strict=True)), loads=loads)), T


def test_parameters_from_a_motion_and_its_torques():
    """Linear least squares for the base parameters give those of the true masses, from a model with others."""
    eom, T = pendulums()
    true = {"m1": 1.3, "m2": 0.7, "I1": 0.21, "I2": 0.05}
    laws = {T[0]: 3 * kn.sin(2.1 * kn.time), T[1]: 2 * kn.cos(3.3 * kn.time)}
    sol = kn.simulate(eom, (0, 4), q=[0.3, -0.5], u=[0, 0], parameters=true, inputs=laws, samples=81)
    r = regressor(eom)
    given = {"inputs": {s: sol[s] for s in T}}
    state = (list(sol.q.T), list(sol.u.T), list(sol.rates()[:, 2:].T))
    base = r.base(near=[0.3, 0.4])
    assert base.rank == 6
    assert "a: m" in base.without or not any(c == "a: m" for c in base.chosen)
    columns = [r.names.index(name) for name in base.chosen]
    y, f = r.at(*state, **given)[:, :, columns].reshape(-1, 6), r.forces(*state, **given).reshape(-1)
    found = np.linalg.lstsq(y, f)[0]
    wanted = base.matrix @ r.numbers(true)
    np.testing.assert_allclose(found, wanted, atol=1e-9)
    assert np.abs(wanted - base.matrix @ r.numbers()).max() > 0.05


def test_of_one_pendulum_by_hand():
    """About the pivot at −s: what is told is I + … of a rod in the plane: three of ten."""
    eom, _ = pendulums()
    assert [n.partition(": ")[2] for n in regressor(eom).names[:10]] == [
        "m", "m c_x", "m c_y", "m c_z", "I_xx", "I_yy", "I_zz", "I_xy", "I_yz", "I_zx",
    ]  # fmt: skip
    base = regressor(eom).base()
    assert set(base.without) == {f"{b}: {x}" for b in "ab" for x in ("m c_z", "I_xx", "I_yy", "I_xy", "I_yz", "I_zx")}
    # about the pins: I + m s², m s + h_x; the masses of b act at the end of a, too
    of = dict(zip(base.names, base.matrix.T, strict=True))
    rows = {name: i for i, name in enumerate(base.chosen)}
    assert of["a: m"][rows["a: I_zz"]] == pytest.approx(-(0.4**2))
    assert of["a: m"][rows["a: m c_x"]] == pytest.approx(0.4)
    assert of["b: m"][rows["a: m c_x"]] == pytest.approx(1.0 - 0.0)


def test_what_has_no_regressor():
    beam = load("flexible_pendulum")
    with pytest.raises(kn.ModelError, match="rigid bodies and particles"):
        regressor(kn.derive(beam.system()))
    with pytest.raises(kn.ModelError, match="loads without reactions"):
        regressor(kn.derive(load("rolling_disk").system()))
    r = regressor(pendulums()[0])
    with pytest.raises(kn.SimulationError, match="got none of u1'"):
        r.at([0, 0], [0, 0], {"u2": 0.0})


def test_bodies_that_there_can_be():
    """Forces with noise give a plate whose least squares no mass has; where these are possible they are what is found."""
    eom, T = plate()
    laws = {t: 0.3 * kn.sin(w * kn.time) for t, w in zip(T, (7.1, 5.3, 6.2), strict=True)}
    sol = kn.simulate(eom, (0, 2), q=[0.3, 0.2, 0], u=[1, 0, 2], inputs=laws, samples=41)
    r, given = regressor(eom), {"inputs": {s: sol[s] for s in T}}
    state = (list(sol.q.T), list(sol.u.T), list(sol.rates()[:, 3:6].T))
    y, f = r.at(*state, **given), r.forces(*state, **given)
    np.testing.assert_allclose(
        r.possible(y, f), r.numbers(), atol=2e-5
    )  # the plate of the model is at the edge, and made thicker
    rng, told = np.random.default_rng(1), [i for i, name in enumerate(r.names) if name != "plate: m"]
    kinds = set()
    for _ in range(3):
        noisy = f + 0.03 * rng.normal(size=f.shape)
        found = r.possible(y, noisy)
        free = r.numbers()
        free[told] = np.linalg.lstsq(y[..., told].reshape(-1, 9), noisy.reshape(-1))[0]
        least = [np.linalg.eigvalsh(pseudo(pi))[0] for pi in (found, free)]
        assert least[0] > 0
        worse = np.sum((y @ found - noisy) ** 2) - np.sum((y @ free - noisy) ** 2)
        if least[1] < -1e-4:
            kinds.add("impossible")
            assert 0 < worse < 0.1 * np.sum((y @ free - noisy) ** 2)
            assert least[0] < 1e-4  # at the edge
            # no possible body is nearer: the slope of the squares rises towards every other
            slope = (y[..., told].reshape(-1, 9).T @ (y @ found - noisy).reshape(-1)) / 0.03**2
            for other in r.numbers() * np.linspace(0.5, 2, 7)[:, None]:
                assert slope @ (other - found)[told] > -1e-3
        elif least[1] > 1e-4:
            kinds.add("possible")
            np.testing.assert_allclose(found[told], free[told], atol=1e-5)
    assert kinds == {"impossible", "possible"}
    with pytest.raises(kn.SimulationError, match="masses above zero"):
        r.possible(y, f, parameters={"m": 0.0})


def pseudo(pi):
    """∫ (r, 1)(r, 1)ᵀ dm of the ten parameters."""
    m, x, y, z, xx, yy, zz, xy, yz, zx = pi
    I = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
    h = np.array([[x], [y], [z]])
    return np.block([[np.trace(I) / 2 * np.eye(3) - I, h], [h.T, np.array([[m]])]])


def test_forces_that_do_not_fit_are_refused():
    """Forces of another shape than the rows of Y, values that are not finite, and zeros alone."""
    N = kn.Frame("N")
    hinge = kn.pin("h", kn.Point("O", fixed_in=N), N, axis=N.z)
    inertia = kn.inertia(hinge.frame, 0.1, 0.2, 0.3)
    rod = kn.RigidBody(
        "rod", frame=hinge.frame, mass_center=hinge.point.at("G", 0.5 * hinge.frame.x), mass=2, inertia=inertia
    )
    r = regressor(kn.derive(kn.System(N, bodies=[rod], joints=[hinge], loads=[kn.gravity(-9.81 * N.y)])))
    y = r.at([np.linspace(0, 1, 9)], [0.2], [0.3])
    with pytest.raises(kn.SimulationError, match="broadcast to one shape"):
        r.at([np.zeros(3)], [np.zeros(2)], [0.0])
    for forces, match in (
        (np.ones((4, 3)), "to one shape"),
        (np.ones(9), r"got the shapes \(9, 1, 10\) and \(9,\)"),
        (np.full((9, 1), np.nan), "finite"),
        (np.zeros((9, 1)), "forces that are not all zero, got only zeros"),
        ("some", "in numbers"),
    ):
        with pytest.raises(kn.SimulationError, match=match):
            r.possible(y, forces)
    with pytest.raises(kn.SimulationError, match="got the shapes"):
        r.possible(np.ones((3, 4)), np.ones(3))


@pytest.mark.parametrize("order", [pytest.param(1, marks=pytest.mark.slow), -1])
def test_base_parameters_do_not_depend_on_the_order_of_dependent_speeds(order):
    """In a parallelogram crank and rocker turn alike, and the coupler does not: motions tell the sum of two moments of inertia."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    (a, b, c), (ua, ub, uc) = kn.coordinates("a b c"), kn.speeds("ua ub uc")
    crank, rocker = N.rotate("A", a, N.z), N.rotate("C", c, N.z)
    coupler = crank.rotate("B", b, N.z)
    A, C = O.at("A", 0.4 * crank.x), O.at("R", N.x).at("C", 0.4 * rocker.x)
    B = A.at("B", 1.0 * coupler.x)
    bodies = [
        kn.RigidBody(name, frame=frame, mass_center=point, mass=1.0, inertia=kn.inertia(frame, 0, 0, 0.1))
        for name, frame, point in (("crank", crank, O), ("coupler", coupler, A), ("rocker", rocker, C))
    ]
    loop = [kn.coincident(B, C, along=axis, name=name) for axis, name in ((N.x, "x"), (N.y, "y"))]
    speeds, dependent = {ua: a.dt, ub: b.dt, uc: c.dt}, (ub, uc)[::order]
    system = kn.System(N, bodies=bodies, speeds=speeds, holonomic=loop, dependent_speeds=dependent)
    base = regressor(kn.derive(system)).base(near={a: 0.9, b: -0.9, c: 0.9})
    (row,) = (k for k, name in enumerate(base.chosen) if name == "crank: I_zz")
    told = dict(zip(base.names, base.matrix[row], strict=True))
    assert told["crank: I_zz"] == pytest.approx(1)
    assert told["rocker: I_zz"] == pytest.approx(1)
    assert told["coupler: I_zz"] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("size", [1e-5, 1.0, 1e4])
def test_base_parameters_in_any_unit_of_length(size):
    """m l² of links of ten micrometres is 10⁻¹⁰ kg m²: it is no rounding beside the mass."""
    N = kn.Frame("N")
    hinge = kn.pin("h", kn.Point("O", fixed_in=N), N, axis=N.z)
    knee = kn.pin("k", hinge.point.at("K", size * hinge.frame.x), hinge.frame, axis=N.z)
    rods = [
        kn.RigidBody(
            name,
            frame=joint.frame,
            mass_center=joint.point.at(f"G{name}", 0.3 * size * joint.frame.x),
            mass=1.0,
            inertia=kn.inertia(joint.frame, 0, 0, 0.1 * size**2),
        )
        for name, joint in (("a", hinge), ("b", knee))
    ]
    eom = kn.derive(kn.System(N, bodies=rods, joints=[hinge, knee], loads=[kn.gravity(-9.81 * N.y)]))
    base = regressor(eom).base()
    units = np.array([size ** {"m": 0, "c": 1, "I": 2}[name.split(": ")[1].split()[-1][0]] for name in base.names])
    chosen = units[[base.names.index(name) for name in base.chosen]]
    rows = dict(zip(base.chosen, base.matrix * units / chosen[:, None], strict=True))
    assert dict(zip(base.names, rows["a: I_zz"], strict=True)) == pytest.approx(
        dict.fromkeys(base.names, 0.0) | {"a: m": -0.09, "a: I_zz": 1.0, "b: m": 0.4}
    )


@pytest.mark.parametrize("units", [(1e-3, 1, 1), (1, 1, 1e-3), (1e3, 1e3, 1e3), (1e-6, 1e-9, 1e-3)])
def test_an_arm_in_other_units(units):
    """As many base parameters, and the same possible bodies from noisy forces, in metres, kilograms, seconds and in others."""

    def told(L, M, T):
        N = kn.Frame("N")
        one = kn.pin("1", kn.Point("O", fixed_in=N), N, axis=N.z)
        two = kn.pin("2", one.point.at("P", 0.8 / L * one.frame.x + 0.1 / L * one.frame.z), one.frame, axis=one.frame.x)
        moments = (0.02, 0.2, 0.21), (0.05, 0.01, 0.055)
        bodies = [
            kn.RigidBody(
                name,
                frame=joint.frame,
                mass_center=joint.point.at(f"C{name}", 0.3 / L * way),
                mass=m / M,
                inertia=kn.inertia(joint.frame, *(x / (M * L**2) for x in own)),
            )
            for name, joint, way, m, own in zip(
                "ab", (one, two), (one.frame.x, two.frame.y), (2, 1), moments, strict=True
            )
        ]
        weight = kn.gravity(-9.81 * T**2 / L * N.z)
        r = regressor(kn.derive(kn.System(N, bodies=bodies, joints=[one, two], loads=[weight])))
        rng = np.random.default_rng(0)
        q, u, a = rng.normal(size=(3, 2, 40))
        y = r.at(list(q), list(u * T), list(3 * a * T**2))
        forces = y @ r.numbers() + 0.05 * rng.normal(size=(40, 2)) * T**2 / (M * L**2)
        kinds = {"m": M, "c": M * L, "I": M * L**2}
        sizes = [kinds[name.split(": ")[1].split()[-1][0]] for name in r.names]
        return r.base().rank, r.possible(y, forces) * sizes

    (rank, bodies), (as_ever, wanted) = told(*units), told(1, 1, 1)
    assert rank == as_ever == 8
    np.testing.assert_allclose(bodies, wanted, rtol=0, atol=1e-7)

# SPDX-License-Identifier: BSD-3-Clause
"""Accelerations of models in Autolev's language against formulas by hand."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.exchange import Imported, from_autolev
from tests.interop.autolev import texts
from tests.peer import require

require("lark")

numbers = st.floats(0.5, 2.0)
angles = st.floats(-3.0, 3.0)


def solved(model: Imported, /, **values: float) -> dict[str, float]:
    """Accelerations and reactions by name."""
    eom = model.eom
    wanted = (*eom.accelerations, *eom.reaction_values)
    names = [s.name for s in (*eom.speeds, *eom.reactions)]
    held = kn.free_symbols(wanted)
    found = kn.evaluate(list(wanted), {s: values[s.name] for s in held})
    return dict(zip(names, map(float, found), strict=True))


MODELS = {name: from_autolev(getattr(texts, name)) for name in dir(texts) if name.isupper()}


@given(angles, angles, numbers, angles)
def test_a_rod_on_a_pin(q: float, u: float, length: float, torque: float) -> None:
    g, m, inertia = 9.81, 1.7, 0.3
    expected = (torque - m * g * length / 2 * np.cos(q)) / (inertia + m * length**2 / 4)
    values = {"theta": q, "omega": u, "L": length, "m": m, "I": inertia, "g": g, "T1": torque}
    assert solved(MODELS["PENDULUM"], **values)["omega"] == pytest.approx(expected, rel=1e-12)
    genesis = {"q": q, "qp": u, "L": length, "m": m, "Izz": inertia, "Ixx": 0.0, "Iyy": 0.0, "g": g, "T1": torque}
    assert solved(MODELS["GENESIS_PENDULUM"], **genesis)["qp"] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("name", "q", "u"), [("PENDULUM", "theta", "omega"), ("GENESIS_PENDULUM", "q", "qp")])
def test_values_of_input(name: str, q: str, u: str) -> None:
    m = MODELS[name]
    start = m.extras["start"]
    assert start.q == {m.q[q]: pytest.approx(np.pi / 6)}
    assert start.u == {m.u[u]: 2.0}
    assert {p: m.parameters[p].default for p in ("g", "L", "m")} == {"g": 9.81, "L": 0.5, "m": 2.0}
    sol = kn.simulate(m.eom, (0, 1), start=start, inputs={"T1": 0})
    assert abs(sol.energy[-1] - sol.energy[0]) < 1e-6


@given(angles, angles, angles, angles, numbers, numbers)
def test_two_strings(q1: float, q2: float, u1: float, u2: float, m1: float, m2: float) -> None:
    g, length = 9.81, 0.7
    c, s = np.cos(q1 - q2), np.sin(q1 - q2)
    mass = np.array([[(m1 + m2) * length**2, m2 * length**2 * c], [m2 * length**2 * c, m2 * length**2]])
    force = [
        -(m1 + m2) * g * length * np.sin(q1) - m2 * length**2 * s * u2**2,
        -m2 * g * length * np.sin(q2) + m2 * length**2 * s * u1**2,
    ]
    found = solved(MODELS["DOUBLE"], q1=q1, q2=q2, u1=u1, u2=u2, m1=m1, m2=m2, g=g, L=length)
    assert [found["u1"], found["u2"]] == pytest.approx(np.linalg.solve(mass, force), rel=1e-10, abs=1e-10)


@given(angles, angles, numbers)
def test_a_tension_by_an_auxiliary_speed(q: float, u: float, length: float) -> None:
    g, m = 9.81, 1.3
    found = solved(MODELS["TENSION"], q=q, u1=u, L=length, m=m, g=g)
    assert found["u1"] == pytest.approx(-g / length * np.sin(q), rel=1e-12, abs=1e-12)
    assert found["R"] == pytest.approx(-m * (length * u**2 + g * np.cos(q)), rel=1e-12)


@given(st.lists(angles, min_size=4, max_size=4), st.lists(angles, min_size=3, max_size=3), angles)
def test_a_body_with_products_of_inertia(e: list[float], w: list[float], torque: float) -> None:
    j = [2.0, 3.0, 4.0, 0.1, -0.2, 0.3]
    inertia = np.array([[j[0], j[3], j[5]], [j[3], j[1], j[4]], [j[5], j[4], j[2]]])
    known: dict[str, Any] = {f"w{k}": x for k, x in enumerate(w, 1)} | {f"J{k}": x for k, x in enumerate(j, 1)}
    known |= {"Tx": torque}
    free = np.linalg.solve(inertia, -np.cross(w, inertia @ w))
    blind = solved(MODELS["BLIND"], **known)
    assert [blind[f"w{k}"] for k in (1, 2, 3)] == pytest.approx(free, rel=1e-12, abs=1e-12)
    size = float(np.linalg.norm(e))
    if size < 0.1:
        return
    a, b, c, d = np.array(e) / size
    column = np.array([1 - 2 * (b * b + c * c), 2 * (a * b - c * d), 2 * (c * a + b * d)])  # n1 along b1, b2, b3
    turned = np.linalg.solve(inertia, torque * column - np.cross(w, inertia @ w))
    known |= {f"e{k}": x for k, x in enumerate((a, b, c, d), 1)}
    found = solved(MODELS["SPIN"], **known)
    assert [found[f"w{k}"] for k in (1, 2, 3)] == pytest.approx(turned, rel=1e-12, abs=1e-12)


@given(angles, angles, angles)
def test_a_motion_constraint(q3: float, speed: float, u3: float) -> None:
    g = 9.81
    c, s = np.cos(q3), np.sin(q3)
    found = solved(MODELS["SKATE"], q1=0, q2=0, q3=q3, u1=speed * c, u2=speed * s, u3=u3, m=2.0, J=0.3, g=g)
    forward = g * c  # along the blade; across it v u3
    assert found["u1"] == pytest.approx(forward * c - speed * u3 * s, rel=1e-9, abs=1e-9)
    assert found["u2"] == pytest.approx(forward * s + speed * u3 * c, rel=1e-9, abs=1e-9)
    assert found["u3"] == pytest.approx(0, abs=1e-12)


@given(angles, angles, st.floats(0, 3))
def test_a_support_that_is_moved(q: float, u: float, t: float) -> None:
    g, length, h, f = 9.81, 0.8, 0.2, 3.0
    found = solved(MODELS["DRIVEN"], q=q, u=u, L=length, m=1.1, g=g, h=h, f=f, t=t)
    lifted = g - h * f**2 * np.sin(f * t)
    assert found["u"] == pytest.approx(-lifted / length * np.cos(q), rel=1e-10, abs=1e-10)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("ignored", "code: no part of the model"),
        ("ignored", "autoz: no part of the model"),
        ("read", "1 body, 1 coordinate, 1 speed"),
    ],
)
def test_remarks_say_what_became_of_a_line(kind: Any, expected: str) -> None:
    assert any(text.startswith(expected) for text in MODELS["PENDULUM"].of_kind(kind))


def test_what_is_inferred_is_said() -> None:
    assert any("no orientation" in text for text in MODELS["BLIND"].of_kind("inferred"))


@given(angles, angles, angles, angles, angles)
def test_a_wheel_that_is_not_oriented(a: float, b: float, c: float, s: float, torque: float) -> None:
    i, j = (2.0, 3.0, 4.5), 0.4
    known = {"w1": a, "w2": b, "w3": c, "s": s, "m": 1.0, "J": j, "T1": torque} | {
        f"I{k}": x for k, x in enumerate(i, 1)
    }
    h = j * (a + s)
    expected = {
        "w1": (-torque - (i[2] - i[1]) * b * c) / i[0],
        "w2": (-(i[0] - i[2]) * a * c - h * c) / i[1],
        "w3": (-(i[1] - i[0]) * a * b + h * b) / i[2],
    }
    expected["s"] = torque / j - expected["w1"]
    assert solved(MODELS["GYROSTAT"], **known) == pytest.approx(expected, rel=1e-10, abs=1e-10)


@given(numbers, numbers, angles, angles)
def test_springs_and_dampers_of_motiongenesis(x: float, y: float, u1: float, u2: float) -> None:
    k, b, length, m = 7.0, 0.6, 0.4, 1.3
    known = {"x": x, "y": y, "q": 0.2, "u1": u1, "u2": u2, "u3": 0.3, "k": k, "b": b, "L": length, "m": m, "J": 0.5}
    r = np.array([x, y])
    size = np.linalg.norm(r)
    pull = -(k * (size - length) + b * (r @ [u1, u2]) / size) / size / m * r
    assert solved(MODELS["GENESIS_SPRING"], **known) == pytest.approx({"u1": pull[0], "u2": pull[1], "u3": 3.0})


def test_what_places_nothing_is_a_state() -> None:
    model = MODELS["GYROSTAT"]
    (x,) = model.system.states
    rate = model.eom.state_rates[0]
    assert x.name == "x"
    assert x.default == 2.0
    assert kn.evaluate(rate, {s: {"w1": 3.0, "w2": 0.5}[s.name] for s in kn.free_symbols([rate])}) == 4.0


def declared_disk() -> kn.System:
    """The rolling disk of `ROLLING`, declared here."""
    A = kn.Frame("A")
    H, L, theta, x, y = kn.coordinates("H L theta x y")
    wx, wy, wz, xp, yp = kn.speeds("wx wy wz xp yp")
    g, m, r, axial, across = kn.parameters("g m r I J")
    B = A.rotate("B", H, A.z)
    C = B.rotate("C", -L, B.x)
    D = C.rotate("D", theta, C.y)
    trace = kn.Point("O", fixed_in=A).at("P", x * A.x + y * A.y)
    center = trace.at("Dcm", r * C.z)
    w = D.angular_velocity(A)
    contact = center.fixed_in(D, "DA", -r * C.z).velocity(A)
    inertia = kn.inertia(C, across, axial, across)
    return kn.System(
        A,
        bodies=[kn.RigidBody("D", frame=D, mass_center=center, mass=m, inertia=inertia)],
        loads=[kn.gravity(-g * A.z)],
        speeds={wx: w.dot(C.x), wy: w.dot(C.y), wz: w.dot(C.z), xp: x.dt, yp: y.dt},
        nonholonomic=[kn.motion_constraint(f"roll {k}", contact.dot(n)) for k, n in enumerate((A.x, A.y))],
        dependent_speeds=(xp, yp),
    )


DISK = kn.derive(declared_disk())


@given(angles, st.floats(-1.0, 1.0), angles, angles, angles)
def test_a_disk_that_rolls(turn: float, lean: float, a: float, b: float, c: float) -> None:
    at: dict[str, Any] = {
        "q": {"H": turn, "L": lean, "theta": 0.4, "x": 0.0, "y": 0.0},
        "u": {"wx": a, "wy": b, "wz": c},
        "parameters": {"g": 9.8, "m": 2.0, "r": 0.3, "I": 0.11, "J": 0.07},
    }
    both = []
    for eom in (MODELS["ROLLING"].eom, DISK):
        named = dict(zip((u.name for u in eom.speeds), eom.accelerations, strict=True))
        wanted = [named[x] for x in ("wx", "wy", "wz", "xp", "yp")]
        both.append([float(x) for x in eom.evaluate(wanted, **at)])
    assert both[0] == pytest.approx(both[1], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("told", "count"), [("Dt(V_BO_N>, N)", 0), ("2*Dt(V_BO_N>, N)", 1)])
def test_accelerations_that_contradict_velocities_are_said(told: str, count: int) -> None:
    model = from_autolev(texts.PENDULUM.replace("Mass B = m", f"A_BO_N> = {told}\nMass B = m"))
    assert len(model.of_kind("changed")) == count


def test_units_of_another_system_and_degrees() -> None:
    text = texts.PENDULUM.replace("autoz on", "UnitSystem slug, ft, sec").replace("L = 50 cm", "L = 12 inch")
    m = from_autolev(text.replace("m = 2 kg", "m = 2 slug"))
    assert m.parameters["L"].default == pytest.approx(1.0, rel=1e-14)
    assert m.parameters["m"].default == pytest.approx(2.0, rel=1e-14)


def test_command_files_beside_a_file(tmp_path: Any) -> None:
    (tmp_path / "hinge.a").write_text("Simprot(#1#, #2#, 3, #3#)\nW_#2#_#1#> = #3#'*#1#3>\n")
    (tmp_path / "rod.al").write_text(
        texts.PENDULUM.replace("Simprot(N, B, 3, theta)\n", "").replace("W_B_N> = omega*N3>", "hinge(N, B, theta)")
    )
    values = {"theta": 0.3, "omega": 1.0, "L": 0.5, "m": 2.0, "I": 0.1, "g": 9.81, "T1": 0.2}
    found = solved(from_autolev(tmp_path / "rod.al"), **values)
    assert found == pytest.approx(solved(MODELS["PENDULUM"], **values), rel=1e-14)

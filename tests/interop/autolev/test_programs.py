# SPDX-License-Identifier: BSD-3-Clause
"""Programs with what users write around a model: accelerations against formulas by hand, and what is said of what was changed."""

from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import kane as kn
from kane import ModelError
from kane.exchange import Imported, from_autolev
from tests.interop.autolev import programs, texts
from tests.peer import require

require("lark")

numbers = st.floats(0.5, 2.0)
angles = st.floats(-3.0, 3.0)
TEXTS = {name: getattr(programs, name) for name in dir(programs) if name.isupper()}
AT_ONCE = ("Dynamics[1] =", "SolveDt( Loop = 0, qB )\nDynamics[1] ="), ("[Dynamics; LoopDtDt]", "Dynamics")
TEXTS["LOOP_AT_ONCE"] = reduce(lambda text, change: text.replace(*change), AT_ONCE, programs.LOOP)
TEXTS["LEG_OUTSIDE_IN"] = programs.LEG.replace("Bodies T, E, F", "Bodies F, E, T")
MODELS = {name: from_autolev(text) for name, text in TEXTS.items()}


def solved(model: Imported, /, **values: float) -> dict[str, float]:
    """Accelerations and reactions by name; parameters that are not given have their defaults."""
    eom = model.eom
    wanted = (*eom.accelerations, *eom.reaction_values)
    held = kn.free_symbols(wanted)
    at = {s: values.get(s.name, s.default) for s in held}
    found = kn.evaluate(list(wanted), at)
    return dict(zip([s.name for s in (*eom.speeds, *eom.reactions)], map(float, found), strict=True))


@given(angles, angles)
def test_a_cart_whose_program_ends_with_quit(v: float, w: float) -> None:
    radius, b, a, mass, m, axial, across, drag = 0.35, 0.75, 1.6, 640.0, 30.0, 2.0, 1.0, 3.0
    found = solved(MODELS["CART"], v=v, w=w, A_angle=0.3)
    forward = mass + 2 * m + 2 * axial / radius**2
    turning = mass * a**2 / 12 + mass * a**2 + 2 * (m + axial / radius**2) * b**2 + 2 * across
    assert found["v"] == pytest.approx((mass * a * w**2 - drag * mass * v) / forward, rel=1e-10, abs=1e-10)
    assert found["w"] == pytest.approx(-mass * a * v * w / turning, rel=1e-10, abs=1e-10)
    assert found["wB"] == pytest.approx((found["v"] + b * found["w"]) / radius, rel=1e-9, abs=1e-9)


@given(angles, angles, angles, numbers)
def test_what_is_no_generalized_speeds_coordinate_is_prescribed(q: float, u: float, rate: float, length: float) -> None:
    model, m, inertia = MODELS["ARM"], 1.3, 0.7
    found = solved(model, **{"qB": q, "qB'": rate, "qAp": u, "L": length, "I": inertia, "m": m})
    moment = m * length**2
    expected = -2 * moment * np.sin(q) * np.cos(q) * rate * u / (inertia + moment * np.sin(q) ** 2)
    assert found == pytest.approx({"qAp": expected}, rel=1e-10, abs=1e-10)
    assert {x.text.split()[0] for x in model.remarks if x.kind == "inferred"} == {"Acm", "Bcm", "qB"}


@given(angles, angles, angles, numbers)
def test_a_body_turns_from_an_orientation_that_stands_still(a: float, b: float, c: float, drag: float) -> None:
    i = (2.0, 3.0, 4.5)
    known = {"wx": a, "wy": b, "wz": c, "c": drag} | {f"I{k}": x for k, x in enumerate(i, 1)}
    found = solved(MODELS["TUMBLING"], **known)
    torque = np.array([-drag * a, 0, 0]) - np.cross([a, b, c], np.multiply(i, [a, b, c]))
    assert [found[f"w{k}"] for k in "xyz"] == pytest.approx(torque / i, rel=1e-10, abs=1e-10)


@given(angles, numbers, numbers)
def test_points_go_with_a_mass_centre_that_moves_as_told(q: float, length: float, c: float) -> None:
    h, m, inertia, force = 0.3, 1.4, 0.6, 5.0
    known = {"q": q, "qp": 0.7, "L": length, "h": h, "c": c, "F": force, "I": inertia, "m": m}
    expected = force * (length - h) * np.cos(q) / (m * c**2 + inertia)
    assert solved(MODELS["GIVEN_CENTRE"], **known)["qp"] == pytest.approx(expected, rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("name", ["LOOP", "LOOP_AT_ONCE"])
@given(st.floats(0.2, 1.2), angles)
def test_a_loop_among_equations_that_are_solved(name: str, q: float, u: float) -> None:
    model = MODELS[name]
    assert [x.name for x in model.system.inputs] == ["Fx"]  # which nobody solves for
    assert any(x.startswith("Fy are constraint forces") for x in model.of_kind("changed"))
    qa, qb, ua = q, np.pi - q, u
    ub = ua * np.cos(qa) / np.cos(qb)
    found = solved(model, qA=qa, qB=qb, qAp=ua, qBp=ub, Fx=0.0)
    g, length, masses = 9.81, 1.0, np.array([2.0, 3.0])
    mass = np.diag(masses * length**2 / 3)
    row = length * np.array([np.cos(qa), -np.cos(qb)])
    right = np.append(-masses * g * length / 2 * np.cos([qa, qb]), length * (np.sin(qa) * ua**2 - np.sin(qb) * ub**2))
    whole = np.linalg.solve(np.block([[mass, row[:, None]], [row[None, :], np.zeros((1, 1))]]), right)
    assert [found["qAp"], found["qBp"]] == pytest.approx(whole[:2], rel=1e-8, abs=1e-8)


def test_coordinates_with_one_prime_and_values_in_mass() -> None:
    model = MODELS["STRINGS"]
    assert {p: model.parameters[p].default for p in ("mP", "mQ", "length")} == {"mP": 10.0, "mQ": 20.0, "length": 2.0}
    found = solved(model, q1=0.3, q2=0.3, q1p=0.0, q2p=0.0, g=9.81)
    assert found == pytest.approx({"q1p": -9.81 / 2 * np.sin(0.3), "q2p": 0.0}, abs=1e-12)


@pytest.mark.parametrize("name", ["LEG", "LEG_OUTSIDE_IN"])
@given(angles, angles, st.lists(st.floats(-2, 2), min_size=4, max_size=4))
def test_torques_of_prescribed_joints(name: str, e: float, f: float, rates: list[float]) -> None:
    """Against Newton and Euler: a force on the mass centre of all is one on each body by its share of the mass."""
    m, inertia, length, g, pull = np.array([1.5, 2.0, 0.7]), (0.2, 0.1), 0.4, 9.81, 3.0
    e1, f1, e2, f2 = rates
    known = dict(zip(("EA", "FA", "EA'", "FA'", "EA''", "FA''"), (e, f, e1, f1, e2, f2), strict=True))
    known |= {"mT": m[0], "mE": m[1], "mF": m[2], "JE": 0.2, "JF": 0.1, "L": length, "g": g, "pull": pull, "u1": 0.5}
    found = solved(MODELS[name], **known)

    def swing(angle: float, rate: float, change: float) -> Any:
        c, s = np.cos(angle), np.sin(angle)
        return change * np.array([-s, c]) - rate**2 * np.array([c, s])

    ae, af = swing(e, e1, e2), swing(e + f, e1 + f1, e2 + f2)
    base = np.array([found["u1"], 0.0])
    rise = np.array([0, pull / m.sum() - g])
    fe, ff = m[1] * (base + length * ae - rise), m[2] * (base + 2 * length * ae + length * af - rise)
    arm_e, arm_f = (length * np.array([np.cos(x), np.sin(x)]) for x in (e, e + f))
    knee = inertia[1] * (e2 + f2) + np.linalg.det([arm_f, ff])
    hip = knee + inertia[0] * e2 + np.linalg.det([arm_e, fe]) + np.linalg.det([2 * arm_e, ff])
    assert [found["SH"], found["SK"]] == pytest.approx([hip, knee], rel=1e-9, abs=1e-9)


def test_values_that_no_body_has_are_left_out() -> None:
    model = MODELS["PLACEHOLDERS"]
    assert model.parameters["Ixx"].default is None
    assert any("no valid inertia" in x for x in model.of_kind("changed"))
    assert len(model.eom.accelerations) == 3


@given(angles, angles, numbers)
def test_coordinates_that_auxiliary_speeds_alone_change_stand_still(q: float, u: float, length: float) -> None:
    model, g, m, inertia = MODELS["BASE"], 9.81, 1.3, 0.2
    assert {"q1", "q2"} <= model.parameters.keys()
    known = {"q1": 0.4, "q2": -0.7, "q3": q, "u3": u, "m": m, "g": g, "L": length, "IA": inertia}
    found, arm = solved(model, **known), 2 * length
    c, s = np.cos(q), np.sin(q)
    change = -m * g * arm * c / (inertia + m * arm**2)
    expected = {
        "u3": change,
        "Rx": -m * arm * (s * change + c * u**2),
        "Ry": m * (g + arm * (c * change - s * u**2)),
    }
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-10)


@given(st.floats(-2.5, 2.5), angles, numbers)
def test_an_orientation_by_rodrigues_parameters(q: float, u: float, length: float) -> None:
    g, m, inertia, axis = 9.81, 1.3, np.array([0.3, 0.5, 0.6]), np.array([0.48, -0.6, 0.64])
    known = {"q": q, "u": u, "m": m, "g": g, "L": length}
    known |= {f"{n}{k}": float(x) for n, v in (("I", inertia), ("a", axis)) for k, x in enumerate(v, 1)}
    arm = Rotation.from_rotvec(q * axis).apply([length, 0, 0])
    moment = axis @ np.cross(arm, [0, 0, -m * g])
    about = axis @ (inertia * axis) + m * np.sum(np.cross(axis, arm) ** 2)
    assert solved(MODELS["OBLIQUE"], **known) == pytest.approx({"u": moment / about}, rel=1e-9, abs=1e-9)


@given(angles, angles, st.lists(angles, min_size=4, max_size=4).filter(lambda e: np.linalg.norm(e) > 0.1))
def test_an_orientation_by_direction_cosines(a: float, b: float, e: list[float]) -> None:
    i, force, w = np.array([0.3, 0.5, 0.6]), 1.7, np.array([a, b, 0.4])
    e = list(e / np.linalg.norm(e))
    known = {f"{n}{k}": float(x) for n, v in (("I", i), ("w", w), ("B_e", e)) for k, x in enumerate(v, 1)}
    c = Rotation.from_quat(e).as_matrix()
    torque = force * (c[0] + c[1, 0] * c[1])
    expected = dict(zip(("w1", "w2", "w3"), (torque - np.cross(w, i * w)) / i, strict=True))
    assert solved(MODELS["COSINES"], F=force, **known) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_file_may_run_another_one_beside_it(tmp_path: Path) -> None:
    lines = texts.PENDULUM.splitlines(keepends=True)
    (tmp_path / "first.al").write_text("".join(lines[:10]))
    (tmp_path / "whole.al").write_text("RUN some/folder/First.al\n" + "".join(lines[10:]))
    whole, parts = from_autolev(texts.PENDULUM), from_autolev(tmp_path / "whole.al")
    assert [str(e) for e in parts.eom.accelerations] == [str(e) for e in whole.eom.accelerations]
    (tmp_path / "ring.al").write_text("Run ring.al\n" * 3)
    with pytest.raises(ModelError, match="deep"):
        from_autolev(tmp_path / "ring.al")

# SPDX-License-Identifier: BSD-3-Clause
"""URDF as systems: against Pinocchio, and what is kept, renamed and ignored."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import kane as kn
from tests.examples import examples
from tests.interop.robots.texts import ARM, numbers, urdf
from tests.peer import require

require("defusedxml")
require("pinocchio")
from tests.oracles import robots  # noqa: E402

KINDS = ("revolute", "continuous", "prismatic", "fixed", "planar", "floating")


def check(text: str, seed: int, free: bool = False, **options: object) -> None:
    model = kn.from_urdf(text, base="free" if free else "fixed", **options)
    assert robots.compare(text, model, kn.derive(model.system), np.random.default_rng(seed), 2, free) < 1


@examples(0.8)
@given(
    st.lists(st.sampled_from(KINDS), min_size=1, max_size=6).filter(lambda kinds: set(kinds) != {"fixed"}),
    st.integers(0, 999),
    st.booleans(),
    st.booleans(),
    st.sampled_from(["none", "masses", "all"]),
)
def test_random_trees_move_as_pinocchio_says(kinds, seed, plain, mimic, parameters):
    check(urdf(kinds, np.random.default_rng(seed), plain=plain, mimic=mimic), seed, parameters=parameters)


def quaternion(found: re.Match[str]) -> str:
    """Roll, pitch and yaw as a quaternion of any length, the scalar last."""
    return f'quat_xyzw="{numbers(3 * Rotation.from_euler("xyz", np.fromstring(found[1], sep=" ")).as_quat())}"'


@pytest.mark.parametrize("plain", [False, True])
def test_quaternions_of_origins_turn_as_angles_do(plain):
    """They were ignored without a word: nothing was turned."""
    text = urdf(["revolute", "prismatic", "planar"], np.random.default_rng(4), plain=plain)
    model = kn.from_urdf(re.sub(r'rpy="([^"]*)"', quaternion, text))
    assert robots.compare(text, model, kn.derive(model.system), np.random.default_rng(1), 2, False) < 1


def test_attributes_that_are_not_read_are_said():
    text = ARM.replace('damping="0.1"', 'damping="0.1" armature="0.3"').replace(
        "<robot ", '<robot xmlns="urdf" xmlns:a="b" '
    )
    said = kn.from_urdf(text).of_kind("ignored")
    assert set(said) - set(kn.from_urdf(ARM).of_kind("ignored")) == {"armature= of <dynamics>"}


@pytest.mark.parametrize("plain", [False, True])
def test_an_arm_of_seven_joints_and_a_free_tree(plain):
    rng = np.random.default_rng(7)
    check(urdf(["revolute"] * 7, rng, chain=True, plain=plain), 1)
    check(urdf(["revolute"] * 6, rng, plain=plain), 2, free=True)


@pytest.mark.slow
def test_a_tree_of_thirty_joints():
    check(urdf(["revolute"] * 30, np.random.default_rng(30)), 3, parameters="masses")


def test_what_is_no_mechanics_is_kept():
    arm = kn.from_urdf(ARM)
    assert dict(arm.extras["limits"]) == {"shoulder": (-1.5, 1.5), "elbow": (0, 2.5)}
    assert dict(arm.extras["efforts"]) == {"shoulder": 40, "elbow": 20}
    assert set(arm.extras["rates"].values()) == {2}
    seen, touched = arm.extras["shapes"]
    assert (seen.link, seen.kind, seen.size, seen.color) == ("upper arm", "cylinder", (0.03, 0.5), (0.5, 0.5, 0.5, 1))
    assert seen.rotation == ((0, 0, 1), (0, 1, 0), (-1, 0, 0))
    assert seen.offset == (0.25, 0, 0)
    assert (touched.use, touched.file) == ("collision", "package://arm/upper.stl")
    assert arm.extras["links"]["upper arm"] == "upper_arm"
    assert arm.system["upper_arm"].mass.default == 2
    said = {(r.kind, r.where) for r in arm.remarks}
    assert {("ignored", "URDF, line 21"), ("ignored", "URDF, line 22"), ("inferred", "URDF, line 5")} <= said
    assert "upper_arm" in repr(arm)
    assert list(arm.symbols)[:2] == ["q_shoulder", "q_elbow"]


def test_prefixes_without_a_namespace_are_read():
    text = ARM.replace('<gazebo reference="forearm"/>', "<gazebo><sensor:camera/></gazebo><ray:sensor/>")
    assert [r.text for r in kn.from_urdf(text).remarks if r.kind == "ignored"][1:] == ["<gazebo>", "<ray:sensor>"]


def test_numbers_are_parameters_as_asked():
    every, masses, none = (kn.from_urdf(ARM, parameters=p) for p in ("all", "masses", "none"))
    assert not none.parameters
    assert set(masses.parameters) == {"m_upper_arm", "m_forearm", "g"}
    assert every.parameters["c_x_forearm"].default == 0.2
    assert every.parameters["I_yy_forearm"].unit == "kg*m^2"
    state = {"q": {"q_shoulder": 0.3, "q_elbow": 0.7}, "u": {"u_shoulder": 1, "u_elbow": -2}}
    effort = {"inputs": {"tau_shoulder": 1, "tau_elbow": 2}}
    found = [kn.derive(m.system) for m in (every, masses, none)]
    values = [np.array(eom.evaluate(list(eom.accelerations), **state, **effort), dtype=float) for eom in found]
    np.testing.assert_allclose(values[0], values[2], rtol=1e-13)
    np.testing.assert_allclose(values[1], values[2], rtol=1e-13)


def test_limits_and_friction_act_on_request():
    arm = kn.from_urdf(ARM, stops=True, friction=True, efforts=False)
    assert [c.name for c in arm.system.contacts] == [
        "shoulder lower", "shoulder upper", "elbow lower", "elbow upper", "stiction in elbow"
    ]  # fmt: skip
    assert not arm.system.inputs
    assert not kn.from_urdf(ARM).system.contacts
    (upper,) = (c for c in arm.system.contacts if c.name == "shoulder upper")
    assert kn.evaluate(upper.gap.expr, {arm.q["q_shoulder"]: 1.2}) == pytest.approx(0.3)


@pytest.mark.slow
def test_an_arm_falls_to_its_limit_and_no_further():
    fallen = kn.from_urdf(ARM, parameters="none", stops=True, locked=["elbow"], efforts=False)
    end = kn.simulate(kn.derive(fallen.system), (0, 1), q=[1.2], u=[0])
    assert np.max(end["q_shoulder"]) == pytest.approx(1.5, abs=1e-9)


@pytest.mark.slow
def test_dry_friction_holds_a_joint_and_lets_it_go():
    """Its size is a number without a unit beside a torque that has one."""
    arm = kn.from_urdf(ARM, friction=True)
    given = {"q": [0, 0], "u": [0, 0], "inputs": {"tau_shoulder": 0, "tau_elbow": 0}}
    motion = kn.simulate(kn.derive(arm.system), (0, 1), **given)
    assert motion.t[-1] == 1, motion
    held = np.abs(motion["u_elbow"]) < 1e-9
    assert held.any()
    assert not held.all()


def test_locked_joints_and_damping():
    stiff = kn.from_urdf(ARM, locked=["elbow"])
    assert list(stiff.u) == ["u_shoulder"]
    M = kn.derive(stiff.system).mass_matrix
    assert kn.evaluate(M[0, 0], {s: s.default for s in stiff.parameters.values()}) == pytest.approx(
        2 * 0.25**2 + 0.05 + 0.7**2 + 0.02
    )
    damped, free = (kn.derive(kn.from_urdf(ARM, damping=d).system) for d in (True, False))
    state = {"q": [0, 0], "u": [0, 1], "inputs": {"tau_shoulder": 0, "tau_elbow": 0}}
    a, b = (np.array(eom.evaluate(list(eom.forcing), **state), dtype=float) for eom in (damped, free))
    np.testing.assert_allclose(a - b, [0, -0.1], atol=1e-14)


def test_right_angles_are_exact():
    """An origin turned by 1.57079632679 rad leaves zeros; one turned by 1.5708 does where that is asked for."""
    text = ARM.replace('<origin xyz="0.5 0 0"/>', '<origin xyz="0.5 0 0" rpy="1.5708 0 0"/>').replace(
        'elbow" type="revolute', 'elbow" type="continuous'
    )
    models = [kn.derive(kn.from_urdf(text, right_angles=x).system) for x in (1e-10, 1e-5)]
    rounded, exact = (kn.expr.count_operations(list(eom.accelerations)) for eom in models)
    assert exact.total < rounded.total

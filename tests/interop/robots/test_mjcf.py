# SPDX-License-Identifier: BSD-3-Clause
"""MJCF as systems: small models of each thing that is read, against MuJoCo's M, bias, forces and Jacobians."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kane as kn
from tests.interop.robots.texts import MODELS, mjcf, rod
from tests.peer import require

require("defusedxml")
mujoco = require("mujoco")
from tests.oracles import mujoco_robots  # noqa: E402


@pytest.mark.parametrize("name", MODELS)
def test_models_move_as_mujoco_says(name, rng):
    text = MODELS[name]
    read = kn.from_mjcf(text, parameters="none" if name == "tilted gravity" else "all")
    with warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", "The constraint 'equality_0 y' is always satisfied", kn.KaneWarning
        )  # in the plane
        eom = kn.derive(read.system)
    assert mujoco_robots.compare(mujoco.MjModel.from_xml_string(text), read, eom, rng, 3) < 1
    assert all(r.kind != "refused" for r in read.remarks)


@pytest.mark.parametrize("name", ["tree", "weld"])
def test_a_motion_starts_where_the_file_places_bodies(name):
    """Free bodies, too: they were at the origin, along its axes."""
    model, read = mujoco.MjModel.from_xml_string(MODELS[name]), kn.from_mjcf(MODELS[name])
    data = mujoco.MjData(model)
    for j, joint in enumerate(read.extras["joints"].values()):
        own = [read.extras["start"].q[q] for q in read.system[joint].coordinates]
        values, _ = mujoco_robots.values(model, data, j)
        np.testing.assert_allclose([getattr(x, "value", x) for x in own], values, rtol=1e-15)


def test_what_is_soft_and_what_is_left_out_is_said():
    body = rod("first", '<joint name="a" range="-1 1" limited="true" frictionloss="0.2"/>', '<site name="s"/>')
    more = '<actuator><motor name="jet" site="s" gear="1 0 0 0 0 0"/></actuator><sensor><jointpos joint="a"/></sensor>'
    more += (
        '<equality><joint joint1="a" polycoef="0.1" active="false"/></equality><keyframe><key qpos="0.3"/></keyframe>'
    )
    with pytest.warns(kn.KaneWarning, match="got 1 without one, the first: refused: actuator 'jet': transmission site"):
        read = kn.from_mjcf(mjcf(body, more), stops=True, friction=True)
    said = {r.text for r in read.remarks if r.kind == "ignored"}
    assert {
        "1 sensors",
        "1 keyframes: a motion starts at the reference pose",
        "contacts of 1 geoms: declare them by kn.contact",
        "the equality 'equality_0', which is not active",
    } == said
    assert [c.name for c in read.system.contacts] == ["a lower", "a upper", "stiction in a"]
    assert read.extras["limits"]["a"] == (-1, 1)
    closed = kn.from_mjcf(MODELS["four-bar"])
    assert any(r.text == "the equality 'equality_0' is soft in MuJoCo, and exact in kane" for r in closed.remarks)
    assert [r.where for r in read.remarks if r.kind == "refused"] == ["MJCF, line 1"]


def test_options_that_disable_what_acts_here_are_refused():
    """They were said among what counts for nothing."""
    text = MODELS["tree"].replace(
        "<option ", '<option><flag spring="disable" contact="disable" gravity="disable"/></option><option '
    )
    with pytest.warns(kn.KaneWarning, match="<option> disables spring"):
        read = kn.from_mjcf(text)
    assert read.of_kind("refused") == ("<option> disables spring",)
    assert "<option> disables contact" in read.of_kind("ignored")


LIMITED = rod("first", '<joint name="a" axis="0 1 0" actuatorfrcrange="-0.4 0.4" actuatorgravcomp="true"/>', '<site name="s"/>',
              more='gravcomp="1"')  # fmt: skip
PULLED = '<tendon><spatial name="g"><site site="s"/><site site="t"/></spatial></tendon>'
PULLED += '<actuator><motor name="m" tendon="g"/></actuator>'


@pytest.mark.parametrize(
    ("body", "more", "said"),
    [
        (LIMITED, '<actuator><motor joint="a"/></actuator>', ["compensation of gravity by actuators"]),
        (LIMITED.replace("actuatorfrcrange", "user"), "", ["compensation of gravity by actuators"]),
        (LIMITED.replace('gravcomp="1"', "") + '<site name="t" pos="1 0 1"/>', PULLED, ["without that of 'm' along its tendon"]),
        (LIMITED.replace("<site", '<site name="t" pos="1 0 0"/><site'), PULLED, ["compensation of gravity by actuators"]),
    ],
)  # fmt: skip
def test_limits_of_actuators_that_bound_more_than_is_read_are_refused(body, more, said):
    """MuJoCo bounds the sum of all that actuators exert on a joint; a tendon between two points of one body exerts nothing on it."""
    with pytest.warns(kn.KaneWarning, match=f"got {len(said)} without one, the first"):
        read = kn.from_mjcf(mjcf(body, more))
    refused = read.of_kind("refused")
    assert len(refused) == len(said)
    assert all(text in told for text, told in zip(said, refused, strict=True))


@pytest.mark.parametrize("timeout", [0, -1.0, "soon", float("nan")])
def test_times_that_are_none_are_named(timeout):
    with pytest.raises(kn.ModelError, match="timeout= as seconds above zero"):
        kn.from_mjcf(MODELS["tree"], timeout=timeout)


def test_a_time_may_be_longer_than_systems_count():
    assert kn.from_mjcf(MODELS["tree"], timeout=1e12).system.bodies


def test_tendons_are_ropes_on_request():
    read = kn.from_mjcf(MODELS["tendons"], stops=True)
    (taut,) = read.system.contacts
    assert taut.name == "g"
    assert taut.gap is not None


@pytest.mark.slow
def test_a_pendulum_swings_as_in_mujoco():
    """Steps of MuJoCo's RK4 at 1e-4 s against `simulate`."""
    text = mjcf(rod("first", '<joint name="a" axis="0 1 0"/>', rod("second", '<joint name="b" axis="0 1 0"/>', at="0.4 0 0")),
                option='timestep="0.0005" integrator="RK4"')  # fmt: skip
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = 0.3, -0.5
    for _ in range(1000):
        mujoco.mj_step(model, data)
    eom = kn.derive(kn.from_mjcf(text).system)
    end = kn.simulate(eom, (0, 0.5), q={"q_a": 0.3, "q_b": -0.5}, u=[0, 0], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose([end["q_a"][-1], end["q_b"][-1]], data.qpos, atol=1e-8)


def test_files_are_read_below_the_folder(tmp_path):
    (tmp_path / "parts").mkdir()
    part = rod("first", '<joint name="a"/>')
    whole = f'<mujoco><default><geom size="0.03" type="capsule"/></default><worldbody>{part}</worldbody></mujoco>'
    (tmp_path / "parts" / "rod.xml").write_text(whole)
    main = tmp_path / "main.xml"
    main.write_text('<mujoco><include file="parts/rod.xml"/></mujoco>')
    assert list(kn.from_mjcf(main).u) == ["u_a"]
    (tmp_path / "own").mkdir()
    inner = tmp_path / "own" / "main.xml"
    inner.write_text('<mujoco><include file="../parts/rod.xml"/></mujoco>')
    with pytest.raises(kn.ModelError, match=r"files below 'own', got '\.\./parts/rod\.xml'"):
        kn.from_mjcf(inner)
    assert list(kn.from_mjcf(str(inner), folder=tmp_path).u) == ["u_a"]


def test_inertias_that_no_body_has_are_warned_of():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        text = mjcf('<body name="b"><joint name="a"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>')
        assert not [r for r in kn.from_mjcf(text).remarks if r.kind == "inferred"]

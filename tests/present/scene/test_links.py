# SPDX-License-Identifier: BSD-3-Clause
"""Shapes of links: placed as the file says, drawn where there is something to draw."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.peer import require

require("defusedxml")

ARM = """<robot name="arm">
  <link name="stand"><visual><origin xyz="0 0 -0.1"/><geometry><sphere radius="0.1"/></geometry></visual></link>
  <link name="upper arm">
    <inertial><origin xyz="0 0 0.2"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.02"/></inertial>
    <visual><origin xyz="0.1 0 0.2" rpy="0.4 0 0"/><geometry><box size="0.05 0.06 0.4"/></geometry></visual>
    <visual><origin xyz="0 0 0.4"/><geometry><cylinder radius="0.03" length="0.1"/></geometry></visual>
    <collision><geometry><sphere radius="1"/></geometry></collision>
  </link>
  <link name="tool">
    <visual><geometry><mesh filename="package://arm/tool.stl"/></geometry></visual>
    <collision><origin xyz="0 0 0.05"/><geometry><capsule radius="0.02" length="0.06"/></geometry></collision>
  </link>
  <link name="hand">
    <inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
    <visual><geometry><mesh filename="FILE" scale="SCALE"/></geometry></visual>
  </link>
  <joint name="lift" type="revolute"><parent link="stand"/><child link="upper arm"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/></joint>
  <joint name="glue" type="fixed"><parent link="upper arm"/><child link="tool"/><origin xyz="0 0 0.5" rpy="0 0 0.7"/></joint>
  <joint name="wrist" type="prismatic"><parent link="tool"/><child link="hand"/><axis xyz="1 0 0"/></joint>
</robot>"""


def turn(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array({"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]]}[axis])


def test_shapes_stand_where_the_file_places_them():
    model = kn.from_urdf(ARM)
    shapes = kn.figures.link_shapes(model)
    assert [(s.kind, s.of and s.of.name) for s in shapes] == [
        ("sphere", None),
        ("box", "upper_arm"),
        ("cylinder", "upper_arm"),
        ("capsule", None),
    ]
    scene = kn.figures.scene(model.system, shapes)
    drawn = [i for i in scene.items if i.kind in ("sphere", "box", "cylinder", "capsule")]
    assert [i.kind for i in drawn] == [s.kind for s in shapes]
    values = {s: getattr(s, "default", None) or 0.0 for s in scene.symbols}
    posed = scene.poses({**values, model.q["q_lift"]: 0.6, model.q["q_wrist"]: 0.2})
    B, base = turn("y", 0.6), np.array([0, 0, 0.3])
    wanted = [np.array([0, 0, -0.1]), *(base + B @ p for p in np.array([[0.1, 0, 0.2], [0, 0, 0.4], [0, 0, 0.55]]))]
    np.testing.assert_allclose([posed.positions[i.at] for i in drawn], wanted, atol=1e-14)
    np.testing.assert_allclose(posed.rotations[drawn[1].frame], B @ turn("x", 0.4), atol=1e-14)
    assert {k: float(posed.scalars[n]) for k, n in drawn[3].sizes.items()} == {"radius": 0.02, "length": 0.06}


def test_meshes_need_their_file_in_metres(tmp_path):
    file = tmp_path / "hand.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "utf-8")
    for scale, count in (("1 1 1", 1), ("0.001 0.001 0.001", 0)):
        model = kn.from_urdf(ARM.replace("FILE", str(file)).replace("SCALE", scale))
        assert sum(s.kind == "mesh" for s in kn.figures.link_shapes(model)) == count
    eom = kn.derive(kn.from_urdf(ARM).system)
    sol = kn.simulate(eom, (0, 0.1), q=[0.1, 0], u=[0, 0], inputs={i.name: 0 for i in eom.inputs}, samples=3)
    with pytest.raises(kn.ArgumentError, match="of an imported robot"):
        kn.figures.link_shapes(sol)


def test_a_model_is_not_a_system():
    """What has what is wanted is told to pass it."""
    model = kn.from_urdf(ARM)
    for call in (kn.derive, kn.sketch, kn.exchange.to_python):
        with pytest.raises(kn.KaneError, match=r"got Imported\(.*Pass its \.system\.$"):
            call(model)
    with pytest.raises(kn.KaneError, match=r"Pass its \.eom\.$"):
        kn.simulate(model, (0, 1))

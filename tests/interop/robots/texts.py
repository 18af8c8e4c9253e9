# SPDX-License-Identifier: BSD-3-Clause
"""Robots as texts: random ones in URDF, and small ones in MJCF that have each thing that is read."""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def numbers(values: Array) -> str:
    return " ".join(repr(float(x)) for x in np.atleast_1d(values))


def inertial(rng: np.random.Generator) -> str:
    """A mass and an inertia that a body can have, in axes of its own."""
    a, b, c = rng.uniform(0.05, 0.3, 3)
    mass = float(rng.uniform(0.5, 3))
    xx, yy, zz = (float(mass * (p * p + q * q) / 3) for p, q in ((b, c), (a, c), (a, b)))
    return (
        f'<inertial><origin xyz="{numbers(rng.uniform(-0.2, 0.2, 3))}" rpy="{numbers(rng.uniform(-3, 3, 3))}"/>'
        f'<mass value="{mass!r}"/><inertia ixx="{xx!r}" iyy="{yy!r}" izz="{zz!r}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def axis(rng: np.random.Generator, plain: bool) -> Array:
    return rng.choice([-1.0, 1.0]) * np.eye(3)[rng.integers(3)] if plain else rng.uniform(-1, 1, 3)


def angles(rng: np.random.Generator, plain: bool) -> Array:
    """Of an origin; right ones of a plain one."""
    return rng.choice([0, np.pi / 2, -np.pi / 2, np.pi], 3) if plain else rng.uniform(-3, 3, 3)


def urdf(
    kinds: list[str], rng: np.random.Generator, *, chain: bool = False, plain: bool = False, mimic: bool = False
) -> str:
    """A random tree with joints of these kinds; every second pin or slider follows the first where they mimic."""
    parts = ['<robot name="random">', '<link name="link0"/>']
    leader = ""
    for k, kind in enumerate(kinds, 1):
        parent = k - 1 if chain else int(rng.integers(k))
        parts.append(f'<link name="link{k}">{inertial(rng)}</link>')
        along = np.array([0.0, 0, 1]) if kind == "planar" else axis(rng, plain)
        follows = ""
        if kind in ("revolute", "continuous", "prismatic"):
            if mimic and leader and k % 2 == 0:
                follows = (
                    f'<mimic joint="{leader}" multiplier="{rng.uniform(-2, 2)!r}" offset="{rng.uniform(-1, 1)!r}"/>'
                )
            leader = leader or f"joint{k}"
        parts.append(
            f'<joint name="joint{k}" type="{kind}"><parent link="link{parent}"/><child link="link{k}"/>'
            f'<origin xyz="{numbers(rng.uniform(-0.5, 0.5, 3))}" rpy="{numbers(angles(rng, plain))}"/>'
            f'<axis xyz="{numbers(along)}"/><limit lower="-2" upper="2" effort="50" velocity="3"/>'
            f'<dynamics damping="{rng.uniform(0, 1)!r}" friction="0.5"/>{follows}</joint>'
        )
    return "\n".join([*parts, "</robot>"])


ARM = """<robot name="two links">
  <material name="steel"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="base"/>
  <link name="upper arm">
    <inertial><origin xyz="0.25 0 0"/><mass value="2"/><inertia ixx="0" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial>
    <visual><origin xyz="0.25 0 0" rpy="0 1.57079632679 0"/><geometry><cylinder radius="0.03" length="0.5"/></geometry>
      <material name="steel"/></visual>
    <collision><geometry><mesh filename="package://arm/upper.stl" scale="1 1 1"/></geometry></collision>
  </link>
  <link name="forearm">
    <inertial><origin xyz="0.2 0 0"/><mass value="1"/><inertia ixx="0" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper arm"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="40" velocity="2"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper arm"/><child link="forearm"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="2.5" effort="20" velocity="2"/><dynamics damping="0.1" friction="0.2"/>
  </joint>
  <transmission name="gear"><type>simple</type></transmission>
  <gazebo reference="forearm"/>
</robot>
"""

_DEFAULTS = (
    '<compiler angle="radian"/><default><geom type="capsule" size="0.03" contype="0" conaffinity="0"/></default>'
)


def mjcf(body: str, more: str = "", option: str = "") -> str:
    return f'<mujoco model="small">{_DEFAULTS}<option {option}/><worldbody>{body}</worldbody>{more}</mujoco>'


def rod(name: str, joints: str, inner: str = "", at: str = "0 0 0", more: str = "") -> str:
    """A rod of 0.4 m along its x."""
    return f'<body name="{name}" pos="{at}" {more}>{joints}<geom fromto="0 0 0 0.4 0 0"/>{inner}</body>'


_TREE = rod(
    "first",
    '<joint name="a" axis="0 1 0" ref="0.3" pos="0.05 0.1 0" damping="0.2" stiffness="3" springref="0.5" armature="0.1"/>',
    rod("second", '<joint name="b" type="slide" axis="1 0 0" ref="0.1" armature="0.4" damping="0.5"/>'
        '<joint name="c" axis="0.3 0.2 0.8"/>', at="0.4 0 0", more='quat="0.3 0.5 -0.2 0.7" gravcomp="0.6"')
    + rod("third", '<joint name="d" type="ball" pos="0 0.02 0" armature="0.05" damping="0.3"/>', at="0.2 0 0.1"),
) + rod("loose", '<freejoint name="e"/>', rod("tail", '<joint name="f" axis="0 0 1"/>', at="0.4 0 0"), at="1 1 1")  # fmt: skip
_FOUR_BAR = rod("crank", '<joint name="a" axis="0 1 0"/>', rod("coupler", '<joint name="b" axis="0 1 0"/>', at="0.4 0 0")) + rod(
    "rocker", '<joint name="c" axis="0 1 0"/>', at="0.8 0 0"
)  # fmt: skip
_PAIR = rod("left", '<joint name="a" axis="0 1 0"/>', '<site name="s" pos="0.3 0 0"/>') + rod(
    "right", '<joint name="b" axis="0 1 0"/><joint name="c" type="slide" axis="0 0 1"/>', '<site name="t" pos="0.3 0.1 0"/>', "0.5 0 0"
)  # fmt: skip
_FREE_PAIR = rod("left", '<freejoint name="a"/>') + rod(
    "right", '<freejoint name="b"/>', at="0.5 0.1 0", more='euler="0.3 0.2 0.1"'
)
_TENDONS = (
    '<tendon><fixed name="f" stiffness="5" damping="0.3" springlength="0.1"><joint joint="a" coef="0.5"/><joint joint="b" coef="-1"/>'
    '</fixed><spatial name="g" stiffness="20" damping="0.4" springlength="0.1 0.3" range="0 2" limited="true"><site site="s"/>'
    '<site site="t"/></spatial></tendon>'
)
_ACTUATORS = """<actuator>
  <motor name="m" joint="a" gear="3"/>
  <position name="p" joint="c" kp="40" kv="2" gear="0.5" ctrlrange="-1 1"/>
  <velocity name="v" joint="b" kv="3"/>
  <general name="w" joint="a" gainprm="2" biastype="affine" biasprm="0.1 -0.3 -0.2" forcerange="-0.5 0.5"/>
  <general name="x" joint="b" dyntype="filter" dynprm="0.1" gainprm="2"/>
  <general name="y" joint="b" dyntype="integrator" gainprm="2"/>
  <general name="z" joint="c" gaintype="affine" gainprm="1 0.5 -0.3"/>
  <motor name="k" tendon="f" gear="2"/>
  <motor name="l" tendon="g"/>
</actuator>"""

MODELS = {
    "tree": mjcf(_TREE),
    "tilted gravity": mjcf(_TREE, option='gravity="1 -2 -9"'),
    "no gravity": mjcf(_TREE, option='gravity="0 0 0"'),
    "four-bar": mjcf(_FOUR_BAR, '<equality><connect body1="coupler" body2="rocker" anchor="0.4 0 0"/></equality>'),
    "connect in space": mjcf(_FREE_PAIR, '<equality><connect body1="left" body2="right" anchor="0.4 0 0"/></equality>'),
    "weld": mjcf(_FREE_PAIR, '<equality><weld body1="left" body2="right"/></equality>'),
    "weld of places": mjcf(_FREE_PAIR, '<equality><weld body1="left" body2="right" torquescale="0"/></equality>'),
    "weld to the world": mjcf(_FREE_PAIR, '<equality><weld body1="left" relpose="0.1 0 0 1 0.2 0 0"/></equality>'),
    "connected sites": mjcf(
        _PAIR + rod("third", '<freejoint name="d"/>', '<site name="r" pos="0.1 0 0"/>', "0.3 0 0.2"),
        '<equality><connect site1="r" site2="t"/></equality>',
    ),
    "coupled joints": mjcf(
        _PAIR, '<equality><joint joint1="a" joint2="b" polycoef="0.1 0.5 -0.2 0.1 0"/><joint joint1="c" polycoef="0.2"/></equality>'
    ),
    "tendons": mjcf(_PAIR, _TENDONS),
    "coupled tendon": mjcf(
        _PAIR, '<tendon><fixed name="f"><joint joint="a" coef="1"/><joint joint="c" coef="2"/></fixed></tendon>'
        '<equality><tendon tendon1="f" polycoef="0.1"/></equality>'
    ),
    "actuators": mjcf(_PAIR, _TENDONS + _ACTUATORS),
    "force limits": mjcf(
        rod("first", '<joint name="a" axis="0 1 0" actuatorfrcrange="-0.4 0.4"/>'),
        '<actuator><motor name="m" joint="a" gear="3"/><motor name="n" joint="a" gear="-1"/></actuator>',
    ),
    "degrees and defaults": '<mujoco><default><joint damping="0.1"/></default><worldbody><body euler="30 20 10"><joint axis="0 1 0" '
    'ref="20" range="-10 90" limited="true"/><geom type="box" size="0.1 0.2 0.05" pos="0.1 0 0" euler="10 0 40"/></body></worldbody>'
    "</mujoco>",
}  # fmt: skip
"""Small models by what they show."""

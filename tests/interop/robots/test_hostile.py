# SPDX-License-Identifier: BSD-3-Clause
"""Texts that are wrong, and texts that mean harm: a named error in bounded time and memory, or a model; never anything else."""

from __future__ import annotations

import contextlib
import os
import random
import time
import warnings
from itertools import pairwise

import pytest

import kane as kn
from tests.interop.robots.texts import ARM, MODELS, mjcf
from tests.peer import require

require("defusedxml")

LINK = '<link name="{}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
PAIR = LINK.format("a") + LINK.format("b")
JOINT = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'


def robot(inner: str) -> str:
    return f'<robot name="r">\n{inner}\n</robot>'


_TENFOLD = [f"<!ENTITY {y} '{f'&{x};' * 10}'>" for x, y in zip("abcdefgh", "bcdefghi", strict=True)]
BOMB = f"<!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'>{''.join(_TENFOLD)}]>"
WRONG = {
    "entities": (BOMB + robot("<link name='&i;'/>"), "Expected XML without entities"),
    "an outer entity": ('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="&x;"/>', "Expected XML without entities"),
    "depth": ("<robot>" + "<link>" * 100_000, "Expected at most 300 levels"),
    "elements": ("<robot>" + "<link/>" * 300_000 + "</robot>", "200000 elements, got more"),
    "no end": ("<robot><link name='a'>", "Expected well-formed XML"),
    "no text": ("<", "Expected well-formed XML"),
    "bytes": (b"\xff\xfe<\x00r\x00", "Expected "),
    "another root": ("<sdf/>", r"Expected <robot> as the root of a URDF, got <sdf> \(URDF, line 1\)"),
    "no link": (robot(""), "Expected a <link> in <robot>, got none"),
    "no name": (robot("<link/>"), r"Expected an attribute name= of <link>, got none \(URDF, line 2\)"),
    "two of a name": (robot(PAIR + LINK.format("a") + JOINT), "Expected links of different names, got 'a' in line 2 too"),
    "two joints of a name": (robot(PAIR + JOINT * 2), "Expected joints of different names"),
    "a link that is missing": (robot(LINK.format("a") + JOINT), r"one of the links a, got 'b'\. .*line 2"),
    "no parent": (robot(PAIR + JOINT.replace('<parent link="a"/>', "")), "Expected a <parent> of the joint 'j', got none"),
    "two parents": (robot(PAIR + JOINT.replace("<child", '<parent link="a"/><child')), "Expected one <parent> in <joint>"),
    "two roots": (robot(PAIR + LINK.format("c") + JOINT), "Expected one link that is no joint's child, got 'a', 'c'"),
    "a loop": (
        robot(PAIR + LINK.format("c") + JOINT + JOINT.replace('"j"', '"k"').replace('"a"', '"c"')),
        r"links that are each the child of one joint, got 'b' of 'j' and 'k' \(URDF, line 2\)\. A loop is closed by a constraint",
    ),
    "a ring": (
        robot(PAIR + JOINT + JOINT.replace('"j"', '"k"').replace("parent", "x").replace("child", "parent").replace("x ", "child ")),
        "got a ring of joints, 'j', 'k'",
    ),
    "a ring beside a tree": (
        robot(PAIR + LINK.format("c") + JOINT + '<joint name="k" type="fixed"><parent link="c"/><child link="c"/></joint>'),
        "got a ring of joints, 'k'",
    ),
    "a type": (robot(PAIR + JOINT.replace("continuous", "revolut")), "one of revolute, .*got 'revolut'. Did you mean revolute"),
    "a slip": (robot(PAIR.replace("inertial", "intertial") + JOINT), "got 'intertial'. Did you mean inertial"),
    "a slip within": (robot(PAIR.replace("<mass", "<mas") + JOINT), r"Expected in <inertial> one of .* got 'mas'.*line 2"),
    "a slip in an attribute": (robot(PAIR.replace('iyy="1"', 'Iyy="1"') + JOINT), "got 'Iyy'. Did you mean iyy?.*line 2"),
    "two orientations": (
        robot(PAIR + JOINT.replace("<child", '<origin rpy="0 0 1" quat_xyzw="0 0 0 1"/><child')),
        "rpy= or quat_xyzw= .*, got both",
    ),
    "no quaternion": (robot(PAIR + JOINT.replace("<child", '<origin quat_xyzw="0 0 0 0"/><child')), "that is not zero .*, got zero"),
    "macros": (robot('<xacro:macro name="x" xmlns:xacro="http://www.ros.org/wiki/xacro"/>' + PAIR + JOINT), "Run xacro over it first"),
    "no mass": (robot(PAIR.replace('<mass value="1"/>', "") + JOINT), "Expected a <mass> of the link 'a', got none"),
    "a word": (robot(PAIR.replace('mass value="1"', 'mass value="$(rm -rf /)"') + JOINT), "Expected a number as value= of <mass>"),
    "not a number": (robot(PAIR.replace('mass value="1"', 'mass value="nan"') + JOINT), "Expected a number as value= of <mass>"),
    "infinity": (robot(PAIR.replace('ixx="1"', 'ixx="1e999"') + JOINT), "Expected a number as ixx= of <inertia>, got '1e999'"),
    "two numbers": (robot(PAIR + JOINT.replace("<child", '<axis xyz="0 1"/><child')), "Expected 3 numbers as xyz= of <axis>"),
    "no axis": (robot(PAIR + JOINT.replace("<child", '<axis xyz="0 0 0"/><child')), "an axis of the joint 'j' that is not zero"),
    "limits": (
        robot(PAIR + JOINT.replace("continuous", "revolute").replace("<child", '<limit lower="1" upper="0"/><child')),
        "Expected lower ≤ upper limit of the joint 'j', got 1 and 0",
    ),
    "negative damping": (robot(PAIR + JOINT.replace("<child", '<dynamics damping="-1"/><child')), "damping and friction ≥ 0"),
    "negative mass": (
        robot(PAIR.replace('value="1"', 'value="-1"') + JOINT),
        r"Expected a mass ≥ 0 of the link 'a', got -1 \(URDF, line 2\)",
    ),
    "negative inertia": (
        robot(PAIR.replace('ixx="1"', 'ixx="1" ixy="3"') + JOINT),
        r"principal moments of inertia ≥ 0 of the link 'a', got -2, 1, 4 \(URDF, line 2\)",
    ),
    "itself": (robot(PAIR + JOINT.replace("<child", '<mimic joint="j"/><child')), "Expected <mimic> of 'j' to follow another"),
    "nothing to follow": (
        robot(PAIR + JOINT.replace("<child", '<mimic joint="no"/><child')),
        "Expected <mimic> of 'j' to follow another",
    ),
    "nothing weighs": (
        robot('<link name="a"/><link name="b"/>' + JOINT),
        "Expected a link with mass in 'r', got none",
    ),
    "nothing moves": (robot(PAIR + JOINT.replace("continuous", "fixed")), "Expected a joint that moves in 'r', got none"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_in_a_urdf_is_named(name):
    text, match = WRONG[name]
    began = time.process_time()
    with pytest.raises(kn.ModelError, match=match):
        kn.from_urdf(text)
    assert time.process_time() - began < 10


def test_what_is_no_file_is_refused(tmp_path):
    for source in (tmp_path, tmp_path / "no.urdf", "no such file", "/dev/zero", "a\0b", ""):
        with pytest.raises(kn.ModelError, match="Expected the path of a URDF file, or its text"):
            kn.from_urdf(source)
    big = tmp_path / "big.urdf"
    with big.open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(kn.ModelError, match="at most 33554432 bytes"):
        kn.from_urdf(big)


def test_options_of_another_kind_are_named():
    for given, message in (
        ({"stops": "no"}, "stops= to be True or False, got 'no'"),
        ({"friction": 0}, "friction= to be True or False, got 0"),
        ({"efforts": None}, "efforts= to be True or False, got None"),
        ({"locked": "elbow"}, "locked= a list of names of joints, got 'elbow'"),
        ({"right_angles": "small"}, "right_angles= an angle, rad, got 'small'"),
        ({"right_angles": float("nan")}, "right_angles= an angle, rad, got nan"),
    ):
        with pytest.raises(kn.ModelError, match=message):
            kn.from_urdf(ARM, **given)


def test_dry_friction_that_has_no_counterpart_is_refused_where_it_is_asked_for():
    planar = robot(PAIR + JOINT.replace("continuous", "planar").replace("<child", '<dynamics friction="1"/><child'))
    assert not kn.from_urdf(planar).of_kind("refused")
    with pytest.warns(kn.KaneWarning, match="dry friction in a planar joint"):
        read = kn.from_urdf(planar, friction=True)
    assert read.of_kind("refused") == ("joint 'j': dry friction in a planar joint",)


def test_names_are_identifiers_whatever_they_are():
    """Nothing of a name is run, and no two become one."""
    names = ["a b", "a-b", "class", "1st", "$(touch x)", "../../x", "é", "_"]
    links = "".join(LINK.format(n) for n in names)
    joints = "".join(
        f'<joint name="{n}" type="continuous"><parent link="{m}"/><child link="{n}"/></joint>'
        for m, n in pairwise(names)
    )
    read = kn.from_urdf(robot(links + joints))
    given = list(read.extras["links"].values())
    assert all(n.isidentifier() and n.isascii() for n in given)
    assert len(set(given)) == len(names)
    assert all(any(repr(n) in r.text for r in read.remarks) for n in names if n != "_")
    assert all(s.isidentifier() for s in read.symbols)


def test_inertias_that_no_body_has_are_said():
    read = kn.from_urdf(robot(PAIR.replace('ixx="1"', 'ixx="9"') + JOINT))
    assert any("none is larger than the sum of the other two, got 1, 1, 9" in r.text for r in read.remarks)


BAD_MJCF = {
    "a plugin": ('<mujoco><extension><plugin plugin="mujoco.pid"/></extension></mujoco>', "Expected rigid bodies alone"),
    "a file": (mjcf("", '<asset><mesh name="m" file="/etc/passwd"/></asset>'), "no files in an MJCF that is given as text"),
    "an include": ('<mujoco><include file="x.xml"/></mujoco>', "no files in an MJCF that is given as text"),
    "entities": (BOMB + "<mujoco/>", "Expected XML without entities"),
    "a word": ("<mujoco><worldbdy/></mujoco>", "Expected an MJCF that MuJoCo reads, got: .*unrecognized element"),
    "a hinge of no mass": (mjcf('<body><joint/></body>'), "Expected an MJCF that MuJoCo reads, got: .*mass and inertia"),
    "too much": (
        '<mujoco><worldbody><replicate count="1000000000"><body><geom size="1"/></body></replicate></worldbody></mujoco>',
        "Expected ",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n == "too much" else n for n in BAD_MJCF])
def test_what_is_wrong_in_an_mjcf_is_named(name):
    require("mujoco")
    text, match = BAD_MJCF[name]
    with pytest.raises(kn.ModelError, match=match):
        kn.from_mjcf(text, timeout=2 if name == "too much" else 20)


def test_includes_and_files_of_an_mjcf_stay_below_its_folder(tmp_path):
    require("mujoco")
    main = tmp_path / "inner" / "main.xml"
    main.parent.mkdir()
    (tmp_path / "secret.xml").write_text("<mujoco/>")
    (main.parent / "link.xml").symlink_to(tmp_path / "secret.xml")
    inside = {
        '<include file="main.xml"/>': "Expected files that are included once, got 'main.xml' again",
        '<include file="../secret.xml"/>': "Expected files below 'inner', got '../secret.xml'",
        '<include file="link.xml"/>': "Expected files below 'inner', got 'link.xml'",
        '<include file="no.xml"/>': "There is no such file",
        '<asset><mesh name="m" file="/etc/passwd"/></asset>': "Expected files below 'inner', got '/etc/passwd'",
        '<compiler meshdir="../.."/><asset><mesh name="m" file="m.stl"/></asset>': "Expected files below 'inner'",
        r'<asset><mesh name="m" file="C:\m.stl"/></asset>': "Expected files below 'inner'",
    }
    for text, match in inside.items():
        main.write_text(f"<mujoco>{text}</mujoco>")
        with pytest.raises(kn.ModelError, match=match):
            kn.from_mjcf(main)


# Mutations -----------------------------------------------------------------------------------------------------------

WORDS = (
    b"<", b">", b'"', b"/", b"&", b"&lt;", b"0", b"-1", b"1e308", b"nan", b"<link", b"</robot>", b"\0", b"\xff", b"<!--", b"<![CDATA[",
    b"free", b"world",
)  # fmt: skip


def mutated(text: bytes, rng: random.Random) -> bytes:
    """A few bytes, words or pieces changed, moved or left out."""
    for _ in range(rng.choice((1, 1, 2, 4, 8))):
        a, b = sorted(rng.randrange(len(text) + 1) for _ in range(2))
        b = min(b, a + rng.choice((1, 3, 10, 60)))
        piece = rng.choice((b"", rng.choice(WORDS), rng.randbytes(2), text[a:b] * 2, text[b : b + 40]))
        text = text[:a] + piece + text[b:]
    return text


def fuzz(read: object, texts: list[str], seconds: float, seed: int) -> int:
    """How many texts were read or refused in these seconds; anything but a named error goes through."""
    rng, end, count = random.Random(seed), time.monotonic() + seconds, 0
    while time.monotonic() < end or not count:
        text = mutated(rng.choice(texts).encode(), rng)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kn.KaneWarning)
            with contextlib.suppress(kn.KaneError):
                read(text)
        count += 1
    return count


SECONDS = {"1": 300, "rest": 20}.get(os.environ.get("KANE_FULL", ""), 1)


@pytest.mark.grows
@pytest.mark.timeout(900)
def test_mutated_urdf_is_read_or_refused():
    texts = [ARM, *(t for t, _ in WRONG.values() if isinstance(t, str) and len(t) < 5000)]
    assert fuzz(kn.from_urdf, texts, SECONDS, 1) > 20


@pytest.mark.grows
@pytest.mark.timeout(900)
def test_mutated_mjcf_is_read_or_refused():
    require("mujoco")
    assert fuzz(lambda text: kn.from_mjcf(text, timeout=20), list(MODELS.values()), SECONDS, 2) > 0


@pytest.mark.slow
def test_rods_without_end_are_read_in_time():
    """A tree as deep as MuJoCo and the limits allow."""
    require("mujoco")
    text = '<joint axis="0 1 0"/><geom fromto="0 0 0 0.1 0 0" size="0.01"/>'
    for _ in range(80):
        text = f'<joint axis="0 1 0"/><geom fromto="0 0 0 0.1 0 0" size="0.01"/><body pos="0.1 0 0">{text}</body>'
    read = kn.from_mjcf(
        f'<mujoco><default><geom type="capsule"/></default><worldbody><body>{text}</body></worldbody></mujoco>'
    )
    assert len(read.u) == 81

# SPDX-License-Identifier: BSD-3-Clause
"""Scenes hold what frames and points say: every pose, every turn and shift of a coordinate, over all of the gallery."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.errors import ArgumentError, ModelError, ValueMissingError
from kane.figures import Scene, scene
from kane.gallery import GALLERY, load


@cache
def seen(name: str) -> Scene:
    module = load(name)
    system = module.system()
    return scene(system, module.shapes(system) if hasattr(module, "shapes") else ())


def values(drawn: Scene, rng: Any) -> dict[Any, float]:
    found: dict[Any, Any] = {
        s: s.default if getattr(s, "default", None) is not None else rng.uniform(0.2, 0.9) for s in drawn.symbols
    }
    found |= {s: rng.uniform(0.2, 0.9) for s in drawn.symbols if isinstance(s, kn.expr.Coordinate)}
    for group in drawn.system.euler_parameters:
        size = np.sqrt(sum(found[q] ** 2 for q in group.coordinates))
        found |= {q: found[q] / size for q in group.coordinates}
    return found


@pytest.mark.parametrize("name", GALLERY)
def test_poses_are_those_of_frames_and_points(name: str, rng: Any) -> None:
    """By the direction cosines and positions themselves, at a state, for marks, axes of frames, and several states at once."""
    drawn, system = seen(name), seen(name).system
    at = values(drawn, rng)
    posed, points = drawn.poses(at), {p.name: p for p in system.points}
    frames = {f.name: f for f in system.frames}
    for mark in drawn.marks:
        p = points[mark.name]
        place = kn.evaluate(list(p.position(p.root()).components(system.inertial)), at)
        np.testing.assert_allclose(posed.positions[mark.at], place, rtol=1e-12, atol=1e-12)
    for triad in drawn.triads:
        turned = np.array(kn.evaluate(system.inertial.dcm(frames[triad.name]), at), dtype=float)
        np.testing.assert_allclose(posed.rotations[triad.frame], turned, rtol=1e-12, atol=1e-12)
    for turn in posed.rotations:
        np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-9)
        assert np.linalg.det(turn) > 0
    several = drawn.poses({s: np.array([v, v, v]) for s, v in at.items()})
    np.testing.assert_allclose(several.positions[1], posed.positions, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(several.rotations[2], posed.rotations, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", GALLERY)
def test_movements_are_what_coordinates_do(name: str, rng: Any) -> None:
    """Each coordinate has one; what turns is where it is at zero after a turn back, what shifts starts where it is at zero."""
    drawn = seen(name)
    at = values(drawn, rng)
    posed = drawn.poses(at)
    told = [s for m in drawn.movements for s in m.symbols]
    assert sorted(told) == sorted(q.name for q in drawn.system.coordinates)
    for m in drawn.movements:
        before = drawn.poses({s: 0.0 if s.name == m.symbols[0] else v for s, v in at.items()})
        if m.kind == "turn":
            assert m.axis is not None
            assert m.direction is not None
            assert m.sweep is not None
            axis, end = posed.directions[m.axis], posed.directions[m.direction]
            axis = axis / np.linalg.norm(axis)
            assert abs(axis @ end) < 1e-9 * np.linalg.norm(end)
            angle = -posed.scalars[m.sweep]
            back = end * np.cos(angle) + np.cross(axis, end) * np.sin(angle)
            np.testing.assert_allclose(back, before.directions[m.direction], rtol=1e-9, atol=1e-9)
        elif m.kind == "shift":
            np.testing.assert_allclose(posed.positions[m.points[0]], before.positions[m.points[-1]], atol=1e-12)
            assert np.linalg.norm(posed.positions[m.points[-1]] - posed.positions[m.points[0]]) > 1e-3


@pytest.mark.parametrize("name", GALLERY)
def test_scenes_are_plain_data(name: str) -> None:
    drawn = seen(name)
    data = json.loads(json.dumps(drawn.to_dict()))
    for group, count in (("positions", 3), ("directions", 3), ("rotations", 3)):
        assert all(len(entry) == count for entry in data[group])
    for item in data["items"]:
        used = [*item["points"], *([] if item["at"] is None else [item["at"]])]
        assert all(0 <= k < len(data["positions"]) for k in used)
        assert all(0 <= k < len(data["scalars"]) for k in item["sizes"].values())
    bodies = {b.name for b in drawn.system.bodies}
    assert bodies <= {i["name"] for i in data["items"]}


def test_what_is_seen_follows_from_what_is_declared() -> None:
    """Solids of inertias, links, springs, what rolls, ropes, beams, blocks: each by its kind."""
    kinds = {name: {(i.kind, i.name) for i in seen(name).items} for name in GALLERY}
    assert ("disk", "disk") in kinds["rolling_disk"]
    assert {("rod", "crank"), ("rod", "coupler"), ("rod", "rocker")} <= kinds["four_bar"]
    assert {("spring", "spring between P and O"), ("damper", "damper between P and O")} <= kinds["particle_on_spring"]
    assert {("bar", "coupler 1"), ("box", "slider")} <= kinds["flyball_governor"]
    assert {("disk", "rear wheel"), ("disk", "front wheel")} <= kinds["whipple_bicycle"]
    assert {("rope", "rope"), ("block", "crate")} <= kinds["winch"]
    assert ("sphere", "ball 3") in kinds["newtons_cradle"]
    assert ("hull", "block") in kinds["rocking_block"]
    assert ("slider", "piston") in kinds["slider_crank"]
    assert ("beam", "blade") in kinds["flap_lag_blade"]
    assert ("sphere", "ball") in kinds["tippe_top"]
    assert {("wheel", "rear axle")} <= kinds["car_with_trailer"]
    assert any(kind == "plane" for kind, _ in kinds["pure_rolling_disk"])


def test_a_particle_in_the_middle_of_what_rolls_is_no_second_ball() -> None:
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, a = kn.coordinates("x y a")
    B, C = N.rotate("B", a, N.z), O.at("C", x * N.x + y * N.y)
    ball = kn.RigidBody("ball", frame=B, mass_center=C, mass=1, inertia=kn.inertia(B, 1, 2, 3))
    floor = kn.contact(kn.joints.sphere_on_plane("floor", B, C, O, radius=1, normal=N.y), 0.5)
    system = kn.System(N, bodies=[ball, kn.Particle("load", C, 1)], speeds="rates", contacts=[floor])
    kinds = {i.name: i.kind for i in scene(system).items}
    assert (kinds["ball"], kinds["load"]) == ("sphere", "particle")


def test_a_radius_is_the_one_declared(rng: Any) -> None:
    drawn = seen("whipple_bicycle")
    wheel = next(i for i in drawn.items if i.name == "front wheel")
    at = values(drawn, rng)
    assert drawn.poses(at).scalars[wheel.sizes["radius"]] == pytest.approx(0.35)


def test_shapes_change_no_equation() -> None:
    module = load("spinning_top")
    system = module.system()
    before = kn.derive(system).accelerations
    kn.figures.scene(system, module.shapes(system))
    assert all(a is b for a, b in zip(before, kn.derive(system).accelerations, strict=True))


def test_declared_shapes_take_the_place_of_others() -> None:
    module = load("spinning_top")
    system = module.system()
    assert [i.kind for i in scene(system).items] == ["link", "inertia"]
    assert [i.kind for i in scene(system, module.shapes(system)).items] == ["cone"]


def test_what_is_no_shape_is_refused(tmp_path: Any) -> None:
    module = load("spinning_top")
    system, other = module.system(), module.system()
    (top,), (stranger,) = system.rigid_bodies, other.rigid_bodies
    shape = kn.figures.shape
    with pytest.raises(ModelError, match=r"kind of a shape, one of .*cone.*got 'cones'"):
        shape("cones", top)
    with pytest.raises(ModelError, match="Expected radius, height for a cone, got radius"):
        shape("cone", top, radius=1)
    with pytest.raises(ModelError, match="Expected a position of the box"):
        shape("box", a=1, b=1, c=1)
    with pytest.raises(ModelError, match="unit vector"):
        shape("cone", top, radius=1, height=1, axis=2 * top.frame.z)
    with pytest.raises(ModelError, match="got one of top"):
        scene(system, [shape("sphere", stranger, radius=1)])
    with pytest.raises(ModelError, match="STL or OBJ"):
        shape("mesh", top, file="x.glb")
    with pytest.raises(ModelError, match="Expected a path as file= of the mesh, got 3"):
        shape("mesh", top, file=3)  # type: ignore[arg-type]
    with pytest.raises(ModelError, match=r"kind of a shape, one of .*got \['cone'\]"):
        shape(["cone"], top)  # type: ignore[arg-type]
    for given, told in (("frame", "a frame as frame="), ("at", "a point as at=")):
        with pytest.raises(ModelError, match=f"Expected {told} of the sphere, got 'B'"):
            shape("sphere", top, radius=1, **{given: "B"})
    with pytest.raises(ModelError, match="Expected points of the link, got 1"):
        shape("link", top, points=[1, 2])  # type: ignore[list-item]
    with pytest.raises(ArgumentError, match=r"a kn\.System or its Equations"):
        scene(top)  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="mesh that can be read"):
        kn.sketch(system, shapes=[shape("mesh", top, file=tmp_path / "none.stl")])
    with pytest.raises(ValueMissingError):
        scene(system).poses({})


def test_a_mesh_is_read_in_each_form(tmp_path: Any) -> None:
    """One tetrahedron as OBJ, and as STL in text and in bytes, spans the same box."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=float)
    faces = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]
    (tmp_path / "a.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 2 3\n")
    rows = "".join("facet\n" + "".join("vertex {} {} {}\n".format(*corners[k]) for k in f) for f in faces)
    (tmp_path / "b.stl").write_text(f"solid t\n{rows}endsolid\n")
    packed = b"".join(np.array([[0, 0, 0], *corners[list(f)]], dtype="<f4").tobytes() + b"\0\0" for f in faces)
    (tmp_path / "c.stl").write_bytes(b"\0" * 80 + len(faces).to_bytes(4, "little") + packed)
    from kane.present import mesh

    for name in ("a.obj", "b.stl", "c.stl"):
        found = mesh(str(tmp_path / name)).cloud
        assert {tuple(p) for p in found} == {tuple(p) for p in corners}


def test_axes_of_few_frames_are_shown_those_of_rods_without_mass_too() -> None:
    """A bob's rod has no mass and no body; of more than three bodies the axes would hide the drawing."""
    assert {t.name for t in seen("light_cart_pole").triads} == {"N", "B"}
    assert {t.name for t in seen("four_bar").triads} == {"N", "crank", "coupler", "rocker"}
    assert {t.name for t in seen("bricard").triads} == {"N"}

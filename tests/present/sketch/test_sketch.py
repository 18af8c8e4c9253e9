# SPDX-License-Identifier: BSD-3-Clause
"""Sketches of all of the gallery: every coordinate labelled, no label upon another or beyond the edges, whole SVG, the same bytes."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import kane as kn
from kane.errors import ArgumentError, KaneError, ModelError
from kane.figures import Sketch, scene
from kane.gallery import GALLERY, load
from kane.present import DARK, GAP, LIGHT, NARROW, TEXT, WIDE, looks, pose_of, style, view_of

SVG = "{http://www.w3.org/2000/svg}"


@cache
def drawn(name: str, width: int) -> Sketch:
    module = load(name)
    system = module.system()
    shapes = module.shapes(system) if hasattr(module, "shapes") else ()
    return kn.sketch(system, width=width, shapes=shapes, title=module.TITLE)


WIDTHS = (WIDE, pytest.param(NARROW, marks=pytest.mark.slow))


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", GALLERY)
def test_every_coordinate_is_labelled_and_no_label_overlaps(name: str, width: int) -> None:
    sketch = drawn(name, width)
    root = ElementTree.fromstring(sketch.svg)
    texts = root.findall(f"{SVG}text")
    told = [s for t in texts for s in t.get("data-s", "").split() if "".join(t.itertext()).strip()]
    names = {q.name for q in sketch.scene.system.coordinates}
    assert sorted(s for s in told if s in names) == sorted(names)
    assert len(texts) == len(sketch.labels)
    assert {t.get("class") for t in texts} <= set(TEXT)
    for b in sketch.labels:
        left, top, right, bottom = b.box
        assert left >= 0, b
        assert top >= 0, b
        assert right <= sketch.width, b
        assert bottom <= sketch.height, b
    for a, b in combinations(sketch.labels, 2):
        assert not _overlap(a.box, b.box), (a.runs, b.runs)


def _overlap(a: Any, b: Any) -> bool:
    near = GAP / 2
    return bool(a[0] < b[2] + near and b[0] < a[2] + near and a[1] < b[3] + near and b[1] < a[3] + near)


@pytest.mark.parametrize("name", GALLERY)
def test_all_is_on_the_paper_and_said_in_words(name: str) -> None:
    """Bodies, arcs and arrows lie within the edges; a ground may go beyond them."""
    sketch = drawn(name, WIDE)
    root = ElementTree.fromstring(sketch.svg)
    for path in root.findall(f"{SVG}path"):
        look = path.get("class", "")
        if look.split()[0] in ("floor", "ground", "hatch"):
            continue
        numbers = np.array(re.findall(r"-?\d+(?:\.\d+)?", path.get("d", "")), dtype=float).reshape(-1, 2)
        assert np.isfinite(numbers).all()
        assert numbers.min() >= -1, look
        assert (numbers <= (sketch.width + 1, sketch.height + 1)).all(), look
    said = root.findtext(f"{SVG}desc") or ""
    assert all(q.name in said for q in sketch.scene.system.coordinates)
    labelled = (root.get("aria-labelledby") or "").split()
    assert [root.find(f"{SVG}{tag}").get("id") for tag in ("title", "desc")] == labelled  # type: ignore[union-attr]


@pytest.mark.parametrize("name", GALLERY)
def test_constraints_hold_in_the_pose(name: str) -> None:
    """By the constraints' own expressions; gaps of contacts are not below zero."""
    seen = scene(load(name).system())
    pose = pose_of(seen)
    at = pose.values
    for c in seen.system.holonomic:
        assert abs(float(kn.evaluate(c.expr, at))) < 1e-6, c.name
    for law in seen.system.contacts:
        if law.gap is not None:
            assert float(kn.evaluate(law.gap.expr, at)) > -0.2 * pose.size, law.name


def test_what_moves_in_a_plane_is_drawn_in_it() -> None:
    flat = {name for name in GALLERY if _view(name).plane}
    spatial = {"rolling_disk", "spinning_top", "bricard", "whipple_bicycle", "furuta_pendulum", "tippe_top", "clutch"}
    assert {"four_bar", "slider_crank", "double_pendulum", "rocking_block", "car_with_trailer", "winch"} <= flat
    assert not flat & spatial
    four_bar = _view("four_bar")
    np.testing.assert_allclose([four_bar.right, four_bar.up, four_bar.toward], np.eye(3), atol=1e-12)


def _view(name: str) -> Any:
    seen = scene(load(name).system())
    return view_of(seen, pose_of(seen))


@pytest.mark.parametrize("name", ["rolling_disk", "bricard", "gimbal_gyroscope"])
def test_the_camera_is_a_right_handed_frame_that_sees_what_opens(name: str) -> None:
    view = _view(name)
    axes = np.array([view.right, view.up, view.toward])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1)


def test_an_arc_opens_by_its_angle() -> None:
    """The pendulum at 30 degrees: its arc, read off the drawing, spans 30 degrees about the pivot."""
    sketch = kn.sketch(load("pendulum").system(), q={"theta": np.radians(30)})
    root = ElementTree.fromstring(sketch.svg)
    (arc,) = (p for p in root.findall(f"{SVG}path") if p.get("class") == "move")
    rays = [p for p in root.findall(f"{SVG}path") if p.get("class") in ("base", "ray")]
    ways = []
    for ray in rays:
        a, b = np.array(re.findall(r"-?\d+(?:\.\d+)?", ray.get("d", "")), dtype=float).reshape(-1, 2)[:2]
        ways.append((b - a) / np.hypot(*(b - a)))
    assert np.degrees(np.arccos(ways[0] @ ways[1])) == pytest.approx(30, abs=0.5)
    assert arc is not None


def test_colours_have_contrast() -> None:
    """4.5 at least, as WCAG has it, of each label's colour on the card and on all faces of bodies, light and dark."""

    def light(colour: str) -> float:
        parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        r, g, b = (x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts)
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    for table in (LIGHT, DARK):
        for colour in set(TEXT.values()):
            for ground in ("card", "body", "floor"):
                a, b = sorted((light(table[colour]), light(table[ground])))
                assert (b + 0.05) / (a + 0.05) >= 4.5, (colour, ground)


def test_labels_have_a_halo() -> None:
    sheet = style()
    (rule,) = re.findall(r"\.kane-sketch text\{(stroke:[^}]*)\}", sheet)
    assert "paint-order:stroke" in rule
    assert "stroke:var(--k-card)" in rule
    assert float(re.findall(r"stroke-width:([\d.]+)px", rule)[0]) >= 3
    assert sheet in drawn("pendulum", WIDE).svg


@pytest.mark.slow
def test_the_same_bytes_under_any_hash_seed() -> None:
    code = (
        "import kane as kn, hashlib; from kane.gallery import load; "
        "print(hashlib.sha256(''.join(kn.sketch(load(n).system(), width=w).svg for w in (640, 330) "
        "for n in ('rolling_disk', 'four_bar', 'bricard', 'flexible_arm', 'rocking_block')).encode()).hexdigest())"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("0", "1", "77")
    }
    assert len(found) == 1


def test_a_sketch_is_saved_and_shown(tmp_path: Path) -> None:
    eom = kn.derive(load("pendulum").system())
    sketch = kn.sketch(eom, tmp_path / "new" / "pendulum.svg")
    assert (
        (tmp_path / "new" / "pendulum.svg").read_text("utf-8")
        == sketch.svg
        == sketch._repr_html_()
        == sketch._repr_svg_()
    )
    assert sketch.save(tmp_path / "new" / "pendulum.svg").is_file()
    (tmp_path / "other.svg").write_text("mine")
    with pytest.raises(KaneError):
        sketch.save(tmp_path / "other.svg")
    assert (tmp_path / "other.svg").read_text() == "mine"


def test_a_sketch_is_drawn_for_paper_in_the_colours_of_its_style_sheet(tmp_path: Path) -> None:
    """A rule that names more classes goes before one that names fewer; a foreign file stays."""
    assert looks("wide rod face")["stroke"] == LIGHT["body"]
    assert looks("rod wide")["stroke"] == LIGHT["ink"]
    assert looks("point") == looks("point") | {"fill": LIGHT["ink"], "stroke": "none"}
    sketch = kn.sketch(load("pendulum").system())
    pixels = np.asarray(Image.open(sketch.save(tmp_path / "p.png")).convert("RGB")).reshape(-1, 3)
    seen = {tuple(p) for p in np.unique(pixels, axis=0).tolist()}
    for colour in ("body", "ink", "move", "force"):
        assert tuple(bytes.fromhex(LIGHT[colour][1:])) in seen, colour
    assert sketch.save(tmp_path / "p.pdf").read_bytes() == sketch.save(tmp_path / "p.pdf").read_bytes()
    (tmp_path / "other.pdf").write_text("mine")
    with pytest.raises(KaneError):
        sketch.save(tmp_path / "other.pdf")


def test_a_pose_that_is_told_is_kept() -> None:
    system = load("four_bar").system()
    pose = pose_of(scene(system), {"q1": 0.9})
    (q1, *_) = system.coordinates
    assert pose.values[q1] == 0.9
    assert all(abs(float(kn.evaluate(c.expr, pose.values))) < 1e-6 for c in system.holonomic)


def test_what_cannot_be_drawn_is_refused() -> None:
    system = load("pendulum").system()
    with pytest.raises(ArgumentError, match=r"a kn\.System or its Equations to draw"):
        kn.sketch("pendulum")  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="pixels from 240 to 2000"):
        kn.sketch(system, width=100)
    with pytest.raises(KaneError, match="phi"):
        kn.sketch(system, q={"phi": 1.0})


def test_arguments_that_no_sketch_has_are_refused(tmp_path: Path) -> None:
    """An ending of another format, angles that are no finite numbers, a title that is no text, shapes that are no list."""
    system = load("pendulum").system()
    with pytest.raises(ArgumentError, match=r"a file for the sketch that ends in \.svg, \.pdf, \.png, got .*a\.jpg"):
        kn.sketch(system, tmp_path / "a.jpg")
    assert not (tmp_path / "a.jpg").exists()
    assert kn.sketch(system).save(tmp_path / "a").read_text().startswith("<svg")
    values: tuple[Any, ...] = (float("nan"), float("inf"), "a", [1.0])
    for value in values:
        with pytest.raises(ModelError, match="Expected a finite number for theta in q="):
            kn.sketch(system, q={"theta": value})
    with pytest.raises(ModelError, match="Expected title= of a sketch as a text, got 3"):
        kn.sketch(system, title=3)  # type: ignore[arg-type]
    with pytest.raises(ModelError, match=r"Expected shapes= as shapes of kn\.figures\.shape, got BodyShape"):
        kn.sketch(system, shapes=kn.figures.shape("sphere", system.bodies[0], radius=1))  # type: ignore[arg-type]


def test_a_body_about_its_own_mass_centre_is_drawn() -> None:
    """A length of zero leaves the bar to the mass centre no direction."""
    N = kn.Frame("N")
    theta, l, moment = kn.coordinate("theta", "rad"), kn.parameter("l", 0.0, "m"), kn.parameter("I", 1.0, "kg*m^2")
    B = N.rotate("B", theta, N.z)
    center = kn.Point("O", fixed_in=N).at("B*", -l * B.y)
    body = kn.RigidBody("wheel", frame=B, mass_center=center, mass=1.0, inertia=kn.inertia(B, moment, 0, moment))
    drawn = kn.sketch(kn.System(N, bodies=[body], speeds="rates"))
    assert all(np.isfinite(s.points).all() for s in drawn.strokes)
    assert "nan" not in drawn.svg

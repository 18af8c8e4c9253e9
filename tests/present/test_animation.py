# SPDX-License-Identifier: BSD-3-Clause
"""Animations: where parts are, the page that shows them, and what is written to files."""

from __future__ import annotations

import json
import pickle
import re
import struct
import subprocess

import numpy as np
import pytest
from PIL import Image

import kane as kn
from kane.gallery import GALLERY, load
from kane.present import SIZED, UNIT, read, transforms
from tests.peer import require
from tests.present.browser import chromium

QUICK = ("four_bar", "flyball_governor", "rolling_disk", "flexible_pendulum", "rocking_block")
GL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")


def motion(name, end=0.2):
    module = load(name)
    eom = kn.derive(module.system())
    start = getattr(module, "START", None)
    if start is None:
        from kane.cli import STARTS

        start = STARTS[name]
    return kn.simulate(eom, (0, end), samples=5, **start)


def volume(mesh):
    """Σ p₁·(p₂ × p₃)/6: of a closed surface that turns right about its outward normal."""
    p = mesh.vertices[mesh.triangles]
    return np.einsum("ij,ij->", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6


SOLIDS = {
    "box": (UNIT["box"](), 1.0),
    "sphere": (UNIT["sphere"](), 4 * np.pi / 3),
    "hemisphere": (UNIT["hemisphere"](), 2 * np.pi / 3),
    "cylinder": (UNIT["cylinder"](), np.pi),
    "cone": (UNIT["cone"](), np.pi / 3),
    "frustum": (SIZED["frustum"][0](2.0, 1.0, 3.0), np.pi * 3 * (4 + 2 + 1) / 3),
    "torus": (SIZED["torus"][0](2.0, 0.5), 2 * np.pi**2 * 2 * 0.25),
    "capsule": (SIZED["capsule"][0](0.5, 2.0), np.pi * 0.25 * 2 + 4 * np.pi / 3 / 8),
    "sector": (SIZED["sector"][0](2.0, 0.6, 0.1), 0.6 * 4 * 0.1),
    "triangle": (SIZED["triangle"][0](2.0, 3.0, 0.1), 0.3),
}


def test_what_moves_up_and_down_alone_is_seen_from_farther_away(tmp_path):
    """A screen shows 3.5 tan 0.26 of the reach above the middle and below."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    (y,) = kn.coordinates("y")
    particles = [kn.Particle(n, O.at(n, y * N.y + k * N.y), 1.0) for k, n in enumerate("PQ")]
    sol = kn.simulate(
        kn.derive(kn.System(N, bodies=particles, speeds="rates", loads=[kn.gravity(-N.y)])), (0, 2), q=[2.0], u=0
    )
    kn.figures.animate(sol, tmp_path / "motion.html")
    page = (tmp_path / "motion.html").read_text(encoding="utf-8")
    (reach,) = re.findall(r'"reach":([0-9.]+)', page)
    assert 3.5 * np.tan(0.26) * float(reach) > 1.2 * (np.ptp(sol[y]) + 1) / 2


@pytest.mark.parametrize("kind", SOLIDS)
def test_meshes_are_closed_and_turn_outward(kind):
    mesh, exact = SOLIDS[kind]
    assert volume(mesh) == pytest.approx(exact, rel=0.03)
    corners = mesh.vertices[mesh.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", mesh.normals[mesh.triangles].mean(axis=1), across) > 0).mean() > 0.99
    keys, edges = np.unique(np.round(mesh.vertices, 9), axis=0, return_inverse=True)
    ring = edges.reshape(-1)[mesh.triangles]
    sides = [(a, b) for t in ring for a, b in zip(t, np.roll(t, -1), strict=True) if a != b]
    assert len(keys) > 4
    assert sorted(sides) == sorted((b, a) for a, b in sides)  # each edge once in each direction


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in GALLERY])
def test_parts_are_where_the_motion_says(name):
    """Rigid maps keep lengths; a part at a point is at that point, one along axes has those of its frame."""
    sol = motion(name)
    animation = kn.figures.animate(sol)
    model, course = animation.model, animation.courses[0]
    places = transforms(model, course.poses)
    assert np.isfinite(places).all()
    dense = sol.at(course.times)
    values = np.array(dense[[x for p in animation.scene.positions for x in p]], dtype=float)
    points = np.stack([np.broadcast_to(v, len(course.times)) for v in values], axis=-1).reshape(
        len(course.times), -1, 3
    )
    for k, part in enumerate(model.parts):
        np.testing.assert_allclose(places[:, k, :, 3], points[:, part.at], rtol=0, atol=1e-9 * model.size)
        columns = places[:, k, :, :3]
        gram = np.einsum("nij,nik->njk", columns, columns)
        off = gram - np.einsum("njj,jk->njk", gram, np.eye(3))
        np.testing.assert_allclose(off, 0, atol=1e-9 * model.size**2)
        assert (np.linalg.det(columns) >= -1e-15 * model.size**3).all()
        if part.kind == "between":
            np.testing.assert_allclose(
                columns[:, :, 2], points[:, part.to] - points[:, part.at], rtol=0, atol=1e-9 * model.size
            )
        if part.kind == "corners":  # the mesh's corners are points of the body
            item = next(i for i in animation.scene.items if i.kind == "hull" and i.name == part.name)
            corners = np.einsum("nij,mj->nmi", columns, model.meshes[part.mesh].vertices) + places[:, k, None, :, 3]
            for p in item.points:
                near = np.linalg.norm(corners - points[:, None, p], axis=-1).min(axis=1)
                assert near.max() <= 0.076 * model.size  # half of the thickness of what lies in a plane


def until(page, condition):
    """Wait for a condition; the page's policy forbids what waits within it."""
    for _ in range(600):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(50)
    pytest.fail(condition)


@pytest.mark.parametrize("width", [1280, pytest.param(390, marks=pytest.mark.slow)])
def test_a_page_plays_scrubs_and_turns_by_hand(tmp_path, width):
    """Clicks, keys and touches; poses equal Python's; no message, no request, nothing beyond the page's width."""
    sol = motion("four_bar", 2.0)
    animation = kn.figures.animate(sol, tmp_path / "motion.html", autoplay=False)
    places = transforms(animation.model, animation.courses[0].poses)
    with chromium(*GL) as browser:
        context = browser.new_context(viewport={"width": width, "height": 800}, has_touch=True)
        page = context.new_page()
        said: list[str] = []
        page.on("console", lambda m, said=said: said.append(m.text))
        page.on("pageerror", lambda e, said=said: said.append(str(e)))
        page.on("request", lambda r, said=said: said.append(r.url) if not r.url.startswith("file:") else None)
        page.goto((tmp_path / "motion.html").as_uri())
        view = "document.querySelector('.kane-view').viewer"
        until(page, f"!!{view}?.slider")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for k in (0, 57, 199):
            t = float(animation.courses[0].times[k])
            for part in range(len(animation.model.parts)):
                shown = np.reshape(page.evaluate(f"{view}.matrix({part}, {t!r})"), (4, 3)).T
                np.testing.assert_allclose(shown, places[k, part], rtol=0, atol=1e-6)
        begin = page.evaluate(f"[{view}.t, {view}.azimuth, {view}.height, {view}.distance]")
        page.get_by_role("button", name="play").click()
        until(page, f"{view}.t > 0.2")
        page.get_by_role("button", name="pause").click()
        assert not page.evaluate(f"{view}.playing")
        page.get_by_label("time").fill("0.5")
        assert page.evaluate(f"{view}.t") == pytest.approx(1.0)
        box = page.locator("canvas").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 60, y + 20)
        page.mouse.up()
        turned = page.evaluate(f"[{view}.azimuth, {view}.height]")
        assert turned[0] < begin[1] - 0.3
        assert turned[1] > begin[2] + 0.1
        page.keyboard.press("ArrowLeft")
        page.keyboard.press("+")
        page.keyboard.press(".")
        after = page.evaluate(f"[{view}.t, {view}.azimuth, {view}.height, {view}.distance]")
        assert after[0] > 1.0
        assert after[1] < turned[0]
        assert after[3] < begin[3]
        page.keyboard.press("Home")
        page.touchscreen.tap(x, y)
        assert page.evaluate(f"{view}.azimuth") == begin[1]
        pixels = page.evaluate(
            f"(() => {{ {view}.paint(); const c = {view}.canvas, g = {view}.gl, p = new Uint8Array(4 * c.width * c.height);"
            " g.readPixels(0, 0, c.width, c.height, g.RGBA, g.UNSIGNED_BYTE, p); const s = new Set();"
            " for (let k = 0; k < p.length; k += 4) s.add(p[k] * 65536 + p[k + 1] * 256 + p[k + 2]); return s.size; })()"
        )
        assert pixels > 20
        assert said == []
        context.close()


def test_gltf(tmp_path):
    """The chunks, and translations, rotations and scales that give the places again."""
    animation = kn.figures.animate(motion("flyball_governor"))
    data = animation.save(tmp_path / "motion.glb").read_bytes()
    magic, version, length = struct.unpack_from("<III", data)
    assert (magic, version, length) == (0x46546C67, 2, len(data))
    size, kind = struct.unpack_from("<II", data, 12)
    assert kind == 0x4E4F534A
    document = json.loads(data[20 : 20 + size])
    blob = data[28 + size :]

    def array(k):
        accessor = document["accessors"][k]
        view = document["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        kind = "<u4" if accessor["componentType"] == 5125 else "<f4"
        return np.frombuffer(blob, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)

    from scipy.spatial.transform import Rotation

    places = transforms(animation.model, animation.courses[0].poses)
    moving = {(c["target"]["node"], c["target"]["path"]): c["sampler"] for c in document["animations"][0]["channels"]}
    samplers, count = document["animations"][0]["samplers"], len(places)
    for k in range(len(animation.model.parts)):
        node, parts = document["nodes"][k], {}
        for path in ("translation", "rotation", "scale"):
            still = np.broadcast_to(np.array(node[path]), (count, len(node[path])))
            parts[path] = array(samplers[moving[k, path]]["output"]) if (k, path) in moving else still
        columns = Rotation.from_quat(parts["rotation"]).as_matrix() * parts["scale"][:, None, :]
        np.testing.assert_allclose(columns, places[:, k, :, :3], atol=1e-6 * animation.model.size)
        np.testing.assert_allclose(parts["translation"], places[:, k, :, 3], atol=1e-6 * animation.model.size)
        mesh = document["meshes"][node["mesh"]]["primitives"][0]
        assert array(mesh["indices"]).max() < len(array(mesh["attributes"]["POSITION"]))
    assert document["asset"]["version"] == "2.0"


@pytest.mark.slow
def test_pictures(tmp_path):
    """A first picture has the body's colour, and a moving one as many pictures as are played."""
    sol = motion("pendulum", 1.2)
    still = np.asarray(
        Image.open(kn.figures.animate(sol, tmp_path / "a.png") and tmp_path / "a.png").convert("RGB"), int
    )
    blue = (np.abs(still - [37, 99, 168]).sum(axis=-1) < 90).mean()
    assert 0.0005 < blue < 0.3
    kn.figures.animate(sol, tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as moving:
        assert 20 <= moving.n_frames <= 30


@pytest.mark.slow
@pytest.mark.filterwarnings(
    "ignore:os.fork:RuntimeWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)  # beside JAX
def test_a_video_plays(tmp_path):
    """Decoded again: size, rate, duration and number of pictures, and the pictures that were drawn."""
    ffmpeg = require("imageio_ffmpeg")
    sol = motion("pendulum", 1.2)
    path = kn.figures.animate(sol, tmp_path / "a.mp4") and tmp_path / "a.mp4"
    kn.figures.animate(sol, tmp_path / "a.png")
    call = [ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(call, capture_output=True, check=True)
    told = done.stderr.decode()
    # H.264 in yuv420p is what browsers and presentations play
    assert re.search(r"Video: h264 .*yuv420p.* 800x480.* 25 fps", told), told
    assert "Duration: 00:00:01.20" in told
    pictures = np.frombuffer(done.stdout, np.uint8).reshape(-1, 480, 800, 3).astype(int)
    assert len(pictures) == 30
    still = np.asarray(Image.open(tmp_path / "a.png").convert("RGB"), int)
    off = [np.abs(p - still).mean() for p in pictures]
    assert off[0] < 2
    assert max(off) > off[0] + 1
    assert path.read_bytes().index(b"moov") < path.read_bytes().index(b"mdat")


@pytest.mark.parametrize("end", ["stl", "obj"])
def test_mesh_files(tmp_path, end):
    """A tetrahedron, in text: its volume and its outward normals."""
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    if end == "obj":
        text = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(
            f"f {a + 1}/1 {b + 1} {c + 1}\n" for a, b, c in faces
        )
    else:
        loops = ["".join(f"vertex {' '.join(map(str, corners[k]))}\n" for k in f) for f in faces]
        vertex = "".join(f"facet normal 0 0 0\nouter loop\n{loop}endloop\nendfacet\n" for loop in loops)
        text = f"solid t\n{vertex}endsolid t\n"
    (tmp_path / f"t.{end}").write_text(text)
    assert volume(read(str(tmp_path / f"t.{end}"))) == pytest.approx(1 / 6)


def test_what_is_refused(tmp_path):
    sol = motion("pendulum")
    N = sol.equations.system.inertial
    with pytest.raises(kn.errors.ArgumentError, match=r"ends in \.html, \.glb"):
        kn.figures.animate(sol, tmp_path / "a.xyz")
    with pytest.raises(kn.errors.ArgumentError, match="Expected a motion from kn"):
        kn.figures.animate(sol.equations)
    with pytest.raises(kn.errors.ArgumentError, match="traces of points"):
        kn.figures.animate(sol, traces=[kn.Point("X", fixed_in=N).at("Y", N.x * 7.5)])
    for name in ("mine.html", "mine.png"):
        (tmp_path / name).write_text("mine")
        with pytest.raises(kn.KaneError, match=rf"{name}"):
            kn.figures.animate(sol, tmp_path / name)
    kn.figures.animate(sol, tmp_path / "own.png").save(tmp_path / "own.png")  # its own is replaced


def test_up_is_against_gravity_as_the_motion_has_it():
    """A slope by a parameter: of the motion its value counts, not its default."""
    N = kn.Frame("N")
    alpha, x, g = kn.parameter("alpha", 0.0, "rad"), kn.coordinate("x", "m"), kn.parameter("g", 9.81, "m/s^2")
    ball = kn.Particle("ball", kn.Point("O", fixed_in=N).at("P", x * N.x), 1.0)
    loads = [kn.gravity(g * (kn.sin(alpha) * N.x - kn.cos(alpha) * N.y))]
    eom = kn.derive(kn.System(N, bodies=[ball], speeds="rates", loads=loads))
    for slope in (0.0, np.pi / 2):
        sol = kn.simulate(eom, (0, 0.1), samples=3, q=[0], u=[0], parameters={alpha: slope})
        np.testing.assert_allclose(kn.animate(sol).model.up, [-np.sin(slope), np.cos(slope), 0], atol=1e-15)


@pytest.mark.parametrize(
    ("name", "up"), [("car_with_trailer", [0, 0, 1]), ("snakeboard", [0, 0, 1]), ("four_bar", [0, 1, 0])]
)
def test_wheels_stand_on_the_floor(name, up):
    """A linkage without gravity is seen as it is drawn, with y up; what rolls in this plane is seen on the floor."""
    model = load(name)
    eom = kn.derive(model.system().replace(loads=[]))
    given = {"inputs": dict.fromkeys((u.name for u in eom.inputs if isinstance(u, kn.expr.Input)), 0.1)}
    sol = kn.simulate(eom, (0, 0.1), samples=3, q=model.START["q"], u=dict.fromkeys(model.START["u"], 0.0), **given)
    assert kn.animate(sol).model.up.tolist() == up


@pytest.mark.parametrize(
    ("kind", "sizes", "exact"),
    [
        ("frustum", (2.0, 0.0, 3.0), np.pi * 4),
        ("frustum", (0.0, 2.0, 3.0), np.pi * 4),
        ("capsule", (0.5, 0.0), np.pi / 6),
        ("torus", (2.0, 0.0), 0.0),
        ("capsule", (0.0, 2.0), 0.0),
        ("frustum", (2.0, 1.0, 0.0), 0.0),
    ],
)
def test_sizes_that_vanish_leave_a_mesh(kind, sizes, exact):
    mesh = SIZED[kind][0](*sizes)
    assert np.isfinite(mesh.normals).all()
    assert volume(mesh) == pytest.approx(exact, rel=0.03, abs=1e-12)


def test_a_motion_from_a_pickle_is_played_at_its_samples(tmp_path, monkeypatch):
    """Nothing can be run again: pictures show each sample as long as it is the nearest one, and each is made once."""
    quantized, quantize = [], Image.Image.quantize
    monkeypatch.setattr(Image.Image, "quantize", lambda *a, **more: quantized.append(a) or quantize(*a, **more))
    sol = pickle.loads(pickle.dumps(motion("pendulum")))
    made = kn.animate(sol, tmp_path / "a.gif")
    np.testing.assert_array_equal(made.courses[0].times, sol.t)
    assert len(quantized) == len(sol.t)
    with Image.open(tmp_path / "a.gif") as picture:
        lasts = []
        for k in range(picture.n_frames):
            picture.seek(k)
            lasts.append(picture.info["duration"])
    assert sum(lasts) == pytest.approx(1000 * made.played)
    assert np.ptp(lasts[1:-1]) <= 40
    assert lasts[0] == pytest.approx(lasts[1] / 2, abs=40)
    assert kn.report(sol.equations, tmp_path / "a.html", solution=sol).is_file()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.stl", "solid t\nvertex 0 0 0\nvertex 1 0 x\nvertex 0 1 0\n"),
        ("b.stl", "solid t\nvertex 0 0 0\nvertex 1 0 0\n"),
        ("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
        ("d.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 a\n"),
        ("e.obj", "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n"),
    ],
)
def test_a_mesh_that_is_none_is_named(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(kn.ModelError, match=rf"a mesh as STL or OBJ, got .*{name}"):
        read(str(tmp_path / name))


def test_the_name_of_an_stl_is_no_vertex(tmp_path):
    (tmp_path / "a.stl").write_text("solid vertex of a part\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid\n")
    np.testing.assert_array_equal(read(str(tmp_path / "a.stl")).vertices, [(0, 0, 0), (1, 0, 0), (0, 1, 0)])


@pytest.mark.parametrize("gap", [" ", "\n", "\r\n", "\t"])
def test_words_of_an_stl_stand_on_any_lines(tmp_path, gap):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    loop = gap.join(f"vertex {x} {y} {z}" for x, y, z in corners)
    text = gap.join(["solid t", "facet normal 0 0 1", f"outer loop {loop}", "endloop", "endfacet", "endsolid t"])
    (tmp_path / "a.stl").write_text(text, newline="")
    np.testing.assert_array_equal(read(str(tmp_path / "a.stl")).vertices, corners)


def test_pictures_have_paths_and_ghosts_as_pages_have(tmp_path):
    """The path of a point ends where the point is; a ghost's colour is its body's, nearer to the paper's."""
    module = load("pendulum")
    eom = kn.derive(module.system())
    sols = [kn.simulate(eom, (0, 0.3), samples=4, q=[q], u=[0]) for q in (1.0, -1.0)]
    sols = pickle.loads(pickle.dumps(sols))  # they have few pictures
    center = sols[0].equations.system.bodies[0].mass_center

    def last(name, *given, **more):
        kn.animate(*given, tmp_path / name, **more)
        with Image.open(tmp_path / name) as picture:
            picture.seek(picture.n_frames - 1)
            return np.asarray(picture.convert("RGB")).astype(int)

    alone, path, both = last("a.webp", sols[0]), last("b.webp", sols[0], traces=[center]), last("c.webp", sols)

    def near(picture, colour):
        return np.abs(picture - colour).max(axis=2) < 40

    pink, blue = (0xB3, 0x26, 0x6B), (0x25, 0x63, 0xA8)
    drawn, body = near(path, pink), near(alone, blue)
    assert not near(alone, pink).any()
    assert drawn.sum() > 50
    assert 0 < np.abs(path - alone).max(axis=2).astype(bool).sum() < 0.05 * drawn.size
    changed = np.abs(both - alone).max(axis=2) > 8
    assert changed.sum() > 50
    assert near(both, blue).sum() < 1.05 * body.sum()  # the other is paler
    assert np.argwhere(changed)[:, 1].mean() < np.argwhere(body)[:, 1].mean()


@pytest.mark.parametrize("zero", ["m", "l", "I"])
def test_what_has_no_mass_length_or_inertia_is_drawn(zero, tmp_path):
    """By parameters at zero: an ellipsoid of no mass has no size, and a bar that leads nowhere no end."""
    eom = kn.derive(load("pendulum").system())
    sol = kn.simulate(eom, (0, 0.1), samples=3, q=[0.5], u=[0], parameters={zero: 0.0})
    made = kn.animate(sol, tmp_path / "a.glb")
    assert np.isfinite(transforms(made.model, made.courses[0].poses)).all()

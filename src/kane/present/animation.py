# SPDX-License-Identifier: BSD-3-Clause
"""`animate`: an animation of a motion, in an HTML page or a notebook, as glTF, or as pictures."""

import html
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from kane import expect
from kane.errors import ArgumentError, SimulationError, cut
from kane.expr.node import ZERO
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.present.check_figures import taken
from kane.present.languages.catalogue import N_, tr
from kane.present.pages import as_json, asset, carried, environment
from kane.present.scene.gather import scene as scene_of
from kane.present.scene.records import Posed, Scene, against_gravity
from kane.present.scene.shapes import BodyShape
from kane.present.viewer.page import PosedMotion, lowest, page_data
from kane.present.viewer.parts import DrawnModel, model
from kane.space.frame import Point
from kane.whole import FIGURES, exchange_marked, path_of

_RATE, _FEWEST, _MOST = 30.0, 200, 1800
"""Instants per second of the animation, and their least and largest number."""
_PLAYED = 8.0
"""Duration (s) of the animation of a motion shorter than 1 s, or much longer."""
_MARK = b'<meta name="generator" content="kane">'
_MARKS = (_MARK, b'"generator":"kane"', FIGURES[0], b"made by kane")
"""Marks by which files written by `save` are recognized: pages, glTF, PNG and other pictures."""
MODE_COLOURS = {
    N_("separated"): "#c9ced6", N_("closed"): "#8fbcf2", N_("stick"): "#5b9be6", N_("slip"): "#f2994a",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Animation:
    """An animation of one or several motions, from `kn.figures.animate`; notebooks display it, and `save` writes a file."""

    solutions: tuple[Solution, ...]
    scene: Scene
    courses: tuple[PosedMotion, ...]
    traces: tuple[int, ...]
    autoplay: bool

    @cached_property
    def model(self) -> DrawnModel:
        """The parts to draw."""
        poses = self.courses[0].poses
        # without gravity up is the third inertial axis, or the second if all points are in the plane of the first two without wheels
        upright = all(p[2] is ZERO for p in self.scene.positions) and not any(
            x.kind == "wheel" for x in self.scene.items
        )
        up = np.eye(3)[1 if upright else 2]
        return model(self.scene, poses, against_gravity(self.scene, poses.directions[0], up))

    @cached_property
    def camera(self) -> dict[str, Any]:
        """The initial position of the camera."""
        front = _front(self.scene, self.courses[0], self.model.up)
        return {"front": front.tolist(), "azimuth": 0.45, "height": 0.28}

    @cached_property
    def low(self) -> float:
        """The height of the floor, below all parts throughout the motion."""
        return lowest(self.scene, self.model, self.courses)

    @property
    def played(self) -> float:
        """Duration of the animation (s)."""
        return _played(float(self.courses[0].times[-1] - self.courses[0].times[0]))

    def part(self, extra: Array | None = None, words: Iterable[str] = ()) -> Markup:
        """The HTML of the viewer, without its style and script; `extra` are further columns of data of the first motion.

        `words` are modes of contacts to include in the legend in addition to those in the motion.
        """
        courses = self.courses if extra is None else (replace(self.courses[0], extra=extra), *self.courses[1:])
        data = page_data(self.scene, self.model, courses, self.traces, self.camera)
        strips = [(name, _gradient(runs, self.courses[0].times)) for name, runs in self._modes().items()]
        known = {mode for runs in self._modes().values() for _, mode in runs}.union(words)
        seen = [m for m in MODE_COLOURS if m in known]
        return Markup(
            environment().get_template("viewer.html").render(
                label=_label(self.scene), picture=Markup(""), forces=bool(self.model.arrows), traces=bool(self.traces),
                strips=strips, key=[(tr(m), MODE_COLOURS[m]) for m in seen], data=Markup(as_json(data)), autoplay=self.autoplay,
            )
        )  # fmt: skip

    def _modes(self) -> Mapping[str, list[tuple[float, str]]]:
        history = self.solutions[0].mode_history
        result: dict[str, list[tuple[float, str]]] = {}
        for t, modes in history:
            for name, mode in modes.items():
                own = result.setdefault(name, [])
                if not own or own[-1][1] != mode:
                    own.append((float(t), mode))
        return result

    def html(self) -> str:
        """A self-contained HTML page."""
        css, js = (asset(name, "templates") for name in ("viewer.css", "viewer.js"))
        given = {"title": _label(self.scene), "css": Markup(css), "carried": carried("", js)}
        page = environment().get_template("animation.html")
        return page.render(part=self.part(), mark=Markup(_MARK.decode()), **given)

    def _repr_html_(self) -> str:
        page = html.escape(self.html(), quote=True)
        title = html.escape(_label(self.scene))
        return f'<iframe srcdoc="{page}" style="width:100%;height:36rem;border:0" title="{title}"></iframe>'

    def save(self, path: str | Path) -> Path:
        """Write the animation: `.html`, `.glb` (glTF), `.gif`, `.webp`, `.png` (the first instant), `.mp4` (by imageio-ffmpeg).

        Raises
        ------
        ArgumentError
            if the path has a different ending, or is that of a file not written by `kane`
        """
        place = path_of(path, 'kn.animate(sol, "motion.html")')
        exchange_marked(place, partial(self._writer(place), self), *_MARKS)
        return place

    def write(self, path: Path) -> None:
        """Write a file in the format of its ending, whatever its present content."""
        self._writer(path)(self, path)

    def _writer(self, path: Path) -> "Callable[[Animation, Path], object]":
        result = FORMATS.get(path.suffix.lower())
        if result is None:
            raise ArgumentError(f"Expected a file that ends in {', '.join(FORMATS)}, got {str(path)!r}.")
        return result

    def __repr__(self) -> str:
        t = self.courses[0].times
        return f"Animation({_label(self.scene)}: {len(self.model.parts)} parts, t = {t[0]:g} … {t[-1]:g} s, {len(t)} instants)"


def animate(
    solution: Solution | Sequence[Solution],
    path: str | Path | None = None,
    *,
    shapes: Iterable[BodyShape] = (),
    traces: Iterable[Point] = (),
    autoplay: bool = True,
) -> Animation:
    """Animate a motion in three dimensions: bodies with their shapes, to rotate, play and step through.

    Parameters
    ----------
    solution : a motion, from `kn.simulate`; one read from a file is shown at its samples. Of several motions of one system, all
        but the first are pale "ghosts", and glTF has the first alone
    path : file to write: `.html` (self-contained), `.glb`, `.gif`, `.webp`, `.png`, `.mp4`
    shapes : shapes of bodies and surroundings, from `kn.figures.shape`; by default derived from inertias, points, joints and
        contacts
    traces : points whose paths are drawn, in pages and pictures
    autoplay : whether the page plays at once, unless the reader's system asks for reduced motion

    Returns
    -------
    Animation
        displayed by notebooks; `save(path)` writes it

    Raises
    ------
    ArgumentError
        if `solution` is not a motion, or the file cannot be written
    ModelError
        if shapes belong to bodies of another system, or the file of a mesh cannot be read
    """
    solutions = [solution] if not isinstance(solution, Sequence) else list(solution)
    if not solutions or not all(isinstance(s, Solution) for s in solutions):
        raise ArgumentError(f"Expected a motion from kn.simulate to animate, or several, got {cut(repr(solution))}.")
    given = tuple(expect.instances(traces, Point, "traces= to be points", "Write traces=[P]."))
    made = animation_of(solutions, scene_of(solutions[0].equations, shapes), given, autoplay)
    if path is not None:
        made.save(path)
    return made


def animation_of(solutions: Sequence[Solution], scene: Scene, traces: Sequence[Point], autoplay: bool) -> Animation:
    """An animation of motions of one system whose scene is known."""
    numbers = tuple(_point_index(scene, p) for p in traces)
    return Animation(tuple(solutions), scene, tuple(course(scene, s) for s in solutions), numbers, autoplay)


def _point_index(scene: Scene, point: Point) -> int:
    """The index of a point's position in the scene; raises an error if the scene does not contain it."""
    wanted = point.position(point.root()).components(scene.system.inertial)
    for k, place in enumerate(scene.positions):
        if all(a is b for a, b in zip(place, wanted, strict=True)):
            return k
    raise ArgumentError(
        f"Expected traces of points that the drawing has, got {point.name}: give it a kn.figures.shape, or trace a body's point."
    )


def course(scene: Scene, solution: Solution) -> PosedMotion:
    """The poses at instants for playing; for a motion that cannot be evaluated between samples, as one from a file, at its samples."""
    try:
        motion = solution.at(_instants(solution))
    except SimulationError:
        motion = taken(solution, np.flatnonzero(np.append(np.diff(solution.t) > 0, True)))
    symbols = list(scene.symbols)
    poses = scene.poses(dict(zip(symbols, motion[symbols], strict=True)) if symbols else {})
    axes = {"positions": 2, "rotations": 3, "directions": 2, "scalars": 1}
    return PosedMotion(
        motion, Posed(**{what: _spread(getattr(poses, what), len(motion), n) for what, n in axes.items()})
    )


def _spread(values: Array, count: int, axes: int) -> Array:
    return np.broadcast_to(values, (count, *values.shape[-axes:])) if values.ndim == axes else values


def _instants(solution: Solution) -> Array:
    begin, end = float(solution.t[0]), float(solution.t[-1])
    span = end - begin
    count = int(np.clip(_RATE * _played(span), _FEWEST, _MOST)) if span > 0 else 1
    return np.linspace(begin, end, count)


def _played(span: float) -> float:
    return span if 1.0 < span < 5 * _PLAYED else _PLAYED


def _front(scene: Scene, course: PosedMotion, up: Array) -> Array:
    """The direction from which to look: normal to the plane of a planar system, or else along the horizontal axis that hides least."""
    p = course.poses.positions.reshape(-1, 3)
    p = p[np.isfinite(p).all(axis=1)]
    spread = p - p.mean(axis=0) if len(p) else np.zeros((1, 3))
    spread = spread - np.outer(spread @ up, up)
    _, s, v = np.linalg.svd(spread, full_matrices=True)
    if s.size and s[0] > 0:
        front = np.cross(v[0], up)
        size = float(np.linalg.norm(front))
        if size > 1e-9:
            front = front / size
            return front if front @ np.array([-0.3, -1.0, 0.9]) >= 0 else -front
    near = np.eye(3)[int(np.argmin(np.abs(up)))]
    return np.asarray(np.cross(up, np.cross(near, up)))


def _label(scene: Scene) -> str:
    names = [b.name for b in scene.system.bodies]
    return tr("Motion of %(bodies)s", bodies=f"{', '.join(names[:4])}{' …' if len(names) > 4 else ''}")


def _gradient(runs: Sequence[tuple[float, str]], times: Array) -> str:
    begin, end = float(times[0]), float(times[-1])
    stops = []
    for (t, mode), after in zip(runs, [*(t for t, _ in runs[1:]), end], strict=True):
        a, b = (100 * (x - begin) / ((end - begin) or 1.0) for x in (t, after))
        stops.append(f"{MODE_COLOURS.get(mode, '#999')} {max(a, 0):.3f}% {min(b, 100):.3f}%")
    return f"linear-gradient(to right, {', '.join(stops)})"


def _write_gltf(animation: Animation, place: Path) -> None:
    from kane.present.viewer.gltf import binary

    place.write_bytes(binary(animation.model, animation.courses[0]))


def _write_pictures(animation: Animation, place: Path) -> None:
    from kane.present.viewer.raster import PictureView, write

    camera, front = animation.camera, np.array(animation.camera["front"])
    shown = animation.model, animation.courses, animation.traces
    write(PictureView(*shown, front, camera["azimuth"], camera["height"], animation.low, animation.played), place)


FORMATS: dict[str, Callable[[Animation, Path], object]] = {
    ".html": lambda animation, place: place.write_text(animation.html(), encoding="utf-8"),
    ".glb": _write_gltf,
    **dict.fromkeys((".gif", ".png", ".mp4", ".webp"), _write_pictures),
}
"""The writer of each format."""

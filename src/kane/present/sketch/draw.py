# SPDX-License-Identifier: BSD-3-Clause
"""`sketch`: a drawing of a system, with labelled coordinates."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from kane import expect
from kane.equations.equations import Equations
from kane.errors import ArgumentError
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.present.languages.catalogue import N_, tr
from kane.present.scene.gather import scene as scene_of
from kane.present.scene.records import Item, Posed, Scene
from kane.present.scene.shapes import BodyShape
from kane.present.sketch.body_drawings import draw_items
from kane.present.sketch.camera import View, view_of
from kane.present.sketch.labels import Label, placed
from kane.present.sketch.outlines import outline
from kane.present.sketch.paper import Paper, Stroke, rod_ends
from kane.present.sketch.pose import pose_of
from kane.present.sketch.signs import draw_signs
from kane.present.sketch.svg import render
from kane.units.rules import unit_text
from kane.whole import exchange_marked, path_of

WIDE, NARROW = 640, 330
"""Widths of sketches for a desktop screen and for a phone."""
_MARGIN = 50.0
_FITS = 2
"""Number of corrections of the scale, as arrows and letters do not scale with the drawing."""
_LEAST, _MOST = 240, 2000
_MOST_INERTIA = 0.45
"""Largest semi-axes of ellipsoids of inertia, relative to the typical length."""
MARKS = (b'class="kane-sketch"', b"/Creator (kane sketch)", b"Software\0kane sketch")
"""Marks by which a sketch file is recognized."""


@dataclass(frozen=True, slots=True, eq=False)
class Sketch:
    """A sketch as SVG, which notebooks display; `labels` are its texts with their boxes, `strokes` its lines, `scene` its source."""

    svg: str
    width: int
    height: int
    labels: tuple[Label, ...]
    scene: Scene
    strokes: tuple[Stroke, ...]

    def _repr_svg_(self) -> str:
        return self.svg

    def _repr_html_(self) -> str:
        return self.svg

    def save(self, path: str | Path) -> Path:
        """Write the sketch as SVG, PDF or PNG by the ending of the path, and return the path; only files of sketches are replaced."""
        target = path_of(path, 'sketch.save("system.svg")')
        known = target.suffix.lower() in ("", *FORMATS)
        expect.that(
            known,
            f"a file for the sketch that ends in {', '.join(FORMATS)}",
            came=repr(str(target)),
            error=ArgumentError,
        )
        exchange_marked(target, partial(save, self), *MARKS)
        return target

    def __repr__(self) -> str:
        return f"Sketch({', '.join(b.name for b in self.scene.system.bodies)}; {self.width} × {self.height})"


FORMATS = (".svg", ".pdf", ".png")
"""Endings of sketch files."""


def save(drawn: Sketch, path: Path) -> None:
    """Write a sketch in the format of the path's ending."""
    if path.suffix.lower() not in FORMATS[1:]:
        path.write_text(drawn.svg, encoding="utf-8")
        return
    from kane.present.sketch.printed import printed  # matplotlib only here

    printed(drawn.strokes, drawn.labels, drawn.width, drawn.height, path)


def sketch(
    system: System | Equations,
    path: str | Path | None = None,
    *,
    width: int = WIDE,
    q: Mapping[Any, float] | None = None,
    shapes: Iterable[BodyShape] = (),
    title: str | None = None,
) -> Sketch:
    """A labelled drawing of a system: bodies, frames, loads at their points, coordinates as arcs and arrows.

    Pose and camera are chosen automatically; a planar system is drawn in its plane. The placement of labels depends on `width`.

    Parameters
    ----------
    system : a System, or its Equations
    path : file to write, `.svg`, `.pdf` or `.png`
    width : width of the drawing, 240 to 2000 pixels
    q : coordinates of the pose, by symbol or name; those left out are chosen automatically
    shapes : shapes of bodies, from `kn.figures.shape`
    title : by default the names of the bodies

    Raises
    ------
    ArgumentError
        if `system` is neither a System nor Equations, or the path has a different ending
    ModelError
        if shapes belong to bodies of another system, `width` is out of range, or `q` contains a name that is not a coordinate, or
        a value that is not finite
    """
    right = expect.is_number(width) and _LEAST <= width <= _MOST
    expect.that(right, f"width= of a sketch as pixels from {_LEAST} to {_MOST}", width)
    expect.that(title is None or isinstance(title, str), "title= of a sketch as a text", title)
    drawn = draw(scene_of(system, shapes), int(width), q, title)
    if path is not None:
        drawn.save(path)
    return drawn


def draw(scene: Scene, width: int, q: Any = None, title: str | None = None) -> Sketch:
    """The sketch of a scene with one width."""
    return next(iter(draw_each(scene, (width,), q, title)))


def draw_each(scene: Scene, widths: Iterable[int], q: Any = None, title: str | None = None) -> list[Sketch]:
    """Sketches of a scene with several widths, in one pose and view."""
    pose = pose_of(scene, q)
    view = view_of(scene, pose)
    head = title or tr("Sketch of %(bodies)s", bodies=", ".join(b.name for b in scene.system.bodies))
    made = []
    for width in widths:
        paper = _drawn(_paper(scene, pose.posed, view, width, pose.size), scene, pose.posed)
        for _ in range(_FITS):
            paper = _drawn(_fitted(paper), scene, pose.posed)
        labels = placed(paper.labels, *paper.obstacles(), paper.width, paper.height)
        svg = render(paper, labels, head, describe(scene, view))
        made.append(Sketch(svg, width, round(paper.height), tuple(labels), scene, tuple(paper.strokes)))
    return made


def _paper(scene: Scene, posed: Posed, view: View, width: int, size: float) -> Paper:
    """A drawing surface with a scale at which everything fits between margins."""
    limit = _MOST_INERTIA * size
    flat = view.flat(np.concatenate([_cloud(i, posed, limit) for i in scene.items] + [_drawn_points(scene, posed)]))
    low, high = flat.min(axis=0), flat.max(axis=0)
    extent = np.maximum(high - low, 1e-12)
    small = width < 480
    margin = (_MARGIN if not small else 40.0) + 14.0
    most = width * (0.95 if small else 0.66)
    room = np.array([width - 2 * margin, most - 2 * margin])
    scale = float(min(room / np.maximum(extent, 0.35 * max(extent.max(), 0.3 * size))))
    height = float(np.clip(extent[1] * scale + 2 * margin, 0.42 * width, most))
    middle = (low + high) / 2 * (scale, -scale)
    return Paper(view, float(width), height, scale, np.array([width / 2, height / 2]) - middle, most=limit)


def _drawn(paper: Paper, scene: Scene, posed: Posed) -> Paper:
    draw_items(paper, scene, posed)
    draw_signs(paper, scene, posed)
    return paper


def _fitted(paper: Paper) -> Paper:
    """A new drawing surface on which all that was drawn on this one fits between the margins."""
    drawn = [s.points for s in paper.strokes if not s.look.startswith(("floor", "ground", "hatch", "force"))]
    points = np.concatenate(drawn)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = (30.0 if paper.small else 38.0) * np.array([1.0, 0.9])
    width, most = paper.width, paper.width * (0.95 if paper.small else 0.66)
    extent = np.maximum(high - low, 1e-9)
    ratio = float(min((np.array([width, most]) - 2 * margin) / extent))
    ratio = min(ratio, 1.0) if ratio < 1 else min(ratio, 1.15)
    height = float(np.clip(extent[1] * ratio + 2 * margin[1], 0.42 * width, most))
    shift = np.array([width / 2, height / 2]) - ((low + high) / 2 - paper.shift) * ratio
    return Paper(paper.view, width, height, paper.scale * ratio, shift, most=paper.most)


def _cloud(item: Item, posed: Posed, most: float) -> Array:
    shape = outline(item, posed, most)
    return rod_ends(item, posed) if shape is None else shape.cloud


def _drawn_points(scene: Scene, posed: Posed) -> Array:
    """The points of items, movements, marks and triads."""
    used = [k for i in scene.items if i.role != "ground" for k in (*i.points, *(() if i.at is None else (i.at,)))]
    used += [k for m in scene.movements for k in m.points] + [m.at for m in scene.marks] + [t.at for t in scene.triads]
    return np.asarray(posed.positions[sorted(set(used))])


def describe(scene: Scene, view: View) -> str:
    """The content of the sketch, in words."""
    system = scene.system
    bodies = ", ".join(b.name for b in system.bodies)
    flat, spatial = (
        tr("Drawing in the plane of motion: %(bodies)s.", bodies=bodies),
        tr("Drawing in space: %(bodies)s.", bodies=bodies),
    )
    said = [flat if view.plane else spatial]
    named = {q.name: q for q in system.coordinates}
    for m in scene.movements:
        for name in m.symbols:
            q = named[name]
            unit = f" [{unit_text(q.unit)}]" if q.unit else ""
            said.append(f"{name}: {q.description or tr(_WORDS[m.kind], frame=m.frame)}{unit}.")
    acting = [a.name for a in scene.actions if a.kind != "contact"]
    if acting:
        said.append(tr("Loads: %(loads)s.", loads=", ".join(acting)))
    return " ".join(said)


_WORDS = {
    "turn": N_("angle of %(frame)s"),
    "shift": N_("displacement of %(frame)s"),
    "attitude": N_("orientation of %(frame)s"),
    "deflection": N_("deformation of %(frame)s"),
    "none": N_("without a place"),
}

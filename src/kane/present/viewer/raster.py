# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of a motion without a browser, as PNG, GIF, WebP and MP4: triangles are shaded, sorted by distance, and drawn."""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import groupby, product, repeat
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from kane import expect
from kane.errors import ArgumentError
from kane.numeric.arrays import Array
from kane.present.viewer.meshes import unit_rows
from kane.present.viewer.page import PosedMotion
from kane.present.viewer.parts import DrawnModel, colour_of, towards, transforms
from kane.progress import far, working

SIZE = (800, 480)
"""Columns and rows of a picture."""
PAPER, RULE, SHADOW, PATH = "#f4f4ef", "#cfcfc9", "#d3d3cd", "#b3266b"
_RATE = 25
_MARK = b"made by kane"
"""The mark by which a GIF, WebP or MP4 is recognized; a PNG by its software entry."""
_SPREAD = 0.26
"""Half the angle of view, rad."""
_GHOST = 0.3
"""Opacity of a ghost."""
_LINES = 24
"""Number of lines of the floor's grid in each direction."""


class PictureView(NamedTuple):
    """The drawn model, motions, camera (`front` is the direction of azimuth 0), floor height and duration (s).

    Motions after the first are ghosts; `traces` are the indices of positions whose paths in the first motion are drawn.
    """

    model: DrawnModel
    courses: Sequence[PosedMotion]
    traces: Sequence[int]
    front: Array
    azimuth: float
    height: float
    low: float
    played: float


def write(shot: PictureView, place: Path) -> None:
    """Draw the motion into a file, in the format of its ending."""
    end = place.suffix.lower()
    with working("Drawing"):
        pictures = frames(shot, first=end == ".png")
        if end == ".png":
            info = PngInfo()
            info.add_text("Software", "kane")
            next(pictures).save(place, pnginfo=info)
        elif end == ".mp4":
            _video(pictures, place)
        else:
            own = list[Image.Image]()
            for _, (shown, *others) in groupby(pictures, key=id):  # one that is shown for long is the same object
                own += [shown.quantize(128, dither=Image.Dither.NONE) if end == ".gif" else shown] * (1 + len(others))
            mark: dict[str, Any] = {"comment": _MARK} if end == ".gif" else {"xmp": _MARK}
            own[0].save(
                place, save_all=True, append_images=own[1:], duration=1000 // _RATE, loop=0, optimize=True, **mark
            )


def _video(pictures: Iterator[Image.Image], place: Path) -> None:
    lacking = "Expected imageio-ffmpeg for .mp4, which is not installed: pip install 'kane[video]', or write a .gif."
    ffmpeg = expect.package("imageio_ffmpeg", ArgumentError(lacking))
    told = ["-metadata", f"comment={_MARK.decode()}", "-movflags", "+faststart"]  # playable while loading
    writer = ffmpeg.write_frames(str(place), SIZE, fps=_RATE, macro_block_size=1, output_params=told)
    writer.send(None)
    for p in pictures:
        writer.send(np.ascontiguousarray(p))
    writer.close()


def frames(shot: PictureView, first: bool = False) -> Iterator[Image.Image]:
    """The pictures, `_RATE` per second of the animation."""
    own = shot.courses[0]
    now = np.linspace(own.times[0], own.times[-1], 1 if first else max(2, round(_RATE * shot.played)))
    nearest = [np.interp(now, c.times, np.arange(len(c.times))).round().astype(int).tolist() for c in shot.courses]
    chosen = list(zip(*nearest, strict=True))
    places = [transforms(shot.model, c.poses) for c in shot.courses]
    paths = own.poses.positions[:, list(shot.traces)]
    for n, (at, same) in enumerate(groupby(chosen), 1):
        far(partial("picture {} of {}".format, n, len(set(chosen))))
        shown = _picture(shot, [p[k] for p, k in zip(places, at, strict=True)], paths[: at[0] + 1])
        yield from repeat(shown, len(list(same)))


def _camera(shot: PictureView, places: Array) -> tuple[Array, Array]:
    """The eye, and the axes of the view as rows: right, up, back."""
    model, front, azimuth, height = shot.model, shot.front, shot.azimuth, shot.height
    up = model.up
    side = np.cross(up, front)
    away = np.cos(height) * (np.cos(azimuth) * front + np.sin(azimuth) * side) + np.sin(height) * up
    middle = places[:, :, 3].mean(axis=0) if model.travels else model.middle
    x = np.cross(up, away)
    x /= np.linalg.norm(x)
    return middle + 3.5 * model.reach * away, np.stack([x, np.cross(away, x), away])


def _picture(shot: PictureView, places: Sequence[Array], paths: Array) -> Image.Image:
    """One picture: the floor, shadows on it, then triangles from far to near, and paths (instants × paths × 3)."""
    model, low = shot.model, shot.low
    eye, axes = _camera(shot, places[0])
    seen = partial(_seen, eye, axes)
    front, up = shot.front, model.up
    light = up + 0.45 * front + 0.3 * np.cross(up, front)
    light /= np.linalg.norm(light)
    paper = np.array(to_rgb(PAPER))
    shadows, shapes, depths, colours = [], [], [], []
    for (ghost, own), (k, part) in product(enumerate(places), enumerate(model.parts)):
        mesh, place = model.meshes[part.mesh], own[k]
        points = mesh.vertices @ place[:, :3].T + place[:, 3]
        p = points[mesh.triangles]
        n = unit_rows(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]))
        kept = np.einsum("ij,ij->i", n, eye - p.mean(axis=1)) > 0  # the normal of a degenerate triangle is zero
        corners, depth = seen(points)
        flat, _ = seen(points - np.outer((points @ up - low) / (light @ up), light))
        tone = mesh.tones[mesh.triangles].mean(axis=1)[:, None]
        base = np.array(to_rgb(colour_of(model, part)))
        shade = (0.46 + 0.12 * (1 + n @ up) + 0.42 * np.clip(n @ light, 0, 1))[:, None]
        tinted = np.clip((base + (1 - base) * 0.42 * tone) * shade, 0, 1)[kept]
        shadows.append(flat[mesh.triangles[kept & (ghost == 0)]])
        shapes.append(corners[mesh.triangles[kept]])
        depths.append(depth[mesh.triangles[kept]].mean(axis=1))
        colours.append(paper + _GHOST * (tinted - paper) if ghost else tinted)
    order = np.argsort(-np.concatenate(depths), kind="stable")
    figure = Figure(figsize=(SIZE[0] / 100, SIZE[1] / 100), dpi=100, facecolor=PAPER)
    canvas = FigureCanvasAgg(figure)
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set(xlim=(0, SIZE[0]), ylim=(0, SIZE[1]))
    ax.axis("off")
    lines = _floor(seen, model, eye - 3.5 * model.reach * axes[2], low)
    ax.add_collection(LineCollection(lines, colors=RULE, linewidths=0.8, zorder=1), autolim=False)
    # Any: arrays are twice as fast, but matplotlib's annotations allow lists of triangles only
    shaded: Any = np.concatenate(shadows)
    faces: Any = np.concatenate(shapes)[order]
    shown = np.concatenate(colours)[order]
    ax.add_collection(
        PolyCollection(shaded, facecolors=SHADOW, edgecolors=SHADOW, linewidths=0.4, zorder=2), autolim=False
    )
    ax.add_collection(
        PolyCollection(faces, facecolors=shown, edgecolors=shown, linewidths=0.4, zorder=3), autolim=False
    )
    trails = [seen(paths[:, k])[0] for k in range(paths.shape[1])]
    ax.add_collection(LineCollection(trails, colors=PATH, linewidths=1.6, zorder=4), autolim=False)
    canvas.draw()  # type: ignore[no-untyped-call]
    drawn = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
    return Image.fromarray(drawn[..., :3].copy())


def _seen(eye: Array, axes: Array, points: Array) -> tuple[Array, Array]:
    """Columns and rows (upward) of points in the picture, and their distances."""
    local = (points - eye) @ axes.T
    depth = np.maximum(-local[:, 2], 1e-9)
    scale = 0.5 * SIZE[1] / np.tan(_SPREAD) / depth
    return np.column_stack([SIZE[0] / 2 + local[:, 0] * scale, SIZE[1] / 2 + local[:, 1] * scale]), -local[:, 2]


def _floor(seen: Any, model: DrawnModel, middle: Array, low: float) -> list[Array]:
    """The lines of a grid on the floor."""
    a, b, _ = towards(model.up[None])[0].T
    step = 10.0 ** np.round(np.log10(0.3 * model.size))
    step = step if step * _LINES > 3 * model.reach else step * 10
    at = middle + model.up * (low - middle @ model.up)
    lines = []
    for one, other in ((a, b), (b, a)):
        start = np.round(at @ one / step) * step - at @ one
        for k in range(-_LINES, _LINES + 1):
            points, depth = seen(
                at + one * (start + k * step) + np.outer(np.linspace(-1, 1, 25) * _LINES * step, other)
            )
            lines.append(points[depth > 0.05 * model.reach])
    return [x for x in lines if len(x) > 1]

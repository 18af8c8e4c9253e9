# SPDX-License-Identifier: BSD-3-Clause
"""The moving pictures of the gallery and of the front page: small WebP files, drawn without a browser."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

import kane as kn
from kane.cli.derive import derived
from kane.cli.models import model_of
from kane.cli.simulate import motion, start
from kane.present.viewer.raster import PictureView, frames

CARD = (280, 168)
"""Columns and rows of a picture of the gallery."""
FRONT = (640, 272)
"""Columns and rows of the picture of the front page."""
_BAND = (0, 70, 800, 410)
"""What is kept of a frame there: the band of the floor that the disk crosses."""
_FAR = 13.0
"""A system that goes farther than so many times its size is followed."""
_COUNT, _PAUSE = 36, 90
"""Frames of a picture of the gallery, and ms between them."""

_ENDS = {"newtons_cradle": 0.4, "stacked_blocks": 1.5, "woodpecker": 0.5}
"""Where a motion ends, s, that goes far or repeats itself in the time of `kane simulate`."""


def card(name: str, folder: Path) -> None:
    """The motion of a system of the gallery from its START, as a small picture that moves, and an instant of it."""
    pictures = list(frames(_shot(name, _COUNT / 25)))
    _save(pictures, CARD, folder / f"{name}.webp", pause=_PAUSE, quality=20)
    pictures[_COUNT // 3].resize(CARD, Image.Resampling.LANCZOS).save(
        folder / f"{name}_still.webp", quality=40, method=6
    )


def front(place: Path) -> None:
    """The disk thrown forward with backspin, which slides, turns aside, and rolls."""
    drawn = list(frames(_shot("skidding_disk", 5.0, azimuth=0.0, height=0.3, near=0.34)))[::2]
    _save([p.crop(_BAND) for p in drawn], FRONT, place, pause=80, quality=60)


def _shot(name: str, seconds: float, azimuth: float = 0.3, height: float = 0.3, near: float = 0.42) -> PictureView:
    """The motion of a system from where all of it is seen."""
    model = model_of(name)
    eom = derived(model)
    sol = motion(model, eom, start(model, eom, {}), _ENDS.get(name))
    animation = kn.animate(sol, shapes=model.shapes)
    course, seen = animation.courses[0], animation.model
    at = [item.at for item in animation.scene.items if item.kind != "plane" and item.at is not None]
    way = course.poses.positions[:, at].reshape(-1, 3)
    low, high = way.min(axis=0), way.max(axis=0)
    across = float(np.linalg.norm(high - low))
    if seen.travels and across < _FAR * seen.size:
        seen = replace(seen, travels=False, middle=(low + high) / 2, reach=near * across + 0.2)
    elif seen.travels:
        seen = replace(seen, reach=1.3 * seen.reach)
    return PictureView(
        seen, animation.courses, (), np.array(animation.camera["front"]), azimuth, height, animation.low, seconds
    )


def _save(pictures: list[Image.Image], size: tuple[int, int], place: Path, pause: int, quality: int) -> None:
    small = [p.resize(size, Image.Resampling.LANCZOS) for p in pictures]
    small[0].save(
        place,
        save_all=True,
        append_images=small[1:],
        duration=pause,
        loop=0,
        quality=quality,
        method=6,
        minimize_size=True,
    )

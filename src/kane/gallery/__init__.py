# SPDX-License-Identifier: BSD-3-Clause
"""Worked systems, each a short module with `system()`, `TITLE` and `SOURCES`, imported only when it is loaded."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import Any, Literal

from kane.errors import ModelError

GALLERY: dict[str, str] = {
    "particle_on_spring": "kane.gallery.particle_on_spring",
    "pendulum": "kane.gallery.pendulum",
    "double_pendulum": "kane.gallery.double_pendulum",
    "pendulums": "kane.gallery.pendulums",
    "pendulum_on_cart": "kane.gallery.pendulum_on_cart",
    "spherical_pendulum": "kane.gallery.spherical_pendulum",
    "spinning_top": "kane.gallery.spinning_top",
    "free_body": "kane.gallery.free_body",
    "gimbal_gyroscope": "kane.gallery.gimbal_gyroscope",
    "whipple_bicycle": "kane.gallery.whipple_bicycle",
    "furuta_pendulum": "kane.gallery.furuta_pendulum",
    "slider_crank": "kane.gallery.slider_crank",
    "four_bar": "kane.gallery.four_bar",
    "n_four_bar": "kane.gallery.n_four_bar",
    "flyball_governor": "kane.gallery.flyball_governor",
    "bricard": "kane.gallery.bricard",
    "andrews_squeezer": "kane.gallery.andrews_squeezer",
    "rolling_disk": "kane.gallery.rolling_disk",
    "pure_rolling_disk": "kane.gallery.pure_rolling_disk",
    "knife_edge": "kane.gallery.knife_edge",
    "chaplygin_sleigh": "kane.gallery.chaplygin_sleigh",
    "sphere_on_turntable": "kane.gallery.sphere_on_turntable",
    "snakeboard": "kane.gallery.snakeboard",
    "car_with_trailer": "kane.gallery.car_with_trailer",
    "rattleback": "kane.gallery.rattleback",
}
"""Module path of each system by name, from simple to rich."""

Definitions = Mapping[Any, Any] | Literal["rates"]
"""What `System(speeds=…)` takes."""


def load(name: str) -> ModuleType:
    """The module of a system by its name in `GALLERY`: `load("spinning_top").system()`.

    Raises
    ------
    ModelError
        if the gallery has no system of that name
    """
    path = GALLERY.get(name)
    if path is None:
        raise ModelError(f"Expected a system of the gallery, one of {', '.join(GALLERY)}; got {name!r}.")
    return import_module(path)


def choose(choices: Mapping[str, Definitions], speeds: str) -> Definitions:
    """The definitions of the speeds that a system's option `speeds` names."""
    if speeds not in choices:
        raise ModelError(f"Expected speeds to be one of {', '.join(choices)}; got {speeds!r}.")
    return choices[speeds]

# SPDX-License-Identifier: BSD-3-Clause
"""Worked systems, each a short module with `system()`, `TITLE` and `SOURCES`, imported only when it is loaded."""

from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import Any, Literal

from kane.errors import ModelError, none_of

_NAMES = """
    particle_on_spring pendulum double_pendulum pendulums pendulum_on_cart spherical_pendulum spinning_top free_body
    gimbal_gyroscope whipple_bicycle furuta_pendulum slider_crank four_bar n_four_bar flyball_governor bricard
    andrews_squeezer muscle_arm rolling_disk pure_rolling_disk knife_edge chaplygin_sleigh sphere_on_turntable snakeboard
    car_with_trailer rattleback rotating_beam flexible_pendulum flexible_slider_crank flexible_four_bar flexible_spacecraft
    flexible_satellite flap_lag_blade flexible_arm
"""
GALLERY: dict[str, str] = {name: f"kane.gallery.{name}" for name in _NAMES.split()}
"""Module path of each system by name, from simple to rich."""


def load(name: str) -> ModuleType:
    """The module of a system by its name in `GALLERY`, else a ModelError: `load("spinning_top").system()`."""
    path = GALLERY.get(name)
    if path is None:
        raise ModelError(f"Expected a system of the gallery, one of {none_of(GALLERY, name)}")
    return import_module(path)


def choose(choices: Mapping[str, Mapping[Any, Any]], speeds: str) -> Mapping[Any, Any] | Literal["rates"]:
    """What `System(speeds=…)` takes for a system's option `speeds`: one of its choices, or "rates", for u = q̇ unless it is one."""
    if speeds in choices:
        return choices[speeds]
    if speeds != "rates":
        raise ModelError(f"Expected speeds to be one of {none_of(dict.fromkeys(['rates', *choices]), speeds)}")
    return "rates"

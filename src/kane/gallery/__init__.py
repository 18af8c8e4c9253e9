# SPDX-License-Identifier: BSD-3-Clause
"""Worked systems, each a short module with `system()`, `TITLE` and `SOURCES`, imported only when it is loaded."""

from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any, Literal

from kane.errors import ModelError, none_of
from kane.lazy_imports import offered

if TYPE_CHECKING:
    from kane.gallery.contacts import ball_on_turntable as ball_on_turntable
    from kane.gallery.contacts import bouncing_ball as bouncing_ball
    from kane.gallery.contacts import clutch as clutch
    from kane.gallery.contacts import dry_oscillator as dry_oscillator
    from kane.gallery.contacts import eulers_disk as eulers_disk
    from kane.gallery.contacts import mass_on_belt as mass_on_belt
    from kane.gallery.contacts import newtons_cradle as newtons_cradle
    from kane.gallery.contacts import painleve_rod as painleve_rod
    from kane.gallery.contacts import pool_ball as pool_ball
    from kane.gallery.contacts import rocking_block as rocking_block
    from kane.gallery.contacts import shaken_block as shaken_block
    from kane.gallery.contacts import skidding_bicycle as skidding_bicycle
    from kane.gallery.contacts import skidding_disk as skidding_disk
    from kane.gallery.contacts import slider_crank_with_clearance as slider_crank_with_clearance
    from kane.gallery.contacts import stacked_blocks as stacked_blocks
    from kane.gallery.contacts import thrown_disk as thrown_disk
    from kane.gallery.contacts import tippe_top as tippe_top
    from kane.gallery.contacts import winch as winch
    from kane.gallery.contacts import woodpecker as woodpecker
    from kane.gallery.flexible import flap_lag_blade as flap_lag_blade
    from kane.gallery.flexible import flexible_arm as flexible_arm
    from kane.gallery.flexible import flexible_four_bar as flexible_four_bar
    from kane.gallery.flexible import flexible_pendulum as flexible_pendulum
    from kane.gallery.flexible import flexible_satellite as flexible_satellite
    from kane.gallery.flexible import flexible_slider_crank as flexible_slider_crank
    from kane.gallery.flexible import flexible_spacecraft as flexible_spacecraft
    from kane.gallery.flexible import rotating_beam as rotating_beam
    from kane.gallery.rolling import car_with_trailer as car_with_trailer
    from kane.gallery.rolling import chaplygin_sleigh as chaplygin_sleigh
    from kane.gallery.rolling import knife_edge as knife_edge
    from kane.gallery.rolling import pure_rolling_disk as pure_rolling_disk
    from kane.gallery.rolling import rattleback as rattleback
    from kane.gallery.rolling import rolling_disk as rolling_disk
    from kane.gallery.rolling import snakeboard as snakeboard
    from kane.gallery.rolling import sphere_on_turntable as sphere_on_turntable
    from kane.gallery.rolling import whipple_bicycle as whipple_bicycle
    from kane.gallery.walking import compass_gait as compass_gait
    from kane.gallery.walking import rimless_wheel as rimless_wheel
    from kane.gallery.walking import simplest_walker as simplest_walker

_PLACES = """
    particle_on_spring pendulum double_pendulum pendulums pendulum_on_cart spherical_pendulum spinning_top free_body
    gimbal_gyroscope rolling.whipple_bicycle furuta_pendulum slider_crank four_bar n_four_bar flyball_governor bricard
    andrews_squeezer muscle_arm light_cart_pole rolling.rolling_disk rolling.pure_rolling_disk rolling.knife_edge
    rolling.chaplygin_sleigh rolling.sphere_on_turntable rolling.snakeboard rolling.car_with_trailer rolling.rattleback
    flexible.rotating_beam flexible.flexible_pendulum flexible.flexible_slider_crank flexible.flexible_four_bar
    flexible.flexible_spacecraft flexible.flexible_satellite flexible.flap_lag_blade flexible.flexible_arm
    contacts.bouncing_ball contacts.thrown_disk contacts.mass_on_belt contacts.skidding_disk contacts.clutch contacts.winch
    contacts.tippe_top contacts.painleve_rod contacts.dry_oscillator contacts.shaken_block contacts.stacked_blocks
    contacts.rocking_block contacts.pool_ball contacts.ball_on_turntable contacts.eulers_disk contacts.newtons_cradle
    contacts.woodpecker contacts.slider_crank_with_clearance
    walking.rimless_wheel walking.simplest_walker walking.compass_gait contacts.skidding_bicycle
"""
GALLERY: dict[str, str] = {place.rpartition(".")[2]: f"kane.gallery.{place}" for place in _PLACES.split()}
"""Module path of each system by name, from simple to rich."""


__getattr__ = offered(
    __name__,
    {
        f"{folder}.": " ".join(name for name, path in GALLERY.items() if path.startswith(f"kane.gallery.{folder}."))
        for folder in ("rolling", "flexible", "contacts", "walking")
    },
)


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

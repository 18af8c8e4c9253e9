# SPDX-License-Identifier: BSD-3-Clause
"""Joints as functions over frames and points, loops closed by the same joints, contacts, stops, ropes and clutches, and gears."""

from typing import TYPE_CHECKING

from kane.dynamics.readings.joint_reactions import JointReaction
from kane.lazy_imports import offered as _offered
from kane.model.contacts import (
    ContactLaw,
    ContactMode,
    capstan,
    clutch,
    drilling_resistance,
    rolling_resistance,
    rope,
    stiction,
    stop,
    stribeck,
)
from kane.model.joints.closing import (
    close_ball,
    close_cylindrical,
    close_pin,
    close_planar,
    close_screw,
    close_slider,
    close_universal,
    close_weld,
)
from kane.model.joints.contact import Contact, disk_on_plane, point_on_plane, sphere_on_plane, torus_on_plane
from kane.model.joints.gears import bevel_pair, gear_pair, rack_and_pinion, worm_pair
from kane.model.joints.joint import Joint
from kane.model.joints.round_contact import capsule_on_plane, corners_on_plane, sphere_on_cylinder, sphere_on_sphere
from kane.model.joints.tree_joints import ball, cylindrical, free, pin, planar, screw, slider, universal, weld

__all__ = [
    "Contact", "ContactLaw", "ContactMode", "Joint", "JointReaction", "ball", "bevel_pair", "capstan",
    "capsule_on_plane", "close_ball", "close_cylindrical", "close_pin", "close_planar", "close_screw",
    "close_slider", "close_universal", "close_weld", "clutch", "corners_on_plane", "cylindrical", "disk_on_plane",
    "drilling_resistance", "free", "gear_pair", "pin", "planar", "point_on_plane", "rack_and_pinion",
    "rolling_resistance", "rope", "screw", "slider", "sphere_on_cylinder", "sphere_on_plane", "sphere_on_sphere",
    "stiction", "stop", "stribeck", "torus_on_plane", "universal", "weld", "worm_pair",
]  # fmt: skip

if not TYPE_CHECKING:  # checkers of types know the names; what is misspelt is answered with what resembles it
    __getattr__ = _offered(__name__, {})

# SPDX-License-Identifier: BSD-3-Clause
"""Forces and torques, springs, dampers, drag, gravitation, friction, and systems of forces."""

from typing import TYPE_CHECKING

from kane.dynamics.readings.contributions import Noncontributing
from kane.lazy_imports import offered as _offered
from kane.model.field_loads import (
    buoyancy,
    gravitation,
    gravity_moment,
    line_load,
    linear_drag,
    pressure_on_disk,
    pressure_on_rectangle,
    quadratic_drag,
)
from kane.model.force_systems import ForceSystem, Wrench, force_system
from kane.model.joints.contact import dry_friction, friction
from kane.model.loads import (
    Force,
    Gravity,
    Load,
    Torque,
    action_reaction,
    gravity,
    linear_damper,
    linear_spring,
    torque_pair,
    torsional_damper,
    torsional_spring,
)

__all__ = [
    "Force", "ForceSystem", "Gravity", "Load", "Noncontributing", "Torque", "Wrench", "action_reaction",
    "buoyancy", "dry_friction", "force_system", "friction", "gravitation", "gravity", "gravity_moment",
    "line_load", "linear_damper", "linear_drag", "linear_spring", "pressure_on_disk", "pressure_on_rectangle",
    "quadratic_drag", "torque_pair", "torsional_damper", "torsional_spring",
]  # fmt: skip

if not TYPE_CHECKING:  # checkers of types know the names; what is misspelt is answered with what resembles it
    __getattr__ = _offered(__name__, {})

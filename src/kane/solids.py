# SPDX-License-Identifier: BSD-3-Clause
"""Inertia of uniform solids, shells, plates and wires, and mass properties of bodies composed of them."""

from typing import TYPE_CHECKING

from kane.lazy_imports import offered as _offered
from kane.model.mass import (
    Principal,
    composite,
    inertia_about,
    inertia_matrix,
    inertia_vector,
    mass_center,
    moment_of_inertia,
    principal,
    product_of_inertia,
    radius_of_gyration,
)
from kane.model.solids import (
    box,
    central_inertia,
    circular_arc,
    circular_sector,
    cylindrical_shell,
    ellipsoid,
    frustum,
    half_cylinder,
    hemisphere,
    inertia,
    parallel_axis,
    rectangular_plate,
    right_triangle,
    ring,
    rod,
    solid_cone,
    solid_cylinder,
    solid_sphere,
    spherical_shell,
    thin_disk,
    torus,
    triangular_plate,
)

__all__ = [
    "Principal", "box", "central_inertia", "circular_arc", "circular_sector", "composite", "cylindrical_shell",
    "ellipsoid", "frustum", "half_cylinder", "hemisphere", "inertia", "inertia_about", "inertia_matrix",
    "inertia_vector", "mass_center", "moment_of_inertia", "parallel_axis", "principal", "product_of_inertia",
    "radius_of_gyration", "rectangular_plate", "right_triangle", "ring", "rod", "solid_cone", "solid_cylinder",
    "solid_sphere", "spherical_shell", "thin_disk", "torus", "triangular_plate",
]  # fmt: skip

if not TYPE_CHECKING:  # checkers of types know the names; what is misspelt is answered with what resembles it
    __getattr__ = _offered(__name__, {})

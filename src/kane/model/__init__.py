# SPDX-License-Identifier: BSD-3-Clause
"""Layer 2: declarations of a mechanical system. Checks here are local; those that need derivation are in `dynamics`."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "beams.shape_functions": "FAMILIES",
        "beams.deformation": "foreshortening moments_beyond",
        "bodies": "Part check_inertia check_mass deforming",
        "constraints": "as_constraints constraint_of cut_of",
        "solids": "Inertia",
        "system": "gravity_load total_mass",
    },
)

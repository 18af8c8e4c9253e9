# SPDX-License-Identifier: BSD-3-Clause
"""Layer 2: what the engineer declares. Checks here are local; what needs derivation is checked in `dynamics`."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "beams.functions": "FAMILIES",
        "beams.integrals": "foreshortening moments_beyond",
        "bodies": "Part",
        "constraints": "as_constraints",
        "inertia": "Inertia",
        "plausible": "check_inertia check_mass",
        "reactions": "constraint_of cut_of",
        "system": "gravity_load total_mass",
    },
)

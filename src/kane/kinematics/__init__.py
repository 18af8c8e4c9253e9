# SPDX-License-Identifier: BSD-3-Clause
"""Layer 3: generalized speeds, velocities in them, partial velocities, velocity constraints, the tree of joints."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "aligned": "AS_DECLARED aligned_bases",
        "velocity_constraints": "placed_form constraint_rows rows_along_tree",
        "definitions": "generalized_speeds turned",
        "freedoms": "Unsuited",
        "speeds": "Matching Sample",
        "velocities": "Following Kinematics",
        "links": "tree_of",
    },
)

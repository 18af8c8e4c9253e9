# SPDX-License-Identifier: BSD-3-Clause
"""Questions to equations that are no motions: assembly, linearization, trim, continuation, inverse dynamics."""

from kane.lazy import offered

__getattr__ = offered(
    __name__,
    {
        "held": "held_at",
        "load_signs": "doubtful_loads",
        "stability": "changes tracked",
        "state": "start_state",
        "steady": "dependence",
    },
)

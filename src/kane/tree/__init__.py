# SPDX-License-Identifier: BSD-3-Clause
"""Layer 2: recursions along a tree of segments: two sweeps, the values that they carry, and the algorithms made of these."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {"": "composite", "composite": "are_slender", "triples": "Turn", "values": "Moments NO_MOMENTS Rigid moments"},
)

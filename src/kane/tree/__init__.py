# SPDX-License-Identifier: BSD-3-Clause
"""Layer 2: recursive algorithms of Featherstone 2008 on a tree of segments: ABA, CRBA and tangents, built on two generic sweeps."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {"": "composite", "composite": "are_slender", "triples": "Turn", "values": "Moments NO_MOMENTS Rigid moments"},
)

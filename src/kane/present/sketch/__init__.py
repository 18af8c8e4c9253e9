# SPDX-License-Identifier: BSD-3-Clause
"""The labelled sketch of a system: pose and camera are searched, labels are placed at the width at which they are read."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "draw": "NARROW WIDE Sketch draw_each sketch",
        "labels": "GAP Label placed",
        "svg": "DARK LIGHT TEXT style",
        "typeset": "listed place plain product spans unit_vector width_of",
        "pose": "pose_of",
        "camera": "view_of",
        "outlines": "hull mesh",
    },
)

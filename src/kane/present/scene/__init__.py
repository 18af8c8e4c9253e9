# SPDX-License-Identifier: BSD-3-Clause
"""What a system looks like: shapes, places, coordinates and loads as one frozen `Scene`, with one routine for all its poses."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "records": "Action Item Mark Movement Posed Scene Triad",
        "gather": "scene",
        "shapes": "KINDS BodyShape shape",
    },
)

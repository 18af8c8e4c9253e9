# SPDX-License-Identifier: BSD-3-Clause
"""Models and equations of other tools, and equations for them."""

from kane.interop.imported import Imported, Remark
from kane.interop.robots.mjcf import from_mjcf
from kane.interop.robots.records import LinkShape
from kane.interop.robots.urdf import from_urdf
from kane.interop.sympy import from_sympy, to_sympy

__all__ = [
    "Imported",
    "LinkShape",
    "Remark",
    "from_mjcf",
    "from_sympy",
    "from_urdf",
    "to_sympy",
]  # fmt: skip

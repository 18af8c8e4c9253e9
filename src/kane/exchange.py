# SPDX-License-Identifier: BSD-3-Clause
"""Models and equations of other tools, and equations for them."""

from kane.interop.imported import Imported, Remark
from kane.interop.sympy import from_sympy, to_sympy
from kane.interop.sympy_mechanics.importing import from_sympy_mechanics

__all__ = [
    "Imported", "Remark", "from_sympy", "from_sympy_mechanics", "to_sympy",
]  # fmt: skip

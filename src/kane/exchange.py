# SPDX-License-Identifier: BSD-3-Clause
"""Models and equations of other tools, and equations for them."""

from kane.interop.autolev import from_autolev
from kane.interop.imported import Imported, Remark
from kane.interop.sympy import from_sympy, to_sympy

__all__ = [
    "Imported", "Remark", "from_autolev", "from_sympy", "to_sympy",
]  # fmt: skip

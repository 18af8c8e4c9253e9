# SPDX-License-Identifier: BSD-3-Clause
"""Models and equations of other tools, and equations for them."""

from kane.interop.fmu.archive import FMU, to_fmu
from kane.interop.sympy import from_sympy, to_sympy

__all__ = [
    "FMU", "from_sympy", "to_fmu", "to_sympy",
]  # fmt: skip

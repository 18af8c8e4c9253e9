# SPDX-License-Identifier: BSD-3-Clause
"""Models and equations of other tools, and equations for them."""

from kane.interop.autodiff import to_casadi, to_jax, to_torch
from kane.interop.python_source.model import to_python
from kane.interop.sympy import from_sympy, to_sympy

__all__ = [
    "from_sympy",
    "to_casadi",
    "to_jax",
    "to_python",
    "to_sympy",
    "to_torch",
]

# SPDX-License-Identifier: BSD-3-Clause
"""Models and equations of other tools, and equations for them."""

from typing import TYPE_CHECKING

from kane.equations.compiled import Handle
from kane.interop.autodiff import to_casadi, to_jax, to_torch
from kane.interop.autolev import from_autolev
from kane.interop.fmu.archive import FMU, to_fmu
from kane.interop.imported import Imported, Remark
from kane.interop.python_source.model import to_python
from kane.interop.robots.mjcf import from_mjcf
from kane.interop.robots.records import LinkShape
from kane.interop.robots.urdf import from_urdf
from kane.interop.sympy import from_sympy, to_sympy
from kane.interop.sympy_mechanics.importing import from_sympy_mechanics
from kane.lazy_imports import offered as _offered

__all__ = [
    "FMU", "Handle", "Imported", "LinkShape", "Remark", "from_autolev", "from_mjcf", "from_sympy",
    "from_sympy_mechanics", "from_urdf", "to_casadi", "to_fmu", "to_jax", "to_python", "to_sympy", "to_torch",
]  # fmt: skip

if not TYPE_CHECKING:  # checkers of types know the names; what is misspelt is answered with what resembles it
    __getattr__ = _offered(__name__, {})

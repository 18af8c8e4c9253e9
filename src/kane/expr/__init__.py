# SPDX-License-Identifier: BSD-3-Clause
"""Layer 0: the scalar expression graph."""

from kane.expr import operators as _operators  # noqa: F401  attaches the operators of Expr

# SPDX-License-Identifier: BSD-3-Clause
"""Scalar expressions: symbols, derivatives, tables, operations, series."""

from typing import TYPE_CHECKING

from kane.expr import operators as _operators  # noqa: F401  attaches the operators of Expr
from kane.lazy_imports import offered as _offered

if TYPE_CHECKING:
    from kane.expr.differentiation import affine, diff, gradient, jacobian, time_derivative
    from kane.expr.evaluation import Operations, count_operations, evaluate, free_symbols
    from kane.expr.forms.taylor_series import taylor
    from kane.expr.matrix import Matrix, solve_linear
    from kane.expr.node import Expr
    from kane.expr.piecewise import Table
    from kane.expr.symbols import (
        AuxiliarySpeed,
        Coordinate,
        Input,
        Parameter,
        Rate,
        Reaction,
        Speed,
        StateVariable,
        Symbol,
    )
    from kane.expr.visit import substitute

__getattr__ = _offered(
    __name__,
    {
        "build": "NODE_BUILDERS add cos div mul sin sub sum_of",
        "differentiation": "diff gradient jacobian time_derivative weighted affine affine_forms",
        "evaluation": (
            "Walk compile_reference evaluate free_symbols is_constant_in_time FLOAT Operations count_operations price"
        ),
        "forms.collect": "MOST collected combined expanded factored joined",
        "forms.integration": "antiderivative",
        "forms.scales": "scaled",
        "forms.shorter": "named shared shortened with_short_quotients",
        "forms.taylor_series": "taylor",
        "forms.two_angles": "by_two_angles",
        "matrix": "Matrix dot ldl lu matched_columns solve_linear sparse_order structural_rank",
        "visit": "remembered remembering fold imaged rebuilt substitute substituted",
        "node": (
            "BUILDERS Expr ONE ZERO as_expr constant constant_value digest error_of intern_node postorder precedes sweep weight"
        ),
        "ops": "ADD CONST COS DIV GONE MUL OPS SIN SUB",
        "piecewise": "Table leaps lowered on_sides switches table",
        "regular": "denominators guarding guards unguarded",
        "square_system": "Adjugate InOrder Triangular content divider over_number square",
        "numbers": "Surd correctly_rounded root",
        "symbols": (
            "AuxiliarySpeed Coordinate Input Parameter QuasiRate Rate Reaction Speed StateVariable Symbol names "
            "per_second rate"
        ),
    },
)

__all__ = [
    "Expr", "Symbol", "Parameter", "Coordinate", "Rate", "Speed", "AuxiliarySpeed", "Reaction", "Input", "StateVariable",
    "Table", "Matrix", "diff", "gradient", "jacobian", "time_derivative", "affine", "taylor", "substitute",
    "solve_linear", "evaluate", "free_symbols", "count_operations", "Operations",
]  # fmt: skip

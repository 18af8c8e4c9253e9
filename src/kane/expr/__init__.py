# SPDX-License-Identifier: BSD-3-Clause
"""Layer 0: the scalar expression graph."""

from typing import TYPE_CHECKING

from kane.expr import operators as _operators  # noqa: F401  attaches the operators of Expr
from kane.lazy_imports import offered as _offered

if TYPE_CHECKING:
    from kane.expr.count import Operations, count_operations
    from kane.expr.differentiation import diff, gradient, jacobian, time_derivative
    from kane.expr.evaluation import evaluate, free_symbols
    from kane.expr.linear_parts import affine
    from kane.expr.matrix import Matrix
    from kane.expr.node import Expr
    from kane.expr.solve import solve_linear
    from kane.expr.substitution import substitute
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
    from kane.expr.tables import Table
    from kane.expr.taylor_series import taylor

__getattr__ = _offered(
    __name__,
    {
        "build": "NODE_BUILDERS add cos div mul sin sub",
        "collect": "collected factored",
        "common_factor": "content divider over_number",
        "constants": "error_of weight",
        "count": "Operations count_operations price",
        "differentiation": "diff gradient jacobian time_derivative weighted",
        "evaluation": "Walk compile_reference evaluate free_symbols is_constant_in_time",
        "expand": "MOST expanded",
        "floats": "FLOAT",
        "integration": "antiderivative",
        "irreducible": "matched_columns structural_rank",
        "known": "named",
        "linear_forms": "combined joined",
        "linear_parts": "affine affine_forms",
        "matrix": "Matrix dot",
        "memo": "remembered remembering",
        "node": "BUILDERS Expr ONE ZERO as_expr constant constant_value digest intern_node postorder precedes sweep",
        "ops": "ADD CONST COS DIV GONE MUL OPS SIN SUB",
        "piecewise": "lowered",
        "piecewise_sides": "leaps",
        "products": "shared",
        "regular": "denominators guarding guards unguarded",
        "rounded_functions": "correctly_rounded",
        "scales": "scaled",
        "shorten": "shortened with_short_quotients",
        "solve": "ldl lu solve_linear sparse_order",
        "square_system": "Adjugate InOrder Triangular square",
        "substitution": "substitute",
        "surd": "Surd root",
        "switching": "on_sides switches",
        "symbols": "AuxiliarySpeed Coordinate Input Parameter QuasiRate Rate Reaction Speed StateVariable Symbol names "
        "per_second rate",
        "tables": "Table",
        "taylor_series": "taylor",
        "visit": "fold imaged rebuilt substituted",
    },
)


def __dir__() -> list[str]:
    return sorted(__all__)


__all__ = [
    "Expr", "Symbol", "Parameter", "Coordinate", "Rate", "Speed", "AuxiliarySpeed", "Reaction", "Input", "StateVariable",
    "Table", "Matrix", "diff", "gradient", "jacobian", "time_derivative", "affine", "taylor", "substitute",
    "solve_linear", "evaluate", "free_symbols", "count_operations", "Operations",
]  # fmt: skip

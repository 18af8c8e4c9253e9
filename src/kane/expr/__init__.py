# SPDX-License-Identifier: BSD-3-Clause
"""Layer 0: the scalar expression graph."""

from kane.expr import operators as _operators  # noqa: F401  attaches the operators of Expr
from kane.lazy import offered

__getattr__ = offered(
    __name__,
    {
        "linear_parts": "affine_forms",
        "build": "NODE_BUILDERS add cos div mul sin sub",
        "collect": "collected factored",
        "common_factor": "content divider over_number",
        "constants": "error_of",
        "count": "price",
        "differentiation": "weighted",
        "evaluation": "Walk compile_reference is_constant_in_time",
        "expand": "MOST expanded",
        "floats": "FLOAT",
        "integration": "antiderivative",
        "irreducible": "matched_columns structural_rank",
        "known": "named",
        "linear_forms": "combined joined",
        "matrix": "dot",
        "memo": "remembered remembering",
        "node": "BUILDERS ONE ZERO as_expr constant constant_value digest intern_node postorder precedes sweep",
        "ops": "ADD CONST COS DIV GONE MUL OPS SIN SUB",
        "piecewise": "lowered",
        "piecewise_sides": "leaps",
        "products": "shared",
        "regular": "guarding guards unguarded",
        "rounded_functions": "correctly_rounded",
        "scales": "scaled",
        "shorten": "shortened with_short_quotients",
        "solve": "ldl lu",
        "square_system": "Adjugate InOrder Triangular square",
        "surd": "Surd root",
        "switching": "on_sides switches",
        "symbols": "QuasiRate names per_second rate",
        "visit": "fold imaged rebuilt substituted",
    },
)

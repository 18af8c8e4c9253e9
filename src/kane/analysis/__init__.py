# SPDX-License-Identifier: BSD-3-Clause
"""Questions to equations that are no motions: assembly, linearization, trim, continuation, inverse dynamics."""

from typing import TYPE_CHECKING

from kane.lazy_imports import offered as _offered

if TYPE_CHECKING:
    from kane.analysis.assembly import Assembled, assemble
    from kane.analysis.constraint_loads import ConstraintForces, constraint_forces
    from kane.analysis.impacts import Impact, impact
    from kane.analysis.inverse_dynamics import Inverse, inverse
    from kane.analysis.linear import Linear, Mode, SecondOrder
    from kane.analysis.linearization import Linearizer, linearize, linearizer
    from kane.analysis.method_comparison import MethodComparison, compare_methods
    from kane.analysis.modes import NormalModes, normal_modes
    from kane.analysis.point import OperatingPoint
    from kane.analysis.solution_branches import Branch, continuation
    from kane.analysis.speed_comparison import SpeedComparison, SpeedSet, compare_speeds
    from kane.analysis.stability import Crossing
    from kane.analysis.state import Guess, guess
    from kane.analysis.symbolic import SymbolicLinear, linearize_symbolic
    from kane.analysis.trimming import equilibrium, trim
    from kane.dynamics.methods.formulation import Formulation
    from kane.dynamics.motions import Motions, motions

__getattr__ = _offered(
    __name__,
    {
        ".dynamics.methods.formulation": "Formulation",
        ".dynamics.motions": "Motions motions",
        "assembly": "Assembled assemble",
        "constraint_loads": "ConstraintForces constraint_forces",
        "held": "held_at",
        "impacts": "Impact impact",
        "inverse_dynamics": "Inverse inverse",
        "linear": "Linear Mode SecondOrder",
        "linearization": "Linearizer linearize linearizer",
        "load_signs": "doubtful_loads",
        "method_comparison": "MethodComparison compare_methods",
        "modes": "NormalModes normal_modes",
        "point": "OperatingPoint",
        "solution_branches": "Branch continuation",
        "speed_comparison": "SpeedComparison SpeedSet compare_speeds",
        "stability": "Crossing changes tracked",
        "state": "Guess guess start_state",
        "steady": "dependence",
        "symbolic": "SymbolicLinear linearize_symbolic",
        "trimming": "equilibrium trim",
    },
)


def __dir__() -> list[str]:
    return sorted(__all__)


__all__ = [
    "assemble", "Assembled", "guess", "Guess", "linearize", "linearizer", "linearize_symbolic", "Linear", "Linearizer",
    "SymbolicLinear", "SecondOrder", "Mode", "normal_modes", "NormalModes", "impact", "Impact", "constraint_forces",
    "ConstraintForces", "trim", "equilibrium", "OperatingPoint", "continuation", "Branch", "Crossing", "inverse",
    "Inverse", "compare_speeds", "SpeedComparison", "SpeedSet", "compare_methods", "MethodComparison", "Formulation",
    "motions", "Motions",
]  # fmt: skip

# SPDX-License-Identifier: BSD-3-Clause
"""Analyses of equations of motion: assembly, linearization, trim, continuation, inverse dynamics, comparison of methods."""

from typing import TYPE_CHECKING

from kane.lazy_imports import offered as _offered

if TYPE_CHECKING:
    from kane.analysis.assembly import Assembled, assemble
    from kane.analysis.comparison import MethodComparison, SpeedComparison, SpeedSet, compare_methods, compare_speeds
    from kane.analysis.constraint_loads import ConstraintForces, Impact, constraint_forces, impact
    from kane.analysis.linear import Linear, Mode, NormalModes, SecondOrder, normal_modes
    from kane.analysis.linearization import Linearizer, SymbolicLinear, linearize, linearize_symbolic, linearizer
    from kane.analysis.mixed_dynamics import Inverse, inverse
    from kane.analysis.solution_branches import Branch, Crossing, continuation
    from kane.analysis.trimming import equilibrium, trim
    from kane.dynamics.formalisms import Formulation
    from kane.dynamics.motions import Motions, motions
    from kane.equations.state import Guess, guess

__getattr__ = _offered(
    __name__,
    {
        ".dynamics.formalisms": "Formulation",
        ".dynamics.motions": "Motions motions",
        ".equations.state": "Guess OperatingPoint State guess",
        "assembly": "Assembled assemble velocity_constraints_at",
        "comparison": "MethodComparison SpeedComparison SpeedSet compare_methods compare_speeds",
        "constraint_loads": "ConstraintForces constraint_forces Impact impact",
        "flow": "dependence",
        "linear": "Linear Mode NormalModes SecondOrder normal_modes",
        "linearization": "Linearizer SymbolicLinear linearize linearize_symbolic linearizer",
        "many.following": "Unknowns follow",
        "load_signs": "doubtful_loads",
        "mixed_dynamics": "Inverse inverse",
        "solution_branches": "Branch Crossing changes continuation tracked",
        "stacks": "MatrixEntries solve_each surely_independent",
        "state_checks": "start_state",
        "trimming": "equilibrium trim",
    },
)

__all__ = [
    "assemble", "Assembled", "guess", "Guess", "linearize", "linearizer", "linearize_symbolic", "Linear", "Linearizer",
    "SymbolicLinear", "SecondOrder", "Mode", "normal_modes", "NormalModes", "impact", "Impact", "constraint_forces",
    "ConstraintForces", "trim", "equilibrium", "continuation", "Branch", "Crossing", "inverse",
    "Inverse", "compare_speeds", "SpeedComparison", "SpeedSet", "compare_methods", "MethodComparison", "Formulation",
    "motions", "Motions",
]  # fmt: skip

# SPDX-License-Identifier: BSD-3-Clause
"""Layer 4: Kane's dynamical equations: generalized forces, M u̇ = f + G R, constraints, and formulations that solve them."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "": "inverse_dynamics",
        "forcing": "Blocks",
        "constraints.manifold": "ROWS branches configurations in_rows manifold contacts touches",
        "constraints.partition": "Partition choose choose_each chosen compared qualities qualities_of quality ranks",
        "constraints.dependence": "steadiest",
        "derivation": "Derived derived",
        "inverse_dynamics": "kinetic_energy_along_tree",
        "lazy": "LazyMapping read",
        "in_rates": "InRates",
        "formalisms": "METHODS OTHERS",
        "poles": "without_poles",
        "readings.energy": "kinetic_energy",
        "readings.potential": "line_integral",
        "readings.unsolved": "mass_matrix unsolved",
        "readings.regularity": "concerned nan_where_more",
        "readings.seven_steps": "Kind shown_speeds",
        "formulation.": "candidates table",
        "formulation.candidates": "LARGE TRIED",
        "formulation.carried": "regrouped",
        "formulation.recursive": "WAYS by_recursion carrying",
        "formulation.table": "FINISHES shortest shortest_in_given_speeds tree_with_reactions",
        "formulation.change_of_speeds": "absolute by_mass_centre",
        "formulation.classical": (
            "about_points_at_rest block_solution classical embedded embedded_motions holds_reactions homogeneous power squares "
            "unguarded_classical"
        ),
        "slopes": "acceleration_slopes closed_slopes forward",
    },
)

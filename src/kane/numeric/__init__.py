# SPDX-License-Identifier: BSD-3-Clause
"""Numerical methods that all layers share: rank, balancing, least changes, Gauss–Newton, continuation, samples and tolerances."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "scale": "bounded vanish DECLARED DERIVE_RANK SOLVE_RANK",
        "polynomials": "SHARES gauss passages zero_of",
        "sampling": ("HIGH LOW draw sample value_of values_of finite_number named_values symbol_named symbols_named"),
        "newton": "NaturalSizes close close_many close_most closest improved sizes starts",
        "rank": (
            "balance balanced decays dependencies indeterminate null_direction singular sure_rows within "
            "least_change least_constraint metric mobility of_unit_length reflected surely_regular"
        ),
        "arrays": "zxz pace",
    },
)

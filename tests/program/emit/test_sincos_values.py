# SPDX-License-Identifier: BSD-3-Clause
"""The steps of sine and cosine with NumPy: within an ulp of the exact values, at multiples of π/2 too."""

import mpmath
import numpy as np

from kane.program import LIMIT, sine_cosine


def test_values_are_within_an_ulp(rng: np.random.Generator) -> None:
    x = np.concatenate([rng.uniform(-10, 10, 300), rng.uniform(-LIMIT, LIMIT, 300), np.arange(-40, 41) * np.pi / 2])
    with mpmath.workdps(40):
        for values, function in zip(sine_cosine(x), (mpmath.sin, mpmath.cos), strict=True):
            exact = np.array([float(function(mpmath.mpf(float(v)))) for v in x])
            assert (np.abs(values - exact) <= np.spacing(np.abs(exact))).all()

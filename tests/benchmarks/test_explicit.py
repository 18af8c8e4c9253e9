# SPDX-License-Identifier: BSD-3-Clause
"""Evaluations of explicit methods at equal error."""

import numpy as np
import pytest

from benchmarks.explicit import METHODS, at, counts
from tests.motion.steppers.runs import spring


def test_evaluations_at_an_error_lie_on_a_line_of_logarithms():
    """Points whose error is no smaller than one at a looser tolerance are left out; beyond the smallest error there is nothing."""
    errors, evaluations = [1e-2, 1e-4, 3e-3, 1e-6], [100.0, 200.0, 250.0, 400.0]
    assert at(errors, evaluations, 1e-3) == pytest.approx(100 * 2**0.5)
    assert at(errors, evaluations, 1e-5) == pytest.approx(200 * 2**0.5)
    assert np.isnan(at(errors, evaluations, 1e-9))


@pytest.mark.slow
def test_higher_order_takes_fewer_evaluations_at_small_errors():
    """Of a spring's motion, from 1e-6 to 1e-12; samples cost stages of dense output."""
    found = counts(spring(), 10, {"q": [1.0], "u": [0.0]})
    for errors, sampled, ends in found.values():
        assert max(errors[-4:]) < 1e-10
        assert all(a > b for a, b in zip(sampled, ends, strict=True))
    needed = {m: [at(found[m][0], found[m][2], w) for w in (1e-6, 1e-12)] for m in METHODS}
    growth = {m: few[1] / few[0] for m, few in needed.items()}
    assert growth["vern9"] < growth["dop853"]
    assert growth["tsitpap8"] < 1.2 * growth["dop853"]

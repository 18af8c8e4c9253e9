# SPDX-License-Identifier: BSD-3-Clause
"""Machine code looks at a divisor's guard when the quotient is known: the same numbers, and NaN at the same places."""

import itertools

import numpy as np
import pytest

from kane import Handle, Settings
from kane.expr import GONE, OPS, intern_node
from tests.program.emitted import from_numpy
from tests.program.passes.codes import STATES, SYMBOLS, built

a, b, c, d = STATES
REGULAR, DIV = OPS["regular"], OPS["div"]
guard = intern_node(REGULAR, a, b)
SIZES = [0.0, 5e-324, 1e-300, 1.0, 3.0, np.inf, np.nan]


@pytest.mark.parametrize(
    "roots",
    [
        [intern_node(DIV, c, guard), intern_node(DIV, d, guard)],
        [intern_node(DIV, c, guard), guard],  # read elsewhere, too
        [intern_node(DIV, c, guard) + guard * d],
        [intern_node(DIV, guard, guard)],
    ],
    ids=["divisor", "result", "factor", "both"],
)
def test_a_guard_says_the_same_wherever_it_is_read(roots, tmp_path):
    made = built(roots)
    ends = [GONE * 3.0 * f for f in (1.0, 1 - 2**-52, 1 + 2**-52)]
    values = [s * v for s in (1, -1) for v in (*SIZES, *ends)]
    rows = np.array([[0.0, x, y, 2.5, -0.7, 1.5, 1.5, 1.5] for x, y in itertools.product(values, values)])
    assert rows.shape[1] == len(SYMBOLS)
    split = rows[:, 0], rows[:, 1:5], rows[:, 5:]
    found = Handle(made, "f0", Settings(contract=False), None, "ignore")(*split)
    with np.errstate(all="ignore"):
        right = from_numpy(made, tmp_path).f0(*split)
    assert np.array_equal(found, right, equal_nan=True)
    lost = ~(np.abs(rows[:, 1]) > GONE * rows[:, 2])
    assert lost.any()
    assert np.isnan(found[lost][:, 0]).all()

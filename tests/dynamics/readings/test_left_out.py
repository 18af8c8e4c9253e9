# SPDX-License-Identifier: BSD-3-Clause
"""Rows left out as redundant on one branch of a mechanism hold something on another: that is said, never passed over."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kane as kn
from kane.dynamics.constraints.choice import ranks
from kane.dynamics.constraints.configurations import configurations
from kane.gallery import bricard


def quietly(system, **more):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)
        return kn.derive(system, **more)


@pytest.fixture(scope="module")
def both():
    """Bricard's linkage derived on its moving branch, where one row is redundant, and on one where two are; a state on the first."""
    system = bricard.system(redundant=True)
    eom = quietly(system)
    found = configurations(system, eom.A.entries)
    k = int(np.argmin(ranks(found.matrices(eom.A))))
    other = quietly(system, near={q: found.at(k)[q] for q in system.coordinates})
    state = kn.assemble(eom, q={"q1": 0.3, **{f"q{k}": kn.guess(0.1) for k in range(2, 6)}}, u={"u1": 1.0})
    assert (len(eom.redundant), len(other.redundant)) == (1, 2)
    return eom, other, state


TOLD = r"got 'last \w+ \w', 'last \w+ \w', which were left out as redundant and hold more"


def test_at_a_state(both):
    eom, other, state = both
    with pytest.raises(kn.SingularError, match=rf"{TOLD}.*kn\.derive\(system, near=…\) of this configuration"):
        other.evaluate(other.accelerations, q=state.q, u=state.u)
    cured = quietly(eom.system, near=state.q)
    for x in (eom, cured):
        found = x.evaluate(x.accelerations, q=state.q, u=state.u)
        np.testing.assert_allclose(found, eom.evaluate(eom.accelerations, q=state.q, u=state.u), rtol=1e-9)


def test_of_arrays(both):
    _, other, state = both
    with pytest.warns(kn.KaneWarning, match=rf"{TOLD} at index 0 and 1 more: the values there are NaN"):
        found = other.evaluate(other.accelerations[:2], q={q: [x, x] for q, x in state.q.items()}, u=state.u)
    assert np.isnan(found).all()


def test_what_was_not_solved_for_is_told(both):
    _, other, state = both
    a = other.evaluate(other.A, q=state.q)
    assert np.linalg.matrix_rank(a, 1e-9) == 4


@pytest.mark.slow
def test_a_simulation_takes_the_rows_that_hold_more(both):
    eom, other, state = both
    right, same = (kn.simulate(x, (0, 0.3), q=state.q, u=state.u, rtol=1e-10, atol=1e-10) for x in (eom, other))
    np.testing.assert_allclose(same.states[-1], right.states[-1], atol=1e-8)

# SPDX-License-Identifier: BSD-3-Clause
"""Random mechanisms with loops, of which a closed configuration is known: each is closed from starts that do not know it."""

from __future__ import annotations

import warnings

import hypothesis.strategies as st
import pytest
from hypothesis import HealthCheck, given, settings

import kane as kn
from kane.dynamics import compared, derived
from tests.oracles.mechanism_draw import mechanisms
from tests.oracles.mechanism_kane import to_kane


@pytest.mark.slow
@pytest.mark.parametrize("planar", [True, False])
def test_random_loops_are_closed(planar: bool) -> None:
    """A hundred of a kind, closed, and with none of their rows redundant."""

    @settings(max_examples=100, suppress_health_check=list(HealthCheck))
    @given(st.integers(1, 2).flatmap(lambda loops: mechanisms(planar, loops)))
    def check(m) -> None:
        parts = derived(to_kane(m).system)
        found = compared(parts.system, parts.constraints, None)
        assert not found.at.missed
        assert found.ranks[0] == len(parts.constraints.constraints)

    check()


@pytest.mark.slow
@pytest.mark.parametrize("planar", [True, False])
def test_near_a_closed_configuration_is_that(planar: bool) -> None:
    """Derived near the known configuration: it is the first one compared."""

    @settings(max_examples=20, suppress_health_check=list(HealthCheck))
    @given(st.integers(1, 2).flatmap(lambda loops: mechanisms(planar, loops)))
    def check(m) -> None:
        model = to_kane(m)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            first = kn.derive(model.system, near=model.q()).derived.compared.at.at(0)
        assert max(abs(first[q] - x) for q, x in model.q().items()) < 1e-9

    check()

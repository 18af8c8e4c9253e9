# SPDX-License-Identifier: BSD-3-Clause
"""Motions go on with other dependent speeds wherever the rates follow with these, whichever the system names."""

from __future__ import annotations

import pickle
import re
import warnings
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples
from tests.systems.wheels import disk, named, vehicle

SETS = (
    ("w3", "v_x"),
    *(pytest.param(x, marks=pytest.mark.slow) for x in (("w3", "v_y"), ("w2", "v_x"), ("w2", "v_y"))),
)


def ends(sol):
    assert sol.status == "finished", sol.message
    return np.array([sol[q][-1] for q in sol.equations.coordinates])


@pytest.mark.parametrize("dependent", SETS)
@pytest.mark.parametrize(
    "psi", [0.0, 0.3, pytest.param(np.pi / 2, marks=pytest.mark.slow), pytest.param(1e-9, marks=pytest.mark.slow)]
)
def test_a_disk_rolls_whichever_speeds_are_named(dependent, psi):
    q = {"psi": psi, "theta": 0.1, "phi": 0, "x": 0, "y": 0}
    rates = {"psi": 0.3, "theta": 0.1, "phi": 5.0}
    found, start = [], kn.assemble(kn.derive(disk()), q=q, rates=rates)
    for eom in (kn.derive(disk()), kn.derive(disk(dependent))):
        found.append(ends(kn.simulate(eom, (0, 2), q=start.q, u=start.u, samples=2)))
    np.testing.assert_allclose(found[1], found[0], atol=1e-7)


@pytest.mark.parametrize("dependent", [(), *SETS])
def test_a_disk_falls_flat_and_through_the_plane_that_nothing_keeps(dependent):
    """Upright angle pi/2 is a pole of W, but not of the motion: K + V stays, and the lean is that of a rod about its end."""
    eom = kn.derive(disk(dependent))
    start = kn.assemble(
        kn.derive(disk()),
        q={"psi": 0.7, "theta": 1.0, "phi": 0, "x": 0, "y": 0},
        rates={"psi": 0, "theta": 1, "phi": 0},
    )
    sol = kn.simulate(eom, (0, 0.3), q=start.q, u=start.u)
    lean = sol["theta"]
    assert sol.status == "finished"
    assert lean[-1] > np.pi / 2
    # J = m R^2/4 + m R^2 about the trace, m g R cos(theta)
    rate = np.sqrt(1 + 2 * 9.81 / (1.25 * 0.3) * (np.cos(1.0) - np.cos(lean)))
    np.testing.assert_allclose(sol["w1"], rate, rtol=1e-7)
    assert sol.energy_check.relative < 1e-7
    again = pickle.loads(pickle.dumps(sol))
    assert (
        len(again.segments)
        == len(sol.segments)
        == 1 + sum(e.name.startswith("dependent speeds") and t > 0 for e, t in sol.events)
    )
    np.testing.assert_array_equal(again.energy, sol.energy)


@pytest.mark.parametrize(
    ("dependent", "q", "u"),
    [
        (("w3", "v_x"), {"psi": 0.0, "theta": 0.1}, {"w1": 0.1, "w2": 5.0, "v_y": 0.0}),
        ((), {"psi": 0.3, "theta": np.pi / 2}, {"w1": 0.1, "w2": 5.0, "w3": 0.0}),
    ],
)
def test_the_speeds_that_a_message_names_are_a_cure(dependent, q, u):
    eom, q = kn.derive(disk(dependent)), {"phi": 0.0, "x": 0.0, "y": 0.0} | q
    with pytest.raises(kn.SingularError, match="dependent_speeds=") as told:
        eom.evaluate(list(eom.right_hand_side), q=q, u=u)
    cure = re.search(r"\) of (.*); kn.simulate", str(told.value)).group(1).split(", ")
    cured = kn.derive(disk(cure))
    free = {s.name: 0.4 for s in cured.independent_speeds}
    assert np.isfinite(cured.evaluate(list(cured.right_hand_side), q=q, u=free)).all()


@given(seed=st.integers(0, 10**6))
@examples(0.05, 2)
def test_vehicles_go_on_whichever_speeds_are_named(seed):
    rng = np.random.default_rng(seed)
    system = vehicle(rng)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)  # blades may hold more than the plane leaves open
        eom = kn.derive(system)
        assume(eom.independent_speeds)
        q = dict(zip((c.name for c in eom.coordinates), rng.uniform(-3, 3, len(eom.coordinates)), strict=True))
        start = kn.assemble(eom, q=q, u={s.name: float(rng.normal()) for s in eom.independent_speeds})
        sets = list(combinations([s.name for s in eom.speeds], len(eom.dependent_speeds)))
        try:
            other = kn.derive(named(system, sets[int(rng.integers(len(sets)))]))
        except kn.ModelError:  # speeds that the constraints give nowhere
            assume(False)
    expected = kn.simulate(eom, (0, 5), q=start.q, u=start.u)
    assume(expected.status == "finished")
    np.testing.assert_allclose(
        ends(kn.simulate(other, (0, 5), q=start.q, u=start.u)), ends(expected), rtol=1e-5, atol=1e-5
    )

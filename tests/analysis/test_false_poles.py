# SPDX-License-Identifier: BSD-3-Clause
"""Linearization and inverse dynamics where the declared speeds have a false pole: named, with a cure that works."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.dynamics.test_poles import cart, sled

TOLD = (
    r"a false pole, a singularity of the speeds but not of the motion\..*"
    r"System\(speeds=…\), \"rates\" for u = q', or choose a state farther from it"
)
RATES = {"sled": {"x": 0.0, "y": 0.0, "yaw": 0.0}, "cart": dict.fromkeys(("x", "y", "yaw", "left", "right"), 0.0)}
SYSTEMS = {"sled": sled, "cart": cart}


def at(eom, name, yaw):
    """A state that runs ahead at 1.1 m/s."""
    q = RATES[name] | {"yaw": yaw}
    rates = dict.fromkeys(q, 0.0) | {"x": 1.1 * np.cos(yaw), "y": 1.1 * np.sin(yaw)}
    if name == "cart":
        rates |= {"left": 5.5, "right": 5.5}
    found = kn.assemble(eom, q=q, rates=rates)
    return {"q": found.q, "u": found.u}


def by_rates(name, dependent=()):
    """The cure: the same with u = q̇."""
    return kn.derive(SYSTEMS[name]().replace(speeds="rates", dependent_speeds=dependent))


@pytest.mark.slow
@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("yaw", [np.pi / 2, np.pi / 2 - 1e-8, np.pi / 2 + 1e-5])
def test_at_the_pole_it_is_named_and_the_cure_works(name, yaw):
    # of a sled's rates u_y, which follows where motions begin, does not at the pole, as evaluate says
    eom, cured = kn.derive(SYSTEMS[name]()), by_rates(name, ("u_x",) if name == "sled" else ())
    with pytest.raises(kn.SingularError, match=rf"W of q' = W u \+ X that divides by cos\(yaw\).*{TOLD}"):
        kn.linearize(eom, **at(eom, name, yaw), steady=False)
    with pytest.raises(kn.SingularError, match=TOLD):
        kn.inverse(eom, [u.dt for u in eom.speeds])(**at(eom, name, yaw))
    there = at(cured, name, yaw)
    found = kn.inverse(cured, [u.dt for u in cured.speeds])(**there)
    wanted = cured.evaluate(list(cured.accelerations), **there)
    np.testing.assert_allclose([found[u.dt] for u in cured.speeds], wanted, atol=1e-9)
    linear = kn.linearize(cured, **there, steady=False)
    assert np.isfinite(linear.A).all()


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("yaw", [0.4, np.pi / 2 - 0.02, 3.0])
def test_away_from_it_nothing_is_refused(name, yaw):
    eom = kn.derive(SYSTEMS[name]())
    state = at(eom, name, yaw)
    found = kn.inverse(eom, [u.dt for u in eom.speeds])(**state)
    wanted = eom.evaluate(list(eom.accelerations), **state)
    np.testing.assert_allclose([found[u.dt] for u in eom.speeds], wanted, atol=1e-9)
    kn.linearize(eom, **state, steady=False)

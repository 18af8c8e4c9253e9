# SPDX-License-Identifier: BSD-3-Clause
"""A body in space strikes a rough floor: the kernel's impact beside SciPy's integration of the hodograph, and Python is not asked."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.motion import ContactMotion
from tests.examples import examples
from tests.oracles.contact_impacts import hodograph
from tests.systems.thrown_body import PARAMETERS, thrown_body

NEAR, SPAN = 1e-4, (0.0, 1e-3)
LAWS = ("stronge", "poisson", "newton")


@pytest.fixture(scope="module")
def bodies() -> dict[str, kn.Equations]:
    return {law: kn.derive(thrown_body(law)) for law in LAWS}


def turned(angles: Any) -> Any:
    (a, b, c), (x, y, z) = np.cos(angles), np.sin(angles)
    first = np.array([[1, 0, 0], [0, a, -x], [0, x, a]])
    return first @ [[b, 0, y], [0, 1, 0], [-y, 0, b]] @ [[c, -z, 0], [z, c, 0], [0, 0, 1]]


def struck(at: Any, arm: Any, inertia: Any) -> tuple[Any, Any, Any]:
    """W, v of the tip, normal first, and the kinetic energy, of Newton's and Euler's equations at a state (q, u)."""
    R, w, v = turned(at[:3]), at[6:9], at[9:12]
    x, y, z = R @ arm
    lever = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    mobility = np.eye(3) - lever @ R @ np.diag(1 / inertia) @ R.T @ lever
    order = [2, 0, 1]
    return mobility[np.ix_(order, order)], (v - lever @ R @ w)[order], (v @ v + w @ (inertia * w)) / 2


@examples(2)
@given(seed=st.integers(0, 2**32 - 1), law=st.sampled_from(LAWS))
def test_beside_the_hodograph(bodies: Any, seed: int, law: str) -> None:
    rng = np.random.default_rng(seed)
    arm, inertia, angles = rng.uniform(-1, 1, 3), rng.uniform(0.5, 1, 3), rng.uniform(-0.6, 0.6, 3)
    mu, e, at = rng.uniform(0.01, 1.2), rng.random(), np.zeros(12)
    at[:3], at[6:] = angles, rng.normal(size=6)
    at[5] = NEAR - (turned(angles) @ arm)[2]
    at[11] -= struck(at, arm, inertia)[1][0] + rng.uniform(0.2, 2)
    values = dict(zip(PARAMETERS, (*arm, *inertia, mu, e), strict=True))
    asked = list[str]()
    with warnings.catch_warnings(), pytest.MonkeyPatch.context() as patch:
        warnings.filterwarnings("ignore", "An impact increases", kn.KaneWarning)
        own = ContactMotion.hit

        def hit(*args: Any) -> Any:
            asked.append("hit")
            return own(*args)

        patch.setattr(ContactMotion, "hit", hit)
        sol = kn.simulate(bodies[law], SPAN, q=at[:6], u=at[6:], parameters=values, rtol=1e-12, atol=1e-13)
    when = next(t for e, t in sol.events if e.name == "floor closes")
    before, after = sol.states[np.flatnonzero(sol.t == when)[[0, -1]]]
    w, v, energy = struck(before, arm, inertia)
    _, left, rest = struck(after, arm, inertia)
    wanted, impulse = hodograph(w, v, mu, e, law)
    size = np.abs(v).max()
    np.testing.assert_allclose(left, wanted, rtol=0, atol=1e-9 * size)
    change = impulse @ (v + wanted) / 2
    assert rest - energy == pytest.approx(change, abs=1e-9 * energy)
    assert not asked or (law == "newton" and change > 0)  # a gain of energy is Python's to tell
    if law != "newton":
        assert rest <= energy * (1 + 1e-12)
    if e > 0.1:
        assert left[0] > 0
    assert np.linalg.norm(impulse[1:]) <= mu * impulse[0] * (1 + 1e-9)

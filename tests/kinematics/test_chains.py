# SPDX-License-Identifier: BSD-3-Clause
"""Many speeds, each defined by the rates before it: what is read of them grows with their number, not with its cube."""

import numpy as np
import pytest

import kane as kn
from kane.expr import differentiation
from kane.gallery import pendulums


def beads(n: int) -> kn.System:
    """Beads on a line, each placed from the one before; u_i is the velocity of the i-th, the sum of the first i rates."""
    N = kn.Frame("N")
    at, bodies, speeds = kn.Point("O", fixed_in=N), [], {}
    moved = 0 * kn.time
    m = kn.parameter("m", 2.0, "kg")
    for i in range(1, n + 1):
        q, u = kn.coordinate(f"q{i}", "m"), kn.speed(f"u{i}", "m/s")
        at = at.at(f"P{i}", q * N.x)
        moved = moved + q.dt
        bodies.append(kn.Particle(f"bead {i}", at, m))
        speeds[u] = moved
    force = kn.Force(at, kn.parameter("F", 3.0, "N") * N.x)
    return kn.System(N, bodies=bodies, speeds=speeds, loads=[force])


def test_the_last_bead_alone_is_pushed():
    n = 60
    eom = kn.derive(beads(n))
    u = np.linspace(1, 2, n)
    rates = eom.evaluate(list(eom.right_hand_side), q=np.zeros(n), u=u)
    assert rates == pytest.approx([1, *np.diff(u), *[0] * (n - 1), 1.5])


def test_definitions_that_share_sums_are_read_once(monkeypatch):
    seen = []
    combined = differentiation.combined
    monkeypatch.setattr(differentiation, "combined", lambda node, parts: seen.append(node) or combined(node, parts))
    n = 60
    kn.derive(beads(n))
    assert len(seen) < 10 * n  # n²/2 and more where each definition and velocity is read anew


def test_the_end_of_a_long_chain_that_turns_as_one_is_pulled_to_its_pin():
    n = 600  # more links than a recursion from motion to motion has room for
    eom = kn.derive(pendulums.system(n))
    center = eom.system.bodies[-1].parts()[0].mass_center
    x, y, _ = eom.point_accelerations[center].components(eom.system.inertial)
    still = dict.fromkeys((u.dt for u in eom.speeds), 0.0)
    turning = dict.fromkeys(eom.coordinates, 0.0) | dict.fromkeys(eom.speeds, 0.5)
    assert kn.evaluate([x, y], turning | still) == pytest.approx([0, 0.25 * (n - 0.5)])

# SPDX-License-Identifier: BSD-3-Clause
"""States that are given whole are held to the constraints by shares of their terms: the verdict is the same in any units."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

LENGTHS = [1e-6, 1e-3, 1.0, 1e6]


def pendulum(length):
    """A bob on a rod, kept by x and y."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    bob = O.at("bob", x * N.x + y * N.y)
    particle = kn.Particle("bob", bob, 2.0)
    gravity = kn.gravity(-9.81 * length * N.y)
    return kn.derive(
        kn.System(N, bodies=[particle], speeds="rates", loads=[gravity], holonomic=kn.distance(bob, O, length))
    )


def uses(eom, q, u):
    """All that take a state whole."""
    yield lambda: kn.assemble(eom, q=q, u=u)
    yield lambda: kn.linearize(eom, q=q, u=u)
    yield lambda: kn.inverse(eom, [s.dt for s in eom.speeds])(q=q, u=u)


@pytest.mark.parametrize("length", LENGTHS)
def test_coordinates(length):
    eom = pendulum(length)
    for off, fine in ((1e-10, True), (1e-6, False)):
        for use in uses(eom, [0.0, -length * (1 + off)], [0.0, 0.0]):
            if fine:
                use()
            else:
                with pytest.raises(kn.SimulationError, match="coordinates that miss"):
                    use()


@pytest.mark.parametrize("length", LENGTHS)
def test_speeds(length):
    """Along the circle they hold, and across it they miss it, however small they are in m/s."""
    eom = pendulum(length)
    q = [length * np.sin(0.3), -length * np.cos(0.3)]
    for pace in (1e-6, 1.0, 1e6):
        along, across = pace * length * np.array([[np.cos(0.3), np.sin(0.3)], [np.sin(0.3), -np.cos(0.3)]])
        found = kn.assemble(eom, q=q, u=along + 1e-10 * across)
        np.testing.assert_allclose(list(found.u.values()), along + 1e-10 * across, rtol=1e-9)
        with pytest.raises(kn.SimulationError, match="got values that miss"):
            kn.assemble(eom, q=q, u=along + 1e-4 * across)
        with pytest.raises(kn.SimulationError, match="satisfy the constraints"):
            kn.linearize(eom, q=q, u=along + 1e-4 * across, steady=False)

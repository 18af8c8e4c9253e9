# SPDX-License-Identifier: BSD-3-Clause
"""Constraints that are nearly the same everywhere hold what they hold; those that lose rank at a position let pass."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.systems.four_bar import N, O
from tests.systems.parallelogram import Parallelogram


def planar(*constraints, unit=1.0):
    """A particle that falls, by x and y."""
    x, y = kn.coordinates("x y")
    p = O.at("p", x * N.x + y * N.y)
    system = kn.System(
        N, bodies=[kn.Particle("p", p, 1)], speeds="rates", loads=[kn.gravity(-9.81 * unit * N.y)],
        holonomic=[c(x, y) for c in constraints],
    )  # fmt: skip
    return kn.derive(system)


@pytest.mark.slow
@pytest.mark.parametrize("unit", [1.0, 1e6, 1e-6])
@pytest.mark.parametrize("slope", [1.0003, 1 + 3e-6])
def test_two_lines_that_nearly_coincide_hold_their_point(slope, unit):
    eom = planar(lambda x, y: x - y, lambda x, y: x - slope * y, unit=unit)
    sol = kn.simulate(eom, (0, 1), q=[0, 0], u=[0, 0], samples=3)
    assert sol.status == "finished"
    assert np.abs(sol.q).max() < 1e-9 * unit
    assert sol.events == ()


@pytest.mark.parametrize("kind", ["holonomic", "nonholonomic"])
def test_a_braked_reducer_stands(kind):
    """Sun 101, planets 100 and 99, output 100: it goes round once in 10,000 turns of the arm, and holds them all when it is braked."""
    arm, planet, output = kn.coordinates("arm planet output")
    frames = [N.rotate(str(x).upper(), x, N.z) for x in (arm, planet, output)]
    bodies = [kn.RigidBody(f.name, frame=f, mass_center=O, mass=1, inertia=kn.inertia(f, 1, 1, 1)) for f in frames]
    a, p, o = (arm, planet, output) if kind == "holonomic" else (arm.dt, planet.dt, output.dt)
    rows = [101 * (0 - a) + 100 * (p - a), 99 * (p - a) + 100 * (o - a), o]
    system = kn.System(N, bodies=bodies, speeds="rates", loads=[kn.Torque(frames[0], N.z)], **{kind: rows})
    sol = kn.simulate(kn.derive(system), (0, 1), q=[0, 0, 0], u=[0, 0, 0], samples=3)
    assert np.abs(sol.q).max() < 1e-9


@pytest.mark.filterwarnings("ignore:.*depend on each other")
@pytest.mark.parametrize("seed", [*range(3), *(pytest.param(k, marks=pytest.mark.slow) for k in range(3, 23))])
def test_random_constraints_of_known_rank(seed):
    """Rows of shares down to 1e-7 of the largest, and some that follow from them: what is free moves as q = P F t²/2 says."""
    rng = np.random.default_rng(seed)
    n, rank = 4, int(rng.integers(1, 4))
    basis, turn = (np.linalg.qr(rng.normal(size=(n, n)))[0] for _ in range(2))
    values = 10.0 ** np.concatenate([[0.0], rng.uniform(-7, 0, rank - 1)])
    c = turn[:, :rank] * values @ basis[:, :rank].T if seed % 2 else (turn[:rank, :rank] * values) @ basis[:, :rank].T
    q, pull = kn.coordinates(f"q1:{n + 1}"), rng.normal(size=n)
    points = [O.at(f"p{i}", x * N.x) for i, x in enumerate(q)]
    system = kn.System(
        N, bodies=[kn.Particle(p.name, p, 1) for p in points], speeds="rates",
        loads=[kn.Force(p, f * N.x) for p, f in zip(points, pull, strict=True)],
        holonomic=[sum(x * float(k) for x, k in zip(q, row, strict=True)) for row in c],
    )  # fmt: skip
    sol = kn.simulate(kn.derive(system), (0, 1), q=[0] * n, u=[0] * n, samples=2)
    free = basis[:, rank:] @ basis[:, rank:].T
    np.testing.assert_allclose(sol.q[-1], free @ pull / 2, atol=1e-6)


def test_a_curve_and_a_surface_that_nearly_touch_everywhere():
    """x² + y² = 1, and the same with 1e-5 z: z = 0, while A changes all along."""
    x, y, z = kn.coordinates("x y z")
    p = O.at("p", x * N.x + y * N.y + z * N.z)
    ring = x**2 + y**2 - 1
    system = kn.System(
        N, bodies=[kn.Particle("p", p, 1)], speeds="rates", loads=[kn.Force(p, 0.3 * N.z)],
        holonomic=[ring, ring + 1e-5 * z],
    )  # fmt: skip
    sol = kn.simulate(kn.derive(system), (0, 6), q=[1, 0, 0], u=[0, 1, 0], samples=13)
    np.testing.assert_allclose(sol["z"], 0, atol=1e-8)
    np.testing.assert_allclose(sol["y"], np.sin(sol.t), atol=1e-6)


class TestBoth(Parallelogram):
    """Lines that nearly coincide, and a parallelogram that passes its change point: the one holds, the other lets pass."""

    @pytest.mark.slow
    @pytest.mark.parametrize("first", [-0.3, 0.0])
    def test_it_swings_through(self, first):
        r, s = kn.coordinates("r s")
        point = O.at("weight", r * N.x + s * N.y)
        system = kn.System(
            N,
            bodies=[*self.bodies, kn.Particle("weight", point, 1)],
            speeds="rates",
            loads=[kn.Force(point, -9.81 * N.y)],
            holonomic=[*self.closed(), r - s, r - 1.00003 * s],
        )
        eom = kn.derive(system)
        given = dict(zip((*self.q, r, s), (first, 0.0, np.pi + first, 0.0, 0.0), strict=True))
        turning = {"u1": 1.0, "u2": 0.0, "u3": 1.0, "u_r": 0.0, "u_s": 0.0}
        sol = kn.simulate(eom, (0, 1), q=given, u=turning, rtol=1e-10, atol=1e-10, samples=3)
        np.testing.assert_allclose(sol["u1"], 1, atol=1e-6)
        # the lines meet at 3e-5: what misses them by rounding is as far from their crossing as 1e-12 is over that angle
        np.testing.assert_allclose(np.abs(sol[[r, s]]).max(), 0, atol=1e-7)
        drops = [e.message for e, _ in sol.events if e.name == "rank of the constraints drops"]
        assert drops
        assert all("'close 1'" in m or "'close 2'" in m for m in drops)

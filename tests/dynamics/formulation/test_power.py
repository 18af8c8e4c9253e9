# SPDX-License-Identifier: BSD-3-Clause
"""One freedom: u̇ from the power of the forces is that of the classical route; not where velocities are not homogeneous."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import classical, homogeneous, power, squares
from kane.gallery import load
from tests.examples import examples


def held_chain(seed: int) -> kn.System:
    """Links in space by angles to each other, all but one freedom held by blades; one blade is steered by an input."""
    rng = np.random.default_rng(seed)
    N, g, steer = kn.Frame("N"), kn.parameter("g", 9.81), kn.input("steer", "rad")
    at, frame, bodies, loads = kn.Point("O", fixed_in=N), N, [], [kn.gravity(-g * N.y)]
    blades: list[kn.Constraint] = []
    for k in range(int(rng.integers(2, 5))):
        axis = getattr(frame, rng.choice(["z", "z", "y"]))
        B = frame.rotate(f"B{k}", kn.coordinate(f"q{k}"), axis)
        m, a = kn.parameter(f"m{k}", rng.uniform(0.5, 2)), kn.parameter(f"a{k}", rng.uniform(0.3, 1))
        inertia = kn.inertia(B, *rng.uniform(0.2, 0.3, 3), *rng.uniform(-0.02, 0.02, 3))
        bodies.append(kn.RigidBody(f"link {k}", frame=B, mass_center=at.at(f"C{k}", a * B.x), mass=m, inertia=inertia))
        loads.append(kn.Torque(B, kn.input(f"T{k}") * axis))
        at, frame = at.at(f"P{k}", a * B.x + a / 2 * B.z), B
        if k:
            blade = B.rotate(f"blade {k}", steer if k == 1 else rng.uniform(-1, 1), B.z)
            blades += kn.no_slip(at, along=0.8 * blade.y + 0.6 * blade.z, name=f"blade {k}")
    return kn.System(N, bodies=bodies, speeds="rates", loads=loads, nonholonomic=blades)


@pytest.mark.parametrize("route", [power, squares])
@given(seed=st.integers(0, 10**6))
@examples(0.1)
def test_the_power_gives_the_numbers_of_the_classical_route(route, seed):
    eom = kn.derive(held_chain(seed))
    d, partition = eom.derived, eom.embedding.partition
    usual = classical(d, partition)
    assert homogeneous(d, usual.embedding)
    found = route(d, usual.embedding)
    rng = np.random.default_rng(seed)
    q, u = rng.uniform(-1, 1, len(eom.coordinates)), {s: rng.normal() for s in eom.independent_speeds}
    inputs = {s: rng.normal() for s in eom.inputs}
    here, there = (
        np.array(eom.evaluate(list(s.accelerations), q=q, u=u, inputs=inputs), dtype=float) for s in (found, usual)
    )
    assert np.abs(here - there).max() <= 1e-9 * np.abs(there).max()


@pytest.mark.parametrize(
    ("name", "taken"), [("andrews_squeezer", True), ("car_with_trailer", True), ("snakeboard", False)]
)
def test_it_is_for_one_freedom(name, taken):
    eom = kn.derive(load(name).system())
    assert homogeneous(eom.derived, eom.embedding) is taken


@pytest.mark.parametrize("carried", [True, False])
def test_it_is_not_for_motions_that_are_prescribed(carried):
    """A pendulum on a table that moves, or turned by a belt that does: K is not quadratic in u."""
    N, t = kn.Frame("N"), kn.time
    O, (q, p), (u, w) = kn.Point("O", fixed_in=N), kn.coordinates("q p"), kn.speeds("u w")
    A, B = N.rotate("A", q, N.z), N.rotate("B", p, N.z)
    P = O.at("P", (kn.sin(3 * t) if carried else 0) * N.x).at("Q", A.x)
    turning = kn.RigidBody("wheel", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, 1, 1, 1))
    eom = kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("P", P, 1), turning],
            speeds={u: q.dt, w: p.dt},
            loads=[kn.gravity(-9.81 * N.y)],
            nonholonomic=[p.dt - kn.cos(q) * q.dt - (0 if carried else kn.sin(t))],
            dependent_speeds=[w],
        )
    )
    assert not homogeneous(eom.derived, eom.embedding)

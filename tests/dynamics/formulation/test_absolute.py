# SPDX-License-Identifier: BSD-3-Clause
"""Absolute rates in the places of relative ones: the same numbers, never more operations, and no divisor that was not there."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import absolute, classical, shortest_in_given_speeds
from kane.errors import ModelError
from kane.gallery import load, pendulums
from tests.dynamics.formulation.test_shortest import admissible
from tests.examples import examples

RELATIVE = ("andrews_squeezer", "car_with_trailer", "snakeboard")


def numbers(eom, solved, q, u):
    """u̇ and the reactions at a state."""
    roots, inputs = [*solved.accelerations, *solved.reactions], dict.fromkeys(eom.inputs, 0.3)
    return np.array(eom.evaluate(roots, q=q, u=u, inputs=inputs), dtype=float)


def chain(seed: int) -> kn.System:
    """Links on one another about mostly parallel axes, some on slides, with loads in relative rates."""
    rng = np.random.default_rng(seed)
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    links, bodies, loads = [(kn.Point("O", fixed_in=N), N)], [], [kn.gravity(-g * N.y)]
    for k in range(int(rng.integers(2, 5))):
        at, before = links[rng.integers(max(0, len(links) - 2), len(links))]
        axis = getattr(before, rng.choice(["z", "z", "z", "y"]))
        q, m, a = kn.coordinate(f"q{k}"), kn.parameter(f"m{k}", 1.0), kn.parameter(f"a{k}", 0.5)
        if rng.random() < 0.2:
            at = at.at(f"slide {k}", kn.coordinate(f"s{k}") * before.x)
        B = before.rotate(f"B{k}", rng.choice([-1, 1]) * q, axis)
        inertia = kn.inertia(B, *kn.parameters(f"Ix{k} Iy{k} Iz{k}", 0.1))
        bodies.append(kn.RigidBody(f"link {k}", frame=B, mass_center=at.at(f"C{k}", a * B.x), mass=m, inertia=inertia))
        loads.append(kn.torque_pair(B, before, -kn.parameter(f"c{k}", 0.1) * q.dt * axis, name=f"damper {k}"))
        links.append((at.at(f"P{k}", a * B.x + a * B.y), B))
    return kn.System(N, bodies=bodies, speeds="rates", loads=loads)


def test_rods_by_relative_angles_take_a_sum_a_rod_more_than_by_absolute_ones():
    relative, free = (kn.derive(pendulums.system(4, relative=r)).operations.total for r in (True, False))
    assert relative <= free + 5


@given(st.integers(0, 10**6))
@examples(0.1)
def test_links_about_parallel_axes_take_no_more_operations_than_by_their_own_rates(seed):
    eom = kn.derive(chain(seed))
    by_rates = shortest_in_given_speeds(eom.derived, None)
    assert eom.operations.total <= by_rates.operations.total
    rng = np.random.default_rng(seed)
    q, u = rng.uniform(-3, 3, len(eom.coordinates)), rng.normal(size=len(eom.speeds))
    found, wanted = (numbers(eom, s, q, u) for s in (eom.solved, by_rates))
    size = np.abs(wanted).max() * np.linalg.cond(np.array(eom.evaluate(eom.mass_matrix, q=q), dtype=float))
    assert np.abs(found - wanted).max() <= 1e-13 * size


@pytest.mark.parametrize("name", RELATIVE)
def test_under_constraints_they_give_the_numbers_of_the_classical_route(name, rng):
    eom = kn.derive(load(name).system())
    assert absolute(eom.derived, eom.embedding.partition) is not None
    usual = classical(eom.derived, eom.embedding.partition)
    assert eom.operations.total < shortest_in_given_speeds(eom.derived, eom.embedding.partition).operations.total
    for q, u in admissible(eom, name, rng, 3):
        wanted = numbers(eom, usual, q, u)
        assert np.abs(numbers(eom, eom.solved, q, u) - wanted).max() <= 1e-10 * np.abs(wanted).max()


def two_links(dependent: str) -> kn.Equations:
    """Two pinned links whose end keeps its height."""
    N = kn.Frame("N")
    O, q, u = kn.Point("O", fixed_in=N), kn.coordinates("q1 q2"), kn.speeds("u1 u2")
    A = N.rotate("A", q[0], N.z)
    B = A.rotate("B", q[1], A.z)
    P = O.at("P", A.x)
    Q = P.at("Q", B.x)
    return kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("P", P, kn.parameter("m", 1.0)), kn.Particle("Q", Q, kn.parameter("M", 2.0))],
            speeds=dict(zip(u, (x.dt for x in q), strict=True)),
            loads=[kn.gravity(-kn.parameter("g", 9.81) * N.y)],
            nonholonomic=kn.no_slip(Q, along=N.y, name="height"),
            dependent_speeds=[s for s in u if s.name == dependent],
        )
    )


@pytest.mark.parametrize(("dependent", "taken"), [("u1", False), ("u2", True)])
def test_dependent_speeds_are_divided_by_what_they_were(dependent, taken):
    """By u̇₁ from Ω₂ one would divide by cos q₁, by u̇₁ from u₂ one divides by cos q₁ + cos (q₁ + q₂)."""
    eom = two_links(dependent)
    partition = eom.embedding.partition
    assert (absolute(eom.derived, partition) is not None) is taken
    usual = classical(eom.derived, partition)
    for q1 in (np.pi / 2, 0.4):
        q, u = (q1, 0.3), dict.fromkeys(eom.independent_speeds, 0.7)
        assert numbers(eom, eom.solved, q, u) == pytest.approx(numbers(eom, usual, q, u), rel=1e-12)


def test_an_error_speaks_of_the_declared_speeds():
    N = kn.Frame("N")
    O, q, u = kn.Point("O", fixed_in=N), kn.coordinates("q1 q2"), kn.speeds("u1 u2")
    A = N.rotate("A", q[0], N.z)
    B = A.rotate("B", q[1], A.z)
    body = kn.RigidBody("A", frame=A, mass_center=O, mass=1, inertia=kn.inertia(A, 1, 1, 1))
    loads = [kn.Torque(B, kn.input("T") * B.z)]
    with pytest.raises(ModelError) as error:
        kn.derive(kn.System(N, bodies=[body], speeds=dict(zip(u, (x.dt for x in q), strict=True)), loads=loads))
    assert "u2" in str(error.value)
    assert "Omega_" not in str(error.value)

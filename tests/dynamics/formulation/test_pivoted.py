# SPDX-License-Identifier: BSD-3-Clause
"""Bodies about points at rest, with their inertia about these: the same u̇ and reactions, in fewer operations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import about_points_at_rest, classical, contacts, embedded, embedded_motions, touches
from kane.gallery import load
from tests.dynamics.formulation.test_absolute import numbers
from tests.dynamics.formulation.test_power import held_chain
from tests.dynamics.formulation.test_shortest import admissible
from tests.examples import examples


@given(st.integers(0, 10**6))
@examples(0.1)
def test_the_first_link_of_a_chain_turns_about_its_pin(seed):
    """In space, with products of inertia; the others have no point at rest."""
    eom = kn.derive(held_chain(seed))
    usual = classical(eom.derived, eom.embedding.partition)
    moving = embedded_motions(eom.derived, usual.embedding, {})
    inertial, forced = about_points_at_rest(moving.bodies, moving.kinematics)
    assert [a is b for a, b in zip(inertial, moving.bodies, strict=True)] == [False, *[True] * (len(inertial) - 1)]
    rng = np.random.default_rng(seed)
    q, u = rng.uniform(-1, 1, len(eom.coordinates)), {s: rng.normal() for s in eom.independent_speeds}
    wanted = numbers(eom, usual, q, u)
    for bodies, carried in (((inertial, forced), False), ((inertial, forced), True), (None, True)):
        found = embedded(eom.derived, usual.embedding, moving, bodies, carried=carried)
        assert np.abs(numbers(eom, found, q, u) - wanted).max() <= 1e-9 * np.abs(wanted).max()


def test_a_rocker_turns_about_the_pin_that_closes_its_loop():
    eom = kn.derive(load("four_bar").system())
    d, e = eom.derived, eom.embedding
    through = contacts(touches(d.constraints.constraints, e.partition.rows, d.kinematics), {}, d.kinematics)
    for particles, turning in (({}, 1), (through, 2)):
        moving = embedded_motions(d, e, particles)
        inertial, _ = about_points_at_rest(moving.bodies, moving.kinematics)
        assert sum(a is not b for a, b in zip(inertial, moving.bodies, strict=True)) == turning
    a, m1 = (next(s for s in eom.parameters if s.name == name) for name in ("a", "m1"))
    rows = about_points_at_rest(moving.bodies, moving.kinematics)[0][0].rotation.inertia.rows
    values = {s: s.default for s in eom.parameters}
    assert kn.evaluate(rows[2][2], values) == pytest.approx(values[m1] * values[a] ** 2 / 3, rel=1e-14)


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "rattleback"])
def test_reactions_are_those_of_the_classical_route(name, rng):
    eom = kn.derive(load(name).system())
    usual = classical(eom.derived, eom.embedding.partition)
    assert eom.reactions
    for q, u in admissible(eom, name, rng, 3):
        wanted = numbers(eom, usual, q, u)
        assert np.abs(numbers(eom, eom.solved, q, u) - wanted).max() <= 1e-10 * np.abs(wanted).max()


def test_a_body_on_a_point_that_is_moved_keeps_its_central_inertia():
    N = kn.Frame("N")
    O, (q, p), (u, w) = kn.Point("O", fixed_in=N), kn.coordinates("q p"), kn.speeds("u w")
    A = N.rotate("A", q, N.z)
    P = O.at("P", kn.sin(kn.time) * N.x)
    body = kn.RigidBody("A", frame=A, mass_center=P.at("C", A.x), mass=1, inertia=kn.inertia(A, 1, 1, 1))
    other = kn.Particle("Q", O.at("Q", p * N.y), 1)
    speeds = {u: q.dt, w: p.dt}
    eom = kn.derive(kn.System(N, bodies=[body, other], speeds=speeds, nonholonomic=[p.dt - q.dt]))
    moving = embedded_motions(eom.derived, eom.embedding, {})
    assert about_points_at_rest(moving.bodies, moving.kinematics) is None

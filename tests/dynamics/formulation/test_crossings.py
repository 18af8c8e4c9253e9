# SPDX-License-Identifier: BSD-3-Clause
"""Reactions by recursion: what joints transmit is as the classical route has it, also where loads are made of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import by_recursion, carrying, classical, derived
from kane.gallery import rolling_disk
from tests.dynamics.formulation.test_recursive import SEEDS, state
from tests.examples import examples
from tests.systems import cuts


def off(system):
    """The largest difference of u̇ and R by recursion from those of the classical route, over the largest of them."""
    parts = derived(system)
    found, usual = by_recursion(parts, carrying(parts), "recursive"), classical(parts, None)
    assert len(found.reactions) == len(system.reactions)
    roots = [*found.accelerations, *found.reactions, *usual.accelerations, *usual.reactions]
    worst = 0.0
    for seed in SEEDS:
        own, other = np.array(kn.evaluate(roots, state(roots, seed)), dtype=float).reshape(2, -1)
        worst = max(worst, np.abs(own - other).max() / np.abs(other).max())
    return worst


@pytest.mark.slow
@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize("seed", [5, 11, 15, 22])
def test_cuts_at_joints_within_what_is_rigid_and_before_what_slides(seed, friction):
    assert off(cuts.tree(seed, 2 + seed % 6, friction)) < 1e-9


@examples(0.3)
@given(st.integers(0, 10**6), st.integers(1, 7), st.booleans())
def test_reactions_of_any_tree(seed, bodies, friction):
    assert off(cuts.tree(seed, bodies, friction)) < 1e-9


def test_operations_of_all_reactions_grow_as_the_chain():
    counts = []
    for n in (12, 24):
        eom = kn.derive(cuts.held(n))
        assert eom.route == "recursive"
        assert len(eom.reactions) == 3 * n
        counts.append(eom.operations.total)
    assert counts[1] / counts[0] < 2.3


@pytest.mark.slow
def test_the_disk_slides_by_recursion_too():
    system = rolling_disk.system()
    assert off(system) < 1e-9
    with pytest.raises(kn.ModelError, match="got loads that contain reactions"):
        kn.derive(system, route="composite")


@pytest.mark.slow
def test_friction_in_every_pin_is_solved_for_with_the_accelerations():
    """Each torque is a share of a normal force: R of a small block, u̇ by these."""
    system = cuts.held(6, friction=True)
    eoms = [kn.derive(system), kn.derive(system, route="classical")]
    assert [e.route for e in eoms] == ["recursive", "classical"]
    assert eoms[0].operations.total < eoms[1].operations.total
    at = {"q": np.linspace(0.2, 1, 6), "u": np.linspace(1, -1, 6)}
    own, usual = (np.array(e.evaluate([*e.accelerations, *e.reactions], **at)) for e in eoms)
    assert np.abs(own - usual).max() < 1e-10 * np.abs(usual).max()


def test_a_cut_of_a_frame_that_others_do_not_follow_is_left_to_the_classical_route():
    """Links by absolute angles: what is beyond the frame of one is moved by it and not turned."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    at, bodies, frames = kn.Point("O", fixed_in=N), [], []
    for i in range(1, 8):
        frames.append(N.rotate(f"B{i}", kn.coordinate(f"q{i}"), N.z))
        at = at.at(f"P{i}", frames[-1].x * 1.0)
        bodies.append(kn.Particle(f"p{i}", at, kn.parameter(f"m{i}", 1.0)))
    held = kn.reaction("T", frame=frames[2], along=N.x)
    system = kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.y)], reactions=[held])
    at_state = {"q": np.linspace(0, 2, 7), "u": np.linspace(1, -2, 7)}
    eoms = [kn.derive(system), kn.derive(system, route="classical")]
    values = [np.array(e.evaluate([*e.accelerations, held], **at_state)) for e in eoms]
    assert np.abs(values[0] - values[1]).max() < 1e-10 * np.abs(values[1]).max()


def test_a_load_that_moves_with_a_cut_frame_from_outside():
    """The mass centre of two bodies hangs on neither: what turns the second moves it."""
    N = kn.Frame("N")
    q, u = kn.coordinate("q"), kn.speed("u")
    length, m, moment, lift = kn.parameters("L m J P")
    A = N.rotate("A", q, N.z)
    B = A.rotate("B", kn.input("s"), A.z)
    torque, turning = kn.reaction("R"), kn.auxiliary_speed("a", frame=B, along=B.z)
    O = kn.Point("O", fixed_in=N)
    first, knee = O.at("C1", length * A.x), O.at("K", 2 * length * A.x)
    second = knee.at("C2", length * B.x)
    center = O.at("C", (3 * length * A.x + length * B.x) / 2)
    system = kn.System(
        N,
        bodies=[
            kn.RigidBody("A", frame=A, mass_center=first, mass=m, inertia=kn.inertia(A, 0, 0, moment)),
            kn.RigidBody("B", frame=B, mass_center=second, mass=m, inertia=kn.inertia(B, 0, 0, moment)),
        ],
        loads=[kn.loads.Force(center, lift * N.y), kn.loads.torque_pair(B, A, torque * N.z)],
        speeds={u: q.dt},
        auxiliary_speeds=[turning],
        reactions=[torque],
    )
    with pytest.raises(
        kn.ModelError, match="got loads that contain reactions"
    ):  # none of the way tells what is transmitted
        kn.derive(system, route="recursive")
    assert "P" in {x.name for x in kn.free_symbols(kn.derive(system).reaction_values)}

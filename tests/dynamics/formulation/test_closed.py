# SPDX-License-Identifier: BSD-3-Clause
"""Constraints by recursion: u̇ and reactions are those of the classical route, in operations that grow as the tree."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import count_operations
from kane.dynamics import WAYS, by_recursion, carrying, tree_with_reactions
from kane.gallery import GALLERY, load
from kane.kinematics import Unsuited
from tests.examples import examples
from tests.laws.test_random_loops import State, multiplier_form
from tests.oracles.compare import tolerance
from tests.oracles.mechanism_draw import mechanisms, questions
from tests.systems import rings
from tests.systems.closed_states import states

SYSTEMS = {name: load(name).system() for name in GALLERY}
CONSTRAINED = [name for name, system in SYSTEMS.items() if system.constraints]
"""All of the gallery that have constraints: none is left out."""


def off(system, seed=1, count=2, routes=("recursive",)):
    """The largest difference of u̇, R and λ by recursion from those of the classical route, over the largest of them."""
    usual, *others = (kn.derive(system, route=route) for route in ("classical", *routes))
    assert [e.route for e in others] == list(routes)
    worst, inputs = 0.0, dict.fromkeys(system.inputs, 0.3)
    for q, u in states(usual, np.random.default_rng(seed), count, inputs=inputs):
        wanted, *found = (
            np.array(e.evaluate([*e.accelerations, *e.reactions, *e.multipliers.values()], q=q, u=u, inputs=inputs))
            for e in (usual, *others)
        )
        worst = max(worst, *(np.abs(x - wanted).max() / np.abs(wanted).max() for x in found))
    return worst


@pytest.mark.slow
@pytest.mark.parametrize("name", CONSTRAINED)
def test_the_gallery(name):
    assert off(SYSTEMS[name], routes=WAYS) < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("name", CONSTRAINED)
def test_what_is_transmitted_in_the_gallery(name):
    """Forces and torques of joints, constraints and bodies by name: from λ and the accelerations, whichever route found them."""
    system = SYSTEMS[name]
    usual, *others = (kn.derive(system, route=route) for route in ("classical", *WAYS))
    frames = [b.frame for b in system.bodies if isinstance(b, kn.RigidBody)]
    places = [p for p in (*system.joints, *system.constraints, *frames) if _is_read(usual, p)]
    assert places
    inputs = dict.fromkeys(system.inputs, 0.3)
    for q, u in states(usual, np.random.default_rng(1), 1, inputs=inputs):
        wanted, *found = (
            np.array(e.evaluate(_transmitted(e, places), q=q, u=u, inputs=inputs)) for e in (usual, *others)
        )
        assert max(np.abs(x - wanted).max() for x in found) <= 1e-10 * np.abs(wanted).max()


def _is_read(eom, place):
    try:
        eom.reaction(place)
    except kn.ReactionError:
        return False
    return True


def _transmitted(eom, places):
    wrenches = [eom.reaction(p) for p in places]
    vectors = [v for w in wrenches for v in (w.force, w.torque) if v is not None]
    return [x for v in vectors for x in v.components(eom.system.inertial)]


@pytest.mark.slow
@pytest.mark.parametrize("spatial", [False, True])
def test_rings_with_reactions(spatial):
    assert off(rings.ring(6, spatial, reactions=4), routes=WAYS) < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("planar", [True, False])
def test_random_loops(planar):
    @examples(0.1, 2)
    @given(st.data(), mechanisms(planar, 1, max_parts=4), st.integers(0, 2**16))
    def check(data, m, seed):
        state = State(m, data.draw(questions(len(m.parts))), seed)
        for route in WAYS:
            try:
                carried = carrying(state.eom.derived, shared=True)
                found = by_recursion(state.eom.derived, carried, route, state.eom.embedding.partition)
            except Unsuited:
                return
            own = tree_with_reactions(state.eom.derived, found)
            roots = ([*e.accelerations, *e.reactions, *e.multipliers.values()] for e in (own, state.eom))
            found, wanted = map(state.values, roots)
            _, _, condition = multiplier_form(state)
            assert np.abs(found - wanted).max() <= tolerance(1e-9, condition**2) * np.abs(wanted).max()

    check()


@pytest.mark.slow
def test_multipliers_are_those_that_u_dot_is_made_with():
    """No mass matrix is assembled for them, and no operation is left to do; without recursion they are less what loads hold."""
    eom = kn.derive(rings.ring(24, True))
    forces = list(eom.multipliers.values())
    both = count_operations([*eom.accelerations, *forces]).total
    assert both == count_operations(eom.accelerations).total
    assert "mass_matrix" not in eom.derived.__dict__


def test_multipliers_with_a_load_along_what_is_held():
    """The end of a chain is pulled along the line that holds it: λ is less by the force, u̇ as it was."""
    values = []
    for pull in (0.0, 3.0):
        system = rings.ring(14)
        end = system.constraints[0].forces[0][0]
        x = system.constraints[0].forces[0][1]
        eom = kn.derive(system.with_loads([*system.loads, kn.Force(end, pull * x)] if pull else system.loads))
        assert eom.route == "recursive"
        ((q, u),) = states(kn.derive(system), np.random.default_rng(3), 1)
        roots = [*eom.accelerations, *eom.multipliers.values()]
        values.append(np.array(eom.evaluate(roots, q=q, u=u)))
    change = values[1] - values[0]
    assert np.abs(change[:14]).max() <= 1e-9 * np.abs(values[0]).max()
    assert change[14:] == pytest.approx([-3.0, 0.0], abs=1e-9 * np.abs(values[0]).max())


def test_operations_grow_as_the_ring():
    counts = [kn.derive(rings.ring(n, True), route="recursive").operations.total for n in (6, 12)]
    assert counts[1] / counts[0] < 2.6
    assert counts[1] < 4500


def test_a_ring_of_many_links_is_solved_by_recursion_and_another_by_what_is_shorter():
    many, few = kn.derive(rings.ring(14)), kn.derive(rings.ring(4))
    assert many.route == "recursive"
    assert few.route != "recursive"
    assert kn.derive(rings.ring(6, True)).route == "composite"
    six = kn.derive(rings.ring(6))
    assert six.routes[six.route] == min(six.routes.values()) == six.operations.total


@pytest.mark.slow
def test_a_singular_configuration_is_said():
    """A stretched ring of two links: A has lost its rank there."""
    eom = kn.derive(rings.ring(2), route="recursive")
    held = {"parameters": {"a": 0.0, "b": 1.0}}
    with pytest.raises(kn.SingularError, match=r"got u1, u2, which they give divided by .* singular configuration"):
        eom.evaluate(eom.accelerations, q=[0.0, 0.0], u=[0.0, 0.0], **held)
    beside = eom.evaluate(
        eom.accelerations, q=[0.1, -0.2], u=[0.0, 0.0], parameters={"a": 0.0, "b": float(np.cos(0.1))}
    )
    assert np.isfinite(np.array(beside)).all()

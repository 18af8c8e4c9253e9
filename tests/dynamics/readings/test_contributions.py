# SPDX-License-Identifier: BSD-3-Clause
"""Terms of the generalized forces: their sums are F_r, F*_r and M_rs; what contributes nothing is named, not listed."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import kane as kn
from kane.expr import sum_of
from kane.gallery import GALLERY, load
from tests.gallery.cases import CASES, Case, equations, random_states

SAME = 1e-12


def near(found, expected, scale) -> bool:
    return bool(np.all(np.abs(found - expected) <= SAME * (1 + scale)))


def sums(eom, chosen):
    """Sums of terms and of their sizes, by speed: two tuples of expressions."""
    terms = [[c.term for c in chosen(eom.contributions(s))] for s in eom.all_speeds]
    return [sum_of(t) for t in terms], [sum_of([kn.abs(x) for x in t]) for t in terms]


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=str)
def test_terms_sum_to_the_generalized_forces(case: Case) -> None:
    for name in case.speeds:
        eom = equations(case, name)
        states = random_states(case, 5, seed=3)
        for chosen, whole in ((lambda c: c.active, eom.Fr), (lambda c: c.inertia, eom.Fr_star)):
            total, size = sums(eom, chosen)
            found = states.evaluate(eom, [*total, *size, *whole]).reshape(3, len(whole), -1)
            assert near(found[0], found[2], found[1])


@pytest.mark.parametrize("case", CASES, ids=str)
def test_bodies_sum_to_the_mass_matrix(case: Case) -> None:
    eom = equations(case, case.speeds[0])
    states = random_states(case, 5, seed=4)
    pairs = list(product(eom.all_speeds, eom.speeds))
    terms = [[x for c in eom.mass_contributions(r, s) for x in (c.translation, c.rotation)] for r, s in pairs]
    whole = [x for row in (*eom.mass_matrix, *eom.auxiliary_mass_matrix) for x in row]
    found = states.evaluate(eom, [*map(sum_of, terms), *(sum_of([kn.abs(x) for x in t]) for t in terms), *whole])
    total, size, expected = found.reshape(3, len(pairs), -1)
    assert near(total, expected, size)


def point_of(eom: kn.Equations, rng: np.random.Generator) -> dict:
    """Any numbers: the sums are identities, so the configuration need not be one that a motion can reach."""
    euler = [e for group in eom.system.euler_parameters for e in group.coordinates]
    q = {x: rng.uniform(0.3, 1.2) for x in eom.coordinates}
    length = float(np.sqrt(sum(q[e] ** 2 for e in euler)))
    q.update({e: q[e] / length for e in euler})
    return {
        "q": q,
        "u": {s: rng.uniform(-1, 1) for s in eom.independent_speeds},
        "parameters": {p: rng.uniform(0.5, 1.5) for p in eom.parameters},
        "inputs": {s: rng.uniform(-1, 1) for s in eom.inputs},
        "t": 0.7,
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", GALLERY)
def test_every_system_of_the_gallery(name: str) -> None:
    eom = kn.derive(load(name).system())
    rng = np.random.default_rng(7)
    for chosen, whole in ((lambda c: c.active, eom.Fr), (lambda c: c.inertia, eom.Fr_star)):
        total, size = sums(eom, chosen)
        for _ in range(3):
            found = np.array(eom.evaluate([*total, *size, *whole], **point_of(eom, rng)), dtype=float)
            assert near(*found.reshape(3, -1)[[0, 2, 1]])
        for s in eom.all_speeds:
            for c in chosen(eom.contributions(s)):
                twin = np.array(eom.evaluate([c.term, c.partial.dot(c.vector)], **point_of(eom, rng)), dtype=float)
                assert twin[0] == pytest.approx(twin[1], rel=1e-12, abs=1e-14)


N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, q = kn.coordinates("x, q")
u1, u2 = kn.speeds("u1, u2")
m, g, k = kn.parameter("m"), kn.parameter("g"), kn.parameter("k")
A = N.rotate("A", q, N.z)
CART = O.at("C", x * N.x)
BOB = CART.at("B", -A.y)
PUSH = kn.Force(CART, k * N.x, "push")
WEIGHT = kn.Force(CART, -m * g * N.y, "weight of the cart")
ROPE = kn.action_reaction(BOB, CART, k * A.y, "rope")
EOM = kn.derive(
    kn.System(
        N,
        bodies=[kn.Particle("cart", CART, m), kn.Particle("bob", BOB, 2 * m)],
        speeds={u1: x.dt, u2: q.dt},
        loads=[PUSH, WEIGHT, ROPE],
    )
)


def test_terms_name_load_place_force_and_partial_velocity() -> None:
    (term,) = EOM.contributions(u1).active
    assert (term.source, term.place, term.term) == (PUSH, CART, k)
    assert (str(term.vector), str(term.partial)) == ("k N.x", "N.x")


def test_terms_that_vanish_are_named_not_listed() -> None:
    # the weight is normal to the velocity; the rope's two forces meet the same partial velocity and cancel
    assert EOM.contributions(u1).noncontributing_loads == (WEIGHT, ROPE)
    assert EOM.contributions(u2).noncontributing_loads == (PUSH, WEIGHT, ROPE)
    assert EOM.contributions(u2).active == ()
    cart, bob = EOM.system.bodies
    assert EOM.contributions(u2).noncontributing_bodies == (cart,)
    assert [c.source for c in EOM.contributions(u1).inertia] == [cart, bob]
    assert [c.body for c in EOM.mass_contributions(u1, u2)] == [bob]


def test_a_load_that_is_only_switched_off_is_listed() -> None:
    stop = kn.Force(CART, kn.max(0, -x) * N.x, "stop")
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("cart", CART, m)], speeds={u1: x.dt}, loads=[stop], coordinates=[x])
    )
    assert [c.source for c in eom.contributions(u1).active] == [stop]


def test_a_reaction_stands_in_its_own_equation() -> None:
    eom = kn.derive(load("rolling_disk").system())
    (u_n,) = eom.auxiliary_speeds
    found = eom.contributions(u_n)
    at = eom.reactions[0]
    assert not any(c.source is at for u in eom.speeds for c in eom.contributions(u).active)
    (pair,) = [c for c in found.active if c.source is at]
    assert pair.term is at
    inertial = eom.system.inertial
    assert isinstance(pair.place, kn.Point)
    assert pair.partial.components(inertial) == eom.partial_velocities[pair.place][u_n].components(inertial)


def test_an_unknown_speed_is_refused() -> None:
    with pytest.raises(kn.SpeedsError, match=r"Expected a speed of the system, one of u1, u2, got w"):
        EOM.contributions(kn.speed("w"))

# SPDX-License-Identifier: BSD-3-Clause
"""Constraints embedded: A B = 0, Kane's equations, multipliers and reactions; redundant, wrong and undetermined ones."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.dynamics import Kind
from tests.systems.four_bar import BAR, EOM, G, N, O, state


def numbers(eom, exprs, **more):
    return np.array(eom.evaluate(list(exprs), **(state(eom) | more)), dtype=float)


def matrix(eom, m, **more):
    return np.asarray(eom.evaluate(m, **(state(eom) | more)), dtype=float).reshape(m.shape)


def places(eom, speeds):
    """Where these speeds stand among all."""
    return [{s: k for k, s in enumerate(eom.speeds)}[u] for u in speeds]


def test_dependent_speeds_follow_from_independent_ones():
    d, i = (places(EOM, speeds) for speeds in (EOM.dependent_speeds, EOM.independent_speeds))
    A, A_n, b_n = matrix(EOM, EOM.A), matrix(EOM, EOM.A_n), numbers(EOM, EOM.b_n)
    u = numbers(EOM, EOM.speeds)
    np.testing.assert_allclose(A[:, d] @ A_n + A[:, i], 0, atol=1e-14)
    np.testing.assert_allclose(A_n @ u[i] + b_n, u[d], atol=1e-13)
    assert {*EOM.dependent_speeds, *EOM.independent_speeds} == set(EOM.speeds)


def test_kane_s_equations_and_the_multipliers():
    u_dot, f = numbers(EOM, EOM.accelerations), numbers(EOM, EOM.forcing)
    A, M = matrix(EOM, EOM.A), matrix(EOM, EOM.mass_matrix)
    multipliers = numbers(EOM, [EOM.multipliers[c] for c in BAR.close])
    np.testing.assert_allclose(M @ u_dot, f + A.T @ multipliers, atol=1e-12)
    np.testing.assert_allclose(A @ u_dot + numbers(EOM, EOM.constraints.drift), 0, atol=1e-12)
    np.testing.assert_allclose(numbers(EOM, EOM.Fr_nh) + numbers(EOM, EOM.Fr_star_nh), 0, atol=1e-12)
    assert len(EOM.Fr_nh) == 1


@pytest.mark.slow
def test_both_pivots_carry_the_weight_and_the_inertia():
    """Σ m a = R_pivot + R_anchor + Σ m g, the multipliers being forces on the tip."""
    pivot = [kn.reaction(f"P{k}", at=BAR.pivot, along=e) for k, e in enumerate((N.x, N.y))]
    held = [kn.reaction(f"H{k}", constraint=c) for k, c in enumerate(BAR.close)]
    eom = BAR.derive(reactions=[*pivot, *held])
    p, h = numbers(eom, pivot), numbers(eom, held)
    a = numbers(eom, [x for b in BAR.bodies for x in eom.point_accelerations[b.mass_center].components(N)]).reshape(
        -1, 3
    )
    np.testing.assert_allclose(p + h, a[:, :2].sum(axis=0) + np.array([0, 3 * G]), atol=1e-12)
    np.testing.assert_allclose(h, numbers(EOM, [EOM.multipliers[c] for c in BAR.close]), atol=1e-12)
    np.testing.assert_allclose(numbers(eom, eom.accelerations), numbers(EOM, EOM.accelerations), atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("named", [(0, 1), (1, 0), (2, 0), (2, 1), (2,), (1,), ()])
def test_dependent_speeds_stand_in_the_order_in_which_they_were_named(named):
    """A_n and b_n read so, in numbers of A; what was not named comes after, in the order of the speeds."""
    eom = BAR.derive(dependent_speeds=[EOM.speeds[k] for k in named])
    d, i = places(eom, eom.dependent_speeds), places(eom, eom.independent_speeds)
    assert tuple(d[: len(named)]) == named
    assert d[len(named) :] == sorted(d[len(named) :])
    A, b = matrix(eom, eom.A), numbers(eom, eom.b)
    np.testing.assert_allclose(matrix(eom, eom.A_n), -np.linalg.solve(A[:, d], A[:, i]), atol=1e-12)
    np.testing.assert_allclose(numbers(eom, eom.b_n), -np.linalg.solve(A[:, d], b), atol=1e-12)
    shown = [result for result in eom.steps[3].results if result[0].kind is Kind.SYMBOL]
    assert all(quantity.place is u for (quantity, _), u in zip(shown, eom.dependent_speeds, strict=True))
    found = numbers(eom, [x for _, x in shown])
    np.testing.assert_allclose(found, numbers(eom, eom.dependent_speeds), atol=1e-12)


@pytest.mark.parametrize("dependent", [(0, 1), (0, 2), (1, 2)])
def test_the_dependent_speeds_can_be_named(dependent):
    eom = BAR.derive(dependent_speeds=[EOM.speeds[k] for k in dependent])
    assert {u.name for u in eom.dependent_speeds} == {EOM.speeds[k].name for k in dependent}
    np.testing.assert_allclose(numbers(eom, eom.accelerations, **state()), numbers(EOM, EOM.accelerations), atol=1e-12)


def test_the_power_of_a_rod_that_grows():
    """dE/dt = P with what the rod's drive does, its rate and the rate of that included."""
    x, y = kn.coordinates("x y")
    p = O.at("p", x * N.x + y * N.y)
    length = 1 + 0.3 * kn.sin(kn.time)
    rod = kn.distance(p, O, length)
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("p", p, 2)], speeds="rates", loads=[kn.gravity(-G * N.y)], holonomic=rod)
    )
    found = kn.assemble(eom, q={x: 0.4, y: kn.guess(-1)}, u={eom.speeds[0]: 0.9}, t=0.5)
    derivative, power, thrust = eom.evaluate(
        [eom.time_derivative(eom.energy), eom.power, eom.multipliers[rod]], q=found.q, u=found.u, t=0.5
    )
    assert derivative == pytest.approx(power, abs=1e-12)
    radial = np.array([*found.q.values()]) / (1 + 0.3 * np.sin(0.5))
    v = np.array([*found.u.values()])
    assert v @ radial == pytest.approx(0.3 * np.cos(0.5), abs=1e-12)
    across = v @ v - (v @ radial) ** 2
    pull = 2 * (-0.3 * np.sin(0.5) - across / (1 + 0.3 * np.sin(0.5))) + 2 * G * radial[1]
    assert thrust == pytest.approx(pull, abs=1e-12)


class TestRedundant:
    """Closed twice, or a plane loop in space."""

    def test_is_named_and_changes_nothing(self):
        again = kn.distance(BAR.tip, BAR.pivot, 1.1, name="same distance")
        with pytest.warns(
            kn.KaneWarning,
            match="'same distance' depend on each other: 1 of these 2 is redundant",
        ):
            eom = BAR.derive(holonomic=[*BAR.close, again])
        assert len(eom.redundant) == 1
        np.testing.assert_allclose(
            numbers(eom, eom.accelerations, **state()), numbers(EOM, EOM.accelerations), atol=1e-10
        )

    def test_what_is_not_determined_is_not_told(self):
        space = kn.coincident(BAR.tip, BAR.anchor, along=(N.x, N.y, N.z), name="space")
        told = r"the constraint 'space z' is always satisfied.*[Ll]eave out 'space z'"
        for r in (kn.reaction("Z", constraint=space[2]), kn.reaction("Z", at=BAR.pivot, along=N.z)):
            with pytest.raises(kn.ReactionError, match=f"reactions that are uniquely determined, got Z.*{told}"):
                BAR.derive(holonomic=space, reactions=[r])
        with pytest.warns(kn.KaneWarning, match="'space z' is always satisfied: it is redundant"):
            eom = BAR.derive(holonomic=space, reactions=[kn.reaction("X", at=BAR.pivot, along=N.x)])
        (x,) = numbers(eom, eom.reactions)
        plain = BAR.derive(reactions=[kn.reaction("X", at=BAR.pivot, along=N.x)])
        assert x == pytest.approx(numbers(plain, plain.reactions)[0], abs=1e-10)


class TestRefused:
    """Messages."""

    def test_speeds_that_the_constraints_do_not_give(self):
        x = kn.coordinate("x")
        slider = kn.Particle("slider", O.at("slider", x * N.z), 1)
        system = kn.System(
            N, bodies=[*BAR.bodies, slider], speeds="rates", holonomic=BAR.close, dependent_speeds=[kn.speed("u_x")]
        )
        with pytest.raises(
            kn.ModelError,
            match=r"dependent_speeds= that the constraints determine, got u_x, which.*name others: u2, u3 will do",
        ):
            kn.derive(system)

    def test_bare_constraints_with_reactions_at_cuts(self):
        bare = [kn.configuration_constraint(f"bare {k}", c.expr) for k, c in enumerate(BAR.close)]
        with pytest.raises(
            kn.ReactionError,
            match="points of application of their forces, which the reactions R contain, got the plain expressions bare 0, bare 1",
        ):
            BAR.derive(holonomic=bare, reactions=[kn.reaction("R", at=BAR.pivot, along=N.x)])
        eom = BAR.derive(holonomic=bare)
        np.testing.assert_allclose(
            numbers(eom, eom.accelerations, **state()), numbers(EOM, EOM.accelerations), atol=1e-11
        )

    def test_no_freedom_left(self):
        """Four constraints of three coordinates that no configuration satisfies: no speed is left, and nothing false is said."""
        stay = kn.distance(BAR.tip, O.at("above", 0.3 * N.x + 2 * N.y), 1.7, name="stay")
        far = kn.distance(BAR.bodies[1].mass_center, O.at("left", -1 * N.x), 1.0, name="far")
        told = r"some configuration satisfies, got none from 1872 starts: .*'stay' depend on each other at a random configuration"
        with pytest.warns(kn.KaneWarning, match=told):
            eom = BAR.derive(holonomic=[*BAR.close, stay, far])
        assert eom.independent_speeds == ()
        assert len(eom.redundant) == 1

# SPDX-License-Identifier: BSD-3-Clause
"""Random mechanisms with closed loops, rods, rolling and knife edges: three routes and the laws.

The same accelerations and reactions come from the embedded form, from the multiplier form solved in numbers, and from Newton's
and Euler's equations in redundant coordinates, at a random configuration with random velocities.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import choose
from kane.equations import repartition
from kane.numeric import balanced
from tests.examples import examples
from tests.oracles.compare import error, tolerance
from tests.oracles.loops.equations import Solution, solve
from tests.oracles.mechanism import Loops, Mechanism, admissible_rates, to_oracle
from tests.oracles.mechanism_draw import mechanisms, questions
from tests.oracles.mechanism_kane import SPEEDS, Asked, Model, to_kane
from tests.oracles.tree import Array

KINDS = [
    pytest.param(p, n, id=f"{'planar' if p else 'spatial'}, {n}", marks=[] if p or n < 3 else pytest.mark.slow)
    for p in (True, False)
    for n in (1, 2, 3)
]
SEEDS = st.integers(0, 2**16)


class State:
    """A mechanism at random admissible velocities, as the oracle and as kane have it."""

    def __init__(self, m: Mechanism, asked: Asked, seed: int) -> None:
        self.loops: Loops = to_oracle(m)
        self.rates = admissible_rates(np.random.default_rng(seed), self.loops)
        self.model: Model = to_kane(m, asked)
        self.eom = kn.derive(self.model.system)
        self.q, self.u = self.model.q(), self.model.u(self.eom, self.rates)
        a = self.matrix(self.eom.A)
        e = self.eom.embedding
        assert e is not None
        if np.linalg.cond(balanced(a)[np.ix_(e.partition.rows, e.partition.dependent)]) > 50:
            self.eom = repartition(self.eom, choose(a))  # as a simulation does

    def values(self, exprs: Any) -> Array:
        """Numbers of a list of expressions."""
        return np.array(self.eom.evaluate(list(exprs), q=self.q, u=self.u), dtype=float)

    def matrix(self, m: kn.Matrix) -> Array:
        """Numbers of a matrix."""
        return np.asarray(self.eom.evaluate(m, q=self.q, u=self.u), dtype=float).reshape(m.shape)

    def vectors(self, vectors: Any) -> Array:
        """Components of vectors along the inertial axes, a row each."""
        N = self.model.system.inertial
        return self.values([x for v in vectors for x in v.components(N)]).reshape(-1, 3)

    @property
    def expected(self) -> Solution:
        """What the oracle says."""
        m, o = self.model.mechanism, self.loops
        found = solve(
            o.bodies, o.joints, o.poses, o.twists(self.rates),
            np.array([p.force for p in m.parts]), np.array([p.torque for p in m.parts]), m.gravity,
        )  # fmt: skip
        assert found.drift < 1e-11
        assert found.inconsistency < 1e-8
        return found


def multiplier_form(state: State) -> tuple[Array, Array, float]:
    """u̇ and λ of [M −Aᵀ; A 0] [u̇; λ] = [f; −(Ȧ u + ḃ)], and the larger condition number of that matrix and of Bᵀ M B."""
    eom, e = state.eom, state.eom.embedding
    assert e is not None
    M, A, A_n = (state.matrix(x) for x in (eom.mass_matrix, eom.A, eom.A_n))
    right = state.values([*eom.forcing, *eom.constraints.drift])
    n, m = len(M), len(A)
    right[n:] *= -1.0
    whole = np.block([[M, -A.T], [A, np.zeros((m, m))]])
    found = np.linalg.solve(whole, right)

    B = np.zeros((n, n - m))
    B[list(e.independent)] = np.eye(n - m)
    place = {u: k for k, u in enumerate(eom.speeds)}
    B[[place[u] for u in eom.dependent_speeds]] = A_n
    assert error(A @ B, np.zeros((m, n - m))) < 1e-10
    condition = max(np.linalg.cond(x) for x in (whole, B.T @ M @ B))
    return found[:n], found[n:], float(condition)


def check_routes(state: State) -> float:
    """The three routes to the accelerations and to the forces of the closures; returns the tolerance."""
    eom, model, expected = state.eom, state.model, state.expected
    u_dot, multipliers, condition = multiplier_form(state)
    limit = tolerance(1e-8, condition)
    assert error(state.values(eom.accelerations), u_dot) <= limit
    assert error(state.values(eom.multipliers[c] for c in eom.system.constraints), multipliers) <= limit
    assert error(state.vectors(eom.point_accelerations[C] for C in model.centers), expected.a) <= limit
    assert error(state.vectors(eom.angular_accelerations[B] for B in model.frames), expected.alpha) <= limit
    twists = np.array([[t.v, t.w] for t in state.loops.twists(state.rates)])
    assert error(state.vectors(eom.velocities[C] for C in model.centers), twists[:, 0]) <= 1e-12
    assert error(state.vectors(eom.angular_velocities[B] for B in model.frames), twists[:, 1]) <= 1e-12

    closing = expected.reactions[len(expected.reactions) - len(model.closures) :]
    for group, told in zip(model.closures, closing, strict=True):
        # the forces on the far body come first in each constraint
        force = sum((c.forces[0][1] * eom.multipliers[c] for c in group if c.forces), kn.Vector())
        torque = sum((c.torques[0][1] * eom.multipliers[c] for c in group if not c.forces), kn.Vector())
        assert error(state.vectors([force, torque]), [told.force, told.torque]) <= limit, group
    return limit


def check_reactions(state: State, limit: float) -> None:
    """Reactions at joints of the tree, and multipliers by name."""
    eom, model, expected = state.eom, state.model, state.expected
    found = dict(zip(eom.reactions, state.values(eom.reactions), strict=True))
    for cut in model.cuts:
        part = model.mechanism.parts[cut.part]
        start, frame = model.starts[cut.part]
        place, axis = state.vectors([start.position(start.root()), (frame.x, frame.y, frame.z)[cut.axis]])
        wrench = np.zeros(3)
        if part.joint != "free":
            told = expected.reactions[state.loops.carried.index(cut.part)]
            wrench = told.torque + np.cross(told.point - place, told.force) if cut.torque else told.force
        assert error(found[cut.reaction], wrench @ axis) <= limit, cut.reaction
    for k, c in enumerate(eom.system.constraints):
        for r in eom.reactions:
            if r.place is c:
                assert error(found[r], state.values([eom.multipliers[c]])[0]) <= limit, (k, c)


def check_laws(state: State, limit: float) -> None:
    """Power, the constraints and their derivatives, Kane's dynamical equations."""
    eom = state.eom
    held = [kn.Matrix([row]) @ kn.Matrix([[u] for u in eom.speeds]) for row in eom.A.rows]
    rows = [x[0, 0] + b for x, b in zip(held, eom.b, strict=True)]
    assert np.abs(state.values(rows)).max() <= 1e-11
    rates = [eom.time_derivative(row) for row in rows]
    scale = max(1.0, np.abs(state.values(eom.constraints.drift)).max())
    assert np.abs(state.values(rates)).max() <= limit * scale

    derivative, power = state.values([eom.time_derivative(eom.energy), eom.power])
    u, u_dot = (np.abs(state.values(x)) for x in (eom.speeds, eom.accelerations))
    scale = max(1.0, float(u @ np.abs(state.matrix(eom.mass_matrix)) @ u_dot))
    assert abs(derivative - power) <= limit * scale

    active, inertia = state.values(eom.Fr_nh), state.values(eom.Fr_star_nh)
    assert error(inertia, -active) <= limit


@pytest.mark.slow
@pytest.mark.parametrize(("planar", "loops"), KINDS)
def test_three_routes_and_laws(planar: bool, loops: int) -> None:
    @examples(0.02, 2)
    @given(st.data(), mechanisms(planar, loops), SEEDS)
    def check(data: st.DataObject, m: Mechanism, seed: int) -> None:
        state = State(m, data.draw(questions(len(m.parts))), seed)
        limit = check_routes(state)
        check_reactions(state, limit)
        check_laws(state, limit)

    check()


@pytest.mark.slow
@pytest.mark.parametrize(("planar", "loops"), KINDS)
def test_the_choice_of_speeds_and_of_dependent_speeds_does_not_matter(planar: bool, loops: int) -> None:
    @examples(0.01)
    @given(mechanisms(planar, loops, max_parts=3), SEEDS)
    def check(m: Mechanism, seed: int) -> None:
        expected, rng = None, np.random.default_rng(seed)
        for speeds in SPEEDS:
            state = State(m, Asked(speeds, seed=seed), seed)
            limit = tolerance(1e-8, multiplier_form(state)[-1])
            for eom in (state.eom, with_other_dependent_speeds(rng, state)):
                state.eom = eom
                found = state.vectors(eom.point_accelerations[C] for C in state.model.centers)
                expected = found if expected is None else expected
                assert error(found, expected) <= limit, (speeds, eom.dependent_speeds)

    check()


def with_other_dependent_speeds(rng: np.random.Generator, state: State) -> kn.Equations:
    """The same system with dependent speeds named that the constraints determine well."""
    a, eom = balanced(state.matrix(state.eom.A)), state.eom
    for _ in range(50):
        chosen = rng.choice(a.shape[1], len(a), replace=False)
        if np.linalg.cond(a[:, chosen]) < 50:
            named = [eom.speeds[i] for i in chosen]
            found = kn.derive(eom.system.replace(dependent_speeds=named))
            assert set(found.dependent_speeds) == set(named)
            return found
    return eom


@pytest.mark.slow
@pytest.mark.parametrize(("planar", "loops"), KINDS)
def test_a_second_of_motion_stays_on_the_constraints(planar: bool, loops: int) -> None:
    @examples(0.01)
    @given(mechanisms(planar, loops, max_parts=3), st.sampled_from(SPEEDS), SEEDS)
    def check(m: Mechanism, speeds: str, seed: int) -> None:
        state = State(m, Asked(speeds, seed=seed), seed)
        sol = kn.simulate(state.eom, (0, 1), q=state.q, u=state.u, samples=21)
        assert sol.status == "finished", sol.message
        worst = {c.name: np.abs(r).max() for c, r in sol.constraint_residuals.items()}
        assert max(worst.values()) <= 1e-9, worst
        assert sol.energy_check.relative <= 1e-6, sol.energy_check

    check()


def with_redundant_rows(m: Mechanism) -> tuple[Mechanism, set[str]]:
    """The first loop closed twice, or, of a planar mechanism, in space; with the names of the closures that say too much."""
    for k, c in enumerate(m.closures):
        if c.kind == "on line" and abs(c.marks[0].axes[2, 2] - 1.0) < 1e-15:
            spatial = (*m.closures[:k], replace(c, kind="pin"), *m.closures[k + 1 :])
            return replace(m, closures=spatial), {f"pin {k}"}
    c = m.closures[0]
    return replace(m, closures=(*m.closures, c)), {f"{c.kind} 0", f"{c.kind} {len(m.closures)}"}


@pytest.mark.slow
@pytest.mark.parametrize("planar", [True, False])
def test_redundant_closures_are_named_and_do_no_harm(planar: bool) -> None:
    @examples(0.1, 2)
    @given(st.integers(1, 2).flatmap(lambda n: mechanisms(planar, n, max_parts=3)), SEEDS)
    def check(m: Mechanism, seed: int) -> None:
        m, doubtful = with_redundant_rows(m)
        with pytest.warns(kn.KaneWarning, match="redundant") as told:
            state = State(m, Asked(), seed)
        (warning,) = told
        constraints = state.eom.system.constraints
        named = {c for c in constraints if f"'{c.name}'" in str(warning.message)}
        assert named
        assert all(any(c.name.startswith(name) for name in doubtful) for c in named)
        assert set(state.eom.redundant) <= named

        expected = state.expected
        assert error(state.vectors(state.eom.point_accelerations[C] for C in state.model.centers), expected.a) <= 1e-8
        closing = expected.reactions[len(expected.reactions) - len(m.closures) :]
        for group, reaction in zip(state.model.closures, closing, strict=True):
            wrench = np.append(reaction.force, reaction.torque)
            limit = 1e-8 * max(1.0, float(np.abs(wrench).max()))
            for c in group:
                v = state.vectors([c.forces[0][1] if c.forces else c.torques[0][1]])[0]
                way = np.append(v, np.zeros(3)) if c.forces else np.append(np.zeros(3), v)
                way /= np.linalg.norm(way)
                determinate = np.abs(way @ reaction.doubt).max(initial=0.0) < 1e-7
                assert determinate == (c not in named), c.name
                if determinate:
                    found = state.values([state.eom.multipliers[c]])[0] * np.linalg.norm(v)
                    assert abs(found - wrench @ way) <= limit, c.name
        for c in named:
            with pytest.raises(kn.ReactionError, match=r"reactions that are uniquely determined, got R \("):
                kn.derive(state.eom.system.replace(reactions=[kn.reaction("R", constraint=c)]))

    check()

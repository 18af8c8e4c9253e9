# SPDX-License-Identifier: BSD-3-Clause
"""Accelerations at ordinary states, whatever the equations were divided by on the way, against Newton and Euler.

What `evaluate`, machine code, C and the NumPy module give is held to the accelerations of all bodies in redundant coordinates, solved
in plain NumPy: at random states, and at headings at which a fixed order of elimination or a pole of W would divide by zero.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson, solve_ivp

import kane as kn
from kane import jacobian
from kane.expr import rate
from kane.program import emit_c
from tests.oracles.loops.equations import Solution, solve
from tests.oracles.loops.records import Pose, Twist
from tests.program.emitted import call, from_numpy, library
from tests.systems.regular import CASES, Redundant, bicycle

Array = Any
EPS = np.finfo(float).eps
REGULAR = 1e8
"""Condition of A_D up to which a state is one: on some branches of parallelograms a choice of dependent speeds follows nowhere."""
SLOW = 0.1
"""Share of the random speeds at which motions start."""
POORLY = ("u1", "u2", "u3", "u6", "u8")
"""Lean, pitch and yaw rates of a bicycle among its dependent speeds."""
STRAIGHT = (0.2, 0, 0, 0, -10, -3 / 0.35, 3, 0)
"""A bicycle's speeds at 3 m/s straight on, upright, as it begins to lean."""
C99 = ("-std=c99", "-O1", "-ffp-contract=off")


def wide(value, count: int, *shape: int) -> Array:
    return np.broadcast_to(np.asarray(value, dtype=float), (count, *shape))


def matrices(matrix: kn.Matrix, values: dict, count: int) -> Array:
    """A matrix in numbers at each of several states (count × m × n)."""
    entries = [wide(x, count) for x in kn.evaluate(list(matrix.entries), values)]
    return np.stack(entries, axis=-1).reshape(count, *matrix.shape) if entries else np.zeros((count, *matrix.shape))


class States:
    """States of a system on its constraints (count × n): q, and u of rates that the constraints admit."""

    def __init__(self, case: Redundant, count: int, rng: np.random.Generator) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kn.KaneWarning)  # which constraints are redundant is known
            self.eom = kn.derive(case.system)
        self.case, self.count = case, count
        self.parameters = {p: p.default for p in self.eom.parameters}
        q = rng.uniform(-case.reach, case.reach, (8 * count, len(self.eom.coordinates)))
        for k, given in enumerate([*case.special] * (1 + count // 30)):
            q[k, list(given)] = list(given.values())
        q = self._closed(q)
        rates, regular = self._admitted(q, rng)
        self.q, self.rates = q[regular], rates[regular]
        regular = np.flatnonzero(self.condition() < REGULAR)[:count]
        self.q, self.rates = self.q[regular], self.rates[regular]
        assert len(self.q) == count
        self.u = self._numbers(list(case.system.speeds.values()))
        self.inputs = [0.0] * len(self.eom.inputs)

    def _values(self, q: Array) -> dict:
        return {**dict(zip(self.eom.coordinates, q.T, strict=True)), **self.parameters}

    def _closed(self, q: Array) -> Array:
        """Newton's steps of least size, of all at once; those that close."""
        system = self.case.closing or self.case.system
        f = kn.Matrix.column([c.expr for c in system.holonomic])
        if not f.entries:
            return q
        places = list(range(q.shape[1]) if self.case.moving is None else self.case.moving)
        gradient = jacobian(f.entries, [system.coordinates[k] for k in places])
        for _ in range(40):
            left = matrices(f, self._values(q), len(q))
            if np.abs(left).max() < 1e-14:
                break
            step = (np.linalg.pinv(matrices(gradient, self._values(q), len(q)), rcond=1e-10) @ left)[:, :, 0]
            q[:, places] -= step / np.maximum(1, np.abs(step).max(axis=1, keepdims=True))
        return q[np.abs(left[:, :, 0]).max(axis=1) < 1e-12]

    def _admitted(self, q: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """Random rates that the constraints admit, and at which states the constraints have the rank of the motion."""
        held, qs = self.case.system, self.eom.coordinates
        by_q = jacobian([c.expr for c in held.holonomic], qs)
        by_rate = jacobian([c.expr for c in held.nonholonomic], [rate(x) for x in qs])
        a = np.concatenate([matrices(m, self._values(q), len(q)) for m in (by_q, by_rate) if m.entries], axis=1)
        rates = rng.normal(size=q.shape)
        rates -= (np.linalg.pinv(a, rcond=1e-9) @ a @ rates[:, :, None])[:, :, 0]
        sizes, rank = np.linalg.svd(a, compute_uv=False), len(self.eom.dependent_speeds)
        beyond = sizes[:, rank:].max(axis=1, initial=0)
        return rates, (sizes[:, rank - 1] > 1e-3 * sizes[:, 0]) & (beyond < 1e-9 * sizes[:, 0])

    def condition(self) -> Array:
        """That of A_D; 1 where W has poles and A in the declared speeds says nothing."""
        assert self.eom.embedding is not None
        p = self.eom.embedding.partition
        if self.eom.solved.route not in ("classical", "embedded", "power", "squares"):
            return np.ones(len(self.q))
        a = matrices(self.eom.A.take(p.rows, p.dependent), self._values(self.q), len(self.q))
        return np.linalg.cond(a)

    def by_independent(self) -> Array:
        """A_n."""
        return matrices(self.eom.A_n, self._values(self.q), len(self.q))

    def expected(self) -> Array:
        """u̇ by the oracle (count × n): its accelerations of all bodies, J q̈ + J̇ q̇, then those of the definitions of the speeds."""
        return self.by_bodies(self.solutions())

    def solutions(self) -> list[Solution]:
        """What the oracle says at each state."""
        case, bodies, N = self.case, self.case.system.rigid_bodies, self.case.system.inertial
        root = bodies[0].mass_center.root()
        places = [
            x.components(N)
            for b, f in zip(bodies, case.axes, strict=True)
            for x in (b.mass_center.position(root), f.x, f.y, f.z)
        ]
        at = self._numbers([x for three in places for x in three]).reshape(len(self.q), len(bodies), 4, 3)
        motion = self._numbers(self._velocities()).reshape(len(self.q), len(bodies), 2, 3)
        found = []
        for where, how in zip(at, motion, strict=True):
            poses = [Pose(x[0], x[1:].T) for x in where]
            forces, torques = case.pushed(poses) if case.pushed else (None, None)
            one = solve(case.bodies, case.joints, poses, [Twist(*x) for x in how], forces, torques, case.gravity)
            assert max(one.drift, one.inconsistency) < 1e-9
            found.append(one)
        return found

    def _velocities(self) -> list[kn.Expr]:
        """Those of the mass centres, and the angular ones, of all bodies."""
        bodies, N = self.case.system.rigid_bodies, self.case.system.inertial
        moving = [v for b in bodies for v in (b.mass_center.velocity(N), b.frame.angular_velocity(N))]
        return [x for v in moving for x in v.components(N)]

    def by_bodies(self, solutions: Sequence[Solution]) -> Array:
        """u̇ (count × n) from the accelerations of all bodies."""
        found = [np.stack([one.a, one.alpha], axis=1).reshape(-1) for one in solutions]
        j, bias = self._derivatives(self._velocities())
        q_ddot = np.linalg.pinv(j) @ (np.array(found) - bias)[:, :, None]
        y, rest = self._derivatives(list(self.case.system.speeds.values()))
        return np.asarray((y @ q_ddot)[:, :, 0] + rest)

    def _derivatives(self, exprs: list[kn.Expr]) -> tuple[Array, Array]:
        """∂/∂q̇, and what of the time derivative is left without q̈."""
        rates = [rate(x) for x in self.eom.coordinates]
        still = dict.fromkeys(map(rate, rates), 0.0)
        by_rate = self._numbers(jacobian(exprs, rates).entries).reshape(len(self.q), len(exprs), len(rates))
        return by_rate, self._numbers([kn.time_derivative(x) for x in exprs], still)

    def _numbers(self, exprs: Sequence[kn.Expr], more: Mapping[kn.Expr, float] | None = None) -> Array:
        """Numbers of what is written in coordinates and rates (count × exprs)."""
        rates = dict(zip(map(rate, self.eom.coordinates), self.rates.T, strict=True))
        told = kn.evaluate(list(exprs), {**self._values(self.q), **rates, **(more or {})})
        return np.stack([wide(x, len(self.q)) for x in told], axis=-1)

    def by_evaluate(self) -> Array:
        """u̇ by `evaluate`."""
        exprs = list(self.eom.accelerations)
        told = self.eom.evaluate(exprs, q=list(self.q.T), u=list(self.u.T), inputs=self.inputs)
        return np.stack([wide(x, len(self.q)) for x in told], axis=-1)

    def by_code(self, compiled: kn.Compiled, folder: Path | None) -> dict[str, Array]:
        """u̇ by machine code; with a folder by emitted C and NumPy too."""
        x = np.hstack([self.q, self.u])
        inputs = np.array(self.inputs) if self.inputs else None
        made = compiled.program
        found = {"rhs": compiled.rhs(0.0, x, None, inputs)}
        if folder is not None:
            given = {"t": 0.0, "x": x, "p": list(self.parameters.values()), "r": self.inputs}
            found["numpy"] = from_numpy(made, folder).rhs(*(given[port.name] for port in made.ports))
            built = library(emit_c(made), folder / "emitted.c", *C99)
            rows = [np.array([0.0, *row, *self.parameters.values(), *self.inputs]) for row in x]
            found["c"] = np.array([call(built, made, "rhs", row) for row in rows])
        return {name: y[:, self.q.shape[1] :] for name, y in found.items()}


def check(case: Redundant, count: int, folder: Path | None, rng: np.random.Generator, poor: bool = False) -> None:
    """To 100 ε cond A_D; where speeds are `poor` also times |A_n|, which the mass matrix of the independent speeds holds twice."""
    states = States(case, count, rng)
    reach = np.maximum(1, np.abs(states.by_independent()).max(axis=(1, 2))) if poor else 1.0
    limit = np.maximum(1e-10, 100 * EPS * states.condition() * reach)
    expected = states.expected()
    found = {"evaluate": states.by_evaluate(), **states.by_code(kn.compile(states.eom), folder)}
    size = np.maximum(1, np.abs(expected).max(axis=1))
    for name, u_dot in found.items():
        error = np.abs(u_dot - expected).max(axis=1) / size
        assert (error <= limit).all(), name


QUICK = ("wheel", "sled", "bicycle NN rates", "bicycle YH speeds", "Bricard 3 whole", "windows +-+ 0234")


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_accelerations_at_a_few_states(name, rng, tmp_path):
    check(CASES[name](), 8, tmp_path if name in ("sled", "wheel") else None, rng)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_accelerations_at_200_states(name, rng, tmp_path):
    check(CASES[name](), 200, tmp_path, rng)


@pytest.mark.slow
def test_dependent_speeds_that_follow_poorly_cost_digits(rng):
    """Lean, pitch and yaw rates of a bicycle by the others: upright they do not follow at all."""
    check(bicycle("YY", "speeds", POORLY), 200, None, rng, poor=True)


@pytest.mark.slow
def test_where_dependent_speeds_do_not_follow_others_are_named_that_do():
    at = {"q": [0, 0, 0.3, 0, 0, 0, 0.2, 0.1], "inputs": [0, 0]}
    with pytest.raises(kn.SingularError, match="of u2, u3, u5, u6, u8;"):
        upright(POORLY, **at)
    named = upright(("u2", "u3", "u5", "u6", "u8"), **at)
    np.testing.assert_allclose(named, upright((), **at), rtol=1e-10, atol=1e-10)


def upright(dependent: Sequence[str], **at: Any) -> Array:
    """The accelerations of a bicycle that runs straight on."""
    eom = kn.derive(bicycle("YY", "speeds", dependent).system)
    return np.array(eom.evaluate(list(eom.accelerations), u=dict(zip(eom.speeds, STRAIGHT, strict=True)), **at))


@pytest.mark.parametrize("axes", ["NN", "YY", "YH"])
def test_a_wheel_that_lies_flat_is_no_pole_of_the_speeds_alone(axes):
    """Where the rear frame lies flat on the road cos(phi), by which W divides, is zero; there the front wheel has no lowest point."""
    eom = kn.derive(bicycle(axes, "speeds", POORLY).system)
    assert eom.solved.twin is None


def moved(case: Redundant, rng: np.random.Generator) -> None:
    """One second of SciPy's solver on `rhs` from the state nearest to rest at the lowest place: loops stay closed, energy is kept."""
    states = States(case, 20, rng)
    eom, n = states.eom, states.q.shape[1]
    compiled = kn.compile(eom, not_finite="ignore")
    q, u = states.q, SLOW * states.u
    potential = wide(eom.evaluate(eom.potential_energy, q=list(q.T), u=list(u.T)), len(q))
    k = int(np.argmin(potential)) if states.case.gravity is not None and not case.special else 0
    inputs = np.array(states.inputs) if states.inputs else None
    motion = solve_ivp(
        lambda t, x: compiled.rhs(t, x, None, inputs), (0, 1), np.concatenate([q[k], u[k]]), "DOP853",
        np.linspace(0, 1, 101), rtol=1e-10, atol=1e-10,
    )  # fmt: skip
    assert motion.success
    q, u = motion.y[:n], motion.y[n:]
    f = [c.expr for c in (case.closing or case.system).holonomic]
    left = [wide(x, 101) for x in kn.evaluate(f, states._values(q.T))]
    assert np.abs(left).max(initial=0) < 1e-6
    own = {s: u[k] for k, s in enumerate(eom.speeds) if s in eom.independent_speeds}
    told = eom.evaluate([eom.energy, eom.power, eom.kinetic_energy], q=list(q), u=own, inputs=states.inputs)
    energy, power, kinetic = (wide(x, 101) for x in told)
    assert abs(energy[-1] - energy[0] - simpson(power, motion.t)) < 1e-7 * kinetic.max()


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n == "sled" else pytest.mark.slow) for n in CASES])
def test_a_second_of_motion(name, rng):
    moved(CASES[name](), rng)

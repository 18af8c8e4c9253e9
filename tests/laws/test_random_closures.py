# SPDX-License-Identifier: BSD-3-Clause
"""Random loops closed by every `kn.close_*`: no refusal where A_D is regular, and one answer by every way to numbers.

The configuration comes from the oracle, which knows one that closes; `derive` is not told. Geometry is in numbers or in parameters,
axes point either way, orientations are oblique, dependent speeds are named at random or left out. Newton's and Euler's equations in
redundant coordinates say what `evaluate`, machine code, C and the NumPy module must give.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, assume, given
from hypothesis import strategies as st

import kane as kn
from kane import time
from kane.numeric import balanced
from tests.examples import examples
from tests.oracles.compare import error, tolerance
from tests.oracles.loops.equations import Solution, solve
from tests.oracles.mechanism import Closure, Loops, Mechanism, admissible_rates, to_oracle
from tests.oracles.mechanism_draw import mechanisms
from tests.oracles.mechanism_kane import SPEEDS, Asked, Model, Place, to_kane
from tests.oracles.tree import Array
from tests.program.emitted import from_c, from_numpy

CLOSED: dict[bool, tuple[str, ...]] = {
    True: ("pin", "ball", "planar", "on line", "distance"),
    False: ("pin", "slider", "cylindrical", "screw", "universal", "ball", "planar", "weld"),
}
REGULAR = 1e5
"""Condition of A_D, balanced, up to which nothing may be refused."""


class Random:
    """A mechanism in the words of `kn.close_*`, at random admissible velocities."""

    def __init__(self, m: Mechanism, seed: int, speeds: str, in_parameters: bool, named: bool) -> None:
        rng = np.random.default_rng(seed)
        self.loops: Loops = to_oracle(m)
        self.rates = admissible_rates(rng, self.loops)

        def declare(name: str, c: Closure, near: Place, far: Place) -> Sequence[kn.Constraint] | None:
            make = getattr(kn, f"close_{c.kind}", None)
            if make is None:
                return None
            sign = 1 if rng.random() < 0.5 else -1
            axis: dict[str, Any] = {"axis": sign * near.frame.z}
            if c.kind in ("ball", "weld"):
                axis = {}
            elif c.kind == "planar":
                axis = {"normal": sign * near.frame.z}
            elif c.kind == "universal":
                axis = {"axes": (near.frame.z, sign * near.frame.x)}
            elif c.kind == "screw":
                axis["pitch"] = c.size
            constraints: Sequence[kn.Constraint] = make(name, near.point, near.frame, far.point, far.frame, **axis)
            return constraints

        self.model: Model = to_kane(m, Asked(speeds, seed=seed, symbolic=in_parameters), declare)
        self.system = self.model.system
        if named:
            self.system = self.system.replace(dependent_speeds=self._choice(rng))

    def _choice(self, rng: np.random.Generator) -> list[kn.Speed]:
        """Speeds that the constraints give well at the oracle's configuration."""
        eom = kn.derive(self.system)
        a = balanced(np.asarray(eom.evaluate(eom.A, q=self.model.q(), u=self.u(eom)), dtype=float))
        rank = len(eom.dependent_speeds)
        for _ in range(50):
            chosen = rng.choice(a.shape[1], rank, replace=False)
            if np.linalg.matrix_rank(a[:, chosen]) == rank and np.linalg.cond(a[:, chosen]) < 100:
                return [eom.speeds[k] for k in chosen]
        assume(False)
        raise AssertionError

    def u(self, eom: kn.Equations) -> dict[Any, float]:
        """The speeds."""
        return self.model.u(eom, self.rates)

    def expected(self) -> Solution:
        """What the oracle says."""
        m, o = self.model.mechanism, self.loops
        return solve(
            o.bodies, o.joints, o.poses, o.twists(self.rates),
            np.array([p.force for p in m.parts]), np.array([p.torque for p in m.parts]), m.gravity,
        )  # fmt: skip


def accelerations(r: Random, eom: kn.Equations, u_dot: Array) -> Array:
    """Accelerations of mass centres and frames at these u̇."""
    N = r.model.system.inertial
    vectors = [eom.point_accelerations[C] for C in r.model.centers] + [
        eom.angular_accelerations[B] for B in r.model.frames
    ]
    exprs = [x for v in vectors for x in v.components(N)]
    values = {s.dt: float(x) for s, x in zip(eom.speeds, u_dot, strict=True)}
    at = {**r.model.q(), **r.u(eom), **values, **{p: p.default for p in eom.parameters}, time: 0.0}
    return np.array(kn.evaluate(exprs, at), dtype=float).reshape(-1, 3)


def check(r: Random, folder: Path, emit: bool, move: bool) -> None:
    eom = kn.derive(r.system)
    q, u = r.model.q(), r.u(eom)
    a = balanced(np.asarray(eom.evaluate(eom.A, q=q, u=u), dtype=float))
    place = {s: k for k, s in enumerate(eom.speeds)}
    block = a[:, [place[s] for s in eom.dependent_speeds]]
    values = np.linalg.svd(block, compute_uv=False)
    condition = float(values[0] / values[-1]) if len(values) and values[-1] else np.inf
    x = np.array([{**q, **u}[s] for s in (*eom.coordinates, *eom.speeds)])
    compiled = eom.compile(not_finite="ignore")
    rates = compiled.rhs(0.0, x)
    if condition > REGULAR:  # the dependent speeds are not given here: no finite number that is wrong
        if np.isfinite(rates).all():
            compare(r, eom, rates[len(q) :], condition)
        return
    reach = np.abs(np.asarray(eom.evaluate(eom.A_n, q=q, u=u), dtype=float)).max(initial=1)
    condition *= reach**2  # the mass matrix of the independent speeds holds A_n twice
    want = compare(r, eom, np.array(eom.evaluate(list(eom.accelerations), q=q, u=u), dtype=float), condition)
    compare(r, eom, rates[len(q) :], condition)
    if emit:
        row = np.concatenate([[0.0], x, [p.default for p in eom.parameters]])
        told = from_c(compiled.program, folder, True)("rhs", row[None])[0]
        compare(r, eom, told[len(q) :], condition)
        module = from_numpy(compiled.program, folder)
        compare(r, eom, np.asarray(module.rhs(0.0, x))[len(q) :], condition)
    if move:
        sol = kn.simulate(eom, (0, 0.2), q=q, u=u, rtol=1e-9, atol=1e-9, samples=3)
        assert sol.status == "finished", sol.message
        assert sol.energy_check.relative < 1e-6
        residuals = [c.expr for c in eom.system.holonomic]
        assert np.abs([sol[e] for e in residuals]).max(initial=0) < 1e-9
    assert want


def compare(r: Random, eom: kn.Equations, u_dot: Array, condition: float) -> bool:
    """The oracle's accelerations, to max(1e-10, 100 ε cond)."""
    expected = r.expected()
    rows = r.loops.rank[2]
    limit = tolerance(1e-9, condition * rows)
    assert error(accelerations(r, eom, u_dot), np.concatenate([expected.a, expected.alpha])) <= limit
    return True


KINDS = [
    pytest.param(p, n, id=f"{'planar' if p else 'spatial'}, {n}", marks=[] if p and n == 1 else pytest.mark.slow)
    for p in (True, False)
    for n in (1, 2)
]


@pytest.mark.slow
@pytest.mark.timeout(1800)  # minutes where the machine does other things, too
@pytest.mark.parametrize(("planar", "loops"), KINDS)
def test_loops_by_every_closure(planar: bool, loops: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    @examples(0.02, 3, phases=[Phase.explicit, Phase.reuse, Phase.generate])  # numbers from a seed do not shrink
    @given(
        mechanisms(planar, loops, max_parts=4, kinds=CLOSED[planar]),
        st.integers(0, 2**16), st.sampled_from(SPEEDS), st.booleans(), st.booleans(),
    )  # fmt: skip
    def run(m: Mechanism, seed: int, speeds: str, in_parameters: bool, named: bool) -> None:
        r = Random(m, seed, speeds, in_parameters, named)
        check(r, tmp_path_factory.mktemp("closures"), emit=seed % 32 == 0, move=seed % 16 == 0)

    run()

# SPDX-License-Identifier: BSD-3-Clause
"""Single shooting: Newton's method for r(x) = P(x) − x = 0.

P is the map to the section or over a period (Parker & Chua 1989, ch. 5). With a basis T of the changes of the start that constraints
admit, and D = ∂P/∂x by the variational equations and saltation matrices,

    (I − T⁺ D T) ξ = T⁺ r,      x ← x + T ξ

On a section D f = 0 for the rates f at the start: the trivial multiplier is 0 instead of 1, and I − D is regular.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from kane.analysis.assembly import assemble
from kane.analysis.state_checks import start_state
from kane.equations.state import guess
from kane.errors import SimulationError
from kane.expr.node import Expr
from kane.expr.symbols import Parameter
from kane.motion.derivatives.return_map import ReturnMap
from kane.motion.derivatives.tangent_space import basis_of, flow_of, sizes_of
from kane.motion.derivatives.variation import Differential
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array, Complex
from kane.numeric.scale import ROUNDED_CHAIN, SAME_TIME, SIX_DIGITS, STATE_RANK
from kane.progress import far

_HALVINGS = 8
_SAMPLES = 501


@dataclass(frozen=True, slots=True, eq=False)
class FirstReturn:
    """A motion from x, `left` r = P(x) − x, the sizes `scale` of x along it, and `way`, its initial rates times T/2π."""

    x: Array
    motion: Solution
    left: Array
    scale: Array
    way: Array

    @property
    def moves(self) -> bool:
        """Whether the motion leaves its start: a section that is reached at once does not end a cycle."""
        return bool(np.abs(self.way / self.scale).max(initial=0.0) > SIX_DIGITS)

    @property
    def size(self) -> float:
        """The largest |r|, relative to the size of its component."""
        return float(np.abs(self.left / self.scale).max(initial=0.0))


@dataclass(frozen=True, slots=True, eq=False)
class Shooting:
    """Newton's method for P(x) = x at values `constants` of the parameters; the components `cyclic` need not return."""

    map: ReturnMap
    constants: dict[Expr, float]
    cyclic: tuple[str, ...]

    def onto(self, x: Array, names: Sequence[str]) -> Array:
        """A state on the constraints with the components `names` of x, and other components near those of x."""
        eom = self.map.eom
        if not eom.constraints.constraints:
            return x
        kept = set(names)
        values = [float(v) if s.name in kept else guess(float(v)) for s, v in zip(eom.state, x, strict=True)]
        q, u = len(eom.coordinates), len(eom.coordinates) + len(eom.speeds)
        at: Any = {"parameters": self.constants, "inputs": self.map.inputs_at_start(self.constants), "t": self.map.t0}
        found = assemble(
            eom,
            q=dict(zip(eom.coordinates, values, strict=False)),
            u=dict(zip(eom.speeds, values[q:u], strict=True)),
            **at,
        )
        return start_state(eom, found.q, found.u, x[u:])

    def shot(self, x: Array, samples: Any = ()) -> FirstReturn:
        """The motion from x with its residual."""
        motion = self.map(x, self.constants, samples)
        left = motion.states[-1] - x
        left[self._cyclic] = 0.0
        rate = Differential((), self.map.settings, {}).side(motion, 0).rate
        way = np.abs(rate) * float(motion.t[-1] - motion.t[0]) / (2 * np.pi)
        size = np.maximum(np.abs(motion.states).max(axis=0), way)
        return FirstReturn(x, motion, left, sizes_of(self.map.eom, size, 0.1), way)

    @property
    def _cyclic(self) -> list[int]:
        return [i for i, s in enumerate(self.map.eom.state) if s.name in self.cyclic]

    def linear(self, shot: FirstReturn, by: tuple[Parameter, ...] = ()) -> "Linearized":
        """The derivative of P at a shot with respect to independent perturbations, and to the parameters `by`."""
        whole = self.map.differential(shot.motion, by, self.constants)
        walk = Differential((), self.map.settings, {})
        flow = flow_of(walk.side(shot.motion, 0))
        basis, names = basis_of(flow), flow.states
        kept = [k for k, name in enumerate(names) if name not in self.cyclic]
        basis = basis[:, kept]
        back = np.asarray(np.linalg.pinv(basis), dtype=np.float64)
        n, known = len(shot.x), {s.name: x for s, x in zip(self.map.eom.state, shot.scale.tolist(), strict=True)}
        own = whole.x.copy()
        own[self._cyclic] = 0.0
        self._check_cyclic(own, shot.scale)
        return Linearized(
            basis,
            back,
            back @ own[:, :n] @ basis,
            back @ own[:, n:],
            flow.rest[kept],
            np.array([known.get(names[k], 1.0) for k in kept]),  # 1 rad for small angles of Euler parameters
            tuple(names[k] for k in kept),
            whole.t,
        )

    def _check_cyclic(self, slopes: Array, scale: Array) -> None:
        """A SimulationError if another component of P(x) depends on a cyclic one."""
        names = [s.name for s in self.map.eom.state]
        for i in self._cyclic:
            share = np.abs(slopes[:, i]) * scale[i] / scale
            if share.max(initial=0.0) > SIX_DIGITS:
                raise SimulationError(
                    f"Expected in cyclic= coordinates on which nothing else depends, got {names[i]}: {names[int(np.argmax(share))]} "
                    "at the end of the motion depends on it. Leave it out, as it must return to its first value."
                )

    def newton(self, x: Array, tolerance: float, most: int) -> tuple[FirstReturn, "Linearized", int]:
        """The cycle near x, its derivative, and the number of Newton steps.

        Raises
        ------
        SimulationError
            if the steps do not converge, or the motion ends where it begins
        """
        now = self.shot(x)
        for step in range(most):
            far(partial("a residual of {:.1e}".format, now.size))
            if self.map.section is not None and not now.moves:
                raise SimulationError(
                    "Expected a motion between two passages of the section, got one that meets it again right where it began, "
                    f"after {float(now.motion.t[-1]) - self.map.t0:.3g} s. Start from the state that the section's action "
                    "leaves, or farther from rest."
                )
            linear = self.linear(now)
            if now.size <= ROUNDED_CHAIN:
                return now, linear, step
            after = self._step(now, linear)
            if now.size <= tolerance and (after is None or after.size > 0.5 * now.size):
                return now, linear, step
            if after is None:
                break
            now = after
        if now.size <= tolerance:
            return now, self.linear(now), most
        names = [s.name for s in self.map.eom.state]
        worst = int(np.argmax(np.abs(now.left / now.scale)))
        raise SimulationError(
            f"Expected a cycle near the start, got none within {most} Newton steps: the closest motion ends "
            f"{now.left[worst]:.3g} away from its start in {names[worst]}, {now.size:.1e} of its size, after "
            f"{float(now.motion.t[-1]) - self.map.t0:.6g} s. Start closer to the cycle: let the motion settle by kn.simulate "
            "first, or follow the cycle from other values of the parameters."
        )

    def _step(self, now: FirstReturn, linear: "Linearized") -> FirstReturn | None:
        """The shot after a damped Newton step that reduces the residual; None if no step does."""
        change = linear.basis @ linear.solve(linear.back @ now.left)
        share, failed = 1.0, None
        for _ in range(_HALVINGS):
            try:
                after = self.shot(self.onto(now.x + share * change, linear.names))
            except SimulationError as error:
                failed = error
            else:
                if after.size < (1 - 0.1 * share) * now.size:
                    return after
                failed = None
            share /= 2
        if failed is not None:
            raise failed
        return None

    def sampled(self, shot: FirstReturn) -> Solution:
        """The motion of a shot with many samples."""
        length = float(shot.motion.t[-1]) - self.map.t0
        return self.shot(shot.x, np.linspace(self.map.t0, self.map.t0 + length * (1 - SAME_TIME), _SAMPLES)).motion


@dataclass(frozen=True, slots=True, eq=False)
class Linearized:
    """T, T⁺, `d` = T⁺ D T, `by` = T⁺ ∂P/∂p, and δT; initial rates `rest` of the independent perturbations, their `sizes`, `names`."""

    basis: Array
    back: Array
    d: Array
    by: Array
    rest: Array
    sizes: Array
    names: tuple[str, ...]
    t: Array

    @property
    def sized(self) -> Array:
        """T⁺ D T of perturbations in units of their sizes."""
        return self.d * self.sizes / self.sizes[:, None]

    def solve(self, right: Array) -> Array:
        """ξ of (I − D) ξ = right.

        Raises
        ------
        SimulationError
            if a multiplier is 1
        """
        own = self.sized
        matrix = np.eye(len(own)) - own
        scale = 1.0 + np.abs(own).max(axis=1, initial=0.0)
        values = np.linalg.svd(matrix / scale[:, None], compute_uv=False)
        if values.min(initial=1.0) <= STATE_RANK:
            raise SimulationError(
                "Expected an isolated cycle, got one with a multiplier 1: it is one of a family, as where energy is conserved "
                "or a coordinate may have any value. Give cyclic= for coordinates that need not return (of "
                f"{', '.join(self.names)}), or section= instead of period= if nothing depends on time."
            )
        return np.asarray(np.linalg.solve(matrix, right / self.sizes) * self.sizes)

    def multipliers(self, on_section: bool) -> Complex:
        """The multipliers by decreasing magnitude; on a section without the trivial one."""
        d = self.sized
        if on_section and len(d):
            across = np.linalg.svd((self.rest / self.sizes)[None, :])[2][1:].T
            d = across.T @ d @ across
        found = np.asarray(np.linalg.eigvals(d), dtype=complex) if len(d) else np.zeros(0, dtype=complex)
        return found[np.lexsort((-found.imag, -np.round(np.abs(found), 12)))]

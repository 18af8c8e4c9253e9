# SPDX-License-Identifier: BSD-3-Clause
"""Backward integration of the adjoint over a stretch of a motion whose states are known.

One routine computes the vector-Jacobian product wᵀ ∂f/∂(x, p, r) by reverse differentiation of the equations; a kernel calls it step
by step (`pulling_kernel`). Contributions of input laws and of an integrand are evaluated separately, for blocks of steps.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from kane.dynamics.readings.quantities import without_unknowns
from kane.dynamics.slopes import backward
from kane.equations.compiled import along, ports
from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.expr.differentiation import gradient
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol
from kane.expr.visit import substituted
from kane.model.contact_modes import in_mode
from kane.motion.arguments import by_kind
from kane.motion.derivatives.parameter_slopes import evaluated, law_slopes
from kane.motion.derivatives.pulling_kernel import LAST, NODES, STAGES, Place, pulling_kernel
from kane.motion.derivatives.tangent_space import Side
from kane.motion.inputs.expressions import Formula
from kane.motion.right_hand_side import Routines, only, turning
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle, Shaped
from kane.program.native.entry import CompiledKernel, aligned, aligned_copy, hoisted, wide_entry
from kane.program.native.machine import Settings
from kane.program.program import Port

_B = np.array(NODES.b)
_DOUBLES = 1 << 21
"""Largest number of doubles stored for the stages of a block of steps."""


def pulls(eom: Equations, *by: Symbol) -> Bundle[Array]:
    """wᵀ ∂(q̇, u̇, ȧ)/∂symbols, by one reverse sweep."""
    w = along("w", eom.state)
    t, x, *given = ports(eom.derived)
    own = (t, x, Port("w", w, noun="weight", nouns="weights"), *given)
    return Bundle("pulls", own, only, {"x": Shaped((len(by),), tuple(backward(eom.solved, by, w)))})


@cache
def _compiled(settings: Settings) -> CompiledKernel:
    return CompiledKernel(pulling_kernel(), settings)


class StageStates(NamedTuple):
    """Times of stages (steps × 8), lengths (steps), states at the stages (steps × 8 × n)."""

    t: Array
    h: Array
    x: Array


class Weights(NamedTuple):
    """∂J/∂x (m × n) and ∂J/∂p (m × k) of m functionals J at an instant; `sizes` are the sums of absolute contributions to ∂J/∂p.

    `integral` is ∫ L dt from that instant to the end.
    """

    x: Array
    p: Array
    sizes: Array
    integral: float = 0.0


class Pulled(NamedTuple):
    """The weights at the start; error estimates of steps (infinite where the iteration failed), and of ∂J/∂p, absolute.

    `pace` is the contraction factor of the iteration in a step where it did not converge.
    """

    weights: Weights
    rough: Array
    bent: Array
    pace: float


@dataclass(frozen=True, slots=True, eq=False)
class Integrand:
    """L of ∫ L dt: an expression, and the factor with which the integral enters each of m functionals J (m)."""

    expr: Expr
    factors: Array
    inputs: Mapping[Any, Any]

    def slopes(self, now: Routines, by: Sequence[Parameter], t: Array, x: Array) -> tuple[Array, Array, Array]:
        """L (m), ∂L/∂x (m × n) and ∂L/∂p (m × k) at times and states."""
        roots = now.eom.numeric(now.settings).value(slopes_with_laws, self.expr, tuple(by), Laws(self.inputs))
        table = evaluated(roots, now, t, x)
        return table[0], table[1 : 1 + now.width].T, table[1 + now.width :].T

    def jump(self, before: Side, behind: Side) -> float:
        """L⁻ − L⁺ across an instant."""
        first, second = (float(self.slopes(s.now, (), np.array([s.t]), s.x[None])[0][0]) for s in (before, behind))
        return first - second

    def checked(self, eom: Equations) -> list[Expr]:
        """L with the laws of inputs substituted.

        Raises
        ------
        SimulationError
            if it is discontinuous in the state
        """
        own = Laws(self.inputs).read(eom, [self.expr])
        jumping = next((s for s in turning({"integral": own}) if s.jumps), None)
        if jumping is not None:
            raise SimulationError(
                "Expected an integrand that is smooth between events for the derivative of its integral, got one that jumps "
                f"where the state crosses a threshold: {jumping.text}. Smooth it ({jumping.smooth}), or replace it by a "
                "further state, kn.state, that an event sets there."
            )
        return own


class Laws:
    """The laws of inputs that are expressions, by symbol; compared and hashed by the identity of the expressions."""

    def __init__(self, inputs: Mapping[Any, Any]) -> None:
        self.whole: dict[Expr, Expr] = {s: f.expr for s, f in inputs.items() if isinstance(f, Formula)}
        self._key = tuple(id(e) for pair in self.whole.items() for e in pair)

    def read(self, eom: Equations, exprs: Sequence[Expr]) -> list[Expr]:
        """Expressions in the contact mode of the equations, with input laws substituted and accelerations and reactions eliminated."""
        held = in_mode(eom.system.contacts, eom.system.modes, exprs)
        plain = without_unknowns(eom.solved, [substituted(e, self.whole) for e in held])
        return [substituted(e, self.whole) for e in plain]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Laws) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


def slopes_with_laws(eom: Equations, expr: Expr, by: tuple[Parameter, ...], laws: Laws) -> list[Expr]:
    """An expression with input laws substituted, and its gradient with respect to state and parameters."""
    (whole,) = laws.read(eom, [expr])
    return [whole, *gradient(whole, [*eom.state, *by])]


class _Gains(NamedTuple):
    """Contributions to ∂J/∂p (rows × p), their absolute sums and error estimates; and ∫ L dt (1)."""

    own: Array
    sized: Array
    bent: Array
    integral: Array

    @staticmethod
    def none(rows: int, count: int) -> "_Gains":
        """Zero contributions."""
        own, sized, bent = np.zeros((3, rows, count))
        return _Gains(own, sized, bent, np.zeros(1))

    def add(self, given: Array, slopes: Array) -> None:
        """Adds the products of weights at the nodes (rows × steps × laws · 8) and slopes (steps × laws × 8 × p)."""
        rows, steps, count = given.shape
        by = slopes.reshape(steps, count, slopes.shape[-1])
        whole, along = given.reshape(rows, steps * count), by.reshape(steps * count, by.shape[2])
        self.own[:] += whole @ along
        self.sized[:] += np.abs(whole) @ np.abs(along)
        laws = count // STAGES
        last = [np.abs(np.einsum("rmi,mip->rmp", given * np.tile(row, laws), by)) for row in np.array(LAST) / _B]
        first, second, above = (np.maximum(*last[m : m + 2]) for m in (0, 2, 4))
        shares = [np.divide(above, x, out=np.ones_like(x), where=above < x) for x in (first, second)]
        self.bent[:] += (above * np.minimum(shares[0] ** 2, shares[1] ** 4)).sum(axis=1)


class Pulling:
    """The backward integration for one set of equations with numeric parameters and inputs."""

    def __init__(self, now: Routines, by: Sequence[Parameter]) -> None:
        self.now, self.by, eom = now, tuple(by), now.eom
        own = set(eom.parameters)
        self.place = [k for k, s in enumerate(by) if s in own]
        self.laws = law_slopes(now, (*eom.state, *by))
        self.routine = now.routine(pulls, *eom.state, *(by[k] for k in self.place), *self.laws).flat
        zero, r = np.zeros(now.width), np.zeros(len(now.drives))
        kinds = eom.numeric(now.settings).value(by_kind)
        self.pairs, self.pair_count = kinds["pairs"], kinds["pair_count"]
        self.h = hoisted(self.routine, 0.0, zero, zero, now.p, r)

    @staticmethod
    def serves(drives: Iterable[Any]) -> bool:
        """Whether all inputs are numbers, functions of time or expressions, as the method requires."""
        return not any(getattr(f, "of_state", False) and not isinstance(f, Formula) for f in drives)

    def __call__(
        self, steps: StageStates, end: Weights, seeds: Mapping[int, Array], integrand: Integrand | None, scale: Array
    ) -> Pulled:
        """The weights at the start of the steps from those at the end; `seeds` (rows × n) are added at the ends of some steps."""
        now, rows, count = self.now, len(end.x), len(self.place)
        size = STAGES * (now.width * (2 + len(self.laws)) + 1 + len(now.drives)) + 1
        most, total = max(1, _DOUBLES // size), len(steps.h)
        kept = {"lam": end.x.copy().reshape(-1), "k": aligned(rows * now.width * STAGES), "last": np.zeros(rows)}
        kept |= {name: np.zeros(rows * now.width) for name in ("edge", "tail")}
        kept |= {name: np.zeros(rows * count + 1) for name in ("own", "sized", "bent")} | {"told": np.zeros(len(Place))}
        of_laws, rough = _Gains.none(rows, len(self.by)), np.full(total, np.inf)
        found = True
        for k in reversed(range(0, total, most)):
            some = StageStates(*(part[k : k + most] for part in steps))
            own = {i - k: seed for i, seed in seeds.items() if k <= i < k + most}
            found = self._some(some, (kept, rough[k : k + most], of_laws), own, integrand, scale)
            if not found:
                break
        whole = _Gains.none(rows, len(self.by))
        for name, to in (("own", whole.own), ("sized", whole.sized), ("bent", whole.bent)):
            to[:, self.place] = kept[name][:-1].reshape(rows, count)
        gains = _Gains(*(x + y for x, y in zip(whole, of_laws, strict=True)))
        lam = kept["lam"].reshape(rows, -1)
        integral = end.integral + float(gains.integral[0])
        weights = Weights(lam, end.p + gains.own, end.sizes + gains.sized, integral)
        return Pulled(weights, rough, gains.bent, float(kept["told"][Place.PACE]))

    def _some(
        self,
        steps: StageStates,
        to: tuple[dict[str, Array], Array, _Gains],
        seeds: Mapping[int, Array],
        integrand: Integrand | None,
        scale: Array,
    ) -> bool:
        """The same for a block of steps; writes the arrays of the kernel, step errors and contributions to ∂J/∂p. True on success."""
        now, n, (kept, rough, gains) = self.now, self.now.width, to
        rows, count, laws, m = len(kept["last"]), len(self.place), len(self.laws), len(steps.h)
        times, states = steps.t.reshape(-1), steps.x.reshape(-1, n)
        slopes = np.zeros((laws, n + len(self.by), m, STAGES))
        for i, row in enumerate(self.laws.values()):
            slopes[i] = evaluated(row, now, times, states).reshape(-1, m, STAGES)
        source, factors, by_p = np.zeros((0, n, STAGES)), np.zeros(rows), None
        if integrand is not None:
            along_t, by_x, by_p = integrand.slopes(now, self.by, times, states)
            gains.integral[0] += float(np.sum(steps.h[:, None] * _B * along_t.reshape(m, STAGES)))
            source, factors = by_x.reshape(m, STAGES, n).transpose(0, 2, 1), integrand.factors
        inputs = now.inputs(times, states).reshape(m, STAGES, -1).transpose(0, 2, 1)
        seeded, of_inputs = np.full(m, -1.0), aligned(rows * m * laws * STAGES)
        seeded[list(seeds)] = np.arange(len(seeds))
        back = _compiled(now.settings or Settings())(
            kept
            | {
                "rows": rows, "steps": m, "n": n, "count": count, "laws": laws, "wide": len(now.drives),
                "times": aligned_copy(steps.t), "x": aligned_copy(steps.x.transpose(0, 2, 1)), "p": np.append(now.p, 0.0),
                "r": aligned_copy(inputs), "h": self.h, "lengths": np.append(steps.h, 0.0), "rough": rough,
                "through": aligned_copy(slopes[:, :n].transpose(2, 0, 1, 3)), "source": aligned_copy(source),
                "sourced": factors.copy(), "scale": scale.copy(), "seeded": seeded,
                "seeds": np.append(np.array([*seeds.values()]), 0.0), "w": aligned(n * STAGES),
                "out": aligned((n + count + laws) * STAGES), "of_inputs": of_inputs,
                "pairs": self.pairs, "pair_count": self.pair_count, "pull": wide_entry(self.routine, STAGES),
            }
        )  # fmt: skip
        gains.add(of_inputs.reshape(rows, m, laws * STAGES), slopes[:, n:].transpose(2, 0, 3, 1))
        if by_p is not None:
            gains.add(factors[:, None, None] * (steps.h[:, None] * _B), by_p.reshape(m, STAGES, -1))
        return back == 0

# SPDX-License-Identifier: BSD-3-Clause
"""How exact a motion is, by its variational equations: what it misses between samples, carried on by derivatives of the rates.

With x̂ the motion's states and φ the flow of the equations, δ = x̂(tᵢ₊₁) − φ(x̂(tᵢ)) is what it missed between two samples, and the
error e = x̂ − x goes on as e(tᵢ₊₁) = Φ e(tᵢ) + δ to first order in e, where Φ solves Φ′ = J Φ along φ, J = ∂ẋ/∂x (Hairer, Nørsett &
Wanner 1993, sec. I.14). Both are stepped together, at a thousandth of the motion's tolerances.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.motion.compiled_equations import Routines, routines
from kane.motion.feedback import controllers
from kane.motion.formulas import turning_laws
from kane.motion.implicit import exact
from kane.motion.regimes import has_jumps
from kane.motion.solution import Solution
from kane.motion.time_breaks import next_end, on_from
from kane.numeric.arrays import Array
from kane.program.native.machine import Settings

_FINER, _LEAST = 1e-3, 3e-14
"""Share of the motion's tolerances at which it is stepped again from each sample, and the least that rounding allows."""
_STEPS = 256
"""As many steps at least, so that none leaps over what inputs do."""
_LOOKS, _STIFF = 9, 1e5
"""At so many samples it is asked for the fastest rate; how often it fits into the span where an implicit method takes less time."""


def variational_errors(motion: Solution, breakpoints: Sequence[float], settings: Settings | None) -> Array:
    """e of coordinates, speeds and further states (n × width) at the samples.

    Raises
    ------
    SimulationError
        if e jumps on the way, where states, ranks or loads do, or controllers are asked; if a step from a sample fails
    """
    _check(motion)
    flow = _Flow(motion, sorted(breakpoints), settings)
    errors = np.zeros_like(motion.states)
    for k in range(len(motion) - 1):
        errors[k + 1] = flow.error(k, errors[k])
    return errors


def _check(motion: Solution) -> None:
    inputs = tuple(motion.phases[0].inputs.values())
    met = {
        "events change the state or motions are joined": len(motion.phases) > 1,
        "the constraints lose rank": bool(motion.lost.any()),
        "loads or inputs jump at states": has_jumps(motion.equations, turning_laws(inputs)),
        "a sampled controller is asked": bool(controllers(inputs)),
    }
    told = [text for text, holds in met.items() if holds]
    if told:
        raise SimulationError(
            f"Expected a motion whose error is smooth for the variational equations, got one in which {' and '.join(told)}. Take "
            "sol.accuracy(), which repeats the motion."
        )


class _Flow:
    """The equations and their variational equations, z = (x, e), stepped from sample to sample of a motion."""

    def __init__(self, motion: Solution, breakpoints: Sequence[float], settings: Settings | None) -> None:
        from scipy import integrate

        self.motion, self.breakpoints, self.settings = motion, breakpoints, settings
        self.width, self.length = motion.states.shape[1], np.inf
        self.known: dict[Equations, tuple[Routines, Callable[[float, Array], Array]]] = {}
        self.take(0)
        span = float(motion.t[-1] - motion.t[0])
        stiff = max(map(self._fastest, range(0, len(motion), max(1, len(motion) // _LOOKS)))) * span > _STIFF
        self.solver: Any = integrate.Radau if stiff else integrate.DOP853
        self.options: dict[str, Any] = {"jac": self._twice} if stiff else {}
        self.options |= {"rtol": max(_FINER * motion.rtol, _LEAST), "atol": _FINER * motion.atol}
        self.options["max_step"] = span / _STEPS

    def take(self, k: int) -> None:
        """The equations whose dependent speeds are determined at a sample; the flow along the constraints is the same by all."""
        motion = self.motion
        eom = motion.samples[k] if motion.samples else motion.equations
        if eom not in self.known:
            p = np.array([motion.phases[0].parameters[s] for s in eom.parameters])
            now = routines(eom, p, tuple(motion.phases[0].inputs.values()), self.settings)
            self.known[eom] = now, exact(now)
        self.now, self.slopes = self.known[eom]

    def _fastest(self, k: int) -> float:
        """The largest |eigenvalue| of J at a sample."""
        self.take(k)
        return float(np.abs(np.linalg.eigvals(self._j(float(self.motion.t[k]), self.motion.states[k]))).max(initial=0))

    def _j(self, t: float, x: Array) -> Array:
        whole: Array = self.slopes(t, np.append(x, 0.0))
        return whole[:-1, :-1]

    def _rates(self, t: float, z: Array) -> Array:
        x, e = z[: self.width], z[self.width :]
        return np.concatenate([self.now.rate(t, np.append(x, 0.0))[:-1], self._j(t, x) @ e])

    def _twice(self, t: float, z: Array) -> Array:
        """J of (x, e) without what e adds by second derivatives: it steers iterations alone."""
        return np.asarray(np.kron(np.eye(2), self._j(t, z[: self.width])), dtype=np.float64)

    def error(self, k: int, e: Array) -> Array:
        """e at the sample after the one at place k, where it is e."""
        self.take(k)
        t, states = self.motion.t, self.motion.states
        at, z = float(t[k]), np.concatenate([states[k], e])
        while at < t[k + 1]:
            end = next_end(self.breakpoints, at, float(t[k + 1]))
            z = self._to(at, z, end)
            at = on_from(end) if end < t[k + 1] else end
        return np.asarray(z[self.width :] + states[k + 1] - z[: self.width])

    def _to(self, t: float, z: Array, end: float) -> Array:
        if not end > t:
            return z
        first = min(self.length, end - t) if np.isfinite(self.length) else None
        solver = self.solver(self._rates, t, z, end, first_step=first, **self.options)
        while solver.status == "running":
            message = solver.step()
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            raise SimulationError(
                "Expected equations that can be stepped at a thousandth of the motion's tolerances, got none beyond "
                f"t = {solver.t:.6g}: {message or 'the error is not finite'}. Take sol.accuracy(), which repeats the motion."
            )
        self.length = solver.h_abs
        return np.asarray(solver.y)

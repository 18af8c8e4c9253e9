# SPDX-License-Identifier: BSD-3-Clause
"""Error estimates of a motion: by comparison with smaller tolerances or steps, or by its variational equations.

With the motion's states x̂ and the flow φ of the equations, δ = x̂(tᵢ₊₁) − φ(x̂(tᵢ)) is the defect between two samples, and the error
e = x̂ − x is propagated by e(tᵢ₊₁) = Φ e(tᵢ) + δ to first order in e, where Φ solves Φ′ = J Φ along φ, J = ∂ẋ/∂x (Hairer, Nørsett &
Wanner 1993, sec. I.14). Both are integrated together, at a thousandth of the motion's tolerances.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kane import expect
from kane.equations.equations import Equations
from kane.errors import ArgumentError, Attributes, SimulationError, cut, none_of
from kane.motion.inputs.breakpoints import next_end, on_from
from kane.motion.inputs.expressions import controllers, turning_laws
from kane.motion.right_hand_side import Routines, exact, has_jumps, routines
from kane.motion.solution.phases import Parts
from kane.numeric.arrays import Array
from kane.numeric.scale import NEAR_TIME, ROUNDED
from kane.program.native.machine import Settings

REPEATED, VARIATIONAL = "repeated", "variational"
"""Methods of error estimation."""
_TENTH = 0.1
_SHARES = {"rk4": 16 / 15, "midpoint": 4 / 3}
"""The error of methods with fixed steps, relative to the change when the step is halved."""
_IN_PARTS = (
    "Expected a motion that this process simulated as a whole, got one that was joined, or read from a file or a pickle, "
    "which contains inputs only at the samples. Simulate it here, or use each part separately"
)


@dataclass(frozen=True, slots=True, eq=False)
class Accuracy(Attributes):
    """Estimated errors of coordinates and speeds along a motion, from `sol.accuracy`.

    Attributes
    ----------
    t : times (n) of samples; if a second motion was used, those in both motions
    errors : absolute errors (n × (coordinates + speeds)), in the units of coordinates and speeds
    largest : the largest error of each coordinate and speed, by name
    relative : the largest ratio of the error of a coordinate or speed to its largest magnitude
    worst : the name of that coordinate or speed
    at : the time of that error (s)
    """

    t: Array
    errors: Array
    largest: dict[str, float]
    relative: float
    worst: str
    at: float

    def __repr__(self) -> str:
        return f"Accuracy({self.relative:.1e} of {self.worst} at t = {self.at:.4g} s)"


def accuracy(motion: Any, again: Callable[..., Any] | None, method: str) -> Accuracy:
    """See Solution.accuracy."""
    if method not in (REPEATED, VARIATIONAL):
        raise ArgumentError(f"Expected method to be one of {none_of((REPEATED, VARIATIONAL), method)}")
    if isinstance(again, Between):
        return again.accuracy(motion.t, method)
    if again is None or isinstance(again, Parts):
        raise SimulationError(f"{_IN_PARTS}.")
    if motion.t[0] == motion.t[-1]:  # a motion without duration
        return _accuracy_of(motion, motion.t, np.zeros_like(motion.states))
    if method == VARIATIONAL:
        return _accuracy_of(motion, motion.t, np.abs(again(motion, variational=True)))
    share = _SHARES.get(motion.method, 1.0)
    if share != 1.0:
        finer = again(motion)
    elif motion.rtol * _TENTH < ROUNDED:
        raise SimulationError(
            f"Expected a motion with rtol of {ROUNDED / _TENTH:.0e} or more, got {motion.rtol:g}: at a tenth of it only "
            "rounding errors would differ. Compare it with a motion by another method."
        )
    else:
        finer = again(motion, rtol=motion.rtol * _TENTH, atol=motion.atol * _TENTH)
    # where a phase begins there are two values, at a time that differs between the motions
    _, _, there = np.intersect1d(np.setdiff1d(motion.t, motion.t[motion.begins]), finer.t, return_indices=True)
    here = np.searchsorted(motion.t, finer.t[there])
    return _accuracy_of(motion, motion.t[here], share * np.abs(motion.states[here] - finer.states[there]))


def _accuracy_of(motion: Any, t: Array, errors: Array) -> Accuracy:
    """The Accuracy of a motion with these errors at times of samples."""
    sizes = np.abs(motion.states).max(axis=0)
    ratio = np.divide(errors, sizes, out=np.where(errors > 0, np.inf, 0.0), where=sizes > 0)
    k, i = (int(x) for x in np.unravel_index(int(np.argmax(ratio)), ratio.shape))
    names = [s.name for s in motion.equations.state]
    largest = dict(zip(names, errors.max(axis=0).tolist(), strict=True))
    return Accuracy(t, errors, largest, float(ratio[k, i]), names[i], float(t[k]))


def between(motion: Any, again: Callable[..., Any] | None, times: Any) -> Any:
    """See Solution.at."""
    if again is None:
        raise SimulationError(f"{_IN_PARTS}; or take more samples.")
    wanted = np.atleast_1d(expect.floats(times, "a time or times of the motion", error=SimulationError))
    begin, end = float(motion.t[0]), float(motion.t[-1])
    if wanted.ndim != 1 or not wanted.size or np.any(np.diff(wanted) <= 0):
        raise SimulationError(
            f"Expected a time, or increasing times, of the motion, got {cut(repr(times))}. Sort them."
        )
    if not (begin <= wanted[0] and wanted[-1] <= end):
        raise SimulationError(
            f"Expected times of the motion, from t = {begin:.9g} to {end:.9g}, got {wanted[0]:.9g} to {wanted[-1]:.9g}. "
            "Continue the motion for later times: kn.simulate(eom, end, start=sol)."
        )
    whole = motion if begin == end else again(motion, samples=wanted)
    # of the two values where a phase begins, the later one
    places = np.searchsorted(whole.t, wanted, side="right") - 1
    off = wanted - whole.t[np.clip(places, 0, len(whole.t) - 1)]
    if np.any(np.abs(off) > NEAR_TIME * max(abs(begin), abs(end), end - begin)):
        raise SimulationError(
            f"Expected the repeated motion to reach t = {end:.9g} again, got one that ends at {whole.t[-1]:.9g}: "
            f"{whole.message}. Functions that are inputs must return the same values at each call."
        )
    return replace(whole._only(places), _again=Between(whole))


@dataclass(frozen=True, slots=True, eq=False)
class Between:
    """A function that repeats a `whole` motion, for the part of it at some times."""

    whole: Any

    def __call__(self, motion: Any, samples: Array) -> Any:
        """The whole motion at other times."""
        return self.whole._again(self.whole, samples=samples)

    def accuracy(self, times: Array, method: str) -> Accuracy:
        """The errors of the whole motion at those times that its error estimate includes."""
        every: Accuracy = self.whole.accuracy(method=method)
        kept = np.isin(every.t, times)
        if not kept.any():
            raise SimulationError(
                "Expected times other than those at which events change the motion, got none. Give others."
            )
        return _accuracy_of(self.whole, every.t[kept], every.errors[kept])


_THOUSANDTH, _LEAST_RTOL = 1e-3, 3e-14
"""Share of the motion's tolerances at which it is integrated from each sample, and the least rtol that rounding allows."""
_STEPS = 256
"""Least number of steps over the span, so that no step passes over changes of inputs."""
_LOOKS, _STIFF = 9, 1e5
"""Number of samples at which ρ(J) is evaluated, and the product of ρ(J) and the span above which an implicit method is faster."""


def variational_errors(motion: Any, breakpoints: Sequence[float], settings: Settings | None) -> Array:
    """e of coordinates, speeds and further states (n × width) at the samples.

    Raises
    ------
    SimulationError
        if e may jump, since states, ranks or loads jump or a controller is sampled; if the integration from a sample fails
    """
    _check(motion)
    flow = _Flow(motion, sorted(breakpoints), settings)
    errors: Array = np.zeros_like(motion.states)
    for k in range(len(motion) - 1):
        errors[k + 1] = flow.error(k, errors[k])
    return errors


def _check(motion: Any) -> None:
    inputs = tuple(motion.phases[0].inputs.values())
    met = {
        "events change the state or motions are joined": len(motion.phases) > 1,
        "the constraints lose rank": bool(motion.lost.any()),
        "loads or inputs jump with the state": has_jumps(motion.equations, turning_laws(inputs)),
        "a sampled controller acts": bool(controllers(inputs)),
    }
    told = [text for text, holds in met.items() if holds]
    if told:
        raise SimulationError(
            f"Expected a motion whose error is smooth for the variational equations, got one in which {' and '.join(told)}. "
            "Use sol.accuracy(), which repeats the motion."
        )


class _Flow:
    """The equations and their variational equations, z = (x, e), integrated from sample to sample of a motion."""

    def __init__(self, motion: Any, breakpoints: Sequence[float], settings: Settings | None) -> None:
        from scipy import integrate

        self.motion, self.breakpoints, self.settings = motion, breakpoints, settings
        self.width, self.length = motion.states.shape[1], np.inf
        self.known: dict[Equations, tuple[Routines, Callable[[float, Array], Array]]] = {}
        self.take(0)
        span = float(motion.t[-1] - motion.t[0])
        stiff = max(map(self._fastest, range(0, len(motion), max(1, len(motion) // _LOOKS)))) * span > _STIFF
        self.solver: Any = integrate.Radau if stiff else integrate.DOP853
        self.options: dict[str, Any] = {"jac": self._twice} if stiff else {}
        self.options |= {"rtol": max(_THOUSANDTH * motion.rtol, _LEAST_RTOL), "atol": _THOUSANDTH * motion.atol}
        self.options["max_step"] = span / _STEPS

    def take(self, k: int) -> None:
        """Selects the equations whose dependent speeds are determined at sample k; all have the same flow on the constraints."""
        motion = self.motion
        eom = motion.samples[k] if motion.samples else motion.equations
        if eom not in self.known:
            p = np.array([motion.phases[0].parameters[s] for s in eom.parameters])
            now = routines(eom, p, tuple(motion.phases[0].inputs.values()), self.settings)
            self.known[eom] = now, exact(now)
        self.now, self.slopes = self.known[eom]

    def _fastest(self, k: int) -> float:
        """The spectral radius ρ(J) at sample k."""
        self.take(k)
        return float(np.abs(np.linalg.eigvals(self._j(float(self.motion.t[k]), self.motion.states[k]))).max(initial=0))

    def _j(self, t: float, x: Array) -> Array:
        whole: Array = self.slopes(t, np.append(x, 0.0))
        return whole[:-1, :-1]

    def _rates(self, t: float, z: Array) -> Array:
        x, e = z[: self.width], z[self.width :]
        return np.concatenate([self.now.rate(t, np.append(x, 0.0))[:-1], self._j(t, x) @ e])

    def _twice(self, t: float, z: Array) -> Array:
        """The Jacobian of (ẋ, ė) without second derivatives, which suffices for the iterations of implicit stages."""
        return np.asarray(np.kron(np.eye(2), self._j(t, z[: self.width])), dtype=np.float64)

    def error(self, k: int, e: Array) -> Array:
        """The error at sample k + 1, given the error e at sample k."""
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
                "Expected equations that can be integrated at a thousandth of the motion's tolerances, got no step beyond t = "
                f"{solver.t:.6g}: {message or 'the error is not finite'}. Use sol.accuracy(), which repeats the motion."
            )
        self.length = solver.h_abs
        return np.asarray(solver.y)

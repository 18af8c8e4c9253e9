# SPDX-License-Identifier: BSD-3-Clause
"""`prepare`: repeated motions of the same equations over one span with the same options, from different starts and parameters."""

from collections.abc import Mapping, Sequence
from copy import copy
from typing import Any

from kane.equations.equations import Equations, check_equations
from kane.errors import Attributes
from kane.motion.integrators import AdaptiveStep, FixedStep
from kane.motion.runner import Plan
from kane.motion.simulate import Runners, are_fixed, repeated, simulate, single_runner
from kane.motion.solution.checks import checking_functions
from kane.motion.solution.solution import Solution
from kane.motion.start import check_span
from kane.numeric.arrays import Array
from kane.program.native.machine import Settings


def prepare(
    eom: Equations,
    span: tuple[float, float],
    *,
    inputs: Mapping[Any, Any] | None = None,
    method: str | AdaptiveStep | FixedStep | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    samples: int | Sequence[float] = 501,
    max_steps: int | None = None,
    max_step: float | None = None,
    first_step: float | None = None,
    breakpoints: Sequence[float] | None = None,
    max_seconds: float | None = None,
    settings: Settings | None = None,
    check: Sequence[Any] = (),
) -> "Prepared":
    """Prepare repeated simulations: `run = kn.prepare(eom, span, …)`, then `run(q=…, u=…, parameters=…)` as often as needed.

    Each call returns the same motion as `kn.simulate`, bit for bit, but options are checked and code is compiled only once. The
    overhead of a call is some 40 µs if machine code runs the whole motion (`run.in_one_call`): inputs are numbers or
    expressions, and no event has a Python function as its action. Initial states on constraints are found by iteration,
    which takes some milliseconds at the first call; deflections of beams are checked after each motion. Other motions take as long
    as with `kn.simulate`.

    Parameters
    ----------
    eom : Equations
    span : (float, float)
        beginning and end (s)
    inputs, method, rtol, atol, samples, max_steps, max_step, first_step, breakpoints, max_seconds, settings, check
        as `kn.simulate` takes them

    Returns
    -------
    Prepared
        `run(q, u, states=None, parameters=None)` returns a Solution; values are given by symbol or name, or in order, and
        parameters left out take their defaults. Attributes are `equations`, `span` and `in_one_call`. Threads may call it at the
        same time

    Raises
    ------
    SimulationError
        if the span or an option is not admissible

    Examples
    --------
    >>> run = kn.prepare(eom, (0, 10), samples=11)
    >>> ends = [run(q=[angle], u=[0]).q[-1] for angle in (0.1, 0.2, 0.3)]
    """
    check_equations(eom)
    check_span(span)
    checking_functions(eom.derived, check)
    times, stops = copy(samples), copy(breakpoints)
    plan = Plan(span, method, rtol, atol, times, max_steps, max_step, first_step, stops, max_seconds).spelled()
    return Prepared(eom, plan, dict(inputs) if isinstance(inputs, Mapping) else inputs, settings, check)


class Prepared(Attributes):
    """Motions of `equations` over one `span`: `run(q=…, u=…, states=…, parameters=…)`. Threads may call it at the same time.

    Attributes
    ----------
    equations : Equations
    span : (float, float)
    in_one_call : whether a motion is one call of machine code, without Python between steps
    """

    def __init__(
        self,
        eom: Equations,
        plan: Plan,
        inputs: Mapping[Any, Any] | None,
        settings: Settings | None,
        check: Sequence[Any],
    ) -> None:
        self.equations, self.span = eom, check_span(plan.span)
        self._plan, self._inputs, self._settings, self._check = plan, inputs, settings, check
        self._runners = Runners()
        runner = single_runner(eom, plan, inputs, settings) if are_fixed(eom, inputs) else None
        self._runners.is_plain = runner is not None
        if runner is not None:
            self._runners.give_back(runner)

    @property
    def in_one_call(self) -> bool:
        """Whether a motion is one call of machine code."""
        return self._runners.is_plain

    def __call__(
        self,
        q: Mapping[Any, float] | Sequence[float] | Array,
        u: Mapping[Any, float] | Sequence[float] | Array,
        states: Mapping[Any, float] | Sequence[float] | Array | None = None,
        parameters: Mapping[Any, float] | None = None,
    ) -> Solution:
        """Simulate from initial values by symbol or name, or in order; parameters that are left out take their defaults.

        Raises
        ------
        ValueMissingError
            if a start value or parameter is missing or unknown
        SimulationError
            if the start is not admissible, or the integration fails
        """
        given, at = (self._inputs, self._settings, self._check), (q, u, states, parameters)
        result = repeated(self._runners, self.equations, self._plan, at, *given)
        if result is not None:
            return result
        options = self._plan._asdict() | {"inputs": self._inputs, "settings": self._settings, "check": self._check}
        return simulate(self.equations, q=q, u=u, states=states, parameters=parameters, **options)

    def __reduce__(self) -> tuple[Any, ...]:
        """A pickle contains the arguments; reading it prepares the motions again."""
        return Prepared, (self.equations, self._plan, self._inputs, self._settings, self._check)

    def __repr__(self) -> str:
        way = "in one call of machine code" if self.in_one_call else "as by kn.simulate"
        return f"Prepared({self.equations!r}, t = {self.span[0]:g} … {self.span[1]:g} s, {way})"

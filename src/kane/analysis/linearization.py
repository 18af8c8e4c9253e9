# SPDX-License-Identifier: BSD-3-Clause
"""`linearize`: the equations of motion about an equilibrium or a steady motion, by exact differentiation."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.beams import warn_of_beams
from kane.analysis.differentiable import Side, differentiable
from kane.analysis.flow import Choice, Flow, flow_at
from kane.analysis.linear import Linear
from kane.analysis.outputs import Outputs, outputs_of
from kane.analysis.point import point_of, state_at
from kane.analysis.sides import Piece
from kane.analysis.state import State, check_equations
from kane.analysis.steady import Steadiness, changing, steadiness
from kane.analysis.tangents import perturbations
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.errors import Attributes, SimulationError, ValueMissingError
from kane.expr.symbols import Symbol
from kane.program.native.machine import Settings
from kane.progress import working


@dataclass(frozen=True, slots=True, eq=False)
class Linearizer(Attributes):
    """`linearizer(q=…, u=…)` gives a `Linear`; the derivatives are compiled at the first call, and kept with the equations."""

    eom: Equations
    outputs: Outputs
    settings: Settings | None = None

    def __call__(
        self,
        *,
        q: Any = None,
        u: Any = None,
        parameters: Mapping[Any, float] | None = None,
        inputs: Mapping[Any, float] | None = None,
        t: float = 0.0,
        states: Any = None,
        independent: Sequence[Any] = (),
        leave_out: Sequence[Any] = (),
        steady: bool = True,
        tolerance: float = 1e-8,
        side: Side | None = None,
    ) -> Linear:
        """See `linearize`."""
        with working("Linearizing"):
            numeric = self.eom.numeric(self.settings)
            state = state_at(numeric, q, u, parameters, inputs, t, states)
            flow, verdict = _flow(numeric, state, choice_of(numeric, independent), bool(independent), tolerance)
            smooth = differentiable(flow, self.outputs, tolerance if verdict.holds else 0.0, side)
            if smooth.flow is not flow:
                flow, verdict = smooth.flow, steadiness(smooth.flow, tolerance)
            if steady and not verdict.holds:
                raise SimulationError(_not_steady(flow, verdict, self._steady_with(flow, bool(independent), tolerance)))
            _check_independent(flow, independent)
            linear = self._linear(smooth, verdict)
            return (
                linear.without(*([leave_out] if isinstance(leave_out, str) else leave_out))
                if len(leave_out)
                else linear
            )

    @staticmethod
    def _steady_with(flow: Flow, fixed: bool, tolerance: float) -> str:
        """Which speeds would be constant as independent ones where others were asked for; "" where none would."""
        if not fixed:
            return ""
        other, verdict = _flow(flow.numeric, flow.state, Choice(), False, tolerance)
        return ", ".join(other.states[slice(*other.counts)]) if verdict.holds else ""

    def _linear(self, piece: Piece, verdict: Steadiness) -> Linear:
        eom, flow, slopes = self.eom, piece.flow, piece.output_slopes
        states, count = flow.states, len(flow.states)
        return Linear(
            states,
            tuple(r.name for r in eom.inputs),
            self.outputs.names,
            states[: len(flow.tangents.free_q)],
            flow.a,
            flow.b,
            slopes[:, :count],
            slopes[:, count:],
            point_of(eom, flow.state),
            flow.rest,
            piece.outputs,
            flow.mass,
            tuple(n for n, m in zip(states, verdict.matters, strict=True) if not m),
            states[flow.counts[1] :],
        )


def linearizer(
    eom: Equations,
    *,
    outputs: Mapping[str, Any] | Sequence[Any] | None = None,
    settings: Settings | None = None,
) -> Linearizer:
    """A function that linearizes `eom` at many points, made and compiled once; `outputs` and `settings` are those of `linearize`."""
    check_equations(eom)
    return Linearizer(eom, outputs_of(eom, outputs), settings)


def linearize(
    eom: Equations,
    *,
    q: Any = None,
    u: Any = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, float] | None = None,
    t: float = 0.0,
    outputs: Mapping[str, Any] | Sequence[Any] | None = None,
    independent: Sequence[Any] = (),
    leave_out: Sequence[Any] = (),
    steady: bool = True,
    tolerance: float = 1e-8,
    side: Side | None = None,
    settings: Settings | None = None,
    states: Any = None,
) -> Linear:
    """ẋ = A x + B r about an equilibrium or a steady motion, all constraints included.

    The dependent perturbations are eliminated by the implicit function theorem at the point. In a steady motion coordinates may
    move on which nothing that matters depends: the heading and the place of a rolling disk.

    Parameters
    ----------
    eom : Equations
    q, u : the point, by symbol or name; it must satisfy the constraints, what is left out is solved for as in `assemble`
    parameters, inputs, states : values; parameters and further states left out take their defaults, inputs are zero
    outputs : expressions y by name, which may hold coordinates, their rates, speeds with their accelerations, reactions and inputs
    independent : coordinates and speeds to be independent; by default those of the equations, coordinates by rank
    leave_out : states that nothing depends on, or "cyclic" for all of them
    steady : False to linearize at any state of a motion; `rates` then tells what changes there
    tolerance : up to which share of their terms accelerations and rates count as zero
    side : where a switch (|x|, max, where, …) stands at the state, the direction in states and inputs into which the derivative is
        taken, such as {"x": 1}
    settings : how to compile

    A beam that spins faster there than what it is declared with has it is warned of, as in motions.

    Raises
    ------
    SimulationError
        if the point is off the constraints, or neither at rest nor in steady motion; says what remains
    CornerError
        if a switch stands there whose sides have other derivatives, or other values, and no `side` is given
    SingularError
        if the constraints lose rank there
    """
    evaluate = linearizer(eom, outputs=outputs, settings=settings)
    linear = evaluate(
        q=q, u=u, parameters=parameters, inputs=inputs, t=t, states=states, independent=independent, leave_out=leave_out,
        steady=steady, tolerance=tolerance, side=side,
    )  # fmt: skip
    warn_of_beams(eom, [linear.point], 2)
    return linear


@np.errstate(invalid="ignore")
def _flow(
    numeric: Numeric[Equations], state: State, choice: Choice, fixed: bool, tolerance: float
) -> tuple[Flow, Steadiness]:
    """The flow; where speeds change that another choice makes dependent, and nothing depends on them, with that choice.

    Which speeds change does not depend on what is called dependent, so neither does the verdict.
    """
    eom, flow = numeric.equations, flow_at(numeric, state, choice)
    verdict = steadiness(flow, tolerance)
    if verdict.holds or fixed or eom.embedding is None:
        return flow, verdict
    second = flow_at(numeric, state, Choice(choice.q, changing(flow, tolerance)))
    again = steadiness(second, tolerance)
    return (second, again) if again.holds else (flow, verdict)


def choice_of(numeric: Numeric[Equations], independent: Iterable[Any]) -> Choice:
    """What is to be dependent when `independent` is to be independent, and by the system's own wish."""
    eom, known = numeric.equations, numeric.value(perturbations).names
    names = [x.name if isinstance(x, Symbol) else x for x in independent]
    speeds = [u.name for u in eom.speeds]
    unknown = [str(n) for n in names if n not in known and n not in speeds]
    if unknown:
        raise ValueMissingError(
            f"Expected independent= among {', '.join((*known, *speeds))}, got {', '.join(unknown)}."
        )
    wished = {q.name for q in eom.system.dependent_coordinates}
    chosen_q = [i for i, n in enumerate(known) if (n not in names if set(names) & set(known) else n in wished)]
    chosen_u = [i for i, n in enumerate(speeds) if n not in names] if set(names) & set(speeds) else []
    return Choice(tuple(chosen_q), tuple(chosen_u))


def _check_independent(flow: Flow, wanted: Sequence[Any]) -> None:
    names, count = {x.name if isinstance(x, Symbol) else x for x in wanted}, len(flow.tangents.free_q)
    known, speeds = flow.numeric.value(perturbations).names, [u.name for u in flow.numeric.equations.speeds]
    for all_names, got in ((known, flow.states[:count]), (speeds, flow.states[slice(*flow.counts)])):
        asked = [n for n in all_names if n in names]
        if asked and set(asked) != set(got):
            raise SimulationError(
                f"Expected independent= to hold {len(got)} of {', '.join(all_names)} that determine the others, got "
                f"{', '.join(asked)}. At this point {', '.join(got)} would do."
            )


def _not_steady(flow: Flow, verdict: Steadiness, speeds: str) -> str:
    count, perturbed = len(flow.tangents.free_q), flow.numeric.value(perturbations)
    free_u = flow.tangents.free_u
    eom = flow.numeric.equations
    symbols = [perturbed.symbols[i] for i in flow.tangents.free_q] + [*(eom.speeds[i] for i in free_u), *eom.states]

    def rate_of(i: int) -> str:
        s = symbols[i]
        unit = f" {s.unit}/s" if s is not None and s.unit else ""
        return f"{flow.states[i]}' = {flow.rest[i]:.6g}{unit}"

    accelerations = [rate_of(i) for i in verdict.left if i >= count]
    rates = [rate_of(i) for i in verdict.left if i < count]
    head = "Expected an equilibrium or a steady motion to linearize about, got a state"
    if accelerations:
        also = f" (and the rates {', '.join(rates)})" if rates else ""
        what = f"where these accelerations remain: {', '.join(accelerations)}{also}"
    elif rates:
        what = f"that moves coordinates on which the speeds depend: {', '.join(rates)}"
    elif verdict.varies == (-1,):
        what = "whose equations change with the time t"
    else:
        what = f"that moves {', '.join(rate_of(i) for i in verdict.varies)}, with which the equations change"
    if speeds:
        return f"{head} {what}. With independent speeds {speeds} it is a steady motion: name those, or none."
    return f"{head} {what}. Find one with kn.trim(eom, …), or linearize at this instant with steady=False."

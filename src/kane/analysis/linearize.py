# SPDX-License-Identifier: BSD-3-Clause
"""`linearize`: the equations of motion about an equilibrium or a steady motion, by exact differentiation."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.flow import Choice, Flow, Outputs, flow_at, output_slopes, outputs_of
from kane.analysis.linear import Linear
from kane.analysis.point import point_of, state_at
from kane.analysis.state import State
from kane.analysis.steady import Steadiness, steadiness
from kane.dynamics.readings.unsolved import Perturbations, perturbations
from kane.equations.equations import Equations
from kane.errors import SimulationError, ValueMissingError
from kane.expr.symbols import Symbol
from kane.program.native.machine import Settings

LeaveOut = Sequence[Any]


@dataclass(frozen=True, slots=True, eq=False)
class Linearizer:
    """`linearizer(q=…, u=…)` gives a `Linear`; the derivatives are compiled at the first call, and kept with the equations."""

    eom: Equations
    outputs: Outputs
    known: Perturbations
    settings: Settings | None = None

    def __call__(
        self,
        *,
        q: Any,
        u: Any = None,
        parameters: Mapping[Any, float] | None = None,
        inputs: Mapping[Any, float] | None = None,
        t: float = 0.0,
        independent: Sequence[Any] = (),
        leave_out: LeaveOut = (),
        steady: bool = True,
        tolerance: float = 1e-8,
    ) -> Linear:
        """See `linearize`."""
        state = state_at(self.eom.numeric(self.settings), self.known, q, u, parameters, inputs, t)
        choice = choice_of(self.eom, self.known, independent)
        flow, verdict, choice = self._flow(state, choice, bool(independent), tolerance)
        if steady and not verdict.holds:
            raise SimulationError(_not_steady(self.eom, self.known, flow, verdict))
        _check_independent(self.eom, self.known, flow, choice, independent)
        linear = self._linear(flow, verdict)
        return linear.without(*([leave_out] if isinstance(leave_out, str) else leave_out)) if len(leave_out) else linear

    def _flow(self, state: State, choice: Choice, fixed: bool, tolerance: float) -> tuple[Flow, Steadiness, Choice]:
        """The flow; where speeds change that another choice makes dependent, and nothing depends on them, with that choice."""
        numeric = self.eom.numeric(self.settings)
        flow = flow_at(numeric, self.known, state, choice)
        verdict = steadiness(numeric, self.known, flow, choice, tolerance)
        if verdict.holds or fixed or self.eom.embedding is None or self.eom.system.dependent_speeds:
            return flow, verdict, choice
        changing = np.flatnonzero(np.abs(flow.z[: len(self.eom.speeds)]) > tolerance)
        other = Choice(choice.q, tuple(changing.tolist()))
        second = flow_at(numeric, self.known, state, other)
        again = steadiness(numeric, self.known, second, other, tolerance)
        return (second, again, other) if again.holds else (flow, verdict, choice)

    def _linear(self, flow: Flow, verdict: Steadiness) -> Linear:
        eom, tangent = self.eom, flow.tangents
        coordinates = tuple(self.known.names[i] for i in tangent.free_q)
        states = (*coordinates, *(eom.speeds[i].name for i in tangent.free_u))
        values, slopes = output_slopes(eom.numeric(self.settings), flow, self.outputs)
        return Linear(
            states,
            tuple(r.name for r in eom.inputs),
            self.outputs.names,
            coordinates,
            flow.a,
            flow.b,
            slopes[:, : len(states)],
            slopes[:, len(states) :],
            point_of(eom, flow.state),
            flow.rest,
            values,
            flow.mass,
            tuple(n for n, m in zip(states, verdict.matters, strict=True) if not m),
        )


def linearizer(
    eom: Equations,
    *,
    outputs: Mapping[str, Any] | Sequence[Any] | None = None,
    settings: Settings | None = None,
) -> Linearizer:
    """A function that linearizes `eom` at many points: the derivatives are made and compiled once.

    Parameters
    ----------
    eom : Equations
    outputs : expressions y by name, which may hold coordinates, their rates, speeds with their accelerations, reactions and inputs
    settings : how to compile
    """
    return Linearizer(eom, outputs_of(eom, outputs), perturbations(eom.derived), settings)


def linearize(
    eom: Equations,
    *,
    q: Any,
    u: Any = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, float] | None = None,
    t: float = 0.0,
    outputs: Mapping[str, Any] | Sequence[Any] | None = None,
    independent: Sequence[Any] = (),
    leave_out: LeaveOut = (),
    steady: bool = True,
    tolerance: float = 1e-8,
    settings: Settings | None = None,
) -> Linear:
    """ẋ = A x + B r about an equilibrium or a steady motion, all constraints included.

    The dependent perturbations are eliminated by the implicit function theorem at the point. In a steady motion coordinates may
    move on which nothing that matters depends: the heading and the place of a rolling disk.

    Parameters
    ----------
    eom : Equations
    q, u : the point, by symbol or name; it must satisfy the constraints, what is left out is solved for as in `assemble`
    parameters, inputs : values; parameters left out take their defaults, inputs are zero
    outputs : expressions y by name, which may hold coordinates, their rates, speeds with their accelerations, reactions and inputs
    independent : coordinates and speeds to be independent; by default those of the equations, coordinates by rank
    leave_out : states that nothing depends on, or "cyclic" for all of them
    steady : False to linearize at any state of a motion; `rates` then tells what changes there
    tolerance : up to which accelerations and rates count as zero
    settings : how to compile

    Raises
    ------
    SimulationError
        if the point is off the constraints, or neither at rest nor in steady motion; says what remains
    SingularError
        if the constraints lose rank there
    """
    evaluate = linearizer(eom, outputs=outputs, settings=settings)
    return evaluate(
        q=q, u=u, parameters=parameters, inputs=inputs, t=t, independent=independent, leave_out=leave_out, steady=steady,
        tolerance=tolerance,
    )  # fmt: skip


def choice_of(eom: Equations, perturbed: Perturbations, independent: Iterable[Any]) -> Choice:
    """What is to be dependent when `independent` is to be independent, and by the system's own wish."""
    names = [x.name if isinstance(x, Symbol) else x for x in independent]
    speeds = [u.name for u in eom.speeds]
    unknown = [str(n) for n in names if n not in perturbed.names and n not in speeds]
    if unknown:
        raise ValueMissingError(
            f"Expected independent= among {', '.join((*perturbed.names, *speeds))}, got {', '.join(unknown)}."
        )
    wished = {q.name for q in eom.system.dependent_coordinates}
    own = [i for i, n in enumerate(perturbed.names) if n in wished]
    chosen_q = (
        [i for i, n in enumerate(perturbed.names) if n not in names] if set(names) & set(perturbed.names) else own
    )
    chosen_u = [i for i, n in enumerate(speeds) if n not in names] if set(names) & set(speeds) else []
    return Choice(tuple(chosen_q), tuple(chosen_u))


def _check_independent(
    eom: Equations, perturbed: Perturbations, flow: Flow, choice: Choice, wanted: Sequence[Any]
) -> None:
    names = {x.name if isinstance(x, Symbol) else x for x in wanted}
    for all_names, free in (
        (perturbed.names, flow.tangents.free_q),
        ([u.name for u in eom.speeds], flow.tangents.free_u),
    ):
        asked = [n for n in all_names if n in names]
        got = [all_names[i] for i in free]
        if asked and set(asked) != set(got):
            raise SimulationError(
                f"Expected independent= to hold {len(got)} of {', '.join(all_names)} that determine the others, got "
                f"{', '.join(asked)}. At this point {', '.join(got)} would do."
            )


def _not_steady(eom: Equations, perturbed: Perturbations, flow: Flow, verdict: Steadiness) -> str:
    count = len(flow.tangents.free_q)
    symbols = [perturbed.symbols[i] for i in flow.tangents.free_q] + [eom.speeds[i] for i in flow.tangents.free_u]
    names = [perturbed.names[i] for i in flow.tangents.free_q] + [eom.speeds[i].name for i in flow.tangents.free_u]

    def rate_of(i: int) -> str:
        s = symbols[i]
        unit = f" {s.unit}/s" if s is not None and s.unit else ""
        return f"{names[i]}' = {flow.rest[i]:.6g}{unit}"

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
    return f"{head} {what}. Find one with kn.trim(eom, …), or linearize at this instant with steady=False."

# SPDX-License-Identifier: BSD-3-Clause
"""The operating point: complete values on the constraints."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from kane.analysis.admissible import check_branch, check_configuration
from kane.analysis.assembly import assemble
from kane.analysis.local import Values, slopes_at, values_at
from kane.analysis.state import State, entries, start_state
from kane.analysis.tangents import perturbations, spread
from kane.dynamics.readings.values import parameter_values
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.errors import Attributes, ValueMissingError
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.numeric.named import finite_number, named_values, symbol_named
from kane.numeric.newton import improved
from kane.numeric.projection import least_squares, of_unit_length, row_sizes
from kane.numeric.scale import LAST_DIGIT

_ROUNDS = 4
"""Steps at most."""
_GROUPS = ("q", "u", "parameters", "inputs", "states")


@dataclass(frozen=True, slots=True, eq=False)
class OperatingPoint(Attributes):
    """Values by symbol: `kn.simulate(eom, span, **point.arguments)`, `kn.linearize(eom, **point.arguments)`.

    A time t other than 0 is among them: what is linearized or evaluated is so at t, and a span must begin there.
    """

    q: dict[Symbol, float]
    u: dict[Symbol, float]
    parameters: dict[Symbol, float]
    inputs: dict[Symbol, float]
    t: float
    states: dict[Symbol, float] = field(default_factory=dict)

    @property
    def arguments(self) -> dict[str, Any]:
        """What `simulate`, `linearize` and `Equations.evaluate` take: q, u, parameters, inputs; t where it is not 0, states if any."""
        at: dict[str, Any] = {"t": self.t} if self.t else {}
        if self.states:
            at["states"] = self.states
        return {"q": self.q, "u": self.u, "parameters": self.parameters, "inputs": self.inputs, **at}

    def replace(self, *, t: float | None = None, **groups: Mapping[Any, float]) -> "OperatingPoint":
        """The point with some values changed, by symbol or name: `point.replace(inputs={"T": 2}, parameters={m: 1.5})`.

        It need not be an operating point any more: what takes it checks it.
        """
        strange = groups.keys() - set(_GROUPS)
        if strange:
            raise ValueMissingError(f"Expected some of {', '.join(_GROUPS)}, t to replace, got {', '.join(strange)}.")
        made: list[dict[Symbol, float]] = []
        for kind in _GROUPS:
            own: dict[Symbol, float] = getattr(self, kind)
            told = named_values(kind, tuple(own), groups.get(kind))
            made.append({s: finite_number("value", s.name, told.get(s, v)) for s, v in own.items()})
        q, u, parameters, inputs, states = made
        at = self.t if t is None else finite_number("time", "the point", t)
        return OperatingPoint(q, u, parameters, inputs, at, states)

    def __getitem__(self, what: Any) -> float:
        values = {**self.q, **self.u, **self.states, **self.parameters, **self.inputs}
        return values[symbol_named(values, what)]

    def __repr__(self) -> str:
        values = ", ".join(
            f"{s} = {v:.6g}" for s, v in (*self.q.items(), *self.u.items(), *self.states.items(), *self.inputs.items())
        )
        return f"OperatingPoint({values}{f'; t = {self.t:g}' if self.t else ''})"


def point_of(eom: Equations, state: State) -> OperatingPoint:
    """The state by symbol."""
    q, u, a = np.split(state.x, np.cumsum([len(eom.coordinates), len(eom.speeds)]))
    return OperatingPoint(
        dict(zip(eom.coordinates, q.tolist(), strict=True)),
        dict(zip(eom.speeds, u.tolist(), strict=True)),
        dict(zip(eom.parameters, state.p.tolist(), strict=True)),
        dict(zip(eom.inputs, state.r.tolist(), strict=True)),
        state.t,
        dict(zip(eom.states, a.tolist(), strict=True)),
    )


def state_at(
    numeric: Numeric[Equations],
    q: Any,
    u: Any,
    parameters: Mapping[Any, Any] | None,
    inputs: Mapping[Any, Any] | None,
    t: float,
    states: Any = None,
) -> State:
    """The state at a point on the constraints; what is left out is solved for."""
    eom = numeric.equations
    constants = parameter_values(eom.system, parameters)
    p = np.array([constants[s] for s in eom.parameters])
    values = named_values("inputs", eom.inputs, inputs)
    r = np.array([finite_number("value", s.name, values.get(s, 0.0)) for s in eom.inputs])
    if u is None and not eom.constraints.constraints:
        u = np.zeros(len(eom.speeds))
    if eom.constraints.constraints and (
        entries("coordinates", eom.coordinates, q).free or entries("speeds", eom.speeds, u).free
    ):
        start = assemble(
            eom, q=q, u=u, parameters=parameters, inputs=dict(zip(eom.inputs, r.tolist(), strict=True)), t=t
        )
        q, u = start.q, start.u
    return closed(numeric, State(float(t), start_state(eom, q, u, states), p, r))


def closed(numeric: Numeric[Equations], state: State) -> State:
    """The state moved onto the constraints by rounding's worth; further off is an error."""
    eom, perturbed, values = numeric.equations, numeric.value(perturbations), values_at(numeric, state)
    nq, n = len(eom.coordinates), len(eom.speeds)
    check_configuration(
        eom,
        values.configuration,
        values.configuration_terms,
        state.given(eom),
        "an operating point",
        "Assemble one first, kn.assemble(eom, q=…, u=…), leave some values out to have them solved for, or find one with kn.trim.",
    )
    check_branch(eom, state.x[:nq], state.given(eom), "an operating point", "")
    zero = np.zeros(values.right.shape)

    def closer(at: tuple[Array, Values]) -> tuple[Array, Values]:
        x, now = at
        g = slopes_at(numeric, replace(state, x=x), zero).configuration[:, :nq]
        t = spread(perturbed, x[:nq])
        x = np.append(x[:nq] - t @ least_squares(g @ t, now.configuration), x[nq:])
        return x, values_at(numeric, replace(state, x=x))

    start = of_unit_length(state.x, perturbed.sets), values
    size = row_sizes(values.matrix[:n, :n], values.constraints(n)[: len(values.configuration)])
    limit = LAST_DIGIT * (values.configuration_terms / size).max(initial=0)
    x, values = improved(start, lambda at: np.abs(at[1].configuration / size).max(initial=0), closer, limit, _ROUNDS)
    if values.motion.any():
        eom.evaluate(
            list(eom.speeds), **point_of(eom, replace(state, x=x)).arguments
        )  # says which constraints they miss
    if len(values.motion):
        x = x.copy()
        x[nq : nq + n] -= least_squares(values.constraints(n), values.motion)
    return replace(state, x=x)

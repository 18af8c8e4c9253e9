# SPDX-License-Identifier: BSD-3-Clause
"""Further states beside q and u, each with its rate: ȧ = f(q, u, a, t, parameters, inputs)."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from kane.errors import ModelError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Rate, Reaction, StateVariable, Symbol, input_of
from kane.model.declarations import Declarations
from kane.model.survey import geometry
from kane.space.vector import Dyadic, Vector


def state_rates(states: Any) -> dict[StateVariable, Expr]:
    """The rate of each further state; a ModelError says what is no state, or no rate of one.

    Accelerations and reactions are refused in rates: they would have to be solved for first.
    """
    if not isinstance(states, Mapping):
        raise ModelError(
            f"Expected states= to be a dict {{a: rate, …}}, got {cut(repr(states))}. Give each state its rate: {{a: (e - a)/tau}}."
        )
    rates: dict[StateVariable, Expr] = {}
    for a, given in states.items():
        if not isinstance(a, StateVariable):
            raise ModelError(
                f"Expected states from kn.state as keys of states=, got {cut(repr(a))} ({type(a).__name__}). Declare one: "
                'a = kn.state("a").'
            )
        if isinstance(given, Vector | Dyadic):
            raise ModelError(
                f"Expected a scalar as the rate of the state {a}, got {cut(given)}. Use .dot(unit vector)."
            )
        rates[a] = as_expr(given)
        for s in free_symbols([rates[a]]):
            _check_known(a, s)
    return rates


def _check_known(a: StateVariable, s: Symbol) -> None:
    if isinstance(s, Rate) and isinstance(s.place, StateVariable):
        what, cure = f"the rate {s}", f"Write out what states= says of {s.place}"
    elif isinstance(s, Reaction | AuxiliarySpeed):
        what, cure = f"{s} ({type(s).__name__})", "Write what the reaction follows from, or a load in its place"
    elif isinstance(s, Rate) and input_of(s) is None and not isinstance(s.place, Coordinate):
        what, cure = (
            f"the acceleration {s}",
            "Take a state whose rate holds the speed in its place: a high-pass filter is the speed minus a low-pass filter of it",
        )
    else:
        return
    raise ModelError(
        f"Expected the rate of the state {a} in coordinates, rates, speeds, states, parameters, inputs and time, got {what}, which is "
        f"not known before the equations are solved. {cure}."
    )


def check_states(system: Declarations, symbols: Iterable[Symbol]) -> None:
    """Every state has a rate; nothing by which motions are described depends on one."""
    for s in symbols:
        origin: Any = s.place if isinstance(s, Rate) else s
        if not isinstance(origin, StateVariable):
            continue
        if origin not in system.states:
            raise ModelError(
                f"Expected a rate for the state {origin}, got none. Say it: System(states={{{origin}: …}}), an expression of "
                "coordinates, speeds, states, parameters, inputs and time."
            )
        if origin is not s:
            raise ModelError(
                f"Expected loads and events in states themselves, got the rate {s}. Write out what states= says of {origin}."
            )
    for kind, exprs in _STILL.items():
        found = [s for s in free_symbols(exprs(system)) if isinstance(s, StateVariable)]
        if found:
            raise ModelError(
                f"Expected {kind} without states, got {found[0]} in them. States act by loads: a servo turns a joint by a torque that "
                "follows from its state."
            )


_STILL: Mapping[str, Callable[[Declarations], Iterable[Expr]]] = {
    "positions and orientations": lambda system: geometry(system.frames, system.points),
    "definitions of speeds": lambda system: system.speeds.values(),
    "constraints": lambda system: [c.expr for c in system.constraints],
}
"""What no state may be in, by its name."""

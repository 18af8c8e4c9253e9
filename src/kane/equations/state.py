# SPDX-License-Identifier: BSD-3-Clause
"""`State`: the values of (q, u, a), parameters, inputs and time at which equations are evaluated, solved, linearized and started."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypedDict, Unpack

import numpy as np

from kane import expect
from kane.errors import ArgumentError, Attributes, ValueMissingError, cut
from kane.expr.symbols import Parameter, Symbol, time
from kane.numeric.sampling import finite_number, named_values, stands_for_zeros, symbol_named

GROUPS = {"q": "coordinates", "u": "speeds", "states": "states", "inputs": "inputs", "parameters": "parameters"}
"""The groups of values, by what `Equations` call their symbols."""


class StateValues(TypedDict, total=False):
    """The same and the time by keyword, in place of a `State`."""

    q: Any
    u: Any
    states: Any
    parameters: Mapping[Any, Any] | None
    inputs: Mapping[Any, Any] | None
    t: Any


by_keyword = expect.keywords(*StateValues.__annotations__)
"""What shows these keywords of a function."""


@dataclass(frozen=True, slots=True)
class Guess(Attributes):
    """An initial guess of a value to be solved for, from `kn.guess`."""

    value: float

    def __str__(self) -> str:
        return f"guess({self.value:.6g})"


def guess(value: float) -> Guess:
    """An initial guess in place of a fixed value: `q={q1: 1.2, q2: kn.guess(-1)}`; it also selects the branch of a closed loop."""
    return Guess(finite_number("guess", "assembly", value))


@dataclass(frozen=True, slots=True, eq=False)
class State(Attributes):
    """Values of coordinates, speeds, further states, parameters and inputs at a time t.

    Functions with the keywords `q=`, `u=`, `states=`, `parameters=`, `inputs=` and `t=` accept a State instead:
    `kn.linearize(eom, state)`, `eom.evaluate(e, state)`, `kn.simulate(eom, span, start=state)`. A group left out of the State
    counts as a keyword left out; functions ignore groups that they do not need. `kn.trim`, `kn.equilibrium` and
    `kn.analysis.continuation` return complete States, by symbol.

    Attributes
    ----------
    q, u, states : coordinates, speeds and further states, by symbol or name, or as a sequence in the order of the equations; 0
        sets all to zero. `kn.guess(value)` is an initial guess; arrays hold many states
    parameters, inputs : values by symbol or name; where a motion starts, an input may also have the law that it follows
    t : the time (s); a simulation must start at this time unless it is 0
    """

    q: Any = None
    u: Any = None
    states: Any = field(default=None, kw_only=True)
    parameters: Any = field(default=None, kw_only=True)
    inputs: Any = field(default=None, kw_only=True)
    t: Any = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        for kind in GROUPS:
            group = getattr(self, kind)
            listed = _has_length(group) and not isinstance(group, str | set)
            right = group is None or listed or stands_for_zeros(kind, group)
            expected = f"{kind}= of a state as a dict {{symbol or name: value}} or as a sequence"
            expect.that(right, expected, group, error=ArgumentError)

    @property
    def arguments(self) -> dict[str, Any]:
        """The values as a dict of keyword arguments: q, u, parameters, inputs; t unless it is 0; states if given."""
        rest = {"t": self.t} if _is_later(self.t) else {}
        if _given(self.states):
            rest["states"] = self.states
        return {"q": self.q, "u": self.u, "parameters": self.parameters, "inputs": self.inputs, **rest}

    @property
    def in_order(self) -> tuple[Any, Any, Any, Any, Any, Any]:
        """The values as a tuple (q, u, parameters, inputs, t, states)."""
        return self.q, self.u, self.parameters, self.inputs, self.t, self.states

    def replace(self, *, t: float | None = None, **groups: Mapping[Any, Any]) -> "State":
        """A copy of the state with some values changed, by symbol or name: `state.replace(inputs={"T": 2}, parameters={m: 1.5})`.

        The copy of a steady motion is not, in general, a steady motion; functions that need one check it.
        """
        strange = groups.keys() - set(GROUPS)
        expect.none(strange, f"some of {', '.join(GROUPS)}, t to replace", error=ValueMissingError)
        made = {kind: _replaced(kind, getattr(self, kind), groups.get(kind)) for kind in GROUPS}
        return State(**made, t=self.t if t is None else finite_number("time", "the state", t))

    def __getitem__(self, what: Any) -> Any:
        groups = [group for kind in GROUPS if isinstance(group := getattr(self, kind), Mapping)]
        values = {key: value for group in groups for key, value in group.items()}
        keys = {key.name if isinstance(key, Symbol) else key: key for key in values}
        key = keys.get(what.name if isinstance(what, Symbol) else what)
        if key is None or not (key is what or isinstance(key, str) or isinstance(what, str)):
            key = symbol_named([key for key in values if isinstance(key, Symbol)], what)
        return values[key]

    def __repr__(self) -> str:
        parts = []
        for kind in ("q", "u", "states", "inputs"):
            group = getattr(self, kind)
            if isinstance(group, Mapping):
                parts += [f"{key} = {_shown(value)}" for key, value in group.items()]
            elif group is not None:
                listed = _has_length(group)
                parts.append(f"{kind} = [{', '.join(map(_shown, group))}]" if listed else f"{kind} = {_shown(group)}")
        return f"State({', '.join(parts)}{f'; t = {_shown(self.t)}' if _is_later(self.t) else ''})"


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float | int) else cut(value)


def _is_later(t: Any) -> bool:
    """Whether a time is given, and not 0."""
    return bool(t != 0) if isinstance(t, float | int | np.number | np.ndarray) and np.ndim(t) == 0 else _given(t)


def _has_length(value: Any) -> bool:
    """Whether values are several, or a mapping; an array of no dimension is one."""
    return hasattr(value, "__len__") and getattr(value, "ndim", 1) > 0


def _given(value: Any) -> bool:
    """Whether a group of values is more than left out."""
    return value is not None and (not _has_length(value) or len(value) > 0)


def _replaced(kind: str, old: Any, new: Any) -> Any:
    """A group with some of its values replaced."""
    if new is None or not _given(old) or not isinstance(new, Mapping):
        return old if new is None else new
    if not isinstance(old, Mapping):
        if _has_length(old) and len(new) >= len(old):
            return new
        raise ValueMissingError(
            f"Expected a state with {kind} given by name to replace some of them, got {cut(repr(old))}. Give all of them, "
            f"{kind}=[…], or a state by names."
        )
    if not all(isinstance(key, Symbol) for key in old):
        names = {key.name if isinstance(key, Symbol) else key: key for key in old}
        keys = {key: key.name if isinstance(key, Symbol) else key for key in new}
        return {**old, **{names.get(name, key): new[key] for key, name in keys.items()}}
    values = named_values(kind, tuple(old), new)
    if kind == "parameters":  # those by symbol that the state has none of, which `named_values` passes over
        values |= {s: v for s, v in new.items() if isinstance(s, Parameter) and s not in values}
    return {**old, **{s: v if _is_law(kind, v) else finite_number("value", str(s), v) for s, v in values.items()}}


def _is_law(kind: str, value: Any) -> bool:
    """Whether a value is none yet: one to be solved for, or what an input follows along a motion."""
    plain = value is None or isinstance(value, str | bytes | int | float | complex | np.generic | np.ndarray)
    return isinstance(value, Guess) or (kind == "inputs" and not plain)


def state_of(state: State | None, **values: Unpack[StateValues]) -> State:
    """The state that a function is given, as one or by keywords.

    Raises
    ------
    ArgumentError
        if it is no State, or a group of values comes both ways
    """
    strange = values.keys() - StateValues.__annotations__.keys()
    if strange:
        known = ", ".join(StateValues.__annotations__)
        raise TypeError(f"Expected options of the function, and values by {known}, got the keyword {min(strange)!r}.")
    own = {kind: x for kind, x in values.items() if (x is not None if kind == "t" else _given(x))}
    if state is None:
        return State(**{**values, "t": own.get("t", 0.0)})
    cure = "Give kn.State(q={…}, u={…}), or q=, u=, …."
    given = expect.instance(state, State, "a kn.State, or values by keyword", cure, error=ArgumentError)
    twice = [kind for kind in own if (_is_later if kind == "t" else _given)(getattr(given, kind))]
    if twice:
        raise ArgumentError(
            f"Expected values of {', '.join(twice)} in the state or by keyword, got both. Change those of the state: "
            f"state.replace({twice[0]}={'…' if twice[0] == 't' else '{…}'})."
        )
    return State(**{kind: getattr(given, kind) for kind in (*GROUPS, "t")} | own)


def columns_of(eom: Any, table: Any) -> dict[str, dict[Any, Any]]:
    """What a Dataset holds of the symbols of equations, by kind; the time as "t", by its symbol."""
    symbols = {kind: getattr(eom, what) for kind, what in GROUPS.items()} | {"t": (time,)}
    return {
        kind: {s: table[s.name].to_numpy()[()] for s in listed if s.name in table.variables}
        for kind, listed in symbols.items()
    }


OperatingPoint = State
"""The former name of `State`."""

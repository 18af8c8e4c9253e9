# SPDX-License-Identifier: BSD-3-Clause
"""Results of many motions: arrays that are filled tile by tile, as one xarray Dataset over (instance, t)."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kane import expect
from kane.dynamics.readings.quantities import asked
from kane.equations.equations import Equations
from kane.equations.instances import STARTS, Instances, labelled, package
from kane.errors import SimulationError, cut
from kane.expr.node import Expr
from kane.expr.symbols import Input, Symbol
from kane.motion.many.tiles import Outcome, Tile
from kane.motion.solution.phases import Indices
from kane.motion.solution.solution import Solution
from kane.motion.solution.tables import named
from kane.numeric.arrays import Array

Reduction = Callable[[Array], Any]


def _last(values: Array) -> Array:
    """The last finite value along t."""
    at = np.isfinite(values).cumsum(axis=0).argmax(axis=0)
    result: Array = np.take_along_axis(values, at[None], axis=0)[0]
    return result


def _mean(values: Array) -> Array:
    count = np.isfinite(values).sum(axis=0)
    return np.where(count > 0, np.nansum(values, axis=0) / np.maximum(count, 1), np.nan)


REDUCTIONS: Mapping[str, Reduction] = {
    "last": _last,
    "max": lambda values: np.fmax.reduce(values, axis=0),
    "min": lambda values: np.fmin.reduce(values, axis=0),
    "mean": _mean,
}
"""Reductions of values along t (n × …), by name; samples beyond the end of a motion are NaN and are ignored."""
CARRIED: Collection[Reduction | None] = (None, REDUCTIONS["last"], REDUCTIONS["mean"])
"""Reductions that commute with differentiation."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedQuantity:
    """A quantity recorded of each motion: an expression, vector or name, its unit and description, and a reduction over t.

    `dims` are the names of its further dimensions, if they are not the default ones.
    """

    name: str
    what: Any
    unit: str
    description: str
    reduce: Reduction | None
    dims: tuple[str, ...] = ()

    def shape(self, eom: Equations, samples: int) -> tuple[int, ...]:
        """The shape of the values of one instance.

        Raises
        ------
        SimulationError
            if the reduction fails for zeros
        """
        wanted = asked(eom.derived, self.what)
        values = np.asarray(wanted.filled([np.zeros(samples)] * len(wanted.roots)))
        if self.reduce is None:
            return values.shape
        try:
            return np.asarray(self.reduce(values), dtype=float).shape
        except Exception as error:
            raise SimulationError(
                f"Expected a function as reduce= of {self.name!r} that accepts any numbers (samples × …), as it is called "
                f"with zeros to find the shape of its result, got {type(error).__name__}: {cut(str(error), 200)}. Let it "
                "return NaN where there is no value."
            ) from error


def quantities(eom: Equations, outputs: Mapping[str, Any] | None, reduce: Any) -> list[RecordedQuantity]:
    """The quantities named in `outputs`, by default coordinates, speeds and further states.

    Raises
    ------
    ArgumentError
        if outputs are not a dict of names
    SimulationError
        if a reduction is unknown
    """
    if outputs is None:
        found = [(s.name, s, eom.unit(s), s.description) for s in eom.state]
    else:
        found = [
            (name, what, eom.unit(what) if isinstance(what, Expr) else "", "") for name, what in named(outputs).items()
        ]
    names = [name for name, *_ in found]
    if isinstance(reduce, Mapping):
        for name in reduce:
            expect.one_of(name, names, "reduce= to name outputs,", error=SimulationError)
        return [RecordedQuantity(*one, _reduction(reduce[one[0]]) if one[0] in reduce else None) for one in found]
    one = None if reduce is None else _reduction(reduce)
    return [RecordedQuantity(*row, one) for row in found]


def check_names(kept: Sequence[RecordedQuantity], many: Instances) -> None:
    """Raises SimulationError if a recorded quantity has the name of another variable or coordinate of the Dataset."""
    taken = {*_TOLD, *_ENDS, "instance", "t", "state", "axis", "by", *(_label(kind, s) for kind, s, _ in many.varied)}
    cure = "Give it another name, outputs={name: …}."
    told = f"outputs whose names are not those of other variables ({', '.join(sorted(taken))})"
    expect.none([one.name for one in kept if one.name in taken], told, cure=cure, error=SimulationError)


def _label(kind: str, s: Any) -> str:
    """The name of the coordinate of a quantity that differs."""
    return f"{s}(0)" if kind in STARTS else str(s)


def _reduction(given: Any) -> Reduction:
    if callable(given):
        own: Reduction = given
        return own
    cure = "Or give a function of the values along t."
    return REDUCTIONS[expect.one_of(given, REDUCTIONS, "reduce= to be", cure, error=SimulationError)]


class _Texts:
    """A text for each of n instances, initially empty; equal texts are stored once."""

    def __init__(self, n: int) -> None:
        self.numbers = {"": 0}
        self.which = np.zeros(n, dtype=np.int64)

    def put(self, places: int | Indices, text: str) -> None:
        """Sets the text of one or several instances."""
        self.which[places] = self.numbers.setdefault(text, len(self.numbers))

    def array(self) -> Any:
        """The texts (n)."""
        longest = max((text for text, k in self.numbers.items() if k in self.which), key=len, default="")
        return np.array([*self.numbers]).astype(f"U{max(1, len(longest))}")[self.which]


class Results:
    """Results of all instances or of `rows`, NaN where not available (yet): recorded quantities over t, and how each motion ended."""

    def __init__(
        self,
        eom: Equations,
        kept: Sequence[RecordedQuantity],
        t: Array,
        instances: Instances,
        rows: range | None = None,
    ) -> None:
        self.eom, self.kept, self.t, self.instances = eom, kept, t, instances
        self.rows = range(instances.count) if rows is None else rows
        n = len(self.rows)
        self.columns: dict[Symbol, int] = {s: k for k, s in enumerate(eom.state)}
        self.usual = np.arange(len(t))
        self.done = 0
        self.values: dict[str, Array] = {}
        self.texts = {name: _Texts(n) for name in ("status", "cause", "event", "warning")}
        self.steps = np.zeros(n, dtype=np.int64)
        self.end_t, self.end_state = np.full(n, np.nan), np.full((n, len(eom.state)), np.nan)

    def put(self, found: Tile) -> None:
        """Stores the outcomes of a tile."""
        for k, one in found.outcomes.items():
            self._note(k - self.rows.start, one)
        motions = {k - self.rows.start: one.found for k, one in found.outcomes.items() if one.found is not None}
        if motions:
            self._keep_all(list(motions), _together([*motions.values()]), *self._sample_indices([*motions.values()]))
        for places, steps, table in found.finished:
            which = np.asarray(places) - self.rows.start
            self.texts["status"].put(which, table.status)
            self.texts["cause"].put(which, table.message)
            ends = np.arange(1, len(which) + 1) * len(self.t) - 1
            self.steps[which], self.end_t[which], self.end_state[which] = steps, table.t[-1], table.states[ends]
            self._keep_all(which, table)
        self.done += len(found.outcomes) + sum(len(own.instances) for own in found.finished)

    def _keep_all(self, which: Sequence[int] | Indices, table: Solution, at: Any = None, there: Any = None) -> None:
        """Records instances whose motions are one table; `at` are the rows of their samples, `there` whether these exist."""
        for quantity in self.kept:
            column = self.columns.get(quantity.what) if isinstance(quantity.what, Symbol) else None
            values = np.asarray(table[quantity.what]) if column is None else table.states[:, column]
            values = values.reshape(len(which), -1, *values.shape[1:]) if at is None else values[at]
            if there is not None:
                values[~there] = np.nan
            self._keep(quantity, which, values)

    def _sample_indices(self, motions: Sequence[Solution]) -> tuple[Any, Any]:
        """The rows of each motion's samples at the times t in the joint table, after actions, and whether there is such a sample."""
        at, there, first = (
            np.empty((len(motions), len(self.t)), dtype=np.int64),
            np.ones((len(motions), len(self.t)), dtype=bool),
            0,
        )
        for k, motion in enumerate(motions):
            if np.array_equal(motion.t, self.t):
                at[k] = self.usual
            else:
                at[k] = np.maximum(np.searchsorted(motion.t, self.t, side="right") - 1, 0)
                there[k] = motion.t[at[k]] == self.t
            at[k] += first
            first += len(motion)
        return at, there

    def _note(self, k: int, one: Outcome[Solution]) -> None:
        motion = one.found
        told = {"status": "failed", "cause": one.error, "event": ""}
        if motion is not None:
            told = {
                "status": motion.status,
                "cause": motion.message,
                "event": motion.event.name if motion.event else "",
            }
            self.steps[k], self.end_t[k], self.end_state[k] = motion.steps, motion.t[-1], motion.states[-1]
        for name, text in (told | {"warning": "; ".join(dict.fromkeys(one.told))}).items():
            self.texts[name].put(k, text)

    def _keep(self, one: RecordedQuantity, places: Sequence[int] | Indices, values: Array) -> None:
        """Stores the values of instances along t (instances × t × …), or their reductions."""
        kept = values if one.reduce is None else np.array([one.reduce(row) for row in values], dtype=float)
        if one.name not in self.values:
            self.values[one.name] = np.full((len(self.rows), *kept.shape[1:]), np.nan)
        self.values[one.name][places] = kept

    def dataset(self, facts: Mapping[str, Any]) -> Any:
        """The Dataset, with `facts` as its attributes."""
        own = self.variables()
        return package("xarray").Dataset(
            own, coordinates(self.eom, self.t, self.instances, self.rows, own), dict(facts)
        )

    def variables(self) -> dict[str, Any]:
        """The variables of the Dataset by name."""
        xarray = package("xarray")
        own: dict[str, Any] = {}
        for one in self.kept:
            values = self.values.get(one.name)
            if values is None:
                values = np.full((len(self.rows), *one.shape(self.eom, len(self.t))), np.nan)
            first = ["instance"] if one.reduce else ["instance", "t"]
            own[one.name] = labelled(xarray, one.name, values, first, one.unit, one.description, one.dims)
        own |= {
            name: xarray.Variable("instance", texts.array(), {"long_name": _TOLD[name]})
            for name, texts in self.texts.items()
        }
        own["steps"] = xarray.Variable("instance", self.steps, {"long_name": "steps"})
        own["end_t"] = xarray.Variable("instance", self.end_t, {"units": "s", "long_name": "time of the last state"})
        own["end_state"] = xarray.Variable(("instance", "state"), self.end_state, {"long_name": "last state"})
        return own


def coordinates(eom: Equations, t: Array, many: Instances, rows: range, variables: Mapping[str, Any]) -> dict[str, Any]:
    """The coordinates of the Dataset by name, for the instances `rows`."""
    xarray = package("xarray")
    result = {
        "instance": xarray.Variable("instance", np.arange(rows.start, rows.stop)),
        "t": xarray.Variable("t", t, {"units": "s", "long_name": "time"}),
        "state": xarray.Variable("state", np.array([s.name for s in eom.state])),
    }
    if any("axis" in v.dims for v in variables.values()):
        result["axis"] = xarray.Variable("axis", np.array(["x", "y", "z"]))
    for kind, s, column in many.varied:
        what = _VARIED["inputs" if isinstance(s.place, Input) else kind]
        told = {"units": eom.unit(s), "long_name": s.description or f"{what} {s}"}
        values = column[rows.start : rows.stop]
        result[_label(kind, s)] = xarray.Variable("instance", values, {key: text for key, text in told.items() if text})
    return result


_TOLD = {
    "status": "finished, event, stopped, or failed at the start",
    "cause": "the reason for which the motion ended or did not start",
    "event": "the event that ended the motion",
    "warning": "the warnings during the motion",
}
_ENDS = ("steps", "end_t", "end_state")
_VARIED = dict.fromkeys(STARTS, "start value of") | {"parameters": "parameter", "inputs": "input"}


def _together(motions: Sequence[Solution]) -> Solution:
    """Motions of several instances as one table with separate phases, so that an expression is evaluated once for all."""
    first = motions[0]
    if len(motions) == 1:
        return first
    offsets = np.cumsum([0, *(len(m.phases) for m in motions)])
    numbers = [m.phase + offset for m, offset in zip(motions, offsets.tolist(), strict=False)]
    several = any(m.samples for m in motions)
    return replace(
        first,
        t=np.concatenate([m.t for m in motions]),
        states=np.concatenate([m.states for m in motions]),
        work=np.concatenate([m.work for m in motions]),
        samples=tuple(eom for m in motions for eom in m.samples or (m.equations,) * len(m)) if several else (),
        phases=tuple(phase for m in motions for phase in m.phases),
        phase=np.concatenate(numbers),
    )

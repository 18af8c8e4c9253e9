# SPDX-License-Identifier: BSD-3-Clause
"""The phases of a motion, each with its own values of parameters and inputs, and the joining of successive motions."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.errors import SimulationError
from kane.expr.node import Expr
from kane.model.declarations import Event
from kane.motion.inputs.expressions import Formula, HeldInput, with_value
from kane.motion.inputs.functions import constant
from kane.numeric.arrays import Array
from kane.numeric.scale import SAME_TIME

Indices = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Phase:
    """A part of a motion: the values of its parameters, its inputs, and the events whose actions began it."""

    parameters: Mapping[Expr, float]
    inputs: Mapping[Expr, Callable[[Any], Any]]
    by: tuple[Event, ...] = ()

    def at(self, values: Mapping[Expr, Any]) -> "Phase":
        """The same with other values of parameters, also within its inputs; those left out keep theirs."""
        return replace(
            self,
            parameters={s: values.get(s, v) for s, v in self.parameters.items()},
            inputs={s: with_value(f, values) for s, f in self.inputs.items()},
        )

    def same(self, other: "Phase") -> bool:
        """Whether a later phase has the same parameters and inputs."""
        return self.parameters == other.parameters and all(
            same_drive(f, other.inputs.get(s)) for s, f in self.inputs.items()
        )


@dataclass(frozen=True, slots=True, eq=False)
class Jump:
    """A jump of the state, at an event or where motions are joined: a phase starts with other values than the last one ended with.

    Attributes
    ----------
    t : time (s)
    events : the events whose actions caused the jump
    changes : coordinates, speeds and parameters that changed, each with its values before and after
    energy : change of the kinetic and potential energy (J)
    """

    t: float
    events: tuple[Event, ...]
    changes: Mapping[Expr, tuple[float, float]]
    energy: float

    def __repr__(self) -> str:
        names = ", ".join(e.name for e in self.events) or "start="
        told = ", ".join(f"{s}: {a:.6g} → {b:.6g}" for s, (a, b) in self.changes.items())
        return f"Jump({names} at t = {self.t:.6g} s: {told or 'nothing'}; energy {self.energy:+.4g} J)"


def same_drive(f: Any, g: Any) -> bool:
    """Whether the input g continues f; a sampled controller may have more samples in g."""
    if isinstance(f, Formula) and isinstance(g, Formula):
        return f.expr is g.expr and f.values == g.values
    if isinstance(f, HeldInput) and isinstance(g, HeldInput):
        count = len(f.group.times)
        same = f.group.controller is g.group.controller and f.place == g.place
        return same and g.group.times[:count] == f.group.times
    return f is g or (constant(f) is not None and g is not None and constant(f) == constant(g))


def leaps(values: Array, begins: Indices) -> Array:
    """The sum (n) of the jumps of values (n) up to each sample, where phases begin at the samples `begins`."""
    steps = np.zeros_like(values)
    steps[begins] = values[begins] - values[begins - 1]
    return np.cumsum(steps)


def check_follows(first: Any, second: Any) -> None:
    """A SimulationError unless `second` is a motion of the same equations that begins where `first` ends."""
    if second.equations.derived is not first.equations.derived:
        raise SimulationError(
            "Expected motions of the same equations to join, got motions of different ones. Simulate both with one eom = "
            "kn.derive(system), or load both with it; motions of different systems cannot be joined."
        )
    end, begin = float(first.t[-1]), float(second.t[0])
    if abs(end - begin) > SAME_TIME * max(abs(end), abs(begin), np.ptp(second.t), np.ptp(first.t)):
        raise SimulationError(
            f"Expected a motion that begins at t = {end:.9g}, where the first one ends, got one from {begin:.9g}. Continue "
            f"from there: kn.simulate(eom, ({end:.9g}, …), start=sol), or join them in their order."
        )


def merged(phases: Sequence[Phase], of: Indices) -> Phase:
    """Phases with the same inputs as one; parameters that differ have a value for each sample; `of` (n) are the samples' phases."""
    own = np.flatnonzero(np.bincount(of)).tolist()
    given = [phases[k].parameters for k in own]
    values: dict[Expr, Any] = {}
    for s, value in given[0].items():
        column = [parameters[s] for parameters in given if s in parameters]
        if len(column) == len(given):
            differs = column.count(value) < len(column)
            values[s] = np.array(column)[np.searchsorted(own, of)] if differs else value
    whole: Phase = replace(phases[own[0]], parameters=values)
    return whole


def joined(pieces: Sequence[Any]) -> Any:
    """The Solution that consists of several, each of which begins where the previous one ends.

    If nothing changes between two, their common instant is one sample, else two, before and after the change.
    """
    first, last = pieces[0], pieces[-1]
    phases, numbers, kept = list(first.phases), [first.phase], [slice(0, None)]
    done = [first.work]
    for before, piece in pairwise(pieces):
        own = piece.phases
        goes_on = phases[-1].same(own[0]) and not own[0].by and _unmoved(before, piece)
        kept.append(slice(int(goes_on), None))
        numbers.append(piece.phase + len(phases) - int(goes_on))
        if goes_on:
            phases[-1] = replace(own[0], by=phases[-1].by)
        phases += own[int(goes_on) :]
        done.append(piece.work + (done[-1][-1] - piece.work[0]))
    several = any(p.segments for p in pieces)
    samples = [p.samples or (p.equations,) * len(p.t) for p in pieces]

    def whole(parts: Sequence[Any]) -> Any:
        return np.concatenate([part[at] for part, at in zip(parts, kept, strict=True)])

    return replace(
        first,
        t=whole([p.t for p in pieces]),
        states=whole([p.states for p in pieces]),
        work=whole(done),
        phase=whole(numbers),
        phases=tuple(phases),
        status=last.status,
        message=last.message,
        event=last.event,
        events=tuple(pair for p in pieces for pair in p.events),
        steps=sum(p.steps for p in pieces),
        evaluations=sum(p.evaluations for p in pieces),
        segments=tuple(s for p in pieces for s in p.segments),
        samples=tuple(one for part, at in zip(samples, kept, strict=True) for one in part[at]) if several else (),
        rtol=max(p.rtol for p in pieces),
        atol=max(p.atol for p in pieces),
        method=", ".join(dict.fromkeys(name for p in pieces for name in p.method.split(", "))),
        _again=Parts(tuple(pieces)) if all(p._again is not None for p in pieces) else None,
        _options=last._options,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """A function that repeats a joined motion: each of its parts, at the times within it."""

    pieces: tuple[Any, ...]

    def __call__(self, motion: Any, samples: Array) -> Any:
        """The joined motion, sampled at these times."""
        found = []
        for piece in self.pieces:
            own = samples[(samples >= piece.t[0]) & (samples <= piece.t[-1])]
            found.append(piece._again(piece, samples=own if own.size else piece.t[:1]))
        return joined(found)


def _unmoved(first: Any, second: Any) -> bool:
    """Whether a motion begins at the final state of the previous one, up to tolerances: projection may have changed it."""
    end, begin = first.states[-1], second.states[0]
    return bool(np.all(np.abs(begin - end) <= second.atol + second.rtol * np.abs(end)))

# SPDX-License-Identifier: BSD-3-Clause
"""The frozen result of a simulation."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from kane import show
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.lazy import LazyMapping
from kane.dynamics.readings.asked import asked
from kane.dynamics.readings.joint_reactions import Place, unsolved
from kane.dynamics.readings.values import evaluate_along
from kane.equations.derive import repartition
from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.expr.evaluate import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Reaction
from kane.model.constraints import Constraint
from kane.model.declarations import Event
from kane.model.loads import Load
from kane.motion import tables
from kane.motion.accuracy import Accuracy, accuracy
from kane.motion.checking import Drift, checking_functions, drifts
from kane.motion.contents import contents, some
from kane.motion.energy import EnergyCheck, energy_check
from kane.motion.feedback import along
from kane.motion.files import write
from kane.motion.works import work_of
from kane.numeric.arrays import Array, Mask
from kane.space.frame import Frame

_SOME = 101
_FEW = 25
"""At as many samples, at most, it is asked what tolerances mean for the energy."""


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """From time `start` on, the motion was stepped with `equations`, which differ in their dependent speeds."""

    start: float
    equations: Equations


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """The values of an input at the samples of a motion: what a file or a pickle keeps of its function."""

    name: str
    t: Array
    values: Array

    def __call__(self, t: Any) -> Any:
        """The value at a sample's time."""
        k = np.searchsorted(self.t, t)
        if k < len(self.t) and self.t[k] == t:
            return self.values[k]
        raise SimulationError(
            f"Expected a time among the samples for the input {self.name} of a motion that was saved or pickled, got t = {t:.6g}: of "
            "its function the values there were kept. Simulate again with the function."
        )


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """A motion: `t` (n), `states` (n × (coordinates + speeds + further states)), and `work` (n), the integral of the power.

    `sol[expression]` evaluates anything along it: an expression (n), a vector (n × 3, along the inertial frame), a reaction, a
    name, a list of these. `status` is "finished", "event" or "stopped"; `message` says why it ended, `event` which event ended it,
    `events` all that were met and their times. `segments` are the equations it was stepped with, `samples` for each time those whose
    dependent speeds are determined there: accelerations and reactions are read off these. Where the constraints lose rank, reactions
    have no value (NaN). `method` is the one that ran: where it was "auto", the one that was chosen.
    """

    equations: Equations
    t: Array
    states: Array
    work: Array
    parameters: Mapping[Expr, float]
    inputs: Mapping[Expr, Callable[[Any], Any]]
    status: str
    message: str
    event: Event | None
    events: tuple[tuple[Event, float], ...]
    steps: int
    evaluations: int
    segments: tuple[Segment, ...] = ()
    samples: tuple[Equations, ...] = ()
    rtol: float = 1.0
    atol: float = 0.0
    method: str = ""
    _again: Callable[..., Any] | None = None

    def __reduce__(self) -> tuple[Callable[..., "Solution"], tuple[Any, ...]]:
        """Equations are derived again where a pickle is read; of the inputs their values at the samples stay."""
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        kept = list(dict.fromkeys([self.equations, *(s.equations for s in self.segments), *self.samples]))
        place = {eom: k for k, eom in enumerate(kept)}
        own["inputs"] = {s: Recorded(str(s), self.t, along(f, self.t, self.states)) for s, f in self.inputs.items()}
        own["segments"] = [(s.start, place[s.equations]) for s in self.segments]
        own["_again"] = None
        own["samples"] = [place[eom] for eom in self.samples]
        partitions = [eom.embedding and eom.embedding.partition for eom in kept]
        return _restored, (own.pop("equations"), partitions, own)

    @property
    def q(self) -> Array:
        """Coordinates, n × nq."""
        return self.states[:, : len(self.equations.coordinates)]

    @property
    def u(self) -> Array:
        """Generalized speeds, n × nu."""
        nq = len(self.equations.coordinates)
        return self.states[:, nq : nq + len(self.equations.speeds)]

    @property
    def a(self) -> Array:
        """Further states, n × as many as there are."""
        return self.states[:, len(self.equations.state) - len(self.equations.states) :]

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, what: Any) -> Any:
        wanted = asked(self.equations.derived, what)
        return wanted.filled(self._values(list(wanted.roots)))

    def reaction(self, place: Place, frame: Frame | None = None) -> tuple[Array | None, Array]:
        """Force and torque (each n × 3, along `frame`, by default the inertial one) at a place, by name or as `eom.reaction` takes it.

        They are what the near side exerts on the far side, the torque about the far side's point. Of a frame the force is None.
        """
        target = self.equations.system.inertial if frame is None else frame

        def components(eom: Equations) -> list[Expr]:
            exerted = unsolved(eom.solved, place)
            vectors = [v for v in (exerted.force, exerted.torque) if v is not None]
            return [x for v in vectors for x in v.components(target)]

        table = np.stack(self.by_sample(components), axis=-1)
        table[self.lost] = np.nan
        return (table[:, :3] if table.shape[1] == 6 else None), table[:, -3:]

    def _values(self, exprs: Any) -> list[Array]:
        tables = self.by_sample(lambda eom: exprs)
        for e, values in zip(exprs, tables, strict=True):
            if any(isinstance(s, Reaction) for s in free_symbols([e])):
                values[self.lost] = np.nan
        return tables

    @cached_property
    def lost(self) -> Mask:
        """Samples at which the constraints determine fewer speeds than elsewhere."""
        ranks = np.array([len(eom.dependent_speeds) for eom in self.samples or (self.equations,) * len(self)])
        return np.asarray(ranks < max(ranks.max(initial=0), len(self.equations.dependent_speeds)))

    def by_sample(self, exprs: Callable[[Equations], Any]) -> list[Array]:
        """Values (n each) of the expressions that `exprs` makes of the equations that hold at each sample."""
        places: dict[Equations, list[int]] = {}
        for k, eom in enumerate(self.samples or (self.equations,) * len(self)):
            places.setdefault(eom, []).append(k)
        parts = [(at, self._along(eom, exprs(eom), self.t[at], self.states[at])) for eom, at in places.items()]
        tables = [np.empty(len(self)) for _ in parts[0][1]]
        for at, values in parts:
            for whole, part in zip(tables, values, strict=True):
                whole[at] = part
        return tables

    def _along(self, eom: Equations, exprs: Any, t: Array, states: Array) -> list[Array]:
        """Values (n each) of expressions at times (n) and states (n × (coordinates + speeds + further states))."""
        q, u, a = np.split(states.T, np.cumsum([len(eom.coordinates), len(eom.speeds)]))
        inputs = {s: along(f, t, states) for s, f in self.inputs.items()}
        values = evaluate_along(eom.solved, exprs, list(q), list(u), self.parameters, inputs, t, list(a), held=False)
        return [np.broadcast_to(v, t.shape) for v in values]

    def rates(self) -> Array:
        """(q̇, u̇, ȧ) along the motion, n × (coordinates + speeds + further states)."""
        return np.stack(self.by_sample(lambda eom: eom.right_hand_side), axis=-1)

    def save(self, path: Any) -> None:
        """Write the motion to a file that `kn.load_solution(path, eom)` reads: .npz, or .zarr where the package zarr is installed.

        It holds numbers and names and nothing that is executed; of inputs their values at the samples. It is written beside its
        place and then renamed: at no time there is a part of a file.

        Raises
        ------
        SolutionFileError
            if the name ends otherwise, or there is no such folder
        """
        write(path, contents(self, lambda at: np.asarray(some(self, at).rates())))

    def accuracy(self) -> Accuracy:
        """The errors of coordinates and speeds, estimated by the same motion at a tenth of the tolerances, or at half the steps.

        It takes somewhat longer than the motion took.

        Raises
        ------
        SimulationError
            if the motion was read from a file or a pickle, or a tenth of its tolerances is less than rounding
        """
        return accuracy(self, self._again)

    def to_dataframe(self, outputs: Mapping[str, Any] | None = None) -> Any:
        """A DataFrame of pandas over t: coordinates, speeds, inputs, and the expressions that `outputs` names.

        Vectors have a column for each component along the inertial frame, "v.x", "v.y", "v.z". `attrs["units"]` has the unit
        of every column, `attrs` the parameters and how the motion ended.
        """
        return tables.dataframe(self, outputs)

    def to_xarray(self, outputs: Mapping[str, Any] | None = None) -> Any:
        """A Dataset of xarray over t: coordinates, speeds, inputs, and the expressions that `outputs` names, with units.

        Vectors have the dimension "axis" beside "t". `attrs` has the parameters and how the motion ended.
        """
        return tables.dataset(self, outputs)

    @cached_property
    def constraint_residuals(self) -> Mapping[Constraint, Array]:
        """What is left of each constraint along the motion: f of a configuration constraint, (A u + b) of a motion constraint."""
        derived = self.equations.derived
        constraints = derived.constraints.constraints
        pairs = zip(constraints, derived.constraint_rates, strict=True)
        roots = [c.expr if c.kind == "configuration" else rate for c, rate in pairs]
        return dict(zip(constraints, self._values(roots) if roots else [], strict=True))

    @cached_property
    def energy(self) -> Array:
        """E = K + V along the motion."""
        return self._values([self.equations.energy])[0]

    @cached_property
    def energy_check(self) -> EnergyCheck:
        """E − ∫P dt must stay constant; see EnergyCheck."""
        kinetic, total = self._values([self.equations.kinetic_energy, self.equations.energy])
        return energy_check(self.t, kinetic, total, self.work, self._open() / self.rtol)

    def checking_functions(self, functions: Sequence[Any] | None = None) -> tuple[Drift, ...]:
        """How far integrals of the equations went from their values at the start; those of `eom.integrals` if left out.

        An integral, or any expression that should be constant, may be in the list (Kane & Levinson 1985, sec. 7.3).
        """
        wanted = self.equations.integrals if functions is None else functions
        return drifts(self.t, checking_functions(self.equations.derived, wanted), self._values)

    @cached_property
    def load_works(self) -> Mapping[Load, Array]:
        """The work of each load since the start (n), by the load or its name: −ΔV where it has a potential, else ∫ (Σ F·v + Σ T·ω) dt.

        The power is a cubic spline between samples: where loads jump, take samples close to each other.
        """
        eom = self.equations
        meant = dict(zip((*eom.system.gravities, *eom.system.loads), eom.loads, strict=True))
        return LazyMapping(
            eom.loads, lambda load: work_of(load, eom.load_powers[load], self.t, lambda e: self._values(list(e))), meant
        )

    @property
    def keeps_energy(self) -> bool:
        """Whether the energy check passes by its own limit; where a few samples show it, the others are not asked."""
        at = np.unique(np.linspace(0, len(self) - 1, min(len(self), _SOME)).astype(int))
        few = replace(self, t=self.t[at], states=self.states[at], work=self.work[at], samples=())
        kinetic, total = few._values([self.equations.kinetic_energy, self.equations.energy])
        sure = energy_check(few.t, kinetic, total, few.work, np.zeros(len(at)))
        return sure.sharply(self.rtol) or not self.energy_check.exceeds(self.rtol)

    def _open(self) -> Array:
        """Σ |E(x ± atol eᵢ) − E(x)| over x = (q, u), computed at a few of the samples."""
        at = np.unique(np.linspace(0, len(self) - 1, min(len(self), _FEW)).astype(int))
        width = self.states.shape[1]
        shifts = self.atol * np.concatenate([np.zeros((1, width)), np.eye(width), -np.eye(width)])
        x = (self.states[at] + shifts[:, None, :]).reshape(-1, width)
        (energy,) = self._along(self.equations, [self.equations.energy], np.tile(self.t[at], len(shifts)), x)
        table = energy.reshape(len(shifts), -1)
        up, down = np.split(np.abs(table[1:] - table[0]), 2)
        return np.asarray(np.interp(np.arange(len(self)), at, np.maximum(up, down).sum(axis=0)))

    _repr_html_ = show.html

    def __repr__(self) -> str:
        return (
            f"Solution(t = {self.t[0]:g} … {self.t[-1]:g}, {len(self.t)} samples, {self.steps} steps; {self.status}: "
            f"{self.message})"
        )


def _restored(first: Equations, partitions: Sequence[Partition | None], own: dict[str, Any]) -> Solution:
    """A solution that was pickled; `first` are its equations, the others differ from them by their partitions."""
    others = [repartition(first, p) for p in partitions[1:] if p is not None]
    equations = [first, *others]
    own["segments"] = tuple(Segment(start, equations[k]) for start, k in own["segments"])
    own["samples"] = tuple(equations[k] for k in own["samples"])
    return Solution(first, **own)

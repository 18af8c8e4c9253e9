# SPDX-License-Identifier: BSD-3-Clause
"""The frozen result of a simulation."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from kane import show
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.lazy import LazyMapping
from kane.dynamics.readings.joint_reactions import Place, unsolved
from kane.dynamics.readings.quantities import asked, evaluate_along
from kane.equations.equations import Equations
from kane.equations.mode_equations import equations_in
from kane.errors import ArgumentError, Attributes
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Reaction
from kane.model.constraints import Constraint
from kane.model.contact_modes import in_mode
from kane.model.contacts import Modes
from kane.model.declarations import Event
from kane.model.loads import Load
from kane.motion.inputs.expressions import along, gains_of, with_value
from kane.motion.inputs.functions import recorded
from kane.motion.right_hand_side import sides
from kane.motion.solution.accuracy import REPEATED, Accuracy, accuracy, between
from kane.motion.solution.checks import (
    FEW,
    Drift,
    EnergyCheck,
    by_runs,
    checking_functions,
    drifts,
    energy_check,
    integral,
    opened,
    surely_keeps,
    work_of,
)
from kane.motion.solution.files import contents, write
from kane.motion.solution.phases import Indices, Jump, Phase, check_follows, joined, leaps, merged
from kane.motion.solution.tables import dataframe, dataset
from kane.numeric.arrays import Array, Mask, distinct
from kane.numeric.scale import EQUAL
from kane.space.frame import Frame
from kane.whole import path_of

_ROWS = "Samples are the rows of sol.q, sol.u and sol.states, at the times sol.t; len(sol) is how many there are."
_SOME = 101


@dataclass(frozen=True, slots=True, eq=False)
class SolutionSegment:
    """From time `start` on, the motion was integrated with `equations`; those of other segments have other dependent speeds."""

    start: float
    equations: Equations


@dataclass(frozen=True, eq=False, repr=False)
class Solution(Attributes):
    """A motion: times `t` (n), `states` (n × (coordinates + speeds + further states)), and `work` (n), the integral of the power.

    `sol[expression]` evaluates an expression (n), a vector (n × 3, along the inertial axes), a reaction, a name, or a list of
    these along the motion. `status` is "finished", "event" or "stopped"; `message` gives the reason for the end, `event` the event
    that ended the motion, `events` all events with their times. `method` is the integrator used, also if it was chosen by "auto".
    `segments` are the equations that were integrated, one after the other, with their choices of dependent speeds, `samples` those
    used to evaluate accelerations and reactions at each time. Reactions are NaN where the constraints lose rank.

    A motion has several `phases` if events change the state, or if motions were joined; `phase` (n) is the number of the phase of
    each sample. Where a phase begins, two samples have the same time, before and after, and `jumps` describes the change.
    `parameters` and `inputs` are those at the start.
    """

    _other_names = MappingProxyType(
        {
            "states": "y x",
            "t": "time",
            "at": "sol",
            "status": "success",
            "evaluations": "nfev",
            "events": "t_events",
            "jumps": "y_events",
            "parameters": "params",
            "energy": "E",
            "to_dataframe": "to_csv to_pandas dataframe",
        }
    )

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
    segments: tuple[SolutionSegment, ...] = ()
    samples: tuple[Equations, ...] = ()
    rtol: float = 1.0
    atol: float = 0.0
    method: str = ""
    phases: tuple[Phase, ...] = ()
    phase: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    _again: Callable[..., Any] | None = None
    _options: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        if not self.phases:
            object.__setattr__(self, "phases", (Phase(self.parameters, self.inputs),))
            object.__setattr__(self, "phase", np.zeros(len(self.t), dtype=np.int64))

    def __reduce__(self) -> tuple[Callable[..., "Solution"], tuple[Any, ...]]:
        """A pickle stores inputs by their values at the samples; equations are derived again when it is read."""
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        kept = list(dict.fromkeys([self.equations, *(s.equations for s in self.segments), *self.samples]))
        place = {eom: k for k, eom in enumerate(kept)}
        own["inputs"] = self._recorded(0)
        own["phases"] = tuple(Phase(p.parameters, self._recorded(k), p.by) for k, p in enumerate(self.phases))
        own["segments"] = [(s.start, place[s.equations]) for s in self.segments]
        own["_again"] = own["_options"] = None
        own["samples"] = [place[eom] for eom in self.samples]
        partitions = [(eom.system.modes, eom.embedding and eom.embedding.partition) for eom in kept]
        return _restored, (own.pop("equations"), partitions, own)

    def __add__(self, other: Any) -> "Solution":
        """The motion joined with one that continues from its end.

        Raises
        ------
        SimulationError
            if the other motion has other equations, or begins at another time
        """
        if not isinstance(other, Solution):
            return NotImplemented
        check_follows(self, other)
        whole: Solution = joined([self, other])
        return whole

    @property
    def q(self) -> Array:
        """Coordinates (n × nq), in the order of `sol.equations.coordinates`."""
        return self.states[:, : len(self.equations.coordinates)]

    @property
    def u(self) -> Array:
        """Generalized speeds (n × nu), in the order of `sol.equations.speeds`."""
        nq = len(self.equations.coordinates)
        return self.states[:, nq : nq + len(self.equations.speeds)]

    @property
    def a(self) -> Array:
        """Further states (n × na), in the order of `sol.equations.states`."""
        return self.states[:, len(self.equations.state) - len(self.equations.states) :]

    def __len__(self) -> int:
        return len(self.t)

    def __iter__(self) -> NoReturn:
        raise ArgumentError(f"Expected symbols, names or expressions in sol[…], got an iteration. {_ROWS}")

    def __getitem__(self, what: Any) -> Any:
        if isinstance(what, (int, float, np.number, slice)):
            raise ArgumentError(f"Expected symbols, names or expressions in sol[…], got {what!r}. {_ROWS}")
        wanted = asked(self.equations.derived, what)
        return wanted.filled(self._values(list(wanted.roots)))

    def reaction(self, place: Place, frame: Frame | None = None) -> tuple[Array | None, Array]:
        """Force (N) and torque (N m) along the motion, each (n × 3), at a joint, point, frame or constraint, as for `eom.reaction`.

        The near side (towards the root of the tree) exerts them on the far side; the torque is about the point of the far side.
        The vectors are written along `frame`, by default the inertial frame. For a frame as `place` the force is None.
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

    def _energies(self, exprs: Callable[[Equations], list[Expr]]) -> list[Array]:
        """Values of expressions; by the equations valid at each sample if W of the first ones may have a pole there."""
        poles = any(eom.solved.twin is not None for eom in (self.equations, *self.samples))
        return self.by_sample(exprs) if poles else self._values(exprs(self.equations))

    @cached_property
    def lost(self) -> Mask:
        """Which samples (n) are at a loss of rank, where the constraints determine fewer speeds than elsewhere."""
        every = self.samples or (self.equations,) * len(self)
        most: dict[Any, int] = {}
        for eom in (self.equations, *every):
            most[eom.derived] = max(most.get(eom.derived, 0), len(eom.dependent_speeds))
        return np.array([len(eom.dependent_speeds) < most[eom.derived] for eom in every], dtype=bool)

    def by_sample(self, exprs: Callable[[Equations], Any]) -> list[Array]:
        """Values (n each) of expressions that `exprs(equations)` returns for the equations valid at each sample."""
        found: dict[Equations, int] = {}
        inputs = {key: k for k, key in enumerate(dict.fromkeys(id(phase.inputs) for phase in self.phases))}
        whose = np.array([inputs[id(phase.inputs)] for phase in self.phases])[self.phase]
        every = self.samples or (self.equations,)
        number = np.array([found.setdefault(eom, len(found)) for eom in every]) * len(inputs) + whose
        equations = list(found)
        places = [(equations[k // len(inputs)], np.flatnonzero(number == k)) for k in distinct(number).tolist()]
        parts = [(at, self._along(eom, merged(self.phases, self.phase[at]), exprs(eom), at)) for eom, at in places]
        tables = [np.empty(len(self)) for _ in parts[0][1]]
        for at, values in parts:
            for whole, part in zip(tables, values, strict=True):
                whole[at] = part
        return tables

    def _along(self, eom: Equations, phase: Phase, exprs: Any, at: Indices) -> list[Array]:
        """Values (n each) of expressions at samples of a phase, whose parameters may have a value for each."""
        t, states = self.t[at], self.states[at]
        q, u, a = np.split(states.T, np.cumsum([len(eom.coordinates), len(eom.speeds)]))
        drives = {s: with_value(f, phase.parameters) for s, f in phase.inputs.items()}
        inputs = {s: along(f, t, states) for s, f in drives.items()}
        exprs = in_mode(eom.system.contacts, eom.system.modes, exprs)
        others = gains_of(drives.values())
        values = evaluate_along(
            eom.solved, exprs, list(q), list(u), phase.parameters, inputs, t, list(a), held=False, others=others
        )
        return [np.broadcast_to(v, t.shape) for v in values]

    def rates(self) -> Array:
        """Rates (q̇, u̇, ȧ) along the motion (n × (coordinates + speeds + further states))."""
        return np.stack(self.by_sample(lambda eom: eom.right_hand_side), axis=-1)

    def save(self, path: Any) -> None:
        """Write the motion to a file that `kn.load_solution(path, eom)` reads: .npz, or .zarr if the package zarr is installed.

        The file contains numbers and names, no executable code; inputs are stored by their values at the samples. It is written
        completely before it replaces an existing file, which must be a solution.

        Raises
        ------
        SolutionFileError
            if the name has a different ending, the folder does not exist, or the path is that of another file than a solution
        ArgumentError
            if `path` is not a path
        """
        write(path_of(path, 'sol.save("run.npz")'), contents(self))

    def at(self, times: Any) -> "Solution":
        """The motion at a time (s), or at increasing times, between its samples, with the same accuracy.

        The integration is repeated, in about the original time, and its interpolation polynomials (dense output) are evaluated. At
        the beginning of a phase the values are those after the jump.

        Raises
        ------
        SimulationError
            if the motion was read from a pickle, or from a file with functions as inputs, or a time is outside the motion
        """
        result: Solution = between(self, self._again, times)
        return result

    def accuracy(self, *, method: str = REPEATED) -> Accuracy:
        """Estimate the errors of coordinates and speeds by a second motion at a tenth of the tolerances, or half the step size.

        This takes somewhat longer than the motion itself. Errors common to both motions are not seen, and where errors do not
        decrease with the tolerances, the estimate may be a tenth of the true error or less.

        `method="variational"` integrates from each sample to the next at a thousandth of the tolerances (down to 3e-14), and
        propagates the defects of the motion by the variational equations. It needs no second motion, works at any tolerances, and
        has an accuracy of some percent while errors are small enough to add linearly. Beyond, as in a chaotic motion, it gives the
        linear estimate. Rounding errors, 1e-14 per sample, are not resolved, and errors of the times of events not included. It
        runs in Python, many times as long as the motion.

        Raises
        ------
        SimulationError
            if the motion was read from a pickle, or from a file with functions as inputs, or was joined; if a tenth of its
            tolerances is below rounding; with "variational", if states or loads jump during the motion, the constraints lose rank,
            or an input is a sampled controller
        """
        return accuracy(self, self._again, method)

    def to_dataframe(self, outputs: Mapping[str, Any] | None = None) -> Any:
        """The motion as a pandas DataFrame over t: coordinates, speeds, inputs, and `outputs`, {name: expression}.

        A vector v has a column for each component along the inertial axes, "v.x", "v.y", "v.z". `attrs["units"]` holds the unit of
        each column; `attrs` also holds the parameters and the reason for the end of the motion.
        """
        return dataframe(self, outputs)

    def to_xarray(self, outputs: Mapping[str, Any] | None = None) -> Any:
        """The motion as an xarray Dataset over t: coordinates, speeds, inputs, and `outputs`, {name: expression}, with units.

        Vectors have the dimensions "t" and "axis". `attrs` holds the parameters and the reason for the end of the motion.
        """
        return dataset(self, outputs)

    @cached_property
    def constraint_residuals(self) -> Mapping[Constraint, Array]:
        """Residual (n) of each constraint along the motion: f of a configuration constraint, A u + b of a motion constraint."""
        derived = self.equations.derived
        constraints = derived.constraints.constraints
        pairs = zip(constraints, derived.constraint_rates, strict=True)
        roots = [c.expr if c.kind == "configuration" else rate for c, rate in pairs]
        return dict(zip(constraints, self._values(roots) if roots else [], strict=True))

    @cached_property
    def regimes(self) -> Mapping[str, Any]:
        """The side of each discontinuity at each sample (n): for a switch in a load, such as "sign(v)", the sign of its argument.

        For the loads of `kn.friction` and `kn.loads.dry_friction`, by name, 1 while sliding, 0 at and below the threshold of slip.
        """
        return sides(self)

    @cached_property
    def modes(self) -> Mapping[str, npt.NDArray[np.str_]]:
        """The mode of each contact at each sample (n), by its name: "separated", "stick" or "slip"; "closed" without friction."""
        every = self.samples or (self.equations,) * len(self)
        contacts = self.equations.system.contacts
        rows = {
            eom: [m.word(c) for m, c in zip(eom.system.modes, contacts, strict=False)] for eom in dict.fromkeys(every)
        }
        names = [c.name for c in contacts]
        return {name: np.array([(rows[eom] or [""] * len(names))[k] for eom in every]) for k, name in enumerate(names)}

    @cached_property
    def mode_history(self) -> tuple[tuple[float, Mapping[str, str]], ...]:
        """Pairs of a time (s) and the modes of all contacts from then on, by name: at the start, and at each change of a mode."""
        found: list[tuple[float, Mapping[str, str]]] = []
        for k, t in enumerate(self.t.tolist()):
            now = {name: str(words[k]) for name, words in self.modes.items()}
            if now and (not found or now != found[-1][1]):
                found.append((t, now))
        return tuple(found)

    @cached_property
    def energy(self) -> Array:
        """Total energy E = K + V (n) along the motion."""
        return self._energies(lambda eom: [eom.energy])[0]

    @cached_property
    def power(self) -> Array:
        """Power P (n) of the loads without potential along the motion, friction of contacts included."""
        own = bool(self.equations.system.contacts)
        return self.by_sample(lambda eom: [eom.power])[0] if own else self._values([self.equations.power])[0]

    @cached_property
    def energy_check(self) -> EnergyCheck:
        """The energy balance: how constant E − ∫P dt is along the motion; see EnergyCheck.

        ∫P dt, integrated with the state, has errors up to `atol` in J a step, at most ∫|P| dt; they may exceed all energies.
        If they may be why the balance does not hold, it is that with the integral of P between samples, by cubic splines, where this
        is more constant.
        """

        def terms(eom: Equations) -> list[Expr]:
            powers = [eom.load_powers[load] for load in eom.loads if load.potential is None]
            return [eom.kinetic_energy, eom.energy, *powers]

        kinetic, total, *own = self._energies(terms)
        open_ = self._open() / self.rtol

        def found(work: Array) -> EnergyCheck:
            return energy_check(self.t, kinetic, total, work + leaps(total, self.begins), open_, own)

        check = found(self.work)
        if check.exceeds(self.rtol) and check.drift <= self.steps * self.atol:
            done, most = (by_runs(self.t, p, self._runs, integral) for p in (self.power, np.abs(self.power)))
            by_samples = found(done)
            check = by_samples if check.drift <= most[-1] and by_samples.relative < check.relative else check
        return check

    @cached_property
    def energy_drift(self) -> Array:
        """E − ∫P dt (n) less its initial value and less the jumps of energy between phases: zero for an exact motion."""
        done = self.work + leaps(self.energy, self.begins)
        return np.asarray((self.energy - self.energy[0]) - (done - done[0]))

    @cached_property
    def jumps(self) -> tuple[Jump, ...]:
        """The jumps of the state where phases begin, with the change of energy of each."""
        symbols = self.equations.state
        found = []
        for k in self.begins.tolist():
            old, new = self.phases[self.phase[k - 1]], self.phases[self.phase[k]]
            pairs = dict(
                zip(symbols, zip(self.states[k - 1].tolist(), self.states[k].tolist(), strict=True), strict=True)
            )
            changes: dict[Expr, tuple[float, float]] = {s: (a, b) for s, (a, b) in pairs.items() if a != b}
            values = ((p, old.parameters[p], new.parameters[p]) for p in self.parameters)
            changes |= {p: (a, b) for p, a, b in values if a != b}
            if all(e.then is None for e in new.by) and not self._leaps(k):
                continue  # a contact changes its mode without a jump
            found.append(Jump(float(self.t[k]), new.by, changes, float(self.energy[k] - self.energy[k - 1])))
        return tuple(found)

    def _leaps(self, k: int) -> bool:
        """Whether the state at sample k differs from the previous one by more than tolerances, or no event began its phase."""
        before, after = self.states[k - 1], self.states[k]
        size = np.maximum(np.abs(before), np.abs(after))
        near = self.atol + max(self.rtol, EQUAL) * size  # of a slip that ends ten digits are left
        return bool(np.any(np.abs(after - before) > near)) or not self.phases[self.phase[k]].by

    @property
    def _runs(self) -> list[Indices]:
        """Indices of the samples of each phase."""
        return np.split(np.arange(len(self)), self.begins)

    @property
    def begins(self) -> Indices:
        """Indices of the first samples of all phases but the first."""
        return np.flatnonzero(np.diff(self.phase)) + 1

    def _recorded(self, number: int) -> dict[Expr, Callable[[Any], Any]]:
        """The inputs of a phase in the form that files and pickles store."""
        at = np.flatnonzero(self.phase == number)
        return {s: recorded(str(s), f, self.t[at], self.states[at]) for s, f in self.phases[number].inputs.items()}

    def checking_functions(self, functions: Sequence[Any] | None = None) -> tuple[Drift, ...]:
        """The drift of integrals of the equations from their initial values, by default of `eom.integrals`.

        `functions` may contain integrals and any expressions that should be constant (Kane & Levinson 1985, sec. 7.3).
        """
        wanted = self.equations.integrals if functions is None else functions
        return drifts(self.t, checking_functions(self.equations.derived, wanted), self._values, self.begins)

    @cached_property
    def load_works(self) -> Mapping[Load, Array]:
        """Work of each load since the start (n), by the load or its name: −ΔV if it has a potential, else ∫ (Σ F·v + Σ T·ω) dt.

        The power is interpolated between samples by a cubic spline; for loads that jump, use closely spaced samples.
        """
        eom = self.equations
        meant = dict(zip((*eom.system.gravities, *eom.system.loads), eom.loads, strict=True))
        return LazyMapping(
            eom.loads,
            lambda load: work_of(load, eom.load_powers[load], self.t, lambda e: self._values(list(e)), self._runs),
            meant,
        )

    @property
    def keeps_energy(self) -> bool:
        """Whether the energy balance is within its limit."""
        at = distinct(np.concatenate([some_of(len(self)), self.begins, self.begins - 1]))
        few = self._only(at)
        kinetic, total = few._energies(lambda eom: [eom.kinetic_energy, eom.energy])
        work, whole = few.work + leaps(total, few.begins), len(at) == len(self)
        sure = surely_keeps(few.t, kinetic, total, work, self.rtol, whole)
        return sure or not self.energy_check.exceeds(self.rtol)

    def _only(self, at: Indices) -> "Solution":
        """The motion at some of its samples."""
        samples = tuple(self.samples[k] for k in at) if self.samples else ()
        return replace(
            self, t=self.t[at], states=self.states[at], work=self.work[at], samples=samples, phase=self.phase[at]
        )

    def _open(self) -> Array:
        """Σ |E(x ± atol eᵢ) − E(x)| over x = (q, u), computed at a few of the samples."""
        at = distinct(np.linspace(0, len(self) - 1, min(len(self), FEW)).astype(int))
        width = self.states.shape[1]
        shifts = self.atol * np.concatenate([np.zeros((1, width)), np.eye(width), -np.eye(width)])
        few = self._only(np.tile(at, len(shifts)))
        x = (self.states[at] + shifts[:, None, :]).reshape(-1, width)
        table = replace(few, states=x).energy.reshape(len(shifts), -1)
        return np.asarray(np.interp(np.arange(len(self)), at, opened(table)))

    _repr_html_ = show.html

    def __repr__(self) -> str:
        return (
            f"Solution(t = {self.t[0]:g} … {self.t[-1]:g}, {len(self.t)} samples, {self.steps} steps; {self.status}: "
            f"{self.message})"
        )


def some_of(count: int) -> Indices:
    """Indices of at most `_SOME` evenly spaced samples out of `count`, at which the energy balance is checked first."""
    return np.linspace(0, count - 1, min(count, _SOME)).astype(int)


def _restored(first: Equations, partitions: Sequence[tuple[Modes, Partition | None]], own: dict[str, Any]) -> Solution:
    """The solution in a pickle; `first` are its equations, from which the others differ by modes and partitions."""
    equations = [first, *(equations_in(first, *pair) for pair in partitions[1:])]
    own["segments"] = tuple(SolutionSegment(start, equations[k]) for start, k in own["segments"])
    own["samples"] = tuple(equations[k] for k in own["samples"])
    return Solution(first, **own)

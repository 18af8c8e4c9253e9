# SPDX-License-Identifier: BSD-3-Clause
"""`sensitivities`: the exact derivatives of a motion by parameters and start values, at every sample."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from kane import expect
from kane.analysis.assembly import assemble
from kane.analysis.state_checks import start_state
from kane.dynamics.readings.quantities import asked, parameter_values, without_unknowns
from kane.equations.equations import Equations, check_equations
from kane.equations.state import Guess, State, StateValues, by_keyword, state_of
from kane.errors import Attributes, ExpressionError, SimulationError
from kane.expr.differentiation import gradient
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol
from kane.expr.visit import substituted
from kane.model.contact_modes import in_mode
from kane.motion.derivatives.return_map import ReturnMap
from kane.motion.derivatives.tangents import allowed, basis_of, flow_of
from kane.motion.derivatives.variation import Differential
from kane.motion.inputs.expressions import Formula
from kane.motion.solution.solution import Solution
from kane.motion.start import check_span, check_tolerance
from kane.numeric.arrays import Array
from kane.numeric.sampling import named_values, symbols_named
from kane.numeric.scale import SIX_DIGITS
from kane.program.native.machine import Settings
from kane.progress import working


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities(Attributes):
    """∂x/∂b of a motion, at the times of its samples.

    `s[expression]` is the derivative of anything along the motion by all of b: (n × k) of an expression or name, (n × 3 × k) of a
    vector. Where events change the state two samples have one time, and the derivatives before and after differ by the saltation
    matrix.

    Attributes
    ----------
    motion : Solution
    by : b (k), parameters, and coordinates, speeds or further states, which stand for their start values
    states : ∂(q, u, a)/∂b (n × states × k)
    """

    motion: Solution
    by: tuple[Symbol, ...]
    states: Array

    @property
    def t(self) -> Array:
        """The times (n)."""
        return self.motion.t

    def __getitem__(self, what: Any) -> Array:
        motion = self.motion
        wanted = asked(motion.equations.derived, what)
        if wanted.shape is None:
            raise ExpressionError(
                "Expected expressions of one kind in s[…], got a list of several: ask for one after the other."
            )
        found = np.array([self._of(e) for e in wanted.roots])
        return np.moveaxis(found, 0, 1).reshape(len(motion), *wanted.shape, len(self.by))

    def _of(self, expr: Expr) -> Array:
        """dexpr/db (n × k)."""
        motion, n = self.motion, self.states.shape[1]
        whole = {s: f.whole for s, f in motion.inputs.items() if isinstance(f, Formula)}
        own = [p for p in self.by if isinstance(p, Parameter)]

        def slopes(eom: Equations) -> list[Expr]:
            (held,) = in_mode(eom.system.contacts, eom.system.modes, [expr])
            (plain,) = without_unknowns(eom.solved, [substituted(held, whole)])
            return list(gradient(substituted(plain, whole), [*eom.state, *own]))

        table = np.stack(motion.by_sample(slopes), axis=-1)
        found: Array = np.einsum("tn,tnk->tk", table[:, :n], self.states)
        found[:, [k for k, s in enumerate(self.by) if isinstance(s, Parameter)]] += table[:, n:]
        return found

    def __repr__(self) -> str:
        return f"Sensitivities(of {self.states.shape[1]} states by {', '.join(s.name for s in self.by)}, {len(self.t)} samples)"


@dataclass(frozen=True, eq=False)
class Course:
    """Motions over a span from a start that is assembled, and their derivatives by `by`: what `sensitivities` asks for once.

    `given` are the start values as they were told; those that are in `by` are numbers among them.
    """

    map: ReturnMap
    given: State
    by: tuple[Symbol, ...]

    @staticmethod
    def of(
        eom: Equations, span: Any, by: Any, given: State, tolerances: tuple[float, float], settings: Settings | None
    ) -> "Course":
        """Of the arguments as they were given."""
        check_equations(eom)
        start, end = check_span(span)
        for name, value in zip(("rtol", "atol"), tolerances, strict=True):
            check_tolerance(name, value)
        map_ = ReturnMap(eom, None, end - start, given.inputs, start, end - start, tolerances, settings)
        return Course(map_, given, _symbols(eom, given, by))

    @property
    def parameters(self) -> dict[Expr, Any]:
        """Values of all parameters, those that stand in inputs alone included where they were given."""
        eom, given = self.map.eom, dict(self.given.parameters or {})
        own = parameter_values(eom.system, {k: v for k, v in given.items() if not _foreign(eom, k)})
        return {**own, **{k: v for k, v in given.items() if _foreign(eom, k)}}

    @property
    def start(self) -> Array:
        """(q, u, a) at the start, on the constraints."""
        eom, q, u = self.map.eom, self.given.q, self.given.u
        if eom.constraints.constraints:
            own = {s: v for s, v in self.parameters.items() if s in set(eom.parameters)}
            found = assemble(eom, q=q, u=u, parameters=own, inputs=self.map.inputs_at_start, t=self.map.t0)
            q, u = found.q, found.u
        return start_state(eom, q, u, self.given.states)

    def motion(self, samples: Any, start: Array | None = None) -> Solution:
        """The motion."""
        return self.map.motion(self.start if start is None else start, self.parameters, samples)

    def sensitivities(self, motion: Solution) -> Sensitivities:
        """The derivatives at the samples of a motion."""
        own = tuple(s for s in self.by if isinstance(s, Parameter))
        walk = self.map.walk(own)
        free = [s for s in self.by if not isinstance(s, Parameter)]
        begin = _start_slopes(walk, motion, (free, _told(self.map.eom, self.given)), own)
        again = self.map.again(motion, self.parameters)
        found = walk.along(motion, again, begin)
        order = {s: k for k, s in enumerate((*free, *own))}
        return Sensitivities(motion, self.by, found[:, :, [order[s] for s in self.by]])


def _told(eom: Equations, given: State) -> list[Symbol]:
    """The start values that were given as numbers, no guesses."""
    found = list[Symbol]()
    for kind, group in (("q", eom.coordinates), ("u", eom.speeds)):
        own = getattr(given, kind)
        values = (
            named_values(kind, group, own)
            if isinstance(own, Mapping)
            else dict(zip(group, own if own is not None else (), strict=False))
        )
        found += [s for s in group if s in values and not isinstance(values[s], Guess)]
    return found


def _foreign(eom: Equations, key: Any) -> bool:
    """Whether it is a parameter of inputs alone."""
    return isinstance(key, Parameter) and key not in set(eom.parameters)


def _symbols(eom: Equations, given: State, by: Any) -> tuple[Symbol, ...]:
    """What is varied, in order, once each."""
    inputs = [e for e in dict(given.inputs or {}).values() if isinstance(e, Expr)]
    free = [s for s in free_symbols(inputs) if _foreign(eom, s)]
    own: tuple[Symbol, ...] = (*eom.state, *eom.parameters, *free)
    listed = [by] if isinstance(by, Symbol | str) else list(by)
    found = tuple(symbols_named("by", own, listed))
    expect.that(bool(found), "some parameters or start values to differentiate by", listed, error=SimulationError)
    twice = [name for name, count in Counter(s.name for s in found).items() if count > 1]
    expect.none(twice, "each one once", "{} twice", error=SimulationError)
    return found


def _start_slopes(
    walk: Differential, motion: Solution, starts: tuple[Sequence[Symbol], Sequence[Symbol]], by: Sequence[Parameter]
) -> Array:
    """δx of the start: by start values, and what constraints add to a change of parameters.

    Of the start values those by which the motion is differentiated are independent, then those that were given, then others, as many
    as the constraints leave; they stay where a parameter changes.
    """
    side, (free, told) = walk.side(motion, 0), starts
    eom, n = side.now.eom, side.now.width
    place = {s: i for i, s in enumerate(eom.state)}
    if not eom.system.euler_parameters and not eom.constraints.constraints:
        return np.hstack([np.eye(n)[:, [place[s] for s in free]], np.zeros((n, len(by)))])
    flow = flow_of(side)
    basis, names = basis_of(flow), {s.name: s for s in eom.state}
    kept = [place[s] for s in free]
    _check_independent(basis, kept, free, flow.states)
    sizes = np.abs(basis).max(axis=1)
    for i in (place[s] for s in (*told, *(names[name] for name in flow.states if name in names))):
        some = [*kept, i]
        if sizes[i] > 0 and np.linalg.matrix_rank(basis[some] / sizes[some, None], SIX_DIGITS) > len(kept):
            kept.append(i)
    rest = basis[kept]
    if len(kept) < basis.shape[1]:  # angles of Euler parameters
        angles = [j for j, name in enumerate(flow.states) if name not in names]
        rest = np.vstack([rest, np.eye(basis.shape[1])[angles]])
    own = np.linalg.solve(rest, np.eye(len(rest)))
    shifts = allowed(side, by)[2] if len(by) else np.zeros((n, 0))
    moved = shifts - basis @ own[:, : len(kept)] @ shifts[kept]
    return np.hstack([(basis @ own)[:, : len(free)], moved])


def _check_independent(basis: Array, kept: Sequence[int], free: Sequence[Symbol], names: Sequence[str]) -> None:
    if not kept:
        return
    sizes = np.abs(basis[kept]).max(axis=1)
    regular = (sizes > 0).all() and np.linalg.matrix_rank(basis[kept] / sizes[:, None], SIX_DIGITS) == len(kept)
    if not regular:
        raise SimulationError(
            f"Expected start values that constraints leave free, got {', '.join(s.name for s in free)}, of which some follow from the "
            f"others. Independent ones are {', '.join(names)}."
        )


@by_keyword
def sensitivities(
    eom: Equations,
    span: tuple[float, float],
    by: Sequence[Any],
    state: State | None = None,
    *,
    samples: int | Sequence[float] = 101,
    rtol: float = 1e-11,
    atol: float = 1e-11,
    settings: Settings | None = None,
    **by_kind: Unpack[StateValues],
) -> Sensitivities:
    """The derivatives of a motion by parameters and start values, at every sample.

    Between events they obey the variational equations Ψ′ = J Ψ + ∂f/∂b along the motion, which are stepped by collocation of order 16
    until nine digits stay; at events, modes of contacts and impacts they leap by saltation matrices.

    Parameters
    ----------
    eom : Equations
    span : (float, float)
        beginning and end (s)
    by : parameters, of the equations or of inputs that are expressions; coordinates, speeds or states for their start values. Under
        constraints the independent start values stay where a parameter changes, the others follow
    state : `kn.State` of the start, in place of q, u, states, parameters and inputs
    samples : how many, or at which times
    rtol, atol : tolerances of the motion. The derivatives are those of what was computed
    q, u, states, parameters, inputs : the start as `kn.simulate` takes it; under constraints it is assembled

    Returns
    -------
    Sensitivities
        `s.states` (samples × states × by), `s[expression]` (samples × by), `s.motion`

    Raises
    ------
    SimulationError
        if the motion has no derivative: it grazes an event, or meets two at one instant; or a rate jumps without one. If start values
        in `by` depend on each other

    Notes
    -----
    Aizerman, M. A., Gantmakher, F. R. (1958), On the stability of periodic motions, J. Appl. Math. Mech. 22, 1065–1078; Leine, R. I.,
    Nijmeijer, H. (2004), Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer, sec. 7.5.

    Examples
    --------
    >>> s = kn.fitting.sensitivities(eom, (0, 10), by=["k", "x"], q={"x": 0.1}, u=[0])
    >>> s["x"][-1]  # ∂x(10)/∂k, ∂x(10)/∂x(0)
    """
    with working("Differentiating the motion"):
        course = Course.of(eom, span, by, state_of(state, **by_kind), (rtol, atol), settings)
        return course.sensitivities(course.motion(samples))

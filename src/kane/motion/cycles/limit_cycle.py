# SPDX-License-Identifier: BSD-3-Clause
"""`limit_cycle`: a motion that comes back to its start, found by shooting, with its Floquet multipliers.

Newton's method on r(x) = P(x) − x, P the map to the section or over a period (Parker & Chua 1989, ch. 5). With T the changes of the start
that constraints allow, and D = ∂P/∂x by the variational equations and saltation matrices,

    (I − T⁺ D T) ξ = T⁺ r,      x ← x + T ξ

On a section D f = 0 along the flow f of the start: the trivial multiplier is 0 there in the place of 1, and I − D is regular.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Unpack

import numpy as np

from kane import expect
from kane.analysis.assembly import assemble
from kane.analysis.state_checks import start_state
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.equations import Equations, check_equations
from kane.equations.state import State, StateValues, by_keyword, guess, state_of
from kane.errors import Attributes, SimulationError
from kane.expr.node import Expr
from kane.expr.symbols import Parameter
from kane.motion.cycles.return_map import ReturnMap
from kane.motion.cycles.tangents import basis_of, flow_of
from kane.motion.cycles.variation import Differential
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array, Complex
from kane.numeric.sampling import symbols_named
from kane.numeric.scale import ROUNDED_CHAIN, SIX_DIGITS, SOLVED, STATE_RANK
from kane.program.native.machine import Settings
from kane.progress import far, working

_HALVINGS = 8
_SAMPLES = 501


@dataclass(frozen=True, eq=False, repr=False)
class LimitCycle(Attributes):
    """A motion that comes back to its start.

    Attributes
    ----------
    start : State
        where it begins, with the values of parameters; on a section whose event acts, after its action
    period : T (s)
    multipliers : Floquet multipliers (complex), by falling size, without the one that belongs to the flow of an autonomous cycle
    matrix : D (n × n) over `names`: the derivative of the map to the section, or the monodromy matrix over a period
    names : the independent perturbations of the start: coordinates, speeds, further states
    solution : Solution
        the motion over one period
    residual : what is left of P(x) − x, the largest share of the size of its component
    steps : Newton's steps
    """

    start: State
    period: float
    multipliers: Complex
    matrix: Array
    names: tuple[str, ...]
    solution: Solution
    residual: float
    steps: int
    map: ReturnMap
    x: Array
    cyclic: tuple[str, ...] = ()

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie within the unit circle: motions beside it come nearer."""
        return bool(np.all(np.abs(self.multipliers) < 1.0))

    @property
    def section(self) -> str | None:
        """The name of the event that is the section; None over a given period."""
        return None if self.map.section is None else self.map.section.name

    @cached_property
    def equations(self) -> Equations:
        """The equations, which watch the section."""
        return self.map.eom

    def __repr__(self) -> str:
        shown = ", ".join(_number(m) for m in self.multipliers[:6]) or "none"
        more = f" and {len(self.multipliers) - 6} more" if len(self.multipliers) > 6 else ""
        at = f"on {self.section!r}" if self.section else "of the forcing"
        return (
            f"LimitCycle(T = {self.period:.9g} s {at}, {'stable' if self.stable else 'unstable'}; multipliers {shown}{more}; "
            f"residual {self.residual:.1e} after {self.steps} steps)"
        )


def _number(m: complex) -> str:
    return f"{m.real:.6g}" if abs(m.imag) < 1e-12 * max(abs(m), 1e-300) or m.imag == 0 else f"{m.real:.6g}{m.imag:+.6g}i"


@by_keyword
def limit_cycle(
    eom: Equations,
    state: State | None = None,
    *,
    section: Any = None,
    period: Any = None,
    cyclic: Sequence[Any] = (),
    within: float = 100.0,
    tolerance: float = 1e-10,
    max_steps: int = 30,
    rtol: float = 1e-13,
    atol: float = 1e-13,
    settings: Settings | None = None,
    **by_kind: Unpack[StateValues],
) -> LimitCycle:
    """The cycle near a state: x with P(x) = x, by Newton's method with the exact derivative of the motion.

    P leads to the next passage of a `section`, after its action if it has one, or over a `period`. Events on the way may act, contacts may
    stick, slip, separate and hit.

    Parameters
    ----------
    eom : Equations
    state : `kn.State` of the guess, in place of q, u, states, parameters, inputs and t
    section : a `kn.Event`, or the name of one of the system, at which the cycle begins and ends. Its `then=` may relabel legs, so that a
        step counts as a cycle
    period : of forced systems, in s: a number or an expression of parameters, `2*kn.pi/omega`
    cyclic : coordinates or states that may go on, and on which nothing else depends: the way that a walker has gone
    within : how long the section is waited for (s)
    tolerance : up to which P(x) − x counts as zero, a share of the largest size of each component along the motion
    max_steps : Newton's steps at most
    rtol, atol : tolerances of the motions
    q, u, states, parameters, inputs, t : the guess; under constraints it is assembled

    Raises
    ------
    SimulationError
        if neither or both of section and period are given, or period ≤ 0; if the start is off a section that does not act, the
        section is not reached, the cycle grazes an event, a multiplier is 1, or Newton's method does not converge

    Notes
    -----
    Variational equations with saltation matrices: `kane.motion.cycles.variation`. Parker, T. S., Chua, L. O. (1989), Practical Numerical
    Algorithms for Chaotic Systems, Springer, ch. 5; Leine, R. I., Nijmeijer, H. (2004), Dynamics and Bifurcations of Non-Smooth Mechanical
    Systems, Springer, ch. 7.

    Examples
    --------
    >>> cycle = kn.limit_cycle(eom, q=[2.0], u=[0.0], section=kn.Event("turns", u, direction=-1))
    >>> cycle.period, cycle.multipliers, cycle.stable
    """
    check_equations(eom)
    guess_ = state_of(state, **by_kind)
    _check_kind(section, period)
    constants = parameter_values(eom.system, guess_.parameters)
    map_ = ReturnMap.of(
        eom, section, period, inputs=guess_.inputs, t0=float(guess_.t or 0.0), within=within, tolerances=(rtol, atol), settings=settings
    )
    _check_map(map_, constants)
    free = tuple(s.name for s in symbols_named("cyclic", eom.state, list(cyclic)))
    with working("Closing the cycle"):
        shooting = Shooting(map_, dict(constants), free)
        x = shooting.admitted(guess_)
        if map_.section is not None and map_.section.then is None:
            _check_on(map_, x, constants)
        return shooting.cycle(*shooting.newton(x, tolerance, max_steps))


def _check_kind(section: Any, period: Any) -> None:
    if (section is None) == (period is None):
        raise SimulationError(
            f"Expected either section= or period=, got {'neither' if section is None else 'both'}. A cycle of an autonomous system ends at a "
            "section, kn.Event('passes', q, direction=1); a forced one after the period of its forcing."
        )


def _check_map(map_: ReturnMap, constants: Mapping[Expr, float]) -> None:
    if map_.section is None:
        length = map_.length(constants)
        if not (np.isfinite(length) and length > 0):
            raise SimulationError(f"Expected period > 0, the time in s after which the forcing is the same again, got {length:g}.")
    elif map_.timed:
        raise SimulationError(
            f"Expected equations without the time for a cycle that ends at the section {map_.section.name!r}, got some in which it stands: the "
            "forcing must be the same again, too. Give period= in the place of section=."
        )
    expect.that(map_.within > 0, "within > 0, a time in s", map_.within, error=SimulationError)


def _check_on(map_: ReturnMap, x: Array, constants: Mapping[Expr, float]) -> None:
    h, terms = map_.off(x, constants)
    assert map_.section is not None
    if abs(h) > SIX_DIGITS * terms:
        raise SimulationError(
            f"Expected a start on the section {map_.section.name!r}, where {map_.section.quantity} = {map_.section.threshold:g}, got one where it "
            f"is {h + map_.section.threshold:.6g}. Move the start onto it; the last state of kn.poincare(…) lies there."
        )


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A motion from x, r = P(x) − x, and the sizes of x along it."""

    x: Array
    motion: Solution
    left: Array
    scale: Array

    @property
    def size(self) -> float:
        """The largest |r| of its component's size."""
        return float(np.abs(self.left / self.scale).max(initial=0.0))


@dataclass(frozen=True, slots=True, eq=False)
class Shooting:
    """Newton's method on P(x) = x at values of the parameters; components `cyclic` may be others at the end."""

    map: ReturnMap
    constants: dict[Expr, float]
    cyclic: tuple[str, ...]

    def admitted(self, given: State) -> Array:
        """(q, u, a) of the guess, on the constraints."""
        eom = self.map.eom
        q, u = given.q, given.u
        if eom.constraints.constraints:
            found = assemble(eom, q=q, u=u, parameters=given.parameters, inputs=given.inputs, t=self.map.t0)
            q, u = found.q, found.u
        return start_state(eom, q, u, given.states)

    def onto(self, x: Array) -> Array:
        """The state of the constraints nearest to x."""
        eom = self.map.eom
        if not eom.constraints.constraints:
            return x
        q, u, a = np.split(x, np.cumsum([len(eom.coordinates), len(eom.speeds)]))
        found = assemble(
            eom,
            q={s: guess(float(v)) for s, v in zip(eom.coordinates, q, strict=True)},
            u={s: guess(float(v)) for s, v in zip(eom.speeds, u, strict=True)},
            parameters=self.constants,
            inputs=self.map.inputs,
            t=self.map.t0,
        )
        return start_state(eom, found.q, found.u, a)

    def shot(self, x: Array, samples: Any = ()) -> Shot:
        """The motion from x."""
        motion = self.map(x, self.constants, samples)
        left = motion.states[-1] - x
        left[self._cyclic] = 0.0
        scale = np.abs(motion.states).max(axis=0)
        return Shot(x, motion, left, np.maximum(scale, 1e-6 * scale.max(initial=0) or 1.0))

    @property
    def _cyclic(self) -> list[int]:
        return [i for i, s in enumerate(self.map.eom.state) if s.name in self.cyclic]

    def linear(self, shot: Shot, by: tuple[Parameter, ...] = ()) -> "Linearized":
        """The derivative of P at a shot, in independent perturbations."""
        whole = self.map.differential(shot.motion, by)
        walk = Differential((), self.map.settings, {})
        flow = flow_of(walk.side(shot.motion, 0))
        basis, names = basis_of(flow), flow.states
        kept = [k for k, name in enumerate(names) if name not in self.cyclic]
        basis = basis[:, kept]
        back = np.linalg.pinv(basis)
        n = len(shot.x)
        own = whole.x.copy()
        own[self._cyclic] = 0.0
        return Linearized(
            basis, back, back @ own[:, :n] @ basis, back @ own[:, n:], flow.rest[kept], tuple(names[k] for k in kept), whole.t
        )

    def newton(self, x: Array, tolerance: float, most: int) -> tuple[Shot, "Linearized", int]:
        """The cycle near x.

        Raises
        ------
        SimulationError
            if steps do not converge
        """
        now = self.shot(x)
        for step in range(most):
            far(lambda now=now: f"a residual of {now.size:.1e}")
            linear = self.linear(now)
            if now.size <= ROUNDED_CHAIN:
                return now, linear, step
            after = self._step(now, linear)
            if now.size <= tolerance and (after is None or after.size > 0.5 * now.size):
                return now, linear, step
            if after is None:
                break
            now = after
        if now.size <= tolerance:
            return now, self.linear(now), most
        names = [s.name for s in self.map.eom.state]
        worst = int(np.argmax(np.abs(now.left / now.scale)))
        raise SimulationError(
            f"Expected a cycle near the start, got none by {most} of Newton's steps at most: the nearest motion misses its start by "
            f"{now.left[worst]:.3g} in {names[worst]}, {now.size:.1e} of its size, after {float(now.motion.t[-1]) - self.map.t0:.6g} s. Start nearer "
            "to it: let the motion settle by kn.simulate first, or follow the cycle from other values of the parameters."
        )

    def _step(self, now: Shot, linear: "Linearized") -> Shot | None:
        """The shot of a step that helps; None where none does."""
        change = linear.basis @ linear.solve(linear.back @ now.left)
        share, failed = 1.0, None
        for _ in range(_HALVINGS):
            try:
                after = self.shot(self.onto(now.x + share * change))
            except SimulationError as error:
                failed = error
            else:
                if after.size < (1 - 0.1 * share) * now.size:
                    return after
                failed = None
            share /= 2
        if failed is not None:
            raise failed
        return None

    def cycle(self, shot: Shot, linear: "Linearized", steps: int) -> LimitCycle:
        """The record of what was found."""
        length = float(shot.motion.t[-1]) - self.map.t0
        last = self.shot(shot.x, np.linspace(self.map.t0, self.map.t0 + length * (1 - 1e-12), _SAMPLES)).motion
        eom = self.map.eom
        q, u, a = (
            dict(zip(own, part.tolist(), strict=True))
            for own, part in zip(
                (eom.coordinates, eom.speeds, eom.states),
                np.split(shot.x, np.cumsum([len(eom.coordinates), len(eom.speeds)])),
                strict=True,
            )
        )
        start = State(q, u, states=a, parameters=dict(self.constants), inputs=self.map.inputs, t=self.map.t0)
        return LimitCycle(
            start, length, linear.multipliers(self.map.section is not None), linear.d, linear.names, last, shot.size, steps, self.map, shot.x,
            self.cyclic,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Linearized:
    """D over independent perturbations, by state and by parameters; the rates of these at the start; δT."""

    basis: Array
    back: Array
    d: Array
    by: Array
    rest: Array
    names: tuple[str, ...]
    t: Array

    def solve(self, right: Array) -> Array:
        """ξ of (I − D) ξ = right.

        Raises
        ------
        SimulationError
            if a multiplier is 1
        """
        matrix = np.eye(len(self.d)) - self.d
        scale = np.maximum(np.abs(matrix).max(axis=1), 1e-300)
        values = np.linalg.svd(matrix / scale[:, None], compute_uv=False)
        if not np.isfinite(matrix).all() or values[-1] <= STATE_RANK * values[0]:
            raise SimulationError(
                "Expected a cycle that stands alone, got one with a multiplier 1: others lie beside it, as where energy is kept or a coordinate "
                f"may have any value. Give cyclic= for what goes on by itself (of {', '.join(self.names)}), or section= in the place of period= "
                "where nothing depends on time."
            )
        return np.asarray(np.linalg.solve(matrix, right))

    def multipliers(self, on_section: bool) -> Complex:
        """By falling size; on a section without that of the flow."""
        d = self.d
        if on_section and len(d):
            across = np.linalg.svd(self.rest[None, :])[2][1:].T
            d = across.T @ d @ across
        found = np.asarray(np.linalg.eigvals(d), dtype=complex) if len(d) else np.zeros(0, dtype=complex)
        return found[np.lexsort((-found.imag, -np.round(np.abs(found), 12)))]


__all__ = ["SOLVED", "LimitCycle", "limit_cycle", "replace"]

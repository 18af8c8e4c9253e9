# SPDX-License-Identifier: BSD-3-Clause
"""`limit_cycle`: a periodic motion, found by shooting, with its Floquet multipliers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from kane import expect
from kane.equations.equations import Equations, check_equations
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import Attributes, SimulationError
from kane.expr.node import Expr
from kane.motion.cycles.branch import CycleBranch, follow
from kane.motion.cycles.shooting import FirstReturn, Linearized, Shooting
from kane.motion.derivatives.return_map import ReturnMap
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array, Complex
from kane.numeric.sampling import symbols_named
from kane.numeric.scale import SIX_DIGITS
from kane.program.native.machine import Settings
from kane.progress import working


@dataclass(frozen=True, eq=False, repr=False)
class LimitCycle(Attributes):
    """A limit cycle: a periodic motion, from `kn.cycles.limit_cycle`.

    Attributes
    ----------
    start : State
        a state on the cycle, with the values of parameters; on a section whose event has an action, the state after it
    period : T (s)
    multipliers : Floquet multipliers (complex), in the order of decreasing magnitude, without the trivial one of an autonomous
        cycle
    matrix : D (n × n) over `names`: the derivative of the Poincaré map, or the monodromy matrix over a period
    names : the independent perturbations of the start: coordinates, speeds, further states
    solution : Solution
        the motion over one period
    residual : the largest component of P(x) − x, relative to its magnitude along the cycle
    steps : number of Newton steps
    """

    start: State
    period: float
    multipliers: Complex
    matrix: Array
    names: tuple[str, ...]
    solution: Solution
    residual: float
    steps: int
    shooting: Shooting
    x: Array

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie within the unit circle: neighbouring motions approach the cycle."""
        return bool(np.all(np.abs(self.multipliers) < 1.0))

    @property
    def map(self) -> ReturnMap:
        """The map P of a state to the next passage of the section, or over a period."""
        return self.shooting.map

    @property
    def section(self) -> str | None:
        """The name of the event that defines the section; None if the period is given."""
        return None if self.map.section is None else self.map.section.name

    @property
    def equations(self) -> Equations:
        """The equations of motion, with the section among their events."""
        return self.map.eom

    def follow(self, parameter: Any, to: Any, *, max_points: int = 200, locate: bool = True) -> CycleBranch:
        """Follow the branch of limit cycles as a parameter varies, by pseudo-arclength continuation, past turning points.

        Parameters
        ----------
        parameter : the parameter, by symbol or name
        to : the last value; or several values, increasing or decreasing from the present one: the branch has a cycle at each of
            them, and at each turning point
        max_points : largest number of steps along the branch
        locate : whether to locate the crossings of the unit circle by multipliers

        Returns
        -------
        CycleBranch
            `kn.figures.root_locus(branch)` draws its exponents

        Raises
        ------
        SimulationError
            if `to` has no suitable values, or the orientation of a body is described by Euler parameters
        """
        return follow(self, parameter, to, max_points, locate, of_shot)

    def __repr__(self) -> str:
        shown = ", ".join(_number(m) for m in self.multipliers[:6]) or "none"
        more = f" and {len(self.multipliers) - 6} more" if len(self.multipliers) > 6 else ""
        at = f"on {self.section!r}" if self.section else "of the forcing"
        return (
            f"LimitCycle(T = {self.period:.9g} s {at}, {'stable' if self.stable else 'unstable'}; multipliers {shown}{more}; "
            f"residual {self.residual:.1e} after {self.steps} steps)"
        )


def _number(m: complex) -> str:
    return (
        f"{m.real:.6g}" if abs(m.imag) < 1e-12 * max(abs(m), 1e-300) or m.imag == 0 else f"{m.real:.6g}{m.imag:+.6g}i"
    )


def of_shot(shooting: Shooting, shot: FirstReturn, linear: Linearized, steps: int = 0) -> LimitCycle:
    """The LimitCycle of a converged shot."""
    map_ = shooting.map
    start = map_.state(shot.x, parameters=dict(shooting.constants), inputs=map_.inputs)
    found = linear.multipliers(map_.section is not None)
    length = float(shot.motion.t[-1]) - map_.t0
    return LimitCycle(
        start, length, found, linear.d, linear.names, shooting.sampled(shot), shot.size, steps, shooting, shot.x
    )


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
    """Find a limit cycle near a state: x with P(x) = x, by Newton's method with exact derivatives of the motion.

    P maps a state to that at the next passage of a `section`, after its action if it has one, or after a `period`. On the way
    events may have actions, and contacts may stick, slip, separate and collide.

    Parameters
    ----------
    eom : Equations
    state : a `kn.State` as initial guess, instead of q, u, states, parameters, inputs and t
    section : a `kn.Event`, or the name of an event of the system, at which the cycle starts and ends. An action `then=` may
        exchange legs, so that each step of a walker is a cycle
    period : the period of a forced system (s): a number, or an expression of parameters such as `2*kn.pi/omega`
    cyclic : coordinates or states that need not return, and on which nothing depends: the distance that a walker has covered
    within : longest time until the section is reached (s)
    tolerance : largest admissible P(x) − x, relative to the largest magnitude of each component along the motion
    max_steps : largest number of Newton steps
    rtol, atol : tolerances of the motions
    q, u, states, parameters, inputs, t : the initial guess; under constraints it is assembled

    Returns
    -------
    LimitCycle

    Raises
    ------
    SimulationError
        if neither or both of section and period are given, or period ≤ 0; if the guess is not on a section without action, the
        section is not reached, the cycle grazes an event, a multiplier is 1, or Newton's method does not converge

    Notes
    -----
    Variational equations with saltation matrices: `kane.motion.derivatives.variation`. Parker, T. S., Chua, L. O. (1989), Practical
    Numerical Algorithms for Chaotic Systems, Springer, ch. 5; Leine, R. I., Nijmeijer, H. (2004), Dynamics and Bifurcations of
    Non-Smooth Mechanical Systems, Springer, ch. 7.

    Examples
    --------
    >>> cycle = kn.limit_cycle(eom, q=[2.0], u=[0.0], section=kn.Event("turns", u, direction=-1))
    >>> cycle.period, cycle.multipliers, cycle.stable
    """
    check_equations(eom)
    guess_ = state_of(state, **by_kind)
    _check_kind(section, period)
    right = expect.is_number(tolerance) and tolerance > 0
    expect.that(right, "tolerance as a number above zero", tolerance, error=SimulationError)
    expect.whole(max_steps, "max_steps as a whole number above 0", least=1, error=SimulationError)
    map_ = ReturnMap.of(
        eom,
        section,
        period,
        inputs=guess_.inputs,
        t0=float(guess_.t or 0.0),
        within=within,
        tolerances=(rtol, atol),
        settings=settings,
        closing=True,
    )
    constants = map_.known(guess_.parameters)
    _check_map(map_, constants)
    free = tuple(s.name for s in symbols_named("cyclic", eom.state, list(cyclic)))
    with working("Computing the limit cycle"):
        shooting = Shooting(map_, constants, free)
        x = map_.admitted(guess_)
        if map_.section is not None and map_.section.then is None:
            _check_on(map_, x, constants)
        return of_shot(shooting, *shooting.newton(x, tolerance, max_steps))


def _check_kind(section: Any, period: Any) -> None:
    right = period is None or isinstance(period, Expr) or expect.is_number(period)
    expect.that(right, "period= as a number, or an expression of parameters", period, error=SimulationError)
    if (section is None) == (period is None):
        raise SimulationError(
            f"Expected either section= or period=, got {'neither' if section is None else 'both'}. A cycle of an autonomous "
            "system ends at a section, kn.Event('passes', q, direction=1); a forced one after the period of its forcing."
        )


def _check_map(map_: ReturnMap, constants: Mapping[Expr, float]) -> None:
    if map_.section is None:
        length = map_.length(constants)
        if not (np.isfinite(length) and length > 0):
            raise SimulationError(
                f"Expected period > 0, the time in s after which the forcing repeats, got {length:g}."
            )
        if not map_.timed(constants):
            raise SimulationError(
                "Expected equations that depend on time for a cycle with a given period, got equations that do not: their cycles "
                "may begin at any phase, and close after any multiple of a period of their own. Give section= instead of period=."
            )
    elif map_.timed(constants):
        raise SimulationError(
            f"Expected equations that do not depend on time for a cycle that ends at the section {map_.section.name!r}, got "
            "equations that do: their forcing must repeat, too. Give period= instead of section=."
        )


def _check_on(map_: ReturnMap, x: Array, constants: Mapping[Expr, float]) -> None:
    h, terms = map_.off(x, constants)
    assert map_.section is not None
    if not abs(h) <= SIX_DIGITS * terms:
        raise SimulationError(
            f"Expected a start on the section {map_.section.name!r}, where {map_.section.quantity} = "
            f"{map_.section.threshold:g}, got one where it is {h + map_.section.threshold:.6g}. Move the start onto it, or "
            "start from the last state of kn.poincare(…), which lies there."
        )

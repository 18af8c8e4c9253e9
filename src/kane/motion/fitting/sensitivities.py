# SPDX-License-Identifier: BSD-3-Clause
"""`sensitivities`: the exact derivatives of a motion by parameters and start values, at every sample."""

from collections.abc import Sequence
from typing import Any, Literal, Unpack

from kane import expect
from kane.equations.equations import Equations
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import SimulationError
from kane.motion.derivatives.backwards import AdjointSensitivities
from kane.motion.derivatives.forwards import Sensitivities
from kane.motion.derivatives.parametric_motion import ParametricMotion
from kane.program.native.machine import Settings
from kane.progress import working


@by_keyword
def sensitivities(
    eom: Equations,
    span: tuple[float, float],
    by: Sequence[Any],
    state: State | None = None,
    *,
    samples: int | Sequence[float] = 101,
    method: Literal["forward", "adjoint"] = "forward",
    rtol: float = 1e-11,
    atol: float = 1e-11,
    settings: Settings | None = None,
    **by_kind: Unpack[StateValues],
) -> Sensitivities | AdjointSensitivities:
    """The derivatives of a motion by parameters and start values, at every sample.

    Between events they obey the variational equations Ψ′ = J Ψ + ∂f/∂b along the motion, which are stepped by collocation of order 16
    until nine digits stay; at events, modes of contacts and impacts they leap by saltation matrices. By "adjoint" weights of what is
    asked for go the other way, from the end to the start: for few numbers and many of `by`.

    Parameters
    ----------
    eom : Equations
    span : (float, float)
        beginning and end (s)
    by : parameters, of the equations or of inputs that are expressions; coordinates, speeds or states for their start values. Under
        constraints the independent start values stay where a parameter changes, the others follow
    state : `kn.State` of the start, in place of q, u, states, parameters and inputs
    samples : how many, or at which times
    method : "forward", all states by all of `by` at once; "adjoint", what is asked for by one way back along the motion, which takes
        hardly longer for a hundred `by` than for one
    rtol, atol : tolerances of the motion. The derivatives are those of what was computed
    q, u, states, parameters, inputs : the start as `kn.simulate` takes it; under constraints it is assembled

    Returns
    -------
    Sensitivities or AdjointSensitivities
        `s.states` (samples × states × by), `s[expression]` (samples × by), `s.motion`; by "adjoint" they are found when they are asked
        for, and `s.cost(end, integral=…, samples=…)` is a cost and its gradient (by)

    Raises
    ------
    SimulationError
        if the motion has no derivative: it grazes an event, or meets two at one instant; or a rate jumps without one. If start values
        in `by` depend on each other

    Notes
    -----
    Aizerman, M. A., Gantmakher, F. R. (1958), On the stability of periodic motions, J. Appl. Math. Mech. 22, 1065–1078; Leine, R. I.,
    Nijmeijer, H. (2004), Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer, sec. 7.5. Adjoint equations of steps:
    Hager, W. W. (2000), Runge–Kutta methods in optimal control and the transformed adjoint system, Numer. Math. 87, 247–282;
    Sanz-Serna, J. M. (2016), Symplectic Runge–Kutta schemes for adjoint equations, SIAM Rev. 58, 3–33.

    Examples
    --------
    >>> s = kn.fitting.sensitivities(eom, (0, 10), by=["k", "x"], q={"x": 0.1}, u=[0])
    >>> s["x"][-1]  # ∂x(10)/∂k, ∂x(10)/∂x(0)
    >>> s = kn.fitting.sensitivities(eom, (0, 10), by=eom.parameters, q={"x": 0.1}, u=[0], method="adjoint")
    >>> s.cost("x", integral=u**2).gradient
    """
    expect.one_of(method, ("forward", "adjoint"), "method= to be", error=SimulationError)
    with working("Differentiating the motion"):
        course = ParametricMotion.of(eom, span, by, state_of(state, **by_kind), (rtol, atol), settings)
        motion = course.motion(samples)
        return course.backwards(motion) if method == "adjoint" else course.sensitivities(motion)

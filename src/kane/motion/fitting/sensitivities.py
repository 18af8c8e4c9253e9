# SPDX-License-Identifier: BSD-3-Clause
"""`sensitivities`: the exact derivatives of a motion with respect to parameters and initial values."""

from collections.abc import Sequence
from typing import Any, Literal, Unpack

from kane import expect
from kane.equations.equations import Equations
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import SimulationError
from kane.motion.derivatives.motion_derivatives import AdjointSensitivities, Sensitivities
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
    """Simulate a motion with its derivatives with respect to parameters and initial values, at every sample.

    Between events, the derivatives satisfy the variational equations Ψ′ = J Ψ + ∂f/∂b along the motion, which are integrated by
    collocation of order 16 to nine digits; at events, changes of contact modes and impacts they jump by saltation matrices. With
    method "adjoint", the adjoint equations are integrated backwards instead, which is efficient for few values and many `by`.

    Parameters
    ----------
    eom : Equations
    span : (float, float)
        beginning and end (s)
    by : parameters, of the equations or of inputs that are expressions; and coordinates, speeds or states, which stand for their
        initial values. Under constraints, parameters vary with fixed independent initial values, which determine the dependent ones:
        the first specified ones, in order, then some of the guesses and values left out, as they are assembled here. A new
        `kn.simulate` from the same guesses seeks all of them again
    state : a `kn.State` as initial state, instead of q, u, states, parameters and inputs
    samples : number of samples, or their times
    method : "forward" integrates the derivatives of all states with respect to all of `by`; "adjoint" takes a backward integration
        for each requested value, and hardly more time for a hundred `by` than for one
    rtol, atol : tolerances of the motion; the derivatives are those of the computed motion
    q, u, states, parameters, inputs : the initial state, as for `kn.simulate`; under constraints it is assembled

    Returns
    -------
    Sensitivities or AdjointSensitivities
        `s.states` (samples × states × by), `s[expression]` (samples × by), `s.motion`; with "adjoint" computed on request, and
        `s.cost(end, integral=…, samples=…)` is a cost with its gradient (by)

    Raises
    ------
    SimulationError
        if the motion has no derivative: it grazes an event, two events coincide, or a rate jumps without an event; or if initial
        values in `by` depend on each other

    Notes
    -----
    Aizerman, M. A., Gantmakher, F. R. (1958), On the stability of periodic motions, J. Appl. Math. Mech. 22, 1065–1078; Leine, R.
    I., Nijmeijer, H. (2004), Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer, sec. 7.5. Adjoint equations of
    steps: Hager, W. W. (2000), Runge–Kutta methods in optimal control and the transformed adjoint system, Numer. Math. 87,
    247–282; Sanz-Serna, J. M. (2016), Symplectic Runge–Kutta schemes for adjoint equations, SIAM Rev. 58, 3–33.

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

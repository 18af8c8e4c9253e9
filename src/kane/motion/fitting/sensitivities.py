# SPDX-License-Identifier: BSD-3-Clause
"""`sensitivities`: the exact derivatives of a motion by parameters and start values, at every sample."""

from collections.abc import Sequence
from typing import Any, Unpack

from kane.equations.equations import Equations
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.motion.derivatives.backwards import AdjointSensitivities
from kane.motion.derivatives.course import Course
from kane.motion.derivatives.sensitivities import Sensitivities
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
    method: str = "forward",
    rtol: float = 1e-11,
    atol: float = 1e-11,
    settings: Settings | None = None,
    **by_kind: Unpack[StateValues],
) -> Sensitivities | AdjointSensitivities:
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
        motion = course.motion(samples)
        return course.backwards(motion) if method == "adjoint" else course.sensitivities(motion)

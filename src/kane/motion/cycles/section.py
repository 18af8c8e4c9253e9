# SPDX-License-Identifier: BSD-3-Clause
"""`poincare`: the successive states at which a motion passes a Poincaré section."""

from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from kane import expect
from kane.equations.equations import Equations, check_equations
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import Attributes, SimulationError
from kane.motion.derivatives.return_map import ReturnMap
from kane.numeric.arrays import Array
from kane.numeric.sampling import symbols_named
from kane.program.native.machine import Settings
from kane.progress import working


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SectionPoints(Attributes):
    """Passages of a Poincaré section: `t` (n) and `states` (n × (q, u, a)), after the action of the section if it has one.

    `points[x]` are the values (n) of a coordinate, speed or state, by symbol or name. `message` gives the reason if passages are
    missing.
    """

    equations: Equations
    section: str
    t: Array
    states: Array
    message: str

    def __getitem__(self, what: Any) -> Array:
        (symbol,) = symbols_named("a component of the state", self.equations.state, [what])
        return self.states[:, [s.name for s in self.equations.state].index(symbol.name)]

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        times = f", t = {self.t[0]:.6g} … {self.t[-1]:.6g}" if len(self) else ""
        return f"SectionPoints({len(self)} passages of {self.section!r}{times}; {self.message})"


@by_keyword
def poincare(
    eom: Equations,
    state: State | None = None,
    *,
    section: Any,
    count: int = 100,
    within: float = 100.0,
    rtol: float = 1e-10,
    atol: float = 1e-10,
    settings: Settings | None = None,
    **by_kind: Unpack[StateValues],
) -> SectionPoints:
    """Simulate from a state, and return the next `count` passages of a Poincaré section.

    Parameters
    ----------
    eom : Equations
    state : a `kn.State` as initial state, instead of q, u, states, parameters, inputs and t
    section : a `kn.Event`, or the name of an event of the system. For a forced system,
        `kn.Event("period", kn.sin(omega*kn.time/2))` occurs once per period 2π/ω
    count : number of passages
    within : longest time between passages (s)
    rtol, atol : tolerances of the motion
    q, u, states, parameters, inputs, t : the initial state

    Returns
    -------
    SectionPoints
        fewer than `count` if the motion ends or does not reach the section again; `message` gives the reason

    Raises
    ------
    SimulationError
        if the start is not admissible
    """
    check_equations(eom)
    expect.whole(count, "count of passages, a whole number above 0", least=1, error=SimulationError)
    given = state_of(state, **by_kind)
    t0 = float(given.t or 0.0)
    map_ = ReturnMap.of(
        eom, section, None, inputs=given.inputs, t0=t0, within=within, tolerances=(rtol, atol), settings=settings
    )
    constants = map_.known(given.parameters)
    x, t, found, message = map_.admitted(given), t0, list[tuple[float, Array]](), "all requested passages"
    with working("Computing passages of the section"):
        for _ in range(count):
            try:
                motion = replace(map_, t0=t)(x, constants)
            except SimulationError as error:
                if not found and t == t0 and "reaches the section" not in str(error):
                    raise
                message = str(error)
                break
            x, t = motion.states[-1], float(motion.t[-1])
            found.append((t, x))
    assert map_.section is not None
    states = np.array([x for _, x in found]).reshape(len(found), len(eom.state))
    return SectionPoints(map_.eom, map_.section.name, np.array([t for t, _ in found]), states, message)

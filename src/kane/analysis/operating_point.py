# SPDX-License-Identifier: BSD-3-Clause
"""Operating points: complete states on the constraints, as arrays and as `State`; warnings of fast beams and closed contacts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kane.analysis.assembly import assemble
from kane.analysis.flow import perturbations, spread
from kane.analysis.local import Values, coded, slopes_at, values_at
from kane.analysis.state_checks import StateArrays, check_branch, check_configuration, entries, start_state
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.compiled import Numeric
from kane.equations.equations import Equations
from kane.equations.state import GROUPS, State
from kane.errors import warn
from kane.expr.node import Expr
from kane.expr.regular import size
from kane.model.beams.beam import Beam, doubts, spin_squared
from kane.model.contacts import ContactLaw
from kane.numeric.arrays import Array
from kane.numeric.newton import improved
from kane.numeric.rank import least_squares, of_unit_length, row_sizes
from kane.numeric.sampling import finite_number, named_values
from kane.numeric.scale import GIVEN, LAST_DIGIT

_ROUNDS = 4
"""Largest number of Newton steps onto the constraints."""


def state_from(eom: Equations, arrays: StateArrays) -> State:
    """The `State` with the values of arrays."""
    values = arrays.numbers(eom)
    return State(**{k: {s: float(values[s]) for s in getattr(eom, what)} for k, what in GROUPS.items()}, t=arrays.t)


def arrays_at(numeric: Numeric[Equations], state: State) -> StateArrays:
    """A state as arrays, with values left out solved for; raises SimulationError if it violates the constraints."""
    eom, q, u = numeric.equations, state.q, state.u
    constants = parameter_values(eom.system, state.parameters)
    p = np.array([constants[s] for s in eom.parameters])
    values = named_values("inputs", eom.inputs, state.inputs)
    r = np.array([finite_number("value", s.name, values.get(s, 0.0)) for s in eom.inputs])
    if u is None and not eom.constraints.constraints:
        u = np.zeros(len(eom.speeds))
    if eom.constraints.constraints and (
        entries("coordinates", eom.coordinates, q).free or entries("speeds", eom.speeds, u).free
    ):
        inputs = dict(zip(eom.inputs, r.tolist(), strict=True))
        start = assemble(eom, State(q, u, parameters=state.parameters, inputs=inputs, t=state.t))
        q, u = start.q, start.u
    t = finite_number("time", "the state", state.t)
    return closed(numeric, StateArrays(t, start_state(eom, q, u, state.states), p, r))


def closed(numeric: Numeric[Equations], state: StateArrays) -> StateArrays:
    """The state after Newton steps that remove rounding errors; raises SimulationError if it violates the constraints by more."""
    eom, perturbed, run = numeric.equations, numeric.value(perturbations), coded(numeric)
    values = values_at(run, state)
    nq, n = len(eom.coordinates), len(eom.speeds)
    given, what = state.given(eom), "an operating point"
    cure = "Assemble one first, kn.assemble(eom, q=…, u=…), leave some values out to have them solved for, or find one with kn.trim."
    check_configuration(eom, values.configuration, values.configuration_terms, given, what, cure)
    check_branch(eom, state.x[:nq], given, what, "")
    zero = np.zeros(values.right.shape)

    def closer(at: tuple[Array, Values]) -> tuple[Array, Values]:
        x, now = at
        g = slopes_at(run, replace(state, x=x), zero).configuration[:, :nq]
        t = spread(perturbed, x[:nq])
        x = np.append(x[:nq] - t @ least_squares(g @ t, now.configuration), x[nq:])
        return x, values_at(run, replace(state, x=x))

    start = of_unit_length(state.x, perturbed.sets), values
    sizes = row_sizes(values.matrix[:n, :n], values.constraints(n)[: len(values.configuration)])
    limit = LAST_DIGIT * (values.configuration_terms / sizes).max(initial=0)
    x, values = improved(start, lambda at: np.abs(at[1].configuration / sizes).max(initial=0), closer, limit, _ROUNDS)
    if values.motion.any():
        eom.evaluate(list(eom.speeds), state_from(eom, replace(state, x=x)))  # raises with their names
    if len(values.motion):
        x = x.copy()
        x[nq : nq + n] -= least_squares(values.constraints(n), values.motion)
    return replace(state, x=x)


def warn_of_beams(eom: Equations, points: Sequence[State]) -> None:
    """Warn once of each beam that, in some of these states, spins faster than its declared model allows."""
    for beam in eom.system.bodies:
        square = spin_squared(beam) if isinstance(beam, Beam) else None
        if square is None or not isinstance(beam, Beam):
            continue
        spins = [float(np.sqrt(max(float(eom.evaluate(square, p)), 0.0))) for p in points]
        fastest = int(np.argmax(spins))
        values = dict[Expr, float](points[fastest].parameters.items())
        for said, category in doubts(beam, spins[fastest], values):
            warn(said, category)


def warn_of_contacts(eom: Equations, points: Sequence[State]) -> None:
    """Warn of contacts that are closed in some of these states, as equations without modes do not contain their forces."""
    contacts = eom.system.contacts if eom.system.modes_change else ()
    closed = [c for c in contacts if c.gap is None or any(_touches(eom, c.gap.expr, p) for p in points)]
    if closed:
        names = ", ".join(repr(c.name) for c in closed)
        warn(f"Expected contacts that are open, got {names} closed, whose forces are left out. {_of_a_mode(closed)}")


def left_out(eom: Equations) -> str:
    """Advice for systems with contacts whose forces are not in the equations; "" if there are none."""
    contacts = eom.system.contacts if eom.system.modes_change else ()
    return f" These are the equations without the forces of contacts. {_of_a_mode(contacts)}" if contacts else ""


def _of_a_mode(contacts: Sequence[ContactLaw]) -> str:
    first = contacts[0]
    mode = "stick" if first.slips else "closed"
    return f"Use the equations of a mode: kn.derive(eom.system.in_modes({{{first.name!r}: {mode!r}}}))."


def _touches(eom: Equations, gap: Expr, point: State) -> bool:
    """Whether a gap is zero within the precision of the given values."""
    g, terms = eom.evaluate([gap, size(gap, {})], point)
    return bool(g <= GIVEN * terms)

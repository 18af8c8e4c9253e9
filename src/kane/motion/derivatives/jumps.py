# SPDX-License-Identifier: BSD-3-Clause
"""First-order behaviour of events: gradients of event functions, and derivatives of the resets g(x⁻, t, p).

Expressions are differentiated symbolically. Impacts of contacts and actions written in Python are maps between numbers and are
differentiated by sixth-order differences, applied to the map alone and never to a motion; two step lengths must agree. Differences
are central, but one-sided at the boundary of the domain of the map: a coefficient of restitution is at most 1.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from kane import expect
from kane.errors import ArgumentError, SimulationError
from kane.expr.differentiation import weighted
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, Expr
from kane.expr.symbols import Input, Parameter, Symbol, time
from kane.model.contacts import ContactMode
from kane.model.declarations import Event, target
from kane.motion.contact_motion import ContactMotion
from kane.motion.derivatives.parameter_slopes import evaluated
from kane.motion.derivatives.pulling import Laws
from kane.motion.derivatives.tangent_space import Side, allowed
from kane.motion.hybrid.actions import Instant, acted, following
from kane.motion.inputs.expressions import Formula, gains_of
from kane.motion.inputs.functions import constant
from kane.motion.solution.phases import Phase, same_drive
from kane.numeric.arrays import Array
from kane.numeric.rank import least_squares
from kane.numeric.scale import SIX_DIGITS

_FORWARD = (-49 / 20, 6.0, -15 / 2, 20 / 3, -15 / 4, 6 / 5, -1 / 6)
_WEIGHTS: tuple[dict[int, float], ...] = (
    {-3: -1 / 60, -2: 3 / 20, -1: -3 / 4, 1: 3 / 4, 2: -3 / 20, 3: 1 / 60},
    dict(enumerate(_FORWARD)),
    {-k: -w for k, w in enumerate(_FORWARD)},
)
"""Difference weights by offset in step lengths: central, forward, backward."""
_LENGTHS = tuple(1e-2 / 4**k for k in range(7))
"""Step lengths relative to the size of each component; the result is from the two successive ones that differ least."""


class Gradient(NamedTuple):
    """∂e/∂x (n), ∂e/∂t and ∂e/∂p (k) of an expression."""

    x: Array
    t: float
    p: Array


class JumpSlopes(NamedTuple):
    """δx⁺ = x δx + t δt + p δp of a reset."""

    x: Array
    t: Array
    p: Array


def gradients(side: Side, exprs: Sequence[Expr], by: Sequence[Parameter]) -> list[Gradient]:
    """The gradients of expressions, which may contain reactions and accelerations; input laws are substituted.

    Raises
    ------
    SimulationError
        if an expression depends on an input that is a Python function
    """
    eom, n = side.now.eom, side.now.width
    drives = dict(zip(eom.inputs, side.now.drives, strict=True))
    open_ = [s for s, f in drives.items() if constant(f) is None and not isinstance(f, Formula)]
    symbols = (*eom.state, time, *by, *open_)
    result = []
    for e in Laws(drives).read(eom, exprs):
        row = evaluated(weighted([e], [ONE], symbols), side.now, np.array([side.t]), side.x[None])[:, 0]
        if row[n + 1 + len(by) :].any():
            names = ", ".join(s.name for s in open_)
            raise SimulationError(
                "Expected inputs that are numbers or expressions, as an event depends on them, got Python functions: "
                f"{names}. Write them as expressions of kn.time and the state."
            )
        result.append(Gradient(row[:n], float(row[n]), row[n + 1 : n + 1 + len(by)]))
    return result


def action(before: Side, after: Side, event: Event, by: Sequence[Parameter]) -> JumpSlopes:
    """The derivative of the action of an event, between the states `before` and `after`."""
    n, k = before.now.width, len(by)
    if event.then is None:
        return JumpSlopes(np.eye(n), np.zeros(n), np.zeros((n, k)))
    if not isinstance(event.then, Mapping):
        return _of_function(before, event, by)
    system, eom = before.now.eom.system, before.now.eom
    own = {target(system, event, key): what for key, what in event.then.items()}
    check_set(own, event, by)
    place = {s: i for i, s in enumerate(eom.state)}
    moved = {place[s]: what for s, what in own.items() if s in place}
    x, t, p = np.eye(n), np.zeros(n), np.zeros((n, k))
    for i, row in zip(moved, gradients(before, list(moved.values()), by), strict=True):
        x[i], t[i], p[i] = row
    if not eom.constraints.constraints or not moved:
        return JumpSlopes(x, t, p)
    return _on_constraints(after, JumpSlopes(x, t, p), list(moved), by)


def check_set(own: Mapping[Symbol, Any], event: Event, by: Sequence[Parameter]) -> None:
    """Raises SimulationError if an action sets an input, a parameter in `by`, or a parameter to a value that is not constant."""
    for s, what in own.items():
        if isinstance(s, Parameter) and (s in set(by) or free_symbols([what])):
            raise SimulationError(
                f"Expected actions that set the state, or parameters to numbers, for the derivative of a motion, got {s} := "
                f"{what} from the event {event.name!r}. Make {s} a further state whose rate is zero: kn.state."
            )
        if isinstance(s, Input):
            raise SimulationError(
                f"Expected actions that set the state for the derivative of a motion, got the input {s} set by the event "
                f"{event.name!r}. Let the input depend on a further state, which the event sets: kn.state."
            )


def _on_constraints(after: Side, raw: JumpSlopes, moved: Sequence[int], by: Sequence[Parameter]) -> JumpSlopes:
    """Projects δx⁺ onto the tangent space of the constraints: dependent values follow, all others are as set or kept."""
    basis, shift_t, shift_p = allowed(after, by)
    eom = after.now.eom
    nq = len(eom.coordinates)
    speeds = [nq + i for i, u in enumerate(eom.speeds) if u in set(eom.dependent_speeds)]
    moved_q = [i for i in moved if i < nq]
    follow = [i for i in speeds if i not in set(moved)]
    if moved_q:
        own: set[Symbol] = {eom.coordinates[i] for i in moved_q}
        behind = set(following(eom, own))
        follow += [i for i, q in enumerate(eom.coordinates) if q in behind]
    kept = [i for i in range(len(raw.x)) if i not in set(follow)]

    def on(change: Array, shift: Array) -> Array:
        return basis @ least_squares(basis[kept], (change - shift)[kept]) + shift

    x = on(raw.x, np.zeros_like(raw.x))
    return JumpSlopes(x, on(raw.t, shift_t), on(raw.p, shift_p) if len(by) else raw.p)


# Maps of numbers -------------------------------------------------------------------------------------------------------------


def differenced(
    map_: Callable[[Array], Array], at: Array, sizes: Array, what: str, ends: tuple[type[Exception], ...] = ()
) -> Array:
    """∂map/∂z (m × n) by sixth-order differences; errors of the types `ends` mark the boundary of the domain of the map.

    Raises
    ------
    SimulationError
        if no two step lengths agree
    """

    def column(i: int, length: float, weights: Mapping[int, float]) -> Array:
        step = length * sizes[i]
        e = np.eye(len(at))[i] * step
        return np.asarray(sum(w * map_(at + k * e) for k, w in weights.items()) / step)

    ended: list[Exception] = []

    def every(i: int, weights: Mapping[int, float]) -> list[Array]:
        """The columns of those step lengths that stay within the domain of the map."""
        result = []
        for length in _LENGTHS:
            try:
                result.append(column(i, length, weights))
            except ends as error:
                ended.append(error)
        return result

    found = []
    for i in range(len(at)):
        some = next((own for weights in _WEIGHTS if len(own := every(i, weights)) > 1), [])
        if not some:
            raise ended[-1]
        apart = np.nan_to_num([float(np.abs(b - a).max(initial=0)) for a, b in pairwise(some)], nan=np.inf)
        best = int(np.argmin(apart))
        if not apart[best] <= SIX_DIGITS * max(float(np.abs(some[best]).max(initial=0)), 1.0):
            raise SimulationError(
                f"Expected {what} to be smooth near the cycle, got one that has a corner there: a different law applies "
                "nearby, as where friction in an impact is just sufficient. Give other values of the parameters."
            )
        found.append(some[best + 1])
    return np.column_stack(found)


def _sizes(before: Side) -> Array:
    """The size by which each component is measured: its magnitude, at least a tenth of the largest."""
    size = np.abs(before.x)
    return np.maximum(size, 0.1 * (size.max(initial=0) or 1.0))


def _of_function(before: Side, event: Event, by: Sequence[Parameter]) -> JumpSlopes:
    """The derivative of an action that is a Python function.

    Raises
    ------
    SimulationError
        if it sets inputs, or sets parameters to values that are not constant
    """
    first, own, n = before.now.eom, before.phase, before.now.width
    place = {s: i for i, s in enumerate(own.parameters)}

    def instant(z: Array) -> Instant:
        phase = _at(own, by, z[n + 1 :])
        return acted(Instant(first, first, float(z[n]), z[:n], phase), [event], float(z[n]) + 1.0)

    def after(z: Array) -> Array:
        found = instant(z)
        return np.append(found.x, [*found.phase.parameters.values()])

    now = instant(np.array([*before.x, before.t, *_values(own, by)])).phase
    _refuse([s for s, f in now.inputs.items() if not _goes_on(own.inputs[s], f)], event)
    x, t, p = _split(after, before, _values(own, by), f"the action of the event {event.name!r}")
    kept = np.array([[float(s is b) for b in by] for s in place]).reshape(len(place), len(by))
    moved = np.column_stack([x[n:], t[n:], p[n:] - kept])
    _refuse([s for s, i in place.items() if np.abs(moved[i]).max() > SIX_DIGITS], event)
    return JumpSlopes(x[:n], t[:n], p[:n])


def _goes_on(f: Any, g: Any) -> bool:
    """Whether an input is unchanged; parameters in its expression may have other values."""
    return same_drive(f, g) or (isinstance(f, Formula) and isinstance(g, Formula) and f.expr is g.expr)


def _refuse(found: Sequence[Expr], event: Event) -> None:
    cure = "Make them further states by kn.state, which the event sets."
    told = f"a function of the event {event.name!r} that sets the state, or parameters to numbers, for the derivative of a motion"
    expect.none(map(str, found), told, "one that sets {}", cure, error=SimulationError)


def parameters_of(phase: Phase) -> dict[Expr, Any]:
    """The values of all parameters, those that occur only in inputs included."""
    return {**gains_of(phase.inputs.values()), **phase.parameters}


def _values(phase: Phase, by: Sequence[Parameter]) -> Array:
    values = parameters_of(phase)
    return np.array([values[p] for p in by])


def _at(phase: Phase, by: Sequence[Parameter], values: Array) -> Phase:
    """A phase with other parameter values, also within its inputs."""
    return phase.at(dict(zip(by, values.tolist(), strict=True)))


def _split(
    after: Callable[[Array], Array], before: Side, values: Array, what: str, ends: tuple[type[Exception], ...] = ()
) -> JumpSlopes:
    n = before.now.width
    z = np.concatenate([before.x, [before.t], values])
    sizes = np.concatenate([_sizes(before), [max(abs(before.t), 1.0)], np.where(values != 0, np.abs(values), 1.0)])
    whole = differenced(after, z, sizes, what, ends)
    return JumpSlopes(whole[:, :n], whole[:, n], whole[:, n + 1 :])


def impact(motion: ContactMotion, before: Side, hits: int, by: Sequence[Parameter]) -> JumpSlopes:
    """The derivative of an impact in which contact `hits` closes; SimulationError if other contacts stay closed in nearby impacts."""
    modes = before.now.eom.system.modes
    closed = {i for i, m in enumerate(modes) if m is not ContactMode.SEPARATED} | {hits}
    n, symbols = before.now.width, motion.numbers.bundle.ports[2].symbols
    own, whole = motion.p, Phase(motion.parameters, motion.inputs)

    def hit(z: Array) -> tuple[Array, set[int], float]:
        phase = _at(whole, by, z[n + 1 :])
        motion.p, motion.inputs = np.array([phase.parameters[p] for p in symbols]), phase.inputs
        motion.fastest[:], motion.highest[:], motion.rebound[:] = 0.0, 0.0, 0.0
        return motion.hit(float(z[n]), z[:n], set(closed))

    stays = hit(np.concatenate([before.x, [before.t], _values(whole, by)]))[1]

    def after(z: Array) -> Array:
        found, own_stays, _ = hit(z)
        return found if own_stays == stays else np.full(n, np.nan)

    # ArgumentError: a coefficient of restitution above 1 ends the domain of the map
    result = _split(
        after, before, _values(whole, by), f"the impact of the contact {motion.contacts[hits].name!r}", (ArgumentError,)
    )
    motion.p, motion.inputs = own, whole.inputs
    return result

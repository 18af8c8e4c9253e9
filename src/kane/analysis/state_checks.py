# SPDX-License-Identifier: BSD-3-Clause
"""States as arrays, from named values, and checks: completeness, unit length, constraints, closure branches, kinetic energy."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane import expect
from kane.dynamics.constraints.manifold import turned_closures
from kane.equations.equations import Equations
from kane.equations.state import Guess
from kane.errors import SimulationError, ValueMissingError
from kane.expr.node import Expr
from kane.expr.symbols import Symbol, time
from kane.numeric.arrays import Array, first_index
from kane.numeric.rank import negative_direction
from kane.numeric.sampling import finite_number, named_values
from kane.numeric.scale import GIVEN, TAKES_PART

_TINY = np.finfo(float).tiny


@dataclass(frozen=True, slots=True)
class StateArrays:
    """A state: time t, x = (q, u, a), parameters p and inputs r; of many states with leading axes."""

    t: Any
    x: Array
    p: Array
    r: Array

    @property
    def arguments(self) -> tuple[Any, Array, Array, Array]:
        """The values in the order of the arguments of routines."""
        return self.t, self.x, self.p, self.r

    def given(self, eom: Equations) -> dict[Expr, Any]:
        """Inputs, parameters and the time by symbol."""
        r, p = (x if x.ndim == 1 else np.moveaxis(x, -1, 0) for x in (self.r, self.p))
        return dict(zip((*eom.inputs, *eom.parameters, time), (*r, *p, self.t), strict=True))

    def numbers(self, eom: Equations) -> dict[Expr, Any]:
        """All values by symbol."""
        return {**dict(zip(eom.state, self.x, strict=True)), **self.given(eom)}


@dataclass(frozen=True, slots=True)
class GivenEntries:
    """Start values in order, and the indices of those that are guesses or left out."""

    values: Array
    guessed: tuple[int, ...]
    missing: tuple[int, ...]

    @property
    def free(self) -> tuple[int, ...]:
        """Indices of the values that may change: guesses, and those left out."""
        return tuple(sorted((*self.guessed, *self.missing)))


def entries(what: str, symbols: Sequence[Symbol], given: Any, label: str = "start value") -> GivenEntries:
    """Values by symbol or name, in the order of the symbols; `what` and `label` are for messages."""
    named = named_values(what, symbols, given)
    values = np.zeros(len(symbols))
    guessed, missing = [], []
    for i, s in enumerate(symbols):
        value = named.get(s)
        if isinstance(value, Guess):
            guessed.append(i)
            value = value.value
        if s in named:
            values[i] = finite_number(label, s.name, value)
        else:
            missing.append(i)
    return GivenEntries(values, tuple(guessed), tuple(missing))


def further(eom: Equations, states: Any) -> Array:
    """Values of the further states, given by symbol or name, or else by default."""
    given = named_values("states", eom.states, states)
    return np.array([finite_number("start value", a.name, given.get(a, a.default)) for a in eom.states], dtype=float)


def start_state(eom: Equations, q: Any, u: Any, states: Any = None) -> Array:
    """(q, u, a) from given finite numbers, with defaults for a; Euler parameters must be of unit length."""
    state = [*_numbers("coordinates", eom.coordinates, q), *_numbers("speeds", eom.speeds, u), *further(eom, states)]
    x = np.array(state)
    check_unit_length(eom, x)
    return x


def check_unit_length(eom: Equations, x: Array) -> None:
    """Raise SimulationError if Euler parameters in states x (… × n) are not of unit length."""
    sets = eom.system.euler_parameters
    place = {c: i for i, c in enumerate(eom.coordinates if sets else ())}
    for s in sets:
        lengths = np.linalg.norm(x[..., [place[e] for e in s.coordinates]], axis=-1).reshape(-1)
        off = lengths[np.abs(lengths - 1) > GIVEN]
        expected = f"Euler parameters ({', '.join(e.name for e in s.coordinates)}) with e0² + e1² + e2² + e3² = 1"
        came = f"length {off[0]:.9g}" if len(off) else ""
        expect.that(not came, expected, came=came, cure="Divide them by this length.", error=SimulationError)


def _numbers(what: str, symbols: Sequence[Symbol], given: Any) -> list[float]:
    if type(given) is np.ndarray and given.shape == (len(symbols),) and given.dtype == float:
        result: list[float] = given.tolist()
        if all(map(math.isfinite, result)):
            return result
    values = named_values(what, symbols, given)
    missing, cure = (s.name for s in symbols if s not in values), "Give one for each, by symbol or name."
    expect.none(missing, f"a start value for all {what}", "none for {}", cure, error=ValueMissingError)
    return [finite_number("start value", s.name, values[s]) for s in symbols]


def open_shares(eom: Equations, residual: Array, terms: Array, values: Mapping[Expr, Any]) -> Array:
    """Residuals of the configuration constraints (… × m) as fractions of the sizes of their terms, which do not depend on units.

    `terms` (… × m) are the sizes at the state. If these are too small to accept it, as they may vanish there, typical sizes are used,
    with all symbols except coordinates at `values`.
    """
    shares = np.asarray(np.abs(residual) / np.maximum(terms, _TINY))
    if not residual.shape[-1] or bool((shares <= GIVEN).all()):
        return shares
    usual = eom.derived.conditions.at(values).usual.f[: residual.shape[-1]]
    return np.asarray(np.abs(residual) / np.maximum(terms, usual))


def misses(names: Iterable[str], residual: Array, size: Array | None = None, limit: float = GIVEN) -> list[str]:
    """Texts for violated constraints with residuals; a constraint holds if its `size`, by default |residual|, is at most `limit`."""
    sizes = np.abs(residual if size is None else size)
    return [f"{n} by {v:.3g}" for n, v, s in zip(names, residual, sizes, strict=False) if not s <= limit]


def check_configuration(
    eom: Equations, residual: Array, terms: Array, values: Mapping[Expr, Any], what: str, cure: str
) -> None:
    """Raise SimulationError if configuration constraints are violated, given `residual`, `terms` and `values` as in `open_shares`."""
    count = residual.shape[-1]
    if not count:
        return
    shares = open_shares(eom, residual, terms, values).reshape(-1, count)
    worst = np.abs(residual).reshape(-1, count).max(axis=0, initial=0)
    bad = misses([c.name for c in eom.system.holonomic], worst, shares.max(axis=0, initial=0))
    expect.none(bad, f"{what} on the constraints", "coordinates that miss {}", cure, error=SimulationError)


def check_branch(eom: Equations, q: Array, rest: Mapping[Expr, Any], what: str, cure: str) -> None:
    """Raise SimulationError if a closure is not on its specified branch at some q (… × n); `rest` gives all other values."""
    conditions = eom.derived.conditions
    angles = conditions.at(rest).turned(q)
    away = angles.any(axis=-1)
    if away.any():
        first = first_index(away)
        where = f" at index {first.written}" if first.place else ""
        turned = turned_closures(conditions.branches, angles[first.place])
        raise SimulationError(
            f"Expected {what} on the intended branch of the closures, got {turned}{where}. kn.assemble finds one on it from "
            f"guesses{cure}."
        )


def check_kinetic_energy(speeds: Sequence[Symbol], m: Array, place: str) -> None:
    """Raise SimulationError if ½ uᵀ M u < 0 for some u, naming the speeds in that direction; `place` is for the message."""
    direction = negative_direction(m)
    if direction is None:
        return
    names = ", ".join(str(u) for u, c in zip(speeds, direction, strict=True) if abs(c) > TAKES_PART)
    raise SimulationError(
        f"Expected a kinetic energy ≥ 0 for all speeds, got a negative one of {names} {place}: physically possible masses and "
        "inertias exclude this, and a beam has it if it is bent beyond the validity of its equations. Give smaller "
        "deformations, or correct the masses and inertias."
    )

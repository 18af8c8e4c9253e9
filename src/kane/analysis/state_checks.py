# SPDX-License-Identifier: BSD-3-Clause
"""States as arrays: values named, complete, on the constraints, and on the branch that closures mean."""

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
    """Where: t, x = (q, u, a), p, r; of many states with leading axes."""

    t: Any
    x: Array
    p: Array
    r: Array

    @property
    def arguments(self) -> tuple[Any, Array, Array, Array]:
        """The same as routines take them."""
        return self.t, self.x, self.p, self.r

    def given(self, eom: Equations) -> dict[Expr, Any]:
        """Inputs, parameters and the time by symbol."""
        r, p = (x if x.ndim == 1 else np.moveaxis(x, -1, 0) for x in (self.r, self.p))
        return dict(zip((*eom.inputs, *eom.parameters, time), (*r, *p, self.t), strict=True))

    def numbers(self, eom: Equations) -> dict[Expr, Any]:
        """All of it by symbol."""
        return {**dict(zip(eom.state, self.x, strict=True)), **self.given(eom)}


@dataclass(frozen=True, slots=True)
class GivenEntries:
    """Start values in order, and which of them are guessed or left out."""

    values: Array
    guessed: tuple[int, ...]
    missing: tuple[int, ...]

    @property
    def free(self) -> tuple[int, ...]:
        """What may move."""
        return tuple(sorted((*self.guessed, *self.missing)))


def entries(what: str, symbols: Sequence[Symbol], given: Any, label: str = "start value") -> GivenEntries:
    """Values by symbol or name, in the order of the symbols; `what` and `label` name them in messages."""
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
    """The further states: values given by symbol or name, else their defaults."""
    given = named_values("states", eom.states, states)
    return np.array([finite_number("start value", a.name, given.get(a, a.default)) for a in eom.states], dtype=float)


def start_state(eom: Equations, q: Any, u: Any, states: Any = None) -> Array:
    """(q, u, a), each value given as a finite number, those of a by default; Euler parameters must be of unit length."""
    state = [*_numbers("coordinates", eom.coordinates, q), *_numbers("speeds", eom.speeds, u), *further(eom, states)]
    x = np.array(state)
    check_unit_length(eom, x)
    return x


def check_unit_length(eom: Equations, x: Array) -> None:
    """Euler parameters among the values of states x (… × n) are of unit length."""
    sets = eom.system.euler_parameters
    place = {c: i for i, c in enumerate(eom.coordinates if sets else ())}
    for s in sets:
        lengths = np.linalg.norm(x[..., [place[e] for e in s.coordinates]], axis=-1).reshape(-1)
        off = lengths[np.abs(lengths - 1) > GIVEN]
        expected = f"Euler parameters ({', '.join(e.name for e in s.coordinates)}) with e0² + e1² + e2² + e3² = 1"
        came = f"length {off[0]:.9g}" if len(off) else ""
        expect.that(not came, expected, came=came, cure="Divide them by it.", error=SimulationError)


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
    """What is left of the configuration constraints (… × m), over the size of their terms: the same in any units.

    `terms` (… × m) are their sizes at the state; where these leave doubt, as they may vanish there, the usual ones count too, all
    symbols but the coordinates at `values`.
    """
    shares = np.asarray(np.abs(residual) / np.maximum(terms, _TINY))
    if not residual.shape[-1] or bool((shares <= GIVEN).all()):
        return shares
    usual = eom.derived.conditions.at(values).usual.f[: residual.shape[-1]]
    return np.asarray(np.abs(residual) / np.maximum(terms, usual))


def misses(names: Iterable[str], residual: Array, size: Array | None = None, limit: float = GIVEN) -> list[str]:
    """Which constraints are missed, and by how much; those of a `size`, by default the residual's, of no more than `limit` hold."""
    sizes = np.abs(residual if size is None else size)
    return [f"{n} by {v:.3g}" for n, v, s in zip(names, residual, sizes, strict=False) if not s <= limit]


def check_configuration(
    eom: Equations, residual: Array, terms: Array, values: Mapping[Expr, Any], what: str, cure: str
) -> None:
    """The configuration constraints hold: `residual` (… × m) is what is left of them; `terms` and `values` as for `open_shares`."""
    count = residual.shape[-1]
    if not count:
        return
    shares = open_shares(eom, residual, terms, values).reshape(-1, count)
    worst = np.abs(residual).reshape(-1, count).max(axis=0, initial=0)
    bad = misses([c.name for c in eom.system.holonomic], worst, shares.max(axis=0, initial=0))
    expect.none(bad, f"{what} on the constraints", "coordinates that miss {}", cure, error=SimulationError)


def check_branch(eom: Equations, q: Array, rest: Mapping[Expr, Any], what: str, cure: str) -> None:
    """No closure is turned away from the branch that it means, at any of the coordinates q (… × n); `rest` holds all other values."""
    conditions = eom.derived.conditions
    angles = conditions.at(rest).turned(q)
    away = angles.any(axis=-1)
    if away.any():
        first = first_index(away)
        where = f" at index {first.written}" if first.place else ""
        turned = turned_closures(conditions.branches, angles[first.place])
        raise SimulationError(
            f"Expected {what} on the branch that the closures mean, got {turned}{where}. kn.assemble finds one on it "
            f"from guesses{cure}."
        )


def check_kinetic_energy(speeds: Sequence[Symbol], m: Array, place: str) -> None:
    """½ uᵀ M u ≥ 0 for all speeds u at a place; the error names those that take part in a negative one."""
    direction = negative_direction(m)
    if direction is None:
        return
    names = ", ".join(str(u) for u, c in zip(speeds, direction, strict=True) if abs(c) > TAKES_PART)
    raise SimulationError(
        f"Expected a kinetic energy ≥ 0 for all speeds, got a negative one of {names} {place}: bodies of these masses and inertias "
        "cannot have it, and a beam has it where it is bent further than its equations hold. Take smaller deformations, or correct "
        "the masses and inertias."
    )

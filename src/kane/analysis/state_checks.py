# SPDX-License-Identifier: BSD-3-Clause
"""States as arrays: values named, complete, on the constraints, and on the branch that closures mean.

Which small changes of a state the constraints allow, by the implicit function theorem at a point.

    G δq + ∂f/∂r δr = 0                       δq = T ξ,  ξ = N ξ_I + P δr
    A δu + ∂(A u + b)/∂q δq + ∂b/∂r δr = 0     δu = B δu_I + E ξ_I + Q δr

ξ are the perturbations of the coordinates; for Euler parameters three angles θ along the axes of the frame they turn, with
δe = ½ E(e) θ and θ̇ = δω − ω × θ. Arrays hold numbers or expressions alike.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.dynamics.constraints.manifold import manifold, turned_closures
from kane.dynamics.constraints.partition import Partition, choose
from kane.dynamics.readings.unsolved import unsolved
from kane.equations.equations import Equations
from kane.equations.state import Guess
from kane.errors import SimulationError, ValueMissingError
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate, Symbol, Time, time
from kane.numeric.arrays import Array, Entries, first_place
from kane.numeric.mass_metric import sizes
from kane.numeric.sampling import finite_number, named_values
from kane.numeric.scale import GIVEN

_TINY = np.finfo(float).tiny


@dataclass(frozen=True, slots=True)
class StateArrays:
    """Where: t, x = (q, u, a), p, r."""

    t: float
    x: Array
    p: Array
    r: Array

    def given(self, eom: Equations) -> dict[Expr, Any]:
        """Inputs, parameters and the time by symbol."""
        return dict(zip((*eom.inputs, *eom.parameters, time), (*self.r, *self.p, self.t), strict=True))

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
    place = {c: i for i, c in enumerate(eom.coordinates)}
    for s in eom.system.euler_parameters:
        length = float(np.sqrt(sum(state[place[e]] ** 2 for e in s.coordinates)))
        if abs(length - 1) > GIVEN:
            names = ", ".join(e.name for e in s.coordinates)
            raise SimulationError(
                f"Expected Euler parameters ({names}) with e0² + e1² + e2² + e3² = 1, got length {length:.9g}. Divide them by it."
            )
    return np.array(state)


def _numbers(what: str, symbols: Sequence[Symbol], given: Any) -> list[float]:
    if type(given) is np.ndarray and given.shape == (len(symbols),) and given.dtype == float:
        found: list[float] = given.tolist()
        if all(map(math.isfinite, found)):
            return found
    values = named_values(what, symbols, given)
    missing = [s.name for s in symbols if s not in values]
    if missing:
        raise ValueMissingError(
            f"Expected a start value for all {what}, got none for {', '.join(missing)}. Give one for each, by symbol or name."
        )
    return [finite_number("start value", s.name, values[s]) for s in symbols]


def open_shares(eom: Equations, residual: Array, terms: Array, values: Mapping[Expr, Any]) -> Array:
    """What is left of the configuration constraints (… × m), over the size of their terms: the same in any units.

    `terms` (… × m) are their sizes at the state; where these leave doubt, as they may vanish there, the usual ones count too, all
    symbols but the coordinates at `values`.
    """
    shares = np.asarray(np.abs(residual) / np.maximum(terms, _TINY))
    if not residual.shape[-1] or bool((shares <= GIVEN).all()):
        return shares
    usual = manifold(eom.system).at(values).usual.f[: residual.shape[-1]]
    return np.asarray(np.abs(residual) / np.maximum(terms, usual))


def misses(names: Iterable[str], residual: Array, size: Array | None = None, limit: float = GIVEN) -> str:
    """Which constraints are missed, and by how much; those of a `size`, by default the residual's, of no more than `limit` hold."""
    sizes = np.abs(residual if size is None else size)
    return ", ".join(f"{n} by {v:.3g}" for n, v, s in zip(names, residual, sizes, strict=False) if not s <= limit)


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
    if bad:
        raise SimulationError(f"Expected {what} on the constraints, got coordinates that miss {bad}. {cure}")


def check_branch(eom: Equations, q: Array, rest: Mapping[Expr, Any], what: str, cure: str) -> None:
    """No closure is turned away from the branch that it means, at any of the coordinates q (… × n); `rest` holds all other values."""
    conditions = manifold(eom.system)
    angles = conditions.at(rest).turned(q)
    away = angles.any(axis=-1)
    if away.any():
        first = first_place(away)
        where = f" at index {first.written}" if first.place else ""
        turned = turned_closures(conditions.branches, angles[first.place])
        raise SimulationError(
            f"Expected {what} on the branch that the closures mean, got {turned}{where}. kn.assemble finds one on it "
            f"from guesses{cure}."
        )


@dataclass(frozen=True, slots=True, eq=False)
class Perturbations:
    """The free perturbations ξ of the coordinates, δq = T ξ: δq itself; for Euler parameters three small angles.

    The angles are along the axes of the frame that the parameters turn. `coordinates` are those perturbed as they are, `sets` the
    indices of the Euler parameters, whose angles come last. `timed` says whether the time enters the equations.
    """

    names: tuple[str, ...]
    symbols: tuple[Coordinate | None, ...]
    coordinates: tuple[int, ...]
    sets: tuple[tuple[int, int, int, int], ...]
    timed: bool


def perturbations(eom: Equations) -> Perturbations:
    """The perturbations of the coordinates of a system."""
    equations, coordinates = unsolved(eom.derived), eom.coordinates
    place = {q: i for i, q in enumerate(coordinates)}
    sets = [tuple(place[e] for e in s.coordinates) for s in eom.system.euler_parameters]
    turned = {i for s in sets for i in s}
    plain = [i for i in range(len(place)) if i not in turned]
    angles = [f"theta{k}_{coordinates[s[0]].name}" for s in sets for k in (1, 2, 3)]
    return Perturbations(
        (*(coordinates[i].name for i in plain), *angles),
        (*(coordinates[i] for i in plain), *[None] * len(angles)),
        tuple(plain),
        tuple((s[0], s[1], s[2], s[3]) for s in sets),
        any(isinstance(s, Time) for s in free_symbols([*equations.places, *equations.residual])),
    )


def turning(e: Entries) -> Entries:
    """½ E(e), 4 × 3: δe of small angles along the frame's own axes (Kane, Likins, Levinson 1983, sec. 1.13)."""
    e0, e1, e2, e3 = e
    return 0.5 * np.array([[-e1, -e2, -e3], [e0, -e3, e2], [e3, e0, -e1], [-e2, e1, e0]])


def turning_rates(rates: Entries, plain: int) -> Entries:
    """The matrix (ξ × ξ) of ω × θ in the rates of ξ, whose first `plain` are those of coordinates; ω follow them."""
    matrix = np.zeros((len(rates), len(rates)), dtype=rates.dtype)
    for k in range(plain, len(rates), 3):
        x, y, z = rates[k : k + 3]
        matrix[k : k + 3, k : k + 3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    return matrix


def spread(perturbed: Perturbations, q: Entries) -> Entries:
    """T (coordinates × ξ) of δq = T ξ."""
    plain = len(perturbed.coordinates)
    t = np.zeros((len(q), plain + 3 * len(perturbed.sets)), dtype=q.dtype)
    t[perturbed.coordinates, range(plain)] = 1.0
    for k, places in enumerate(perturbed.sets):
        t[list(places), plain + 3 * k : plain + 3 * k + 3] = turning(q[list(places)])
    return t


@dataclass(frozen=True, slots=True, eq=False)
class Tangents:
    """N, P, B, E, Q of the changes that the constraints allow; which ξ and u are independent."""

    free_q: tuple[int, ...]
    free_u: tuple[int, ...]
    n: Entries
    p: Entries
    b: Entries
    e: Entries
    q: Entries

    @property
    def moves(self) -> Entries:
        """δ(ξ, u, r) of δ(ξ_I, u_I, r)."""
        i, j, nr = len(self.free_q), len(self.free_u), self.p.shape[1]
        return np.vstack(
            [
                np.hstack([self.n, np.zeros((len(self.n), j)), self.p]),
                np.hstack([self.e, self.b, self.q]),
                np.hstack([np.zeros((nr, i + j)), np.eye(nr)]),
            ]
        )


FreePart = Callable[[Entries, Entries], tuple[tuple[int, ...], Entries]]
"""x of a x + rest y = 0 by its free part: which of x are free, and S of x = S (x_free, y)."""


def tangents(g: Entries, v: Entries, width: int, count: int, by_q: FreePart, by_u: FreePart) -> Tangents:
    """The changes that the constraints allow at a point, in numbers or in expressions.

    Parameters
    ----------
    g, v : derivatives of f and of A u + b in (ξ, u, r)
    width, count : how many ξ and u there are
    by_q, by_u : how ξ and u are solved for
    """
    free_q, of_q = by_q(g[:, :width], g[:, width + count :])
    i = len(free_q)
    shift = v[:, :width] @ of_q
    shift[:, i:] = shift[:, i:] + v[:, width + count :]
    free_u, of_u = by_u(v[:, width : width + count], shift)
    j = len(free_u)
    return Tangents(free_q, free_u, of_q[:, :i], of_q[:, i:], of_u[:, :j], of_u[:, j : j + i], of_u[:, j + i :])


def by_free_part(
    a: Entries, rest: Entries, partition: Partition, solve: Callable[[Entries, Entries], Entries]
) -> tuple[tuple[int, ...], Entries]:
    """See `FreePart`; the dependent x of the partition are solved for."""
    count = a.shape[1]
    free, rows, dependent = partition.independent(count), list(partition.rows), list(partition.dependent)
    solution = np.zeros((count, len(free) + rest.shape[1]), dtype=a.dtype)
    solution[list(free), range(len(free))] = 1
    if rows:
        solution[dependent] = solve(a[np.ix_(rows, dependent)], -np.hstack([a[np.ix_(rows, list(free))], rest[rows]]))
    return free, solution


def in_numbers(root: Array, preferred: Sequence[int]) -> FreePart:
    """Solving in numbers: `preferred` are dependent as far as they are determined; S Sᵀ = M⁻¹ in x of `root` says by what."""

    def solved(a: Entries, rest: Entries) -> tuple[tuple[int, ...], Entries]:
        return by_free_part(a, rest, choose(a, preferred, reach=sizes(a, root)), np.linalg.solve)

    return solved

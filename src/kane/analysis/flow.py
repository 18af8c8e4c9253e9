# SPDX-License-Identifier: BSD-3-Clause
"""The flow on the constraints at a state, and its exact derivatives: ẋ = F(x, r) in x = (ξ_I, u_I, a).

    δẋ = A δx + B δr,   y = h(q, u, u̇, λ, R, r):   δy = C δx + D δr

Zero is judged beside the terms that cancel in a sum: for u̇, |M⁻¹| times the sizes of the terms of M u̇ = f + Aᵀλ + G R, with sines
and cosines taken as 1; for speeds, |u| and what such accelerations yield in the time in which the state changes; for q̇ = W u + X and
A u + b, their terms at such speeds.

In a steady motion, coordinates on which no speed depends, directly or through other states, may vary. They are those without such a
path in A, and the flow is compared at states displaced along them.

Perturbations that satisfy the constraints follow by the implicit function theorem:

    G δq + ∂f/∂r δr = 0                       δq = T ξ,  ξ = N ξ_I + P δr
    A δu + ∂(A u + b)/∂q δq + ∂b/∂r δr = 0     δu = B δu_I + E ξ_I + Q δr

ξ are free perturbations of the coordinates, three angles θ along the axes of the oriented frame for each set of Euler parameters, with
δe = ½ E(e) θ and θ̇ = δω − ω × θ. Arrays have entries that are numbers or expressions.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from kane.analysis.local import Outputs, RoutineSource, Slopes, Values, answers, coded, slopes_at, solver, values_at
from kane.analysis.state_checks import StateArrays, check_kinetic_energy, open_shares
from kane.dynamics.constraints.partition import Partition, choose, quality
from kane.dynamics.readings.unsolved import unsolved
from kane.equations.compiled import Numeric
from kane.equations.equations import Equations
from kane.expr.evaluation import free_symbols
from kane.expr.symbols import Coordinate, Time
from kane.numeric.arrays import Array, Entries, Mask, pace
from kane.numeric.rank import least_squares, mobility, sizes
from kane.numeric.scale import GIVEN, POOR, ROUNDED, ROUNDED_ROOT, UNRELATED, bounded


class Perturbations(NamedTuple):
    """The free perturbations ξ of the coordinates, δq = T ξ: δq itself; for Euler parameters three small angles.

    The angles are along the axes of the oriented frame. `coordinates` are indices of the other coordinates, `sets` those of Euler
    parameters, whose angles come last in ξ. `timed` is true if the equations contain the time.
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
    """½ E(e) (4 × 3), δe = ½ E(e) θ for small angles θ along axes of the frame (Kane, Likins & Levinson 1983, sec. 1.13)."""
    e0, e1, e2, e3 = e
    return 0.5 * np.array([[-e1, -e2, -e3], [e0, -e3, e2], [e3, e0, -e1], [-e2, e1, e0]])


def turning_rates(rates: Entries, plain: int) -> Entries:
    """The matrix of θ ↦ ω × θ (ξ × ξ); `rates` are those of ξ: first those of `plain` coordinates, then ω of each set."""
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


class Tangents(NamedTuple):
    """N, P, B, E, Q of the perturbations that satisfy the constraints, and the indices of the independent ξ and u."""

    free_q: tuple[int, ...]
    free_u: tuple[int, ...]
    n: Entries
    p: Entries
    b: Entries
    e: Entries
    q: Entries

    @classmethod
    def of(cls, free_q: Sequence[int], of_q: Entries, free_u: Sequence[int], of_u: Entries) -> "Tangents":
        """From the derivatives of ξ in (ξ_I, r) and of u in (u_I, ξ_I, r), at one state or at many (leading axes)."""
        i, j = len(free_q), len(free_u)
        u_parts = of_u[..., :j], of_u[..., j : j + i], of_u[..., j + i :]
        return cls(tuple(free_q), tuple(free_u), of_q[..., :i], of_q[..., i:], *u_parts)

    @property
    def moves(self) -> Entries:
        """Derivative of (ξ, u, r) in (ξ_I, u_I, r)."""
        many, (width, nr), i, j = self.p.shape[:-2], self.p.shape[-2:], len(self.free_q), len(self.free_u)
        rows = (
            [self.n, np.zeros((*many, width, j)), self.p],
            [self.e, self.b, self.q],
            [np.zeros((*many, nr, i + j)), np.broadcast_to(np.eye(nr), (*many, nr, nr))],
        )
        return np.concatenate([np.concatenate(row, axis=-1) for row in rows], axis=-2)


FreePart = Callable[[Entries, Entries], tuple[tuple[int, ...], Entries]]
"""A solver of a x + rest y = 0: returns the indices of the independent x, and S of x = S (x_independent, y)."""


def tangents(g: Entries, v: Entries, width: int, count: int, by_q: FreePart, by_u: FreePart) -> Tangents:
    """The perturbations that satisfy the constraints at a point, in numbers or in expressions.

    Parameters
    ----------
    g, v : derivatives of f and of A u + b in (ξ, u, r)
    width, count : numbers of ξ and of u
    by_q, by_u : solvers for ξ and for u
    """
    free_q, of_q = by_q(g[:, :width], g[:, width + count :])
    i = len(free_q)
    shift = v[:, :width] @ of_q
    shift[:, i:] = shift[:, i:] + v[:, width + count :]
    free_u, of_u = by_u(v[:, width : width + count], shift)
    return Tangents.of(free_q, of_q, free_u, of_u)


def by_free_part(
    a: Entries, rest: Entries, partition: Partition, solve: Callable[[Entries, Entries], Entries]
) -> tuple[tuple[int, ...], Entries]:
    """Solve for the dependent x of a partition; see `FreePart`."""
    count = a.shape[1]
    free, rows, dependent = partition.independent(count), list(partition.rows), list(partition.dependent)
    solution = np.zeros((count, len(free) + rest.shape[1]), dtype=a.dtype)
    solution[list(free), range(len(free))] = 1
    if rows:
        solution[dependent] = solve(a[np.ix_(rows, dependent)], -np.hstack([a[np.ix_(rows, list(free))], rest[rows]]))
    return free, solution


def in_numbers(root: Array, preferred: Sequence[int]) -> FreePart:
    """Numerical solver; `preferred` x become dependent where the rank allows. `root` is S of S Sᵀ = M⁻¹, which sets the sizes."""

    def solved(a: Entries, rest: Entries) -> tuple[tuple[int, ...], Entries]:
        return by_free_part(a, rest, choose(a, preferred, reach=sizes(a, root)), np.linalg.solve)

    return solved


_REMOTE = 1e-4
"""Fraction of all terms together, in the mass metric, that counts in each size, as a linear solution mixes rounding errors."""


class Magnitudes(NamedTuple):
    """The sizes of u̇ (n), of q̇ (nq), of the spins of Euler parameters, and of A u + b (m), as the sums of their terms.

    `pace` (1/s) is the rate of the fastest change, `inverse` M⁻¹ (n × n), `alone` (n) each speed if it had the whole kinetic energy,
    `alike` (nq + n) the changes of q in the time 1/`pace`, and of u, at one energy.
    """

    accelerations: Array
    rates: Array
    spins: Array
    motion: Array
    pace: float
    inverse: Array
    alone: Array
    alike: Array


def magnitudes(eom: Equations, values: Values, slopes: Slopes, z: Array, state: StateArrays) -> Magnitudes:
    """The sizes at a state with the solution z = (u̇, λ, R).

    Raises SimulationError, which names the speed, if M has a diagonal entry that is negative beyond rounding.
    """
    n, nq = len(eom.speeds), len(values.rates)
    u = state.x[nq : nq + n]
    m, held = values.matrix[:n, :n], values.constraints(n)
    low, entries = np.flatnonzero(np.diag(m) < 0), unsolved(eom.derived).matrix
    if any(x < -error for x, error in bounded([entries[i][i] for i in low], state.numbers(eom))):
        check_kinetic_energy(eom.speeds, m, "at this state")
    root = mobility(m, held)
    inverse, far = root @ root.T, np.linalg.norm(root, axis=1)
    k = n + len(held)
    forces = values.terms[:n] + sizes(held, root).T @ np.abs(z[n:k]) + np.abs(values.matrix[:n, k:]) @ np.abs(z[k:])
    accelerations = np.abs(inverse) @ forces + _REMOTE * far * np.linalg.norm(np.abs(root.T) @ forces)
    own = np.vstack([slopes.rates[:, : nq + n], -inverse @ slopes.residual[:n, : nq + n]])
    fastest = pace(own)
    alone = far * np.sqrt(np.maximum(u @ m @ u, 0.0))
    speeds = np.maximum(np.abs(u), _REMOTE * alone)
    speeds = np.maximum(speeds, accelerations / fastest if fastest > 0 else 0.0)

    def terms(linear: Array, whole: Array) -> Array:
        return np.asarray(np.abs(linear) @ speeds + np.abs(whole - linear @ u))

    rates, spins = (
        terms(s[:, nq : nq + n], v) for s, v in ((slopes.rates, values.rates), (slopes.spins, values.spins))
    )
    alike = np.append(np.linalg.norm(slopes.rates[:, nq : nq + n] @ root, axis=1) / (fastest or 1.0), far)
    return Magnitudes(accelerations, rates, spins, terms(held, values.motion), fastest, inverse, alone, alike)


def share(value: Array, size: Array) -> Array:
    """|value| / size, at most 1: 0 for a value of zero, 1 for a value without a size, and infinite for an infinite size."""
    result = np.abs(value) / np.maximum(np.maximum(size, np.abs(value)), np.finfo(float).tiny)
    return np.where(np.isinf(size), np.inf, result)


class Preference(NamedTuple):
    """Indices of perturbations ξ and speeds u to be dependent, as far as the constraints determine them."""

    q: tuple[int, ...] = ()
    u: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """The flow F and its derivatives A and B at a state. `rest` is F, `terms` the sizes of its terms.

    `mass` is the mass matrix of the independent speeds; `moves` and `answers` are the derivatives of (q, u, a, r) and (u̇, λ, R) in
    (ξ_I, u_I, a, r). D of `scale` is the change of x at equal energy in the time 1/`pace`; D⁻¹ A D does not depend on units.
    """

    numeric: Numeric[Equations]
    run: RoutineSource
    state: StateArrays
    choice: Preference
    values: Values
    solve: Callable[[Array], Array]
    slopes: Slopes
    z: Array
    tangents: Tangents
    rest: Array
    a: Array
    b: Array
    mass: Array
    moves: Array
    answers: Array
    magnitudes: Magnitudes
    terms: Array
    scale: Array

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states x = (ξ_I, u_I, a)."""
        names, speeds = self.numeric.value(perturbations).names, self.numeric.equations.speeds
        own = (*(names[i] for i in self.tangents.free_q), *(speeds[i].name for i in self.tangents.free_u))
        return (*own, *(a.name for a in self.numeric.equations.states))

    @property
    def counts(self) -> tuple[int, int]:
        """Number of coordinates in x, and of coordinates and speeds."""
        count = len(self.tangents.free_q)
        return count, count + len(self.tangents.free_u)


@np.errstate(invalid="ignore")
def flow_at(
    numeric: Numeric[Equations],
    state: StateArrays,
    choice: Preference,
    run: RoutineSource | None = None,
    known: Flow | None = None,
) -> Flow:
    """The flow and its derivatives at a state on the constraints, evaluated by `run`, by default compiled code.

    `known` is a flow at the same state with another choice of dependent speeds; what does not depend on the choice is taken from it.
    """
    run = run or coded(numeric)
    eom, perturbed = numeric.equations, numeric.value(perturbations)
    nq, n = len(eom.coordinates), len(eom.speeds)
    if known is None:
        values = values_at(run, state)
        solve = solver(eom, values, state)
        z = solve(values.right)
        slopes = slopes_at(run, state, z)
    else:
        values, solve, z, slopes = known.values, known.solve, known.z, known.slopes
    held = values.constraints(n)
    m = values.matrix[:n, :n]
    given_u = choice.u or _dependent_speeds_of(eom, held, m)
    t, plain = spread(perturbed, state.x[:nq]), list(perturbed.coordinates)

    def by_xi(slope: Array) -> Array:
        return np.hstack([slope[:, :nq] @ t, slope[:, nq:]])

    rates, rate_slopes = np.append(values.rates[plain], values.spins), np.vstack([slopes.rates[plain], slopes.spins])
    width, root = t.shape[1], mobility(m, held)
    by_q, by_u = in_numbers(rate_slopes[:, nq : nq + n] @ root, choice.q), in_numbers(root, given_u)
    tangent = tangents(by_xi(slopes.configuration), by_xi(slopes.motion), width, n, by_q, by_u)
    moves = np.vstack([t @ tangent.moves[:width], tangent.moves[width:]])
    answers = -solve(slopes.residual @ moves)
    own = rate_slopes @ moves - turning_rates(rates, len(plain)) @ tangent.moves[:width]
    # further states a are prescribed for the constraints, as inputs are, so that their columns precede those of inputs
    free_q, free_u = list(tangent.free_q), list(tangent.free_u)
    rows = np.vstack([own[free_q], answers[:n][free_u], slopes.states @ moves])
    rest = np.concatenate([rates[free_q], z[:n][free_u], values.states])
    a, b = rows[:, : len(rows)], rows[:, len(rows) :]
    size = known.magnitudes if known else magnitudes(eom, values, slopes, z, state)
    terms, far = np.append(size.rates[plain], size.spins), np.linalg.norm(rate_slopes[:, nq : nq + n] @ root, axis=1)
    terms = np.concatenate([terms[free_q], size.accelerations[free_u], values.state_terms])
    scale = np.append(far[free_q] / (size.pace or 1.0), np.linalg.norm(root, axis=1)[free_u])
    scale = _with_states(scale, a, size.pace or 1.0)
    mass = tangent.b.T @ m @ tangent.b
    return Flow(
        numeric, run, state, choice, values, solve, slopes, z, tangent, rest, a, b, mass, moves, answers, size, terms,
        scale,
    )  # fmt: skip


def _with_states(scale: Array, a: Array, pace: float) -> Array:
    """The scales of q and u, extended to further states: a change of one by its scale changes another variable by its own in 1/pace.

    A further state that affects no other has the scale of its own change in that time.
    """
    if len(scale) == len(a):
        return scale
    whole, slopes = np.append(scale, np.zeros(len(a) - len(scale))), np.abs(a)
    for _ in range(len(scale), len(a)):
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (whole * pace / slopes.T)[:, whole > 0].min(axis=1, initial=np.inf)
        whole = np.where(whole > 0, whole, np.where(np.isfinite(reach), reach, 0.0))
    driven = slopes @ whole / pace
    whole = np.where(whole > 0, whole, driven)
    return np.where(whole > 0, whole, 1.0)


def _dependent_speeds_of(eom: Equations, a: Array, m: Array) -> tuple[int, ...]:
    """The dependent speeds of the equations, if A determines them well, else none."""
    if eom.embedding is None:
        return ()
    partition = eom.embedding.partition
    return partition.dependent if quality(a, partition, sizes(a, mobility(m, a))) > POOR else ()


def output_slopes(flow: Flow, outputs: Outputs) -> tuple[Array, Array]:
    """Outputs h at the state, and their derivatives in (ξ_I, u_I, a, r)."""
    if not outputs.roots:
        return np.zeros(0), np.zeros((0, flow.moves.shape[1]))
    found = flow.run(answers, *outputs.roots)(*flow.state.arguments, flow.z)
    return found.values, found.slopes @ np.vstack([flow.moves, flow.answers])


_SHIFTS = (0.71, -1.13)
"""Times (1/pace) by which cyclic states are displaced to test that the flow does not depend on them."""


def dependence(a: Array, count: int, last: int | None = None) -> Mask:
    """Which states affect the speeds, directly or through others; the first `count` are coordinates, those from `last` further states.

    Entries of A within rounding of zero are dropped first: balancing would enlarge them if they closed a cycle of dependence.
    """
    from scipy.linalg import matrix_balance

    a = np.where(np.abs(a) > ROUNDED * np.abs(a).max(initial=0), a, 0.0)
    scaled = np.abs(matrix_balance(a, permute=False)[0])
    linked = scaled > UNRELATED * scaled.max(initial=0)
    places = np.arange(len(a))
    matters = (places >= count) & (places < (len(a) if last is None else last))
    while True:
        more = matters | linked[matters].any(axis=0)
        if np.array_equal(more, matters):
            return matters
        matters = more


class Steadiness(NamedTuple):
    """Which states affect the speeds, and which of them are not steady.

    `left` are the indices of affecting states that change, `varies` of other states whose change alters the equations; −1 is time.
    """

    matters: Mask
    left: tuple[int, ...]
    varies: tuple[int, ...]

    @property
    def holds(self) -> bool:
        """Whether the state is an equilibrium or a steady motion."""
        return not self.left and not self.varies


def steadiness(flow: Flow, tolerance: float) -> Steadiness:
    """Whether all states that affect the speeds are constant, and the equations do not change as the others and the time vary."""
    matters = dependence(scaled(flow.a, flow), *flow.counts)
    constant = share(flow.rest, flow.terms) <= tolerance
    left = tuple(np.flatnonzero(matters & ~constant).tolist())
    moving = np.flatnonzero(~matters & ~constant)
    if left or not (len(moving) or flow.numeric.value(perturbations).timed):
        return Steadiness(matters, left, ())
    same = all(_same(flow, matters, moving, shift / (flow.magnitudes.pace or 1.0), tolerance) for shift in _SHIFTS)
    return Steadiness(matters, (), () if same else tuple(moving.tolist()) or (-1,))


def changing(flow: Flow, tolerance: float) -> tuple[int, ...]:
    """Indices of all speeds, dependent ones included, with u̇ ≠ 0, or with u̇ = 0 and ü ≠ 0."""
    n, count = len(flow.numeric.equations.speeds), len(flow.rest)
    slopes, size = flow.answers[:n, :count], flow.magnitudes
    turns = slopes @ flow.rest
    noise = ROUNDED_ROOT * (np.abs(slopes) @ np.abs(flow.rest))
    least = np.maximum(tolerance * size.pace * size.accelerations, noise)
    changed = share(flow.z[:n], size.accelerations) > tolerance
    return tuple(np.flatnonzero(changed | (np.abs(turns) > least)).tolist())


def scaled(a: Array, flow: Flow) -> Array:
    """D⁻¹ A D with the scale D of the states; it does not depend on units."""
    return np.asarray(a * flow.scale / flow.scale[:, None])


def _same(flow: Flow, matters: Mask, moving: npt.NDArray[np.intp], shift: float, tolerance: float) -> bool:
    """Whether ẋ and A of the affecting states are unchanged after the time `shift`, in which the other states move at their rates."""
    numeric, state, tangent = flow.numeric, flow.state, flow.tangents
    eom, perturbed = numeric.equations, numeric.value(perturbations)
    nq, n = len(eom.coordinates), len(eom.speeds)
    x = state.x.copy()
    step = np.zeros(len(perturbed.names))
    placed = moving[moving < flow.counts[0]]
    step[[tangent.free_q[i] for i in placed]] = shift * flow.rest[placed]
    others = moving[moving >= flow.counts[1]]
    x[nq + n + others - flow.counts[1]] += shift * flow.rest[others]
    for at, place in enumerate(perturbed.coordinates):
        x[place] += step[at]
    for k, places in enumerate(perturbed.sets):
        angles = step[len(perturbed.coordinates) + 3 * k :][:3]
        x[list(places)] = _turned(x[list(places)], angles)
    moved = StateArrays(state.t + shift if perturbed.timed else state.t, x, state.p, state.r)
    held = [i for i in range(n) if i not in tangent.free_u]
    own = values_at(flow.run, moved)
    open_ = open_shares(eom, own.configuration, own.configuration_terms, moved.given(eom))
    if not open_.max(initial=0) <= GIVEN or not np.all(np.isfinite(own.motion)):
        return False
    if len(own.motion):
        x[nq : nq + n][held] -= least_squares(own.constraints(n)[:, held], own.motion)
    there = flow_at(numeric, moved, Preference(flow.choice.q, tuple(held)), flow.run)
    if there.tangents.free_u != tangent.free_u or there.tangents.free_q != tangent.free_q:
        return False
    inner = np.ix_(matters, matters)
    before, after = scaled(flow.a, flow)[inner], scaled(there.a, flow)[inner]
    change = (there.rest - flow.rest)[matters]
    alike = np.abs(after - before).max(initial=0) <= ROUNDED_ROOT * np.abs(before).max(initial=0)
    return bool(alike and share(change, flow.terms[matters]).max(initial=0) <= max(ROUNDED_ROOT, tolerance))


def _turned(e: Array, angles: Array) -> Array:
    """Euler parameters e (4) after a rotation φ n about axes of the body frame: e cos φ/2 + E(e) n sin φ/2, with `angles` φ n."""
    half = np.linalg.norm(angles) / 2
    return np.asarray(e * np.cos(half) + turning(e) @ angles * np.sinc(half / np.pi))

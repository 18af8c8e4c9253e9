# SPDX-License-Identifier: BSD-3-Clause
"""`linearize`: the equations of motion about an equilibrium or a steady motion, by exact differentiation, in numbers or in symbols.

    δq = T ξ,  G T ξ = 0  ⟹  ξ = N ξ_I + P δr,      A δu + ∂(A u + b)/∂q δq = 0  ⟹  δu = B δu_I + E ξ_I + Q δr

T is the identity; for Euler parameters it turns three small angles along the axes of their frame into δe.

At many states A and B of all are computed at once where possible, otherwise state by state. The independent perturbations of the first
state are those of all states. At once means the implicit function theorem of `kane.analysis.flow` on stacks of matrices; a
state in doubt, by rank, constraints or values that are not finite, is linearized by itself.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Unpack

import numpy as np

from kane import expect
from kane.analysis.assembly import assemble
from kane.analysis.flow import (
    Flow,
    FreePart,
    Preference,
    Steadiness,
    Tangents,
    by_free_part,
    changing,
    dependence,
    flow_at,
    perturbations,
    spread,
    steadiness,
    tangents,
    turning_rates,
)
from kane.analysis.linear import Linear
from kane.analysis.local import Outputs, Values, all_switches, answers, coded, outputs_of, regular_rows, slopes, values
from kane.analysis.many.poses import Poses, poses
from kane.analysis.one_sided import Piece, Side, differentiable, lengths
from kane.analysis.operating_point import arrays_at, left_out, state_from, warn_of_beams, warn_of_contacts
from kane.analysis.stacks import MatrixEntries, Stack, solve_each
from kane.analysis.state_checks import StateArrays, misses
from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.quantities import without_unknowns
from kane.dynamics.readings.unsolved import unsolved
from kane.equations.compiled import Numeric
from kane.equations.equations import Equations, check_equations
from kane.equations.instances import package
from kane.equations.state import Guess, State, StateValues, by_keyword, state_of
from kane.errors import ArgumentError, Attributes, CornerError, SimulationError, ValueMissingError, cut
from kane.expr.build import sub
from kane.expr.differentiation import tangent
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.matrix import Matrix, dot, solve_lu
from kane.expr.node import ONE, Expr, as_expr
from kane.expr.piecewise import on_either_side
from kane.expr.visit import substituted
from kane.numeric.arrays import Array, Entries, Mask, blocks
from kane.numeric.sampling import SEED, named_values, names_in, values_of
from kane.numeric.scale import GIVEN, NEAR_SINGULAR, ROUNDED_CHAIN
from kane.program.native.machine import Settings
from kane.progress import working


@dataclass(frozen=True, slots=True, eq=False)
class Linearizer(Attributes):
    """A function that linearizes: `linearizer(q=…, u=…)` returns a `Linear`. Derivatives are compiled at the first call."""

    eom: Equations
    outputs: Outputs
    settings: Settings | None = None

    @by_keyword
    def __call__(
        self,
        state: State | Any | None = None,
        *,
        independent: Sequence[Any] = (),
        leave_out: Sequence[Any] = (),
        steady: bool = True,
        tolerance: float = 1e-8,
        side: Side | None = None,
        **values: Unpack[StateValues],
    ) -> Linear | Any:
        """Linearize at a state or at many; see `linearize`."""
        expect.floats(tolerance, "a tolerance, a number", error=ArgumentError)
        gone, chosen = names_in("leave_out= as a list", leave_out), names_in("independent= as a list", independent)
        many = poses(self.eom, state, values)
        if many is not None:
            with working("Linearizing"):
                options = {"steady": steady, "tolerance": tolerance, "side": side}
                return self._of_many(many, chosen, gone, options)
        with working("Linearizing"):
            numeric = self.eom.numeric(self.settings)
            arrays = arrays_at(numeric, state_of(state, **values))
            flow, verdict = _flow(numeric, arrays, choice_of(numeric, chosen), bool(chosen), tolerance)
            smooth = differentiable(flow, self.outputs, tolerance if verdict.holds else 0.0, side)
            if smooth.flow is not flow:
                flow, verdict = smooth.flow, steadiness(smooth.flow, tolerance)
            if steady and not verdict.holds:
                raise SimulationError(_not_steady(flow, verdict, self._steady_with(flow, bool(chosen), tolerance)))
            _check_independent(flow, chosen)
            linear = self._linear(smooth, verdict)
            return linear.without(*gone) if gone else linear

    def _of_many(self, many: Poses, independent: Sequence[str], gone: Sequence[str], options: Mapping[str, Any]) -> Any:
        """Linearizations at many states as a Dataset; values left out are solved for as in `assemble`."""
        eom = self.eom
        given = {**many.given("q"), **many.given("u")}
        if not many.failed and any(
            s not in given or isinstance(given[s], Guess) for s in (*eom.coordinates, *eom.speeds)
        ):
            states = many.given("states")
            table: Any = assemble(eom, many.of_state())
            table = table.drop_vars([s.name for s in states], errors="ignore")
            whole = poses(eom, table, {"states": states})
            assert whole is not None
            many = whole

        def alone(k: int, names: Sequence[str]) -> Linear:
            result: Linear = self(many.state(k), independent=names or independent, **options)
            return result

        together = not (options["steady"] or gone or options["side"])
        return linearized(many, eom.numeric(self.settings), self.outputs, alone, gone, together)

    @staticmethod
    def _steady_with(flow: Flow, fixed: bool, tolerance: float) -> str:
        """The speeds that would be constant if they were chosen as independent, in place of a requested choice; "" if none are."""
        if not fixed:
            return ""
        other, verdict = _flow(flow.numeric, flow.state, Preference(), False, tolerance)
        return ", ".join(other.states[slice(*other.counts)]) if verdict.holds else ""

    def _linear(self, piece: Piece, verdict: Steadiness) -> Linear:
        eom, flow, slopes = self.eom, piece.flow, piece.output_slopes
        states, count = flow.states, len(flow.states)
        inputs, point = tuple(r.name for r in eom.inputs), state_from(eom, flow.state)
        cyclic = tuple(n for n, m in zip(states, verdict.matters, strict=True) if not m)
        a, b = flow.a + 0.0, flow.b + 0.0  # replaces −0 by 0
        return Linear(
            states, inputs, self.outputs.names, states[: flow.counts[0]], a, b, slopes[:, :count], slopes[:, count:],
            point, flow.rest, piece.outputs, flow.mass, cyclic, flow.scale, states[flow.counts[1] :],
        )  # fmt: skip


def linearizer(
    eom: Equations, *, outputs: Mapping[str, Any] | Sequence[Any] | None = None, settings: Settings | None = None
) -> Linearizer:
    """A function that linearizes `eom` at many operating points, compiled once; `outputs` and `settings` as for `linearize`."""
    check_equations(eom)
    return Linearizer(eom, outputs_of(eom, outputs), settings)


@by_keyword
def linearize(
    eom: Equations,
    state: State | Any | None = None,
    *,
    outputs: Mapping[str, Any] | Sequence[Any] | None = None,
    independent: Sequence[Any] = (),
    leave_out: Sequence[Any] = (),
    steady: bool = True,
    tolerance: float = 1e-8,
    side: Side | None = None,
    settings: Settings | None = None,
    **values: Unpack[StateValues],
) -> Linear | Any:
    """Linearize the equations, ẋ = A x + B r, about an equilibrium or a steady motion, with all constraints.

    Dependent perturbations are eliminated by the implicit function theorem. In a steady motion, coordinates on which the dynamics
    do not depend may vary: the heading and the position of a rolling disk.

    Parameters
    ----------
    eom : Equations
    state : a `kn.State` instead of the values that follow
    q, u : the operating point, by symbol or name; it must satisfy the constraints, values left out are solved for as in `assemble`
    parameters, inputs, states : by symbol or name; parameters and further states left out take their defaults, inputs left out are
        zero
    outputs : expressions y by name, in coordinates, rates, speeds, accelerations, reactions, states and inputs
    independent : coordinates and speeds to be independent; by default speeds as in `eom`, coordinates by rank
    leave_out : states to remove, on which no other state depends; "cyclic" removes all of them
    steady : False allows any state of a motion, with its rates of change in `rates`
    tolerance : accelerations and rates below this fraction of their terms count as zero
    side : the direction of the derivative, as perturbations of states and inputs such as {"x": 1}, if a switch (|x|, max, where,
        …) is at its corner
    settings : a `kn.Settings` for the compiled code

    If values are arrays, or a Dataset from `kn.assemble`, the result is an xarray Dataset with the dimension instance: A, B, C, D,
    rates and output_values over rate, state, input and output. Independent states are those of the first instance; steady=False is
    fastest. A beam that spins faster at the point than its functions or missing stiffening allow gives a warning, as in motions.

    Returns
    -------
    Linear, or xarray.Dataset

    Raises
    ------
    SimulationError
        if the point violates the constraints, or is neither an equilibrium nor a steady motion; the message names the nonzero rates
    CornerError
        if a switch is at its corner, with different derivatives or values on its two sides, and `side` is not given
    SingularError
        if the constraints lose rank at the point
    """
    evaluate = linearizer(eom, outputs=outputs, settings=settings)
    linear = evaluate(
        state, independent=independent, leave_out=leave_out, steady=steady, tolerance=tolerance, side=side, **values
    )
    if isinstance(linear, Linear):
        warn_of_beams(eom, [linear.point])
        warn_of_contacts(eom, [linear.point])
    return linear


@np.errstate(invalid="ignore")
def _flow(
    numeric: Numeric[Equations], state: StateArrays, choice: Preference, fixed: bool, tolerance: float
) -> tuple[Flow, Steadiness]:
    """The flow and its steadiness; if this fails because of speeds that are cyclic once they are dependent, with that choice instead.

    The set of changing speeds does not depend on the choice of dependent ones, and so neither does the verdict.
    """
    eom, flow = numeric.equations, flow_at(numeric, state, choice)
    verdict = steadiness(flow, tolerance)
    if verdict.holds or fixed or eom.embedding is None:
        return flow, verdict
    second = flow_at(numeric, state, Preference(choice.q, changing(flow, tolerance)), known=flow)
    again = steadiness(second, tolerance)
    return (second, again) if again.holds else (flow, verdict)


def choice_of(numeric: Numeric[Equations], independent: Any) -> Preference:
    """The coordinates and speeds to be dependent if those in `independent` are not; by default as declared in the system."""
    eom, known = numeric.equations, numeric.value(perturbations).names
    names = names_in("independent= as a list", independent)
    speeds = [u.name for u in eom.speeds]
    unknown = (n for n in names if n not in known and n not in speeds)
    expect.none(unknown, f"independent= among {', '.join((*known, *speeds))}", error=ValueMissingError)
    wished = {q.name for q in eom.system.dependent_coordinates}
    chosen_q = [i for i, n in enumerate(known) if (n not in names if set(names) & set(known) else n in wished)]
    chosen_u = [i for i, n in enumerate(speeds) if n not in names] if set(names) & set(speeds) else []
    return Preference(tuple(chosen_q), tuple(chosen_u))


def _check_independent(flow: Flow, names: Sequence[str]) -> None:
    count = len(flow.tangents.free_q)
    known, speeds = flow.numeric.value(perturbations).names, [u.name for u in flow.numeric.equations.speeds]
    for all_names, got in ((known, flow.states[:count]), (speeds, flow.states[slice(*flow.counts)])):
        asked = [n for n in all_names if n in names]
        if asked and set(asked) != set(got):
            raise SimulationError(
                f"Expected independent= to contain {len(got)} of {', '.join(all_names)} that determine the others, got "
                f"{', '.join(asked)}. At this point, choose for example {', '.join(got)}."
            )


def _not_steady(flow: Flow, verdict: Steadiness, speeds: str) -> str:
    count, perturbed = len(flow.tangents.free_q), flow.numeric.value(perturbations)
    free_u = flow.tangents.free_u
    eom = flow.numeric.equations
    symbols = [perturbed.symbols[i] for i in flow.tangents.free_q] + [*(eom.speeds[i] for i in free_u), *eom.states]

    def rate_of(i: int) -> str:
        s = symbols[i]
        unit = f" {s.unit}/s" if s is not None and s.unit else ""
        return f"{flow.states[i]}' = {flow.rest[i]:.6g}{unit}"

    accelerations = [rate_of(i) for i in verdict.left if i >= count]
    rates = [rate_of(i) for i in verdict.left if i < count]
    head = "Expected an equilibrium or a steady motion to linearize about, got a state"
    if accelerations:
        also = f" (and the rates {', '.join(rates)})" if rates else ""
        what = f"at which these accelerations are not zero: {', '.join(accelerations)}{also}"
    elif rates:
        what = f"at which coordinates change on which the speeds depend: {', '.join(rates)}"
    elif verdict.varies == (-1,):
        what = "whose equations depend on the time t"
    else:
        what = f"at which coordinates change on which the equations depend: {', '.join(rate_of(i) for i in verdict.varies)}"
    if speeds:
        return f"{head} {what}. With independent speeds {speeds} it is a steady motion: name these in independent=, or leave it out."
    return (
        f"{head} {what}. Find one with kn.trim(eom, …), or linearize at this instant with steady=False.{left_out(eom)}"
    )


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicLinear(Attributes):
    """ẋ = A x + B r with A and B as expressions; `states` names x, the first `coordinates` of them perturbations of coordinates."""

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    coordinates: int
    A: Matrix
    B: Matrix

    def __repr__(self) -> str:
        return f"SymbolicLinear({', '.join(self.states)}; A {self.A.shape}, B {self.B.shape})"


def linearize_symbolic(eom: Equations, point: Mapping[Any, Any]) -> SymbolicLinear:
    """Linearize the equations about an equilibrium or a steady motion symbolically: A and B as exact expressions of parameters.

    Parameters
    ----------
    eom : Equations
    point : coordinates, speeds and inputs as expressions of parameters, by symbol or name; those left out stay symbols

    Raises
    ------
    SimulationError
        if, for sampled values of the symbols, the point violates the constraints, or is neither an equilibrium nor a steady motion
    CornerError
        if a switch (|x|, max, where, …) is at its corner there, with different derivatives on its two sides
    """
    check_equations(eom)
    perturbed, equations = perturbations(eom), unsolved(eom.derived)
    plain = [equations.rates[i] for i in perturbed.coordinates]
    flow = [*plain, *equations.spins, *without_unknowns(eom.solved, [*eom.accelerations, *eom.state_rates])]
    turned = spread(perturbed, np.array(eom.coordinates, dtype=object)).T
    seeds: list[dict[Expr, Expr]] = [dict(zip(eom.coordinates, map(as_expr, row), strict=True)) for row in turned]
    seeds += [{s: ONE} for s in (*eom.speeds, *eom.states, *eom.inputs)]
    lengths = [sub(dot(s.coordinates, s.coordinates), ONE) for s in eom.system.euler_parameters]
    at = {s: as_expr(e) for s, e in named_values("the point", (*eom.state, *eom.inputs), point).items()}
    held = [*equations.configuration, *equations.motion]
    values, slopes = _of_either_side([*flow, *held, *lengths], at, seeds)
    width, n, rates, c = len(perturbed.names), len(eom.speeds), len(flow), len(equations.configuration)
    slopes[:width, :width] = slopes[:width, :width] - turning_rates(values[:width], len(plain))
    point_values = _sampled(eom, at, free_symbols([*values, *slopes.flat, *at.values()]))

    def sample(exprs: Entries) -> Array:
        return np.array(evaluate(list(map(as_expr, exprs.flat)), point_values), dtype=float).reshape(exprs.shape)

    names = [*(c.name for c in eom.system.holonomic), *(c.name for c in eom.constraints.constraints)]
    names += ["unit length of Euler parameters"] * len(lengths)
    came = "one that violates {} with parameters at their defaults"
    cure = "Give expressions that satisfy them for all parameters."
    expect.none(misses(names, sample(values[rates:])), "a point on the constraints", came, cure, error=SimulationError)
    wished = [k for k, q in enumerate(perturbed.symbols) if q in set(eom.system.dependent_coordinates)]
    own = eom.embedding.partition.dependent if eom.embedding else ()
    by_q, by_u = (_in_symbols(sample, preferred) for preferred in (wished, own))
    tangent = tangents(slopes[rates:][:c], slopes[rates:][c : len(held)], width, n, by_q, by_u)
    rows = [*tangent.free_q, *(width + i for i in (*tangent.free_u, *range(n, n + len(eom.states))))]
    result = slopes[rows] @ tangent.moves
    states = (*(perturbed.names[i] for i in tangent.free_q), *(eom.speeds[i].name for i in tangent.free_u))
    counts = len(tangent.free_q), len(states)
    states = (*states, *(s.name for s in eom.states))
    a, b = result[:, : len(rows)], result[:, len(rows) :]
    left = zip(states, sample(values[rows]), dependence(sample(a), *counts), strict=True)
    remains = (f"{s}' = {x:.6g}" for s, x, matters in left if matters and not abs(x) <= GIVEN)
    came = "a point at which {} with parameters at their defaults"
    expect.none(remains, "an equilibrium or a steady motion", came, error=SimulationError)
    inputs = tuple(r.name for r in eom.inputs)
    return SymbolicLinear(states, inputs, len(tangent.free_q), Matrix(a, a.shape), Matrix(b, b.shape))


def _sampled(eom: Equations, at: Mapping[Expr, Expr], symbols: Iterable[Expr]) -> Mapping[Any, float]:
    """Sample values of all symbols; Euler parameters that the point leaves open are scaled to unit length."""
    values = values_of((*symbols, *eom.coordinates, *eom.parameters), SEED)
    for s in eom.system.euler_parameters:
        left = [e for e in s.coordinates if e not in at]
        rest = 1.0 - sum(float(evaluate(at[e], values)) ** 2 for e in s.coordinates if e in at)
        size = np.linalg.norm([values[e] for e in left])
        values |= {e: float(values[e] / size) * max(rest, 0.0) ** 0.5 for e in left}
    return values


def _of_either_side(
    roots: Sequence[Expr], at: Mapping[Expr, Expr], seeds: Sequence[Mapping[Expr, Expr]]
) -> tuple[Entries, Entries]:
    """Roots and their derivatives along seeds (roots × seeds) at the point; raises CornerError if sides of a switch differ."""

    def made(own: Sequence[Expr], there: Mapping[Expr, Expr]) -> list[Expr]:
        columns = [own]
        for seed in seeds:
            known: dict[Expr, Expr] = {}
            columns.append([tangent(e, seed, known) for e in own])
        memo: dict[Expr, Expr] = {}
        return [substituted(e, there, memo) for column in columns for e in column]

    flat, corner = on_either_side(roots, at, made)
    if corner is not None:
        raise CornerError(
            f"Expected a point at which the equations have one derivative, got a corner: {cut(str(corner.nodes[0]), 80)} "
            f"switches at {cut(str(corner.quantity))} = 0. Use kn.linearize(eom, …, side=…), which computes a one-sided "
            "derivative in numbers."
        )
    table = np.array(flat, dtype=object).reshape(-1, len(roots))
    return table[0], table[1:].T


def _in_symbols(sample: Callable[[Entries], Array], preferred: Sequence[int]) -> FreePart:
    """Symbolic solution for dependent variables chosen by their numerical rank at a sample."""

    def solve(square: Entries, right: Entries) -> Entries:
        solutions = solve_lu(Matrix(square).rows, Matrix(right.T).rows)
        return np.array(solutions, dtype=object).reshape(right.T.shape).T

    def solved(a: Entries, rest: Entries) -> tuple[tuple[int, ...], Entries]:
        return by_free_part(a, rest, choose(sample(a), preferred), solve)

    return solved


PARTS = {"A": "A", "B": "B", "C": "C", "D": "D", "rates": "rates", "values": "output_values"}
"""Arrays of a `Linear`, with their names in a Dataset, in which `values` is already a method."""
_TINY = np.finfo(float).tiny


def linearized(
    poses: Poses,
    numeric: Numeric[Equations],
    outputs: Outputs,
    alone: Callable[[int, Sequence[str]], Linear],
    leave_out: Sequence[str],
    together: bool,
) -> Any:
    """A, B, C, D, rates and output values of all states as a Dataset, without the states `leave_out`.

    `alone` linearizes state k by itself with named independent perturbations; `together` allows all states at once.
    """

    def begun(k: int) -> tuple[Linear, Linear]:
        whole = alone(k, ())
        return whole, whole.without(*leave_out)

    causes = dict(poses.failed)
    place = poses.first(begun, causes, (SimulationError, ArithmeticError))
    if place is None:
        raise SimulationError(f"Expected a state to linearize about, got none of {poses.count}. {causes[0]}")
    whole_first, first = place[1]
    names = [s for s in whole_first.states if s not in whole_first.further]
    gone = [s for s in whole_first.states if s not in first.states]
    found = {part: np.full((poses.count, *getattr(first, part).shape), np.nan) for part in PARTS}
    sure = np.zeros(poses.count, dtype=bool)
    if together and is_plain(numeric, outputs):
        sure = _together(poses, numeric, outputs, first, found)
    for k, own in poses.rest(lambda k: alone(k, names).without(*gone), causes, set(np.flatnonzero(sure))):
        for part, whole in found.items():
            whole[k] = getattr(own, part)
    for whole in found.values():
        whole[list(causes)] = np.nan
    return _dataset(poses, first, found, causes)


def is_plain(numeric: Numeric[Equations], outputs: Outputs) -> bool:
    """Whether there are no switches, lengths, false poles or Euler parameters."""
    tables = (numeric.value(make, *outputs.roots) for make in (all_switches, lengths))
    return numeric.equations.solved.twin is None and not numeric.value(perturbations).sets and not any(tables)


def _together(
    poses: Poses, numeric: Numeric[Equations], outputs: Outputs, first: Linear, found: Mapping[str, Array]
) -> Mask:
    """Fill the arrays `found` for all states, and return where they are reliable."""
    t, p, r = poses.numbers()
    state, sure, chosen = (t, _states(poses), p, r), np.zeros(poses.count, dtype=bool), dict[str, list[int]]()
    for at in blocks(poses.count):
        part = {name: whole[at] for name, whole in found.items()}
        sure[at] = _of_block(numeric, outputs, first, tuple(x[at] for x in state), part, chosen)
    return sure


def _of_block(
    numeric: Numeric[Equations],
    outputs: Outputs,
    first: Linear,
    state: tuple[Array, ...],
    found: Mapping[str, Array],
    chosen: dict[str, list[int]],
) -> Mask:
    """As `_together`, for a block of states; rows for dependent variables are stored in `chosen` at the first block."""
    eom, run, count = numeric.equations, coded(numeric), len(state[0])
    nq, n, keep = len(eom.coordinates), len(eom.speeds), list(regular_rows(eom))
    own, solved, sure = _solved(numeric, keep, state)
    z = np.zeros(own.right.shape)
    z[:, keep] = np.where(sure[:, None], solved.x[:, :, 0], 0.0)
    sloped = run(slopes)(*state, z)
    sure &= _placed(eom, own, state)
    free_q = [i for i, q in enumerate(eom.coordinates) if q.name in first.coordinates]
    free_u = [i for i, u in enumerate(eom.speeds) if u.name in first.speeds]
    by_free = partial(_by_free, settings=numeric.settings, kept=chosen)
    of_q, sure_q = by_free("q", sloped.configuration, range(nq), free_q, range(nq + n, sloped.configuration.shape[2]))
    shift = sloped.motion[:, :, :nq] @ of_q
    shift[:, :, len(free_q) :] += sloped.motion[:, :, nq + n :]
    whole = np.concatenate([sloped.motion[:, :, nq : nq + n], shift], axis=2)
    of_u, sure_u = by_free("u", whole, range(n), free_u, range(n, whole.shape[2]))
    sure &= sure_q & sure_u
    moves = Tangents.of(free_q, of_q, free_u, of_u).moves
    answer = np.zeros((*z.shape, moves.shape[2]))
    answer[:, keep] = -(solved.inverse @ (sloped.residual @ moves)[:, keep])
    rows = np.concatenate([(sloped.rates @ moves)[:, free_q], answer[:, free_u], sloped.states @ moves], axis=1)
    rates = rows.shape[1]
    found["A"][:], found["B"][:] = rows[:, :, :rates], rows[:, :, rates:]
    found["rates"][:] = np.concatenate([own.rates[:, free_q], z[:, free_u], own.states], axis=1)
    if outputs.roots:
        out = run(answers, *outputs.roots)(*state, z)
        by = out.slopes @ np.concatenate([moves, answer], axis=1)
        found["values"][:], found["C"][:], found["D"][:] = out.values, by[:, :, :rates], by[:, :, rates:]
    finite = [np.isfinite(x.reshape(count, -1)).all(axis=1) for x in found.values() if x.size]
    return np.asarray(sure & np.logical_and.reduce(finite) if finite else sure)


def _states(poses: Poses) -> Array:
    """(q, u, a) of all states (k × …)."""
    eom, x = poses.eom, np.zeros((poses.count, len(poses.eom.state)))
    given = {**poses.given("q"), **poses.given("u"), **poses.given("states")}
    for i, s in enumerate(eom.state):
        x[:, i] = given[s] if s in given else s.default or 0.0 if s in set(eom.states) else np.nan
    return x


def _solved(numeric: Numeric[Equations], keep: Sequence[int], state: tuple[Array, ...]) -> tuple[Values, Stack, Mask]:
    """K z = k without rows of redundant constraints: its values, its solution, and where K is certainly regular."""
    routine = numeric.routine(values)
    rows = routine.flat(*state)
    matrix, right = routine.bundle.places("matrix"), routine.bundle.places("right")
    a, b = MatrixEntries(rows, matrix[np.ix_(keep, keep)]), MatrixEntries(rows, right[list(keep), None])
    found = solve_each(a, b, numeric.settings, inverse=True)
    sure = found.regular(NEAR_SINGULAR**2) & np.isfinite(found.x[:, :, 0]).all(axis=1)
    found.inverse[~sure] = 0.0
    return routine.bundle.split(rows), found, np.asarray(sure)


def _placed(eom: Equations, own: Values, state: tuple[Array, ...]) -> Mask:
    """Which states are on the constraints within rounding, with closures on their specified branches."""
    t, x, p, r = state
    nq, n = len(eom.coordinates), len(eom.speeds)
    off = (np.abs(own.configuration) > ROUNDED_CHAIN * np.maximum(own.configuration_terms, _TINY)).any(axis=1)
    terms = (np.abs(own.constraints(n)) @ np.abs(x[:, nq : nq + n, None]))[:, :, 0]
    off |= (np.abs(own.motion) > ROUNDED_CHAIN * np.maximum(terms, _TINY)).any(axis=1)
    if eom.derived.conditions.branches:
        rest = StateArrays(t, x, p, r).given(eom)
        off |= eom.derived.conditions.at(rest).turned(x[:, :nq]).any(axis=1)
    return np.asarray(~off)


def _by_free(
    name: str,
    a: Array,
    own: Sequence[int],
    free: Sequence[int],
    rest: Sequence[int],
    *,
    settings: Settings,
    kept: dict[str, list[int]],
) -> tuple[Array, Mask]:
    """S of x = S (x_free, y), the solution of A x + rest y = 0 at all states, and where A is certainly regular.

    A is in the columns `own` of `a` (k × m × …), the factor of y in the columns `rest`. The chosen rows are stored in `kept` by name.
    """
    dependent = [i for i in own if i not in set(free)]
    columns = [*(own[i] for i in free), *rest]
    solution = np.zeros((len(a), len(own), len(columns)))
    solution[:, list(free), range(len(free))] = 1.0
    if not dependent:
        return solution, np.ones(len(a), dtype=bool)
    sure = np.asarray(np.isfinite(a).all(axis=(1, 2)))
    if name not in kept and sure.any():
        kept[name] = sorted(choose(a[int(np.argmax(sure))][:, dependent]).rows)
    rows = kept.get(name, [])
    if len(rows) < len(dependent):
        return solution, np.zeros(len(a), dtype=bool)
    entries, places = a.reshape(len(a), -1), np.arange(a[0].size).reshape(a.shape[1:])
    found = solve_each(
        MatrixEntries(entries, places[np.ix_(rows, dependent)]),
        MatrixEntries(entries, places[np.ix_(rows, columns)]),
        settings,
    )
    sure &= found.regular(NEAR_SINGULAR)
    solution[:, dependent] = np.where(sure[:, None, None], -found.x, 0.0)
    return solution, sure


def _dataset(poses: Poses, first: Linear, found: Mapping[str, Array], causes: Mapping[int, str]) -> Any:
    xarray = package("xarray")
    dims: dict[str, tuple[str, ...]] = {"A": ("rate", "state"), "B": ("rate", "input"), "rates": ("rate",)}
    dims |= {"C": ("output", "state"), "D": ("output", "input"), "values": ("output",)}
    names = {"rate": [f"{s}'" for s in first.states], "state": list(first.states), "input": list(first.inputs)}
    names["output"] = list(first.outputs)
    told = {"rates": "rates of the states at the point itself", "values": "outputs at the point itself"}
    own = {
        PARTS[part]: xarray.Variable(
            ("instance", *dims[part]), x, {"long_name": told.get(part, f"{part} of the linear equations")}
        )
        for part, x in found.items()
    }
    return poses.dataset(own, causes, names)

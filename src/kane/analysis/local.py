# SPDX-License-Identifier: BSD-3-Clause
"""The unsolved equations at a state in numbers: solution of K z = k, and exact derivatives of all quantities in q, u, a and inputs.

Further, named outputs h(q, u, u̇, λ, R, r), and the switching functions of equations and outputs.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from kane import expect
from kane.analysis.stacks import MatrixEntries, surely_independent
from kane.analysis.state_checks import StateArrays
from kane.dynamics.constraints.partition import choose
from kane.dynamics.formulation.recursive import WAYS
from kane.dynamics.readings.quantities import asked
from kane.dynamics.readings.regularity import undirected
from kane.dynamics.readings.unsolved import Unsolved, partials, unsolved
from kane.dynamics.slopes import residual_slopes
from kane.equations.compiled import Numeric, ports
from kane.equations.equations import Equations
from kane.errors import ArgumentError, SingularError, ValueMissingError, cut
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr
from kane.expr.piecewise import SwitchedQuantity, switches
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Symbol, time
from kane.expr.visit import substituted
from kane.kinematics.freedoms import Unsuited
from kane.numeric.arrays import Array
from kane.numeric.rank import balanced, mobility, singular, surely_regular
from kane.numeric.scale import NEAR_SINGULAR, SOLVE_RANK, SURE_RANK
from kane.program.from_expressions import Bundle
from kane.program.native.machine import Settings
from kane.program.program import Port

_TOLD = 3
_TINY = np.finfo(float).tiny


R_co = TypeVar("R_co")


class RoutineSource(Protocol):
    """An evaluator of the equations: run(make, *arguments) is the routine of the bundle make(equations, *arguments)."""

    def __call__(self, make: Callable[..., Bundle[R_co]], *arguments: Any) -> Callable[..., R_co]:
        """The routine, a function of numbers for the bundle's ports."""


def coded(numeric: Numeric[Equations]) -> RoutineSource:
    """The evaluator by compiled code."""
    numeric.compile(values, slopes)
    return numeric.routine


class Values(NamedTuple):
    """K, k, f, A u + b, q̇, spins and ȧ at a state, or at many (leading axes), and the sizes of the terms of k, f and ȧ."""

    matrix: Array
    right: Array
    terms: Array
    configuration: Array
    configuration_terms: Array
    motion: Array
    rates: Array
    spins: Array
    states: Array
    state_terms: Array

    def constraints(self, n: int) -> Array:
        """The constraint matrix A (m × n), a block of K."""
        m = self.motion.shape[-1]
        return self.matrix[..., n : n + m, :n]


def values(eom: Equations) -> Bundle[Values]:
    """The bundle of K, k, the constraints and the rates."""
    u, memo = unsolved(eom.derived), Sizes()
    terms = [size(k, memo) for k in u.right]
    groups = {"matrix": Matrix(u.matrix), "right": u.right, "terms": terms}
    held = [size(f, memo) for f in u.configuration]
    groups |= {"configuration": u.configuration, "configuration_terms": held, "motion": u.motion}
    groups |= {"rates": u.rates, "spins": u.spins}
    groups |= {"states": u.states, "state_terms": [size(f, memo) for f in u.states]}
    return Bundle("values", ports(eom.derived), Values, groups)


class Slopes(NamedTuple):
    """Derivatives of f, A u + b, q̇, spins, ȧ, and of K z − k at fixed z, with one column for each variable."""

    configuration: Array
    motion: Array
    rates: Array
    spins: Array
    states: Array
    residual: Array


def slopes(eom: Equations, *by: Symbol) -> Bundle[Slopes]:
    """Derivatives in the symbols `by`, by default in q, u, a and the inputs, with z as an argument."""
    u = unsolved(eom.derived)
    symbols = by or (*eom.state, *eom.inputs)
    groups = {"configuration": u.configuration, "motion": u.motion, "rates": u.rates, "spins": u.spins}
    groups |= {"states": u.states}
    rows = iter(partials(u.places, symbols))
    derivatives = {name: Matrix(islice(rows, len(f)), (len(f), len(symbols))) for name, f in groups.items()}
    derivatives["residual"] = _residual_slopes(eom, u, symbols)
    return Bundle("slopes", (*ports(eom.derived), unknowns(eom)), Slopes, derivatives)


def _residual_slopes(eom: Equations, u: Unsolved, symbols: Sequence[Symbol]) -> Matrix:
    """∂(K z − k)/∂symbols, for trees in the speeds from the tangent of inverse dynamics."""
    n = len(eom.speeds)
    if eom.route not in WAYS:
        return partials(u.residual, symbols)
    try:
        own = residual_slopes(eom.derived, symbols)
    except Unsuited:
        return partials(u.residual, symbols)
    held = [dot(row[n:], u.unknowns[n:]) for row in u.matrix[:n]]
    rest = partials([*held, *u.residual[n:]], symbols)
    return Matrix([*(own + rest.take(range(n))).rows, *rest.rows[n:]], rest.shape)


def values_at(run: RoutineSource, state: StateArrays) -> Values:
    """K, k, constraints and rates at a state."""
    return run(values)(*state.arguments)


def slopes_at(run: RoutineSource, state: StateArrays, z: Array, *by: Symbol) -> Slopes:
    """Derivatives at a state and z in the symbols `by`, by default in q, u, a and the inputs."""
    return run(slopes, *by)(*state.arguments, z)


def unknowns(eom: Equations) -> Port:
    """The port of z = (u̇, λ, R)."""
    return Port("z", unsolved(eom.derived).unknowns, noun="unknowns")


def at_false_pole(eom: Equations) -> str:
    """A sentence for messages if the declared speeds may be singular where the motion is not (a false pole), else ""."""
    if eom.solved.twin is None:
        return ""
    pivots = [p for p in dict.fromkeys(eom.derived.kinematical.pivots) if not is_constant_in_time([p])]
    told = ", ".join(f"{cut(p)}" for p in pivots[:_TOLD])
    return (
        "Expected speeds in which the unsolved equations are regular at this state, got W of q' = W u + X that divides by "
        f"{told}, which is zero or nearly zero here: a false pole, a singularity of the speeds but not of the motion. "
        "eom.evaluate, compiled code and kn.simulate are valid there; here, declare speeds that need no such division, "
        'System(speeds=…), "rates" for u = q\', or choose a state farther from it.'
    )


def independent_rows(eom: Equations, a: Array) -> tuple[int, ...]:
    """Indices of independent constraints, given A in numbers; the others are redundant.

    Raises SingularError if A has a lower rank here than elsewhere.
    """
    if eom.embedding is None:
        return ()
    rows = eom.embedding.partition.rows
    if singular(balanced(a[list(rows)])).regular(SURE_RANK):
        return rows
    partition = choose(a)
    if len(partition.rows) < len(rows):
        names = ", ".join(eom.constraints.constraints[i].name for i in partition.redundant)
        raise SingularError(
            at_false_pole(eom)
            or f"Expected constraints of constant rank {len(rows)}, got rank {len(partition.rows)} at this state: it is a "
            f"singular configuration, where the motion may branch and has no derivative. {names} follow from the others "
            "only here. Choose a nearby state."
        )
    return partition.rows


def independent_rows_of(eom: Equations, a: MatrixEntries, settings: Settings) -> list[tuple[int, ...]]:
    """`independent_rows` for each of several A (k × m × n)."""
    if eom.embedding is None or not len(a.rows):
        return [()] * len(a.rows)
    rows = eom.embedding.partition.rows
    sure = surely_independent(MatrixEntries(a.rows, a.places[list(rows)]), SURE_RANK, settings)
    return [rows if surely else independent_rows(eom, a.of(k)) for k, surely in enumerate(sure.tolist())]


def unit_sizes(matrix: Array, n: int, m: int) -> tuple[Array, Array]:
    """The sizes of rows and columns of K, with n speeds and m constraints, from units alone, common to each kind of unknown.

    Rounding residues are recognized beside the largest entries; m r² of a satellite is 10¹⁵ times its m.
    """
    own = 1 / np.maximum(np.linalg.norm(mobility(matrix[:n, :n], matrix[n : n + m, :n]), axis=1), _TINY)
    sizes = np.abs(matrix)
    m += n

    def kind(part: Array) -> Array:
        return np.full(len(part), part.max(initial=0) or 1.0)

    columns = np.concatenate([own, *(kind((sizes[:n, k] / own[:, None]).T) for k in (slice(n, m), slice(m, None)))])
    # without reactions in loads, reactions follow from u̇, and M_a does not matter for regularity
    auxiliary = sizes[m:, :n] / own if sizes[:n, m:].any() else sizes[m:, m:]
    rows = np.concatenate([own, kind(sizes[n:m, :n] / own), kind(auxiliary)])
    return rows, columns


def solver(eom: Equations, values: Values, state: StateArrays | None = None) -> Callable[[Array], Array]:
    """A function that solves K z = right for regular K, with multipliers of redundant constraints zero.

    If a `state` is given, the error for values that are not finite names the load that has none there.
    """
    n = len(eom.speeds)
    keep = _rows_with(eom, independent_rows(eom, values.constraints(n)))
    matrix = values.matrix[np.ix_(keep, keep)]
    if not np.all(np.isfinite(matrix)) or not np.all(np.isfinite(values.right)):
        load = undirected(eom.solved, state.numbers(eom)) if state is not None else ""
        raise SingularError(
            at_false_pole(eom)
            or (
                load and f"Expected equations of motion that are finite at this state, got infinity or NaN: the {load}."
            )
            or "Expected equations of motion that are finite at this state, got infinity or NaN: coordinates, speeds or "
            "parameters are singular here."
        )
    scaled, least = (
        balanced(matrix / np.outer(*unit_sizes(values.matrix, n, len(values.motion)))[keep][:, keep]),
        NEAR_SINGULAR if eom.solved.twin else SOLVE_RANK,
    )
    # the bound by the inverse takes a tenth of the time of singular values
    if matrix.size and not (surely_regular(scaled[None], least)[0] or singular(scaled).regular(least)):
        raise SingularError(
            at_false_pole(eom)
            or "Expected equations of motion that determine u' and the reactions, got a singular matrix at this state: a "
            "speed moves no mass here, or only combinations of reactions are determined."
        )
    return _solving(matrix, keep)


def _rows_with(eom: Equations, constraints: Iterable[int]) -> list[int]:
    """Indices of the rows of K, with those of the given constraints only."""
    n, m, s = len(eom.speeds), len(eom.b), len(eom.reactions)
    return [*range(n), *(n + i for i in constraints), *range(n + m, n + m + s)]


def regular_rows(eom: Equations) -> tuple[int, ...]:
    """Indices of the rows of K without those of redundant constraints."""
    return tuple(_rows_with(eom, sorted(eom.embedding.partition.rows) if eom.embedding is not None else ()))


def quick_solver(eom: Equations, values: Values, state: StateArrays | None = None) -> Callable[[Array], Array]:
    """As `solver`, without tests of rank, for the rows of the embedding; raises SingularError if K is exactly singular."""
    keep = list(regular_rows(eom))
    return _solving(values.matrix[keep][:, keep], keep)


def _solving(matrix: Array, keep: Sequence[int]) -> Callable[[Array], Array]:
    """A function that solves K z = right in the rows and columns `keep`, with the other z zero."""

    def solve(right: Array) -> Array:
        z = np.zeros(right.shape)
        try:
            z[keep] = np.linalg.solve(matrix, right[keep])
        except np.linalg.LinAlgError as error:
            raise SingularError("Expected regular equations of motion at this state, got singular ones.") from error
        return z

    return solve


class Outputs(NamedTuple):
    """Named expressions h(q, u, u̇, λ, R, r, t)."""

    names: tuple[str, ...]
    roots: tuple[Expr, ...]


def outputs_of(eom: Equations, outputs: Mapping[str, Any] | Sequence[Any] | None) -> Outputs:
    """Outputs with rates written in speeds; those of a sequence are named by their text."""
    if outputs is None:
        return Outputs((), ())
    listed = isinstance(outputs, Sequence) and not isinstance(outputs, str | Expr)
    expected = "outputs as a list or a dict {name: expression}"
    expect.that(listed or isinstance(outputs, Mapping), expected, outputs, error=ArgumentError)
    pairs = outputs.items() if isinstance(outputs, Mapping) else [(e, e) for e in outputs]
    names, roots = [], []
    for key, e in pairs:
        name = str(key)
        try:
            wanted = asked(eom.derived, e)
        except TypeError as error:
            raise ArgumentError(
                f"Expected an expression, vector or name as the output {name!r}, got {cut(repr(e))}."
            ) from error
        if wanted.shape not in ((), (3,)) or wanted.parts is not None:
            raise ArgumentError(f"Expected an expression, vector or name as the output {name!r}, got {cut(repr(e))}.")
        names += [f"{name}.{axis}" for axis in "xyz"] if wanted.shape else [name]
        roots += [substituted(eom.in_speeds(root), dict.fromkeys(eom.auxiliary_speeds, ZERO)) for root in wanted.roots]
    allowed = {time, *eom.state, *eom.parameters, *eom.inputs, *unknowns(eom).symbols}
    unknown = (s for s in free_symbols(roots) if s not in allowed)
    cure = "A reaction must be listed in System(reactions=…)."
    expect.none(unknown, "outputs in symbols of the system", cure=cure, error=ValueMissingError)
    return Outputs(tuple(names), tuple(roots))


class Answers(NamedTuple):
    """Outputs h, and ∂h/∂(q, u, a, r, z) with a row for each output."""

    values: Array
    slopes: Array


def answers(eom: Equations, *roots: Expr) -> Bundle[Answers]:
    """The bundle of outputs h and their derivatives, with z as an argument."""
    z = unknowns(eom)
    slopes = partials(roots, (*eom.state, *eom.inputs, *z.symbols))
    return Bundle("outputs", (*ports(eom.derived), z), Answers, {"values": roots, "slopes": slopes})


class SwitchValues(NamedTuple):
    """Switching functions c, the sizes of their terms, and ∂c/∂(q, u, a, r, z) with a row for each."""

    quantities: Array
    sizes: Array
    slopes: Array


def all_switches(eom: Equations, *outputs: Expr) -> tuple[SwitchedQuantity, ...]:
    """The switches of the unsolved equations and of outputs."""
    u = unsolved(eom.derived)
    return switches((*u.places, *u.residual, *outputs))


def turning(eom: Equations, *outputs: Expr) -> Bundle[SwitchValues]:
    """The bundle of the switching functions of `all_switches`, in their order, with z as an argument."""
    z, memo = unknowns(eom), Sizes()
    quantities = [s.quantity for s in all_switches(eom, *outputs)]
    slopes = partials(quantities, (*eom.state, *eom.inputs, *z.symbols))
    groups = {"quantities": quantities, "sizes": [size(c, memo) for c in quantities], "slopes": slopes}
    return Bundle("turning", (*ports(eom.derived), z), SwitchValues, groups)

# SPDX-License-Identifier: BSD-3-Clause
"""`inverse`: inverse and mixed dynamics. Accelerations, inputs and reactions are given or unknown, in any combination.

    M u̇ − Aᵀ λ − G R − H r = f₀,   A u̇ = −(Ȧ u + ḃ),   M_a u̇ − A_aᵀ λ − G_a R − H_a r = f_a0

is linear in (u̇, λ, R, r): the columns of given quantities move to the right-hand side. The multipliers are always unknown.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Unpack

import numpy as np

from kane import expect
from kane.analysis.local import at_false_pole, independent_rows_of, unit_sizes
from kane.analysis.many.poses import poses
from kane.analysis.stacks import MatrixEntries, solve_each
from kane.analysis.state_checks import StateArrays, check_branch, check_configuration, check_unit_length
from kane.dynamics.readings.quantities import parameter_values
from kane.dynamics.readings.unsolved import Unsolved, unsolved
from kane.equations.compiled import ports
from kane.equations.equations import Equations, check_equations
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import Attributes, NotAffineError, SimulationError, SingularError, ValueMissingError, cut
from kane.expr.differentiation import affine_forms
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Symbol, rate, time
from kane.numeric.arrays import Array, common_shape
from kane.numeric.rank import balance, singular
from kane.numeric.sampling import named_values, symbol_named
from kane.numeric.scale import INVERSE_RANK, STATE_RANK, TAKES_PART
from kane.program.from_expressions import Bundle
from kane.program.native.machine import Settings


@dataclass(frozen=True, slots=True, eq=False)
class Inverse(Attributes):
    """A function from `kn.inverse`: `inverse(q=…, u=…, given={…})` returns the `unknowns` by symbol; `given` must contain `known`."""

    eom: Equations
    unknowns: tuple[Symbol, ...]
    known: tuple[Symbol, ...]
    driven: tuple[Symbol, ...]
    settings: Settings | None = None

    @by_keyword
    def __call__(
        self,
        state: State | Any | None = None,
        *,
        given: Mapping[Any, Any] | None = None,
        **by_kind: Unpack[StateValues],
    ) -> dict[Symbol, Any] | Any:
        """The unknowns, by symbol, at a state, or at many states given by arrays, which broadcast.

        Parameters
        ----------
        state : a `kn.State` instead of q, u, inputs, parameters, t and states; or a Dataset from `kn.assemble`
        q, u : the state, by symbol or name, or in order; it must satisfy the constraints, dependent speeds may be left out
        given : values of the accelerations (`u1.dt` or "u1'"), inputs and reactions that are not unknown
        inputs : known inputs, instead of those in `given`, as in `**state.arguments`; unknown inputs in it are ignored
        states : values of further states; those left out take their defaults

        For a Dataset over instance, the result is a Dataset as well; a state at which the unknowns are not determined is marked by
        `cause`.

        Raises
        ------
        SingularError
            if the unknowns are not determined, with the undetermined combination; or if the constraints lose rank at a state
        """
        eom = self.eom
        if hasattr(state, "data_vars"):
            return self._of_dataset(state, given, by_kind)
        at = state_of(state, **by_kind)
        values = named_values("coordinates", eom.coordinates, at.q) | named_values("speeds", eom.speeds, at.u)
        values |= {a: a.default for a in eom.states} | named_values("states", eom.states, at.states)
        own = named_values("inputs", eom.inputs, at.inputs)
        values |= {s: v for s, v in own.items() if s in set(self.known)}
        values |= named_values("quantities that are given", self.known, given)
        missing = [s for s in (*eom.coordinates, *eom.independent_speeds, *self.known) if s not in values]
        if missing:
            cure = "Give them, by symbol or name."
            if eom.constraints.constraints and not set(missing) <= set(self.known):
                cure = "kn.assemble(eom, q=…, u=…) completes a state from the constraints: give its q and u."
            raise ValueMissingError(
                "Expected values of all coordinates, independent speeds and quantities that are not unknowns, got none for "
                f"{', '.join(s.name for s in missing)}. {cure}"
            )
        if eom.dependent_speeds:
            inputs = {s: v for s, v in values.items() if s in set(eom.inputs)}
            speeds = eom.evaluate(list(eom.speeds), replace(at, inputs=inputs))
            values |= dict(zip(eom.speeds, speeds, strict=True))
        sizes = named_values("parameters", eom.parameters, at.parameters)
        varied = {s: _floats(s, v) for s, v in sizes.items() if np.ndim(v)}
        plain = parameter_values(eom.system, sizes | {s: v.flat[0] if v.size else 1.0 for s, v in varied.items()})
        constants: dict[Expr, Any] = {**plain, **varied}
        arrays, times = {s: _floats(s, v) for s, v in values.items()}, _floats(time, at.t)
        shape = common_shape({time: times, **arrays, **varied})
        full = {s: np.broadcast_to(a, shape) for s, a in arrays.items()}
        x, r = (_table([full.get(s, 0.0) for s in own], shape) for own in (eom.state, eom.inputs))
        p = _table([constants[m] for m in eom.parameters], shape if varied else ())
        solution = self._solved(np.broadcast_to(times, shape), x, p, r, full)
        return {s: solution[..., k][()] for k, s in enumerate(self.unknowns)}

    def _of_dataset(self, state: Any, given: Mapping[Any, Any] | None, by_kind: StateValues) -> Any:
        """The unknowns at states of a Dataset; if the solution for all fails, each state is solved alone."""
        many = poses(self.eom, state, by_kind)
        assert many is not None
        own = named_values("quantities that are given", self.known, given)
        wrong = (f"{np.shape(v)} for {s}" for s, v in own.items() if np.shape(v) not in ((), (1,), (many.count,)))
        expect.none(wrong, f"{many.count} values of each array beside the Dataset", error=SimulationError)

        def at(k: int) -> dict[Symbol, Any]:
            return self(many.state(k), given={s: np.broadcast_to(v, many.count)[k] for s, v in own.items()})

        values, causes = np.full((len(self.unknowns), many.count), np.nan), dict(many.failed)
        try:
            found = self(many.of_state(), given=own)
            for row, s in zip(values, self.unknowns, strict=True):
                row[:] = found[s]
        except (SingularError, SimulationError):
            each, causes = many.each(at)
            for k, one in each.items():
                values[:, k] = [one[s] for s in self.unknowns]
        values[:, list(causes)] = np.nan
        return many.dataset(many.variables(self.unknowns, values), causes, {})

    def along(self, solution: Any, given: Mapping[Any, Any] | None = None) -> dict[Symbol, Array]:
        """The unknowns (n) at the samples of a motion from `kn.simulate`; known quantities not in `given` come from the motion."""
        own = named_values("quantities that are given", self.known, given)
        rest = [s for s in self.known if s not in own]
        taken = dict(zip(rest, solution[rest], strict=True)) if rest else {}
        q, u, a = (list(x.T) for x in (solution.q, solution.u, solution.a))
        at = State(q, u, states=a, parameters=dict(solution.parameters), t=solution.t)
        kept = [p for p in self.eom.parameters if p in at.parameters]
        along = zip(kept, solution[kept], strict=True) if kept else ()
        at.parameters.update({p: x for p, x in along if (x != at.parameters[p]).any()})  # parameters changed by events
        return self(at, given=own | taken)

    def _solved(self, t: Array, x: Array, p: Array, r: Array, full: Mapping[Expr, Array]) -> Array:
        eom = self.eom
        check_unit_length(eom, x)
        routine = eom.numeric(self.settings).routine(_mixed, *self.driven)
        flat = routine.flat(t, x, p, r)
        solution = routine.bundle.split(flat)
        if t.size:
            first = (0,) * t.ndim
            own = p[first] if p.ndim > 1 else p
            given = StateArrays(float(t[first]), x[first], own, r[first]).given(eom)
            check_configuration(
                eom, solution.configuration, solution.terms, given, "a state", "Assemble it with kn.assemble."
            )
        rest = StateArrays(t, x, p, r).given(eom)
        check_branch(eom, x[..., : len(eom.coordinates)], rest, "states", ", kn.guess(…) of the coordinates")
        told = _table([full[a] for a in self.known], t.shape).reshape(t.size, len(self.known))
        z = self._of_matrices(routine.bundle, flat.reshape(t.size, flat.shape[-1]), told)
        return z.reshape(*t.shape, len(self.unknowns))

    def _of_matrices(self, bundle: Bundle[Any], rows: Array, given: Array) -> Array:
        """The unknowns at several states, from the `rows` of K, H and k, and the known quantities (states × …)."""
        eom, settings, own = self.eom, self.eom.numeric(self.settings).settings, bundle.split(rows)
        if not (np.isfinite(own.matrix).all() and np.isfinite(own.drive).all()):
            raise SingularError(
                at_false_pole(eom)
                or "Expected equations of motion that are finite at the states given, got infinity or NaN: coordinates, "
                "speeds or parameters are singular there. Give other states."
            )
        n, m, size = len(eom.speeds), len(eom.b), own.right.shape[-1]
        places = np.hstack([bundle.places("matrix"), bundle.places("drive")])
        rates: tuple[Symbol, ...] = tuple(map(rate, eom.speeds))
        columns: dict[Expr, int] = {a: i for i, a in enumerate(rates)}
        columns |= {a: n + m + i for i, a in enumerate(eom.reactions)}
        columns |= {a: size + i for i, a in enumerate(self.driven)}
        told, moved = [i for i, a in enumerate(self.known) if a in columns], np.zeros((len(rows), size, 1))
        moved[:, [columns[self.known[i]] for i in told], 0] = given[:, told]
        right = own.right - (own.matrix @ moved)[:, :, 0]
        held: dict[tuple[int, ...], list[int]] = {}
        for k, independent in enumerate(independent_rows_of(eom, MatrixEntries(rows, places[n : n + m, :n]), settings)):
            held.setdefault(independent, []).append(k)
        z = np.empty((len(rows), len(self.unknowns)))
        for independent, states in held.items():
            kept = [*range(n), *(n + i for i in independent), *range(n + m, size)]
            taken = [*(columns[a] for a in self.unknowns), *(n + i for i in independent)]
            at: list[int] | slice = slice(None) if len(held) == 1 else states
            signs = np.where(np.array(taken) < size, 1.0, -1.0)

            def units(k: int, states: list[int] = states, kept: list[int] = kept, taken: list[int] = taken) -> Any:
                tall, wide = unit_sizes(own.matrix[states[k]], n, m)
                drives = (np.abs(own.drive[states[k]]) / tall[:, None]).max(axis=0)
                return tall[kept], np.append(wide, np.where(drives > 0, drives, 1.0))[taken]

            found = self._solution(
                MatrixEntries(rows[at], places[np.ix_(kept, taken)]), right[at][:, kept], signs, units
            )
            z[at] = found[:, : len(self.unknowns)]
        return z

    def _solution(
        self, square: MatrixEntries, right: Array, signs: Array, units: Callable[[int], tuple[Array, Array]]
    ) -> Array:
        """Solutions for square matrices (k × n × n) with columns times `signs`; raises SingularError if one may be singular.

        Those in doubt are divided by the `units` of rows and columns first.
        """
        told = at_false_pole(self.eom)
        threshold = STATE_RANK if told else INVERSE_RANK
        sides = MatrixEntries(right, np.arange(len(signs))[:, None])
        found = solve_each(square, sides, self.eom.numeric(self.settings).settings, order=(1, 0), rounding=0.0)
        z = found.x[:, :, 0] * signs
        for k in np.flatnonzero(~(found.share > threshold)).tolist():
            tall, wide = units(k)
            scaled = balance(square.of(k) * signs / np.outer(tall, wide), order=(1, 0), rounding=0.0)
            tall, wide = tall * scaled.rows[:, 0], wide * scaled.columns[0]
            values = singular(scaled.matrix)
            if values.regular(threshold):  # a matrix with entries that underflow is regular after balancing
                z[k] = np.linalg.solve(scaled.matrix, right[k] / tall) / wide
                continue
            if told:
                raise SingularError(told)
            own = (values.right[-1] / wide)[: len(self.unknowns)]
            own = own / (np.abs(own).max(initial=0) or 1.0)
            terms = [f"{v:+.4g} {a.name}" for a, v in zip(self.unknowns, own, strict=True) if abs(v) > TAKES_PART]
            raise SingularError(
                "Expected unknowns that the equations determine, got a combination that they leave undetermined: "
                f"{' '.join(terms)} can be added without any effect. Give one of these, or replace it by another unknown."
            )
        return z


def _table(values: Sequence[Any], shape: tuple[int, ...]) -> Array:
    """Numbers and arrays, broadcast to `shape`, along a last axis."""
    table = np.empty((*shape, len(values)))
    for k, x in enumerate(values):
        table[..., k] = x
    return table


def _floats(s: Any, value: Any) -> Array:
    return expect.floats(value, f"numbers for {s.name}", error=SimulationError)


class _Mixed(NamedTuple):
    """K, H and k of K z = H r + k, f and the sizes of its terms."""

    matrix: Array
    drive: Array
    right: Array
    configuration: Array
    terms: Array


def _mixed(eom: Equations, *driven: Symbol) -> Bundle[_Mixed]:
    u = unsolved(eom.derived)
    forms = affine_forms(u.right, driven)
    drive = Matrix(([c.get(s, ZERO) for s in driven] for c, _ in forms), (len(forms), len(driven)))
    groups = {"matrix": Matrix(u.matrix), "drive": drive, "right": [rest for _, rest in forms]}
    memo = Sizes()
    held = {"configuration": u.configuration, "terms": [size(f, memo) for f in u.configuration]}
    return Bundle("inverse", ports(eom.derived), _Mixed, {**groups, **held})


def inverse(eom: Equations, unknowns: Sequence[Any], *, settings: Settings | None = None) -> Inverse:
    """Inverse or mixed dynamics: a function that solves the equations of motion for `unknowns`, everything else given.

    There must be as many unknowns as equations, one for each speed and one for each reaction. If fewer are listed, the
    accelerations of the dependent speeds and the reactions are added, provided that this gives the right number.

    Parameters
    ----------
    eom : Equations
    unknowns : accelerations (`u1.dt` or "u1'"), inputs and reactions, by symbol or name
    settings : a `kn.Settings` for the compiled code

    Raises
    ------
    SimulationError
        if there are too many or too few unknowns
    NotAffineError
        if the equations are not affine in an unknown input
    """
    check_equations(eom)
    given: object = unknowns
    if isinstance(given, str | Symbol):
        unknowns = (given,)
    elif not expect.is_list(given):
        raise SimulationError(f"Expected unknowns as a list of symbols and names, got {cut(repr(given))}.")
    possible: tuple[Symbol, ...] = (*map(rate, eom.speeds), *eom.inputs, *eom.reactions)
    wanted: list[Symbol] = []
    for item in unknowns:
        symbol = symbol_named(possible, item)
        if symbol in set(wanted):
            raise SimulationError(f"Expected different unknowns, got {symbol.name} twice.")
        wanted.append(symbol)
    wanted += _added(eom, wanted)
    driven = tuple(s for s in eom.inputs if s in set(wanted))
    _check_affine(unsolved(eom.derived), driven)
    return Inverse(eom, tuple(wanted), tuple(s for s in possible if s not in set(wanted)), driven, settings)


def _added(eom: Equations, wanted: Sequence[Symbol]) -> list[Symbol]:
    """Dependent accelerations or reactions that complete the list of unknowns."""
    count = len(eom.speeds) + len(eom.reactions)
    listed = set(wanted)
    dependent = [rate(u) for u in eom.dependent_speeds if rate(u) not in listed]
    felt = [r for r in eom.reactions if r not in listed]
    choices: list[list[Symbol]] = [[], [*dependent], [*felt], [*dependent, *felt]]
    for more in choices:
        if len(wanted) + len(more) == count:
            return more
    head = (
        f"Expected {count} unknowns, one for each of {len(eom.speeds)} speeds and {len(eom.reactions)} reactions, got {len(wanted)} "
        f"({', '.join(s.name for s in wanted)}): "
    )
    if len(wanted) > count:
        raise SimulationError(f"{head}too many. Give values of the others.")
    own = ", ".join(s.name for s in choices[-1]) or "none here"
    raise SimulationError(
        f"{head}too few. The accelerations of the dependent speeds and the reactions ({own}) are added only if the count is "
        "right with them; list the other unknowns, too."
    )


def _check_affine(equations: Unsolved, driven: Sequence[Symbol]) -> None:
    chosen = set(driven)
    inside = [s.name for s in free_symbols([x for row in equations.matrix for x in row]) if s in chosen]
    try:
        affine_forms(equations.right, driven)
    except NotAffineError as error:
        raise NotAffineError(
            f"Expected unknown inputs that enter the loads linearly, got one that does not: {error} Make the force or torque "
            "itself the input, and solve for the original input afterwards."
        ) from error
    came, cure = "{}, which multiplies a reaction or an acceleration", "Give it, or make the force itself the input."
    expect.none(inside, "unknown inputs that enter the loads linearly", came, cure, error=NotAffineError)

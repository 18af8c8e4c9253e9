# SPDX-License-Identifier: BSD-3-Clause
"""Quantities that users ask for, as functions of q, u, t, parameters and inputs, and their values at states.

Rates, accelerations and reactions are replaced by their solved expressions.
"""

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from numbers import Number
from types import MappingProxyType
from typing import Any

import numpy as np

from kane.dynamics.derivation import Derived
from kane.dynamics.readings import regularity
from kane.dynamics.solved import Reading, Solved
from kane.errors import ArgumentError, ExpressionError, ValueMissingError, cut
from kane.expr.differentiation import Affine, tangent
from kane.expr.evaluation import Walk, at, evaluate, free_symbols, of_one_shape, stacked
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr, Exprs, as_expr
from kane.expr.symbols import (
    AuxiliarySpeed,
    Coordinate,
    Parameter,
    QuasiRate,
    Rate,
    Reaction,
    Speed,
    StateVariable,
    Symbol,
    Time,
    input_of,
    rate,
    time,
)
from kane.expr.visit import substituting
from kane.model.bodies import Particle, RigidBody
from kane.model.system import System
from kane.numeric.sampling import finite_number, named_values, symbol_named
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector


@dataclass(frozen=True, slots=True, eq=False)
class AskedExpressions:
    """The expressions of a quantity, its shape, or None and the parts of a list whose shapes differ."""

    roots: Exprs
    shape: tuple[int, ...] | None
    parts: tuple["AskedExpressions", ...] | None = None

    def filled(self, numbers: Sequence[Any]) -> Any:
        """The values in the shape asked for: a vector along the last axis, a matrix along the last two, a list as a list."""
        if self.parts is not None:
            rest = iter(numbers)
            return [part.filled([next(rest) for _ in part.roots]) for part in self.parts]
        if not self.shape:
            return numbers[0]
        return np.stack(numbers, axis=-1) if len(self.shape) == 1 else stacked(numbers, (self.shape[0], self.shape[1]))


_QUANTITIES: tuple[tuple[Any, str], ...] = (
    (Point, "its position(…), velocity({0}) or acceleration({0})"),
    (Frame, "its dcm({0}), angular_velocity({0}) or angular_acceleration({0})"),
    (RigidBody | Particle, "the position(…), velocity({0}) or acceleration({0}) of its mass center"),
)


def _quantities_of(what: object, inertial: Frame) -> str:
    """What can be asked of a point, frame or body."""
    said = next((text for kind, text in _QUANTITIES if isinstance(what, kind)), "")
    return said and f" Ask for {said.format(inertial.name)}."


def asked(derived: Derived, what: Any) -> AskedExpressions:
    """The expressions of a quantity given by the user; measure numbers of vectors and dyadics are along the inertial frame.

    Raises
    ------
    ExpressionError
        if it is none of these
    ValueMissingError
        if a name is none of the system's
    """
    frame = derived.system.inertial
    if isinstance(what, str):
        return AskedExpressions((_named(derived, what),), ())
    if isinstance(what, Vector):
        return AskedExpressions(tuple(what.components(frame)), (3,))
    if isinstance(what, Dyadic):
        what = what.components(frame)
    if isinstance(what, Matrix):
        return AskedExpressions(tuple(what.entries), what.shape)
    if isinstance(what, Expr | Number | np.generic) or (isinstance(what, np.ndarray) and what.ndim == 0):
        return AskedExpressions((as_expr(what),), ())
    if not isinstance(what, Iterable) or isinstance(what, Set | Mapping | bytes):
        raise ExpressionError(
            f"Expected an expression, vector, name, dyadic or matrix, or a list of these, got {type(what).__name__}: "
            f"{cut(repr(what))}.{_quantities_of(what, frame)}"
        )
    parts = tuple(asked(derived, x) for x in what)
    shapes = {part.shape for part in parts}
    (inner,) = shapes if len(shapes) == 1 else (None,)
    shape = (len(parts), *inner) if inner is not None else None if parts else (0,)
    return AskedExpressions(tuple(root for part in parts for root in part.roots), shape, parts)


def _named(derived: Derived, name: str) -> Symbol:
    """The symbol of that name: one of the system, a rate of one, or the time."""
    system = derived.system
    moving: tuple[Any, ...] = derived.state
    own: tuple[Symbol, ...] = (*moving, *derived.reactions, *system.parameters, *system.inputs)
    rates = {r.name: r for r in map(rate, moving)} | {time.name: time}
    return symbol_named(own, name) if name in {s.name for s in own} or name not in rates else rates[name]


_PLAIN = Coordinate | Speed | StateVariable | Parameter | Time


def without_rates(derived: Derived, roots: Sequence[Expr]) -> list[Expr]:
    """`roots` with q̇ written in speeds and q̈ in u̇."""
    second: dict[Expr, Expr] = {}
    for s in free_symbols(roots):
        of = s.place if isinstance(s, Rate) and input_of(s) is None else None
        if isinstance(of, StateVariable) and of in derived.system.states:
            second[s] = derived.system.states[of]
        elif isinstance(of, QuasiRate) or (isinstance(of, Rate) and not isinstance(of.place, Speed | StateVariable)):
            second[s] = time_derivative(derived, of)
    roots = list(map(substituting(second), roots) if second else roots)
    speeds, forms = derived.kinematical, dict[Expr, Affine]()
    if {*speeds.rates, *speeds.euler_rates}.isdisjoint(free_symbols(roots)):
        return roots
    return [speeds.in_speeds(e, forms) for e in roots]


def time_derivative(derived: Derived, e: Expr) -> Expr:
    """de/dt along the motion: q̇ = W u + X, u̇ as the leaves u'.

    Raises
    ------
    ExpressionError
        if it would hold the rate of u̇ or of a reaction
    """
    moved = (*derived.system.coordinates, *derived.states)
    rates: dict[Expr, Expr] = dict(zip(moved, (*derived.rates, *derived.state_rates), strict=True))

    def leaf_rate(leaf: Expr) -> Expr:
        if isinstance(leaf, Time):
            return ONE
        if isinstance(leaf, Speed) or input_of(leaf) is not None:
            return rate(leaf)  # type: ignore[arg-type]  # a Speed, an Input or its rate
        if isinstance(leaf, Rate | Reaction):
            raise ExpressionError(
                f"Expected an expression of coordinates, rates and speeds to differentiate along the motion, got {leaf} in it. "
                "Differentiate a trajectory's values instead."
            )
        return rates.get(leaf, ZERO)

    return tangent(without_rates(derived, [e])[0], leaf_rate)


def without_unknowns(solved: Solved, roots: Sequence[Expr]) -> list[Expr]:
    """Functions of q, u, t, parameters and inputs: u̇ and reactions replaced by their solved values, auxiliary speeds by 0."""
    derived = solved.derived
    plain = list(solved.written(without_rates(solved.regular, roots)))
    if not any(isinstance(s, Rate | Reaction | AuxiliarySpeed) for s in free_symbols(plain)):
        return plain
    values: dict[Expr, Expr] = {rate(u): a for u, a in zip(derived.speeds, solved.accelerations, strict=True)}
    values.update(zip(derived.reactions, solved.reactions, strict=True))
    values.update(dict.fromkeys(derived.auxiliary_speeds, ZERO))
    return list(map(substituting(values), plain))


def _by_symbol(derived: Derived, t: Any, q: Any, u: Any, states: Any, parameters: Any, inputs: Any) -> dict[Expr, Any]:
    """Values by symbol."""
    system, values = derived.system, dict[Expr, Any]({time: t})
    values |= named_values("coordinates", system.coordinates, q)
    values |= named_values("speeds", derived.speeds, u)
    values |= named_values("states", derived.states, states)
    values |= named_values("parameters", system.parameters, parameters)
    return values | named_values("inputs", system.inputs, inputs)


def speeds_from_rates(
    derived: Derived, q: Any, rates: Any, parameters: Mapping[Any, Any] | None, inputs: Mapping[Any, Any] | None, t: Any
) -> dict[Speed, Any]:
    """See Equations.speeds_from_rates."""
    system = derived.system
    by_coordinate = named_values("rates, by coordinate,", system.coordinates, rates)
    missing = [c.name for c in system.coordinates if c not in by_coordinate]
    if missing:
        raise ValueMissingError(f"Expected a rate for every coordinate, got none for {', '.join(missing)}.")
    values = _by_symbol(derived, t, q, None, None, parameters, inputs)
    values |= {rate(c): by_coordinate[c] for c in system.coordinates}
    q_dot = [rate(c) for c in system.coordinates]
    y, z, *_ = derived.matrices
    rows = zip(derived.speeds, y, z, strict=False)  # Y ends with a row for each set of Euler parameters
    numbers = evaluate([dot(row, q_dot) + rest for _, row, rest in rows], values)
    return dict(zip(derived.speeds, numbers, strict=True))


def evaluate_along(
    solved: Solved,
    exprs: Any,
    q: Any,
    u: Any,
    parameters: Mapping[Any, Any] | None,
    inputs: Mapping[Any, Any] | None,
    t: Any,
    states: Any = None,
    *,
    held: bool = True,
    others: Mapping[Expr, Any] = MappingProxyType({}),
) -> Any:
    """See Equations.evaluate; with `held` False speeds that miss the constraints pass. `others` are values of foreign parameters."""
    wanted = asked(solved.derived, exprs)
    roots, values = wanted.roots, _by_symbol(solved.derived, t, q, u, states, parameters, inputs)
    values |= others
    known = frozenset(values) if solved.dependent_speeds else frozenset()
    read = solved.readings.get((roots, known), lambda: _reading(solved, roots, known))
    try:
        return wanted.filled(_numbers(solved, read, values, held))
    except ValueError as error:
        _check_shapes(values, error)
        raise


def _numbers(solved: Solved, read: Reading, values: Mapping[Expr, Any], held: bool) -> list[Any]:
    """The checked values of a reading."""
    found, plain = at(read.walk, values), read.walk.roots[: read.asked]
    if held and read.names:
        regularity.check_on_constraints(solved, read.names, found[read.asked : read.asked + 2 * len(read.names)])
    numbers = of_one_shape(found[: read.asked])
    if held:
        regularity.check_rates(solved, values, numbers)
    if solved.dependent_speeds:
        regularity.check_pivots(solved, plain, values, numbers)
        numbers = regularity.check_left_out(solved, read.concerned, values, numbers)
    else:
        pivots = found[read.asked + 2 * len(read.names) :]
        numbers = regularity.check_mass_matrix(solved, read, values, numbers, pivots)
    return numbers


def _check_shapes(values: Mapping[Expr, Any], error: ValueError) -> None:
    """Raises an ArgumentError in the place of NumPy's `error` if arrays do not broadcast."""
    shapes = {s: np.shape(v) for s, v in values.items()}
    try:
        np.broadcast_shapes(*shapes.values())
    except ValueError:
        told = ", ".join(f"{shape} for {s}" for s, shape in shapes.items() if shape)
        raise ArgumentError(
            f"Expected values whose shapes broadcast, got {told}. Give each symbol one number, or as many as the others."
        ) from error


def _reading(solved: Solved, roots: Sequence[Expr], known: frozenset[Expr]) -> Reading:
    """The reading of expressions with solved values for symbols that are not `known`."""
    found = regularity.reading(solved, _walked(solved, roots), known)
    found = found._replace(concerned=regularity.concerned(solved, found.walk.roots[: found.asked]))
    pivots = solved.free_pivots if found.concerned else {}
    if not solved.rate_guards and not pivots:
        return found
    return found._replace(
        walk=Walk([*regularity.with_regular_rates(solved, found.walk.roots), *pivots, *pivots.values()])
    )


def _walked(solved: Solved, roots: Sequence[Expr]) -> Walk:
    """The expressions as functions of q, u, t, parameters and inputs."""
    walk = Walk(roots)
    if all(isinstance(s, _PLAIN) or input_of(s) is not None for s in walk.symbols):
        return walk
    return Walk(without_unknowns(solved, roots))


def parameter_values(system: System, parameters: Mapping[Any, Any] | None) -> dict[Expr, float]:
    """A number for every parameter of the system. ValueMissingError if one is missing."""
    values = named_values("parameters", system.parameters, parameters)
    for p in system.parameters:
        if p not in values and p.default is not None:
            values[p] = p.default
    missing = [p.name for p in system.parameters if p not in values]
    if missing:
        raise ValueMissingError(
            f"Expected a value for every parameter, got none for {', '.join(missing)}: pass parameters={{…}} or declare a "
            "default, kn.parameter(name, default)."
        )
    return {p: finite_number("value", p.name, values[p]) for p in system.parameters}

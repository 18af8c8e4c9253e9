# SPDX-License-Identifier: BSD-3-Clause
"""Inputs as functions of time, with the derivatives that prescribed motions need, and the check that these are smooth."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from inspect import Parameter as Parameter_
from inspect import signature as signature_of
from itertools import pairwise
from typing import Any, Literal, get_args

import numpy as np

from kane import expect
from kane.equations.equations import Equations
from kane.errors import Attributes, SimulationError, ValueMissingError, cut, warn
from kane.expr.node import Expr, as_expr
from kane.expr.piecewise import Table
from kane.expr.symbols import Input, input_of, time
from kane.motion.inputs.breakpoints import MANY
from kane.motion.inputs.expressions import (
    ControlLaw,
    Formula,
    HeldInput,
    LawInput,
    SampleAndHold,
    Sampled,
    SharedLaw,
    along,
    copied,
    formula,
    gains,
    gains_of,
    law,
)
from kane.motion.inputs.smooth import check_smooth
from kane.numeric.arrays import Array
from kane.numeric.sampling import finite_number, named_values
from kane.numeric.scale import NEAR_TIME
from kane.progress import heed

Function = Callable[..., Any]
Ends = Literal["not-a-knot", "natural", "clamped", "periodic"]

_PLACED = (Parameter_.POSITIONAL_ONLY, Parameter_.POSITIONAL_OR_KEYWORD)


@dataclass(frozen=True, slots=True, eq=False)
class Signal(Attributes):
    """A twice continuously differentiable function of time, from `kn.signal`: `s(t)` is its value, `s.derivative(n)` a derivative."""

    spline: Any

    def __call__(self, t: Any) -> Any:
        """The value at time t."""
        return self.spline(t)

    def derivative(self, order: int = 1) -> Function:
        """The nth derivative."""
        function: Function = self.spline.derivative(order)
        return function

    def breakpoints(self, span: tuple[float, float]) -> tuple[float, ...]:
        """The times of the points within the span, at which the third derivative jumps; none if there are very many."""
        inside = [float(t) for t in self.spline.x if span[0] < t < span[1]]
        return tuple(inside) if len(inside) <= MANY else ()

    def __repr__(self) -> str:
        x = self.spline.x
        return f"Signal({len(x)} points, t = {x[0]:g} … {x[-1]:g})"


def signal(t: Sequence[float], y: Sequence[float], *, ends: Ends = "not-a-knot") -> Signal:
    """A signal for an input: the twice continuously differentiable cubic spline through values `y` at increasing times `t` (s).

    It may prescribe a motion, `simulate(…, inputs={r: kn.signal(t, y)})`. `ends` is the boundary condition, as in SciPy:
    "not-a-knot", "natural", "clamped" (zero rate) or "periodic".
    """
    from scipy.interpolate import CubicSpline

    expected, both = "numbers as the points of a signal", lambda: f"{cut(repr(t))} and {cut(repr(y))}"
    times, values = (expect.floats(x, expected, came=both, error=SimulationError) for x in (t, y))
    if times.ndim != 1 or times.shape != values.shape or len(times) < 3:
        raise SimulationError(
            f"Expected at least three points (t, y) of a signal, got shapes {times.shape} and {values.shape}. Lines and steps, also "
            'between two, are tables: kn.table(t, y), kn.table(t, y, "steps").'
        )
    if not (np.all(np.isfinite(times)) and np.all(np.isfinite(values))):
        raise SimulationError("Expected finite points of a signal, got NaN or infinity.")
    if np.any(np.diff(times) <= 0):
        at = times[1:][np.diff(times) <= 0][0]
        raise SimulationError(
            f"Expected increasing times of a signal, got t = {at:g} again or out of order: a jump there would need an infinite force. "
            "Join the two values over a short time."
        )
    expect.one_of(ends, get_args(Ends), "the ends of a signal to be", error=SimulationError)
    try:
        return Signal(CubicSpline(times, values, bc_type=ends, extrapolate=False))
    except ValueError as error:
        raise SimulationError(
            f"Expected the last value of a periodic signal to equal its first one, {values[0]:.17g}, got {values[-1]:.17g}. "
            'Give the same value, or other ends, such as "not-a-knot".'
        ) from error


def input_functions(
    eom: Equations,
    inputs: Mapping[Any, Any] | None,
    span: tuple[float, float],
    parameters: Mapping[Expr, Any] | None = None,
) -> dict[Expr, Function]:
    """A function of time for each input and for the derivatives of those that prescribe a motion, in the order of `eom.inputs`.

    Expressions take `parameters`, or their defaults, and are differentiated; other functions must bring the derivatives, if they
    prescribe a motion. Raises an error if an input or a derivative is missing, or if a prescribed motion jumps.
    """
    values = named_values("inputs", eom.inputs, _each(eom, inputs, span[0]))
    own = [s for s in eom.inputs if isinstance(s, Input)]
    missing = [s.name for s in own if s not in values]
    if missing:
        raise ValueMissingError(
            f"Expected a value or function of time for every input, got none for {', '.join(missing)}: pass inputs={{…}}."
        )
    known: Mapping[Expr, Any] = {p: p.default for p in eom.parameters} if parameters is None else parameters
    moving = {input_of(s) for s in eom.inputs if not isinstance(s, Input)}
    values = {s: v(time) if isinstance(v, Table) else v for s, v in values.items()}
    state = eom.state
    values = {
        s: formula(str(s), v, known, () if input_of(s) in moving else state, gains(eom, v, known))
        if isinstance(v, Expr)
        else v
        for s, v in values.items()
    }
    functions_of: dict[Expr, Function] = {}
    for r in own:
        chain = [s for s in eom.inputs if input_of(s) is r]
        _check_covered(r, values[r], span)
        functions = _derivatives(r, values[r], len(chain) - 1)
        for k, s in enumerate(chain):
            functions_of[s] = _function(s.name, values[s]) if k and s in values else functions[k]
        for below, above in pairwise(chain):
            check_smooth(f"input {below.name}", functions_of[below], functions_of[above], span)
    return {s: functions_of[s] for s in eom.inputs}


def _each(eom: Equations, inputs: Any, start: float) -> dict[Any, Any]:
    """Inputs one by one, from keys of several inputs with one function of the state, f(t, x), or one sampled controller."""
    result: dict[Any, Any] = {}
    for key, given in (inputs if isinstance(inputs, Mapping) else named_values("inputs", eom.inputs, inputs)).items():
        keys = key if isinstance(key, tuple) else (key,)
        names = tuple(str(k) for k in keys)
        made: Sequence[Any] = [given]
        if isinstance(given, Sampled):
            held = SampleAndHold(given, names, start, copied(given, names))
            made = [HeldInput(held, i) for i in range(len(keys))]
        elif _takes_state(given) or (isinstance(key, tuple) and callable(given)):
            law = ControlLaw(given, names)
            made = [LawInput(law, i) for i in range(len(keys))]
        elif isinstance(key, tuple):
            made = list(given) if isinstance(given, Sequence | np.ndarray) and not isinstance(given, str) else [given]
            if len(made) != len(keys):
                raise SimulationError(
                    f"Expected {len(keys)} values for the inputs {', '.join(names)}, got {cut(repr(given))}. Give one for each."
                )
        for k, one in zip(keys, made, strict=True):
            if k in result:
                raise ValueMissingError(f"Expected one value for the input {k}, got two. Leave one out.")
            result[k] = one
    return result


def _takes_state(given: Any) -> bool:
    """Whether `given` is a function of time and state, f(t, x)."""
    if not callable(given) or isinstance(given, Signal | Table | Formula | LawInput):
        return False
    try:
        wanted = [p for p in signature_of(given).parameters.values() if p.default is p.empty and p.kind in _PLACED]
    except (TypeError, ValueError):  # built-in functions have no signature
        return False
    return len(wanted) == 2


def _check_covered(r: Input, value: Any, span: tuple[float, float]) -> None:
    """Check that a signal has values over the whole span."""
    for one in value if isinstance(value, tuple) else (value,):
        if not isinstance(one, Signal):
            continue
        first, last = float(one.spline.x[0]), float(one.spline.x[-1])
        if not (first <= span[0] and span[1] <= last):
            raise SimulationError(
                f"Expected a signal for the input {r.name} that covers the time span t = {span[0]:g} … {span[1]:g}, got one "
                f"from t = {first:g} to {last:g}. Give points up to the ends of the span, or a span within the signal."
            )


def _derivatives(r: Input, value: Any, order: int) -> list[Function]:
    """The value of an input as a function, and its derivatives up to `order`."""
    value = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    if isinstance(value, list | np.ndarray) or (isinstance(value, tuple) and any(map(_several, value))):
        if any(isinstance(v, Expr) for v in np.ravel(np.asarray(value, dtype=object))):
            raise SimulationError(
                f"Expected one expression for the input {r.name}, got an array of them. Where a law gives several inputs at once, "
                f"name these in a tuple: inputs={{({r.name},): …}}."
            )
        raise SimulationError(
            f"Expected a number, a function of time or functions (f, f', …) for the input {r.name}, got samples. Make them a smooth "
            f"function of time: {r.name}: kn.signal(t, y)."
        )
    if isinstance(value, tuple):
        functions = [_function(r.name, v) for v in value]
        if len(functions) <= order:
            raise ValueMissingError(
                f"Expected {order + 1} functions for the input {r.name}, itself and its derivatives, got {len(functions)}."
            )
        return functions
    if not callable(value):
        return [_function(r.name, value), *[_function(r.name, 0.0)] * order]
    if order and isinstance(value, LawInput | HeldInput):
        raise SimulationError(
            f"Expected the input {r.name} as a function of time with its derivatives, as it prescribes a motion, got a "
            "function of the state. Only an input in a load, such as a force, may be a function of the state."
        )
    if order and not hasattr(value, "derivative"):
        raise ValueMissingError(
            f"Expected the input {r.name} with its derivatives, as it prescribes a motion whose velocity and acceleration need them, "
            f"got a bare function. Pass {r.name}: (f, f', f''), or kn.signal(t, y) for a spline through points."
        )
    return [_function(r.name, value), *(value.derivative(k) for k in range(1, order + 1))]


def _several(value: Any) -> bool:
    return isinstance(value, Sequence | np.ndarray) and not isinstance(value, str) and np.ndim(value) > 0


def _function(name: str, value: Any) -> Function:
    if isinstance(value, Signal | Asked | Formula | LawInput | HeldInput):
        return value
    if callable(value):
        _check_signature(name, value)
        return Asked(name, value)
    return a_constant(finite_number("value or function of time", name, value))


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """The user's own function of time for the input `name`; an exception in it becomes a SimulationError that names the input."""

    name: str
    function: Function

    def __call__(self, t: Any) -> float:
        """The number at time t."""
        heed()
        try:
            value = self.function(t)
        except Exception as error:
            raise SimulationError(
                f"Expected a number from the function of time for the input {self.name}, got {type(error).__name__} from it "
                f"at t = {float(t):.6g}: {error}. Correct the function: it is evaluated at all times of the span."
            ) from error
        try:
            return float(value) if np.ndim(value) == 0 else float(np.asarray(value).reshape(()))
        except (TypeError, ValueError) as error:
            what = f"the expression {cut(value)}" if isinstance(value, Expr) else f"{cut(repr(value))}"
            cure = "Use math.sin instead of kn.sin in it." if isinstance(value, Expr) else "Return a plain number."
            raise SimulationError(
                f"Expected a number from the function of time for the input {self.name}, got {what} at t = {float(t):.6g}. {cure}"
            ) from error


def _check_signature(name: str, function: Function) -> None:
    """Check that a function takes the time alone."""
    try:
        takes = signature_of(function)
    except (TypeError, ValueError):  # built-in functions have no signature
        return
    try:
        takes.bind(0.0)
    except TypeError as error:
        raise SimulationError(
            f"Expected a function of the time alone for the input {name}, f(t), got one of {takes}. A function of time and "
            "state takes these two, f(t, x)."
        ) from error


def _constant(value: float, t: Any) -> float:
    return value


def a_constant(value: float) -> Function:
    """An input that is a number, as a function."""
    return partial(_constant, value)


def constant(f: Function) -> float | None:
    """The value of an input that was given as a number; None for a function of time."""
    return float(f.args[0]) if isinstance(f, partial) and f.func is _constant else None


def law_and(drives: Sequence[Any], inputs: Sequence[Expr], more: Sequence[Expr]) -> SharedLaw:
    """The `SharedLaw` of the inputs followed by `more`; an input that is computed in Python is represented by its own symbol."""
    return law([*_written(drives, inputs), *more], gains_of(drives))


def law_of(drives: Sequence[Any], inputs: Sequence[Expr], functions: bool = False) -> SharedLaw | None:
    """The `SharedLaw` of the inputs, if all are numbers, expressions, or values held between steps; else None.

    Held values are represented by their symbols; with `functions`, Python functions too.
    """
    if asked(drives) and not functions:
        return None
    return law(_written(drives, inputs), gains_of(drives))


def _written(drives: Sequence[Any], inputs: Sequence[Expr]) -> list[Expr]:
    own = {s: f.expr if isinstance(f, Formula) else constant(f) for f, s in zip(drives, inputs, strict=True)}
    return [s if value is None else as_expr(value) for s, value in own.items()]


def asked(drives: Sequence[Any]) -> bool:
    """Whether an input is a Python function, of time or of time and state."""
    return any(constant(f) is None and not isinstance(f, Formula | HeldInput) for f in drives)


def following(drives: Sequence[Any]) -> bool:
    """Whether an input depends on the state, as an expression or a function f(t, x)."""
    return any(getattr(f, "of_state", False) for f in drives)


def follows(drives: Sequence[Any]) -> bool:
    """Whether an input is an expression of the state."""
    return any(isinstance(f, Formula) and f.of_state for f in drives)


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """The values of an input at the samples of a motion, which replace its function in a file or a pickle."""

    name: str
    t: Array
    values: Array

    def __call__(self, t: Any) -> Any:
        """The value at the time of a sample."""
        k = np.searchsorted(self.t, t)
        if k < len(self.t) and self.t[k] == t:
            return self.values[k]
        raise SimulationError(
            f"Expected a time among the samples for the input {self.name} of a motion that was saved or pickled, got t = "
            f"{t:.6g}: only the values of its function at the samples were saved. Simulate again with the function."
        )


def recorded(name: str, function: Callable[[Any], Any], t: Array, states: Array) -> Callable[[Any], Any]:
    """An input as it is saved: a number unchanged, a function by its values at the samples."""
    return function if constant(function) is not None else Recorded(name, t, along(function, t, states))


_PLACES = 1025
"""Number of times in a span at which a function is called: a feature between two of them is not detected."""
_MOST = 4
_TORN = 1e-3
"""Share of its range by which a function changes within rounding of a time where it jumps."""


def warn_of_jumps(drives: Iterable[Any], span: tuple[float, float], breakpoints: Sequence[float]) -> None:
    """Warn of jumps of the user's functions of time that are not at breakpoints, the largest ones of each function."""
    for f in drives:
        if isinstance(f, Asked):
            near = NEAR_TIME * (span[1] - span[0])
            told = [t for t in jumps(f, span) if not any(abs(t - b) <= near for b in breakpoints)]
            if told:
                listed = ", ".join(f"{t:.9g}" for t in told)
                warn(
                    f"Expected a function of time without jumps for the input {f.name}, got one that jumps at t = {listed}, where no "
                    f"step ends. Name the times, breakpoints=[{listed}], or give the input as a table, kn.table(t, y, 'steps')."
                )


def jumps(f: Asked, span: tuple[float, float]) -> list[float]:
    """The times of the largest jumps of a function, sorted."""
    times = np.linspace(*span, _PLACES)
    values = np.array([f(float(t)) for t in times])
    reach = float(np.ptp(values)) if np.isfinite(values).all() else 0.0
    changes = np.diff(values)
    beside = np.pad(changes, 1, mode="edge")
    sudden = np.abs(changes - (beside[:-2] + beside[2:]) / 2)  # a slope changes as much in neighbours
    found = []
    for k in np.argsort(sudden)[::-1][:_MOST] if reach else ():
        (a, b), (p, q) = times[k : k + 2].tolist(), values[k : k + 2].tolist()
        while True:
            middle = a + (b - a) / 2
            if not a < middle < b:
                break
            between = f(middle)
            if not abs(p - q) > _TORN * reach:
                break
            a, b, p, q = (a, middle, p, between) if abs(between - p) >= abs(q - between) else (middle, b, between, q)
        if abs(p - q) > _TORN * reach:
            found.append(b)
    return sorted(found)

# SPDX-License-Identifier: BSD-3-Clause
"""Inputs as expressions, as Python functions of time and state, and as sampled controllers with zero-order hold.

Expressions are evaluated and differentiated in machine code. Their routines take numbers at run time, so that laws that differ only
in numbers share compiled code.

The x of functions f(t, x) and of controllers is the state (q, u, a), in the order of `eom.state`: coordinates, speeds, further
states. One function may return several inputs.
"""

import copy
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isfinite
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from kane import expect
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.equations.instances import own_parameters
from kane.errors import SimulationError, ValueMissingError, cut
from kane.expr.build import NODE_BUILDERS, add, neg
from kane.expr.differentiation import tangent
from kane.expr.evaluation import Walk, evaluate, free_symbols
from kane.expr.node import Expr, postorder
from kane.expr.ops import CONST, OPS
from kane.expr.piecewise import Piecewise, switches
from kane.expr.symbols import Parameter, Symbol, Time, time
from kane.expr.visit import fold, substituted
from kane.motion.inputs.breakpoints import breakpoints, by_time, on_from, up_to
from kane.numeric.arrays import Array
from kane.numeric.sampling import finite_number, named_values
from kane.program.from_expressions import Bundle
from kane.program.program import Port
from kane.progress import heed

CORNERS = frozenset(OPS[name] for name in ("abs", "sign", "min", "max", "less", "where"))
"""Operations that have corners or jumps."""


@dataclass(frozen=True, eq=False)
class Formula:
    """An expression of time and of parameters with given `values`, called with a time.

    If it contains symbols of the `state`, it is called with a time and (q, u). `gains` are the parameters that the model does not
    contain.
    """

    expr: Expr
    values: Mapping[Expr, Any]
    state: tuple[Symbol, ...] = ()
    gains: tuple[Expr, ...] = ()

    def at(self, parameters: Mapping[Expr, Any]) -> "Formula":
        """The same with other values of parameters; those left out keep theirs."""
        return replace(self, values={s: parameters.get(s, v) for s, v in self.values.items()}) if self.values else self

    def __call__(self, t: Any, x: Any = ()) -> float:
        """The value at time t and state x."""
        at = dict(zip(self.state, x, strict=bool(self.state)))
        return float(self._walk({**self.values, **at, time: t})[0])

    @cached_property
    def _walk(self) -> Walk:
        return Walk([self.expr])

    def __reduce__(self) -> tuple[Callable[..., "Formula"], tuple[Any, ...]]:
        return Formula, (self.expr, self.values, self.state, self.gains)

    def along(self, t: Array, states: Array) -> Array:
        """The values at times (n) and states (n × (q, u, a))."""
        at = dict(zip(self.state, states.T[: len(self.state)], strict=True))
        return np.broadcast_to(evaluate([self.expr], {**self.values, **at, time: t})[0], t.shape)

    @property
    def of_state(self) -> bool:
        """Whether it depends on the state."""
        return bool(self.state)

    def derivative(self, order: int = 1) -> "Formula":
        """The nth derivative with respect to time."""
        expr = self.expr
        for _ in range(order):
            expr = tangent(expr, by_time)
        return replace(self, expr=expr)

    def breakpoints(self, span: tuple[float, float]) -> tuple[float, ...]:
        """The times within the span at which it jumps or bends."""
        return breakpoints([self.expr], self.values, span)

    @property
    def smooth(self) -> bool:
        """Whether it has no corners."""
        return not any(node.op in CORNERS or isinstance(node.op, Piecewise) for node in postorder([self.expr]))


def turning_laws(drives: Iterable[Any]) -> tuple[Expr, ...]:
    """The inputs that are expressions of the state with switches."""
    laws = (f.expr for f in drives if isinstance(f, Formula) and f.of_state)
    return tuple(e for e in laws if switches([e]))


def formula(
    name: str,
    expr: Expr,
    parameters: Mapping[Expr, Any],
    state: tuple[Symbol, ...] = (),
    gains: Mapping[Expr, float] = MappingProxyType({}),
) -> Formula:
    """The input `name` as a formula, which may contain symbols of the `state` (q, u) and parameters with values of its own, `gains`.

    Raises
    ------
    ValueMissingError
        if it contains a parameter without a value
    SimulationError
        if it contains anything but time, the state, and parameters
    """
    own, known = set(state), {**parameters, **gains}
    symbols = [s for s in free_symbols([expr]) if not isinstance(s, Time)]
    missing = (s.name for s in symbols if isinstance(s, Parameter) and s not in known)
    cure = "Pass parameters={…}, or declare a default, kn.parameter(name, default)."
    expect.none(
        missing, f"a value for every parameter of the input {name}", "none for {}", cure, error=ValueMissingError
    )
    wrong = [f"{s} ({type(s).__name__})" for s in symbols if s not in known and s not in own]
    if wrong:
        kinds, else_ = ("time, coordinates, speeds", "rates or reactions") if state else ("time", "the state")
        raise SimulationError(
            f"Expected the input {name} as a number, a function of time or an expression of {kinds} and of parameters of the "
            f"model, got the expression {cut(expr)} with {', '.join(wrong)}. Write what depends on {else_} into the model "
            f"instead of {name}."
        )
    given: dict[Expr, Any] = {s: known[s] for s in symbols if s not in own}
    return Formula(expr, given, state if own.intersection(symbols) else (), tuple(s for s in given if s in gains))


def gains(eom: Equations, expr: Expr, parameters: Mapping[Expr, Any]) -> dict[Expr, float]:
    """The values of the parameters in an expression that the model does not contain."""
    numbers = {s: parameters.get(s, s.default) for s in own_parameters(eom, [expr])}
    return {s: float(v) for s, v in numbers.items() if v is not None}


def gains_of(drives: Iterable[Any]) -> dict[Expr, float]:
    """The values of parameters that occur in inputs alone."""
    return {s: f.values[s] for f in drives if isinstance(f, Formula) for s in f.gains}


def with_value(drive: Any, parameters: Mapping[Expr, Any]) -> Any:
    """An input with other values of parameters in its expression, if it is one; those left out keep theirs."""
    return drive.at(parameters) if isinstance(drive, Formula) else drive


def by_symbol(eom: Equations, given: Any, inputs: Any, gains: Iterable[Expr] = ()) -> Any:
    """A mapping of parameters by symbol or name, by symbol; those that occur only in `inputs`, or are `gains`, may be named, too."""
    if not isinstance(given, Mapping):
        return given
    own: dict[Any, None] = dict.fromkeys([*own_parameters(eom, inputs), *gains])
    found = given_parameters(given) | named_values(
        "parameters", tuple({**dict.fromkeys(eom.system.parameters), **own}), given
    )
    return found | {s: finite_number("value", s.name, found[s]) for s in own if s in found}


def given_parameters(given: Any) -> dict[Expr, Any]:
    """The values given for parameters, by symbol: also for those that occur in inputs alone, not in the model."""
    return {s: v for s, v in given.items() if isinstance(s, Parameter)} if isinstance(given, Mapping) else {}


_ADD, _SUB, _MUL, _DIV, _NEG = (OPS[name] for name in ("add", "sub", "mul", "div", "neg"))
_KEPT = {OPS["pow"]: 1, OPS["regular"]: 1}
"""Operations with an argument, given by its index, that stays a number: an exponent."""

Signed = tuple[Expr, int]


class Number(Parameter):
    """The symbol for a number in a law; `place` is its position among these."""

    __slots__ = ()
    place: int


def _number(place: int) -> Number:
    return Number.declare(f"number{place}", place=place)


class SharedLaw(NamedTuple):
    """Inputs as expressions with a `Number` in place of each gain and number, and the values of these, gains first."""

    values: tuple[Expr, ...]
    numbers: tuple[float, ...]

    def parameters(self, p: Array) -> Array:
        """The array p for its routines: the parameters of the equations, then the numbers."""
        return np.append(p, self.numbers)


def law(values: Sequence[Expr], gains: Mapping[Expr, float] = MappingProxyType({})) -> SharedLaw:
    """Expressions with a symbol for each gain and number, identical whatever the numbers and their signs.

    Gains come first, then the numbers of the first expression. Numbers absorb signs, and are counted in an order of the terms that
    does not depend on them, as the order of the arguments of sums and products does.
    """
    shapes: dict[Expr, tuple[int, bool]] = {}
    made: dict[Signed, Expr] = {}
    numbers = [*gains.values()]
    places = dict[Expr, Expr]((s, _number(k)) for k, s in enumerate(gains, 1))

    def argument(node: Expr, sign: int, kept: bool) -> Expr:
        if node.op is not CONST or kept:
            return made.get((node, sign), node)
        numbers.append(sign * float(node))
        return _number(len(numbers))

    def combined(node: Expr, sign: int) -> Expr:
        signs, left = _signs(node, sign, shapes)
        args = [argument(a, s, _KEPT.get(node.op) == k) for k, (a, s) in enumerate(zip(node.args, signs, strict=True))]
        if node.op is _NEG:
            return args[0]
        whole = add(*args) if node.op in (_ADD, _SUB) else NODE_BUILDERS[node.op.name](*args) if args else node
        return neg(whole) if left < 0 else whole

    found: list[Expr] = []
    for value in [substituted(value, places) for value in values]:
        fold(value, shapes, lambda node: _shape(node, shapes))
        stack = [(value, 1)]
        while stack:
            node, sign = stack[-1]
            signs, _ = _signs(node, sign, shapes)
            waiting = [x for x in zip(node.args, signs, strict=True) if x[0].op is not CONST and x not in made]
            if waiting:
                stack += sorted(waiting, key=lambda x: shapes[x[0]][0], reverse=True)
            elif stack.pop() not in made and node.op is not CONST:
                made[node, sign] = combined(node, sign)
        found.append(argument(value, 1, False))
    return SharedLaw(tuple(found), tuple(numbers))


def _shape(node: Expr, shapes: dict[Expr, tuple[int, bool]]) -> tuple[int, bool]:
    """A hash of a node without its numbers and signs, and whether one of its numbers can absorb a sign."""
    args, op = [shapes[a] for a in node.args], node.op
    if op is CONST:
        return 0, True
    if not args:
        return node.key, False
    if op is _NEG:
        return args[0]
    codes = [code for code, _ in args]
    taking = [takes for _, takes in args]
    takes = {_ADD: all, _SUB: all, _MUL: any, _DIV: any}.get(op)
    code = _ADD.code if op is _SUB else op.code
    return hash((code, *(sorted(codes) if op.commutative or op is _SUB else codes))), takes is not None and takes(
        taking
    )


def _signs(node: Expr, sign: int, shapes: dict[Expr, tuple[int, bool]]) -> tuple[list[int], int]:
    """The signs that the arguments of a node absorb from `sign`, and the sign that remains for the node itself."""
    op = node.op
    if op is _NEG:
        return [-sign], 1
    if op in (_ADD, _SUB):
        return [sign, -sign if op is _SUB else sign], 1
    signs = [1] * len(node.args)
    if sign < 0 and op in (_MUL, _DIV):
        taking = [k for k, a in enumerate(node.args) if shapes[a][1]]
        if taking:
            signs[min(taking, key=lambda k: shapes[node.args[k]][0])] = -1
            return signs, 1
    return signs, sign


def driving(eom: Equations, *values: Expr) -> Bundle[tuple[Array, ...]]:
    """The inputs as functions of time, the state, and parameters."""
    return Bundle("driving", law_ports(eom, values), parts, {"inputs": list(values)}, [s.name for s in eom.inputs])


def law_ports(eom: Equations, values: Sequence[Expr]) -> tuple[Port, ...]:
    """The ports t, x, p and r of routines that contain a law; its numbers follow the parameters in p."""
    t, x, p, r = ports(eom.derived)
    last = max((s.place for s in free_symbols(values) if isinstance(s, Number)), default=0)
    numbers = [_number(place) for place in range(1, last + 1)]
    return t, x, replace(p, symbols=(*p.symbols, *numbers)), r


def parts(*parts: Array) -> tuple[Array, ...]:
    """The result of a bundle with several arrays: a tuple of these."""
    return parts


# Functions of Python and sampled controllers -------------------------------------------------------------------------


_MOST = 10_000_000
"""Largest number of periods of a controller in a motion."""


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """A controller f(t, x) called every `period` (s) from the start of a motion on; its values are held in between. See `sampled`."""

    function: Callable[..., Any]
    period: float
    state: Any = None

    def __repr__(self) -> str:
        return f"Sampled({getattr(self.function, '__name__', 'function')}, every {self.period:g} s)"


def sampled(function: Callable[..., Any], period: float, *, state: Any = None) -> Sampled:
    """A sampled (discrete-time) controller, whose output is constant over each sampling period (zero-order hold).

    It is the value of an input, `simulate(…, inputs={f: kn.sampled(control, period=0.01)})`, or of several inputs,
    `inputs={(f1, f2): …}`, for which the function returns as many numbers.

    Parameters
    ----------
    function : f(t, x) with x = (q, u, a); or, with `state`, f(t, x, z), which returns the output and the next state
    period : sampling period (s); integration steps end at its multiples
    state : state z of the controller at the start of every motion, any object: an integral, the state of a filter

    Raises
    ------
    SimulationError
        if `period` is not positive, or `function` is not callable
    """
    if not callable(function):
        raise SimulationError(f"Expected a function f(t, x) as a sampled controller, got {cut(repr(function))}.")
    kind, cure = "period > 0 of a sampled controller", "It is a time in s, such as 0.01."
    length = expect.number(period, f"a finite {kind}", cure, error=SimulationError)
    expect.that(length > 0, f"a {kind}", period, cure, error=SimulationError)
    return Sampled(function, length, state)


def copied(controller: Sampled, names: tuple[str, ...]) -> Any:
    """A copy of the state of a controller of the inputs `names`, which a motion may change without effect on others."""
    try:
        return copy.deepcopy(controller.state)
    except Exception as error:
        raise SimulationError(
            f"Expected a state of the sampled controller for {', '.join(names)} that can be copied, as every motion begins with a "
            f"copy, got {cut(repr(controller.state))}: {error}. Give numbers, and keep in the function what cannot be copied."
        ) from error


@dataclass(slots=True, eq=False)
class SampleAndHold:
    """A sampled controller of the inputs `names` in one motion, with its sampling times and values so far.

    `known` are the values and states after these, in reverse order, if a part of the motion is repeated: a controller is called once
    at a time. `kept` are copies of the states since the beginning of a part that may be repeated, as controllers may change states.
    """

    controller: Sampled
    names: tuple[str, ...]
    start: float
    memory: Any
    times: list[float] = field(default_factory=list)
    values: list[Array] = field(default_factory=list)
    known: list[tuple[Array, Any]] = field(default_factory=list)
    kept: list[Any] = field(default_factory=list)

    def copy(self) -> "SampleAndHold":
        """The same controller with memory, times and values of its own, for a motion that goes on."""
        own: dict[str, Any] = {"known": [], "kept": []}
        return replace(self, memory=copy.deepcopy(self.memory), times=list(self.times), values=list(self.values), **own)

    def due(self, t: float, x: Array) -> bool:
        """Call the controller if its next sampling time has come; returns whether it has."""
        k = len(self.times)
        at = self.start + k * self.controller.period
        if t < up_to(at) and k:
            return False
        if self.known:
            found, self.memory = self.known.pop()
        else:
            found = self._called(at, x)
        self.values.append(found)
        self.times.append(at)
        if self.kept:
            self.kept.append(copy.deepcopy(self.memory))
        return True

    def _called(self, at: float, x: Array) -> Array:
        """The values at a sampling time; the state is then the next one."""
        given = (at, x.copy()) if self.memory is None else (at, x.copy(), self.memory)
        answer = asked(self.controller.function, given, self.names)
        if self.memory is not None:
            if not (isinstance(answer, tuple) and len(answer) == 2):
                raise SimulationError(
                    f"Expected the value and the next state, (value, z), from the sampled controller for {', '.join(self.names)}, got "
                    f"{cut(repr(answer))} at t = {at:.6g}. Return both."
                )
            answer, following = answer
            if _lost(following) and not _lost(self.memory):
                raise SimulationError(
                    f"Expected a next state without NaN from the sampled controller for {', '.join(self.names)}, got "
                    f"{cut(repr(following))} after {cut(repr(self.memory))} at t = {at:.6g}. Check its divisors, or bound it."
                )
            self.memory = following
        return numbers(answer, self.names, at)

    def keep(self) -> None:
        """Begins a part of the motion that may be repeated."""
        self.kept = [copy.deepcopy(self.memory)]

    def done(self, repeats: bool) -> None:
        """Ends that part; if the motion `repeats` it, the sampling times and the state are again those at its beginning."""
        count = len(self.times) - len(self.kept) + 1
        if repeats:
            self.known += list(zip(self.values[count:], self.kept[1:], strict=True))[::-1]
            self.memory = self.kept[0]
            del self.times[count:], self.values[count:]
        self.kept = []

    def instants(self, end: float) -> list[float]:
        """The sampling times after the start, up to the first one beyond `end`."""
        count = int((end - self.start) / self.controller.period) + 1
        if count > _MOST:
            raise SimulationError(
                f"Expected at most {_MOST:.0g} periods of the sampled controller for {', '.join(self.names)}, got {count:.3g} of "
                f"{self.controller.period:g} s. Give a longer period, or a continuous function f(t, x)."
            )
        return [self.start + k * self.controller.period for k in range(1, count + 1)]


def _lost(state: Any) -> bool:
    """Whether a controller's state contains NaN; False if it is not numeric."""
    try:
        return bool(np.isnan(np.asarray(state, dtype=float)).any())
    except (TypeError, ValueError):
        return False


@dataclass(frozen=True, slots=True, eq=False)
class HeldInput:
    """One input of a sampled controller, as a function of time."""

    group: SampleAndHold
    place: int

    def __call__(self, t: Any) -> float:
        """The value held at time t."""
        times = self.group.times
        t = on_from(float(t))  # at a sampling time, the value from there on
        if t >= times[-1]:
            return float(self.group.values[-1][self.place])
        return float(self.group.values[max(bisect_right(times, t) - 1, 0)][self.place])

    @property
    def now(self) -> float:
        """The latest value."""
        return float(self.group.values[-1][self.place])

    def along(self, t: Array, states: Array) -> Array:
        """The values held at times (n)."""
        at = np.searchsorted(self.group.times, [on_from(x) for x in t.tolist()], side="right") - 1
        result: Array = np.array(self.group.values)[np.maximum(at, 0), self.place]
        return result


class ControlLaw:
    """A function f(t, x) that returns the inputs `names`; called once per state, as the latest values are cached."""

    __slots__ = ("_last", "function", "names")

    def __init__(self, function: Callable[..., Any], names: tuple[str, ...]) -> None:
        self.function, self.names = function, names
        self._last: tuple[Any, Array] | None = None

    def __call__(self, t: float, x: Array) -> Array:
        """The values of all its inputs."""
        key = (float(t), x.tobytes())
        if self._last is None or self._last[0] != key:
            self._last = key, np.array(self.at(t, x))
        return self._last[1]

    def at(self, t: float, x: Array) -> Sequence[float]:
        """The same, always by a call."""
        answer = asked(self.function, (t, x.copy()), self.names)
        if type(answer) is float and isfinite(answer) and len(self.names) == 1:  # a fast path
            return (answer,)
        return numbers(answer, self.names, t).tolist()  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True, eq=False)
class LawInput:
    """One input of a `ControlLaw`."""

    law: ControlLaw
    place: int
    of_state = True

    def __call__(self, t: float, x: Array) -> float:
        """The value at a state."""
        return float(self.law(t, x)[self.place])


def value(drive: Any, t: float, x: Array) -> float:
    """The value of an input at a time and state, whatever it depends on."""
    return float(drive(t, x) if getattr(drive, "of_state", False) else drive(t))


def values(drives: Sequence[Any], t: Any, x: Array) -> Array:
    """Inputs (m) at a time and state; (n × m) at times (n) and states (n × (q, u, a)), in array operations where possible."""
    if x.ndim == 1:
        return np.array([value(f, t, x) for f in drives])
    result, asked_one_by_one = np.empty((len(t), len(drives))), list[int]()
    for k, f in enumerate(drives):
        if hasattr(f, "along"):
            result[:, k] = f.along(t, x)
        else:
            asked_one_by_one.append(k)
    for i, at in enumerate(zip(t.tolist(), x, strict=True) if asked_one_by_one else ()):
        result[i, asked_one_by_one] = [value(drives[k], *at) for k in asked_one_by_one]
    return result


def along(drive: Any, t: Array, states: Array) -> Array:
    """An input at times (n) and states (n × (q, u, a))."""
    return values([drive], t, states)[:, 0]


def controllers(drives: Sequence[Any]) -> list[SampleAndHold]:
    """The sampled controllers among some inputs, without repetition."""
    return list(dict.fromkeys(f.group for f in drives if isinstance(f, HeldInput)))


def asked(function: Callable[..., Any], arguments: tuple[Any, ...], names: tuple[str, ...]) -> Any:
    """The result of a function of the user; an exception in it becomes a SimulationError that names the inputs and the time."""
    heed()
    try:
        return function(*arguments)
    except SimulationError:
        raise
    except Exception as error:
        raise SimulationError(
            f"Expected numbers from the function of the state for {', '.join(names)}, got {type(error).__name__} from it at "
            f"t = {float(arguments[0]):.6g}, x = {cut(np.array2string(arguments[1], precision=4))}: {error}. It is called as "
            "f(t, x) with x = (q, u, a), a sampled controller with a state as f(t, x, z)."
        ) from error


def numbers(answer: Any, names: tuple[str, ...], t: float) -> Array:
    """A finite number for each of the inputs; raises a SimulationError if `answer` is anything else."""
    who = f"from the function of the state for {', '.join(names)}"
    found = expect.floats(
        answer,
        f"numbers {who}",
        "Return plain numbers.",
        came=lambda: f"{cut(repr(answer))} at t = {t:.6g}",
        error=SimulationError,
    )
    if found.size != len(names):
        raise SimulationError(
            f"Expected {len(names)} number{'s' * (len(names) > 1)} {who}, got an array of shape {found.shape} at t = {t:.6g}. Return "
            "one for each input, in that order."
        )
    if not np.isfinite(found).all():
        raise SimulationError(
            f"Expected finite numbers {who}, got {cut(repr(answer))} at t = {t:.6g}. Check its divisors, or bound it."
        )
    return found.reshape(-1)

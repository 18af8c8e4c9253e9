# SPDX-License-Identifier: BSD-3-Clause
"""Inputs that follow from the state: functions f(t, x) of Python, and sampled controllers, whose values are held for a period.

x is the state (q, u, a), in the order of `eom.state`: coordinates, speeds, further states. One function may give several inputs.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite, nan
from typing import Any

import numpy as np

from kane.errors import SimulationError, cut
from kane.motion.inputs.breakpoints import on_from, up_to
from kane.motion.interrupts import heed
from kane.numeric.arrays import Array

_MOST = 10_000_000
"""Periods of a controller in a motion."""


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """A controller f(t, x) asked every `period` (s) from the start of a motion on; its values are held between. See `sampled`."""

    function: Callable[..., Any]
    period: float
    state: Any = None

    def __repr__(self) -> str:
        return f"Sampled({getattr(self.function, '__name__', 'function')}, every {self.period:g} s)"


def sampled(function: Callable[..., Any], period: float, *, state: Any = None) -> Sampled:
    """A sampled controller: its values are held for a period, at whose ends steps end.

    Give it as the value of an input, `simulate(…, inputs={f: kn.sampled(control, period=0.01)})`, or of several at once,
    `inputs={(f1, f2): …}`; then it returns as many numbers.

    Parameters
    ----------
    function : f(t, x) with x = (q, u, a); with a state f(t, x, z), which returns the value and the next state
    period : (s)
    state : the controller's own state at the start of every motion: an integral, a filter, whatever it may be

    Raises
    ------
    SimulationError
        if the period is not above zero, or the function is none
    """
    if not callable(function):
        raise SimulationError(f"Expected a function f(t, x) as a sampled controller, got {cut(repr(function))}.")
    try:
        length = float(period)
    except (TypeError, ValueError, OverflowError):
        length = nan
    if not 0 < length < inf:
        raise SimulationError(
            f"Expected a {'' if isfinite(length) else 'finite '}period > 0 of a sampled controller, got {cut(repr(period))}. It is "
            "a time in s, such as 0.01."
        )
    return Sampled(function, length, state)


@dataclass(slots=True, eq=False)
class Held:
    """A sampled controller of the inputs `names` in one motion: what it gave, and when."""

    controller: Sampled
    names: tuple[str, ...]
    start: float
    memory: Any
    times: list[float] = field(default_factory=list)
    values: list[Array] = field(default_factory=list)

    def due(self, t: float, x: Array) -> bool:
        """Ask the controller, if its time has come; says whether it has."""
        k = len(self.times)
        at = self.start + k * self.controller.period
        if t < up_to(at) and k:
            return False
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
                    f"{cut(repr(following))} after {cut(repr(self.memory))} at t = {at:.6g}. Look for what it divides by, or bound it."
                )
            self.memory = following
        self.values.append(numbers(answer, self.names, at))
        self.times.append(at)
        return True

    def instants(self, end: float) -> list[float]:
        """When it is asked after the start."""
        count = int((end - self.start) / self.controller.period) + 1
        if count > _MOST:
            raise SimulationError(
                f"Expected at most {_MOST:.0g} periods of the sampled controller for {', '.join(self.names)}, got {count:.3g} of "
                f"{self.controller.period:g} s. Give a longer period, or a continuous function f(t, x)."
            )
        return [self.start + k * self.controller.period for k in range(1, count + 1)]


def _lost(state: Any) -> bool:
    """Whether there is NaN among the numbers of a controller's state; what is none says nothing."""
    try:
        return bool(np.isnan(np.asarray(state, dtype=float)).any())
    except (TypeError, ValueError):
        return False


@dataclass(frozen=True, slots=True, eq=False)
class HeldInput:
    """One input of a sampled controller, as a function of time."""

    group: Held
    place: int

    def __call__(self, t: Any) -> float:
        """The value held at time t."""
        times = self.group.times
        t = on_from(float(t))  # at the instant itself, what holds from there on
        if t >= times[-1]:
            return float(self.group.values[-1][self.place])
        return float(self.group.values[max(bisect_right(times, t) - 1, 0)][self.place])

    @property
    def now(self) -> float:
        """The value that was given last."""
        return float(self.group.values[-1][self.place])

    def along(self, t: Array, states: Array) -> Array:
        """The values held at times (n)."""
        at = np.searchsorted(self.group.times, [on_from(x) for x in t.tolist()], side="right") - 1
        found: Array = np.array(self.group.values)[np.maximum(at, 0), self.place]
        return found


class Law:
    """A function f(t, x) that gives the inputs `names`; asked once a state."""

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
        """The same, asked for now."""
        answer = asked(self.function, (t, x.copy()), self.names)
        if type(answer) is float and isfinite(answer) and len(self.names) == 1:  # in little time
            return (answer,)
        return numbers(answer, self.names, t).tolist()  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True, eq=False)
class LawInput:
    """One input of a `Law`."""

    law: Law
    place: int
    of_state = True

    def __call__(self, t: float, x: Array) -> float:
        """The value at a state."""
        return float(self.law(t, x)[self.place])


def value(drive: Any, t: float, x: Array) -> float:
    """An input at a time and state, whatever it depends on."""
    return float(drive(t, x) if getattr(drive, "of_state", False) else drive(t))


def along(drive: Any, t: Array, states: Array) -> Array:
    """An input at times (n) and states (n × (q, u, a)), at all of them at once where it can be."""
    if hasattr(drive, "along"):
        return np.asarray(drive.along(t, states), dtype=float)
    return np.array([value(drive, time, x) for time, x in zip(t.tolist(), states, strict=True)], dtype=float)


def controllers(drives: Sequence[Any]) -> list[Held]:
    """The sampled controllers among some inputs, each once."""
    return list(dict.fromkeys(f.group for f in drives if isinstance(f, HeldInput)))


def asked(function: Callable[..., Any], arguments: tuple[Any, ...], names: tuple[str, ...]) -> Any:
    """What a function of the user's returns; what goes wrong in it is said as such."""
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
    """A finite number for each of the inputs."""
    who = f"from the function of the state for {', '.join(names)}"
    try:
        found = np.asarray(answer, dtype=float)
    except (TypeError, ValueError) as error:
        raise SimulationError(
            f"Expected numbers {who}, got {cut(repr(answer))} at t = {t:.6g}. Return plain numbers."
        ) from error
    if found.size != len(names):
        raise SimulationError(
            f"Expected {len(names)} number{'s' * (len(names) > 1)} {who}, got an array of shape {found.shape} at t = {t:.6g}. Return "
            "one for each input, in that order."
        )
    if not np.isfinite(found).all():
        raise SimulationError(
            f"Expected finite numbers {who}, got {cut(repr(answer))} at t = {t:.6g}. Look for what it divides by, or bound it."
        )
    return found.reshape(-1)

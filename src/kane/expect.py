# SPDX-License-Identifier: BSD-3-Clause
"""Checks of arguments that make the message: “Expected …, got …. Cure.”, of the error asked for.

`expected` says what is wanted and where (“a Point as the mass centre of 'disk'”), `cure` is a whole sentence. What came is shown by
`repr`, shortened, and only where it is refused: a check that passes prints nothing.
"""

import math
from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterable
from importlib import import_module
from inspect import Parameter, signature
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, TypeGuard, TypeVar

from kane.errors import KaneError, ModelError, cut, none_of

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")
E = TypeVar("E", bound=KaneError)
Error = type[KaneError]
Words = str | Callable[[], str]


def refusal(error: type[E], expected: str, got: str, cure: str = "") -> E:
    """The error to raise where what came is said by a text of its own."""
    return error(f"Expected {expected}, got {got}.{cure and ' '}{cure}")


def said(words: Words) -> str:
    """The text, made now where it takes long and is given by a function."""
    return words if isinstance(words, str) else words()


def that(
    holds: Any, expected: Words, given: object = None, cure: str = "", *, came: Words = "", error: Error = ModelError
) -> None:
    """Refuse `given` unless something holds of it; `came` says in its place what came."""
    if not holds:
        raise refusal(error, said(expected), said(came) or cut(repr(given)), cure)


def instance(
    given: Any, kind: type[T] | tuple[type[T], ...], expected: str, cure: str = "", *, error: Error = ModelError
) -> T:
    """What is given, where it is of a kind; the cure names what it has of that kind, such as the system of an imported model."""
    if not isinstance(given, kind):
        raise refusal(error, expected, cut(repr(given)), _has(given, kind) or cure)
    return given


_WHERE = {"System": ("system",), "Equations": ("eom", "equations"), "State": ("state", "point")}
"""Attributes by what they hold."""


def _has(given: Any, kind: type | tuple[type, ...]) -> str:
    for one in kind if isinstance(kind, tuple) else (kind,):
        for name in _WHERE.get(one.__name__, ()):
            if name in getattr(given, "__dict__", ()) or hasattr(type(given), name):
                return f"Pass its .{name}."
    return ""


def instances(
    given: Any, kind: type[T] | tuple[type[T], ...], expected: str, cure: str = "", *, error: Error = ModelError
) -> tuple[T, ...]:
    """The items of a list, each of a kind; the message shows the first that is not, or what is no list."""
    return tuple(instance(x, kind, expected, cure, error=error) for x in items(given, expected, cure, error=error))


def is_list(given: object) -> TypeGuard[Iterable[Any]]:
    """Whether it is a list, a tuple or any other iterable but a text, bytes, or a NumPy array without axes."""
    return isinstance(given, Iterable) and not isinstance(given, str | bytes) and getattr(given, "shape", None) != ()


def items(given: Any, expected: str, cure: str = "", *, error: Error = ModelError) -> tuple[Any, ...]:
    """What stands in a list."""
    that(is_list(given), expected, given, cure, error=error)
    return tuple(given)


def pair(given: Any, expected: str, cure: str = "") -> tuple[Any, Any]:
    """Two items of a tuple or a list."""
    that(isinstance(given, tuple | list) and len(given) == 2, expected, given, cure)
    first, second = given
    return first, second


def one_of(given: Any, known: Collection[str], expected: str, cure: str = "", *, error: Error = ModelError) -> str:
    """One of several names: “Expected … one of a, b, got 'x'. Did you mean …?”, where `expected` ends in “to be” or a comma."""
    if not (isinstance(given, str) and given in known):
        raise error(f"Expected {expected} one of {none_of(known, given)}{cure and ' '}{cure}")
    return given


def none(
    wrong: Iterable[object], expected: Words, came: str = "{}", cure: str = "", *, error: Error = ModelError
) -> None:
    """Refuse what is wrong, if anything is; `came` says of the list {} of it what it is."""
    listed = ", ".join(map(str, wrong))
    if listed:
        raise refusal(error, said(expected), came.replace("{}", listed), cure)


def different(given: Iterable[Hashable], expected: str, cure: str = "", *, error: Error = ModelError) -> None:
    """Names, or other things that can be compared, of which none comes twice."""
    twice = sorted(repr(x) for x, count in Counter(given).items() if count > 1)
    if twice:
        raise refusal(error, expected, f"{', '.join(twice)} more than once", cure)


def name(given: Any, expected: str, cure: str = "", *, error: Error = ModelError) -> str:
    """A text that is not empty."""
    that(isinstance(given, str) and given, expected, given, cure, error=error)
    return str(given)


def label(given: Any, expected: str = "a text as name=") -> str:
    """A text, empty where a name is to be made; None is the same."""
    that(given is None or isinstance(given, str), expected, given)
    return given or ""


def flag(given: Any, expected: str) -> bool:
    """True or False, NumPy's too."""
    that(isinstance(given, bool) or type(given).__name__ in ("bool", "bool_"), expected, given)
    return bool(given)


def is_number(given: object) -> bool:
    """Whether it is a finite real number, which True and False are not."""
    try:
        return not isinstance(given, bool) and isinstance(given, Real) and math.isfinite(given)
    except OverflowError:  # an integer beyond the floats
        return False


def number(given: Any, expected: str, cure: str = "", *, error: Error = ModelError) -> float:
    """A finite real number."""
    that(is_number(given), expected, given, cure, error=error)
    return float(given)


def whole(
    given: Any,
    expected: str,
    cure: str = "",
    *,
    least: float = -math.inf,
    most: float = math.inf,
    error: Error = ModelError,
) -> int:
    """A whole number from `least` to `most`."""
    right = not isinstance(given, bool) and isinstance(given, Integral) and least <= int(given) <= most
    that(right, expected, given, cure, error=error)
    return int(given)


def reals(given: Any) -> "npt.NDArray[np.float64]":
    """An array of floats; a TypeError or ValueError of texts, or where NumPy would drop imaginary parts, a mask or None."""
    import numpy as np  # `import kane` does without

    array, mask = np.asarray(given), getattr(given, "mask", None)
    odd = array.dtype.kind in "cUS" or (
        array.dtype.kind == "O" and any(x is None or isinstance(x, str) for x in array.flat)
    )
    if odd or (isinstance(mask, np.ndarray) and mask.any()):
        raise TypeError("complex or masked numbers, texts, or none")
    return np.asarray(array, dtype=np.float64)


def floats(
    given: Any, expected: str, cure: str = "", *, came: Words = "", error: Error = ModelError
) -> "npt.NDArray[np.float64]":
    """An array of floats of what NumPy makes one of."""
    try:
        return reals(given)
    except (TypeError, ValueError, OverflowError) as wrong:
        raise refusal(error, expected, said(came) or cut(repr(given)), cure) from wrong


def package(name: str, error: Exception) -> Any:
    """An optional package; the error, if it is not installed."""
    try:
        return import_module(name)
    except ModuleNotFoundError as missing:
        raise error from missing


def keywords(*names: str) -> Callable[[F], F]:
    """A decorator for a function of **others, by which `help` and notebooks show these keywords by name."""

    def shown(function: F) -> F:
        own = signature(function)
        *first, _ = own.parameters.values()
        more = [Parameter(name, Parameter.KEYWORD_ONLY, default=None) for name in names]
        function.__signature__ = own.replace(parameters=[*first, *more])  # type: ignore[attr-defined]
        return function

    return shown

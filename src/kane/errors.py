# SPDX-License-Identifier: BSD-3-Clause
"""One family of exceptions and one of warnings.

Every message says what was expected, what came, where, and the cure.
"""

import difflib
import os
import sys
import threading
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from inspect import isfunction
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn


def alike(word: str, known: Iterable[str]) -> str:
    """“ Did you mean …?” where a name is the word but for capitals, or else has it among its own words, or else resembles it."""
    names, lower = list(known), word.lower()
    same = [name for name in names if name.lower() == lower]
    part = [name for name in names if lower in name.lower().split("_")]
    close = same or part[:4] or difflib.get_close_matches(word, names, cutoff=0.5)
    return f" Did you mean {' or '.join(close)}?" if close else ""


def none_of(known: Iterable[object], given: object) -> str:
    """“a, b, got 'x'. Did you mean …?”: how a message goes on after “Expected one of ” where `given` is none of these names."""
    names = [str(x) for x in known]
    return f"{', '.join(names) or 'none'}, got {cut(repr(given))}.{alike(str(given), names)}"


def cut(shown: object, most: int = 60) -> str:
    """What `shown` prints as in at most so many letters; "…" stands for what is left out, definitions of intermediates too."""
    text, where, _ = str(shown).partition(", where ")
    if not where and len(text) <= most:
        return text
    return f"{text[: most - 2].rstrip(' +-*/^(')} …"


class KaneError(Exception):
    """Base of every error that `kane` raises on purpose."""


class ExpressionError(KaneError, TypeError):
    """A scalar expression is used in an invalid way: in `==` or `if`, with a NaN constant, with a wrong operand."""


class NotAffineError(KaneError, ValueError):
    """An expression that must be affine in some symbols is not."""


class SpaceError(KaneError, ValueError):
    """Frames, points or vectors are inconsistent with each other."""


class ModelError(KaneError, ValueError):
    """A declaration of the model is invalid, or contradicts another one."""


class UnitError(ModelError):
    """A unit is unknown, or units are inconsistent."""


class SpeedsError(ModelError):
    """The generalized speeds do not determine the rates: too many, too few, dependent, or nonlinear."""


class ReactionError(ModelError):
    """A reaction or auxiliary speed does not bring a force into evidence."""


class PotentialError(KaneError, ValueError):
    """Forces have no potential energy, or none was found."""


class SingularError(KaneError, ArithmeticError):
    """A matrix that must be invertible is singular, structurally or at the given numbers."""


class ValueMissingError(KaneError, KeyError):
    """A parameter, coordinate, speed or input has no value, or a value is given for an unknown name."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class SimulationError(KaneError, RuntimeError):
    """A simulation cannot start or cannot go on."""


class ContactError(SimulationError):
    """No contact forces satisfy the laws of friction, or no impulses those of impact."""


class CornerError(SimulationError):
    """The equations have no derivative, or no value, at a state: a switch (|x|, max, where, …) is at its corner there.

    `names` are the states and inputs in which `side=` gives the direction of a one-sided derivative.
    """

    names: tuple[str, ...] = ()


class SolutionFileError(KaneError, ValueError):
    """A file does not contain a solution of this system and version, or a solution cannot be written to it."""


class MissingAttributeError(KaneError, AttributeError):
    """An object has no attribute of this name; its arguments are the object and the name."""

    def __str__(
        self,
    ) -> str:  # made when it is shown, as hasattr() and getattr() with a default ask often and show nothing
        thing, name = self.args
        label = getattr(thing, "__name__", None) or getattr(thing, "name", "")
        owner = f"{type(thing).__name__} {label if isinstance(label, str) else ''}".rstrip()
        listed = vars(thing).get("__all__") if isinstance(thing, ModuleType) else None  # or what it imports counts
        known = [n for n in listed or dir(thing) if not n.startswith("_")]
        every = [*known, *(getattr(vars(thing).get("__getattr__"), "places", ()) if listed else ())]  # of families, too
        what = elsewhere(thing, name) or alike(name, dict.fromkeys(every)) or f" It has {cut(', '.join(known), 400)}."
        return f"Expected an attribute of {owner}, got {name!r}.{what}"


def elsewhere(thing: Any, name: str) -> str:
    """Where a name that is no attribute is found: as an entry, under another name, as one of several, as a function; else ""."""
    if hasattr(type(thing), "__getitem__"):
        with suppress(Exception):  # whatever it makes of a name that it does not know
            thing[name]
            return f" It is an entry: read it as [{name!r}]."
    package = sys.modules["kane"]
    named = _called(package, name)
    if isinstance(thing, ModuleType) and named and hasattr(thing, named[0]):
        return f" Did you mean {named[0]}?"
    several = {f"{name}s"}.intersection(dir(thing))
    for own in (*_called(thing, name), *several):
        return f" It is called {own}."
    for function in (name, f"to_{name}", *named):
        if thing is not package and isfunction(getattr(package, function, None)):
            return f" There is a function: kn.{function}."
    return ""


def _called(thing: Any, name: str) -> list[str]:
    """What is called so elsewhere, by its own name."""
    return [own for own, others in getattr(thing, "_other_names", {}).items() if name.lower() in others.lower().split()]


class Attributes:
    """A base of what has attributes: an unknown one is refused by a `MissingAttributeError`; a notebook shows them as a table.

    `_other_names` are those that textbooks and other packages have for an attribute, by its name, in one text.
    """

    __slots__ = ()
    _other_names: ClassVar[Mapping[str, str]] = MappingProxyType({})

    def _repr_html_(self) -> str | None:
        from kane.show import html  # it wants NumPy

        return html(self)

    if not TYPE_CHECKING:  # a type checker would take it for a declaration of every attribute

        def __getattr__(self, name: str) -> NoReturn:
            if name.startswith("_") or hasattr(
                type(self), name
            ):  # a protocol's; or a property that raised, whose error it is
                object.__getattribute__(self, name)
            raise MissingAttributeError(self, name)


class ProgramError(KaneError, RuntimeError):
    """A program is invalid, or cannot be compiled on this machine."""


class ArgumentError(KaneError, ValueError):
    """An argument has the wrong type, shape or value, such as a non-finite number for compiled code."""


class NotFiniteError(KaneError, ArithmeticError):
    """Compiled code gave infinity or NaN at finite arguments; the message names the first intermediate that did."""


class KaneWarning(UserWarning):
    """Something can be computed, but is probably a mistake."""


class StiffeningWarning(KaneWarning):
    """A beam without stiffening spins faster than its first natural frequency: premature linearization."""


class ModesWarning(KaneWarning):
    """A beam has too few shape functions for its motion."""


_HERE = os.path.dirname(os.path.abspath(__file__))


def warn(message: str, category: type[KaneWarning] | None = None) -> None:
    """A `KaneWarning`, or one of a `category` of its own, at the innermost line outside of kane."""
    listed: list[str] | None = getattr(_here, "listed", None)
    if listed is not None:
        listed.append(message)
        return
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_HERE):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category or KaneWarning, stacklevel=level)


_here = threading.local()


@contextmanager
def listed_warnings() -> Iterator[list[str]]:
    """Within, what this thread warns of is listed and not shown; filters of `warnings` are those of all threads."""
    before: list[str] | None = getattr(_here, "listed", None)
    listed: list[str] = []
    _here.listed = listed
    try:
        yield listed
    finally:
        _here.listed = before


__all__ = [
    "ArgumentError", "ContactError", "CornerError", "ExpressionError", "KaneError", "KaneWarning",
    "MissingAttributeError", "ModelError", "ModesWarning", "NotAffineError", "NotFiniteError", "PotentialError",
    "ProgramError", "ReactionError", "SimulationError", "SingularError", "SolutionFileError", "SpaceError",
    "SpeedsError", "StiffeningWarning", "UnitError", "ValueMissingError",
]  # fmt: skip

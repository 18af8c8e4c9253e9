# SPDX-License-Identifier: BSD-3-Clause
"""Lazy evaluation: cached attributes of records, mappings that compute values when read, and a bounded cache of recent values."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, TypeVar, get_args

from kane.errors import ValueMissingError, alike
from kane.show import Listing, html

K = TypeVar("K")
V = TypeVar("V")


class read(cached_property[V]):
    """A cached property, from a function as a decorator, or in one line: `name = read[type](lambda record: …, docstring)`.

    Tuples are read as listings, which notebooks show.
    """

    def __init__(self, function: Callable[[Any], V], doc: str | None = None) -> None:
        super().__init__(function)
        self.__doc__ = doc or function.__doc__

    if not TYPE_CHECKING:

        def __get__(self, instance: Any, owner: Any = None) -> Any:
            """The value, made when it is first read."""
            value = super().__get__(instance, owner)
            if type(value) is tuple:
                value = instance.__dict__[self.attrname] = Listing(value)
            return value

    def __set_name__(self, owner: type, name: str) -> None:
        super().__set_name__(owner, name)
        for kind in get_args(getattr(self, "__orig_class__", None)):  # documentation shows it
            self.func.__annotations__["return"] = kind

    def within(self, part: str) -> "read[V]":
        """An attribute of a record that reads this attribute of its field `part`."""
        outer: read[V] = read(lambda whole: self.__get__(getattr(whole, part)), self.__doc__)
        outer.func.__annotations__.update(self.func.__annotations__)
        return outer


class LazyMapping(Mapping[K, V]):
    """A read-only mapping that computes each value when it is first read.

    A key may be given by its name, or as what `stands_for` says; a pair by those of its parts.
    """

    __slots__ = ("_compute", "_keys", "_stands_for", "_values")

    def __init__(
        self, keys: Iterable[K], compute: Callable[[K], V], stands_for: Mapping[Any, Any] | None = None
    ) -> None:
        self._keys, self._compute, self._stands_for = dict.fromkeys(keys), compute, stands_for or {}
        self._values: dict[K, V] = {}

    def __getitem__(self, key: K) -> V:
        if key not in self._keys:
            key = self._meant(key)
        if key not in self._values:
            self._values[key] = self._compute(key)
        return self._values[key]

    def __contains__(self, key: object) -> bool:
        return key in self._keys or len(self._called(key)) == 1

    def _called(self, key: Any) -> list[K]:
        """The keys with this name."""
        stands_for = self._stands_for
        own = tuple(stands_for.get(x, x) for x in key) if isinstance(key, tuple) else stands_for.get(key, key)
        return [k for k in self._keys if _named(k, own)]

    def _meant(self, key: Any) -> K:
        """The only key with this name. ValueMissingError if there is none, or several."""
        found = self._called(key)
        if len(found) != 1:
            names = [*map(_label, self._keys)]
            if found:
                raise ValueMissingError(
                    f"Expected one of {', '.join(names)}, got {_label(key)}, the name of {len(found)} of them. Give the key itself."
                )
            raise ValueMissingError(
                f"Expected one of {', '.join(names)}, got {_label(key)}.{alike(_label(key), names)}"
            )
        return found[0]

    def __iter__(self) -> Iterator[K]:
        return iter(self._keys)

    def __len__(self) -> int:
        return len(self._keys)

    def __repr__(self) -> str:
        return "{" + ", ".join(f"{_label(k)}: {self[k]}" for k in self) + "}"

    _repr_html_ = html


class Lately(Generic[K, V]):
    """A cache of the `most` values used last."""

    __slots__ = ("_most", "_values")

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: dict[K, V] = {}

    def get(self, key: K, make: Callable[[], V]) -> V:
        """The cached value of `key`, else make(). Threads that ask for one key at the same time may each make it."""
        value = self._values.pop(key, None)
        if value is None:
            value = make()
        self._values[key] = value
        while len(self._values) > self._most:
            self._values.pop(next(iter(tuple(self._values))), None)
        return value

    def values(self) -> tuple[V, ...]:
        """The cached values, the least recently used first."""
        return tuple(self._values.values())


def _named(key: Any, given: Any) -> bool:
    """Whether `given` is the key or its name; for a tuple entry by entry."""
    if isinstance(key, tuple):
        return isinstance(given, tuple) and len(given) == len(key) and all(map(_named, key, given))
    return given is key or (isinstance(given, str) and getattr(key, "name", None) == given)


def _label(key: object) -> str:
    if isinstance(key, tuple):
        return "(" + ", ".join(map(_label, key)) + ")"
    return str(getattr(key, "name", key))

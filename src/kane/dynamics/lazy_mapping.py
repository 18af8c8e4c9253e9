# SPDX-License-Identifier: BSD-3-Clause
"""A mapping whose values are computed when they are read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeVar

K = TypeVar("K")
V = TypeVar("V")


class LazyMapping(Mapping[K, V]):
    """A read-only mapping that computes each value when it is first read."""

    __slots__ = ("_compute", "_keys", "_values")

    def __init__(self, keys: Iterable[K], compute: Callable[[K], V]) -> None:
        self._keys, self._compute = dict.fromkeys(keys), compute
        self._values: dict[K, V] = {}

    def __getitem__(self, key: K) -> V:
        if key not in self._values:
            if key not in self._keys:
                raise KeyError(f"Expected one of {', '.join(map(_label, self._keys))}, got {_label(key)}.")
            self._values[key] = self._compute(key)
        return self._values[key]

    def __iter__(self) -> Iterator[K]:
        return iter(self._keys)

    def __len__(self) -> int:
        return len(self._keys)

    def __repr__(self) -> str:
        return "{" + ", ".join(f"{_label(k)}: {self[k]}" for k in self) + "}"


def _label(key: object) -> str:
    if isinstance(key, tuple):
        return "(" + ", ".join(map(_label, key)) + ")"
    return str(getattr(key, "name", key))

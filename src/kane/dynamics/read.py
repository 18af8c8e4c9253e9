# SPDX-License-Identifier: BSD-3-Clause
"""Attributes of records that are computed when they are first read."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar, get_args

V = TypeVar("V")


class read(cached_property[V]):
    """A cached property, from a function as a decorator, or in one line: `name = read[type](lambda record: …, docstring)`."""

    def __init__(self, function: Callable[[Any], V], doc: str | None = None) -> None:
        super().__init__(function)
        self.__doc__ = doc or function.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        super().__set_name__(owner, name)
        for kind in get_args(getattr(self, "__orig_class__", None)):  # documentation shows it
            self.func.__annotations__["return"] = kind

    def within(self, part: str) -> read[V]:
        """The same attribute of a record that holds this one's as `part`."""
        outer: read[V] = read(lambda whole: self.__get__(getattr(whole, part)), self.__doc__)
        outer.func.__annotations__.update(self.func.__annotations__)
        return outer

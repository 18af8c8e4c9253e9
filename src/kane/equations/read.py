# SPDX-License-Identifier: BSD-3-Clause
"""Attributes that are one expression each."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar, get_args

V = TypeVar("V")


class read(cached_property[V]):
    """`name = read[type](lambda e: expression, docstring)`: a property that is computed when it is first read."""

    def __init__(self, expression: Callable[[Any], V], doc: str) -> None:
        super().__init__(expression)
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        super().__set_name__(owner, name)
        self.func.__annotations__["return"] = get_args(getattr(self, "__orig_class__", None))[0]  # for documentation

# SPDX-License-Identifier: BSD-3-Clause
"""Pure functions whose results are kept while one derivation lasts: its routes ask for the same turns and products again and again.

A result depends on the arguments alone, kept or not. Nothing is kept outside of `remembering`, so that nodes live no longer for it.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar, cast

P = ParamSpec("P")
R = TypeVar("R")


class _Scope(threading.local):
    """What the derivation of this thread has found, by function and arguments; None outside of one."""

    found: dict[tuple[Any, ...], Any] | None = None


_scope = _Scope()


@contextmanager
def remembering() -> Iterator[None]:
    """Within, `remembered` functions of this thread compute each result once; a derivation within another shares what that one has."""
    outer = _scope.found
    if outer is None:
        _scope.found = {}
    try:
        yield
    finally:
        _scope.found = outer


def remembered(function: Callable[P, R]) -> Callable[P, R]:
    """A pure function of arguments that never change, known by their hash and given by place; never None."""

    def known(*args: Any) -> Any:
        table = _scope.found
        if table is None:
            return call(*args)
        key = (call, *args)
        result = table.get(key)
        if result is None:
            result = table[key] = call(*args)
        return result

    call: Callable[..., Any] = function
    return cast(Callable[P, R], wraps(function)(known))

# SPDX-License-Identifier: BSD-3-Clause
"""Pure functions whose results are kept while one derivation lasts: its routes ask for the same turns and products again and again.

A result depends on the arguments alone, kept or not. Nothing is kept outside of `remembering`, so that nodes live no longer for it.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

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
    """A pure function of arguments that never change, known by their hash; never None."""

    @wraps(function)
    def known(*args: P.args, **kwargs: P.kwargs) -> R:
        table = _scope.found
        if table is None:
            return function(*args, **kwargs)
        key = (function, *args)
        result = table.get(key)
        if result is None:
            result = table[key] = function(*args, **kwargs)
        return result

    return known

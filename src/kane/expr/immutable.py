# SPDX-License-Identifier: BSD-3-Clause
"""What never changes is its own copy."""

from collections.abc import Sequence
from typing import Any, Protocol, Self

from kane.errors import Attributes

_STRIDE = 32


class Immutable(Attributes):
    """A copy, a deep one too, is the thing itself: frames, points and records are known by identity."""

    __slots__ = ()

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self


class Born(Protocol):
    """What has a parent of its own kind, or none."""

    @property
    def parent(self) -> Any:
        """What it is born from."""


def landmarks(child: Born) -> Sequence[Any]:
    """Some ancestors from the root on, a bounded number of births apart: pickled first, long lines of them need no recursion."""
    line, at = [], child.parent
    while at is not None:
        line.append(at)
        at = at.parent
    return line[::-1][_STRIDE - 1 :: _STRIDE]

# SPDX-License-Identifier: BSD-3-Clause
"""Where in arrays something is wrong first, in words."""

from typing import Any, NamedTuple

import numpy as np


class First(NamedTuple):
    """The first `place` of several, () of a single number, `written` as an index, and how many `others` there are."""

    place: tuple[int, ...]
    written: str
    others: int

    def __str__(self) -> str:
        return f"index {self.written}{f' and {self.others} more' if self.others else ''}"


def first_place(mask: Any) -> First:
    """The first place at which a mask holds somewhere."""
    place = tuple(int(i) for i in np.argwhere(mask)[0])
    return First(place, str(place[0] if len(place) == 1 else place), int(np.sum(mask)) - 1)

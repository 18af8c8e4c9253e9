# SPDX-License-Identifier: BSD-3-Clause
"""Whether steps are short for stability alone, so that an implicit method leads on, and when that is over.

Of an explicit method's steps it tells that states hardly bend along them and many fail all the same. Of an implicit method's that they
are no longer than the fastest rate of the equations, h ρ(J) < 1: then others would be stable at them, too.
"""

import numpy as np

from kane.motion.compiled_equations import Routines
from kane.motion.implicit import exact
from kane.motion.steppers.outline import At
from kane.numeric.arrays import Array

_PACE = (At.STEPS, At.SMOOTH, At.LIMITED)
_MANY, _SMOOTH, _LIMITED = 100, 0.5, 0.2
"""After so many steps it is asked whether these shares of them hardly bend, and are short all the same."""
_SOON, _LATE = 25, 1000
"""Steps of an implicit method after which it is asked whether it is needed, as long as it may not be, and where it is."""
_CALM = 1.0
"""h ρ(J) below which it is not."""
_TWICE, _DOUBTED = 2, 4
"""How often in a row that must be, the first time; and by how much more often each time after it."""


class Stiffness:
    """What a motion that chooses its method tells of its steps: `left` is the method that an implicit one has taken over from."""

    def __init__(self) -> None:
        self.left = ""
        self._seen = np.zeros(len(_PACE))
        self._wait, self._calm, self._needed = _SOON, 0, _TWICE

    @property
    def limit(self) -> int:
        """After how many steps to ask."""
        return self._wait if self.left else _LATE

    def sets_in(self, s: Array) -> bool:
        """Whether steps since it was last asked were short for stability alone."""
        steps, smooth, limited = (s[at] - seen for at, seen in zip(_PACE, self._seen, strict=True))
        if self.left or steps < _MANY:
            return False
        self._seen = s[[*_PACE]]
        return bool(limited >= _LIMITED * steps and smooth >= _SMOOTH * steps)

    def leaves(self, method: str) -> None:
        """An implicit method takes over."""
        self.left, self._wait, self._calm = method, _SOON, 0

    def is_over(self, now: Routines, t: float, y: Array, length: float) -> bool:
        """Whether steps of the implicit method, which are of this length at y, would be stable in the other one for some time now."""
        fastest = np.abs(np.linalg.eigvals(exact(now)(t, y))).max(initial=0.0)
        calm = length * fastest < _CALM
        self._calm = self._calm + 1 if calm else 0
        self._wait = _SOON if calm else min(2 * self._wait, _LATE)
        return self._calm >= self._needed

    def comes_back(self, s: Array) -> str:
        """The other method, which leads on again."""
        method, self.left, self._needed = self.left, "", _DOUBTED * self._needed
        self._seen = s[[*_PACE]]
        return method

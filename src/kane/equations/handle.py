# SPDX-License-Identifier: BSD-3-Clause
"""A compiled routine of equations of motion, called with t, x, p, r."""

from typing import Any

import numpy as np

from kane import show
from kane.numeric.arrays import Array
from kane.program.native.compiled_routine import ALL, CompiledRoutine, new_block

_ARRAY: Any = np.ndarray


class Handle(CompiledRoutine):
    """One compiled routine: `handle(t, x, p, r)`.

    `t` is a number, `x` the state (…, n), `p` the parameters (…, np) or a mapping by symbol or name (those left out keep their
    defaults; all of them where `p` is None), `r` the inputs (…, nr). Leading axes broadcast; the result has them, then `shape`.
    It is always a new array. Threads may call one handle at the same time: each call has a block of memory to itself.

    NaN or infinity in the arguments is an `ArgumentError`. If a result is not finite, `not_finite` says what happens: "warn"
    (`KaneWarning`), "raise" (`NotFiniteError`); both name the first intermediate that is not. With "ignore" nothing is checked.
    """

    __slots__ = ()

    def __call__(self, t: Any, x: Any, p: Any = None, r: Any = None) -> Array:
        """The results at t, x, p, r."""
        # As in any routine, but written out for these four: this is what solvers call.
        if (
            (type(t) is float or type(t) is np.float64 or type(t) is int)
            and type(x) is _ARRAY
            and (p is None or type(p) is _ARRAY or type(p) is dict)
            and (type(r) is _ARRAY or type(r) is dict or (r is None and self._standard[3] is not None))
        ):
            free = self._free
            try:
                own = free.pop()
            except IndexError:
                own = new_block(self.program, self.routine)
            address, time, x_own, p_own, r_own, out = own
            try:
                time.value = t
                x_own[ALL] = x
                if type(p) is dict:
                    self._put(2, p_own, p, self._standard[2])
                else:
                    p_own[ALL] = self._standard[2] if p is None else p
                if type(r) is dict:
                    self._put(3, r_own, r, self._standard[3])
                elif r is not None:
                    r_own[ALL] = r
            except (KeyError, OverflowError, TypeError, ValueError, NotImplementedError):
                free.append(own)
            else:
                if self._call(address):
                    return self._doubtful(own, (t, x, p, r))
                results: Array = out.copy()
                free.append(own)
                return results
        many = self._in_rows((t, x, p, r))
        return self._general(t, x, p, r) if many is None else many

    def explain(self, t: Any, x: Any, p: Any = None, r: Any = None) -> str:
        """Which intermediate is the first that is not finite at one state, and what it is made of; "" where all is finite."""
        return super().explain(t, x, p, r)

    _repr_html_ = show.html

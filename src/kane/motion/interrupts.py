# SPDX-License-Identifier: BSD-3-Clause
"""Ctrl-C while a motion runs: it ends after the step at hand, and what there is of it is returned.

The signal is noted and looked at between steps and where Python's functions are asked, since an exception at any place could not
pass through machine code. Another one within a second interrupts the program, so that a loop of many motions can be left.
"""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_AGAIN = 1.0
"""Time (s) within which a second signal is not for the motion."""
MESSAGE = "interrupted by Ctrl-C at t = "
"""How the message of such a motion begins."""

_here = threading.local()
"""Signals are the main thread's: motions of other threads see none."""


class Interrupted(BaseException):
    """A motion is to end: raised where the user's functions are asked, and caught by what runs it."""


@contextmanager
def noted() -> Iterator[None]:
    """Within, the first Ctrl-C is noted; unless the program has a handler of its own, or an outer motion notes it."""
    plain = threading.current_thread() is threading.main_thread()
    if not plain or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    _here.noted = False
    signal.signal(signal.SIGINT, _note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        _here.noted = False


def _note(number: int, frame: Any) -> None:
    last, _here.last = getattr(_here, "last", -_AGAIN), time.monotonic()
    if is_noted() or _here.last - last < _AGAIN:
        signal.default_int_handler(number, frame)
    _here.noted = True


def is_noted() -> bool:
    """Whether the motion is to end."""
    return getattr(_here, "noted", False)


def heed() -> None:
    """An `Interrupted` if the motion is to end."""
    if getattr(_here, "noted", False):
        raise Interrupted


def check_whole(solution: Any) -> Any:
    """The solution; the KeyboardInterrupt that ended it, where a part of it is of no use."""
    if solution.status == "stopped" and solution.message.startswith(MESSAGE):
        raise KeyboardInterrupt
    return solution

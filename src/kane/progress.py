# SPDX-License-Identifier: BSD-3-Clause
"""What takes long says so on a terminal, and a motion ends at Ctrl-C.

A line on stderr says what is being done, how far it is and since when; it is gone when that is done. Where stderr is no terminal
nothing is written, nor with `KANE_PROGRESS=off`.

Work that makes many nodes and drops few lets Python's collector of cycles run seldom. A derivation makes hundreds of thousands
of tuples and nodes that stay, and hardly a cycle. At its usual thresholds the collector goes through all of them again and again,
and through all that the process holds: a third of the time of large systems, and more than in proportion to them.

At Ctrl-C a motion ends after the step at hand, and what there is of it is returned. The signal is noted and looked at between
steps and where Python's functions are asked, since an exception at any place could not pass through machine code. Another one
within a second interrupts the program, so that a loop of many motions can be left.
"""

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

PATIENCE = 1.0
"""Seconds after which it is said that something takes long."""
_AGAIN = 0.2
"""Seconds after which the line is written anew."""
_WIDTH = 100
_CLEAR = "\r\x1b[K"


class _Line:
    """What is being done now, the innermost last; `far` says how far it is."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.doing: list[str] = []
        self.far: list[str] = []
        self.begun = 0.0
        self.owner: int | None = None
        self.done = threading.Event()
        self.shown = False

    def write(self) -> None:
        """The line, over the one before; with the lock held."""
        far = f": {self.far[0]}" if self.far[0] else " …"
        within = f", {self.doing[-1].lower()}" if len(self.doing) > 1 else ""
        text = f"{self.doing[0]}{far}{within} ({time.monotonic() - self.begun:.0f} s)"
        sys.stderr.write(f"{_CLEAR}{text[:_WIDTH]}")
        sys.stderr.flush()
        self.shown = True

    def watch(self, done: threading.Event, patience: float) -> None:
        """Write the line again and again, in a thread of its own."""
        wait = patience
        while not done.wait(wait):
            wait = _AGAIN
            with self.lock:
                if done.is_set():
                    return
                try:
                    self.write()
                except (OSError, ValueError):  # the terminal is gone
                    return

    def end(self) -> None:
        """Nothing is left of the line."""
        with self.lock:
            self.done.set()
            if self.shown:
                self.shown = False
                try:
                    sys.stderr.write(_CLEAR)
                    sys.stderr.flush()
                except (OSError, ValueError):
                    pass


_line = _Line()


def _to_be_seen() -> bool:
    try:
        terminal = sys.stderr is not None and sys.stderr.isatty()
    except ValueError:
        return False
    return terminal and os.environ.get("TERM") != "dumb" and os.environ.get("KANE_PROGRESS", "").lower() != "off"


@contextmanager
def working(doing: str) -> Iterator[None]:
    """Say on a terminal's stderr what is being done, once it has taken `PATIENCE` seconds; within another one, in its place.

    Of several threads the first has the line.
    """
    me = threading.get_ident()
    with _line.lock:
        inner = _line.owner is not None
        mine = _line.owner in (None, me) and (_line.doing[-1] != doing if inner else _to_be_seen())
        if mine:
            _line.doing.append(doing)
            _line.far.append("")
        if mine and not inner:
            _line.owner, _line.begun, _line.done = me, time.monotonic(), threading.Event()
            threading.Thread(target=_line.watch, args=(_line.done, PATIENCE), daemon=True).start()
    try:
        yield
    finally:
        if mine:
            if not inner:
                _line.end()
            with _line.lock:
                _line.doing.pop()
                _line.far.pop()
                _line.owner = me if inner else None


def far(text: Callable[[], str]) -> None:
    """How far the innermost work is; `text` is asked for only where it may be seen."""
    if _line.owner == threading.get_ident():
        _line.far[-1] = text()


SELDOM = (100_000, 20, 100)
"""The thresholds meanwhile: cycles are still found, by and by."""
_lock = threading.Lock()
_before: list[tuple[int, int, int]] = []
"""What the thresholds were, once for each that is at work now."""


@contextmanager
def collecting_seldom() -> Iterator[None]:
    """The collector at higher thresholds while anyone is within; then as it was, unless somebody else has set them meanwhile.

    A process whose own thresholds are higher, or whose collector is off, keeps them.
    """
    with _lock:
        own = gc.get_threshold()
        _before.append(_before[0] if _before else own)
        if 0 < own[0] < SELDOM[0]:
            gc.set_threshold(*SELDOM)
    try:
        yield
    finally:
        with _lock:
            before = _before.pop()
            if not _before and gc.get_threshold() == SELDOM:
                gc.set_threshold(*before)


# Interrupts ----------------------------------------------------------------------------------------------------------


_SECOND = 1.0
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
    mine = plain and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if mine:
        _here.noted = _here.heeded = False
        signal.signal(signal.SIGINT, _note)
    try:
        yield
    except Interrupted:  # before the first step
        raise KeyboardInterrupt from None
    finally:
        if mine:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            _here.noted = False


@contextmanager
def in_time(late: Callable[[], object]) -> Iterator[None]:
    """Within, a motion is to end, too, once it is `late`."""
    before, _here.late, _here.heeded = getattr(_here, "late", bool), late, False
    try:
        yield
    finally:
        _here.late = before


def _note(number: int, frame: Any) -> None:
    last, _here.last = getattr(_here, "last", -_SECOND), time.monotonic()
    if is_noted() or _here.last - last < _SECOND:
        signal.default_int_handler(number, frame)
    _here.noted, _here.heeded = True, False


def is_noted() -> bool:
    """Whether the motion is to end."""
    return getattr(_here, "noted", False)


def heed() -> None:
    """An `Interrupted` if the motion is to end; once, as functions are asked for its last state after that."""
    if (is_noted() or getattr(_here, "late", bool)()) and not _here.heeded:
        _here.heeded = True
        raise Interrupted


def check_whole(solution: Any) -> Any:
    """The solution; the KeyboardInterrupt that ended it, where a part of it is of no use."""
    if solution.status == "stopped" and solution.message.startswith(MESSAGE):
        raise KeyboardInterrupt
    return solution

# SPDX-License-Identifier: BSD-3-Clause
"""Work that makes many nodes and drops few lets Python's collector of cycles run seldom.

A derivation makes hundreds of thousands of tuples and nodes that stay, and hardly a cycle. At its usual thresholds the collector goes
through all of them again and again, and through all that the process holds: a third of the time of large systems, and more than in
proportion to them.
"""

import gc
import threading
from collections.abc import Iterator
from contextlib import contextmanager

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

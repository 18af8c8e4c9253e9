# SPDX-License-Identifier: BSD-3-Clause
"""The queue from which lanes take up one instance after the other: a kernel that stores what has ended, and loads the next."""

from collections.abc import Iterable

from kane.motion.steppers.context import QUEUE, Slot
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Array, Term, Writer

LOADED, SAVED = ("s", "y", "p", "r", "times"), ("s", "y", "rows")
"""The arrays of which an instance has a row in `instances`, one after the other, and in `results`."""
NEXT, COUNT, SIZES = 0, 1, 2
"""Places in `queue`: the next instance, how many there are, the sizes of the arrays, and for each lane its instance, −1 for none."""
ARRAYS = ("s", "y", "lag", "p", "r", "times", "rows")


def queue_kernel(width: int) -> Kernel:
    """What `width` lanes call where some have ended, which is where BACK is not zero: it becomes zero where there is a next one."""
    w = Writer(f"next{width}")
    w.number("lanes")
    arrays = {name: w.array(name) for name in ARRAYS}
    queue, instances, results = (w.array(name) for name in QUEUE)
    back = w.variable("back", INT)
    sizes = {name: w.compute("int", queue[SIZES + k]) for k, name in enumerate(ARRAYS)}
    s, own_at = arrays["s"], SIZES + len(ARRAYS)

    def places(names: Iterable[str], at: Term) -> Iterable[tuple[Array, Term, Term]]:
        for name in names:
            yield arrays[name], at, sizes[name]
            at = at + sizes[name]

    def length(names: Iterable[str]) -> Term:
        total = w.integer(0)
        for name in names:
            total = total + sizes[name]
        return total

    with w.few(width) as lane, w.when(s[lane + int(Slot.BACK) * width] > 0.0):
        own = w.compute("int", queue[own_at + lane])
        with w.when(own >= 0):
            for array, at, size in places(SAVED, own * length(SAVED)):
                with w.few(size) as k:
                    results[at + k] = array[k * width + lane]
        new = w.compute("int", queue[NEXT])
        with w.when(new < w.compute("int", queue[COUNT])):
            for array, at, size in places(LOADED, new * length(LOADED)):
                with w.few(size) as k:
                    array[k * width + lane] = instances[at + k]
            with w.few(sizes["lag"]) as k:
                arrays["lag"][k * width + lane] = 0.0
            queue[own_at + lane] = queue[NEXT]
            queue[NEXT] = queue[NEXT] + 1.0
        with w.otherwise():
            queue[own_at + lane] = -1.0
    return w.finished(back)

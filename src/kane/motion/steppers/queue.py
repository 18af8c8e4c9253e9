# SPDX-License-Identifier: BSD-3-Clause
"""A queue from which vector lanes take one instance after the other: a kernel that stores ended instances and loads the next."""

from collections.abc import Iterable, Iterator, Sequence

from kane.motion.steppers.context import CLEARED, LOADED, QUEUE, SAVED, Slot
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Array, Term, Writer

NEXT, COUNT, SIZES = 0, 1, 2
"""Indices in `queue`: the next instance, their number, the sizes of the arrays; then the instance of each lane, −1 for none."""


def queue_kernel(width: int, names: Sequence[str]) -> Kernel:
    """The kernel that `width` lanes call when some have ended, those with nonzero BACK; it becomes zero if another one is loaded.

    `names` are the arrays of an instance; of the logs of events and actions only the filled part is stored.
    """
    w = Writer(f"next{width}")
    w.number("lanes")
    arrays = {name: w.array(name) for name in names}
    queue, instances, results = (w.array(name) for name in QUEUE)
    back = w.variable("back", INT)
    sizes = {name: w.compute("int", queue[SIZES + k]) for k, name in enumerate(names)}
    own_at = SIZES + len(names)

    def places(of: Iterable[str], row: Term) -> Iterator[tuple[str, Array, Term]]:
        """The arrays that exist, and the index of each in a row."""
        there, length = [name for name in of if name in arrays], w.integer(0)
        for name in there:
            length = length + sizes[name]
        at = row * length
        for name in there:
            yield name, arrays[name], at
            at = at + sizes[name]

    with w.few(width) as lane, w.when(arrays["s"][lane + int(Slot.BACK) * width] > 0.0):

        def filled(name: str) -> Term:
            told = {"log": (Slot.LOGGED, w.integer(2)), "jumps": (Slot.JUMPS, sizes["y"] * 2 + 2)}
            if name not in told:
                return sizes[name]
            slot, each = told[name]
            return w.compute("int", arrays["s"][lane + int(slot) * width]) * each

        own = w.compute("int", queue[own_at + lane])
        with w.when(own >= 0):
            for name, array, at in places(SAVED, own):
                with w.few(filled(name)) as k:
                    results[at + k] = array[k * width + lane]
        new = w.compute("int", queue[NEXT])
        with w.when(new < w.compute("int", queue[COUNT])):
            for name, array, at in places(LOADED, new):
                with w.few(sizes[name]) as k:
                    array[k * width + lane] = instances[at + k]
            for name in CLEARED:
                if name in arrays:
                    with w.few(sizes[name]) as k:
                        arrays[name][k * width + lane] = 0.0
            queue[own_at + lane] = queue[NEXT]
            queue[NEXT] = queue[NEXT] + 1.0
        with w.otherwise():
            queue[own_at + lane] = -1.0
    return w.finished(back)

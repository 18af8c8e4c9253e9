# SPDX-License-Identifier: BSD-3-Clause
"""A queue from which vector lanes take one instance after the other: a kernel that stores ended instances and loads the next."""

from collections.abc import Iterable, Iterator, Sequence

from kane.motion.steppers.context import CLEARED, LOADED, QUEUE, SAVED, Slot
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Array, Term, Writer

NEXT, COUNT, SIZES = 0, 1, 2
"""Indices in `queue`: the next instance, their number, the sizes of the arrays; then the instance of each lane, −1 for none."""
NEAR = 1 / 64
"""A lane that has ended waits for those whose rest is below this share of their steps: lanes with similar motions then stay abreast,
so that samples fall into the same steps and are written at once."""


def queue_kernel(width: int, names: Sequence[str]) -> Kernel:
    """The kernel that `width` lanes call when some have ended, those with nonzero BACK; it becomes zero if another one is loaded.

    A lane that waits has FRESH = 2: it projects its last state and has ended again. `names` are the arrays of an instance; of the logs
    of events and actions only the filled part is stored.
    """
    w = Writer(f"next{width}")
    w.number("lanes")
    arrays = {name: w.array(name) for name in names}
    queue, instances, results = (w.array(name) for name in QUEUE)
    back = w.variable("back", INT)
    sizes = {name: w.compute("int", queue[SIZES + k]) for k, name in enumerate(names)}
    own_at, back_at = SIZES + len(names), int(Slot.BACK) * width

    def places(of: Iterable[str], row: Term) -> Iterator[tuple[str, Array, Term]]:
        """The arrays that exist, and the index of each in a row."""
        there, length = [name for name in of if name in arrays], w.integer(0)
        for name in there:
            length = length + sizes[name]
        at = row * length
        for name in there:
            yield name, arrays[name], at
            at = at + sizes[name]

    def slot(lane: Term, at: Slot) -> Term:
        return arrays["s"][lane + int(at) * width]

    def filled(name: str, lane: Term) -> Term:
        told = {"log": (Slot.LOGGED, w.integer(2)), "jumps": (Slot.JUMPS, sizes["y"] * 2 + 2)}
        if name not in told:
            return sizes[name]
        return w.compute("int", slot(lane, told[name][0])) * told[name][1]

    waits = w.variable("waits", INT)
    waits.put(0)
    with w.few(width) as lane, w.when(arrays["s"][lane + back_at].equals(0.0) & (queue[own_at + lane] >= 0.0)):
        end, t, h, steps = (slot(lane, at) for at in (Slot.END, Slot.TIME, Slot.STEP, Slot.STEPS))
        with w.when(end - t <= h * steps * NEAR):
            waits.put(1)
    with w.few(width) as lane, w.when(~arrays["s"][lane + back_at].equals(0.0)):
        own = w.compute("int", queue[own_at + lane])
        with w.when(own >= 0):
            for name, array, at in places(SAVED, own):
                with w.few(filled(name, lane)) as k:
                    results[at + k] = array[k * width + lane]
            queue[own_at + lane] = -1.0
        new = w.compute("int", queue[NEXT])
        with w.when(new < w.compute("int", queue[COUNT])):
            with w.when(waits.get() > 0):
                arrays["s"][lane + back_at] = 0.0
                arrays["s"][lane + int(Slot.FRESH) * width] = 2.0
            with w.otherwise():
                for name, array, at in places(LOADED, new):
                    with w.few(sizes[name]) as k:
                        array[k * width + lane] = instances[at + k]
                for name in CLEARED:
                    if name in arrays:
                        with w.few(sizes[name]) as k:
                            arrays[name][k * width + lane] = 0.0
                queue[own_at + lane] = queue[NEXT]
                queue[NEXT] = queue[NEXT] + 1.0
    return w.finished(back)

# SPDX-License-Identifier: BSD-3-Clause
"""A queue from which vector lanes take one instance after the other: a kernel that stores ended instances and loads the next."""

from collections.abc import Iterable, Iterator, Sequence

from kane.motion.steppers.context import CLEARED, LOADED, QUEUE, SAVED, Slot
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Array, Term, Writer

NEAR = 1 / 64
"""A lane that has ended waits for lanes that end within this share of their steps, so that lanes with similar motions stay abreast:
they then have samples in the same steps, and the code that writes samples is executed once for all of them."""
NEXT, COUNT, SIZES = 0, 1, 2
"""Indices in `queue`: the next instance, their number, the sizes of the arrays; then the instance of each lane, −1 for none."""


def queue_kernel(width: int, names: Sequence[str]) -> Kernel:
    """The kernel that `width` lanes call when some have ended, those with nonzero BACK; it becomes zero if another one is loaded.

    A lane that waits projects its last state, by FRESH = 2, so that it has ended again after one round. `names` are the arrays of an instance; of the logs of events and actions only the filled part is stored.
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

    def get(lane: Term, at: Slot) -> Term:
        return arrays["s"][lane + int(at) * width]

    def put(lane: Term, at: Slot, value: float) -> None:
        arrays["s"][lane + int(at) * width] = value

    def filled(name: str, lane: Term) -> Term:
        told = {"log": (Slot.LOGGED, w.integer(2)), "jumps": (Slot.JUMPS, sizes["y"] * 2 + 2)}
        if name not in told:
            return sizes[name]
        count, each = told[name]
        return w.compute("int", get(lane, count)) * each

    waits = w.variable("waits", INT)
    waits.put(0)
    with w.few(width) as lane, w.when(get(lane, Slot.BACK).equals(0.0) & (queue[own_at + lane] >= 0.0)):
        rest = get(lane, Slot.END) - get(lane, Slot.TIME)
        with w.when(rest <= get(lane, Slot.STEP) * get(lane, Slot.STEPS) * NEAR):
            waits.put(1)
    with w.few(width) as lane, w.when(~get(lane, Slot.BACK).equals(0.0)):
        own = w.compute("int", queue[own_at + lane])
        with w.when(own >= 0):
            for name, array, at in places(SAVED, own):
                with w.few(filled(name, lane)) as k:
                    results[at + k] = array[k * width + lane]
            queue[own_at + lane] = -1.0
        new = w.compute("int", queue[NEXT])
        with w.when(new < w.compute("int", queue[COUNT])):
            with w.when(waits.get() > 0):
                put(lane, Slot.BACK, 0.0)
                put(lane, Slot.FRESH, 2.0)
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

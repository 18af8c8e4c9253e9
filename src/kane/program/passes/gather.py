# SPDX-License-Identifier: BSD-3-Clause
"""Sines and cosines of as many angles as a vector has lanes, one after the other in a long block.

In an order that is depth first each angle's stand where the first of them is read, link by link, and a piece of the block holds few of
them: one vector of eight angles takes no more code than one angle. Angles that inputs give, or one operation of inputs, can be had
as soon as the first one of eight is wanted.
"""

from collections.abc import Sequence

from kane.expr.ops import COS, SIN
from kane.program.program import Program


def gathered(program: Program, block: Sequence[int], lanes: int) -> tuple[int, ...]:
    """`block` with the sines and cosines of near angles in packs of `lanes`, each where its first one stood."""
    within = set(block)
    own: dict[int, list[int]] = {}  # by angle
    for i in block:
        if program.op(i) in (SIN, COS):
            angle = program.arguments(i)[0]
            if angle not in within or _near(program, angle, within):
                own.setdefault(angle, []).append(i)
    angles = list(own)
    packs: dict[int, list[int]] = {}  # by their first instruction in the block
    for k in range(0, len(angles), lanes):
        pack = angles[k : k + lanes]
        packs[own[pack[0]][0]] = [*(a for a in pack if a in within), *(i for a in pack for i in own[a])]
    placed: dict[int, None] = {}
    for i in block:
        # an angle that something else reads before stays where it is
        placed.update(dict.fromkeys(packs.get(i, (i,))))
    return tuple(placed)


def _near(program: Program, angle: int, within: set[int]) -> bool:
    """Whether an angle is one operation of what the block does not compute, and no sine itself."""
    return program.op(angle) not in (SIN, COS) and within.isdisjoint(program.arguments(angle))

# SPDX-License-Identifier: BSD-3-Clause
"""Constraints of motions in machine code: what kernels are told of them, and the step that Python looks at because they ask.

Kernels keep them and tell where they may be singular, may not be held, or need other dependent speeds (`steppers/held.py`); a step in
doubt is judged here, as those of SciPy's solvers are.
"""

from collections.abc import Callable

import numpy as np

from kane.dynamics.constraints.manifold import branches
from kane.dynamics.constraints.partition import quality
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO
from kane.expr.regular import Sizes, size
from kane.motion.hybrid.events import Inspection, Verdict
from kane.motion.projection import Numbers, Tolerances
from kane.motion.right_hand_side import Given
from kane.motion.steppers.context import Slot
from kane.motion.steppers.held import COUNTS, room
from kane.motion.steps import Stepper, better
from kane.numeric.arrays import Array
from kane.numeric.rank import balance
from kane.numeric.scale import POOR
from kane.program.from_expressions import Bundle
from kane.program.native.entry import aligned, entry, hoist_entry, hoisted

_WELL, _POORLY = 2.5, 0.25
"""Quality over the least one at which kernels take up a motion again, and below which they give it up."""
Pairs = tuple[tuple[int, int], ...]


def holding(eom: Equations) -> Bundle[tuple[Array, ...]]:
    """f, the sizes of its terms, b, the cosines of the branches, and the entries of A and W that are not zero."""
    solved, memo = eom.solved, Sizes()
    f, d = [c.expr for c in eom.system.holonomic], solved.regular
    groups = {
        "f": f,
        "terms": [size(x, memo) for x in f],
        "b": d.b,
        "cosines": [b.cosine for b in branches(eom.system)],
        "a": solved.written([d.A[place] for place in entries(eom)]),
        "w": solved.written([d.W[place] for place in turns(eom)]),
    }
    return Bundle("holding", ports(eom.derived), _parts, groups)


def _parts(*parts: Array) -> tuple[Array, ...]:
    return parts


def entries(eom: Equations) -> Pairs:
    """The places of A at which it is not zero."""
    return _filled(eom.solved.regular.A)


def turns(eom: Equations) -> Pairs:
    """Those of W, but for its columns beside the speeds."""
    return tuple(place for place in _filled(eom.solved.regular.W) if place[1] < len(eom.speeds))


def _filled(matrix: Matrix) -> Pairs:
    rows, columns = matrix.shape
    return tuple((i, j) for i in range(rows) for j in range(columns) if matrix[i, j] is not ZERO)


def unheld(stepper: Stepper) -> str:
    """Why constraints are kept by Python alone, in words; "" where a kernel can."""
    if stepper.projection is None:
        return ""
    if stepper.kinks is not None:
        return "constraints bend"
    if stepper.lost or stepper.mixes != (None, None):
        return "constraints lose rank"
    return "W has poles that the motion has not" if stepper.eom.solved.twin is not None else ""


def _rows(eom: Equations) -> tuple[list[int], list[int]]:
    """The rows that give dependent speeds, closures first, and these speeds."""
    if eom.embedding is None:
        return [], []
    return sorted(eom.embedding.partition.rows), sorted(eom.embedding.partition.dependent)


def structure(eom: Equations, n: int) -> Given:
    """What of the constraints is the same for all motions of n components: counts, where what stands, and room."""
    rows, dependent = _rows(eom)
    places, turned = entries(eom), turns(eom)
    c, place = len(eom.system.holonomic), {q: i for i, q in enumerate(eom.coordinates)}
    spheres = [place[e] for s in eom.system.euler_parameters for e in s.coordinates]
    counts = (c, len(eom.b), len(eom.speeds), len(rows), sum(i < c for i in rows), len(places), len(turned))
    counted = dict(zip(COUNTS, (*counts, len(spheres) // 4, len(branches(eom.system)), len(place)), strict=True))
    slots = {row: k for k, row in enumerate(rows)}
    at = {
        "entry_at": [(slots.get(i, -1), i, j) for i, j in places],
        "turn_at": turned,
        "chosen_at": rows,
        "dependent": dependent,
        "sphere_at": spheres,
    }
    # one more, so that no array is empty
    arrays = {name: np.append(np.array(where, dtype=float).reshape(-1), 0.0) for name, where in at.items()}
    lengths = {"weights": len(places), "reach": len(places), "row_sizes": len(eom.b), "column_sizes": len(eom.speeds)}
    arrays |= {name: np.zeros(count + 1) for name, count in lengths.items()}
    arrays["room"] = aligned(room(n, counted))
    return {f"held_{name}": value for name, value in (counted | arrays).items()}


class Holding:
    """The constraints as a kernel takes them, for the dependent speeds that are stepped now."""

    def __init__(self, stepper: Stepper, t: float, y: Array) -> None:
        self.stepper, now, eom = stepper, stepper.now, stepper.eom
        self.places = entries(eom)
        routine = eom.numeric(now.settings).routine(holding).flat
        self.given = structure(eom, len(y))
        self.given["held_h"] = hoisted(routine, t, y[: now.width], now.p, now.inputs(t, y))
        self.given["hoist_held_h"] = hoist_entry(routine)
        self.given["constraints"] = entry(routine)
        self.measure()

    def measure(self) -> None:
        """The sizes of rows and columns of A are those that entries have had by now."""
        given, stepper = self.given, self.stepper
        for place, had in zip(self.places, given["held_reach"], strict=False):
            stepper.reach[place] = max(stepper.reach[place], had)
        scaled = balance(stepper.reach, order=(1, 0))
        rows, columns = 1 / scaled.rows[:, 0], 1 / scaled.columns[0]
        given["held_row_sizes"][:-1], given["held_column_sizes"][:-1] = rows, columns
        given["held_weights"][:-1] = [rows[i] * columns[j] for i, j in self.places]

    def begin(self, s: Array) -> None:
        """What the kernel is told before its first step."""
        s[Slot.QUIET] = 1 / POOR

    def look(
        self, dense: Callable[[Array], Array], start: float, end: float, narrow: float, tolerances: Tolerances
    ) -> Inspection:
        """A step that may lead where constraints are singular or cannot be kept; no step is made shorter than `narrow`."""
        stepper, reach = self.stepper, self.stepper.reach
        kept, numbers = stepper.keep(end, dense(np.array([end]))[0])
        assert numbers is not None
        turned, missed = stepper.turned(numbers), stepper.missed(end, kept, numbers, tolerances)
        if (turned or missed or not numbers.finite) and end - start > narrow:
            return Inspection(Verdict.SHORTER)
        if turned:
            return Inspection(Verdict.TURNED, message=turned)
        if missed:
            return Inspection(Verdict.MISSED, message=missed)

        def states(t: float | Array) -> Array:
            found = dense(np.atleast_1d(t))
            return found.T if np.ndim(t) else found[0]

        if not numbers.finite or self._poor(numbers):
            return Inspection(Verdict.SINGULAR)
        if not (stepper.jumped(numbers) or stepper.crosses(states, start, end)):
            # the kernel moves the step's end by them: entries may have grown from nothing, as it has noted
            stepper.reach = reach
            self.measure()
            return Inspection(Verdict.TAKEN)
        # where speeds alone are poor others are taken, nearby: `settle`
        lost = end - start <= narrow or stepper.crosses(states, start, end, rank_alone=True)
        return Inspection(Verdict.SINGULAR if lost else Verdict.SHORTER)

    def _poor(self, numbers: Numbers) -> bool:
        """Whether dependent speeds hardly follow, and no others do better."""
        stepper = self.stepper
        if regular(stepper, numbers, _POORLY):
            return False
        assert stepper.eom.embedding is not None
        return better(numbers.a, stepper.eom.embedding.partition, stepper.reach, False, stepper.mixes[1]) is None

    def taken(self, s: Array) -> None:
        """A step that was looked at was taken: as long as speeds are hardly poorer, they are not looked at again."""
        s[Slot.QUIET] = max(s[Slot.QUIET], 1.25 * s[Slot.SHARE])


def regular(stepper: Stepper, numbers: Numbers | None, share: float = _WELL) -> bool:
    """Whether the dependent speeds follow from the others at a state, by that share of what is wanted, so well that kernels go on."""
    embedding = stepper.eom.embedding
    if embedding is None or numbers is None:
        return True
    return quality(numbers.a, embedding.partition, stepper.reach) > share * POOR

# SPDX-License-Identifier: BSD-3-Clause
"""Constraints in kernels: the arguments with which a kernel satisfies them, and the decision on steps that it cannot decide.

A kernel projects states by itself, and returns a step in which constraints may be singular or violated, or that needs other dependent
speeds (`steppers/held.py`). Such a step is decided here, by the criteria that apply to SciPy's solvers too.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import combinations

import numpy as np

from kane.dynamics.constraints.manifold import branches
from kane.dynamics.constraints.partition import Partition
from kane.equations.compiled import ports
from kane.equations.equations import Equations, repartition
from kane.errors import KaneError
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO
from kane.expr.regular import Sizes, size
from kane.motion.arguments import Arguments, by_kind
from kane.motion.course import StepVerdict, Verdict
from kane.motion.hybrid.automaton import on_their_sides, stepped
from kane.motion.inputs.expressions import parts
from kane.motion.kinks import Dense
from kane.motion.projection import Numbers
from kane.motion.right_hand_side import Given, Routines
from kane.motion.steppers.context import ReturnCode, Slot
from kane.motion.steppers.held import CHANGES, COUNTS, POORER, POORLY, room
from kane.motion.steps import Stepper, better, regular
from kane.numeric.arrays import Array
from kane.numeric.scale import POOR, UNUSABLE
from kane.program.from_expressions import Bundle
from kane.program.native.entry import Selection, aligned, entry, hoisted
from kane.program.native.machine import Settings

Pairs = tuple[tuple[int, int], ...]


def holding(eom: Equations) -> Bundle[tuple[Array, ...]]:
    """f, the sizes of its terms, b, the cosines of the closure branches, and the nonzero entries of A and W."""
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
    return Bundle("holding", ports(eom.derived), parts, groups)


def entries(eom: Equations) -> Pairs:
    """Indices (i, j) of the entries of A that are not identically zero."""
    return _filled(eom.solved.regular.A)


def turns(eom: Equations) -> Pairs:
    """Indices (i, j) of the entries of W that are not identically zero, in the columns of the speeds."""
    return tuple(place for place in _filled(eom.solved.regular.W) if place[1] < len(eom.speeds))


def _filled(matrix: Matrix) -> Pairs:
    rows, columns = matrix.shape
    return tuple((i, j) for i in range(rows) for j in range(columns) if matrix[i, j] is not ZERO)


def structure(eom: Equations, n: int) -> Given:
    """The arguments that depend on the structure of the constraints alone, for y of n components: counts, indices, work space."""
    rows = [] if eom.embedding is None else sorted(eom.embedding.partition.rows)  # configuration constraints first
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
        "sphere_at": spheres,
    }
    # padded by one entry, so that no array is empty
    arrays = {name: np.append(np.array(where, dtype=float).reshape(-1), 0.0) for name, where in at.items()}
    lengths = {"weights": len(places), "reach": len(places), "row_sizes": len(eom.b), "column_sizes": len(eom.speeds)}
    arrays |= {name: np.zeros(count + 1) for name, count in lengths.items()}
    arrays |= {"quiet": np.zeros(1), "room": aligned(room(n, counted)), "log": np.zeros(2 * CHANGES + 3)}
    return {f"held_{name}": value for name, value in (counted | arrays).items()}


def among(choices: Sequence[Partition], place: int) -> Given:
    """The arguments for several choices of dependent speeds, of which only the first is compiled; p[place] is the one in use."""
    dependent = [j for choice in choices for j in sorted(choice.dependent)]
    ready = np.array([1.0] + [0.0] * (len(choices) - 1))
    return {
        "held_choices": len(ready),
        "held_choice_at": place,
        "held_ready": ready,
        "held_dependent": np.array([*dependent, 0.0], dtype=float),
    }


def holding_one(now: Routines, t: float, y: Array) -> Given:
    """The arguments for constraints with one choice of dependent speeds."""
    routine, given = now.eom.numeric(now.settings).routine(holding).flat, structure(now.eom, len(y))
    given |= now.hoisted("held_h", routine, t, y, now.inputs(t, y)) | {"constraints": entry(routine)}
    return given | among(choices(now.eom)[:1], 0)


_CHOICES = 6
"""Largest number of choices of dependent speeds that a kernel compares."""


def choices(eom: Equations) -> tuple[Partition, ...]:
    """All choices of dependent speeds for the same rows, the present one first; only that one if there are too many."""
    if eom.embedding is None:
        return ()
    own = eom.embedding.partition
    others = [c for c in combinations(range(len(eom.speeds)), len(own.dependent)) if set(c) != set(own.dependent)]
    return (own, *(replace(own, dependent=c) for c in others)) if len(others) < _CHOICES else (own,)


def alike(eom: Equations, other: Equations) -> bool:
    """Whether A and W have the same nonzero entries with the dependent speeds of `other`, and no false poles."""
    return other.solved.twin is None and entries(other) == entries(eom) and turns(other) == turns(eom)


def stepping(stepper: Stepper, choice: Partition) -> Routines:
    """The routines of the equations with a choice of dependent speeds."""
    now = stepper.now
    return stepped(stepper.numeric.value(repartition, choice), now.p, now.drives, now.settings)


def wanted(eom: Equations) -> set[Partition]:
    """The choices of dependent speeds that motions of the equations have needed: a set stored with them, empty at first."""
    return set()


class KernelConstraints:
    """The constraints of a kernel with given `arguments`, and the choices of dependent speeds between which it changes.

    It begins with the present choice; others are compiled when the kernel first needs them.
    """

    def __init__(self, stepper: Stepper, arguments: Arguments, t: float, y: Array) -> None:
        self.stepper, now, eom = stepper, stepper.now, stepper.eom
        self.arguments, self.at = arguments, (t, y.copy())
        self.rows, self.columns = np.array(entries(eom), dtype=int).reshape(-1, 2).T
        self.given = holding_one(now, t, y)
        self.choices, self.steppable = choices(eom), dict[int, Routines]({0: now})
        if len(self.choices) > 1 and not arguments.integrator.implicit:
            self.choose_among()

    def choose_among(self) -> None:
        """Replaces the right-hand side by a selection: the last entry of p is the number of the choice in use."""
        given, count = self.arguments.given, len(self.choices)
        place = len(given["p"]) - 1
        self.rates = Selection(count, place, self.arguments.integrator.width, self.stepper.now.settings or Settings())
        self.rates.put(0, self.arguments.now.rates, given["h"])
        self.given |= {"rhs": self.rates.call, "h": self.rates.table, "hoist_h": self.rates.hoist}
        self.given |= among(self.choices, place)
        for k in range(1, count):
            if self.choices[k] in self.stepper.numeric.value(wanted):
                self.compile(k)

    def compile(self, k: int) -> None:
        """Compiles choice k; excludes it if that fails or if other arguments of the kernel would change."""
        stepper, now = self.stepper, self.arguments.now
        ready = self.given["held_ready"]
        ready[k] = -1.0
        stepper.numeric.value(wanted).add(self.choices[k])
        with suppress(KaneError):
            plain = stepping(stepper, self.choices[k])
            found = on_their_sides(plain)
            if self._is_alike(found):
                t, y = self.at
                self.rates.put(k, found.rates, hoisted(found.rates, t, y[: found.width], now.p, now.inputs(t, y)))
                self.steppable[k], ready[k] = plain, 1.0

    def completes(self, back: ReturnCode, s: Array) -> bool:
        """Whether the kernel returned because it needs a choice that is not compiled; that choice is then compiled."""
        wants = back is ReturnCode.LOOK and s[Slot.HELD] == POORER and s[Slot.WORST] >= 0
        if wants:
            self.compile(int(s[Slot.WORST]))
        return bool(wants)

    def _is_alike(self, other: Routines) -> bool:
        """Whether all arguments of the kernel except the rates are the same with the dependent speeds of `other`."""
        own = self.stepper.eom
        turning = zip(other.quantities, self.arguments.now.quantities, strict=False)
        same = len(other.quantities) == len(self.arguments.now.quantities) and all(a is b for a, b in turning)
        if self.arguments.integrator.width > 1:
            one, two = (e.numeric(other.settings).value(by_kind) for e in (own, other.eom))
            same = same and all(np.array_equal(one[name], two[name]) for name in one)
        return same and alike(own, other.eom)

    def changes(self) -> list[tuple[float, Routines]]:
        """The changes of dependent speeds by the kernel since the last call: times, and the routines used from then on."""
        log = self.given["held_log"]
        rows = log[1 : 1 + 2 * int(log[0])].reshape(-1, 2).tolist()
        log[0] = 0.0
        return [(t, self.steppable[int(k)]) for t, k in rows]

    def restart(self, stepper: Stepper) -> None:
        """Resets for another motion, that of `stepper`, whose start is known."""
        self.stepper, stepper.segments = stepper, []
        self.given["held_log"][0] = self.arguments.given["p"][-1] = 0.0

    def begin(self, s: Array) -> None:
        """Sets the sizes of A and resets the slots before the first step, in which the kernel measures the constraints."""
        self.given["held_reach"][:-1] = self.stepper.reach[self.rows, self.columns]
        s[[Slot.QUIET, Slot.CHOICE, Slot.MEASURED]] = 0.0

    def measure(self) -> None:
        """Includes the largest entries of A that the kernel has encountered in `reach` of the stepper."""
        rows, columns, stepper = self.rows, self.columns, self.stepper
        stepper.reach[rows, columns] = np.maximum(stepper.reach[rows, columns], self.given["held_reach"][:-1])
        self.reach = stepper.reach

    def singular(self, dense: Dense, start: float, end: float, narrow: float, numbers: Numbers) -> StepVerdict:
        """The verdict on a measured step in which constraints may be singular; steps up to `narrow` long are not shortened."""
        stepper, long = self.stepper, end - start > narrow
        if not numbers.finite and long:
            return StepVerdict(Verdict.SHORTER)
        if not numbers.finite or self._poor(numbers):
            return StepVerdict(Verdict.SINGULAR)
        if not (stepper.jumped(numbers) or stepper.crosses(dense, start, end)):
            stepper.reach = self.reach
            return StepVerdict(Verdict.TAKEN)
        # if only the choice of speeds is poor, a shorter step ends near by, where `settle` changes it
        lost = not long or stepper.crosses(dense, start, end, rank_alone=True)
        return StepVerdict(Verdict.SINGULAR if lost else Verdict.SHORTER)

    def _poor(self, numbers: Numbers) -> bool:
        """Whether the dependent speeds are poorly determined, and no other choice is better."""
        stepper = self.stepper
        embedding = stepper.eom.embedding
        whole = embedding is not None and len(embedding.partition.dependent) == len(stepper.eom.speeds)
        if regular(stepper, numbers, UNUSABLE / POOR if whole else POORLY):
            return False
        assert stepper.eom.embedding is not None
        return better(numbers.a, stepper.eom.embedding.partition, stepper.reach, False, stepper.mixes[1]) is None

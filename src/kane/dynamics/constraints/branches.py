# SPDX-License-Identifier: BSD-3-Clause
"""Whether a closed configuration is on the branch that its closures mean.

Products of axes that hold an orientation vanish at others too: where an axis is reversed, where a frame is turned by half a turn
or by a third. Each closure says the cosine of the angle by which it is turned, which is 1 on the branch that is meant.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from kane.expr.evaluation import compile_reference
from kane.expr.node import Expr
from kane.model.constraints import Branch
from kane.model.system import System
from kane.numeric.arrays import Array

_HOLDS = 1e-4
"""A product of unit vectors that vanishes, at a configuration that was closed."""


def branches(system: System) -> tuple[Branch, ...]:
    """The branches that the configuration constraints of a system mean, each once."""
    return tuple(dict.fromkeys(c.branch for c in system.holonomic if c.branch is not None))


def branch_scalars(meant: tuple[Branch, ...]) -> list[Expr]:
    """What `turned` takes the numbers of."""
    return [x for b in meant for x in (b.cosine, *b.rows)]


def turned(meant: tuple[Branch, ...], scalars: Array) -> Array:
    """By what angle (rad) each closure is turned away from the branch that is meant, 0 where it is on it.

    `scalars` (…, k) are numbers of `branch_scalars` at a closed configuration, the angles (…, b). Where a system lists only some of
    a closure's rows and others do not vanish, nothing was said of its orientation, and it counts as 0.
    """
    angles = np.zeros((*scalars.shape[:-1], len(meant)))
    at = 0
    for k, b in enumerate(meant):
        cosine, rows = scalars[..., at], scalars[..., at + 1 : at + 1 + len(b.rows)]
        away = (cosine <= 0) & (np.abs(rows).max(axis=-1) <= _HOLDS)
        angles[..., k] = np.where(away, np.arccos(np.clip(cosine, -1, 1)), 0.0)
        at += 1 + len(b.rows)
    return angles


def told(meant: tuple[Branch, ...], angles: Array) -> str:
    """Which closures are turned, and by how much, in words; "" where none is."""
    return ", ".join(
        f"{b.name!r} with its {b.what} turned by {np.degrees(x):.0f}°" for b, x in zip(meant, angles, strict=True) if x
    )


def turned_function(system: System, values: Mapping[Expr, Any]) -> Callable[[Array], Array]:
    """`turned` as a function of the coordinates (…, n), all other symbols at `values`, on the reference evaluator."""
    meant = branches(system)
    if not meant:
        return lambda q: np.zeros((*q.shape[:-1], 0))
    run = compile_reference(branch_scalars(meant), [*system.coordinates, *values])
    rest = list(values.values())

    def angles(q: Array) -> Array:
        scalars = run([*np.moveaxis(q, -1, 0), *rest])
        shaped = [np.broadcast_to(x, q.shape[:-1]) for x in scalars]
        return turned(meant, np.stack(shaped, axis=-1))

    return angles

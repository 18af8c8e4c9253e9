# SPDX-License-Identifier: BSD-3-Clause
"""A value for every symbol: the one given, else a parameter's default, else a number drawn at random.

What is drawn depends on the seed and the symbol's declaration alone: not on what else was drawn, nor on the process.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kane.expr.evaluation import FLOAT
from kane.expr.node import Expr, constant_value, postorder
from kane.expr.ops import CONST, PI, SYMBOL
from kane.expr.symbols import Parameter

LOW, HIGH = 0.3, 1.2
"""Numbers are drawn from this range: no angle there is special, no length zero."""
SEEDS = (20042, 20043, 20044)
"""Of the samples that tell whether something is zero everywhere: what is not, vanishes at none of them but by a chance of 1e-12."""
SEED = 20322
"""Of whatever else is drawn at random: starts, configurations, values that nothing gives. Choices made from these depend on it."""
ASSEMBLY_SEED = 20048
"""Of starts of assembly, and of places that tell sizes of coordinates: by these distances are measured, and what is nearest."""
_WORD = 2**64 - 1


def draw(seed: int, symbol: Expr, low: float = LOW, high: float = HIGH) -> float:
    """A number between `low` and `high`: the structural key of the symbol, mixed with the seed.

    The mixing is that of SplitMix64 (Steele, Lea & Flood 2014): every bit of the result depends on every bit of its argument.
    """
    z = (symbol.key + seed * 0x9E3779B97F4A7C15) & _WORD
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _WORD
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _WORD
    return low + (high - low) * ((z ^ (z >> 31)) >> 11) * 2.0**-53


def draws(seeds: int, symbols: Iterable[Expr]) -> NDArray[np.float64]:
    """What `draw` gives for each of the symbols with the seeds 0, 1, …, by rows."""
    keys = np.array([s.key & _WORD for s in symbols], dtype=np.uint64)
    z = keys[:, None] + np.arange(seeds, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    whole: NDArray[np.float64] = ((z ^ (z >> np.uint64(31))) >> np.uint64(11)).astype(float)
    return LOW + (HIGH - LOW) * whole * 2.0**-53


def value_of(symbol: Any, seed: int) -> float:
    """The default of the symbol, where it has one, else a number drawn."""
    return draw(seed, symbol) if symbol.default is None else float(symbol.default)


def values_of(symbols: Iterable[Any], seed: int, values: Mapping[Any, float] | None = None) -> dict[Any, float]:
    """A value for every symbol: the one in `values`, else its default, else a number drawn. Keeps the other `values` too."""
    complete = dict(values or {})
    complete.update((s, value_of(s, seed)) for s in symbols if s not in complete)
    return complete


def unit(values: dict[Any, Any], groups: Iterable[Sequence[Any]]) -> dict[Any, Any]:
    """The same with the values of each group divided by its length: Euler parameters are those of rotations.

    Others would scale what they turn, from link to link, by as many factors as there are links.
    """
    for group in groups:
        own = np.array([values[e] for e in group if e in values])
        if len(own) == len(group):
            values.update(zip(group, own / np.linalg.norm(own, axis=0), strict=True))
    return values


def sample(roots: Iterable[Expr], seed: int, groups: Iterable[Sequence[Expr]] = (), spread: float = 1.0) -> list[float]:
    """Values at one point: parameters at their defaults, other symbols drawn; `groups` of them are Euler parameters.

    What is drawn of others than parameters is multiplied by `spread`. For questions about structure (is this zero everywhere?), asked
    while deriving: one pass over the graph.
    """
    wanted = list(roots)
    values: dict[Expr, float] = {}
    order = postorder(wanted)
    symbols = [node for node in order if node.op is SYMBOL]
    values.update((s, value_of(s, seed) * (1.0 if isinstance(s, Parameter) else spread)) for s in symbols)
    values = {s: float(x) for s, x in unit(values, groups).items()}
    with np.errstate(all="ignore"):
        for node in order:
            if node.op is SYMBOL:
                continue
            if node.op is CONST:
                values[node] = float(constant_value(node) or 0)
            elif node.op is PI:
                values[node] = math.pi
            else:
                values[node] = FLOAT[node.op](*[values[a] for a in node.args])
    return [values[e] for e in wanted]

# SPDX-License-Identifier: BSD-3-Clause
"""Designs of experiments: points between bounds by SciPy's low-discrepancy samplers, or all combinations of levels.

Sobol' points are scrambled, and truncated from the next power of two (Owen 1998; SciPy, `scipy.stats.qmc`).
"""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from kane import expect
from kane.equations.instances import table_of
from kane.errors import SimulationError, cut
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEED

PRODUCT = "product"
SAMPLERS = {"sobol": "Sobol", "latin": "LatinHypercube", "halton": "Halton", "uniform": None}
"""Samplers of the unit cube, with the name of SciPy's class, if any."""


def quantities(design: Any, sampler: str | None, count: int | None, seed: int | None) -> Mapping[Any, Any]:
    """The values of a design by name, one per instance: all combinations of the levels of a product, `count` points between bounds.

    Without a sampler, the design contains the values of the instances themselves.

    Raises
    ------
    SimulationError
        if the design is not a table with names, the sampler is unknown, bounds are not two ascending finite numbers, or count and
        seed do not suit the sampler
    """
    table = table_of(design)
    if not isinstance(table, Mapping):
        raise SimulationError(
            f"Expected a design as a dict, a DataFrame or a Dataset of names, got {cut(repr(design))}. Name each: {{'m': (1, 2)}}."
        )
    if sampler is not None:
        expect.one_of(sampler, (*SAMPLERS, PRODUCT), "the sampler of a design to be", error=SimulationError)
        expect.that(
            table, "at least one quantity in a design", table, "Name some: {'m': (1, 2)}.", error=SimulationError
        )
        return _product(table, count, seed) if sampler == PRODUCT else _points(table, sampler, count, seed)
    if count is not None or seed is not None:
        raise SimulationError(
            'Expected sampler= where count= or seed= are given, got none. Choose "sobol", "latin", "halton" or "uniform", or '
            "leave them out: without a sampler a design lists the values of the instances."
        )
    return table


def _product(design: Mapping[Any, Any], count: int | None, seed: int | None) -> dict[Any, Array]:
    given = [name for name, value in (("count", count), ("seed", seed)) if value is not None]
    cure = "Leave it out: a product has as many instances as its levels have combinations."
    expect.none(given, "no count or seed of a product", "{}", cure, error=SimulationError)
    levels = [_numbers(key, value, "levels of a product, a list of numbers,") for key, value in design.items()]
    columns = np.array(list(product(*levels))).reshape(-1, len(levels)).T
    return dict(zip(design, columns, strict=True))


def _points(design: Mapping[Any, Any], sampler: str, count: int | None, seed: int | None) -> dict[Any, Array]:
    wanted = expect.whole(
        count,
        f'count=, the instances of a design by sampler="{sampler}", a whole number above 0',
        least=1,
        error=SimulationError,
    )
    start = (
        SEED
        if seed is None
        else expect.whole(seed, "seed= as a whole number from 0 on", least=0, error=SimulationError)
    )
    low, high = np.array([_bounds(key, value) for key, value in design.items()]).T
    points = low + (high - low) * _drawn(sampler, len(low), wanted, np.random.default_rng(start))
    return dict(zip(design, points.T, strict=True))


def _drawn(sampler: str, width: int, count: int, rng: np.random.Generator) -> Array:
    """Points (count × width) of the unit cube."""
    kind = SAMPLERS[sampler]
    if kind is None:
        return rng.random((count, width))
    from scipy.stats import qmc  # a slow import

    engine = getattr(qmc, kind)(width, seed=rng)
    if sampler == "sobol":
        return np.asarray(engine.random_base2((count - 1).bit_length())[:count])
    return np.asarray(engine.random(count))


def _bounds(key: Any, value: Any) -> Sequence[float]:
    result = _numbers(key, value, "two bounds (low, high)")
    if len(result) != 2 or not result[0] <= result[1]:
        raise SimulationError(
            f"Expected two bounds (low, high) for {key} in a design, got {cut(repr(value))}. Give the smaller one first; use "
            f'sampler="{PRODUCT}" for levels that are all combined, and no sampler for the values of the instances.'
        )
    return result


def _numbers(key: Any, value: Any, what: str) -> list[float]:
    """A list of finite numbers."""
    try:
        found = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        found = np.zeros(())
    if found.ndim != 1 or not np.isfinite(found).all():
        raise SimulationError(f"Expected {what} for {key} in a design, got {cut(repr(value))}. Give finite numbers.")
    numbers: list[float] = found.tolist()
    return numbers

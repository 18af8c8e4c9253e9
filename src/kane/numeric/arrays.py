# SPDX-License-Identifier: BSD-3-Clause
"""Array types and helpers: a reproducible matrix product, indices for messages, numerical direction cosines, medians.

Direction cosines are arrays C (3, 3) with v_base = C v_rotated. `pace` is the rate of change of ẋ = A x, in any units of x.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from kane.errors import SimulationError
from kane.expr.numbers import value_of_numbers
from kane.expr.ops import COS, OPS, SIN
from kane.numeric.scale import LAST_DIGIT, ROUNDED_ROOT

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Mask = npt.NDArray[np.bool_]
Entries = npt.NDArray[Any]
"""Numbers or expressions."""
Indices = npt.NDArray[np.intp]


def product(a: Array, b: Array) -> Array:
    """A B (l × m, m × n), summed in a fixed order, so that numbers in equations are the same on all machines; BLAS differs."""
    total = np.zeros((a.shape[0], b.shape[1]))
    for column, row in zip(a.T, b, strict=True):
        total += np.multiply.outer(column, row)
    return total


def by_substitution(lower: Array, right: Array) -> Array:
    """L⁻¹ b (n) or L⁻¹ B, of one B (n × m) or several (k × n × m)."""
    # turned round L is upper triangular, with nothing to eliminate; LAPACK's own `trtrs` wakes threads
    rows = -min(right.ndim, 2)
    return np.flip(np.linalg.solve(lower[::-1, ::-1], np.flip(right, rows)), rows)


def ranks(x: Array, apart: Array | float) -> Indices:
    """The rank of each number (k) in increasing order; neighbours that differ by no more than `apart` have the same rank."""
    order = np.argsort(x, kind="stable")
    places, each = np.zeros(len(x), dtype=np.intp), np.broadcast_to(apart, x.shape)[order]
    places[order[1:]] = np.cumsum(np.diff(x[order]) > np.maximum(each[1:], each[:-1]))
    return places


def leading(x: npt.NDArray[Any]) -> Indices:
    """The row of each column's (n × k) largest entry in size; the first one of those equal up to rounding."""
    size = np.abs(x)
    return (
        np.asarray((size >= (1 - ROUNDED_ROOT) * size.max(axis=0, initial=0)).argmax(axis=0))
        if x.size
        else np.zeros(0, dtype=np.intp)
    )


class First(NamedTuple):
    """The first true entry of a mask: its index `place`, () of a scalar, the index as text, and the number of `others`."""

    place: tuple[int, ...]
    written: str
    others: int

    def __str__(self) -> str:
        return f"index {self.written}{f' and {self.others} more' if self.others else ''}"


def first_index(mask: Any) -> First:
    """The first true entry of a mask that has one."""
    place = tuple(int(i) for i in np.argwhere(mask)[0])
    return First(place, str(place[0] if len(place) == 1 else place), int(np.sum(mask)) - 1)


ATAN2 = OPS["atan2"]


def turned(axis: int, c: float, s: float) -> Array:
    """The rotation matrix about basis vector `axis`, from cosine and sine."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    cosines = np.eye(3)
    cosines[j, j] = cosines[k, k] = c
    cosines[k, j], cosines[j, k] = s, -s
    return cosines


def about(axis: int, angle: float) -> Array:
    """The rotation matrix about basis vector `axis` by `angle` (rad)."""
    return turned(axis, value_of_numbers(COS, angle), value_of_numbers(SIN, angle))


def rounded(cosines: Array) -> Array:
    """The direction cosines, with entries that are 0 or ±1 up to rounding made exact."""
    near = np.round(cosines)
    return np.where(np.abs(cosines - near) <= LAST_DIGIT, near, cosines)


def zx(direction: Array) -> tuple[float, float]:
    """γ and α with R_z(γ) R_x(α) z = direction; γ is 0 where that is ±z up to rounding."""
    x, y, z = direction.tolist()
    across = math.hypot(x, y)
    if across <= LAST_DIGIT:
        return 0.0, 0.0 if z > 0 else math.pi
    return value_of_numbers(ATAN2, x, -y), value_of_numbers(ATAN2, across, z)


def zxz(cosines: Array) -> tuple[float, float, float]:
    """a, b, c with C = R_z(a) R_x(b) R_z(c); c is computed from a, b and C, so that the product is accurate for small b too."""
    a, b = zx(cosines[:, 2])
    rest = product(product(about(2, a), about(0, b)).T, cosines)
    return a, b, value_of_numbers(ATAN2, *rest[1::-1, 0].tolist())


def pace(a: Array) -> float:
    """The maximum cycle geometric mean of |A| (n × n), 0 if its graph has no cycle (Karp 1978).

    It lies between 1/n of the spectral radius of |A| and that radius: √k of ẍ = −k x, c of ẋ = −c x.
    """
    n = len(a)
    with np.errstate(divide="ignore"):
        gains = np.log(np.abs(a))
    # the largest products of k entries along a path that ends at each x
    chains = [np.zeros(n)]
    for _ in range(n):
        chains.append((gains + chains[-1]).max(axis=1, initial=-np.inf))
    ends = np.isfinite(chains[-1])
    if not ends.any():
        return 0.0
    means = [(chains[-1][ends] - chain[ends]) / (n - k) for k, chain in enumerate(chains[:-1])]
    return float(np.exp(np.min(means, axis=0).max()))


def distinct(x: npt.ArrayLike) -> npt.NDArray[Any]:
    """The sorted distinct values of an array, as np.unique, without its import of numpy.ma."""
    found = np.sort(np.asarray(x), axis=None)
    return found[np.append(True, found[1:] != found[:-1])] if found.size else found


def median(x: npt.ArrayLike) -> float:
    """The median of numbers (n), as np.median, without its import of numpy.ma."""
    return float(medians(np.asarray(x, dtype=float)))


def medians(x: Array, axis: int = 0) -> Array:
    """The medians along an axis, NaN where any number is NaN."""
    found = np.moveaxis(np.sort(x, axis=axis), axis, 0)
    middle = len(found) // 2
    return np.asarray(np.where(np.isnan(found[-1]), found[-1], (found[middle] + found[~middle]) / 2))


def blocks(count: int, size: int = 64) -> Iterator[slice]:
    """Slices of at most `size` among `count` matrices, so that a block and its results stay in the processor's cache."""
    return (slice(k, min(k + size, count)) for k in range(0, count, size))


def common_shape(values: Mapping[Any, npt.ArrayLike]) -> tuple[int, ...]:
    """The shape to which arrays broadcast. SimulationError, with the names, if they do not."""
    shapes = {name: shape for name, x in values.items() if (shape := np.shape(x))}
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError as error:
        told = ", ".join(f"{shape} for {name}" for name, shape in shapes.items())
        raise SimulationError(f"Expected arrays that broadcast to one shape, got {told}.") from error


def spread(values: Sequence[Any], shape: tuple[int, ...]) -> Array:
    """Numbers and arrays, each broadcast to one shape: values × shape."""
    result = np.empty((len(values), *shape))
    for k, x in enumerate(values):
        result[k] = x
    return result

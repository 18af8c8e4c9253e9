# SPDX-License-Identifier: BSD-3-Clause
"""The contact problem at one instant: a = W λ + b with W = J M⁻¹ Jᵀ and b = J M⁻¹ f + J̇ u.

Contact i has the rows d i … d i + d − 1: its normal, then its d − 1 tangents; d = 2 in the plane and 3 in space. λ = (N, F) are the
contact forces, a the accelerations of gap and slip. Impulses p and velocities v satisfy equations of the same form, v⁺ = W p + v⁻.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np

from kane.errors import ArgumentError
from kane.expect import floats, refusal, that
from kane.numeric.arrays import Array, Mask, first_index
from kane.numeric.scale import DECLARED, GIVEN


class ContactStatus(IntEnum):
    """The status of a contact from this instant on.

    OPEN: it separates, N = 0 and a_n ≥ 0. STICK: a = 0 and |F| ≤ μ_s N. FRESH_SLIP: it begins to slip, a_n = 0 and F = −μ N a_t/|a_t|.
    SLIP: it continues to slip along t, a_n = 0 and F = −μ_k N t.
    """

    OPEN = 0
    STICK = 1
    FRESH_SLIP = 2
    SLIP = 3


@dataclass(frozen=True, slots=True, eq=False)
class ContactProblem:
    """The contact problem of k contacts; `contact_problem` makes one from checked arguments.

    Attributes
    ----------
    mobility : W (dk × dk)
    bias : b (dk)
    terms : sums of magnitudes of the terms of b (dk), the scale of its rounding errors
    static, kinetic : coefficients of friction μ_s and μ_k (k)
    slides : whether a contact slips already (k)
    directions : unit vectors t of present slip (k × d − 1), zero for other contacts
    names : names of the contacts in messages; if empty, their numbers are used
    """

    mobility: Array
    bias: Array
    terms: Array
    static: Array
    kinetic: Array
    slides: Mask
    directions: Array
    names: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """The number k of contacts."""
        return len(self.static)

    @property
    def dimension(self) -> int:
        """The number d of rows per contact: 2 in the plane, 3 in space."""
        return int(self.directions.shape[1]) + 1

    def name(self, i: int) -> str:
        """The name of contact i in messages."""
        return self.names[i] if self.names else f"contact {i}"

    def normals(self, values: Array) -> Array:
        """The normal components (k) of values of all rows (dk)."""
        return values[:: self.dimension]

    def tangents(self, values: Array) -> Array:
        """The tangential components (k × d − 1) of values of all rows (dk)."""
        return values.reshape(self.count, self.dimension)[:, 1:]

    def with_friction(self, friction: Array) -> "ContactProblem":
        """The problem with one coefficient per contact (k); contacts that slip already keep μ_k."""
        one = np.where(self.slides, self.kinetic, friction)
        return replace(self, static=one, kinetic=one)


def contact_problem(
    mobility: Any,
    bias: Any,
    friction: Any,
    *,
    kinetic: Any = None,
    sliding: Any = None,
    terms: Any = None,
    names: Sequence[str] = (),
) -> ContactProblem:
    """The contact problem of k contacts, with checked arguments.

    Parameters
    ----------
    mobility : W (dk × dk), symmetric, with positive normal entries
    bias : b (dk)
    friction : μ_s of each contact (k)
    kinetic : μ_k of each contact (k), from 0 to μ_s; μ_s unless given
    sliding : directions of present slip (k × d − 1), of any length; zero for a contact that does not slip
    terms : sums of the magnitudes of the terms of b (dk); |b| unless given
    names : names of the contacts, for messages

    Raises
    ------
    ArgumentError
        if shapes disagree, W is not symmetric or has an invalid diagonal, an entry is not finite, or 0 ≤ μ_k ≤ μ_s does not hold
    """
    static = numbers(friction, "coefficients of friction, one per contact", 1)
    k = len(static)
    b = numbers(bias, "a bias b with the rows of all contacts", 1)
    d = len(b) // max(k, 1)
    that(
        k and d in (2, 3) and len(b) == d * k,
        f"two or three rows per contact, {2 * k} or {3 * k} of {k}",
        came=f"{len(b)} of b",
        cure="Order them by contact: normal, then tangents.",
        error=ArgumentError,
    )
    w = numbers(mobility, f"a mobility W of {d * k} × {d * k} numbers", 2, (d * k, d * k))
    diagonal = np.diag(w)
    size = np.sqrt(np.abs(np.multiply.outer(diagonal, diagonal)))
    for wrong, expected, cure in (
        (np.abs(w - w.T) > GIVEN * size, "a symmetric mobility W", "W = J M⁻¹ Jᵀ is."),
        (diagonal < 0, "a mobility W without negative entries on its diagonal", "W = J M⁻¹ Jᵀ has none."),
        (diagonal[::d] <= 0, "normals along which a force accelerates the bodies, W_nn > 0", "Leave the contact out."),
    ):
        _refuse(wrong, expected, cure)
    sliding_friction = static if kinetic is None else numbers(kinetic, "coefficients μ_k, one per contact", 1, (k,))
    _refuse(static < 0, "coefficients of friction μ_s ≥ 0", "Give 0 for a frictionless contact.")
    _refuse(sliding_friction < 0, "coefficients of friction μ_k ≥ 0", "Give 0 for a frictionless contact.")
    _refuse(sliding_friction > static, "μ_k ≤ μ_s", "Swap them, or give one value for both.")
    t = np.zeros((k, d - 1))
    if sliding is not None:
        t = numbers(sliding, f"directions of slip, {k} × {d - 1} numbers", 2, (k, d - 1))
    length = np.sqrt((t * t).sum(axis=1))
    size = np.abs(b) if terms is None else numbers(terms, "terms of b, one per row", 1, (d * k,))
    _refuse(
        size < np.abs(b) * (1 - DECLARED),
        "terms of b that are no smaller than b",
        "Give the sum of the magnitudes of the terms.",
    )
    slides = length > 0
    directions = t / np.where(slides, length, 1.0)[:, None]
    return ContactProblem((w + w.T) / 2, b, size, static, sliding_friction, slides, directions, tuple(names))


def numbers(given: Any, expected: str, axes: int, shape: tuple[int, ...] | None = None) -> Array:
    """A new array of finite numbers with `axes` dimensions, and the `shape` if given; ArgumentError for anything else."""
    array = floats(given, expected, error=ArgumentError).copy()
    right = array.ndim == axes and (shape is None or array.shape == shape)
    that(right, expected, came=f"an array of the shape {array.shape}", error=ArgumentError)
    _refuse(~np.isfinite(array), f"{expected}, finite", "Look at the state they come from.")
    return array


def _refuse(wrong: Any, expected: str, cure: str) -> None:
    """Raises an ArgumentError with the first index at which `wrong` is true, if any."""
    if np.any(wrong):
        raise refusal(ArgumentError, expected, f"others at {first_index(wrong)}", cure)

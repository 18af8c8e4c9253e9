# SPDX-License-Identifier: BSD-3-Clause
"""All directions φ of incipient slip of one or two contacts in space, as zeros of trigonometric polynomials.

For one contact, F = −μ N d(φ), a_n = 0 and d⊥·a_t = 0 give a polynomial of degree 2 in φ, a quartic in tan(φ/2). For two contacts each
condition has degree 2 in the contact's own angle and 1 in the other; their resultant has degree 10 in the first angle. The zeros are
computed as those of a polynomial in z = exp(iφ) near the unit circle, a form in which no direction lies at infinity.
"""

import numpy as np

from kane.numeric.arrays import Array, Complex
from kane.numeric.scale import ROUNDED

_SAMPLES, _RESULTANT_SAMPLES = 8, 32
"""Numbers of equidistant angles at which polynomials of degree 2 and of degree 10 are sampled."""
_SMOOTH = 0.01
"""μ below which a contact is also treated as frictionless: rounding loses zeros of the resultant at 1e-6, none was lost at 1e-3."""
_NEAR_CIRCLE = 0.02
"""Bound on |ln|z||: rounding moves double zeros off the unit circle by its square root. Newton's method rejects spurious zeros."""


def zeros(coefficients: Complex) -> Array:
    """The candidate zeros φ of Σ c_m exp(imφ), m = −n … n, in ascending order."""
    size = np.abs(coefficients)
    most = size.max()
    if not most > 0:
        return np.zeros(0)
    counts = np.flatnonzero(size > ROUNDED * most)
    z = np.roots(coefficients[counts[0] : counts[-1] + 1][::-1])
    z = z[np.abs(z) > 0]
    return np.sort(np.angle(z[np.abs(np.log(np.abs(z))) < _NEAR_CIRCLE]))


def harmonics(samples: Complex | Array, degree: int) -> Complex:
    """The coefficients c_m (… × 2n + 1), m = −n … n, of a trigonometric polynomial from its values at equidistant angles (… × s)."""
    c = np.fft.fft(samples, axis=-1) / samples.shape[-1]
    return np.concatenate([c[..., -degree:], c[..., : degree + 1]], axis=-1)


def unit(angles: Array) -> Array:
    """Unit vectors (… × 2) at given angles (…)."""
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def across(directions: Array) -> Array:
    """The vectors (… × 2), rotated by a quarter turn."""
    return np.stack([-directions[..., 1], directions[..., 0]], axis=-1)


def one_direction(w: Array, b: Array, mu: float) -> Array:
    """Candidate directions (m × 2) of incipient slip of one contact with W (3 × 3) and b (3): at most four, some spurious."""
    d = unit(_equidistant(_SAMPLES))
    condition = (
        across(d) * (b[1:] * (w[0, 0] - mu * d @ w[0, 1:])[:, None] - b[0] * (w[1:, 0] - mu * d @ w[1:, 1:].T))
    ).sum(-1)
    return unit(zeros(harmonics(condition, 2)))


def two_directions(w: Array, b: Array, mu: Array) -> Array:
    """Candidate pairs of directions (m × 2 × 2) of incipient slip of two contacts with W (6 × 6) and b (6), some spurious."""
    smooth = [_beside_smooth(w, b, float(mu[i]), i)[:, [i, 1 - i]] for i in range(2) if mu[1 - i] < _SMOOTH]
    angles = _equidistant(_RESULTANT_SAMPLES)
    pairs = np.stack(np.meshgrid(angles, _equidistant(_SAMPLES), indexing="ij"), axis=-1)
    first, second = np.moveaxis(_conditions(w, b, mu, pairs), -1, 0)
    scale = np.abs(first).max(), np.abs(second).max()
    if not min(*scale, *mu) > 0:
        return np.concatenate([*smooth, np.zeros((0, 2, 2))])
    quadratic, quartic = harmonics(first / scale[0], 1), harmonics(second / scale[1], 2)
    resultant = harmonics(_resultant(quadratic, quartic), 10)
    found = []
    for angle in zeros(resultant):
        ring = np.stack(np.broadcast_arrays(angle, _equidistant(_SAMPLES)), axis=-1)
        low, middle, high = harmonics(_conditions(w, b, mu, ring)[..., 0], 1)
        z = np.roots([high, middle, low]) if abs(high) > 0 else np.ones(0, complex)
        found += [(angle, other) for other in np.angle(z)]
    return np.concatenate([*smooth, unit(np.array(found).reshape(-1, 2))])


def _beside_smooth(w: Array, b: Array, mu: float, i: int) -> Array:
    """Directions of contact i and of the other (m × 2 × 2), without friction at the other: an approximation if its μ is small."""
    rows, n, t = slice(3 * i, 3 * i + 3), 3 - 3 * i, slice(4 - 3 * i, 6 - 3 * i)
    if w[n, n] <= ROUNDED * np.diag(w).max():
        return np.zeros((0, 2, 2))
    w, b = w - np.multiply.outer(w[:, n], w[n]) / w[n, n], b - w[:, n] * (b[n] / w[n, n])
    d = one_direction(w[rows, rows], b[rows], mu)
    rates = np.hstack([np.ones((len(d), 1)), -mu * d]) @ w[:, rows].T
    a = b[t] * rates[:, 3 * i, None] - b[3 * i] * rates[:, t]  # multiplied by the divisor of N_i, which may be negative
    slip = np.arctan2(a[:, 1], a[:, 0]) + np.where(rates[:, 3 * i] < 0, np.pi, 0.0)
    return np.stack([d, unit(slip)], axis=1)


def _equidistant(count: int) -> Array:
    return 2 * np.pi * np.arange(count) / count


def _conditions(w: Array, b: Array, mu: Array, angles: Array) -> Array:
    """d⊥·a_t of both contacts (… × 2) at angles (… × 2), multiplied by the determinant of the equations for the normal forces."""
    d = unit(angles)
    columns = np.zeros((*angles.shape, 6))
    for i in range(2):
        columns[..., i, 3 * i] = 1.0
        columns[..., i, 3 * i + 1 : 3 * i + 3] = -mu[i] * d[..., i, :]
    rates = columns @ w.T
    a = rates[..., ::3]  # a[..., i, j]: a_n of contact j for N_i = 1
    det = a[..., 0, 0] * a[..., 1, 1] - a[..., 0, 1] * a[..., 1, 0]
    normal = np.stack([b[3] * a[..., 1, 0] - b[0] * a[..., 1, 1], b[0] * a[..., 0, 1] - b[3] * a[..., 0, 0]], axis=-1)
    accelerations = det[..., None] * b + (normal[..., None] * rates).sum(-2)
    tangential = accelerations.reshape(*angles.shape, 3)[..., 1:]
    return np.asarray((across(d) * tangential).sum(-1))


def _resultant(quadratic: Complex, quartic: Complex) -> Complex:
    """The resultant (…), by Sylvester's determinant, of polynomials of degree 2 and 4 with coefficients (… × 3) and (… × 5)."""
    rows = np.zeros((*quadratic.shape[:-1], 6, 6), complex)
    for i in range(4):
        rows[..., i, i : i + 3] = quadratic
    for i in range(2):
        rows[..., 4 + i, i : i + 5] = quartic
    return np.asarray(np.linalg.det(rows))

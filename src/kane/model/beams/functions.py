# SPDX-License-Identifier: BSD-3-Clause
"""Functions of ξ = x/L that a deformation is a sum of: eigenfunctions of uniform beams and rods, and polynomials.

A row of `FAMILIES` gives the functions of one family as a function of ξ (m) and the order of the derivative, (m × n).
Eigenfunctions of bending have ∫ φ² dξ = 1; their eigenvalues β solve the transcendental equations of Blevins (1979), table 8-1.
What grows as cosh β is written by exponentials that do not.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import Legendre

from kane.numeric.arrays import Array, product
from kane.numeric.legendre import gauss
from kane.program.emit.sincos import sine_cosine

Evaluate = Callable[[Array, int], Array]

_LN2 = float.fromhex("0x1.62e42fefa39efp-1")
_LN2_HIGH, _LN2_LOW = float.fromhex("0x1.62e42feep-1"), float.fromhex("0x1.a39ef35793c76p-33")
"""ln 2 in two parts, of which multiples of the first are exact."""
_TERMS = 14
_QUARTERS = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""cos and sin of so many quarter turns."""


class Family(NamedTuple):
    """How functions of a family are made, what is zero at the root and at the tip of each: value (0), slope (1), both or none."""

    make: Callable[[int], Evaluate]
    root: tuple[int, ...] = ()
    tip: tuple[int, ...] = ()


def _roots(sign: int, guesses: Any) -> Array:
    """Solutions of cos β = `sign`/cosh β beside guesses, by Newton's method."""
    beta: Array = np.array(guesses, dtype=float)
    for _ in range(12):  # it doubles the digits each time; the guesses have one
        (sine, cosine), (sinh, cosh) = sine_cosine(beta), _hyperbolic(beta)
        beta = beta + (cosine - sign / cosh) / (sine - sign * sinh / (cosh * cosh))
    return beta


def _exp(x: Array) -> Array:
    """e^x = 2^k e^r with |r| ≤ ln 2/2, by its series: the same bits on every machine, which NumPy's own are not."""
    k = np.rint(x / _LN2)
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    series = np.ones_like(r)
    for n in range(_TERMS, 0, -1):
        series = 1 + r * series / n
    return np.asarray(np.ldexp(series, k.astype(int)))


def _hyperbolic(x: Array) -> tuple[Array, Array]:
    """sinh x and cosh x where neither is small."""
    rising, falling = _exp(x) / 2, _exp(-x) / 2
    return rising - falling, rising + falling


def _clamped_free(n: int) -> Evaluate:
    """cos β cosh β = −1: cosh βξ − cos βξ − σ (sinh βξ − sin βξ), σ = (sinh β − sin β)/(cosh β + cos β)."""
    beta = _roots(-1, (np.arange(n) + 0.5) * np.pi)
    (sine, cosine), (_, cosh) = sine_cosine(beta), _hyperbolic(beta)
    return _of_exponentials(beta, sine + cosine + _exp(-beta), 1 / (cosh + cosine), -1)


def _free_free(n: int) -> Evaluate:
    """cos β cosh β = 1: cosh βξ + cos βξ − σ (sinh βξ + sin βξ), σ = (cosh β − cos β)/(sinh β − sin β)."""
    beta = _roots(1, (np.arange(n) + 1.5) * np.pi)
    (sine, cosine), (sinh, _) = sine_cosine(beta), _hyperbolic(beta)
    return _of_exponentials(beta, cosine - sine - _exp(-beta), 1 / (sinh - sine), 1)


def _of_exponentials(beta: Array, rest: Array, scale: Array, sign: int) -> Evaluate:
    """½ (1 + σ) e^(−βξ) + ½ (1 − σ) e^(βξ) + sign (cos βξ − σ sin βξ), where 1 − σ = `rest` · `scale`, small."""
    less = rest * scale
    sigma = 1 - less

    def evaluate(x: Array, order: int) -> Array:
        z = np.multiply.outer(x, beta)
        # e^(βξ) (1 − σ)/2 = e^(β(ξ−1)) · [rest · e^β · scale]/2, which stays of order 1
        rising = _exp(z - beta) * (rest * _exp(beta) * scale) / 2
        falling = _exp(-z) * (1 + sigma) / 2 * (-1) ** order
        sine, cosine = _quarters_further(z, order)
        waves = cosine - sigma * sine
        whole: Array = (rising + falling + sign * waves) * _power(beta, order)
        return whole

    return evaluate


def _quarters_further(z: Array, order: int) -> tuple[Array, Array]:
    """sin and cos of z + order π/2: derivatives of sin z and, but for a quarter, of cos z."""
    sine, cosine = sine_cosine(z)
    c, s = _QUARTERS[order % 4]
    return c * sine + s * cosine, c * cosine - s * sine


def _power(beta: Array, order: int) -> Array:
    """β^order by products."""
    power = np.ones_like(beta)
    for _ in range(order):
        power = power * beta
    return power


def _pinned(n: int) -> Evaluate:
    """√2 sin nπξ."""
    return _sines(np.arange(1, n + 1) * np.pi)


def _rod(n: int) -> Evaluate:
    """√2 sin (n − ½)πξ: a rod, or a shaft, fixed at the root and free at the tip."""
    return _sines((np.arange(n) + 0.5) * np.pi)


def _sines(waves: Any) -> Evaluate:
    beta = np.asarray(waves, dtype=float)

    def evaluate(x: Array, order: int) -> Array:
        values: Array = np.sqrt(2) * _quarters_further(np.multiply.outer(x, beta), order)[0] * _power(beta, order)
        return values

    return evaluate


def _polynomials(power: int) -> Callable[[int], Evaluate]:
    """ξ^power P_k(2ξ − 1), with Legendre's P_k, k = 0, 1, …: derivatives by Leibniz's rule."""

    def make(n: int) -> Evaluate:
        series = [Legendre.basis(k, domain=(0, 1)) for k in range(n)]

        def evaluate(x: Array, order: int) -> Array:
            total = np.zeros((*np.shape(x), n))
            factor = Polynomial([0] * power + [1])
            for k in range(order + 1):
                weight = float([1, order, order * (order - 1) // 2][k]) if k < 3 else 0.0
                own = factor.deriv(k)(x) if k else factor(x)
                rest = np.array([(p.deriv(order - k) if order > k else p)(x) for p in series])
                total = total + weight * (own * rest).T
            return total

        return evaluate

    return make


def _orthonormal(power: int) -> Callable[[int], Evaluate]:
    """The same span by functions with ∫ φ_i φ_j dξ = δ_ij, of rising degree: ξ^power times Jacobi polynomials."""

    def make(n: int) -> Evaluate:
        raw = _polynomials(power)(n)
        rule = gauss(n + power + 1)
        values, turned = raw(rule.places, 0), np.eye(n)
        for k in range(n):  # Gram and Schmidt's method, twice: once leaves what rounding makes of it
            for _ in range(2):
                v = product(values, turned[:, : k + 1])
                parts = (rule.weights[:, None] * v[:, :k] * v[:, k:]).sum(axis=0)
                turned[:, k] -= product(turned[:, :k], parts[:, None])[:, 0]
            length = (rule.weights * product(values, turned[:, k : k + 1])[:, 0] ** 2).sum()
            turned[:, k] /= np.sqrt(length)

        def evaluate(x: Array, order: int) -> Array:
            return product(raw(x, order), turned)

        return evaluate

    return make


FAMILIES: dict[str, Family] = {
    "clamped-free": Family(_clamped_free, root=(0, 1)),
    "pinned": Family(_pinned, root=(0,), tip=(0,)),
    "free-free": Family(_free_free),
    "rod": Family(_rod, root=(0,)),
    "polynomials": Family(_orthonormal(2), root=(0, 1)),
    "rod polynomials": Family(_orthonormal(1), root=(0,)),
    "legendre": Family(_polynomials(2), root=(0, 1)),
    "legendre rod": Family(_polynomials(1), root=(0,)),
}
"""Families by name."""

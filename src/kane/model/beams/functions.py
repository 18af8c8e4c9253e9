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

from kane.numeric.arrays import Array

Evaluate = Callable[[Array, int], Array]


class Family(NamedTuple):
    """How functions of a family are made, what is zero at the root and at the tip of each: value (0), slope (1), both or none."""

    make: Callable[[int], Evaluate]
    root: tuple[int, ...] = ()
    tip: tuple[int, ...] = ()


def _roots(sign: int, guesses: Any) -> Array:
    """Solutions of cos β = `sign`/cosh β beside guesses, by Newton's method."""
    beta: Array = np.array(guesses, dtype=float)
    for _ in range(12):  # it doubles the digits each time; the guesses have one
        beta = beta + (np.cos(beta) - sign / np.cosh(beta)) / (np.sin(beta) - sign * np.sinh(beta) / np.cosh(beta) ** 2)
    return beta


def _clamped_free(n: int) -> Evaluate:
    """cos β cosh β = −1: cosh βξ − cos βξ − σ (sinh βξ − sin βξ), σ = (sinh β − sin β)/(cosh β + cos β)."""
    beta = _roots(-1, (np.arange(n) + 0.5) * np.pi)
    return _of_exponentials(beta, np.sin(beta) + np.cos(beta) + np.exp(-beta), 1 / (np.cosh(beta) + np.cos(beta)), -1)


def _free_free(n: int) -> Evaluate:
    """cos β cosh β = 1: cosh βξ + cos βξ − σ (sinh βξ + sin βξ), σ = (cosh β − cos β)/(sinh β − sin β)."""
    beta = _roots(1, (np.arange(n) + 1.5) * np.pi)
    return _of_exponentials(beta, np.cos(beta) - np.sin(beta) - np.exp(-beta), 1 / (np.sinh(beta) - np.sin(beta)), 1)


def _of_exponentials(beta: Array, rest: Array, scale: Array, sign: int) -> Evaluate:
    """½ (1 + σ) e^(−βξ) + ½ (1 − σ) e^(βξ) + sign (cos βξ − σ sin βξ), where 1 − σ = `rest` · `scale`, small."""
    less = rest * scale
    sigma = 1 - less

    def evaluate(x: Array, order: int) -> Array:
        z = np.multiply.outer(x, beta)
        # e^(βξ) (1 − σ)/2 = e^(β(ξ−1)) · [rest · e^β · scale]/2, which stays of order 1
        rising = np.exp(z - beta) * (rest * np.exp(beta) * scale) / 2
        falling = np.exp(-z) * (1 + sigma) / 2 * (-1) ** order
        turn = order * np.pi / 2
        waves = np.cos(z + turn) - sigma * np.sin(z + turn)
        whole: Array = (rising + falling + sign * waves) * beta**order
        return whole

    return evaluate


def _pinned(n: int) -> Evaluate:
    """√2 sin nπξ."""
    return _sines(np.arange(1, n + 1) * np.pi)


def _rod(n: int) -> Evaluate:
    """√2 sin (n − ½)πξ: a rod, or a shaft, fixed at the root and free at the tip."""
    return _sines((np.arange(n) + 0.5) * np.pi)


def _sines(waves: Any) -> Evaluate:
    beta = np.asarray(waves, dtype=float)

    def evaluate(x: Array, order: int) -> Array:
        values: Array = np.sqrt(2) * np.sin(np.multiply.outer(x, beta) + order * np.pi / 2) * beta**order
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
        z, w = np.polynomial.legendre.leggauss(n + power + 1)
        _, upper = np.linalg.qr(np.sqrt(w / 2)[:, None] * raw((z + 1) / 2, 0))
        turned = np.linalg.inv(upper * np.sign(np.diag(upper))[:, None])

        def evaluate(x: Array, order: int) -> Array:
            whole: Array = raw(x, order) @ turned
            return whole

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

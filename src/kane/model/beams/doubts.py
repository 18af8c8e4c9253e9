# SPDX-License-Identifier: BSD-3-Clause
"""What is doubtful of a beam that spins: that its stiffening is left out, or that its functions are too few.

By its own functions and with the root held, a beam that spins at Ω across its axis has, out of the plane of rotation, the frequencies
(k EI/L³ + Ω² ρA L S) x = ω² ρA L m x, S = ∫ m₁ φ'_i φ'_j dξ; by more functions they are lower, and the difference is what these lack.
"""

from collections.abc import Iterator, Mapping
from functools import cache, lru_cache

import numpy as np

from kane.errors import KaneWarning, ModesWarning, StiffeningWarning
from kane.expr.evaluation import evaluate
from kane.expr.node import Expr
from kane.model.beams.beam import Beam
from kane.model.beams.deformation import Field
from kane.model.beams.elastic import strain
from kane.model.beams.integrals import Share, fine, moments_beyond
from kane.model.beams.shapes import ModeShapes, mode_shapes
from kane.numeric.arrays import Array

_ENOUGH = 10
"""Functions that have the first frequency of any beam that spins at a few times it."""
_OFF = 0.02
"""Share of the first frequency by which it may be wrong at the spin before a word is said."""


def first_frequency(
    beam: Beam, field: Field, values: Mapping[Expr, float], spin: float = 0.0, richer: ModeShapes | None = None
) -> float:
    """The first frequency (rad/s) of a deflection with the root held, out of the plane in which the beam spins."""
    f = field if richer is None else field._replace(shapes=richer)
    mass, length, stiff = (
        float(evaluate(x, values)) for x in (beam.mass_per_length.value, beam.length, f.stiffness.value)
    )
    inert, elastic, drawn = _integrals(f.shapes, beam.mass_per_length.share, f.stiffness.share)
    k = stiff / length**3 * elastic + spin**2 * mass * length * drawn
    return float(np.sqrt(np.maximum(_eigenvalues(k, mass * length * inert)[0], 0.0)))


@lru_cache(maxsize=64)
def _integrals(shapes: ModeShapes, mass: Share, stiff: Share) -> tuple[Array, Array, Array]:
    """m, k and S without units: the same for every motion of a beam."""
    rule = fine([shapes])
    values, slopes = (shapes.evaluate(rule.places, k) for k in (0, 1))
    _, beyond = moments_beyond(mass, rule.places)
    found = (
        rule.gram(values, values, mass(rule.places)),
        strain(shapes, stiff, 2),
        rule.gram(slopes, slopes, beyond),
    )
    for a in found:
        a.flags.writeable = False
    return found


@cache
def _polynomials(count: int) -> ModeShapes:
    return mode_shapes("polynomials", count)


def _eigenvalues(k: Array, m: Array) -> Array:
    size = np.sqrt(np.diag(m))
    inverse = np.linalg.inv(np.linalg.cholesky(m / np.multiply.outer(size, size)))
    return np.asarray(np.linalg.eigvalsh(inverse @ (k / np.multiply.outer(size, size)) @ inverse.T), dtype=float)


def across(beam: Beam) -> Expr | None:
    """The square of the angular speed of a beam's frame across its axis; None of one that does not turn."""
    root = beam.frame.root()
    if root is beam.frame:
        return None
    w = beam.frame.angular_velocity(root)
    square: Expr = w.dot(w) - w.dot(beam.deformation.axis) ** 2
    return square


def doubts(beam: Beam, spin: float, values: Mapping[Expr, float]) -> Iterator[tuple[str, type[KaneWarning]]]:
    """What is to be said of a beam that spins at `spin` (rad/s) across its axis, with the parameters' values."""
    if not beam.clamped or not beam.deformation.bending or not np.isfinite(spin) or spin == 0:
        return
    first = min(first_frequency(beam, f, values) for f in beam.deformation.bending)
    if not beam.deformation.stiffening:
        if spin > first:
            yield (
                (
                    f"Expected the stiffening of {beam.name}, which spins at up to {spin:.4g} rad/s, beyond its first frequency at "
                    f"rest, {first:.4g} rad/s, got stiffening=False: linearized so early, it diverges whatever the beam does. Leave "
                    "stiffening= out."
                ),
                StiffeningWarning,
            )
        return
    if spin < first:  # shapes change little then
        return
    for f in beam.deformation.bending:
        own = first_frequency(beam, f, values, spin)
        better = first_frequency(beam, f, values, spin, _polynomials(max(_ENOUGH, 2 * f.shapes.count)))
        if own > better * (1 + _OFF):
            yield (
                (
                    f"Expected enough modes of {beam.name} for its spin, up to {spin:.4g} rad/s, got {f.shapes!r}, by which its first "
                    f"frequency there is {own:.5g} rad/s in the place of {better:.5g}. Take more of them."
                ),
                ModesWarning,
            )

# SPDX-License-Identifier: BSD-3-Clause
"""What is doubtful of a beam that spins: that its stiffening is left out, or that its functions are too few.

By its own functions and with the root held, a beam that spins at Ω across its axis has, out of the plane of rotation, the frequencies
(k EI/L³ + Ω² ρA L S) x = ω² ρA L m x, S = ∫ m₁ φ'_i φ'_j dξ; by more functions they are lower, and the difference is what these lack.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from kane.errors import KaneWarning, ModesWarning, StiffeningWarning
from kane.expr.evaluate import evaluate
from kane.expr.node import Expr
from kane.model.beams.beam import Beam
from kane.model.beams.deformation import Field
from kane.model.beams.elastic import stiffness
from kane.model.beams.integrals import fine, moments_beyond
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
    rule = fine([f.shapes])
    share = beam.mass_per_length.share
    shapes, slopes = (f.shapes.evaluate(rule.places, k) for k in (0, 1))
    m = mass * length * rule.gram(shapes, shapes, share(rule.places))
    _, beyond = moments_beyond(share, rule.places)
    k = stiff / length**3 * stiffness(f) + spin**2 * mass * length * rule.gram(slopes, slopes, beyond)
    return float(np.sqrt(np.maximum(_eigenvalues(k, m)[0], 0.0)))


def _eigenvalues(k: Array, m: Array) -> Array:
    size = np.sqrt(np.diag(m))
    inverse = np.linalg.inv(np.linalg.cholesky(m / np.multiply.outer(size, size)))
    return np.asarray(np.linalg.eigvalsh(inverse @ (k / np.multiply.outer(size, size)) @ inverse.T), dtype=float)


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
        better = first_frequency(beam, f, values, spin, mode_shapes("polynomials", max(_ENOUGH, 2 * f.shapes.count)))
        if own > better * (1 + _OFF):
            yield (
                (
                    f"Expected enough modes of {beam.name} for its spin, up to {spin:.4g} rad/s, got {f.shapes!r}, by which its first "
                    f"frequency there is {own:.5g} rad/s in the place of {better:.5g}. Take more of them."
                ),
                ModesWarning,
            )

# SPDX-License-Identifier: BSD-3-Clause
"""Whether friction is too small for two answers: a bound that costs less than one mode.

Of two answers with one coefficient a contact let Δ be the difference. a + μ |a_t| n lies in the cone dual to that of λ and is
perpendicular to λ (de Saxcé & Feng 1998, Math. Comput. Modelling 28, 225), so Δλ·Δa ≤ Σ μ |ΔN| |Δa_t|; of contacts that slip
already, along t, N ⟂ a_n gives the same with t·Δa_t. As Δa = W Δλ, accelerations are equal where Σ μ |N| |(W λ)_t| < λ·W λ for
all λ with W λ ≠ 0. In y = W^½ λ both factors are linear if no λ with W λ = 0 presses, and 2 |N| |(W λ)_t| ≤ s N² + |(W λ)_t|²/s.
"""

from __future__ import annotations

import numpy as np

from kane.contacts.problem import ContactProblem
from kane.numeric.scale import INVERSE_RANK, ROUNDED, SIX_DIGITS


def unique(problem: ContactProblem) -> bool:
    """Whether answers with one coefficient a contact surely have equal accelerations; False where it is not known."""
    d, rubs = problem.dimension, np.flatnonzero(problem.kinetic)
    values, vectors = np.linalg.eigh(problem.mobility)
    kept = values > INVERSE_RANK * values[-1]
    root, basis = np.sqrt(values[kept]), vectors[:, kept].reshape(problem.count, d, -1)[rubs]
    if (1 - (basis[:, 0] ** 2).sum(axis=1) > ROUNDED).any():
        return False
    along = np.where(problem.slides[:, None, None], problem.directions[:, None] * np.eye(d - 1)[:, :1], np.eye(d - 1))
    pressing, moving = basis[:, :1] / root, along[rubs] @ (basis[:, 1:] * root)  # N = pressing·y, a_t = moving y
    s = np.sqrt((moving**2).sum(axis=2).max(axis=1) / (pressing**2).sum(axis=(1, 2)))
    s, half = np.maximum(s, np.finfo(float).tiny)[:, None, None], problem.kinetic[rubs, None, None] / 2
    rows = np.hstack([pressing * np.sqrt(half * s), moving * np.sqrt(half / s)]).reshape(-1, len(root))
    return bool(np.linalg.eigvalsh(rows.T @ rows).max(initial=0) < 1 - SIX_DIGITS)

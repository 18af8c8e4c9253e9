# SPDX-License-Identifier: BSD-3-Clause
"""The least change by its own optimality conditions."""

from __future__ import annotations

import numpy as np


def kkt(m, a, right):
    """δ of least δᵀM δ with A δ = right."""
    n, k = len(m), len(a)
    return np.linalg.solve(np.block([[m, a.T], [a, np.zeros((k, k))]]), np.append(np.zeros(n), right))[:n]

# SPDX-License-Identifier: BSD-3-Clause
"""How fast what is left to itself changes, read off ẋ = A x: the same in any units of x."""

import numpy as np

from kane.numeric.arrays import Array


def pace(a: Array) -> float:
    """The largest geometric mean of |A_ij| over a cycle of dependence (n × n), 0 where nothing depends on itself (Karp 1978).

    It lies between a share 1/n of the spectral radius of |A| and that radius: √k of ẍ = −k x, c of ẋ = −c x.
    """
    n = len(a)
    with np.errstate(divide="ignore"):
        gains = np.log(np.abs(a))
    # the largest gains of chains of k links that end at each x
    chains = [np.zeros(n)]
    for _ in range(n):
        chains.append((gains + chains[-1]).max(axis=1, initial=-np.inf))
    ends = np.isfinite(chains[-1])
    if not ends.any():
        return 0.0
    means = [(chains[-1][ends] - chain[ends]) / (n - k) for k, chain in enumerate(chains[:-1])]
    return float(np.exp(np.min(means, axis=0).max()))

# SPDX-License-Identifier: BSD-3-Clause
"""Common parts of the native functions of JAX and PyTorch."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from kane.program.program import Port

Evaluate: TypeAlias = Callable[[Sequence[Any]], Any]
"""A function of one array per port, a scalar or values on the last axis after broadcast axes, that returns the results."""
SLOPES: Mapping[str, Mapping[str, str]] = {
    "rhs": {"t": "jac_time", "x": "jac", "p": "jac_parameters", "r": "jac_inputs"}
}
"""The routines that compute the derivatives of a routine, by port."""


def of_arrays(ports: Sequence[Port], function: Callable[..., Any]) -> Evaluate:
    """A function of arrays with any numbers of axes, from one of vectors with equal numbers of axes."""

    def evaluate(arrays: Sequence[Any]) -> Any:
        vectors = [a[..., None] if port.scalar else a for port, a in zip(ports, arrays, strict=True)]
        rank = max(a.ndim for a in vectors)
        return function(*(a.reshape((1,) * (rank - a.ndim) + tuple(a.shape)) for a in vectors))

    return evaluate


def of_vectors(ports: Sequence[Port], evaluate: Evaluate) -> Callable[..., Any]:
    """A function of vectors, from one of arrays."""

    def function(*vectors: Any) -> Any:
        return evaluate([a[..., 0] if port.scalar else a for port, a in zip(ports, vectors, strict=True)])

    return function

# SPDX-License-Identifier: BSD-3-Clause
"""What routines in machine code have in common, whatever tool of differentiation calls them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from kane.program.program import Port

Evaluate: TypeAlias = Callable[[Sequence[Any]], Any]
"""The results at an array for each port: a number or values on the last axis, behind axes that broadcast."""
SLOPES: Mapping[str, Mapping[str, str]] = {
    "rhs": {"t": "jac_time", "x": "jac", "p": "jac_parameters", "r": "jac_inputs"}
}
"""Of routines with compiled derivatives, these by port."""


def of_arrays(ports: Sequence[Port], function: Callable[..., Any]) -> Evaluate:
    """The same of arrays, from a function of vectors with as many axes each."""

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

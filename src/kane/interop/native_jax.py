# SPDX-License-Identifier: BSD-3-Clause
"""Machine code as functions of JAX: XLA calls it for one state or many, and derivatives are compiled routines too.

∂ẋ/∂(t, x, p, r) are compiled like ẋ; JAX multiplies by them, so that forward and reverse mode both work. Other routines, including
these derivatives, are differentiated operation by operation, by JAX's rules.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

from kane.interop.native_routines import SLOPES, Evaluate, of_vectors
from kane.program.native.entry import Entry, xla_function
from kane.program.native.machine import Settings
from kane.program.program import Program

_called: dict[str, Entry] = {}
"""The functions that XLA may call in this process, by name, kept alive."""


def native(
    jax: Any, name: str, program_of: Callable[[str], Program], traced_of: Callable[[str], Evaluate]
) -> Callable[..., Any]:
    """A routine in machine code, on vectors with equal numbers of axes; `traced_of` gives routines as operations of JAX."""
    jnp, program = jax.numpy, program_of(name)
    (routine,), ports = program.routines, program.ports
    target, slopes = _target(jax, program), SLOPES.get(name, {})

    def run(*vectors: Any) -> Any:
        leading = jnp.broadcast_shapes(*(a.shape[:-1] for a in vectors))
        result = jax.ShapeDtypeStruct((*leading, *routine.shape), jnp.float64)
        return jax.ffi.ffi_call(target, result, vmap_method="expand_dims")(*vectors)

    function: Callable[..., Any] = jax.custom_jvp(run)

    @cache
    def slope(k: int) -> Callable[..., Any]:
        return native(jax, slopes[ports[k].name], program_of, traced_of)

    def push(given: tuple[Any, ...], changes: tuple[Any, ...]) -> tuple[Any, Any]:
        if not slopes:
            plain: tuple[Any, Any] = jax.jvp(
                of_vectors(ports, traced_of(name)), given, tuple(_instance(jax, d) for d in changes)
            )
            return plain
        found = function(*given)
        moved = [k for k, d in enumerate(changes) if d.size and not isinstance(d, jax.custom_derivatives.SymbolicZero)]
        parts = [(slope(k)(*given) @ changes[k][..., None])[..., 0] for k in moved]
        return found, sum(parts, jnp.zeros_like(found))

    function.defjvp(push, symbolic_zeros=True)  # type: ignore[attr-defined]  # a custom_jvp
    return function


def _instance(jax: Any, change: Any) -> Any:
    zero = isinstance(change, jax.custom_derivatives.SymbolicZero)
    return jax.numpy.zeros(change.shape, change.dtype) if zero else change


def _target(jax: Any, program: Program) -> str:
    """The name under which XLA calls the program's routine; registers it on first use."""
    name, entry = xla_function(program, Settings())
    if name not in _called:
        jax.ffi.register_ffi_target(name, jax.ffi.pycapsule(entry.address), platform="cpu")
        _called[name] = entry
    return name

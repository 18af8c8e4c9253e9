# SPDX-License-Identifier: BSD-3-Clause
"""Machine code as functions of JAX and PyTorch: for one state or many, with derivatives that are compiled routines too.

∂ẋ/∂(t, x, p, r) are compiled like ẋ; the tool multiplies by them, so that forward and reverse mode both work. Other routines, and
these derivatives, are differentiated operation by operation, by the tool's rules.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, TypeAlias

from kane.errors import ArgumentError
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import Entry, xla_function
from kane.program.native.machine import Settings
from kane.program.program import Port, Program

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


_called: dict[str, Entry] = {}
"""The functions that XLA may call in this process, by name, kept alive."""


def native_of_jax(
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
        return native_of_jax(jax, slopes[ports[k].name], program_of, traced_of)

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


def native_of_torch(
    torch: Any, name: str, program_of: Callable[[str], Program], traced_of: Callable[[str], Evaluate]
) -> Callable[..., Any]:
    """A routine in machine code, on vectors with equal numbers of axes; `traced_of` gives routines as operations of PyTorch."""
    program = program_of(name)
    ports, slopes, run = program.ports, SLOPES.get(name, {}), _cpu_call(torch, program)
    traced = of_vectors(ports, traced_of(name))

    @cache
    def slope(k: int) -> Callable[..., Any]:
        return native_of_torch(torch, slopes[ports[k].name], program_of, traced_of)

    class Native(torch.autograd.Function):  # type: ignore[misc]  # torch is imported lazily
        """The call, and its rules for autograd and vmap."""

        @staticmethod
        def forward(*vectors: Any) -> Any:
            return run(*vectors)

        @staticmethod
        def setup_context(context: Any, inputs: tuple[Any, ...], output: Any) -> None:
            context.save_for_backward(*inputs)
            context.save_for_forward(*inputs)

        @staticmethod
        def backward(context: Any, gradient: Any) -> tuple[Any, ...]:
            given, wanted = context.saved_tensors, context.needs_input_grad
            if not slopes:
                result: tuple[Any, ...] = torch.func.vjp(traced, *given)[1](gradient)
                return result
            return tuple(
                _summed((gradient[..., None, :] @ slope(k)(*given))[..., 0, :], vector) if asked else None
                for k, (vector, asked) in enumerate(zip(given, wanted, strict=True))
            )

        @staticmethod
        def jvp(context: Any, *changes: Any) -> Any:
            given = context.saved_tensors
            if not slopes:
                return _pushed_torch(torch, traced, given, changes)
            return sum((slope(k)(*given) @ d[..., None])[..., 0] for k, d in enumerate(changes) if d is not None)

        @staticmethod
        def vmap(info: Any, axes: tuple[int | None, ...], *vectors: Any) -> tuple[Any, int]:
            moved = (v[None] if axis is None else v.movedim(axis, 0) for v, axis in zip(vectors, axes, strict=True))
            return Native.apply(*moved), 0

    function: Callable[..., Any] = Native.apply
    return function


def _cpu_call(torch: Any, program: Program) -> Callable[..., Any]:
    """The call of machine code on CPU tensors."""
    (routine,), ports = program.routines, program.ports
    compiled = CompiledRoutine(program, routine.name, Settings(), not_finite="ignore")

    def run(*vectors: Any) -> Any:
        away = next((v.device for v in vectors if v.device.type != "cpu"), None)
        if away is not None:
            raise ArgumentError(
                f"Expected CPU tensors for machine code, got one on {away}. Leave native=True out for that device."
            )
        arrays = [v.detach().numpy() for v in vectors]
        values = [a[..., 0][()] if port.scalar else a for port, a in zip(ports, arrays, strict=True)]
        return torch.from_numpy(compiled(*values))

    return run


def _pushed_torch(torch: Any, function: Callable[..., Any], given: Sequence[Any], changes: Sequence[Any]) -> Any:
    """The derivative along `changes`, which may contain None, as that of the product with ∂f with respect to its other factor.

    PyTorch does not nest forward mode.
    """
    moved = [k for k, d in enumerate(changes) if d is not None]
    found, pull = torch.func.vjp(function, *given)

    def pulled(weight: Any) -> list[Any]:
        slopes = pull(weight)
        return [slopes[k] for k in moved]

    return torch.func.vjp(pulled, torch.zeros_like(found))[1]([changes[k] for k in moved])[0]


def _summed(gradient: Any, vector: Any) -> Any:
    """A gradient summed over the axes along which the vector was broadcast."""
    shared = [k for k, (n, own) in enumerate(zip(gradient.shape, vector.shape, strict=True)) if n != own]
    return gradient.sum(shared, keepdim=True) if shared else gradient

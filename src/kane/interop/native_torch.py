# SPDX-License-Identifier: BSD-3-Clause
"""Machine code as functions of PyTorch: for one state or many, with derivatives that are compiled routines too.

∂ẋ/∂(t, x, p, r) are compiled like ẋ; PyTorch multiplies by them, so that forward and reverse mode both work. Other routines, including
these derivatives, are differentiated operation by operation, by PyTorch's rules.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from kane.errors import ArgumentError
from kane.interop.native_routines import SLOPES, Evaluate, of_vectors
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.machine import Settings
from kane.program.program import Program


def native(
    torch: Any, name: str, program_of: Callable[[str], Program], traced_of: Callable[[str], Evaluate]
) -> Callable[..., Any]:
    """A routine in machine code, on vectors with equal numbers of axes; `traced_of` gives routines as operations of PyTorch."""
    program = program_of(name)
    ports, slopes, run = program.ports, SLOPES.get(name, {}), _run(torch, program)
    traced = of_vectors(ports, traced_of(name))

    @cache
    def slope(k: int) -> Callable[..., Any]:
        return native(torch, slopes[ports[k].name], program_of, traced_of)

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
                return _pushed(torch, traced, given, changes)
            return sum((slope(k)(*given) @ d[..., None])[..., 0] for k, d in enumerate(changes) if d is not None)

        @staticmethod
        def vmap(info: Any, axes: tuple[int | None, ...], *vectors: Any) -> tuple[Any, int]:
            moved = (v[None] if axis is None else v.movedim(axis, 0) for v, axis in zip(vectors, axes, strict=True))
            return Native.apply(*moved), 0

    function: Callable[..., Any] = Native.apply
    return function


def _run(torch: Any, program: Program) -> Callable[..., Any]:
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


def _pushed(torch: Any, function: Callable[..., Any], given: Sequence[Any], changes: Sequence[Any]) -> Any:
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

# SPDX-License-Identifier: BSD-3-Clause
"""Equations of motion as functions of JAX, PyTorch and CasADi, built operation by operation.

Each tool is imported on first use.
"""

import importlib
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import Any, TypeAlias

import numpy as np

from kane import expect
from kane.dynamics.solved import Solved
from kane.equations.compiled import ON_DEMAND, ROUTINES
from kane.equations.compiled import program as program_of
from kane.errors import ArgumentError
from kane.expr.ops import GONE
from kane.numeric.arrays import Array
from kane.numeric.sampling import named_values
from kane.program.native.compiled_routine import CompiledRoutine, check_complete, port_defaults, replaced_values
from kane.program.native.entry import Entry, xla_function
from kane.program.native.machine import Settings
from kane.program.program import Port, Program, Routine

_SAME = ["sqrt", "sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sign", "floor"]

Evaluate: TypeAlias = Callable[[Sequence[Any]], Any]
"""A function of one array per port, a scalar or values on the last axis after broadcast axes, that returns the results."""
SLOPES: Mapping[str, Mapping[str, str]] = {
    "rhs": {"t": "jac_time", "x": "jac", "p": "jac_parameters", "r": "jac_inputs"}
}
"""The routines that compute the derivatives of a routine, by port."""


def to_jax(eom: Any, routine: str = "rhs", *, single: bool = False, native: bool = False) -> Callable[..., Any]:
    """Return a routine of the equations as a pure JAX function `f(t, x, p=None, r=None)`, for `jit`, `vmap`, `grad` and `jacfwd`.

    Parameters
    ----------
    eom : the equations, from `kn.derive`
    routine : "rhs" (ẋ), "mass_matrix", "forcing", "reactions", "inverse_dynamics" or another of `Compiled.emit`; additional
        arguments such as the accelerations a follow x
    single : permit single precision. By default JAX must be set to double precision, because the rounding errors of a right-hand
        side in single precision soon dominate an integration.
    native : call kane's machine code from XLA, on CPUs only, instead of compiling thousands of operations with XLA. ẋ has compiled
        first derivatives with respect to all arguments; higher ones, and those of other routines, are as without `native`.

    Returns
    -------
    callable
        Vectors have their values on the last axis; preceding axes are broadcast and come first in the result. `p` and `r` are as in
        `Compiled.rhs`: omitted parameters have their defaults. Values given by name may be traced arrays with axes.

    Raises
    ------
    ArgumentError
        if JAX is not installed or not in double precision, which `native` always requires, or the equations have no such
        routine; when called, if a vector has a wrong length, or a parameter no value
    """
    jax, jnp = _module("jax"), _module("jax.numpy")

    def number(value: Any) -> Any:
        return jnp.asarray(value, dtype=float)

    if not ((single and not native) or jax.config.jax_enable_x64):
        raise ArgumentError(
            "Expected JAX in double precision, got single: call jax.config.update('jax_enable_x64', True) before anything else "
            "of JAX, or to_jax(…, single=True)."
        )

    return _of_tool(eom, routine, jnp, jax.Array, number, partial(native_of_jax, jax) if native else None)


def to_torch(eom: Any, routine: str = "rhs", *, native: bool = False) -> Callable[..., Any]:
    """Return a routine of the equations as a function `f(t, x, p=None, r=None)` of PyTorch tensors in double precision.

    It consists of differentiable operations and works with `torch.autograd` and `torch.func` (`vmap`, `jacrev`, `jacfwd`);
    otherwise it is as in `to_jax`.

    Parameters
    ----------
    eom : the equations, from `kn.derive`
    routine : as in `to_jax`
    native : call kane's machine code, on CPUs only, once instead of one call for each operation. ẋ has compiled first derivatives
        with respect to all arguments; higher ones, and those of other routines, are as without `native`.

    Raises
    ------
    ArgumentError
        if PyTorch is not installed, or the equations have no such routine; when called, as in `to_jax`, and with `native` if a
        tensor is on another device
    """
    torch = _module("torch")

    def number(value: Any) -> Any:
        return torch.as_tensor(value, dtype=torch.float64)

    return _of_tool(eom, routine, torch, torch.Tensor, number, partial(native_of_torch, torch) if native else None)


def _of_tool(
    eom: Any, routine: str, xp: Any, kind: type, number: Callable[[Any], Any], native: Callable[..., Any] | None
) -> Callable[..., Any]:
    """A routine in operations of an array library whose arrays have the type `kind`, or as a call of machine code if `native`."""
    program = cache(lambda name: _program(eom, (name,)))

    def operations(name: str) -> Evaluate:
        return _traced(program(name), xp, number)

    own = program(routine)
    evaluate = of_arrays(own.ports, native(routine, program, operations)) if native else operations(routine)

    def vector(values: Sequence[Any]) -> Any:
        arrays = [number(v) for v in values]
        leading = xp.broadcast_shapes(*(a.shape for a in arrays))
        return xp.stack([xp.broadcast_to(a, leading) for a in arrays], -1)

    def by_name(port: Port, value: Mapping[Any, Any], base: Array) -> Any:
        return _by_name(port, value, base, kind, vector)

    return _callable(eom, own, number, by_name, evaluate)


def to_casadi(eom: Any, routine: str = "rhs") -> Any:
    """Return a routine of the equations as a `casadi.Function` of SX, with the operations of kane's own code.

    Parameters
    ----------
    eom : the equations, from `kn.derive`
    routine : "rhs": ẋ = f(t, x, p, r). "residual": 0 = F(t, x, xdot, p, r), the rates of the coordinates, then M u̇ − f, then the
        rates of further states, without a solution for u̇, as collocation needs it. With constraints M u̇ − f would equal the
        constraint forces, so that F is xdot − f(t, x, p, r). Others as in `to_jax`.

    Returns
    -------
    casadi.Function
        Its inputs are columns named t, x, p, r, with additional ones of the routine after x; its output is <routine>_value.

    Raises
    ------
    ArgumentError
        if CasADi is not installed, or the equations have no such routine or no inverse dynamics that the routine needs
    """
    ca = _module("casadi")
    table = {name: getattr(ca, name) for name in [*_SAME, "asin", "acos", "atan", "atan2"]}
    table |= {"pow": ca.power, "abs": ca.fabs, "min": ca.fmin, "max": ca.fmax}
    table |= {"less": lambda x, y: ca.if_else(x < y, 1.0, 0.0), "where": lambda c, x, y: ca.if_else(c != 0, x, y)}
    table |= {"regular": lambda x, size: ca.if_else(ca.fabs(x) > GONE * size, x, float("nan"))}
    table |= _OPERATORS
    if routine == "residual":
        return _residual(eom, ca, table)
    program = _program(eom, (routine,))
    given = {port.name: ca.SX.sym(port.name, len(port.symbols)) for port in program.ports}
    found = ca.vertcat(*_run(program, program.routine(routine), table, _entries(program, given), ca.SX))
    shape = program.routine(routine).shape
    whole = ca.reshape(found, shape[1], shape[0]).T if len(shape) == 2 else found
    return ca.Function(routine, [*given.values()], [whole], [*given], [f"{routine}_value"])


def _residual(eom: Any, ca: Any, table: Mapping[str, Callable[..., Any]]) -> Any:
    """F(t, x, xdot, p, r): rates of coordinates, M u̇ − f, rates of further states."""
    derived = _solved(eom).derived
    program = _program(eom, ("rhs",) if derived.constraints.constraints else ("rhs", "inverse_dynamics"))
    given = {port.name: ca.SX.sym(port.name, len(port.symbols)) for port in program.ports}
    first = len(derived.system.coordinates)
    last = first + len(derived.speeds)
    xdot = ca.SX.sym("xdot", len(derived.state))
    values = _entries(program, {**given, "a": xdot[first:last]})
    rates, *forces = (_run(program, r, table, values, ca.SX) for r in program.routines)
    rows = [xdot[k] - rate for k, rate in enumerate(rates)]
    for found in forces:
        rows[first:last] = found
    t, x, p, r = (given[name] for name in ("t", "x", "p", "r"))
    return ca.Function(
        "residual", [t, x, xdot, p, r], [ca.vertcat(*rows)], ["t", "x", "xdot", "p", "r"], ["residual_value"]
    )


def _entries(program: Program, given: Mapping[str, Any]) -> list[Any]:
    """The values of all inputs of a program, from one vector for each port."""
    return [given[port.name][k] for port in program.ports for k in range(len(port.symbols))]


_OPERATORS: Mapping[str, Callable[..., Any]] = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
    "neg": lambda x: -x,
}


def _arrays(xp: Any) -> Mapping[str, Callable[..., Any]]:
    """The table of operations of an array library."""
    nan = float("nan")
    named = {name: getattr(xp, name) for name in [*_SAME, "abs"]}
    return {
        **_OPERATORS,
        **named,
        "asin": xp.arcsin,
        "acos": xp.arccos,
        "atan": xp.arctan,
        "atan2": xp.arctan2,
        "pow": getattr(xp, "power", None) or xp.pow,
        "min": lambda x, y: xp.where((x < y) | (x != x), x, y),
        "max": lambda x, y: xp.where((x > y) | (x != x), x, y),
        "less": lambda x, y: xp.where(x < y, 1.0, 0.0),
        "sign": lambda x: xp.where(x != x, x, xp.sign(x)),
        "where": lambda c, x, y: xp.where(c != 0.0, x, y),
        "regular": lambda x, size: xp.where(xp.abs(x) > GONE * size, x, nan),
    }


def _module(name: str) -> Any:
    """An optional dependency; ArgumentError if it is not installed."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as missing:
        package = name.partition(".")[0]
        raise ArgumentError(
            f"Expected {package} to be installed, got {missing}. Install it: pip install {package}."
        ) from missing


def _solved(eom: Any) -> Solved:
    solved = getattr(eom, "solved", None)
    if isinstance(solved, Solved):
        return solved
    raise expect.refusal(ArgumentError, "Equations", type(eom).__name__, "Derive them first, kn.derive(system).")


def _program(eom: Any, routines: Sequence[str]) -> Program:
    solved, known = _solved(eom), (*ROUTINES, *ON_DEMAND)
    expect.none(
        [repr(r) for r in routines if r not in known], f"a routine among {', '.join(known)}", error=ArgumentError
    )
    return program_of(solved, routines)


def _run(
    program: Program,
    routine: Routine,
    table: Mapping[str, Callable[..., Any]],
    inputs: Sequence[Any],
    number: Callable[[float], Any],
) -> list[Any]:
    """The results of a routine at values of all inputs, in the arithmetic of these values."""
    values: dict[int, Any] = dict(enumerate([*inputs, *map(number, program.constants)]))
    needed = {a for i in routine.body for a in program.arguments(i)}.union(routine.results)
    for i in (*program.below(needed, False), *routine.body):
        values[i] = table[program.op(i).name](*(values[a] for a in program.arguments(i)))
    return [values[i] for i in routine.results]


def _traced(program: Program, xp: Any, number: Callable[[Any], Any]) -> Evaluate:
    """The function of a program with one routine, evaluated operation by operation."""
    (routine,), ports, table = program.routines, program.ports, _arrays(xp)

    def evaluate(arrays: Sequence[Any]) -> Any:
        given = list(zip(ports, arrays, strict=True))
        leading = tuple(xp.broadcast_shapes(*(a.shape if p.scalar else a.shape[:-1] for p, a in given)))
        values = [a if p.scalar else a[..., k] for p, a in given for k in range(len(p.symbols))]
        rows = [xp.broadcast_to(x, leading) for x in _run(program, routine, table, values, number)]
        found = xp.stack(rows, -1) if rows else number(np.zeros((*leading, 0)))
        return found.reshape((*leading, *routine.shape))

    return evaluate


ByName: TypeAlias = Callable[[Port, Mapping[Any, Any], Array], Any]
"""The vector of a port from a mapping by symbol or name, and defaults of omitted values."""


def _by_name(
    port: Port, value: Mapping[Any, Any], base: Array, kind: type, vector: Callable[[Sequence[Any]], Any]
) -> Any:
    """The vector of a port from a mapping; arrays of the tool, which may be traced, are stacked unchanged, others are numbers."""
    given = named_values(port.nouns, port.symbols, value)
    traced = {s: v for s, v in given.items() if isinstance(v, kind)}
    zeros = dict.fromkeys(traced, 0.0)
    numbers = check_complete(port, replaced_values(port, {**given, **zeros}, base))
    return vector([traced.get(s, x) for s, x in zip(port.symbols, numbers, strict=True)]) if traced else numbers


def _callable(
    eom: Any, program: Program, number: Callable[[Any], Any], by_name: ByName, evaluate: Evaluate
) -> Callable[..., Any]:
    """A function of the ports of a routine, called by position or name, that returns an array."""
    ports, name = program.ports, program.routines[0].name
    defaults = {port.name: port_defaults(port) for port in ports if port.hoisted}

    def function(t: Any, x: Any, *rest: Any, **named: Any) -> Any:
        given = _given(ports, (t, x, *rest), named)
        return evaluate([_vector(port, given.get(port.name), defaults, number, by_name) for port in ports])

    function.__name__ = function.__qualname__ = name
    function.__doc__ = f"{name}({program.signature}) of {eom!r}."
    return function


def _given(ports: Sequence[Port], rest: tuple[Any, ...], named: Mapping[str, Any]) -> Mapping[str, Any]:
    names = [port.name for port in ports]
    more = (repr(n) for n in named if n not in names[len(rest) :])
    expect.none(more, f"arguments {', '.join(names)}, each once", error=ArgumentError)
    if len(rest) > len(names):
        raise expect.refusal(
            ArgumentError, f"arguments {', '.join(names)}", f"{len(rest)} of them", "Leave the others out."
        )
    return {**dict(zip(names, rest, strict=False)), **named}


def _vector(
    port: Port, value: Any, defaults: Mapping[str, Array], number: Callable[[Any], Any], by_name: ByName
) -> Any:
    """An argument as an array of the tool; raises if its length is wrong or a value is missing."""
    if isinstance(value, Mapping):
        value = by_name(port, value, defaults.get(port.name, np.full(len(port.symbols), np.nan)))
    elif value is None and port.hoisted:
        value = check_complete(port, defaults[port.name])
    elif value is None and not port.symbols:
        value = np.zeros(0)
    array = number(np.nan if value is None else value)
    if not port.scalar and (array.ndim == 0 or array.shape[-1] != len(port.symbols)):
        names = ", ".join(s.name for s in port.symbols) or "none"
        got = "nothing" if value is None else f"an array of shape {tuple(array.shape)}"
        raise ArgumentError(
            f"Expected {len(port.symbols)} values of {port.name} ({names}) on the last axis, got {got}."
        )
    return array


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

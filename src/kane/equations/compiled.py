# SPDX-License-Identifier: BSD-3-Clause
"""Equations of motion as machine code: routines called with t, x, p, r.

What is compiled, or derived anew, of equations of motion: each when it is first needed, and kept with the equations.
"""

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from threading import Lock
from typing import Any, Generic, NoReturn, Protocol, TypeVar

import numpy as np

from kane import show
from kane.dynamics.lazy import read
from kane.dynamics.solved import Solved
from kane.equations.routines import ROUTINES, Outputs, output_bundle, ports, program
from kane.errors import ArgumentError, Attributes, none_of
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle, Receipt, build_program, receipt
from kane.program.native import array_arguments
from kane.program.native.compiled_routine import ALL, BundleRoutine, CompiledRoutine, NotFinite, new_block
from kane.program.native.machine import Settings, build_library
from kane.program.program import Program

_ARRAY: Any = np.ndarray


class Handle(CompiledRoutine):
    """One compiled routine: `handle(t, x, p, r)`.

    `t` is a number, `x` the state (…, n), `p` the parameters (…, np) or a mapping by symbol or name (those left out keep their
    defaults; all of them where `p` is None), `r` the inputs (…, nr). Leading axes broadcast; the result has them, then `shape`.
    It is always a new array. Threads may call one handle at the same time: each call has a block of memory to itself.

    NaN or infinity in the arguments is an `ArgumentError`. If a result is not finite, `not_finite` says what happens: "warn"
    (`KaneWarning`), "raise" (`NotFiniteError`); both name the first intermediate that is not. With "ignore" nothing is checked.
    """

    __slots__ = ()

    def __call__(self, t: Any, x: Any, p: Any = None, r: Any = None) -> Array:
        """The results at t, x, p, r."""
        # As in any routine, but written out for these four: this is what solvers call.
        if (
            (type(t) is float or type(t) is np.float64 or type(t) is int)
            and type(x) is _ARRAY
            and (p is None or type(p) is _ARRAY or type(p) is dict)
            and (type(r) is _ARRAY or type(r) is dict or (r is None and self._standard[3] is not None))
        ):
            free = self._free
            try:
                own = free.pop()
            except IndexError:
                own = new_block(self.program, self.routine)
            address, time, x_own, p_own, r_own, out = own
            try:
                time.value = t
                x_own[ALL] = x
                if type(p) is dict:
                    self._put(2, p_own, p, self._standard[2])
                else:
                    p_own[ALL] = self._standard[2] if p is None else p
                if type(r) is dict:
                    self._put(3, r_own, r, self._standard[3])
                elif r is not None:
                    r_own[ALL] = r
            except (KeyError, OverflowError, TypeError, ValueError, NotImplementedError):
                free.append(own)
            else:
                if self._call(address):
                    return self._doubtful(own, (t, x, p, r))
                results: Array = out.copy()
                free.append(own)
                return results
        many = self._in_rows((t, x, p, r))
        return self._general(t, x, p, r) if many is None else many

    def explain(self, t: Any, x: Any, p: Any = None, r: Any = None) -> str:
        """Which intermediate is the first that is not finite at one state, and what it is made of; "" where all is finite."""
        return super().explain(t, x, p, r)

    _repr_html_ = show.html


class HasSolved(Protocol):
    """What routines need of equations of motion."""

    @property
    def solved(self) -> Solved:
        """u̇ and the reactions."""


@dataclass(frozen=True, eq=False, repr=False)
class Compiled(Attributes):
    """Equations of motion as callable machine code.

    `rhs(t, x, p, r)` gives ẋ = (q̇, u̇), `mass_matrix` M, `forcing` f of M u̇ = f, `reactions` the reactions; each is a `Handle`,
    compiled when it is first read (`rhs` at once). `jac`, `jac_inputs`, `jac_parameters` and `jac_time` are exact
    derivatives of `rhs`, `jvp`, `vjp` and `hvp` products of them with vectors.
    `outputs(t, x, p, r)` gives a dict of the expressions named when compiling.
    """

    equations: HasSolved
    settings: Settings
    name: str
    default: Array
    bundle: Outputs | None
    not_finite: NotFinite
    rhs: Handle = field(init=False)

    def __post_init__(self) -> None:
        self.default.flags.writeable = False
        object.__setattr__(self, "rhs", self._handle("rhs"))

    def _program(self, routines: Sequence[str]) -> Program:
        outputs = self.bundle if "outputs" in routines else None
        names = [r for r in routines if r != "outputs" or not outputs]
        contract, optimize = self.settings.contract, self.settings.optimize
        return program(
            self.equations.solved, names, outputs, name=self.name, reciprocals=contract, optimize=contract and optimize
        )

    def _handle(self, name: str) -> Handle:
        return Handle(self._program((name,)), name, self.settings, {"p": self.default}, self.not_finite)

    def _product(self, name: str) -> CompiledRoutine:
        return CompiledRoutine(self._program((name,)), name, self.settings, {"p": self.default}, self.not_finite)

    mass_matrix = read[Handle](lambda c: c._handle("mass_matrix"), "M, n × n.")
    forcing = read[Handle](lambda c: c._handle("forcing"), "f of M u̇ = f, with the reactions at their solved values.")
    reactions = read[Handle](lambda c: c._handle("reactions"), "The reactions.")
    inverse_dynamics = read[CompiledRoutine](
        lambda c: c._product("inverse_dynamics"),
        "M u̇ − f, the generalized forces wanted besides the loads: `inverse_dynamics(t, x, a, p, r)` with a = u̇.",
    )
    jac = read[Handle](lambda c: c._handle("jac"), "J = ∂ẋ/∂x, n × n: `jac(t, x, p, r)`.")
    jac_inputs = read[Handle](lambda c: c._handle("jac_inputs"), "∂ẋ/∂r.")
    jac_parameters = read[Handle](lambda c: c._handle("jac_parameters"), "∂ẋ/∂p.")
    jac_time = read[Handle](lambda c: c._handle("jac_time"), "∂ẋ/∂t, n × 1.")
    jvp = read[CompiledRoutine](lambda c: c._product("jvp"), "J v: `jvp(t, x, v, p, r)`.")
    sensitivity = read[CompiledRoutine](
        lambda c: c._product("sensitivity"),
        "J v + ∂ẋ/∂p s, how a motion changes that begins at v with the parameters changed by s: `sensitivity(t, x, v, s, p, r)`.",
    )
    vjp_parameters = read[CompiledRoutine](
        lambda c: c._product("vjp_parameters"), "wᵀ ∂ẋ/∂p: `vjp_parameters(t, x, w, p, r)`."
    )
    vjp = read[CompiledRoutine](lambda c: c._product("vjp"), "wᵀ J: `vjp(t, x, w, p, r)`.")
    hvp = read[CompiledRoutine](
        lambda c: c._product("hvp"), "∂(wᵀ J v)/∂x, the Hessians of ẋ weighted by w, times v: `hvp(t, x, v, w, p, r)`."
    )
    _outputs = read[Handle](lambda c: c._handle("outputs"), "The outputs as one vector.")

    def outputs(self, t: Any, x: Any, p: Any = None, r: Any = None) -> dict[str, Array]:
        """The named outputs, each with the leading axes of the arguments, then its own shape."""
        if self.bundle is None:
            raise ArgumentError("Expected outputs to have been named, compile(outputs={name: expression}), got none.")
        return self.bundle.split(self._outputs(t, x, p, r))

    def parameters(self, values: Mapping[Any, Any] | None = None) -> Array:
        """The vector p: values by symbol or name, the others at their defaults."""
        port = self.rhs.program.port("p")
        return array_arguments.values(port, values or {}, self.default)

    @cached_property
    def program(self) -> Program:
        """All routines in one Program: what `emit` prints."""
        return self._program((*ROUTINES, "outputs") if self.bundle else ROUTINES)

    operations = read[Receipt](lambda c: receipt(c.program), "The operation receipt by routine.")

    def emit(self, target: str, routines: str | Sequence[str] | None = None) -> str:
        """Source text: "c" (C99), "h" (its header), "numpy" (a module).

        `routines` are some of "rhs", "mass_matrix", "forcing", "reactions" and "outputs", all of them unless told, or of
        "jac", "jac_inputs", "jac_parameters", "jac_time", "jvp", "vjp", "vjp_parameters", "sensitivity", "hvp",
        "inverse_dynamics".
        """
        from importlib.metadata import version

        from kane.program.emit.targets import EMITTERS

        chosen = (routines,) if isinstance(routines, str) else routines
        program = self.program if chosen is None else self._program(chosen)
        if target not in EMITTERS:
            raise ArgumentError(f"Expected one of {none_of(EMITTERS, target)}")
        return EMITTERS[target](program, contract=self.settings.contract, version=version("kane"))

    def __reduce__(self) -> NoReturn:
        raise ArgumentError(
            "Expected a routine to pickle or copy, compiled.rhs and the like, got the Compiled that holds it."
        )

    _repr_html_ = show.html

    def __repr__(self) -> str:
        return f"Compiled({self.name!r}: {self.rhs!r})"


def compiled(
    equations: HasSolved,
    name: str,
    outputs: Mapping[str, Any] | None,
    parameters: Mapping[Any, float] | None,
    settings: Settings,
    not_finite: NotFinite,
) -> Compiled:
    """See Equations.compile."""
    if not isinstance(getattr(equations, "solved", None), Solved):
        raise ArgumentError(
            f"Expected Equations, got {type(equations).__name__}: derive them first, kn.derive(system).compile()."
        )
    if not isinstance(name, str):
        raise ArgumentError(f"Expected a text as name, got {name!r}.")
    port = ports(equations.solved.derived)[2]
    default = array_arguments.replaced(port, parameters or {}, array_arguments.defaults(port))
    bundle = output_bundle(equations.solved, outputs or {})
    return Compiled(equations, settings, name, default, bundle, not_finite)


E = TypeVar("E")
R = TypeVar("R")
T = TypeVar("T")


_MOST = 64
"""How many of those for arguments are kept: laws, outputs, sides of switches. A routine takes some 0.2 MB."""


class Kept(Generic[T]):
    """What was made, by (function, *arguments): all without arguments, and of those with some the last `_MOST` that were asked for."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._alone: dict[tuple[Any, ...], T] = {}
        self._latest: OrderedDict[tuple[Any, ...], T] = OrderedDict()

    def get(self, key: tuple[Any, ...]) -> T | None:
        """The entry of that key, None where there is none."""
        if len(key) == 1:
            return self._alone.get(key)
        with self._lock:
            if key in self._latest:
                self._latest.move_to_end(key)
            return self._latest.get(key)

    def put(self, key: tuple[Any, ...], value: T) -> None:
        """Keep an entry; the one that was not asked for the longest goes."""
        if len(key) == 1:
            self._alone[key] = value
            return
        with self._lock:
            self._latest[key] = value
            if len(self._latest) > _MOST:
                self._latest.popitem(last=False)


class Numeric(Generic[E]):
    """Routines of `equations` with one kind of `settings`, each named by the function that says what it computes.

    It must not hold the object that keeps it, so that both are forgotten together: `equations` is another one of the same parts.
    """

    def __init__(self, equations: E, settings: Settings) -> None:
        self.equations, self.settings = equations, settings
        self._values, self._routines = Kept[tuple[Any]](), Kept[BundleRoutine[Any]]()

    def value(self, make: Callable[..., T], *arguments: Any) -> T:
        """make(equations, *arguments), made once."""
        key = (make, *arguments)
        found = self._values.get(key)
        if found is None:
            found = (make(self.equations, *arguments),)
            self._values.put(key, found)
        value: T = found[0]
        return value

    def routine(self, make: Callable[..., Bundle[R]], *arguments: Any) -> BundleRoutine[R]:
        """The routine of the bundle make(equations, *arguments), compiled once."""
        key = (make, *arguments)
        routine = self._routines.get(key)
        return self._compile([key])[0] if routine is None else routine

    def compile(self, *makes: Callable[..., Bundle[Any]] | tuple[Any, ...]) -> None:
        """Compile the bundles make(equations) as one module, those that are not yet: quicker than one by one, and the same code.

        A tuple stands for a function with arguments.
        """
        keys = [make if isinstance(make, tuple) else (make,) for make in makes]
        self._compile([key for key in keys if self._routines.get(key) is None])

    def _compile(self, keys: list[tuple[Any, ...]]) -> list[BundleRoutine[Any]]:
        bundles = [make(self.equations, *arguments) for make, *arguments in keys]
        contract = self.settings.contract
        optimize = contract and self.settings.optimize
        programs = [build_program("model", b.ports, [b.task], contract, optimize=optimize) for b in bundles]
        library = build_library(programs, self.settings) if programs else None
        made = []
        for key, bundle, code in zip(keys, bundles, programs, strict=True):
            kind = Handle if [port.name for port in bundle.ports] == ["t", "x", "p", "r"] else CompiledRoutine
            flat = kind(code, bundle.name, self.settings, None, "ignore", library)
            made.append(BundleRoutine(bundle, flat))
            self._routines.put(key, made[-1])
        return made

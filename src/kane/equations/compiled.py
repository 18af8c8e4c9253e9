# SPDX-License-Identifier: BSD-3-Clause
"""Compiled routines of equations of motion: Programs with arguments t, x = (q, u, a), p and r, and machine code called with these.

Derivatives, products with them and inverse dynamics are compiled on request. Each routine is made when first needed and cached with
the equations.
"""

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from threading import Lock
from typing import Any, Generic, Literal, NamedTuple, NoReturn, Protocol, TypeAlias, TypeVar, overload

import numpy as np

from kane import expect, show
from kane.dynamics.derivation import Derived
from kane.dynamics.lazy import read
from kane.dynamics.readings.quantities import asked, without_unknowns
from kane.dynamics.readings.regularity import divided_by, nan_where_more, notes, of_rates, pivot_of, with_regular_rates
from kane.dynamics.readings.unsolved import forcing, inverse_dynamics, mass_matrix
from kane.dynamics.slopes import backward, forward, second, slopes
from kane.dynamics.solved import Solved
from kane.equations.jacobian import KINDS, rate_symbols
from kane.errors import ArgumentError, Attributes, ExpressionError, ValueMissingError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol, rate, time
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle, Receipt, Shaped, Task, build_program, receipt
from kane.program.native.compiled_routine import (
    ALL,
    BundleRoutine,
    CompiledRoutine,
    NotFinite,
    new_block,
    port_defaults,
    port_values,
    replaced_values,
)
from kane.program.native.machine import Settings, build_library
from kane.program.passes.optimize import RULES, Rules
from kane.program.program import Note, Port, Program


def _whole(kind: str) -> Callable[[Solved], Task]:
    def task(solved: Solved) -> Task:
        columns = KINDS[kind](solved.derived)
        rows, found = rate_symbols(solved.derived), slopes(solved, columns)
        labels = [f"d({r.name})/d({c.name})" for r in rows for c in columns]
        return Task(_NAMES[kind], found.entries, found.shape, labels)

    return task


_NAMES = {"state": "jac", "inputs": "jac_inputs", "parameters": "jac_parameters", "time": "jac_time"}


def along(what: str, symbols: Sequence[Symbol]) -> tuple[Symbol, ...]:
    """A symbol beside each of these: the components of a vector."""
    return tuple(Parameter.declare(f"{what}_{s.name}", description=f"{what} of {s.name}") for s in symbols)


_DIRECTIONS: Mapping[str, tuple[str, Callable[[Derived], tuple[Symbol, ...]]]] = {
    "a": ("acceleration", lambda d: tuple(map(rate, d.speeds))),
    "v": ("direction", lambda d: along("v", d.state)),
    "w": ("weight", lambda d: along("w", d.state)),
    "s": ("change", lambda d: along("s", d.system.parameters)),
}
"""Ports of vectors: u̇ as a, v beside x, w beside ẋ, s beside p; what their components are called, and these."""


class _VectorRoutine(NamedTuple):
    """A routine of the vectors of some ports; its results are labelled by symbols of a kind."""

    ports: tuple[str, ...]
    make: Callable[..., Sequence[Expr]]
    label: str
    kind: Callable[[Derived], Sequence[Symbol]] = KINDS["state"]

    def task(self, name: str, solved: Solved) -> Task:
        d = solved.derived
        found = self.make(solved, *(_DIRECTIONS[port][1](d) for port in self.ports))
        return Task(name, found, (len(found),), [f"{self.label} of {s.name}" for s in self.kind(d)])


_PRODUCTS: Mapping[str, _VectorRoutine] = {
    "inverse_dynamics": _VectorRoutine(("a",), lambda s, a: inverse_dynamics(s), "force", lambda d: d.speeds),
    "jvp": _VectorRoutine(("v",), lambda s, v: forward(s, s.derived.state, v), "jvp"),
    "sensitivity": _VectorRoutine(
        ("v", "s"),
        lambda s, v, p: forward(s, (*s.derived.state, *s.derived.system.parameters), (*v, *p)),
        "sensitivity",
    ),
    "vjp": _VectorRoutine(("w",), lambda s, w: backward(s, s.derived.state, w), "vjp"),
    "vjp_parameters": _VectorRoutine(
        ("w",), lambda s, w: backward(s, s.derived.system.parameters, w), "vjp_parameters", KINDS["parameters"]
    ),
    "hvp": _VectorRoutine(("v", "w"), lambda s, v, w: second(s, s.derived.state, w, v), "hvp"),
}
_TASKS = {name: partial(product.task, name) for name, product in _PRODUCTS.items()}
ON_DEMAND: Mapping[str, Callable[[Solved], Task]] = {
    "inverse_dynamics": _TASKS["inverse_dynamics"],
    **{name: _whole(kind) for kind, name in _NAMES.items()},
    **_TASKS,
}
"""Routines that are made where they are asked for, by name: inverse dynamics, derivatives."""


def direction_ports(derived: Derived, routines: Sequence[str]) -> tuple[Port, ...]:
    """The ports that some routines have besides."""
    names = {port for r in routines if r in _PRODUCTS for port in _PRODUCTS[r].ports}
    rows = ((port, *row) for port, row in _DIRECTIONS.items() if port in names)
    return tuple(Port(port, own(derived), noun=noun, nouns=f"{noun}s") for port, noun, own in rows)


ROUTINES = ("rhs", "mass_matrix", "forcing", "reactions")
"""What every set of equations has; "outputs" comes with the user's own expressions."""
SUBJECT = "equations of motion"
Outputs: TypeAlias = Bundle[dict[str, Array]]


def ports(derived: Derived) -> tuple[Port, ...]:
    """t, x (coordinates, speeds, then further states), p (parameters), r (inputs)."""
    system = derived.system
    return (
        Port("t", (time,), scalar=True, noun="time"),
        Port("x", derived.state, noun="state", nouns="states"),
        Port("p", system.parameters, "parameter", noun="parameters"),
        Port("r", system.inputs, noun="inputs", optional=True),
    )


def program(
    solved: Solved,
    routines: Sequence[str] = ROUTINES,
    outputs: Outputs | None = None,
    *,
    more: Sequence[Task] = (),
    beside: Sequence[Symbol] = (),
    name: str = "model",
    reciprocals: bool = True,
    optimize: bool = True,
    rules: Rules = RULES,
) -> Program:
    """The Program of the named routines, of "outputs" where there are any, and of `more` that are given.

    "rhs" gives ẋ = (q̇, u̇, ȧ), "mass_matrix" M, "forcing" f of M u̇ = f with the reactions at their solved values, "reactions"
    those values; those of `ON_DEMAND` are asked for by name. `beside` stands behind the parameters. `reciprocals` lets divisions
    by one divisor share its reciprocal, which rounds differently, `optimize` rewrites to fewer operations by `rules`.
    """
    own = ", ".join([*ROUTINES, *(["outputs"] if outputs else []), *ON_DEMAND])
    unknown = (repr(r) for r in routines if r not in ROUTINES and r not in ON_DEMAND)
    expect.none(unknown, f"routines among {own}", error=ArgumentError)
    tasks = [_routine(solved, routine) for routine in dict.fromkeys(routines)]
    if outputs:
        tasks.append(outputs.task)
    tasks += more
    tasks = [
        replace(task, roots=with_regular_rates(solved, nan_where_more(solved, task.roots, task.roots)))
        for task in tasks
    ]
    left_out = {guard: Note(text, zero=False) for guard, text in notes(solved).items()}

    def note(guard: Expr) -> Note:
        return left_out.get(guard) or Note(of_rates(solved, guard) or divided_by(pivot_of(solved, guard)))

    t, x, *given = ports(solved.derived)
    given = [replace(port, symbols=(*port.symbols, *beside)) if port.name == "p" else port for port in given]
    every = (t, x, *direction_ports(solved.derived, routines), *given)
    return build_program(name, every, tasks, reciprocals, SUBJECT, note, optimize, rules)


def rate_names(derived: Derived) -> list[str]:
    """Names of ẋ = (q̇, u̇, ȧ)."""
    return [f"{s.name}'" for s in derived.state]


def _routine(solved: Solved, name: str) -> Task:
    derived, n = solved.derived, len(solved.derived.speeds)
    if name in ON_DEMAND:
        return ON_DEMAND[name](solved)
    if name == "rhs":
        labels = rate_names(derived)
        return Task(name, solved.right_hand_side, (len(labels),), labels)
    if name == "mass_matrix":
        labels = [f"M[{i + 1},{j + 1}]" for i in range(n) for j in range(n)]
        return Task(name, without_unknowns(solved, mass_matrix(solved).entries), (n, n), labels)
    if name == "forcing":
        return Task(name, without_unknowns(solved, forcing(solved)), (n,), [f"f[{i + 1}]" for i in range(n)])
    return Task(name, solved.reactions, (len(derived.reactions),), [r.name for r in derived.reactions])


def output_bundle(
    solved: Solved, outputs: Mapping[Any, Any], read: Callable[[Sequence[Expr]], Sequence[Expr]] = tuple
) -> Outputs | None:
    """The outputs as functions of q, u, t, parameters and inputs, None where there are none; `read` says what expressions stand for.

    A vector's measure numbers are along the inertial frame. A list of symbols and names stands for outputs of these names.

    Raises
    ------
    ArgumentError
        if a name is not text, or an output is no expression, Vector, Matrix or sequence of expressions
    ValueMissingError
        if an output holds a symbol that is not the system's
    """
    outputs = _labelled(outputs)
    if not outputs:
        return None
    groups = {}
    for name, what in outputs.items():
        expect.that(isinstance(name, str) and name.strip(), "a name for every output", name, error=ArgumentError)
        plain = _shaped(solved.derived, name, what)
        roots = tuple(without_unknowns(solved, read(plain.roots)))
        own: set[Expr] = {s for port in ports(solved.derived) for s in port.symbols}
        unknown = [f"{s} ({type(s).__name__})" for s in free_symbols(roots) if s not in own]
        expected, cure = (
            f"the output {name!r} in symbols of the system",
            "A reaction must be listed in System(reactions=…).",
        )
        expect.none(unknown, expected, "{} in it", cure, error=ValueMissingError)
        groups[name] = Shaped(plain.shape, roots)
    names = list(groups)
    return Bundle("outputs", ports(solved.derived), lambda *parts: dict(zip(names, parts, strict=True)), groups)


def _labelled(outputs: Any) -> Mapping[Any, Any]:
    """Outputs by name; of a list each symbol or name is its own."""
    if isinstance(outputs, Mapping):
        named = [(key.name if isinstance(key, Symbol) else key, what) for key, what in outputs.items()]
        expect.different((name for name, _ in named), "outputs of one name each", "Rename them.", error=ArgumentError)
        return dict(named)
    if isinstance(outputs, list | tuple) and all(isinstance(x, str | Symbol) for x in outputs):
        return {x if isinstance(x, str) else x.name: x for x in outputs}
    raise ArgumentError(
        "Expected outputs as a mapping from names to expressions, or a list of symbols and names, got "
        f"{type(outputs).__name__}: {cut(repr(outputs))}. Name each: {{'speed': v.magnitude()}}."
    )


def _shaped(derived: Derived, name: str, what: Any) -> Shaped:
    try:
        wanted = asked(derived, what)
    except ExpressionError as error:
        raise ArgumentError(
            f"Expected an expression, name, Vector, Dyadic, Matrix or a list of these as output {name!r}, got {cut(repr(what))}."
        ) from error
    if wanted.shape is None:
        expected = f"parts of one shape in the output {name!r}"
        raise expect.refusal(ArgumentError, expected, cut(repr(what)), "Name each of them.")
    return Shaped(wanted.shape, wanted.roots)


_ARRAY: Any = np.ndarray


class Handle(CompiledRoutine):
    """One compiled routine, called as `handle(t, x, p, r)`.

    `t` is the time, `x` the state (…, n), `p` the parameters (…, np) or a mapping by symbol or name, in which parameters left out
    take their defaults (None: all of them), `r` the inputs (…, nr). Leading axes broadcast; the result, a new array, has these
    axes and then those of `shape`. Several threads may call a handle at the same time.

    NaN or infinity in the arguments raises an `ArgumentError`. If a result is not finite, `not_finite` determines what happens:
    "warn" (`KaneWarning`) or "raise" (`NotFiniteError`), with the first intermediate that is not finite; with "ignore" there is no
    check.
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
        """The first intermediate result that is not finite at a state, with its operands, as text; "" if all are finite."""
        return super().explain(t, x, p, r)

    _repr_html_ = show.html


def _kind(code: Program) -> type[CompiledRoutine]:
    """What calls the routines of a Program."""
    return Handle if [port.name for port in code.ports] == ["t", "x", "p", "r"] else CompiledRoutine


class HasSolved(Protocol):
    """What routines need of equations of motion."""

    @property
    def solved(self) -> Solved:
        """u̇ and the reactions."""


@dataclass(frozen=True, eq=False, repr=False)
class Compiled(Attributes):
    """Equations of motion as machine code, from `kn.compile`.

    `rhs(t, x, p, r)` gives ẋ = (q̇, u̇, ȧ), `mass_matrix` M, `forcing` f of M u̇ = f, `reactions` the reactions; each is a
    `Handle`, compiled at its first use (`rhs` at once). `jac`, `jac_inputs`, `jac_parameters` and `jac_time` are exact derivatives
    of `rhs`, `jvp`, `vjp` and `hvp` products of them with vectors. `outputs(t, x, p, r)` gives a dict of the expressions named
    when compiling.
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

    def _handle(self, name: str) -> Any:
        code = self._program((name,))
        return _kind(code)(code, name, self.settings, {"p": self.default}, self.not_finite)

    mass_matrix = read[Handle](lambda c: c._handle("mass_matrix"), "The mass matrix M (n × n).")
    forcing = read[Handle](lambda c: c._handle("forcing"), "f of M u̇ = f, with the reactions at their solved values.")
    reactions = read[Handle](lambda c: c._handle("reactions"), "The reactions.")
    inverse_dynamics = read[CompiledRoutine](
        lambda c: c._handle("inverse_dynamics"),
        "M u̇ − f, the generalized forces needed in addition to the loads: `inverse_dynamics(t, x, a, p, r)` with a = u̇.",
    )
    jac = read[Handle](lambda c: c._handle("jac"), "J = ∂ẋ/∂x, n × n: `jac(t, x, p, r)`.")
    jac_inputs = read[Handle](lambda c: c._handle("jac_inputs"), "∂ẋ/∂r.")
    jac_parameters = read[Handle](lambda c: c._handle("jac_parameters"), "∂ẋ/∂p.")
    jac_time = read[Handle](lambda c: c._handle("jac_time"), "∂ẋ/∂t, n × 1.")
    jvp = read[CompiledRoutine](lambda c: c._handle("jvp"), "J v: `jvp(t, x, v, p, r)`.")
    sensitivity = read[CompiledRoutine](
        lambda c: c._handle("sensitivity"),
        "J v + ∂ẋ/∂p s, the variation of ẋ by variations v of the state and s of the parameters: `sensitivity(t, x, v, s, p, r)`.",
    )
    vjp_parameters = read[CompiledRoutine](
        lambda c: c._handle("vjp_parameters"), "wᵀ ∂ẋ/∂p: `vjp_parameters(t, x, w, p, r)`."
    )
    vjp = read[CompiledRoutine](lambda c: c._handle("vjp"), "wᵀ J: `vjp(t, x, w, p, r)`.")
    hvp = read[CompiledRoutine](
        lambda c: c._handle("hvp"), "∂(wᵀ J v)/∂x, the Hessians of ẋ weighted by w, times v: `hvp(t, x, v, w, p, r)`."
    )
    _outputs = read[Handle](lambda c: c._handle("outputs"), "The outputs as one vector.")

    def outputs(self, t: Any, x: Any, p: Any = None, r: Any = None) -> dict[str, Array]:
        """The outputs named in `kn.compile`, by name; each has the leading axes of the arguments, then the axes of its value."""
        if self.bundle is None:
            raise ArgumentError("Expected outputs to have been named, compile(outputs={name: expression}), got none.")
        return self.bundle.split(self._outputs(t, x, p, r))

    def parameters(self, values: Mapping[Any, Any] | None = None) -> Array:
        """The vector p with given values, by symbol or name; the other parameters have their defaults."""
        port = self.rhs.program.port("p")
        return port_values(port, values or {}, self.default)

    @cached_property
    def program(self) -> Program:
        """All routines in one Program, which `emit` prints."""
        return self._program((*ROUTINES, "outputs") if self.bundle else ROUTINES)

    operations = read[Receipt](lambda c: receipt(c.program), "The operation receipt by routine.")

    @overload
    def emit(self, target: Literal["wasm"], routines: str | Sequence[str] | None = None) -> bytes: ...  # type: ignore[overload-overlap]

    @overload
    def emit(self, target: str, routines: str | Sequence[str] | None = None) -> str: ...

    def emit(self, target: str, routines: str | Sequence[str] | None = None) -> str | bytes:
        """Source code of the routines in another language, with instructions how to call it at its top.

        `target` is "c" (C99), "h" (its header), "numpy", "jax", "torch", "casadi", "sympy" (modules of Python), "cpp", "eigen"
        (headers of C++17), "rust", "cargo" (src/lib.rs and Cargo.toml), "matlab" (Octave too), "julia", "modelica",
        "javascript" or "sfunction" (a C MEX file for Simulink); or bytes, "wasm" (a module of WebAssembly).

        `routines` are any of "rhs", "mass_matrix", "forcing", "reactions" and "outputs", by default all of these, and of "jac",
        "jac_inputs", "jac_parameters", "jac_time", "jvp", "vjp", "vjp_parameters", "sensitivity", "hvp", "inverse_dynamics".
        """
        from importlib.metadata import version

        from kane.program.emit.targets import emit

        chosen = (routines,) if isinstance(routines, str) else routines
        program = self.program if chosen is None else self._program(chosen)
        return emit(program, target, contract=self.settings.contract, version=version("kane"))

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
    default = replaced_values(port, parameters or {}, port_defaults(port))
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
            flat = _kind(code)(code, bundle.name, self.settings, None, "ignore", library)
            made.append(BundleRoutine(bundle, flat))
            self._routines.put(key, made[-1])
        return made

# SPDX-License-Identifier: BSD-3-Clause
"""The routines of equations of motion, as Programs over t, x = (q, u, a), p and r.

Derivatives, their products and inverse dynamics are made where they are asked for.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

from kane import expect
from kane.dynamics.derivation import Derived
from kane.dynamics.readings.quantities import asked, without_unknowns
from kane.dynamics.readings.regularity import divided_by, guarded, notes, of_rates, pivot_of, with_regular_rates
from kane.dynamics.readings.unsolved import forcing, inverse_dynamics, mass_matrix
from kane.dynamics.slopes import backward, forward, second, slopes
from kane.dynamics.solved import Solved
from kane.equations.jacobian import KINDS, rate_symbols
from kane.errors import ArgumentError, ExpressionError, ValueMissingError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol, rate, time
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle, Shaped, Task, build_program
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


def _directions(derived: Derived) -> dict[str, tuple[Symbol, ...]]:
    x, p = KINDS["state"](derived), KINDS["parameters"](derived)
    return {"a": tuple(map(rate, derived.speeds)), "v": along("v", x), "w": along("w", x), "s": along("s", p)}


def _product(name: str, kind: str, make: Callable[..., Sequence[Expr]]) -> Callable[[Solved], Task]:
    """A routine of vectors, by the names of their ports; its results belong to symbols of a kind."""

    def task(solved: Solved) -> Task:
        own = _directions(solved.derived)
        found = make(solved, *(own[port] for port in _PORTS[name]))
        labels = [f"{name} of {s.name}" for s in KINDS[kind](solved.derived)]
        return Task(name, found, (len(found),), labels)

    return task


def _state(solved: Solved) -> Sequence[Symbol]:
    return KINDS["state"](solved.derived)


def _given(solved: Solved) -> Sequence[Symbol]:
    return KINDS["parameters"](solved.derived)


_PORTS: Mapping[str, tuple[str, ...]] = {
    "inverse_dynamics": ("a",),
    "jvp": ("v",),
    "sensitivity": ("v", "s"),
    "vjp": ("w",),
    "vjp_parameters": ("w",),
    "hvp": ("v", "w"),
}
_PRODUCTS: Mapping[str, tuple[str, Callable[..., Sequence[Expr]]]] = {
    "jvp": ("state", lambda solved, v: forward(solved, _state(solved), v)),
    "sensitivity": ("state", lambda solved, v, s: forward(solved, (*_state(solved), *_given(solved)), (*v, *s))),
    "vjp": ("state", lambda solved, w: backward(solved, _state(solved), w)),
    "vjp_parameters": ("parameters", lambda solved, w: backward(solved, _given(solved), w)),
    "hvp": ("state", lambda solved, v, w: second(solved, _state(solved), w, v)),
}


def _inverse_dynamics(solved: Solved) -> Task:
    labels = [f"force of {u.name}" for u in solved.derived.speeds]
    return Task("inverse_dynamics", inverse_dynamics(solved), (len(labels),), labels)


ON_DEMAND: Mapping[str, Callable[[Solved], Task]] = {
    "inverse_dynamics": _inverse_dynamics,
    **{name: _whole(kind) for kind, name in _NAMES.items()},
    **{name: _product(name, *rest) for name, rest in _PRODUCTS.items()},
}
"""Routines that are made where they are asked for, by name: inverse dynamics, derivatives."""


def direction_ports(derived: Derived, routines: Sequence[str]) -> tuple[Port, ...]:
    """The ports that some routines have besides: u̇ as a, v beside x, w beside ẋ, s beside p."""
    names = dict.fromkeys(p for r in routines for p in _PORTS.get(r, ()))
    nouns = {
        "a": ("acceleration", "accelerations"),
        "v": ("direction", "directions"),
        "w": ("weight", "weights"),
        "s": ("change", "changes"),
    }
    own = _directions(derived) if names else {}
    return tuple(Port(p, own[p], noun=nouns[p][0], nouns=nouns[p][1]) for p in nouns if p in names)


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
    name: str = "model",
    reciprocals: bool = True,
    optimize: bool = True,
) -> Program:
    """The Program of the named routines, of "outputs" where there are any, and of `more` that are given.

    "rhs" gives ẋ = (q̇, u̇, ȧ), "mass_matrix" M, "forcing" f of M u̇ = f with the reactions at their solved values, "reactions" those
    values; those of `ON_DEMAND` are asked for by name. `reciprocals` lets divisions by one divisor share its reciprocal, which
    rounds differently, `optimize` rewrites to fewer operations.
    """
    own = ", ".join([*ROUTINES, *(["outputs"] if outputs else []), *ON_DEMAND])
    unknown = (repr(r) for r in routines if r not in ROUTINES and r not in ON_DEMAND)
    expect.none(unknown, f"routines among {own}", error=ArgumentError)
    tasks = [_routine(solved, routine) for routine in dict.fromkeys(routines)]
    if outputs:
        tasks.append(outputs.task)
    tasks += more
    tasks = [replace(task, roots=with_regular_rates(solved, guarded(solved, task.roots))) for task in tasks]
    left_out = {guard: Note(text, zero=False) for guard, text in notes(solved).items()}

    def note(guard: Expr) -> Note:
        return left_out.get(guard) or Note(of_rates(solved, guard) or divided_by(pivot_of(solved, guard)))

    t, x, *given = ports(solved.derived)
    every = (t, x, *direction_ports(solved.derived, routines), *given)
    return build_program(name, every, tasks, reciprocals, SUBJECT, note, optimize)


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


def output_bundle(solved: Solved, outputs: Mapping[Any, Any]) -> Outputs | None:
    """The outputs as functions of q, u, t, parameters and inputs, None where there are none.

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
        roots = tuple(without_unknowns(solved, plain.roots))
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
        return {key.name if isinstance(key, Symbol) else key: what for key, what in outputs.items()}
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

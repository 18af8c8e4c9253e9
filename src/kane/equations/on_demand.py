# SPDX-License-Identifier: BSD-3-Clause
"""Routines that are made where they are asked for: derivatives of the right-hand side, their products, inverse dynamics."""

from collections.abc import Callable, Mapping, Sequence

from kane.dynamics.derivation import Derived
from kane.dynamics.readings.programs import inverse_dynamics
from kane.dynamics.slopes import backward, forward, second, slopes
from kane.dynamics.solved import Solved
from kane.equations.jacobian import KINDS, rate_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol, rate
from kane.program.build import Task
from kane.program.program import Port


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

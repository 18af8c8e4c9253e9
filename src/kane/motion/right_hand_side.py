# SPDX-License-Identifier: BSD-3-Clause
"""The compiled right-hand side (q̇, u̇, ȧ, P) at (t, y), y = (q, u, a, ∫P dt), with its switches, event quantities and Jacobian.

J = ∂(q̇, u̇, ȧ, P)/∂(q, u, a), for implicit methods, is exact: written entry by entry if that is short; for large systems as products
with all unit vectors in one native loop, whose code is as long as a few right-hand sides.

Loads, and inputs that are expressions of the state, switch at the signs, comparisons and directions in them. In machine code the side
of each switch, −1 or 1, is a number among the parameters. With every switch replaced by its value on that side, the rates are smooth
across the switching surface, so that a step detects the crossing as an event on its polynomial (`steppers/watched.py`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from kane.dynamics.poles import SLIPS
from kane.dynamics.readings.quantities import without_unknowns
from kane.dynamics.readings.regularity import with_regular_rates
from kane.dynamics.slopes import forward, slopes
from kane.equations.compiled import along, ports, rate_names
from kane.equations.equations import Equations
from kane.errors import cut
from kane.expr.build import sub
from kane.expr.differentiation import tangent, weighted
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ONE, Expr, postorder
from kane.expr.ops import DIV, OPS, SQRT
from kane.expr.piecewise import Piecewise, applied, leaps, on, on_sides, side_symbol, side_symbols
from kane.expr.piecewise import switches as switches_of
from kane.expr.symbols import Symbol, time
from kane.motion.inputs.breakpoints import Clock, clock, is_timed
from kane.motion.inputs.expressions import (
    Number,
    SharedLaw,
    gains_of,
    law_ports,
    parts,
    turning_laws,
    values,
    with_value,
)
from kane.motion.inputs.functions import following, follows, law_and, law_of
from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import Mixed, least_constraint
from kane.numeric.scale import CHANGES_SIDE, ROUNDED_CHAIN
from kane.program.from_expressions import Bundle, Shaped
from kane.program.native.compiled_routine import BundleRoutine, CompiledRoutine
from kane.program.native.entry import entry, hoist_entry, hoisted
from kane.program.native.machine import Settings
from kane.program.program import Port

_JUMPS = {OPS["sign"], OPS["less"]}


@dataclass(frozen=True, eq=False)
class Switch:
    """A kink, or jump (`jumps`), of a load or of inputs where `quantity` is zero; or a direction v/|v|, which is undefined there.

    Texts are written when they are read, as most motions only count switches.
    """

    node: Expr
    quantity: Expr
    load: str
    jumps: bool

    @property
    def text(self) -> str:
        """The node as text."""
        return str(self.node)

    @property
    def smooth(self) -> str:
        """Advice on a smooth replacement."""
        if isinstance(self.node.op, Piecewise):
            return "take a table of kind 'cubic'"
        if self.quantity.op is SQRT:
            return f"divide by sqrt({cut(self.quantity.args[0])} + eps^2) with a small eps"
        return f"write tanh(({cut(self.quantity)})/eps) with a small eps"


def switches(eom: Equations, laws: Sequence[Expr] = ()) -> tuple[Switch, ...]:
    """Signs, comparisons and directions v/|v| in the loads, and in the `laws` of inputs, each quantity once."""
    return eom.numeric().value(_switches, *laws)


def _switches(eom: Equations, *laws: Expr) -> tuple[Switch, ...]:
    loads = {
        load.name: [x for _, v in (*load.forces, *load.torques) for x in v.scalars()]
        for load in eom.solved.regular.declared_loads
    }
    return turning({**loads, "inputs": laws})


def turning(groups: Mapping[str, Sequence[Expr]]) -> tuple[Switch, ...]:
    """Signs, comparisons and directions v/|v| that depend on the state, in expressions grouped by name of load or other owner."""
    found: dict[Expr, Switch] = {}
    for name, scalars in groups.items():
        for node in postorder(scalars):
            if node.op in _JUMPS:
                quantity = sub(*node.args) if len(node.args) == 2 else node.args[0]
            elif isinstance(node.op, Piecewise) and node.op.sides is not None:
                quantity = applied(node.op.sides[0], node.args[0])
            elif node.op is DIV and node.args[1].op is SQRT:  # a direction v/|v|
                quantity = node.args[1]
            else:
                continue
            if is_constant_in_time([quantity]) or is_timed(quantity):
                continue
            jumping = leaps(node.op) if isinstance(node.op, Piecewise) else node.op is not DIV
            known = found.setdefault(quantity, Switch(node, quantity, name, jumping))
            if jumping and not known.jumps:
                found[quantity] = replace(known, node=node, jumps=True)
    return tuple(found.values())


def has_jumps(eom: Equations, laws: Sequence[Expr] = ()) -> bool:
    """Whether loads, or the `laws` of inputs, jump."""
    return any(s.jumps for s in switches(eom, laws))


def rates_jump(eom: Equations, laws: Sequence[Expr] = ()) -> bool:
    """Whether rates jump at states: by loads, the `laws` of inputs, or the declared rates of further states."""
    return has_jumps(eom, laws) or any(s.jumps for s in turning({"states": [*eom.system.states.values()]}))


Sides = npt.NDArray[np.int8]


def sides(motion: Any) -> dict[str, Sides]:
    """See Solution.regimes."""
    eom: Equations = motion.equations
    turning = [s for s in switches(eom) if s.jumps]
    slips = [
        (load.name, load.slip)
        for load in eom.solved.regular.declared_loads
        if load.slip and load.slip.speed is not None
    ]
    values = motion[[*(s.quantity for s in turning), *(slip.speed for _, slip in slips)]] if turning or slips else []
    result = {s.text: _sign(v) for s, v in zip(turning, values, strict=False)}
    for (name, slip), speed in zip(slips, values[len(turning) :], strict=True):
        least = SLIPS * np.abs(speed).max(initial=0) if slip.threshold is None else slip.threshold
        result[name] = (speed > (1 + CHANGES_SIDE) * least).astype(np.int8)
    return result


def _sign(values: npt.NDArray[np.float64]) -> Sides:
    near = np.abs(values) <= ROUNDED_CHAIN * np.abs(values).max(initial=0)
    return np.where(near, 0, np.sign(values)).astype(np.int8)


R = TypeVar("R")
Given = dict[str, Any]
"""Arguments of a kernel by name: arrays, integers and routines."""


def rates(eom: Equations) -> Bundle[tuple[Array, ...]]:
    """(q̇, u̇, ȧ, P) as a function of the state."""
    roots = without_unknowns(eom.solved, [*eom.right_hand_side, eom.power])
    return Bundle("motion", ports(eom.derived), parts, {"rates": roots}, [*rate_names(eom.derived), "P"])


def timed(eom: Equations) -> Clock:
    """The parts of the rates that switch at given times, or may be pulses."""
    return clock(rates(eom).task.roots)


def switched(eom: Equations, *more: Expr) -> Bundle[tuple[Array, ...]]:
    """The quantities at which loads jump, and `more`, those of the laws of inputs."""
    roots = [*without_unknowns(eom.solved, jumping(eom)), *more]
    return Bundle("switches", law_ports(eom, more), parts, {"switches": roots}, list(map(str, range(len(roots)))))


def jumping(eom: Equations, laws: Sequence[Expr] = ()) -> list[Expr]:
    """The quantities at which loads jump, then those at which `laws` of inputs jump."""
    found = [*switches(eom), *switches(eom, laws)] if laws else switches(eom)
    return list(dict.fromkeys(s.quantity for s in found if s.jumps))


def quantities(eom: Equations, laws: Sequence[Expr] = ()) -> tuple[Expr, ...]:
    """The quantities of all switches in the rates, then of those in the `laws` of inputs, without tables that only have kinks."""
    found = [s for roots in (rates(eom).task.roots, laws) for s in switches_of(roots)]
    return tuple(dict.fromkeys(s.quantity for s in found if not all(map(_bending, s.nodes))))


def _bending(node: Expr) -> bool:
    return isinstance(node.op, Piecewise) and not leaps(node.op)


def sided(eom: Equations, count: int, make: Callable[..., Bundle[R]], *arguments: Any) -> Bundle[R]:
    """A bundle with the switches of `quantities` on their sides, `count` numbers that follow the parameters in p."""
    plain, own, memo = make(eom, *arguments), side_symbols(quantities(eom)), dict[Expr, Expr]()
    groups = {
        name: Shaped(group.shape, tuple(on_sides(root, own, memo) for root in group.roots))
        for name, group in plain.groups.items()
    }
    own_ports = [replace(p, symbols=_with_sides(p.symbols, count)) if p.name == "p" else p for p in plain.ports]
    return Bundle(plain.name, own_ports, plain.record, groups, plain.labels)


def _with_sides(symbols: Sequence[Symbol], count: int) -> tuple[Symbol, ...]:
    """The symbols of p with `count` sides between parameters and the numbers of laws."""
    first = next((k for k, s in enumerate(symbols) if isinstance(s, Number)), len(symbols))
    return (*symbols[:first], *map(side_symbol, range(count)), *symbols[first:])


class Unembedded(NamedTuple):
    """q̇, f and Ȧ u + ḃ, from which accelerations are computed where the constraints lose rank."""

    rates: Array
    forcing: Array
    drift: Array


def unembedded(eom: Equations) -> Bundle[Unembedded]:
    """q̇, f and Ȧ u + ḃ as functions of the state."""
    groups = {"rates": eom.rates, "forcing": eom.forcing, "drift": eom.constraints.drift}
    plain = {name: without_unknowns(eom.solved, roots) for name, roots in groups.items()}
    return Bundle("unembedded", ports(eom.derived), Unembedded, plain)


@dataclass(frozen=True, slots=True, eq=False)
class SidedEquations:
    """Equations whose bundles are compiled with `settings`, the switches of `quantities` replaced by their values on a side."""

    eom: Equations
    settings: Settings | None
    quantities: tuple[Expr, ...]

    def routine(self, make: Callable[..., Bundle[R]], *arguments: Any) -> BundleRoutine[R]:
        """The compiled routine of a bundle."""
        return self.eom.numeric(self.settings).routine(*self._on_sides(make, *arguments))

    def compiled(self, *makes: tuple[Any, ...]) -> list[CompiledRoutine]:
        """The routines of several bundles, each a function with its arguments, compiled in one module."""
        self.eom.numeric(self.settings).compile(*(self._on_sides(*make) for make in makes))
        return [self.routine(*make).flat for make in makes]

    def _on_sides(self, *make: Any) -> tuple[Any, ...]:
        return (sided, len(self.quantities), *make) if self.quantities else make


@dataclass(frozen=True, slots=True, eq=False)
class Routines(SidedEquations):
    """Compiled equations with values `p` of the parameters and inputs `drives` as functions; `width` is the length of (q, u, a).

    `numbers` are the constants in inputs that are expressions, and in the quantities at which these switch. If a kernel decides
    switches, p ends with the sides of `quantities`, `written` are the inputs on these sides, and `turning` are the quantities in the
    form that routines take.
    """

    p: Array
    drives: tuple[Callable[[Any], Any], ...]
    width: int
    rates: CompiledRoutine
    events: CompiledRoutine | None = None
    switches: CompiledRoutine | None = None
    numbers: tuple[float, ...] = ()
    written: tuple[Callable[[Any], Any], ...] = ()
    turning: tuple[Expr, ...] = ()

    @property
    def laid(self) -> tuple[Callable[[Any], Any], ...]:
        """The inputs as kernels evaluate them: with switches on their sides if the kernel decides these."""
        return self.written or self.drives

    @property
    def laws(self) -> tuple[Expr, ...]:
        """The inputs that are expressions of the state with switches."""
        return turning_laws(self.drives)

    def driven(self, parameters: Mapping[Expr, Any]) -> "Routines":
        """The same with other values of parameters in the inputs."""
        drives, written = (tuple(with_value(f, parameters) for f in own) for own in (self.drives, self.written))
        gains = gains_of(drives)
        return replace(self, drives=drives, written=written, numbers=(*gains.values(), *self.numbers[len(gains) :]))

    def inputs(self, t: float | Array, y: Array) -> Array:
        """Values of the inputs at t and y; as below, for one time and state, or a row for each of times (k) and states (k × n)."""
        return values(self.drives, t, y[..., : self.width])

    def rate(self, t: float | Array, y: Array) -> Array:
        """(q̇, u̇, ȧ, P) at t and y."""
        return self.at(self.rates, t, y, self.p)

    def least_rate(self, t: float, y: Array, m: Array, a: Array, reach: Array, mix: Mixed | None = None) -> Array:
        """(q̇, u̇, ȧ, P) with the u̇ nearest to M⁻¹ f in the mass metric for which A u̇ = −(Ȧ u + ḃ) (Gauss's principle)."""
        routine = self.routine(unembedded)
        q_dot, f, drift = routine(t, y[: self.width], self.p, self.inputs(t, y))
        rest = self.rate(t, y)[len(q_dot) + len(f) :]
        return np.concatenate([q_dot, least_constraint(m, a, f, -drift, reach, mix), rest])

    def watch(self, t: float | Array, y: Array) -> Array:
        """The events' quantities (events) at t and y."""
        return np.zeros((*np.shape(t), 0)) if self.events is None else self.at(self.events, t, y)

    def switch(self, t: float | Array, y: Array) -> Array:
        """The quantities of the switches (switches) at t and y; there must be some."""
        assert self.switches is not None
        return self.at(self.switches, t, y)

    def at(self, routine: CompiledRoutine, t: float | Array, y: Array, p: Array | None = None) -> Array:
        """The values of a routine at t and y, by default with its own p."""
        p = self.parameters(routine) if p is None else p
        return routine(t, y[..., : self.width], p, self.inputs(t, y) if self.drives else None)

    def parameters(self, routine: CompiledRoutine) -> Array:
        """The p of a routine: the parameters of the equations, and as many constants of the inputs as its ports have."""
        wanted = sum(len(port.symbols) for port in routine.program.ports if port.name == "p")
        return self.p if wanted == len(self.p) else np.append(self.p, self.numbers)[:wanted]

    def hoisted(self, name: str, routine: CompiledRoutine, t: float, y: Array, r: Array) -> Given:
        """The hoisted values of a routine, and the function that evaluates them anew, as arguments of a kernel."""
        h = hoisted(routine, t, y[: self.width], self.parameters(routine), r)
        return {name: h, f"hoist_{name}": hoist_entry(routine)}

    def values(self, t: float | Array, y: Array) -> dict[Expr, Any]:
        """A number, or one for each row, for every symbol of the equations and of inputs."""
        eom = self.eom
        symbols = (time, *eom.state, *eom.parameters, *eom.inputs)
        p = self.p[: len(eom.parameters)].tolist()
        known = dict(zip(symbols, [t, *y[..., : self.width].T, *p, *self.inputs(t, y).T], strict=True))
        return gains_of(self.drives) | known

    def explain(self, t: float, y: Array) -> str:
        """The first operation of the rates whose value is not finite, as text."""
        return self.rates.explain(t, y[: self.width], self.p, self.inputs(t, y))


def routines(
    eom: Equations,
    p: Array,
    drives: Sequence[Callable[[Any], Any]],
    settings: Settings | None,
    *others: Callable[[Equations], Bundle[Any]],
) -> Routines:
    """The compiled equations; the bundles of `others` are compiled in the same module."""
    equations, jumps = SidedEquations(eom, settings, ()), jumping(eom, turning_laws(drives))
    law = law_and(drives, eom.inputs, jumps[len(jumping(eom)) :])
    turning = [(switched, *law.values[len(eom.inputs) :])] if jumps else []
    own, *more = equations.compiled((rates,), *turning, *((make,) for make in others))
    sides = more[0] if turning else None
    return Routines(eom, settings, (), p, tuple(drives), len(eom.state), own, None, sides, law.numbers)


def unfit(eom: Equations, laws: Sequence[Expr] = ()) -> bool:
    """Whether equations jump and have switches that two sides do not describe: tables of steps, or choices of pivots."""
    if not has_jumps(eom, laws):
        return False
    loads = eom.solved.regular.declared_loads
    scalars = [x for load in loads for _, v in (*load.forces, *load.torques) for x in v.scalars()]
    own = switches_of([*without_unknowns(eom.solved, scalars), *laws])
    tables = any(isinstance(node.op, Piecewise) and leaps(node.op) for s in own for node in s.nodes)
    return tables or not set(quantities(eom, laws)) <= {s.quantity for s in own}


def on_one_side(eom: Equations, laws: Sequence[Expr] = ()) -> list[Expr]:
    """(q̇, u̇, ȧ, P), and the `laws` of inputs, with every switch on side 1: the expressions evaluated between switching times."""
    every = quantities(eom, laws)
    return list(map(on(every, (1,) * len(every)), (*rates(eom).task.roots, *laws)))


_STEP = 2.0**-24
"""Relative step of finite differences with respect to inputs and states."""
_LONG = 40_000
"""Operations of the right-hand side times states above which J is not written entry by entry."""


def only(x: Array) -> Array:
    """The record of a bundle with one array: that array."""
    return x


def entries(eom: Equations) -> Bundle[Array]:
    """J = ∂(q̇, u̇, ȧ, P)/∂(q, u, a), entry by entry."""
    return _written(eom, "slopes", _slopes(eom, eom.state))


def closed(eom: Equations, *values: Expr) -> Bundle[Array]:
    """J if the inputs are the expressions `values` of the state, with the derivatives of these (closed loop)."""
    x, r = eom.state, eom.inputs
    own, by_input = _slopes(eom, x), _slopes(eom, r)
    gained = [[tangent(value, {s: ONE}, at_rest=True) for s in x] for value in values]
    for i in range(len(x) + 1):
        for j in range(len(x)):
            for k in range(len(r)):
                own[i * len(x) + j] += by_input[i * len(r) + k] * gained[k][j]
    return _written(eom, "closed", own, law_ports(eom, values))


def _slopes(eom: Equations, symbols: Sequence[Symbol]) -> list[Expr]:
    power = without_unknowns(eom.solved, [eom.power])
    return [*slopes(eom.solved, symbols).entries, *weighted(power, [ONE], symbols)]


def _written(eom: Equations, name: str, roots: list[Expr], own: Sequence[Port] = ()) -> Bundle[Array]:
    n = len(eom.state)
    return Bundle(name, own or ports(eom.derived), only, {"x": Shaped((n + 1, n), _regular(eom, roots))})


def products(eom: Equations) -> Bundle[Array]:
    """J v for a vector v."""
    x, power = eom.state, without_unknowns(eom.solved, [eom.power])
    v = along("v", x)
    seeds: dict[Expr, Expr] = dict(zip(x, v, strict=True))
    roots = [*forward(eom.solved, x, v), *(tangent(p, seeds, at_rest=True) for p in power)]
    own = (*ports(eom.derived), Port("v", v, noun="direction"))
    return Bundle("products", own, only, {"x": Shaped((len(x) + 1,), _regular(eom, roots))})


def _regular(eom: Equations, roots: list[Expr]) -> tuple[Expr, ...]:
    return tuple(with_regular_rates(eom.solved, roots))


def by_inputs(now: Routines, t: Any, x: Array, r: Array) -> Array:
    """∂(q̇, u̇, ȧ, P)/∂r at one or several states by differences: exact for loads affine in r, else sufficient for iterations."""
    own, steps = now.rates(t, x, now.p, r), _steps(r)
    moved = (now.rates(t, x, now.p, r + h * e) for h, e in zip(steps, np.eye(r.shape[-1]), strict=True))
    return np.stack([(found - own) / h for h, found in zip(steps, moved, strict=True)], axis=-1)


def gains(now: Routines, t: Any, x: Array, r: Array) -> Array:
    """∂r/∂x at one or several states by differences, for inputs r that are functions of the state."""
    places = [k for k, f in enumerate(now.drives) if following([f])]
    drives, result = [now.drives[k] for k in places], np.zeros((*r.shape, x.shape[-1]))
    for k, (h, e) in enumerate(zip(_steps(x), np.eye(x.shape[-1]), strict=True)):
        result[..., places, k] = (values(drives, t, x + h * e) - r[..., places]) / h
    return result


def _steps(x: Array) -> Array:
    """The difference step of each component along the last axis; that axis comes first, one of length 1 last."""
    largest = np.abs(x).max(axis=-1, keepdims=True, initial=0)
    sizes = np.maximum(np.abs(x), np.where(largest, largest, 1.0)) * _STEP
    return np.moveaxis(sizes, -1, 0)[..., None]


def is_long(now: Routines) -> bool:
    """Whether J is evaluated as products with vectors."""
    return now.eom.operations.total * now.width > _LONG


def pattern(now: Routines) -> Mask | None:
    """The sparsity pattern of J by the symbols in the rates; None if an input depends on the state."""
    if any(getattr(f, "of_state", False) for f in now.drives):
        return None
    return now.eom.numeric(now.settings).value(_jacobian_pattern)


def _jacobian_pattern(eom: Equations) -> Mask:
    place = {s: 1 << k for k, s in enumerate(eom.state)}
    roots = without_unknowns(eom.solved, [*eom.right_hand_side, eom.power])
    held: dict[Expr, int] = {}
    for node in postorder(roots):
        own = place.get(node, 0)  # type: ignore[call-overload]  # most nodes are not symbols
        for part in node.args:
            own |= held[part]
        held[node] = own
    n = len(eom.state)
    whole = np.zeros((n + 1, n + 1), dtype=bool)
    whole[:, :n] = [[bool(held[root] >> k & 1) for k in range(n)] for root in roots]
    return whole


def derivatives(now: Routines, t: float, y: Array, law: SharedLaw | None) -> Given:
    """The arguments of a kernel for J."""
    long, p = is_long(now), now.p
    if law is not None and follows(now.drives):
        routine, p = now.routine(closed, *law.values).flat, law.parameters(p)
    else:
        routine = now.routine(products if long else entries).flat
    at = t, y[: now.width], p, now.inputs(t, y)
    own, none = entry(routine), entry(now.rates)
    given: Given = {"long": int(long), "jac": none if long else own, "along": own if long else none}
    h = hoisted(routine, *at, *([np.zeros(now.width)] if long else []))
    return given | {"hj": h, "hoist_hj": hoist_entry(routine)}


def exact(now: Routines) -> Callable[[float, Array], Array]:
    """The function J(t, y). Derivatives that are not finite, as of √x at 0, become 0: the errors of steps are estimated without J."""
    n = now.width
    unit = np.eye(n)
    long = is_long(now)

    def by_entries(t: float, x: Array, r: Array) -> Array:
        return now.routine(entries)(t, x, now.p, r)

    def by_products(t: float, x: Array, r: Array) -> Array:
        return now.routine(products)(t, x, now.p, r, unit).T

    def by_law(t: float, x: Array, r: Array) -> Array:
        return by_values(t, x, p, r)

    law = None if long or not follows(now.drives) else law_of(now.laid, now.eom.inputs)
    if law is not None:
        by_values, p = now.routine(closed, *law.values), law.parameters(now.p)
    by_law_alone = not law and following(now.drives)

    def j(t: float, y: Array) -> Array:
        whole = np.zeros((n + 1, n + 1))
        x, r = y[:n], now.inputs(t, y)
        found = (by_law if law else by_products if long else by_entries)(t, x, r)
        if by_law_alone:
            found = found + by_inputs(now, t, x, r) @ gains(now, t, x, r)
        whole[:, :n] = np.where(np.isfinite(found), found, 0.0)
        return whole

    return j

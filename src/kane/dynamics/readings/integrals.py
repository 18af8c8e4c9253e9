# SPDX-License-Identifier: BSD-3-Clause
"""Integrals of the equations of motion: functions of q, u and t that every motion keeps (Kane & Levinson 1985, sec. 7.1, 7.2 and 7.4).

Candidates are the energy, the Hamiltonian K₂ − K₀ + V in the rates, momenta of cyclic coordinates, linear and angular momenta along
the inertial axes, and single speeds. A candidate is an integral if its rate vanishes beside its terms at several random states; one
that is proportional to a preceding integral is left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kane import show
from kane.dynamics.derivation import Derived
from kane.dynamics.in_rates import InRates
from kane.dynamics.readings import energy
from kane.dynamics.readings.contributions import differs, measured, states
from kane.dynamics.readings.energy import central_angular_momentum, conjugate_momenta
from kane.dynamics.readings.potential import find_potential
from kane.dynamics.readings.quantities import without_rates
from kane.dynamics.solved import Solved
from kane.errors import PotentialError, cut
from kane.expr.build import add, mul, sub
from kane.expr.differentiation import diff, gradient
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ZERO, Expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Time, input_of, rate
from kane.expr.visit import substituting
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL

_STATES, _LEAST = 8, 2


@dataclass(frozen=True, slots=True, eq=False)
class Integral(Immutable):
    """An integral of the equations of motion: a function of the state that is constant in every motion.

    Attributes
    ----------
    name : such as "energy", "momentum of q1", "angular momentum about O along N.z"
    value : the function, in coordinates, speeds and parameters
    why : the reason why it is constant, as text
    """

    name: str
    value: Expr
    why: str

    _repr_latex_ = show.latex

    def __repr__(self) -> str:
        return f"Integral({self.name!r}: {cut(self.value)})"


def integrals(solved: Solved) -> tuple[Integral, ...]:
    """See Equations.integrals."""
    found: list[Integral] = []
    kept: list[Array] = []
    for one in _proposed(solved):
        numbers = _values_if_constant(solved, one.value)
        if numbers is not None and not any(_same(numbers, other) for other in kept):
            found.append(one)
            kept.append(numbers)
    return tuple(found)


def _values_if_constant(solved: Solved, value: Expr) -> Array | None:
    """The values of a function at random states, with one set of parameters, if it is an integral; else None."""
    if is_constant_in_time([value]):
        return None
    derived = solved.derived
    plain = without_rates(derived, value)
    by: dict[Expr, Expr] = {
        u: x for u, x in zip(derived.speeds, solved.speeds_by_independent, strict=True) if u is not x
    }
    *terms, own = map(substituting(by), (*_rate_terms(solved, plain), plain))
    values, moved = differs([terms, [own]], states(derived, [*terms, own]))
    finite = np.isfinite(values).all(axis=1)
    if finite.sum() < _LEAST or moved[finite, 0].any() or not moved[finite, 1].any():
        return None
    return np.asarray(measured([own], states(derived, [own], varied=False))[:, 0])


def _rate_terms(solved: Solved, value: Expr) -> list[Expr]:
    """The terms of dc/dt: ∂c/∂q q̇, ∂c/∂u u̇, and those of the time and of inputs."""
    derived = solved.derived
    moves: dict[Expr, Expr] = dict(zip(derived.system.coordinates, solved.written(derived.rates), strict=True))
    moves.update(zip(derived.speeds, solved.accelerations, strict=True))
    moves.update(zip(derived.states, solved.state_rates, strict=True))
    result = [ZERO]
    for s in free_symbols([value]):
        if isinstance(s, Time):
            result.append(diff(value, s))
        elif s in moves:
            result.append(mul(diff(value, s), moves[s]))
        elif input_of(s) is not None:
            result.append(mul(diff(value, s), rate(s)))
    return result


def _same(a: Array, b: Array) -> bool:
    """Whether two functions are proportional at all states at which both are finite."""
    both = np.isfinite(a) & np.isfinite(b)
    x, y = a[both], b[both]
    scale = np.linalg.norm(x) * np.linalg.norm(y)
    return bool(abs(abs(x @ y) - scale) <= EQUAL * scale) and len(x) > 1


# What may be one --------------------------------------------------------------------------------------------------------


def _proposed(solved: Solved) -> Iterator[Integral]:
    derived = solved.derived.as_declared
    yield from _energies(solved, derived)
    for q, p in zip(derived.system.coordinates, conjugate_momenta(derived), strict=True):
        yield Integral(f"momentum of {q}", p, f"{q} is cyclic: neither K nor a force depends on it or acts along it")
    yield from _momenta(derived)
    for u in derived.speeds:
        yield Integral(f"speed {u}", u, "its equation is u' = 0")


def _energies(solved: Solved, derived: Derived) -> Iterator[Integral]:
    v, found = energy.potential_energy(derived.loads), []
    for load in derived.system.all_loads():
        if load.potential is None:
            try:
                v = add(v, find_potential(derived, [load]).value)
                found.append(load.name)
            except PotentialError:
                continue
    said = f", those of {', '.join(found)} found" if found else ""
    total = add(energy.whole_kinetic_energy(solved), v)
    yield Integral(
        "energy", total, f"K + V: all loads that do work have a potential energy{said}, and no motion is prescribed"
    )
    k, q_dot = InRates(derived).declared_kinetic_energy, tuple(map(rate, derived.system.coordinates))
    twice = ZERO
    for r, p in zip(q_dot, gradient(k, q_dot), strict=True):
        twice = add(twice, mul(r, p))
    hamiltonian = add(without_rates(derived, sub(twice, k)), v)
    yield Integral(
        "Hamiltonian",
        hamiltonian,
        f"K₂ − K₀ + V by the rates: all forces have a potential energy{said}, and L does not depend on time",
    )


def _momenta(derived: Derived) -> Iterator[Integral]:
    bodies, frame = derived.bodies, derived.system.inertial
    root = bodies[0].part.mass_center.root()
    vectors = (
        ("linear momentum", energy.linear_momentum(bodies), "no external force acts along it"),
        (
            f"angular momentum about {root.name}",
            energy.angular_momentum(bodies, root),
            "no external moment acts about it",
        ),
        (
            "central angular momentum",
            central_angular_momentum(bodies),
            "no external moment about the mass centre acts about it",
        ),
    )
    for name, vector, why in vectors:
        for axis, x in zip("xyz", vector.components(frame), strict=True):
            yield Integral(f"{name} along {frame.name}.{axis}", x, why)

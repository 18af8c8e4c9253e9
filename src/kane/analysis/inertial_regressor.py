# SPDX-License-Identifier: BSD-3-Clause
"""`regressor`: inverse dynamics as a linear function of the inertial parameters, and which of these a motion determines.

With the mass m of each body, first moments h = m c about the point C that the model declares as its mass centre, and the inertia
dyadic I about C, Kane's equations of the independent speeds are

    Σ ṽ_r·f + ω̃_r·τ = F̃_r,   f = m (a − g) + α × h + ω × (ω × h),   τ = I·α + ω × I·ω + h × (a − g)

linear in π = (m, h, I) of all bodies: Y(q, u, u̇) π = F̃, the generalized forces of all loads except gravity (Atkeson, An, Hollerbach
1986; with partial velocities for Jacobians). ṽ, ω̃ are nonholonomic partial velocities, so that constraint forces do not appear and
closed loops are admitted. Base parameters are the combinations that Y determines (Gautier & Khalil 1990), here by numerical rank.

Physically consistent parameters that fit measured forces F minimize the convex function ½ |Y π − F|²/σ² + μ Σ D(J, J₀). The divergence
D of the pseudo-inertia J(π) of each body from that of the model is infinite unless J ≻ 0; otherwise its term is small beside the noise
of F, and determines combinations that the forces do not.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane import expect
from kane.analysis.assembly import assemble
from kane.dynamics.motions import Motions
from kane.dynamics.readings.contributions import vanish
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.equations import Equations, check_equations
from kane.equations.state import State, guess
from kane.errors import Attributes, KaneError, ModelError, SimulationError
from kane.expr.build import add
from kane.expr.differentiation import tangent
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Symbol, rate, time
from kane.expr.visit import substituted
from kane.model.bodies import Particle, RigidBody
from kane.numeric.arrays import Array, common_shape
from kane.numeric.pseudo_inertia import UNITS, WEIGHT, distance, made_positive, root_of, step_rows
from kane.numeric.rank import balance, least_squares
from kane.numeric.sampling import SEED, named_values
from kane.numeric.scale import ROUNDED_TERMS
from kane.space.vector import Vector
from kane.units.rules import BASES, parse

_MOMENTS = ((0, 0, "xx"), (1, 1, "yy"), (2, 2, "zz"), (0, 1, "xy"), (1, 2, "yz"), (2, 0, "zx"))
_TELLS = 1e-9
"""Rank tolerance: fraction of the largest singular value of the regressor over many states, with columns scaled to length 1."""
_KINDS = {"m": 2, "m c": 1, "I_x": 0, "I_y": 0, "I_z": 0}
"""Order in which base parameters are represented: by moments of inertia, first moments, masses (Gautier & Khalil 1990)."""
_STATES = 12
"""Random states for each parameter."""
_TRIES = 5
_DECADES = 3
"""Powers of ten, up and down, of the scales of time and length of random states."""


@dataclass(frozen=True, eq=False, repr=False)
class BaseParameters(Attributes):
    """The base parameters β = K π: the combinations of inertial parameters π that motions and forces can identify.

    Attributes
    ----------
    names : names of all inertial parameters π
    chosen : the parameter that represents each base parameter
    matrix : K (rank × parameters): 1 for the chosen parameters, and the coefficients of the others
    without : parameters without effect on motions
    """

    names: tuple[str, ...]
    chosen: tuple[str, ...]
    matrix: Array
    without: tuple[str, ...]

    @property
    def rank(self) -> int:
        """The number of base parameters."""
        return len(self.chosen)

    @property
    def combinations(self) -> tuple[str, ...]:
        """Each base parameter as a sum of inertial parameters, as text."""
        return tuple(" ".join(self._terms(row)).removeprefix("+ ") for row in self.matrix)

    def _terms(self, row: Array) -> Iterator[str]:
        for name, x in zip(self.names, row.tolist(), strict=True):
            if x:
                size = "" if abs(abs(x) - 1) < 1e-9 else f"{abs(x):.6g} "
                yield f"{'-' if x < 0 else '+'} {size}{name}"

    def __repr__(self) -> str:
        return f"BaseParameters({self.rank} of {len(self.names)}: {', '.join(self.chosen)})"


@dataclass(frozen=True, eq=False, repr=False)
class Regressor(Attributes):
    """The regressor Y of the equations of motion Y(q, u, u̇) π = F̃, linear in the inertial parameters π of all bodies.

    `names` (k) are those of π, such as "rod: m", "rod: m c_x", "rod: I_zz"; `values` (k) are their expressions in the model,
    `matrix` is Y (p × k) in q, u, u̇, t and the geometric parameters.
    """

    eom: Equations
    names: tuple[str, ...]
    values: tuple[Expr, ...]
    matrix: tuple[tuple[Expr, ...], ...]
    loads: tuple[Expr, ...]

    def numbers(self, parameters: Mapping[Any, float] | None = None) -> Array:
        """Values of π (k) in the model, for given values of its parameters."""
        return np.array([float(v) for v in evaluate(self.values, dict(parameter_values(self.eom.system, parameters)))])

    def at(self, q: Any, u: Any, accelerations: Any, **given: Any) -> Array:
        """Y (samples × p × k) at states with accelerations, given as numbers or arrays (samples), by symbol or name, or in order.

        Under constraints, give u and u̇ of all speeds. `t`, `parameters` and `inputs` are as in `eom.evaluate`.
        """
        table = self._values([e for row in self.matrix for e in row], q, u, accelerations, **given)
        return table.reshape(*table.shape[:-1], len(self.matrix), len(self.names))

    def forces(self, q: Any, u: Any, accelerations: Any, **given: Any) -> Array:
        """Generalized active forces F̃ (samples × p) of all loads except gravity, at states given as in `at`."""
        return self._values(self.loads, q, u, accelerations, **given)

    def possible(self, y: Any, forces: Any, parameters: Mapping[Any, float] | None = None) -> Array:
        """The physically consistent π (k) that fit Y π = F̃ best: positive masses, and inertias of a distribution of positive mass.

        Ordinary least squares may violate these conditions if noise is large. Combinations that the data do not determine stay
        near the values of the model at `parameters`. Rows of Y (… × p × k) and F̃ (… × p) must have equal standard deviations;
        divide each by its own.

        Raises
        ------
        SimulationError
            if masses of the model are not positive
        """
        rows, right = (expect.floats(x, "Y and F̃ in numbers", error=SimulationError) for x in (y, forces))
        k = len(self.names)
        shape, came = rows.shape[:-1], f"the shapes {rows.shape} and {right.shape}"
        alike = rows.shape[-1:] == (k,) and common_shape({"F̃": right, "Y, its last axis apart": rows[..., 0]}) == shape
        expect.that(alike, f"Y (… × p × {k}) and F̃ (… × p)", came=came, error=SimulationError)
        finite = np.isfinite(rows).all() and np.isfinite(right).all()
        expect.that(finite, "Y and F̃ of finite numbers", came="infinity or NaN", error=SimulationError)
        expect.that(right.any(), "forces that are not all zero", came="only zeros", error=SimulationError)
        right, rows = np.broadcast_to(right, shape).reshape(-1), rows.reshape(-1, k)
        sizes = list(Counter(name.rpartition(": ")[0] for name in self.names).values())
        return possible(rows, right, sizes, self.numbers(parameters))

    def _values(
        self,
        exprs: Sequence[Expr],
        q: Any,
        u: Any,
        accelerations: Any,
        *,
        t: Any = 0.0,
        parameters: Any = None,
        inputs: Any = None,
    ) -> Array:
        """Values of expressions (samples × expressions)."""
        eom = self.eom
        values: dict[Expr, Any] = {time: t, **parameter_values(eom.system, parameters)}
        values |= named_values("coordinates", eom.coordinates, q) | named_values("speeds", eom.speeds, u)
        own = named_values("accelerations, by speed,", eom.speeds, accelerations)
        values |= {rate(s): own[s] for s in eom.speeds if s in own}
        values |= named_values("inputs", eom.inputs, inputs)
        missing = [str(s) for s in (*eom.coordinates, *eom.speeds, *map(rate, eom.speeds)) if s not in values]
        expect.none(missing, "values of all coordinates, speeds and accelerations", "none of {}", error=SimulationError)
        shape = common_shape(values)
        return np.stack([np.broadcast_to(np.asarray(x, dtype=float), shape) for x in evaluate(exprs, values)], axis=-1)

    def base(
        self, parameters: Mapping[Any, float] | None = None, *, near: Any = None, seed: int = SEED
    ) -> BaseParameters:
        """The base parameters, by the numerical rank of Y over random states.

        `near` are coordinates, by name or in order, around which states are drawn; under constraints the states are assembled.
        """
        y, terms = self._random(parameters, near, np.random.default_rng(seed))
        seen = np.flatnonzero((np.abs(y) > ROUNDED_TERMS * terms).any(axis=0))
        level = balance(y[:, seen], order=(1, 0, 1, 0), rounding=0.0)
        scaled, sizes, long = level.matrix, level.columns[0], np.linalg.norm(level.matrix, axis=0)
        chosen = list[int]()
        rest = scaled.copy()
        for i in sorted(range(len(seen)), key=lambda i: _KINDS[self.names[seen[i]].rpartition(": ")[2][:3]]):
            own = rest[:, i]
            if np.linalg.norm(own) > _TELLS**0.5 * long[i]:
                chosen.append(i)
                unit = own / np.linalg.norm(own)
                for _ in range(2):
                    rest -= np.outer(unit, unit @ rest)
        chosen.sort()
        k = np.zeros((len(chosen), len(self.names)))
        solved = least_squares(scaled[:, chosen], scaled) if chosen else np.zeros((0, len(seen)))
        k[:, seen] = np.where(np.abs(solved) < _TELLS, 0.0, solved) * sizes / sizes[chosen][:, None]
        names = np.array(self.names, dtype=object)
        without = tuple(names[np.setdiff1d(np.arange(len(names)), seen)].tolist())
        return BaseParameters(self.names, tuple(names[seen[chosen]].tolist()), k, without)

    def _random(
        self, parameters: Mapping[Any, float] | None, near: Any, rng: np.random.Generator
    ) -> tuple[Array, Array]:
        """Y at random states on the constraints, and the sizes of the terms of its entries (rows × k).

        Only the accelerations of independent speeds matter. Each state has its own scales of time and, without constraints, of length,
        over several decades: which terms dominate does not depend on units then.
        """
        eom, found = self.eom, list[tuple[Mapping[Any, float], Mapping[Any, float], Array]]()
        count = max(6, -(-_STATES * len(self.names) // max(1, len(self.matrix))))
        middle = dict.fromkeys(eom.coordinates, 0.0) | named_values("coordinates", eom.coordinates, near)
        wide, held = 1.0 if near is None else 0.3, bool(eom.constraints.constraints or eom.system.euler_parameters)
        given = {"parameters": parameters, "inputs": dict.fromkeys(eom.inputs, 0.0), "t": 0.3}
        free = not held and near is None
        memo: Sizes = {}
        lengths: dict[Expr, bool] = {s: free and _is_length(s) for s in (*eom.coordinates, *eom.speeds)}
        entries = [e for row in self.matrix for e in row]
        for _ in range(count * _TRIES):
            fast, far = 10 ** rng.uniform(-_DECADES, _DECADES, 2)
            q: Mapping[Any, float] = {
                s: float(v) + wide * far ** lengths[s] * float(rng.normal()) for s, v in middle.items()
            }
            u: Mapping[Any, float] = {s: fast * far ** lengths[s] * float(rng.normal()) for s in eom.speeds}
            accelerations = np.array([fast**2 * far ** lengths[s] * float(rng.normal()) for s in eom.speeds])
            try:
                if held:
                    guesses = ({s: guess(v) for s, v in own.items()} for own in (q, u))
                    state = assemble(eom, State(*guesses, **given))
                    q, u = state.q, state.u
            except KaneError:
                continue
            found.append((q, u, accelerations))
            if len(found) == count:
                q_all, u_all = [{s: np.array([state[k][s] for state in found]) for s in found[0][k]} for k in (0, 1)]
                rates = list(np.transpose([own[2] for own in found]))
                table = self._values([*entries, *(size(e, memo) for e in entries)], q_all, u_all, rates, **given)
                y, terms = table.reshape(count, 2, -1, len(self.names)).swapaxes(0, 1).reshape(2, -1, len(self.names))
                return y, terms
        raise SimulationError(
            f"Expected states on the constraints around {'0' if near is None else 'the coordinates of near='}, got only "
            f"{len(found)} of {count} random ones. Give near=, coordinates at which the mechanism closes."
        )

    def __repr__(self) -> str:
        return f"Regressor({len(self.matrix)} equations, {len(self.names)} inertial parameters)"


def regressor(eom: Equations) -> Regressor:
    """The regressor Y of Y(q, u, u̇) π = F̃ for the inertial parameters π of all bodies, of trees, closed loops, nonholonomic systems.

    For each rigid body, π contains the mass m, the first moments m c (3) about the mass centre declared in the model, and the
    inertia (6) about that point, along the axes of the body; for a particle, its mass. Measured motions and forces give the
    combinations `regressor.base()` by linear least squares, `np.linalg.lstsq(Y, F)`; `regressor.possible(Y, F)` gives physically
    consistent π.

    Parameters
    ----------
    eom : Equations
        of a system of rigid bodies and particles

    Returns
    -------
    Regressor
        `r.at(q, u, accelerations)` is Y, `r.forces(…)` F̃, `r.numbers()` π of the model, `r.base()` the identifiable combinations

    Raises
    ------
    ModelError
        if a body is a beam, or a load depends on a reaction

    Notes
    -----
    Atkeson, C. G., An, C. H., Hollerbach, J. M. (1986), Estimation of inertial parameters of manipulator loads and links, Int. J.
    Robotics Research 5(3), 101–119; Gautier, M., Khalil, W. (1990), Direct calculation of minimum set of inertial parameters of
    serial robots, IEEE Trans. Robotics and Automation 6(3), 368–373.

    Examples
    --------
    >>> r = kn.fitting.regressor(eom)
    >>> Y, F = r.at(q, u, accelerations), r.forces(q, u, accelerations)
    >>> r.base().combinations
    """
    check_equations(eom)
    system = eom.system
    whole = Motions(eom.derived, eom.embedding, True)
    free_fall = whole.in_speeds(sum((g.acceleration for g in system.gravities), start=Vector()))
    names, values, columns = list[str](), list[Expr](), list[list[Expr]]()
    for body in system.bodies:
        if not isinstance(body, RigidBody | Particle):
            raise ModelError(
                f"Expected rigid bodies and particles for a regressor, got the {type(body).__name__} {body.name!r}: its mass moves "
                "within it. Model it by rigid bodies."
            )
        partials = [whole.partial_velocities(body.parts()[0].mass_center).values()]
        if isinstance(body, RigidBody):
            partials.append(whole.partial_angular_velocities(body.frame).values())
        for name, value, *wrench in _columns(whole, body, free_fall):
            names.append(f"{body.name}: {name}")
            values.append(value)
            columns.append(_generalized(whole, zip(partials, wrench, strict=False)))
    forces = ((whole.partial_velocities(at), f) for load in system.loads for at, f in load.forces)
    torques = ((whole.partial_angular_velocities(at), t) for load in system.loads for at, t in load.torques)
    loads = _generalized(whole, ((p.values(), whole.in_speeds(v)) for p, v in (*forces, *torques)))
    held = [s for s in free_symbols(loads) if s in set(eom.reactions)]
    if not vanish([tangent(e, {s: ONE}) for e in loads for s in held], eom.derived):
        raise ModelError(
            "Expected loads without reactions for a regressor, got some that depend on them, as friction does: F̃ would depend on π. "
            "Leave them out of the model that is identified."
        )
    loads = [substituted(e, dict.fromkeys(held, ZERO)) for e in loads]  # reactions are noncontributing
    return Regressor(eom, tuple(names), tuple(values), tuple(zip(*columns, strict=True)), tuple(loads))


def _is_length(s: Symbol) -> bool:
    """Whether the unit of a coordinate or speed contains a length."""
    return bool(s.unit and parse(s.unit).exponents[[*BASES].index("m")])


def _columns(
    whole: Motions, body: RigidBody | Particle, free_fall: Vector
) -> Iterator[tuple[str, Expr, Vector, Vector]]:
    """For each parameter of a body its name, value, and the inertia force and torque about C per unit, with gravity subtracted."""
    center = body.parts()[0].mass_center
    falls = whole.acceleration(center) - free_fall
    yield "m", body.mass, falls, Vector()
    if not isinstance(body, RigidBody):
        return
    w, turn = whole.angular_velocity(body.frame), whole.angular_acceleration(body.frame)
    axes = (body.frame.x, body.frame.y, body.frame.z)
    for letter, e in zip("xyz", axes, strict=True):
        yield f"m c_{letter}", ZERO, turn.cross(e) + w.cross(w.cross(e)), e.cross(falls)
    of_body = body.inertia.components(body.frame)
    for i, j, letters in _MOMENTS:
        unit = axes[i].outer(axes[j]) if i == j else axes[i].outer(axes[j]) + axes[j].outer(axes[i])
        yield f"I_{letters}", of_body[i, j], Vector(), unit.dot(turn) + w.cross(unit.dot(w))


def _generalized(whole: Motions, loads: Iterable[tuple[Iterable[Vector], Vector]]) -> list[Expr]:
    """Σ ṽ_r·F + ω̃_r·T by independent speed, of pairs of partial velocities and the force or torque."""
    found = [ZERO for _ in whole.speeds]
    for partials, load in loads:
        found = [add(e, v.dot(load)) for e, v in zip(found, partials, strict=True)]
    return found


_ROUNDS, _SHORT, _FEWER = 200, 1e-12, 10.0
_ARRIVED, _ROUNDED = 1e-8, 1e-2
"""Tolerances of the predicted decrease of a Newton step, relative to the weight: at convergence, and if rounding prevents it."""
_LEAST = 1e-7
"""Least standard deviation of forces, relative to their root mean square, if they fit without residual."""
_PARTICLE = np.ones((1, 1, 1))


@dataclass(frozen=True, slots=True, eq=False)
class _Body:
    """The indices `at` of a body's parameters in π, the pseudo-inertia J of a unit of each, and J₀."""

    at: slice
    units: Array
    first: Array

    def lower(self, pi: Array) -> Array | None:
        """The Cholesky factor L of J = L Lᵀ, or None unless J ≻ 0."""
        return root_of(np.tensordot(pi[self.at], self.units, 1))


def possible(y: Array, forces: Array, sizes: Sequence[int], model: Array) -> Array:
    """π (k) of bodies whose numbers of parameters are `sizes`: 10, or 1 for a particle; `model` contains π₀.

    Raises
    ------
    SimulationError
        if a mass of the model is not positive, or no minimum is found
    """
    bodies, pi, start = list[_Body](), model.astype(float), 0
    for count in sizes:
        at = slice(start, start := start + count)
        if not pi[at.start] > 0:
            raise SimulationError(f"Expected first masses above zero, got {pi[at.start]:g}. Give parameters=.")
        units = UNITS if count > 1 else _PARTICLE
        first = made_positive(np.tensordot(pi[at], units, 1))
        pi[at] = np.linalg.lstsq(units.reshape(count, -1).T, first.reshape(-1))[0]
        bodies.append(_Body(at, units, first))
    long = np.linalg.norm(y, axis=0)
    equal = y / np.where(long > 0, long, 1.0)
    solution, _, rank, _ = np.linalg.lstsq(equal, forces)
    spread = np.linalg.norm(forces - equal @ solution) / max(len(forces) - int(rank), 1) ** 0.5
    sigma = max(float(spread), _LEAST * float(np.linalg.norm(forces)) / len(forces) ** 0.5, 1e-300)
    return _least(y / sigma, forces / sigma, bodies, pi)


def _least(y: Array, forces: Array, bodies: Sequence[_Body], pi: Array) -> Array:
    """Minimize with decreasing weights: with the last one alone, Newton's method would need many steps from a distant start."""
    weight = max(1.0, 0.5 * float(np.sum((y @ pi - forces) ** 2)))
    while weight > WEIGHT:
        pi = _newton(y, forces, bodies, pi, weight, 0.1)
        weight = max(WEIGHT, weight / _FEWER)
    return _newton(y, forces, bodies, pi, WEIGHT, _ARRIVED)


def _newton(y: Array, forces: Array, bodies: Sequence[_Body], pi: Array, weight: float, near: float) -> Array:
    """Minimize for one weight by Newton's method, until the predicted decrease is less than `near` times the weight."""
    root, fall = weight**0.5, float("inf")
    now, lowers = _value(y, forces, bodies, pi, weight)
    for _ in range(_ROUNDS):
        rows, right = [y], [forces - y @ pi]
        for body, lower in zip(bodies, lowers, strict=True):
            c, slope = step_rows(lower, body.units, body.first)
            rows.append(np.zeros((len(c), len(pi))))
            rows[-1][:, body.at] = root * c
            right.append(-root * slope)
        whole = np.vstack(rows)
        scale = np.linalg.norm(whole, axis=0)
        d = np.linalg.lstsq(whole / scale, np.concatenate(right), rcond=1e-15)[0] / scale
        fall, share = float(np.sum((whole @ d) ** 2)), 1.0
        if fall <= near * weight:
            return pi
        while share > _SHORT:
            value, there = _value(y, forces, bodies, pi + share * d, weight)
            if value <= now - 1e-4 * share * fall + 1e-14 * abs(now):
                break
            share /= 2
        else:
            break
        pi, now, lowers = pi + share * d, value, there
    if fall <= _ROUNDED * weight:
        return pi
    raise SimulationError(
        f"Expected convergence to the physically possible bodies closest to the forces, got none in {_ROUNDS} steps. Scale Y and F̃ "
        "so that deviations of rows are of one size, or give better first values, parameters=, than the model's."
    )


def _value(y: Array, forces: Array, bodies: Sequence[_Body], pi: Array, weight: float) -> tuple[float, list[Array]]:
    lowers = [body.lower(pi) for body in bodies]
    there = [lower for lower in lowers if lower is not None]
    if len(there) < len(bodies):
        return float("inf"), []
    far = sum(distance(lower, body.first) for body, lower in zip(bodies, there, strict=True))
    return 0.5 * float(np.sum((y @ pi - forces) ** 2)) + weight * far, there

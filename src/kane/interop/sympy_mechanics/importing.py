# SPDX-License-Identifier: BSD-3-Clause
"""`from_sympy_mechanics`: a model of `sympy.physics.mechanics` as a `System`."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from itertools import permutations
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from kane.equations.equations import Equations, derive
from kane.errors import KaneWarning, ModelError, ReactionError, cut
from kane.expr.differentiation import gradient, time_derivative
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.matrix import solve_linear
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Coordinate, Input, Parameter, Rate, Speed, Symbol, rate, time
from kane.expr.visit import substituted
from kane.interop.imported import FreeNames, Imported, Remarks
from kane.interop.sympy_mechanics.frames import Frames, euler_sets
from kane.interop.sympy_mechanics.given import Given, read, tree
from kane.interop.sympy_mechanics.names import Translation
from kane.interop.sympy_mechanics.points import Auxiliary, Points
from kane.interop.sympy_mechanics.speeds import Definitions, define, follow, keeps_length, rates_by_speeds
from kane.interop.sympy_mechanics.states import COUNT, States
from kane.model.bodies import Body, Particle, RigidBody
from kane.model.constraints import configuration_constraint, motion_constraint
from kane.model.loads import Force, Load, Torque
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.rank import balanced, singular
from kane.numeric.scale import EQUAL, LAST_DIGIT, ROUNDED_ROOT, SOLVE_RANK, SPEEDS_RANK

_MOST_TIED = 4
"""Maximum number of candidate rates that are matched with functions of time that only accelerations contain."""
T = TypeVar("T", Coordinate, Speed, Parameter)


def from_sympy_mechanics(
    model: Any,
    loads: Any = None,
    *,
    bodies: Sequence[Any] | None = None,
    values: Mapping[Any, float] = MappingProxyType({}),
    check: bool = True,
    **stated: Any,
) -> Imported:
    """Convert a model of `sympy.physics.mechanics` to a `System`, with remarks on inferences, changes and checks.

    Frames are made by their orientations, points by their positions; those with only a velocity, or with one that differs from the
    rate of the position, get coordinates driven by it. Kinematical equations define the speeds; other functions of time are inputs.

    Parameters
    ----------
    model : a KanesMethod, LagrangesMethod, System or JointsMethod, or a list of bodies
    loads : pairs of a point or frame and a vector, actuators; by default those of the model
    bodies : the bodies, if the method does not have them
    values : numbers for parameters, by symbol or name, which become their defaults
    check : whether accelerations are compared with those of SymPy's equations, formed if necessary, at random states
    stated : for a list of bodies, the inertial `frame`, and arguments of KanesMethod: `q`, `u`, `kd_eqs`, …; by default, q are the
        functions of time in orientations and positions, and u = q̇

    Raises
    ------
    ModelError
        if the object is not such a model or lacks required data, or if SymPy's equations contradict the bodies, positions, loads
        and constraints from which they were formed: the message shows the difference
    ExpressionError
        for expressions without a counterpart in kane
    """
    given = read(model, loads, bodies, **stated)
    made, system = _made(given, values)
    remarks, known = made.remarks, made.known
    known.check_values()
    if check:
        made.tie(system.inputs)
        check_accelerations(given, derive(system), known, made.states, remarks, made.auxiliary, made.cause)
    else:
        remarks.say("ignored", "the comparison of accelerations with SymPy's: check=False")
    symbols = known.named()
    q, u, parameters = _of(symbols, Coordinate), _of(symbols, Speed), _of(symbols, Parameter)
    return Imported(system, symbols, q, u, parameters, remarks.all())


def _of(symbols: Mapping[str, Expr], kind: type[T]) -> Mapping[str, T]:
    return MappingProxyType({name: s for name, s in symbols.items() if isinstance(s, kind)})


def _made(given: Given, values: Mapping[Any, float]) -> tuple["_Import", System]:
    """The import; without reactions if there are constraints, because SymPy's do not say where their forces act."""
    made = _Import(given, values, bool(given.auxiliary) and not (given.motion or given.holonomic))
    try:
        system = made.system()
    except ReactionError:
        system = None
    if system is None or (made.auxiliary.reactions and system.constraints):
        made = _Import(given, values, False)
        system = made.system()
    return made, system


class _Import:
    """An import; its parts are made in the order of their dependencies."""

    def __init__(self, given: Given, values: Mapping[Any, float], reactions: bool) -> None:
        self.remarks = remarks = Remarks()
        self.known = known = Translation(given, values, remarks)
        self._given = given
        self._second: dict[Expr, Expr] | None = None
        known.scalars(given.k_q)
        self._kinematical = (_rows(given.k_q, known), _rows(given.k_u, known), known.scalars(given.f))
        self._holonomic = known.scalars(given.holonomic)
        self._motion = known.scalars(given.motion)
        parents = tree(given.frame)
        self._sets = euler_sets(parents, known)
        groups = list(dict.fromkeys(self._sets.values()))

        self.states = States(
            known.coordinates, known.speeds, self._kinematical, self._holonomic, self._motion, groups, known.others
        )
        kept = {g: keeps_length(known, self._kinematical, self.states, g) for g in groups}
        scaled = {f: g for f, g in self._sets.items() if not kept[g]}
        self._sets = {f: g for f, g in self._sets.items() if kept[g]}
        self._holonomic = [f for f in self._holonomic if not _is_length(f, [g for g in groups if kept[g]])]
        self._frames = Frames(given.frame, parents, self._sets, scaled, known, self.states, remarks)
        self.auxiliary = Auxiliary(given, self._frames, known, self.states, remarks, reactions)
        self._points = Points(given.frame, self._frames, self.auxiliary, known, self.states, remarks)

    def system(self) -> System:
        """The system."""
        names = FreeNames()
        bodies = [self._body(b, names.free(str(b.name))) for b in self._given.bodies]
        loads = [self._load(place, vector, names) for place, vector in self._given.loads]
        if self._given.lagrangian is not None:
            loads += self._potential()
        for b in self._given.bodies:
            if hasattr(b, "frame"):
                self._compare_spin(b.frame)
        found = self._definitions()
        configuration = [configuration_constraint(f"configuration {k}", f) for k, f in enumerate(self._holonomic, 1)]
        rows = {f"motion {k}": found.in_rates(f) for k, f in self._independent_motion_constraints()}
        rows |= {f"{w.description.removeprefix('vanishes: ')} ({w.name})": row for w, row in found.vanishing.items()}
        motion = [motion_constraint(name, row) for name, row in rows.items()]
        dependent = self._dependent(found, len(configuration) + len(motion))
        frames = self._frames
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KaneWarning)
            return System(
                frames.inertial, bodies=bodies, speeds=found.speeds | found.vanishing, loads=loads,
                coordinates=[*self.known.coordinates, *found.coordinates], holonomic=configuration, nonholonomic=motion,
                dependent_speeds=dependent, reactions=self.auxiliary.reactions, auxiliary_speeds=self.auxiliary.speeds,
            )  # fmt: skip

    def tie(self, inputs: Sequence[Symbol]) -> None:
        """Identifies functions of time that only accelerations contain with rates of those in velocities, if both then agree."""
        held = set(inputs)
        for b in self._given.bodies:
            given = b.masscenter._acc_dict.get(self._given.frame)
            told = [] if given is None else self._frames.vector(given).components(self._frames.inertial)
            alone = [s for s in free_symbols(told) if isinstance(s, Input) and s not in held]
            if not alone:
                continue
            gap = self._gap(b)
            rates = [s for s in free_symbols(gap) if isinstance(s, Rate) and isinstance(s.place, Input)]
            for chosen in permutations(rates, len(alone)) if len(rates) <= _MOST_TIED else ():
                if self.states.vanish([substituted(x, dict(zip(alone, chosen, strict=True))) for x in gap]):
                    for s, r in zip(alone, chosen, strict=True):
                        self.states.values[s] = self.states.of([r])[0]
                        self.remarks.say(
                            "inferred", f"{s.name} is the rate of {r.place}, in an acceleration given by hand"
                        )
                    break

    def _gap(self, body: Any) -> list[Expr]:
        """The rate of a mass centre's velocity minus its acceleration, along the inertial axes."""
        inertial = self._frames.inertial
        v, a = (self._frames.vector(x(self._given.frame)) for x in (body.masscenter.vel, body.masscenter.acc))
        return [self._at_rates(x) for x in (v.dt(inertial) - a).components(inertial)]

    def cause(self) -> str:
        """A sentence that explains why SymPy's equations may differ; "" if no reason is known."""
        if self._given.lagrangian is not None and self._frames.further:
            return (
                "velocities in the kinetic energy satisfy motion constraints that the coordinates do not, and for such a Lagrangian "
                "Lagrange's equations do not hold. Use KanesMethod, or a Lagrangian of unconstrained rates with nonhol_coneqs."
            )
        inertial, named = self._frames.inertial, []
        for b in self._given.bodies:
            a = self._frames.vector(b.masscenter.acc(self._given.frame))
            if not self.states.vanish(self._gap(b), map(self._at_rates, a.components(inertial))):
                named.append(str(b.masscenter))
        held = [self._slopes(f, self.known.speeds) for f in self._motion]
        if any(not _follows(self._by_speeds(time_derivative(f)), held) for f in self._holonomic):
            return "velocity constraints do not include the rates of all configuration constraints, and SymPy uses only the former."
        if named:
            return f"the acceleration that {', '.join(named)} was given is not the rate of the velocity."
        return ""

    def _at_rates(self, e: Expr) -> Expr:
        """`e` with q̈ expressed by u̇, which has arbitrary values."""
        if self._second is None:
            k_q, k_u, f = self._kinematical
            q, u = self.known.coordinates, self.known.speeds
            rows = [
                sum((a * rate(x) for a, x in zip(k_q[i], q, strict=True)), f[i])
                + sum((a * x for a, x in zip(k_u[i], u, strict=True)), ZERO)
                for i in range(len(q))
            ]
            changes = [substituted(time_derivative(row), {rate(rate(x)): ZERO for x in q}) for row in rows]
            solved = solve_linear(k_q, [-x for x in changes])
            for s in u:
                self.states.values.setdefault(rate(s), np.linspace(0.3, 0.9, self.states.of([ONE]).shape[1]))
            self._second = {rate(rate(x)): y for x, y in zip(q, solved, strict=True)}
        return substituted(e, self._second)

    def _definitions(self) -> Definitions:
        sets = {group: self._frames.frame(f).orientation.quasi for f, group in self._sets.items()}  # type: ignore[union-attr]
        result = define(self.known, self._kinematical, sets, self.states, self.remarks)
        follow(result, self._frames.further, self.known)
        return result

    def _dependent(self, found: Definitions, rows: int) -> list[Speed]:
        """SymPy's dependent speeds and the vanishing ones, if they are as many as the constraints; else none, for automatic choice."""
        known = dict(zip(self._given.u, self.known.speeds, strict=True))
        listed = [*(known[u] for u in self._given.dependent_u), *found.vanishing]
        return listed if len(listed) == rows else []

    def _body(self, b: Any, name: str) -> Body:
        mass, center = self.known.scalar(b.mass), self._points.point(b.masscenter)
        if not hasattr(b, "frame") or getattr(b, "is_rigidbody", True) is False:
            return Particle(name, center, mass)
        frame = self._frames.frame(b.frame)
        about = b.inertia[1]
        if about is not b.masscenter:
            self.remarks.say("changed", f"the inertia of {name} about {about} to the central one")
        inertia = self._frames.dyadic(b.central_inertia, frame)
        return RigidBody(name, frame=frame, mass_center=center, mass=mass, inertia=inertia)

    def _load(self, place: Any, vector: Any, names: FreeNames) -> Load:
        v = self._frames.vector(vector)
        if hasattr(place, "_pos_dict"):
            return Force(self._points.point(place), v, names.free(f"force on {place.name}").replace("_", " "))
        self._compare_spin(place)
        return Torque(self._frames.frame(place), v, names.free(f"torque on {place.name}").replace("_", " "))

    def _compare_spin(self, theirs: Any) -> None:
        """Raises unless an angular velocity that was set agrees with the orientation."""
        inertial = self._frames.inertial
        said = self._frames.vector(theirs.ang_vel_in(self._given.frame)).components(inertial)
        turned = self._frames.frame(theirs).angular_velocity(inertial).components(inertial)
        difference = [a - b for a, b in zip(said, turned, strict=True)]
        if not self.states.vanish(difference, [*said, *turned]):
            a, b = self.states.of(said)[:, 0], self.states.of(turned)[:, 0]
            raise ModelError(
                f"Expected the angular velocity of {theirs} in {self._given.frame} that its orientation has, {_numbers(b)} along "
                f"{self._given.frame} at a random state, got {_numbers(a)}: {cut(theirs.ang_vel_in(self._given.frame), 120)}. SymPy's "
                "equations contradict its orientations. Correct the one or the other; where a function stands for the time, write t."
            )

    def _potential(self) -> list[Load]:
        """V = T − L as loads; raises if it depends on rates."""
        import sympy

        given = self._given
        energy = sum((b.kinetic_energy(given.frame) for b in given.bodies), sympy.S.Zero)
        still = dict.fromkeys(given.u, sympy.S.Zero)
        v = self.known.scalar(energy.xreplace(still) - given.lagrangian.xreplace(still))
        whole = self.known.scalar(energy) - self.known.scalar(given.lagrangian)
        if not self.states.vanish([whole - v], [whole, self.known.scalar(energy)]):
            raise ModelError(
                "Expected a Lagrangian L = T − V with the kinetic energy T of the bodies and a potential V of coordinates and time, "
                "got one whose T − L depends on rates. Give all bodies that it was derived from."
            )
        self.remarks.say("inferred", "the potential energy as T − L")
        return (
            []
            if self.states.vanish([v]) and not any(isinstance(s, Coordinate) for s in free_symbols([v]))
            else [Load.from_potential(v)]
        )

    def _independent_motion_constraints(self) -> list[tuple[int, Expr]]:
        """The motion constraints that are not the rates of configuration constraints."""
        rates = [self._by_speeds(time_derivative(f)) for f in self._holonomic]
        speeds = list(self.known.speeds)
        held = [self._slopes(f, speeds) for f in rates]
        kept: list[tuple[int, Expr]] = []
        for k, f in enumerate(self._motion, 1):
            row = self._slopes(f, speeds)
            if held and _follows(row, held):
                self.remarks.say(
                    "changed", f"the velocity constraint {k} is left out: it is the rate of configuration constraints"
                )
                continue
            held.append(row)
            kept.append((k, f))
        return kept

    def _by_speeds(self, e: Expr) -> Array:
        """∂e/∂u at the states, for an expression affine in q̇ = W u + X."""
        q = list(self.known.coordinates)
        slopes = self.states.of(gradient(e, [rate(x) for x in q]))
        by_u = rates_by_speeds(self.known, self._kinematical, self.states)
        return np.asarray(np.einsum("qs,qus->us", slopes, by_u))

    def _slopes(self, f: Any, speeds: Sequence[Speed]) -> Any:
        return f if isinstance(f, np.ndarray) else self.states.of(gradient(f, speeds))


def _follows(row: Any, held: Sequence[Any]) -> bool:
    """Whether a row is a linear combination of others at all states."""
    for k in range(row.shape[1]):
        if not held:
            return not np.any(row)
        others = np.array([h[:, k] for h in held])
        a = np.vstack([others, row[:, k]])
        if singular(balanced(a)).rank(SPEEDS_RANK) > singular(balanced(others)).rank(SPEEDS_RANK):
            return False
    return True


def _rows(matrix: Any, known: Translation) -> list[list[Expr]]:
    return [[known.scalar(x) for x in matrix.row(i)] for i in range(matrix.rows)]


def _is_length(f: Expr, groups: Sequence[tuple[Coordinate, ...]]) -> bool:
    """Whether f = 0 is the unit length of Euler parameters, which kane's satisfy anyway."""
    own = free_symbols([f])
    for group in groups:
        if set(own) == set(group):
            e = np.random.default_rng(1).uniform(0.2, 1.2, (4, 5))
            e /= np.linalg.norm(e, axis=0)
            return bool(np.abs(evaluate(f, dict(zip(group, e, strict=True)))).max() < EQUAL)
    return False


def _numbers(x: Any) -> str:
    return "(" + ", ".join(f"{v:.6g}" for v in x) + ")"


_UNKNOWN_CAUSE = "look for acceleration constraints that were given, and matrices that were changed."


def theirs(given: Given, known: Translation, states: States) -> tuple[Array, Array]:
    """u̇ from SymPy's matrices (speeds × states), and their reciprocal condition numbers."""
    mass, forcing = given.matrices()
    rows, columns = mass.shape
    m = states.of(known.scalars(mass)).reshape(rows, columns, -1)
    f = states.of(known.scalars(forcing)).reshape(rows, -1)
    n = len(given.u)
    found, condition = np.full((n, m.shape[2]), np.nan), np.zeros(m.shape[2])
    for k in range(m.shape[2]):
        a, size = m[:, :, k], np.abs(m[:, :, k]).max(axis=1, keepdims=True, initial=0)
        if np.isfinite(a).all() and np.isfinite(f[:, k]).all() and (size > 0).all():
            condition[k] = 1 / np.linalg.cond(a / size)
            if condition[k] > SOLVE_RANK:
                found[:, k] = np.linalg.solve(a / size, f[:, k] / size[:, 0])[:n]
    return found, condition


def ours(eom: Equations, sought: Sequence[Symbol], states: States) -> Array:
    """u̇ and reactions of the imported system (speeds and reactions × states)."""
    values, system = states.values, eom.system
    states.of(
        [*system.parameters, *(s for s in system.inputs if isinstance(s, Input))]
    )  # draws values for symbols that occur only in loads
    q, parameters, inputs = (
        {s: values[s] for s in x if s in values} for x in (system.coordinates, system.parameters, system.inputs)
    )
    u = {s: values.get(s, np.zeros(COUNT)) for s in system.speeds}
    wanted = [rate(s) if isinstance(s, Speed) else s for s in sought]
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", KaneWarning
        )  # speeds that violate a constraint give different accelerations, which is reported
        found = eom.evaluate(wanted, q=q, u=u, parameters=parameters, inputs=inputs, t=values.get(time, 0.0))
    return np.array(np.broadcast_arrays(*found, np.zeros(COUNT))[:-1])


def check_accelerations(
    given: Given,
    eom: Equations,
    known: Translation,
    states: States,
    remarks: Remarks,
    auxiliary: Auxiliary,
    cause: Callable[[], str],
) -> None:
    """Compares accelerations; a ModelError shows the largest difference and the `cause`, if it is known."""
    got = ours(eom, (*known.speeds, *auxiliary.reactions), states)
    states.values.update(zip(auxiliary.reactions, got[len(known.speeds) :], strict=True))
    expected, condition = theirs(given, known, states)
    usable = np.isfinite(expected).all(axis=0)
    if not usable.any():
        remarks.say(
            "refused", "the comparison of accelerations: SymPy's matrices are singular or not finite at random states"
        )
        return
    got = got[: len(known.speeds)]
    size = np.maximum(np.abs(expected).max(axis=0), np.abs(got).max(axis=0))
    tolerance = np.maximum(EQUAL, 1000 * LAST_DIGIT / np.maximum(condition, LAST_DIGIT)) * np.maximum(size, 1e-6)
    off = np.where(usable, np.abs(got - expected) / tolerance, 0.0)
    off = np.where(np.isnan(off), np.inf, off)
    if off.max(initial=0) > 1:
        r, k = np.unravel_index(int(np.argmax(off)), off.shape)
        said = _difference(known.speeds[r].name, float(got[r, k]), float(expected[r, k]), states, int(k))
        raise ModelError(
            f"{said} {cause() or _UNKNOWN_CAUSE} Pass check=False to import the bodies, loads and constraints as they are."
        )
    if auxiliary.reactions:
        left = auxiliary.equations_left({rate(s): x for s, x in zip(known.speeds, got, strict=True)})
        if left > ROUNDED_ROOT:
            raise ModelError(
                f"Expected reactions that satisfy SymPy's auxiliary equations, got a residual of {left:.3g} of their terms. "
                "Pass check=False to import the bodies, loads and constraints as they are."
            )
    share = float((np.abs(got - expected)[:, usable] / np.maximum(size, 1e-6)[usable]).max())
    remarks.say(
        "checked",
        f"accelerations equal SymPy's to {max(share, 1e-16):.0e} of the largest at {usable.sum()} random states",
    )


def _difference(speed: str, got: float, expected: float, states: States, k: int) -> str:
    shown = ", ".join(
        f"{s.name} = {x[k]:.4g}"
        for s, x in states.values.items()
        if isinstance(s, Coordinate | Speed | Parameter | Input) and not isinstance(s, Rate)
    )
    return (
        f"Expected the accelerations of SymPy's equations, got {speed}' = {got:.9g} from the bodies, positions, loads and constraints "
        f"where SymPy's matrices give {expected:.9g}, at {shown}. Its equations contradict the model that they were derived from:"
    )

# SPDX-License-Identifier: BSD-3-Clause
"""Every system of the gallery with each of its choices of speeds, and random states given as (q, q')."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

import kane as kn
from kane.gallery import load, rolling_disk

Array = Any
Range = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Case:
    """A system of the gallery: one `kn.System` for each name in `speeds`, and where its coordinates may be.

    Angles are drawn from ±3, other coordinates from ±1 and rates from ±`pace`, unless `ranges` says otherwise by name.
    Simulations start from the state that the seed `start` draws: one from which the motion stays regular.
    """

    name: str
    build: Callable[[str], kn.System]
    speeds: tuple[str, ...]
    ranges: Mapping[str, Range] = field(default_factory=dict)
    pace: float = 2.0
    start: int = 2

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, eq=False)
class States:
    """Values of the coordinates, of their rates, and of the quasi-rates of Euler parameters; `count` of each."""

    count: int
    q: dict[Any, Array]
    rates: dict[Any, Array]
    quasi: dict[Any, Array]
    t: Array

    def speeds(self, system: kn.System) -> dict[Any, Array]:
        """u = Y q' + z, by the definitions themselves."""
        values = {**self.q, **{q.dt: v for q, v in self.rates.items()}, **self.quasi, kn.time: self.t}
        found = kn.evaluate(list(system.speeds.values()), values)
        return {u: np.broadcast_to(v, (self.count,)) for u, v in zip(system.speeds, found, strict=True)}

    def evaluate(self, eom: kn.Equations, exprs: Sequence[Any], **more: Any) -> Array:
        """Values (number of expressions, states)."""
        values = eom.evaluate(list(exprs), q=self.q, u=self.speeds(eom.system), t=self.t, **more)
        return np.array([np.broadcast_to(v, (self.count,)) for v in values]).reshape(len(exprs), self.count)

    def matrix(self, eom: kn.Equations, matrix: kn.Matrix) -> Array:
        """Values (states, rows, columns)."""
        rows, columns = matrix.shape
        flat = self.evaluate(eom, [x for row in matrix for x in row])
        return np.moveaxis(flat.reshape(rows, columns, self.count), -1, 0)


def random_states(case: Case, count: int, seed: int = 0) -> States:
    """Random configurations and rates of a case."""
    rng = np.random.default_rng([seed, *case.name.encode()])
    system = case.build(case.speeds[0])
    q: dict[Any, Array] = {}
    rates: dict[Any, Array] = {}
    quasi: dict[Any, Array] = {}
    for euler in system.euler_parameters:
        e = rng.normal(size=(4, count))
        e /= np.linalg.norm(e, axis=0)
        w = rng.uniform(-case.pace, case.pace, (3, count))
        q.update(zip(euler.coordinates, e, strict=True))
        rates.update(zip(euler.coordinates, euler_rates(e, w), strict=True))
        quasi.update(zip(euler.quasi, w, strict=True))
    for x in system.coordinates:
        if x not in q:
            usual = (-3.0, 3.0) if x.unit == "rad" else (-1.0, 1.0)
            q[x] = rng.uniform(*case.ranges.get(x.name, usual), count)
            rates[x] = rng.uniform(*case.ranges.get(f"{x.name}'", (-case.pace, case.pace)), count)
    ordered = {x: q[x] for x in system.coordinates}
    return States(count, ordered, {x: rates[x] for x in ordered}, quasi, rng.uniform(0, 2, count))


def euler_rates(e: Array, w: Array) -> Array:
    """e' = e ∘ (0, w)/2, the quaternion product, w along the body's axes."""
    scalar = -(e[1:] * w).sum(axis=0)
    return 0.5 * np.concatenate([scalar[None], e[0] * w + np.cross(e[1:], w, axis=0)])


def with_speeds(system: kn.System, speeds: Any) -> kn.System:
    """The same system with other generalized speeds."""
    return kn.System(
        system.inertial,
        bodies=system.bodies,
        speeds=speeds,
        loads=[*system.gravities, *system.loads],
        reactions=system.reactions,
        auxiliary_speeds=system.auxiliary_speeds,
        events=system.events,
        coordinates=system.coordinates,
    )


def sliding_disk(speeds: str) -> kn.System:
    """The disk with the article's speeds, the rates, or the velocity of its lowest particle along and across the track."""
    if speeds == "rates":
        return rolling_disk.model(speeds="rates").system
    model = rolling_disk.model()
    if speeds == "components":
        return model.system
    w, v = model.C.angular_velocity(model.N), model.Ch.velocity(model.N)
    B, Y = model.B, model.Y
    definitions = (w.dot(B.x), w.dot(B.y), w.dot(B.z), v.dot(Y.x), v.dot(Y.y))
    return with_speeds(model.system, dict(zip(model.u, definitions, strict=True)))


def _case(label: str, name: str, ranges: Mapping[str, Range] | None = None, pace: float = 2.0, **options: Any) -> Case:
    module = load(name)

    def build(speeds: str) -> kn.System:
        system: kn.System = module.system(speeds=speeds, **options)
        return system

    return Case(label, build, module.SPEEDS, ranges or {}, pace)


OFF_AXIS = {"x": (0.3, 1.2), "y": (-1.2, -0.3)}
CASES = (
    _case("particle on a spring in space", "particle_on_spring", OFF_AXIS),
    _case("particle on a spring in a plane", "particle_on_spring", OFF_AXIS, dimensions=2),
    _case("pendulum", "pendulum"),
    _case("double pendulum of rods", "double_pendulum"),
    _case("double pendulum of particles", "double_pendulum", bobs=True),
    _case("three links, absolute angles", "pendulums", n=3),
    _case("three links, relative angles", "pendulums", n=3, relative=True),
    _case("three links on a cart", "pendulums", n=3, relative=True, cart=True),
    _case("pendulum on a cart", "pendulum_on_cart"),
    _case("spherical pendulum", "spherical_pendulum", {"theta": (0.3, 1.2)}),
    _case("top", "spinning_top", {"theta": (0.3, 2.8)}, pace=10.0),
    _case("free body", "free_body"),
    _case("free body that falls", "free_body", gravity=True),
    _case("gyroscope", "gimbal_gyroscope", {"q2": (-1.0, 1.0), "q3'": (40, 90)}),
    Case("sliding disk", sliding_disk, ("components", "rates", "contact"), {"q2": (-1.0, 1.0)}, start=3),
)


@cache
def equations(case: Case, speeds: str) -> kn.Equations:
    """The derived equations, made once."""
    return kn.derive(case.build(speeds))


def case_of(name: str) -> Case:
    """The case of that name."""
    return next(c for c in CASES if c.name == name)

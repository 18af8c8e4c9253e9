# SPDX-License-Identifier: BSD-3-Clause
"""Models about random axes behave as those about basis axes do: what rounding leaves of zero is taken for no structure.

Directions are unit vectors in numbers: perpendicular ones have a scalar product of 1e-17, and points on an axis such a velocity. What
follows from the geometry is known: which constraints are redundant, which reactions act, that a spring has its potential.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples
from tests.oracles.tree import Array

SEEDS = st.integers(0, 2**32 - 1)
CLOSURES = ("pin", "slider", "cylindrical", "screw", "universal", "ball", "planar", "weld")
MOVES = {"pin": 1, "slider": 1, "cylindrical": 2, "screw": 1, "universal": 2, "ball": 3, "planar": 3, "weld": 0}


def unit(rng: np.random.Generator, across: Array | None = None) -> Array:
    """A unit vector at random, perpendicular to another one if asked."""
    v = rng.normal(size=3)
    v = v if across is None else np.cross(across, v)
    return np.asarray(v / np.linalg.norm(v))


def vector(frame: kn.Frame, v: Array) -> kn.Vector:
    """The vector with these measure numbers."""
    x, y, z = map(float, v)
    return x * frame.x + y * frame.y + z * frame.z


def body(name: str, frame: kn.Frame, center: kn.Point) -> kn.RigidBody:
    """A body of some mass and inertia."""
    return kn.RigidBody(name, frame=frame, mass_center=center, mass=1.3, inertia=kn.inertia(frame, 0.1, 0.2, 0.25))


@dataclass
class Loop:
    """A chain from the ground that is closed at known coordinates q."""

    system: kn.System
    q: dict[Any, float]
    rows: Array
    """Sizes of the constraints, lengths and cosines."""
    columns: Array
    """Sizes of the coordinates, lengths and angles."""


def loop(seed: int) -> Loop:
    """A chain of pins and sliders, all about one axis and across it or about axes of their own, closed by one of the joints."""
    rng = np.random.default_rng(seed)
    planar, kind = bool(rng.integers(2)), CLOSURES[rng.integers(len(CLOSURES))]
    common, scale = unit(rng), 10.0 ** rng.uniform(-3, 3)
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    at, frame, joints, bodies = O, N, list[kn.Joint](), list[kn.RigidBody]()
    for k in range(3 if planar else 7 - MOVES[kind]):
        slides = rng.random() < 0.25
        axis = unit(rng) if not planar else unit(rng, common) if slides else common
        joint = (kn.slider if slides else kn.pin)(f"J{k}", at, frame, axis=vector(frame, axis))
        joints.append(joint)
        frame = joint.frame
        bodies.append(body(f"B{k}", frame, joint.point.at(f"C{k}", vector(frame, scale * rng.normal(size=3)))))
        at = joint.point.at(f"E{k}", vector(frame, scale * rng.normal(size=3)))
    q = {s: rng.uniform(-1, 1) * (scale if j.kind == "slider" else 1.0) for j in joints for s in j.coordinates}
    place = np.array(kn.evaluate(list(at.position(O).components(N)), q), dtype=float)
    turn = np.array(kn.evaluate(N.dcm(frame), q), dtype=float)
    ground = N.rotate_matrix("G", turn)
    axis = (
        turn.T @ common if planar else unit(rng)
    )  # along the common axis, whose numbers every frame of the chain shares
    along = vector(ground, axis)
    G = O.at("G", vector(N, place))
    more: dict[str, Any] = {"axis": along}
    if kind in ("ball", "weld"):
        more = {}
    elif kind == "planar":
        more = {"normal": along}
    elif kind == "universal":
        more = {"axes": (along, vector(ground, unit(rng, axis)))}
    elif kind == "screw":
        more["pitch"] = scale * rng.uniform(0.1, 0.3)
    rows = getattr(kn, f"close_{kind}")("G", G, ground, at, frame, **more)
    gravity = kn.gravity(-9.81 * scale * N.z)
    lengths = [scale if c.unit == "N" else 1.0 for c in rows], [scale if j.kind == "slider" else 1.0 for j in joints]
    return Loop(kn.System(N, bodies=bodies, joints=joints, holonomic=rows, loads=[gravity]), q, *map(np.array, lengths))


def check_loop(seed: int) -> None:
    """Derived, with and without a place, assembled and evaluated without a refusal; of warnings the redundancy that there is."""
    made = loop(seed)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        eom = kn.derive(made.system)
        near = kn.derive(made.system, near=made.q)
        found = kn.assemble(eom, q=made.q)
        kn.assemble(near, q={s: kn.guess(v + 0.01) for s, v in made.q.items()} | dict([next(iter(made.q.items()))]))
    a = np.asarray(near.evaluate(near.A, q=found.q, u=found.u), dtype=float) * made.columns / made.rows[:, None]
    rank = int(np.linalg.matrix_rank(a, tol=1e-9))
    assert len(near.dependent_speeds) == rank
    said = [str(w.message) for w in caught]
    assert all("redundant" in text for text in said), said
    assert bool(said) == (rank < len(a)), said
    assert (
        np.isfinite(np.array(near.evaluate(list(near.accelerations), q=found.q, u=found.u), dtype=float)).all()
        or rank == a.shape[1]
    )


@cache
def held_ball() -> kn.Equations:
    """A body on a ball joint, oriented by Euler parameters, whose tip a rod holds at a slide that follows."""
    rng = np.random.default_rng(3)
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    ball = kn.ball("A", O, N)
    tip = ball.point.at("P", vector(ball.frame, unit(rng)))
    slide = kn.slider("B", O.at("F", vector(N, 4 * unit(rng))), N, axis=vector(N, unit(rng)))
    bodies = [body("A", ball.frame, tip), body("B", slide.frame, slide.point)]
    rod = kn.distance(slide.point, tip, kn.parameter("L", 4.0, "m"))
    return kn.derive(kn.System(N, bodies=bodies, joints=[ball, slide], holonomic=rod))


def check_complete(seed: int) -> None:
    """A state that is given whole is a start; so are Euler parameters, of unit length but for rounding, where the rest follows."""
    rng = np.random.default_rng(seed)
    eom = held_ball()
    e = rng.normal(size=4)
    x = float(rng.normal())
    q = dict(zip(eom.coordinates, (*e / np.linalg.norm(e), x), strict=True))
    (rod,), (L,) = eom.system.holonomic, eom.parameters
    (one, _), (other, _) = rod.forces
    gap = one.position(other)
    length = {L: float(np.sqrt(kn.evaluate(gap.dot(gap), q)))}
    u = kn.assemble(eom, q=q, u={s: kn.guess(float(rng.normal())) for s in eom.speeds}, parameters=length).u
    again = kn.assemble(eom, q=q, u=u, parameters=length)
    assert [again.q[s] for s in q] == pytest.approx(list(q.values()), rel=1e-12)
    part = kn.assemble(eom, q=q | {eom.coordinates[-1]: kn.guess(x)}, u=u, parameters=length)
    assert part.q[eom.coordinates[-1]] == pytest.approx(x, rel=1e-6)


def check_reaction(seed: int) -> None:
    """The weight that a slide across it carries, along a random axis, is what its reaction says; along the slide there is none."""
    rng = np.random.default_rng(seed)
    axis = unit(rng)
    across, pull = unit(rng, axis), rng.normal(size=3)
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    home = N if rng.random() < 0.5 else N.rotate("A", float(rng.normal()), vector(N, unit(rng)))
    slide = kn.slider("B", O, home, axis=vector(home, axis))
    bodies = [kn.Particle("B", slide.point, 1.3)]
    force = kn.Force(slide.point, vector(home, pull))
    held = kn.reaction("R", at=slide.point, along=vector(home, across))
    eom = kn.derive(kn.System(N, bodies=bodies, joints=[slide], reactions=[held], loads=[force]))
    q, u = [float(rng.normal())], [float(rng.normal())]
    (found,) = eom.evaluate([held], q=q, u=u)
    assert float(found) == pytest.approx(-pull @ across, abs=1e-12)
    along = kn.reaction("S", at=slide.point, along=vector(home, axis))
    with pytest.raises(kn.ReactionError, match="moves freely"):
        kn.derive(kn.System(N, bodies=bodies, joints=[slide], reactions=[along], loads=[force]))


def check_potential(seed: int) -> None:
    """A spring has its potential wherever its ends are, on the axis too; one of another sign is still told from it."""
    rng = np.random.default_rng(seed)
    axis, kind = unit(rng), ("pin", "slider", "cylindrical")[rng.integers(3)]
    scale = 10.0 ** rng.uniform(-3, 3)
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    joint = getattr(kn, kind)("B", O, N, axis=vector(N, axis))
    ends = [scale * (axis * rng.uniform(0.2, 2) if rng.random() < 0.5 else rng.normal(size=3)) for _ in range(2)]
    end, far = joint.point.at("P", vector(joint.frame, ends[0])), O.at("F", vector(N, ends[1]))
    free = scale * rng.uniform(0.1, 0.5) if rng.random() < 0.5 else 0
    spring = kn.linear_spring(end, far, 10.0 ** rng.uniform(-3, 3), free)
    bodies = [body("B", joint.frame, joint.point.at("C", vector(joint.frame, scale * rng.normal(size=3))))]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        eom = kn.derive(kn.System(N, bodies=bodies, joints=[joint], loads=[spring]))
    still = {"q": [0.3] * len(eom.coordinates), "u": [0] * len(eom.speeds)}
    most = max(abs(float(x)) for x in eom.evaluate(list(eom.forcing), **still))
    if most > 1e-3 * scale:
        with pytest.warns(kn.KaneWarning, match="got another one"):
            kn.derive(kn.System(N, bodies=bodies, joints=[joint], loads=[replace(spring, potential=-spring.potential)]))


def check_decay(seed: int) -> None:
    """An energy that comes back to nearly nothing: the error of the work is a share of the work that was done, not of what is left."""
    rng = np.random.default_rng(seed)
    w, ratio, m = 10.0 ** rng.uniform(-0.5, 1), 10.0 ** rng.uniform(-1, 0.3), 10.0 ** rng.uniform(-2, 2)
    slow = w * ratio if ratio < 1 else w / (2 * ratio)
    t, at = kn.time, rng.uniform(0.5, 2) / w
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    slide = kn.slider("B", O, N, axis=vector(N, unit(rng)))
    (x,) = slide.coordinates
    pulse = kn.exp(-(((t - 3 * at) / at) ** 2))
    damping, push, pull = -2 * ratio * w * m * x.dt, m * w * w * rng.normal() * pulse, -m * w * w * x
    together: list[Any] = [
        [damping + push + pull],
        [damping + push, pull],
        [damping, push, pull],
        [damping + pull, push],
    ][rng.integers(4)]
    loads = [kn.Force(slide.point, f * slide.axis) for f in together]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("B", slide.point, m)], joints=[slide], loads=loads))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sol = kn.simulate(eom, (0, rng.uniform(5, 60) / slow), q=[0], u=[0], rtol=10.0 ** rng.uniform(-10, -6))
    assert sol.keeps_energy


CHECKS = [check_loop, check_complete, check_reaction, check_potential, check_decay]
FEW = {check_loop: 2, check_complete: 3, check_reaction: 3, check_potential: 2, check_decay: 2}


@pytest.mark.parametrize(
    ("check", "seed"), [pytest.param(c, k, id=f"{c.__name__[6:]}, {k}") for c in CHECKS for k in range(FEW[c])]
)
def test_a_few_about_random_axes(check: Callable[[int], None], seed: int) -> None:
    check(seed)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize(
    ("check", "count"),
    [(check_loop, 60), (check_complete, 200), (check_reaction, 100), (check_potential, 100), (check_decay, 100)],
)
def test_many_about_random_axes(check: Callable[[int], None], count: int) -> None:
    @examples(
        count / settings().max_examples, phases=[Phase.explicit, Phase.reuse, Phase.generate]
    )  # numbers from a seed do not shrink
    @given(SEEDS)
    def run(seed: int) -> None:
        check(seed)

    run()

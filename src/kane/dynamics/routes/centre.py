# SPDX-License-Identifier: BSD-3-Clause
"""The route by velocities of the mass centre: translations apart from the rest, as one writes the motion of one free body.

Where speeds u_k translate a body as a whole along directions n_k fixed in the inertial frame, the velocities of its mass centre
w_k = v^C*·n_k take their places. The other partial velocities of C* are then perpendicular to all n_k, M has the mass alone in the
rows of the w_k, and the acceleration of C* along n_k is ẇ_k. Loads are written by the declared speeds, as they are declared, and

    u̇_k = ẇ_k − n_k·(Σ v_r u̇_r + a_b)        with v_r of the other speeds and a_b of C*.
"""

from collections.abc import Mapping

from kane.dynamics.assembly import blocks, generalized_by_motion, mass_rows
from kane.dynamics.derivation import Derived, Exprs, by_other_speeds
from kane.dynamics.routes.block_solution import block_solution
from kane.dynamics.solved import Solved
from kane.expr.build import sub
from kane.expr.node import ONE, ZERO, Expr, constant_value
from kane.expr.symbols import Speed
from kane.expr.visit import substituted
from kane.kinematics.motion import velocity_form
from kane.space.point import Point
from kane.space.vector import Vector


def by_mass_centre(derived: Derived) -> tuple[Derived, Solved] | None:
    """The same by velocities of the mass centre, and u̇ and the reactions solved by them; None where nothing translates one body.

    What is divided by is not watched yet.
    """
    moved = _translating(derived)
    if moved is None:
        return None
    centre, directions = moved
    names = {u: Speed.declare(f"w{k + 1}", None, "", "velocity of the mass centre") for k, u in enumerate(directions)}
    velocity = centre.velocity(derived.system.inertial)
    definitions = {
        names.get(u, u): velocity.dot(directions[u]) if u in directions else e for u, e in derived.system.speeds.items()
    }
    twin = by_other_speeds(derived, definitions, derived.constraints)
    left = derived.left_by(twin.kinematics, twin.bodies)
    right = [generalized_by_motion(left, s) for s in twin.all_speeds]
    mass = mass_rows(twin.bodies, twin.speeds, twin.auxiliary_speeds)
    solution = block_solution(blocks(mass, right, twin.auxiliary_speeds, twin.reactions, twin.pairs))
    own = velocity_form(derived.kinematics.point(centre))
    values: dict[Expr, Expr] = {names[u]: own.dot(n) for u, n in directions.items()}
    memo: dict[Expr, Expr] = {}

    def by_declared(e: Expr) -> Expr:
        return substituted(e, values, memo)

    u_dot: dict[Expr, Expr] = dict(zip(derived.speeds, map(by_declared, solution.accelerations), strict=True))
    solution = solution._replace(
        accelerations=_declared(derived, centre, directions, u_dot),
        reactions=tuple(map(by_declared, solution.reactions)),
    )
    return twin, Solved("mass centre", derived, None, *solution)


def _translating(derived: Derived) -> tuple[Point, dict[Speed, Vector]] | None:
    """The mass centre of the only body, and the speeds that translate the body as a whole, with their directions."""
    if len(derived.bodies) != 1:
        return None
    ((_, part, centre, rotation, shared),) = derived.bodies
    if rotation is None or shared:
        return None
    turns, shifts = rotation.motion.partials, centre.partials
    directions = {u: shifts[u] for u in derived.speeds if u in shifts and u not in turns and _fixed(derived, shifts[u])}
    found = list(directions.values())
    apart = all(a.dot(b) is (ONE if a is b else ZERO) for a in found for b in found)
    others = any(u in shifts for u in derived.speeds if u in turns)
    return (part.mass_center, directions) if found and apart and others else None


def _fixed(derived: Derived, v: Vector) -> bool:
    """Whether the vector does not turn."""
    return all(
        f is derived.system.inertial and all(constant_value(x) is not None for x in triple) for f, triple in v.parts
    )


def _declared(derived: Derived, centre: Point, directions: Mapping[Speed, Vector], u_dot: Mapping[Expr, Expr]) -> Exprs:
    """u̇ of the declared speeds: those of the w_k less what the other speeds accelerate C* by."""
    motion = derived.kinematics.point(centre)
    others = sum(
        (v * u_dot[s] for s, v in motion.partials.items() if s in u_dot and s not in directions), start=motion.bias
    ).gathered()
    return tuple(sub(u_dot[u], directions[u].dot(others)) if u in directions else u_dot[u] for u in derived.speeds)

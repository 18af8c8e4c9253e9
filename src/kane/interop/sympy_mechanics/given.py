# SPDX-License-Identifier: BSD-3-Clause
"""The content of a SymPy model as one record, for all classes of models.

The kinematical equations are k_q q̇ + k_u u + f = 0, implicit as given; motion constraints are expressions that vanish.
"""

import copy
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from inspect import signature
from itertools import chain
from typing import Any

from kane import expect
from kane.errors import ModelError, cut


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """A SymPy model: frame, coordinates, speeds, kinematical equations, bodies, loads, constraints; `method` forms its equations."""

    source: str
    frame: Any
    q: tuple[Any, ...]
    u: tuple[Any, ...]
    k_q: Any
    k_u: Any
    f: tuple[Any, ...]
    bodies: tuple[Any, ...]
    loads: tuple[Any, ...]
    holonomic: tuple[Any, ...] = ()
    motion: tuple[Any, ...] = ()
    dependent_u: tuple[Any, ...] = ()
    auxiliary: tuple[Any, ...] = ()
    lagrangian: Any = None
    method: Any = None

    def matrices(self) -> tuple[Any, Any]:
        """M and f of SymPy's equations M (u̇, λ) = f, formed on a copy if necessary."""
        import sympy

        if self.method is None:
            raise ModelError("Expected a method that forms equations, got only bodies and loads.")
        method = copy.copy(self.method)
        if self.lagrangian is not None:
            if method.eom is None:
                method.form_lagranges_equations()
            if method.coneqs:
                lower = method._m_cd.row_join(sympy.zeros(len(method.coneqs)))
                return method.mass_matrix.col_join(lower), method.forcing.col_join(method._f_cd)
            return method.mass_matrix, method.forcing
        if not method._fr or not method._frstar:
            method.kanes_equations(list(self.bodies), list(self.loads) or None)
        return method.mass_matrix, method.forcing


def read(model: Any, loads: Any = None, bodies: Any = None, **stated: Any) -> Given:
    """The record of a KanesMethod, LagrangesMethod, System or JointsMethod, or of bodies with `loads` and the arguments `stated`."""
    import sympy.physics.mechanics as me

    if isinstance(model, Sequence) and not isinstance(model, str):
        expect.that(bodies is None, "no bodies= beside a list of them", bodies, "Put all bodies into the list.")
        return _bodies(model, loads, **stated)
    kind = type(model).__name__
    frame = stated.pop("frame", None) if isinstance(model, me.LagrangesMethod) else None
    expect.none(map(repr, stated), f"keywords for what a {kind} does not define", cure="Leave out the others.")
    if isinstance(model, me.KanesMethod):
        return _kane(model, bodies, loads)
    if isinstance(model, me.LagrangesMethod):
        return _lagrange(model, bodies, loads, frame)
    if isinstance(model, me.System):
        return _system(model, bodies, loads)
    if kind == "JointsMethod":
        return _joints(model, bodies, loads)
    raise ModelError(
        "Expected a KanesMethod, LagrangesMethod, System or JointsMethod of sympy.physics.mechanics, or a list of its bodies, got "
        f"{cut(repr(model))} ({type(model).__name__})."
    )


def _pairs(loads: Any) -> tuple[Any, ...]:
    """The loads as pairs of a point or frame and a vector; actuators are expanded."""
    each = (load.to_loads() if hasattr(load, "to_loads") else (load,) for load in loads or ())
    return tuple(chain.from_iterable(each))


def _kane(method: Any, bodies: Any, loads: Any) -> Given:
    own = method.bodies if bodies is None else bodies
    forces = method.forcelist if loads is None else loads
    cure = "Call kanes_equations(bodies, loads) first, or give bodies=[…]."
    expect.that(own, "a KanesMethod with its bodies", came="one without", cure=cure)
    expect.that(method._k_kqdot, "a KanesMethod with kinematical equations", came="one without kd_eqs")
    u = tuple(method.u)
    motion = tuple(method._k_nh * method.u + method._f_nh) if method._k_nh else ()
    return Given(
        f"KanesMethod in {method._inertial}", method._inertial, tuple(method.q), u,
        method._k_kqdot_implicit, method._k_ku_implicit, tuple(method._f_k_implicit), tuple(own), _pairs(forces),
        tuple(method._f_h), motion, tuple(method._udep), tuple(method._uaux), None, method,
    )  # fmt: skip


def _rates(q: Sequence[Any]) -> tuple[Any, Any, tuple[Any, ...]]:
    """q̇ − u = 0 for speeds that are the rates."""
    import sympy

    return sympy.eye(len(q)), -sympy.eye(len(q)), (sympy.S.Zero,) * len(q)


def _lagrange(method: Any, bodies: Any, loads: Any, frame: Any = None) -> Given:
    own = method.bodies if bodies is None else bodies
    cure = "Give them: from_sympy_mechanics(method, bodies=[…]). The kinetic energy alone does not define the bodies."
    expect.that(own, "a LagrangesMethod with its bodies", came="one without", cure=cure)
    frame = method.inertial or frame
    cure = "Give the inertial frame: from_sympy_mechanics(method, bodies=[…], frame=N)."
    expect.that(frame, "a LagrangesMethod with frame=", came="one without", cure=cure)
    q, held = tuple(method.q), len(method._hol_coneqs)
    return Given(
        f"LagrangesMethod in {frame}", frame, q, tuple(method._qdots), *_rates(q), tuple(own),
        _pairs(method.forcelist if loads is None else loads), tuple(method._hol_coneqs), tuple(method.coneqs)[held:],
        lagrangian=method._L[0], method=method,
    )  # fmt: skip


def _system(system: Any, bodies: Any, loads: Any) -> Given:
    import sympy.physics.mechanics as me

    if isinstance(system._eom_method, me.LagrangesMethod):
        return _lagrange(system._eom_method, bodies, loads)
    bodies = system.bodies if bodies is None else bodies
    loads = _pairs((*system.loads, *system.actuators) if loads is None else loads)
    if system._eom_method is not None:
        return _kane(system._eom_method, bodies, loads)
    method = me.KanesMethod(
        system.frame, system.q_ind, system.u_ind, kd_eqs=system.kdes, q_dependent=system.q_dep,
        u_dependent=system.u_dep, configuration_constraints=system.holonomic_constraints,
        velocity_constraints=system.velocity_constraints, u_auxiliary=system.u_aux, forcelist=loads or None,
        bodies=bodies, explicit_kinematics=False,
    )  # fmt: skip
    return _kane(method, bodies, loads)


def _joints(model: Any, bodies: Any, loads: Any) -> Given:
    import sympy.physics.mechanics as me

    if isinstance(model.method, me.LagrangesMethod):
        return _lagrange(model.method, bodies, loads)
    made = model
    if model.method is None:
        made = copy.copy(model)
        made.form_eoms()
    return _kane(made.method, bodies, loads)


def _bodies(
    bodies: Sequence[Any], loads: Any, frame: Any = None, q: Any = (), u: Any = (), kd_eqs: Any = (), **rest: Any
) -> Given:
    import sympy.physics.mechanics as me

    expect.that(bodies, "bodies in the list", came="none")
    cure = "from_sympy_mechanics(bodies, loads, frame=N, q=[q1, …], u=[u1, …], kd_eqs=[q1.diff() - u1, …])"
    expect.that(isinstance(frame, me.ReferenceFrame), "the inertial frame= of a list of bodies", frame, f"Call {cure}.")
    known = signature(me.KanesMethod).parameters.keys() - {"frame", "q_ind", "u_ind", "bodies", "forcelist"}
    expect.none([repr(k) for k in rest if k not in known], "keywords that KanesMethod takes", cure=f"Call {cure}.")
    expect.that(u or not kd_eqs, "speeds u= beside kd_eqs=", came="none", cure=f"Call {cure}.")
    q = tuple(q) or _coordinates_in(bodies, frame)
    if not u:
        u = tuple(me.dynamicsymbols(f"u_{x.func.__name__}") for x in q)
        kd_eqs = [x.diff() - s for x, s in zip(q, u, strict=True)]
    method = me.KanesMethod(
        frame, q, u, kd_eqs=list(kd_eqs), bodies=list(bodies), forcelist=list(_pairs(loads)) or None, **rest
    )
    return _kane(method, bodies, _pairs(loads))


def _coordinates_in(bodies: Sequence[Any], frame: Any) -> tuple[Any, ...]:
    """The functions of time in the orientations and positions from the inertial frame to the bodies, sorted by name."""
    from sympy.core.function import AppliedUndef

    offsets = [v for b in bodies for v in _offsets(b.masscenter, frame)]
    found = {x for v in offsets for m, _ in v.args for x in m.atoms(AppliedUndef)}
    parents, turned = tree(frame), {f for v in offsets for _, f in v.args}
    for own in turned.union(b.frame for b in bodies if hasattr(b, "frame")):
        while own in parents and own is not frame:
            child, (own, oriented) = own, parents[own]
            found |= own._dcm_dict[child].atoms(AppliedUndef) if oriented else set()
    return tuple(sorted(found, key=lambda x: (len(str(x)), str(x))))


def _offsets(center: Any, frame: Any) -> list[Any]:
    """The vectors from the nearest point at rest to a mass centre; its own position vectors if no path leads to one."""
    ways = paths_from(center)
    here = next((p for p in ways if p._vel_dict.get(frame) == 0), None)
    if here is None:
        return list(center._pos_dict.values())
    found = []
    while here is not center:
        found.append(ways[here]._pos_dict[here])
        here = ways[here]
    return found


# Frames and points as SymPy connects them ----------------------------------------------------------------------------


def tree(frame: Any) -> dict[Any, tuple[Any, bool]]:
    """The parent of each frame, and whether it is oriented in it: by orientations as far as possible, then by angular velocities."""
    parents: dict[Any, tuple[Any, bool]] = {frame: (None, True)}
    line = deque([frame])
    while line:
        own = line.popleft()
        fresh = [other for other in own._dcm_dict if other not in parents]
        parents |= dict.fromkeys(fresh, (own, True))
        line.extend(fresh)
        if not line:
            turning = ((a, b) for a in parents for b in a._ang_vel_dict if b not in parents)
            pair = next(turning, None)
            if pair is not None:
                parents[pair[1]] = (pair[0], False)
                line.append(pair[1])
    return parents


def paths_from(start: Any) -> dict[Any, Any]:
    """Each point that positions connect to a given one, nearest first, with its predecessor."""
    ways: dict[Any, Any] = {start: None}
    line = deque([start])
    while line:
        own = line.popleft()
        for other in own._pos_dict:
            if other not in ways:
                ways[other] = own
                line.append(other)
    return ways

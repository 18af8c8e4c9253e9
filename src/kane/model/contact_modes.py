# SPDX-License-Identifier: BSD-3-Clause
"""Constraints, friction loads, reactions and terminating events that contacts in given modes add to a system."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from kane.expr.build import add, div, mul, sqrt, sub, sum_of
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.symbols import Reaction
from kane.expr.visit import substituted
from kane.model.contacts import ContactLaw, ContactMode, Modes
from kane.model.declarations import EndOfMode, Event
from kane.model.loads import Load, Slip
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

_NO_FRICTION = 1e-300
"""Added to the divisor Σ μ_s N, so that the parts of a group's friction are zero, not NaN, if that sum is zero."""


def additions(contacts: Sequence[ContactLaw], modes: Modes) -> dict[str, list[Any]]:
    """Additional arguments of a system, by name: constraints, friction loads, reactions, and the events that end the modes."""
    result: dict[str, list[Any]] = {name: [] for name in ("holonomic", "nonholonomic", "loads", "reactions", "events")}
    forces = standing_forces(contacts, modes)
    for c, mode, group in zip(contacts, modes, groups(contacts, modes), strict=True):
        for name, items in _added(c, mode, group, forces):
            result[name] += items
    return result


class Stand(NamedTuple):
    """Contacts, by index, of one body with one plane of another, whose constraints are redundant.

    N_i = Σ w_i0k R_k over `normals`; F_ij = Σ w_ijk R_k over `along` for those that stick, with multipliers R of the constraint rows.
    """

    members: tuple[int, ...]
    normals: tuple[Expr, ...]
    along: tuple[Expr, ...]


def stands(contacts: Sequence[ContactLaw], modes: Modes) -> list[Stand]:
    """The redundant contacts of the modes, one `Stand` for each body and plane."""
    if all(mode < ContactMode.ACROSS for mode in modes):
        return []
    found: dict[Any, list[int]] = {}
    for i, (c, mode) in enumerate(zip(contacts, modes, strict=True)):
        if mode is not ContactMode.SEPARATED and c.gap is not None and c.between is not None:
            found.setdefault(c.between, []).append(i)
    made = []
    for members in found.values():
        if all(modes[i] < ContactMode.ACROSS for i in members):
            continue
        along: list[Expr] = []
        for i in members:
            along += contacts[i].friction_forces if modes[i] is ContactMode.STICK else ()
            across = contacts[i].across
            along += [across[1]] if across is not None and modes[i] is ContactMode.ACROSS else ()
        normals = [n for i in members if not modes[i].carried and (n := contacts[i].normal_force) is not None]
        made.append(Stand(tuple(members), tuple(normals), tuple(along)))
    return made


def standing_forces(contacts: Sequence[ContactLaw], modes: Modes) -> dict[Expr, Expr]:
    """N, and F of contacts that stick, in terms of multipliers, for all contacts of stands."""
    forces: dict[Expr, Expr] = {}
    for stand in stands(contacts, modes):
        for c, mode in ((contacts[i], modes[i]) for i in stand.members):
            assert c.normal_force is not None
            pairs = [(c.normal_force, c.shares[0], stand.normals)]
            if not mode.slips:
                pairs += [(f, own, stand.along) for f, own in zip(c.friction_forces, c.shares[1:], strict=True)]
            forces |= {f: sum_of(mul(w, r) for w, r in zip(own, rows, strict=False)) for f, own, rows in pairs}
    return forces


Group = tuple[ContactLaw, ...]
Forces = Mapping[Expr, Expr]


def groups(contacts: Sequence[ContactLaw], modes: Modes) -> list[Group]:
    """For each contact those that its row makes stick, itself first; () if the row of another does; in a stand, itself alone."""
    result: list[Group] = []
    leader, alone = 0, {i for stand in stands(contacts, modes) for i in stand.members}
    for k, (c, mode) in enumerate(zip(contacts, modes, strict=True)):
        held = mode is ContactMode.HELD and k not in alone
        result.append(() if held else (c,))
        if mode is ContactMode.STICK and c.slips and k not in alone:
            leader = k
        elif held:
            result[leader] = (*result[leader], c)
    return result


def _added(c: ContactLaw, mode: ContactMode, group: Group, forces: Forces) -> Iterator[tuple[str, Iterable[Any]]]:
    yield "events", _endings(c, mode, group, forces)
    if mode is ContactMode.SEPARATED:
        return
    if not mode.carried:
        yield "holonomic", [c.gap] if c.gap else []
        yield "reactions", _normal_reactions(c)
    if mode is ContactMode.STICK:
        yield "nonholonomic", c.slips
        yield "reactions", c.friction_forces
    elif mode is ContactMode.ACROSS and c.across is not None:
        yield "nonholonomic", c.across[:1]
        yield "reactions", c.across[1:]
    elif mode.slips:
        yield "loads", [friction(c, mode, forces)]


def _normal_reactions(c: ContactLaw) -> list[Reaction]:
    return [] if c.normal_force is None or c.pressed_by is not None else [c.normal_force]


def friction(c: ContactLaw, mode: ContactMode, forces_: Forces) -> Load:
    """The friction load of a contact that slips; `forces_` replace N and F."""
    sizes = {f: substituted(size, forces_) for f, size in c.sliding_friction(mode).items()}
    forces: list[tuple[Point, Vector]] = []
    torques: list[tuple[Frame, Vector]] = []
    for row, f in zip(c.slips, c.friction_forces, strict=True):
        forces += [(p, v * sizes[f]) for p, v in row.forces]
        torques += [(frame, v * sizes[f]) for frame, v in row.torques]
    shared = c.normal_force in forces_  # a shared multiplier may have either sign; a separate event monitors N
    return Load(friction_name(c), tuple(forces), tuple(torques), slip=Slip(None) if shared else None)


def friction_name(c: ContactLaw) -> str:
    """The name of the friction load of a contact that slips."""
    return f"friction of {c.name}"


def _endings(c: ContactLaw, mode: ContactMode, group: Group, forces: Forces) -> Iterator[Event]:
    """The events that end a mode of a contact."""

    def event(what: str, quantity: Expr, direction: int = -1) -> Event:
        return EndOfMode(f"{c.name} {what}", substituted(quantity, forces), 0.0, direction, True)

    if mode is ContactMode.SEPARATED:
        if c.gap is not None:
            yield event("closes", add(c.gap.expr, c.slack))
        return
    for normal in _normal_reactions(c):
        yield event("opens", normal)
    if c.slips and group and not mode.slips:
        held = sum_of(other.most for other in group)
        square = sum_of(mul(f, f) for f in c.friction_forces)
        yield event("slips", sub(mul(held, held), square))
    elif mode.straight:
        yield event("sticks", c.onward)
        if len(c.slips) > 1:
            yield event("turns", sub(c.onward, c.slowest), 1)
    elif mode.slips:
        yield event("slows", sub(sqrt(c.square), c.slowest))


def in_mode(contacts: Sequence[ContactLaw], modes: Modes, exprs: Sequence[Expr]) -> Sequence[Expr]:
    """Expressions with N and F of contacts replaced by their expressions in the modes, where they are not unknowns."""
    if not modes:
        return exprs
    standing = standing_forces(contacts, modes)
    forces = dict(standing)
    for c, mode, group in zip(contacts, modes, groups(contacts, modes), strict=True):
        if mode is ContactMode.SEPARATED:
            forces |= dict.fromkeys((*_normal_reactions(c), *c.friction_forces), ZERO)
        elif mode.slips:
            forces |= {f: substituted(e, standing) for f, e in c.sliding_friction(mode).items()}
        whole = add(sum_of(other.most for other in group), as_expr(_NO_FRICTION))
        for other in group if len(group) > 1 else ():
            pairs = zip(other.friction_forces, c.friction_forces, strict=True)
            forces |= {f: mul(total, div(other.most, whole)) for f, total in pairs}
    return [substituted(e, forces) for e in exprs] if forces else exprs

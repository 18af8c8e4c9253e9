# SPDX-License-Identifier: BSD-3-Clause
"""Checks of the units of a system: quantities have their dimensions, terms of sums have equal units, and no factors are missing.

An expression is checked only if all its symbols have units. Expressions in numbers and time alone are not checked; in a sum, a
number has dimension one.
"""

from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction

from kane.errors import UnitError, cut
from kane.expr.build import mul
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, constant_value, postorder
from kane.expr.ops import ADD, CONST, DIV, MUL, SUB
from kane.expr.symbols import AuxiliarySpeed, QuasiRate, Rate, Reaction, Symbol, Time, per_second, rate
from kane.model.bodies import deforming, parts_of
from kane.model.constraints import cut_of
from kane.model.declarations import Declarations, EndOfMode, target
from kane.space.frame import Point
from kane.units.rules import ANY, NUMBER, ONE, Known, Unit, conflict, infer, parse, quotient, spelled, unit_of

_QUANTITIES = ("kg", "m", "s", "N", "J", "kg*m^2", "m/s^2")
MASS, LENGTH, TIME, FORCE, ENERGY, INERTIA, ACCELERATION = map(parse, _QUANTITIES)

_MISSING = tuple(unit.exponents for unit in (MASS, LENGTH, TIME, FORCE, ENERGY, INERTIA, ACCELERATION))

_NOUNS = {
    LENGTH: "a length (m)",
    ONE: "an angle (rad) or a ratio",
    MASS: "a mass (kg)",
    INERTIA: "a moment of inertia (kg*m^2)",
    FORCE: "a force (N)",
    ENERGY: "a torque (N*m) or energy (J)",
    ACCELERATION: "an acceleration (m/s^2)",
}
_GIVEN = (AuxiliarySpeed, QuasiRate, Reaction, Time)
"""Symbols that always have units."""

_FOLLOWING = (Rate, QuasiRate, AuxiliarySpeed)
"""Symbols whose units follow from others, or that are zero in any unit."""

_SUMS = (ADD, SUB)
_JOINED = (*_SUMS, MUL, DIV)
_LARGEST = 12
"""Largest integer taken as a factor of a formula, such as 12 in m (a² + b²)/12."""

Quantity = tuple[str, Unit | None, Iterable[Expr]]
"""What the quantity is, its unit up to a scale (None: any), and its measure numbers."""


def check_units(system: Declarations, symbols: Iterable[Symbol]) -> None:
    """Raise UnitError for contradictory units; without units there is no cost."""
    everything = dict.fromkeys((*symbols, *system.coordinates, *system.speeds, *system.reactions))
    carriers = [s for s in everything if s.unit]
    unasked = _unasked(system)
    chosen = {s for body in deforming(system.bodies) for s in (*body.named, *body.speeds, *map(rate, body.coordinates))}
    if all(isinstance(s, _GIVEN) or s in unasked or s in chosen for s in carriers):
        return
    _check_scales(carriers, unasked)
    _check_quantities(system, unasked)
    for r in system.reactions:
        _check_reaction(r)


def _unasked(system: Declarations) -> set[Symbol]:
    """Symbols with units assigned by joints, and their rates: a spring constant of 5 between them is still accepted."""
    named = [s for joint in system.joints for s in joint.named]
    return {*named, *map(rate, named)}


def _check_quantities(system: Declarations, unasked: Iterable[Symbol]) -> None:
    told: Known = {}
    bare: Known = dict.fromkeys(unasked)
    for what, wanted, exprs in _quantities(system):
        for e in exprs:
            if e.op is not CONST:
                _check(e, what, wanted, bare if bare and _may_lack(e, bare) else told)


def _may_lack(e: Expr, bare: Known) -> bool:
    """Whether units assigned by joints may be ignored: alone in an expression, or beside numbers that may be quantities."""
    others = [s for s in free_symbols((e,)) if s.unit and s not in bare and not isinstance(s, (*_GIVEN, *_FOLLOWING))]
    return not others or any(
        other is None or not _is_of_formulas(value) or any(s in bare for s in free_symbols((other,)))
        for value, other in _numbers(e)
    )


def _numbers(e: Expr) -> Iterator[tuple[object, Expr | None]]:
    """Numbers in an expression with their cofactors, None for terms of sums; without exponents."""
    for node in postorder((e,)):
        for k, a in enumerate(node.args):
            if a.op is CONST and node.op in _JOINED:
                yield constant_value(a), None if node.op in _SUMS else node.args[1 - k]


def _is_of_formulas(value: object) -> bool:
    """Whether a number is a factor of a formula, such as 2 and 1/12; 9.81 is a quantity."""
    return isinstance(value, int | Fraction) and max(abs(value.numerator), value.denominator) <= _LARGEST


def _check_scales(carriers: Iterable[Symbol], unasked: set[Symbol]) -> None:
    users: dict[Unit, Symbol] = {}
    for s in carriers:
        if not isinstance(s, _FOLLOWING):
            users.setdefault(_read(s), s)
    if all(u.scale == 1 for u in users):
        return
    odds = conflict(sorted({TIME: None, **users}, key=_trust))
    if odds is None:
        return
    odd = odds.units[0]
    names = [f"{users[u].unit} ({users[u]})" if u in users else "s (the time)" for u in odds.units]
    if odd.is_bare:
        raise UnitError(
            f"Expected angles in rad and ratios in 1, got {names[0]}: functions take radians. Convert the values: "
            f"1 {users[odd].unit} = {odd.scale:.6g}."
        )
    own = [s for u in odds.units for s in [users.get(u)] if s in unasked]
    cure = f" Joints name coordinates in rad and m: give {own[0]} as a symbol in another unit." if own else ""
    raise UnitError(
        f"Expected units that go together without factors, got {', '.join(names)}: a factor {odds.factor:.6g} is left "
        f"over. Give all in one choice of base units, such as kg, m, s, N or t, mm, s, N.{cure}"
    )


def _trust(u: Unit) -> tuple[bool, bool, float]:
    """Sort key: the unit of time first, then those of SI, then those with few factors."""
    return u is not TIME, u.scale != 1, sum(abs(float(e)) for e in u.exponents)


def _read(s: Symbol) -> Unit:
    try:
        return parse(s.unit)
    except UnitError as error:
        raise UnitError(f"{error} This is the unit of {s}.") from None


def _quantities(system: Declarations) -> Iterator[Quantity]:
    for p in system.points:
        if p.parent is not None:
            yield f"the position of {p.name} from {p.parent.name}", LENGTH, p.offset.scalars()
    for f in system.frames:
        o = f.orientation
        if o is not None:
            turned = o.parameters or ((o.angle,) if o.angle is not None else o.scalars())
            yield f"the orientation of {f.name}", ONE, turned
    for part in parts_of(system.bodies):
        yield f"the mass of {part.name}", MASS, (part.mass,)
        if part.inertia is not None:
            pairs = ((x, y) for a, b in part.inertia.dyads for x in a.scalars() for y in b.scalars())
            yield f"the inertia of {part.name}", INERTIA, (mul(x, y) for x, y in pairs)
    for load in system.loads:
        for point, v in load.forces:
            yield f"the force of {load.name!r} on {point.name}", FORCE, v.scalars()
        for frame, v in load.torques:
            yield f"the torque of {load.name!r} on {frame.name}", ENERGY, v.scalars()
        if load.potential is not None:
            yield f"the potential energy of {load.name!r}", ENERGY, (load.potential,)
    for g in system.gravities:
        yield f"the acceleration of {g.name!r}", ACCELERATION, g.acceleration.scalars()
    for u, definition in system.speeds.items():
        declared = f" [{u.unit}]" if u.unit else ""
        yield f"the definition of {u.name}{declared}", parse(u.unit) if u.unit else None, (definition,)
    for a, rate_of in system.states.items():
        unit = per_second(a.unit)
        yield f"the rate of the state {a}{f' [{a.unit}]' if unit else ''}", parse(unit) if unit else None, (rate_of,)
    yield from _of_events(system)


def _of_events(system: Declarations) -> Iterator[Quantity]:
    for c in system.contacts:
        yield f"the gap of the contact {c.name!r}", None, () if c.gap is None else (c.gap.expr,)
    for event in (e for e in system.events if not isinstance(e, EndOfMode)):
        yield f"the quantity of the event {event.name!r}", None, (event.quantity,)
        for key, value in event.then.items() if isinstance(event.then, Mapping) else ():
            unit = target(system, event, key).unit
            made = (value,) if isinstance(value, Expr) else ()
            yield f"the value of {key} set by the event {event.name!r}", parse(unit) if unit else None, made


def _check(e: Expr, what: str, wanted: Unit | None, inferred: Known) -> None:
    try:
        unit = infer(e, inferred)
    except UnitError as error:
        if _is_of_time(e):
            return
        raise UnitError(f"{error} This is in {what}.{_cure_of_numbers(e)}") from None
    if wanted is None or unit is None or unit is NUMBER or unit is ANY or unit.exponents == wanted.exponents:
        return
    if _is_of_time(e):
        return
    carried = ", ".join(f"{s} [{s.unit}]" for s in free_symbols((e,))[:6])
    raise UnitError(
        f"Expected {_NOUNS.get(wanted) or spelled(wanted)} as {what}, got {spelled(unit, e)}: {cut(e, 80)}, with {carried}. "
        f"{_cure(e, quotient(wanted, unit))}"
    )


def _cure(e: Expr, missing: Unit) -> str:
    """Advice for an expression with a wrong unit; a number in it that is not a multiple of one half may lack its unit."""
    values = (constant_value(x) for x in postorder((e,)) if x.op is CONST)
    number = next((float(v) for v in values if v is not None and float(2 * v) % 1), None)
    cure = "Correct the expression, or the unit of a symbol in it"
    if number is None or missing.exponents not in _MISSING:
        return f"{cure}."
    return f'{cure}; where {number:.6g} is a quantity, give it its unit: kn.parameter(name, value, "unit").'


def _is_of_time(e: Expr) -> bool:
    """Whether an expression contains only numbers and time, so that its numbers have unknown units."""
    return all(isinstance(s, Time) for s in free_symbols((e,)))


def _cure_of_numbers(e: Expr) -> str:
    """Advice for functions of numbers and time in a sum with terms of other units."""
    terms = (a for node in postorder((e,)) if node.op in _SUMS for a in node.args)
    lone = next((a for a in terms if a.args and _is_of_time(a) and free_symbols((a,))), None)
    if lone is None or not _has_unit(lone):
        return ""
    return (
        f" Numbers in {cut(lone)} have no unit, while symbols beside them have: give one of them as a parameter with its unit, such "
        'as kn.parameter("c", 0.5, "rad/s^2").'
    )


def _has_unit(e: Expr) -> bool:
    try:
        infer(e, {})
    except UnitError:
        return False
    return True


def _check_reaction(reaction: Reaction) -> None:
    cut = cut_of(reaction)
    if cut is None or not reaction.unit:
        return
    wanted = FORCE if isinstance(cut.at, Point) else ENERGY
    if parse(reaction.unit).exponents != wanted.exponents:
        noun = "a force, such as N, at a point" if wanted is FORCE else "a torque, such as N*m, on a frame"
        raise UnitError(
            f"Expected the unit of {noun} for the reaction {reaction}, got {reaction.unit}. Correct unit=, or leave it out."
        )


# Units of expressions -----------------------------------------------------------------------------------------------


def unit_in(system: Declarations, e: Expr) -> str:
    """The unit of an expression of a system, "" if it is unknown.

    A speed without a unit has that of its definition. If a symbol of the system has no unit, or a quantity is a number, such as a mass
    of 2, expressions in several symbols may lack a factor, and their units are unknown.
    """
    if isinstance(e, Symbol) and e.unit:
        return e.unit
    complete = _is_complete(system)
    units: Known = {}
    for u, definition in system.speeds.items():
        text = "" if u.unit or not (complete or isinstance(definition, Symbol)) else unit_of(definition)
        for symbol, own in ((u, text), (rate(u), per_second(text))):
            if own and e is symbol:
                return own
            units[symbol] = parse(own) if own else infer(symbol, {})
    if not complete:
        return ""
    if unit_of(e):
        return unit_of(e)
    try:
        return unit_of(e, units)
    except UnitError:  # definitions of speeds without units are not checked
        return ""


def _is_complete(system: Declarations) -> bool:
    """Whether all symbols except speeds have units, and no dimensional quantity is a nonzero number."""
    symbols = (*system.coordinates, *system.states, *system.parameters, *system.inputs, *system.reactions)
    if not all(s.unit for s in symbols):
        return False
    try:
        if _unasked(system):  # units assigned by joints must agree with the others
            _check_quantities(system, ())
    except UnitError:
        return False
    inferred: Known = {}
    dimensional = (exprs for _, wanted, exprs in _quantities(system) if wanted is not None and not wanted.is_bare)
    return all(infer(e, inferred) is not NUMBER for exprs in dimensional for e in exprs)

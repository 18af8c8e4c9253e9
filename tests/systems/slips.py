# SPDX-License-Identifier: BSD-3-Clause
"""Slips of the pen that a machine can see, one edit of a draft each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from tests.systems.drafts import Draft, built
from tests.systems.slip_edits import Rng, Slip, formulas, one, rewritten, swapped, uses, with_entry, without

_OTHERS = {
    "kg": ("m", "N"), "m": ("kg", "rad", "s"), "m/s^2": ("m/s", "N"), "N/m": ("N*m/rad", "N"), "N*s/m": ("N/m", "kg"),
    "N": ("N*m", "kg"), "N*m": ("N", "N/m"), "N*m/rad": ("N/m", "N"), "N*m*s/rad": ("N*s/m", "N"), "kg*m^2": ("kg", "kg*m"),
    "rad": ("m", "deg"), "1": ("m",), "rad/s": ("m/s", "1/s^2"),
}  # fmt: skip


def unit_of_a_parameter(d: Draft, rng: Rng) -> Draft | None:
    """A parameter in another unit."""
    known = [
        n for n, (_, unit) in d.parameters.items() if not n.startswith("w")
    ]  # the time's own functions have no units
    name = one(rng, known)
    value, unit = d.parameters[name]
    return with_entry(d, "parameters", name, (value, one(rng, _OTHERS[unit])))


def unit_of_a_coordinate(d: Draft, rng: Rng) -> Draft | None:
    """A length for an angle, an angle for a length, degrees."""
    name = one(rng, d.coordinates)
    if name is None:
        return None
    other = {"rad": ("m", "deg"), "m": ("rad", "kg"), "1": ("m",)}[d.coordinates[name]]
    return with_entry(d, "coordinates", name, one(rng, other))


def unit_of_a_speed(d: Draft, rng: Rng) -> Draft | None:
    """A speed in the unit of another kind."""
    name = one(rng, d.speeds)
    if name is None:
        return None
    unit, text = d.speeds[name]
    return with_entry(d, "speeds", name, ({"rad/s": "m/s", "m/s": "rad/s"}[unit], text))


def factor_left_out(d: Draft, rng: Rng) -> Draft | None:
    """A factor with a unit left out of a product, or a division for it."""
    found = []
    for group, name, text in formulas(d):
        if d.joints and "velocity" in text:  # what is left is written in symbols of which nobody said the units
            continue
        for n in uses(text, d.parameters):
            product = (
                rf"(?<![\w\".]){n}(\*|/2\*)(?=\w)(?![A-Z]\d?(\.frame)?\.[xyz])"  # a length of 1 has no unit to see
            )
            found += [(group, name, text, m) for m in re.finditer(product, text)]
    chosen = one(rng, found)
    if chosen is None:
        return None
    group, name, text, m = chosen
    return rewritten(d, group, name, text[: m.start()] + text[m.end() :])


def force_for_torque(d: Draft, rng: Rng) -> Draft | None:
    """A force where a torque is due, or the other way round."""
    name = one(rng, [n for n, text in d.loads.items() if text.startswith(("kn.Torque", "kn.Force"))])
    if name is None:
        return None
    text = d.loads[name]
    return with_entry(
        d, "loads", name, text.replace("Torque", "Force") if "Torque" in text else text.replace("Force", "Torque")
    )


def exchanged_parameters(d: Draft, rng: Rng) -> Draft | None:
    """Two parameters of different units, or a parameter and a coordinate, exchanged in one formula."""
    units = {n: unit for n, (_, unit) in d.parameters.items()} | dict(d.coordinates)
    found = []
    for group, name, text in formulas(d):
        used = uses(text, units)
        for i, a in enumerate(used):
            found += [(group, name, text, a, b) for b in used[i + 1 :] if units[a] != units[b]]
    chosen = one(rng, found)
    if chosen is None:
        return None
    group, name, text, a, b = chosen
    return rewritten(d, group, name, swapped(text, a, b))


def another_parameter(d: Draft, rng: Rng) -> Draft | None:
    """A parameter of another unit in the place of the one that is meant."""
    found = [(g, n, text, a) for g, n, text in formulas(d) for a in uses(text, d.parameters)]
    chosen = one(rng, found)
    if chosen is None:
        return None
    group, name, text, a = chosen
    others = [n for n, (_, unit) in d.parameters.items() if unit != d.parameters[a][1]]
    b = one(rng, others)
    return None if b is None else rewritten(d, group, name, re.sub(rf"(?<![\w\".]){a}(?![\w\"=])", b, text, count=1))


def name_of_another_kind(d: Draft, rng: Rng) -> Draft | None:
    """A frame for a point, a parameter for a frame, a body for its frame, …."""
    kinds = {n: _kind(d, n) for n in (*d.parameters, *d.coordinates, *d.speeds, *d.places, *d.bodies, "N", "O")}
    whole = {a: re.compile(rf"(?<=[(,= ]){a}(?=[,)])") for a in kinds}  # what is done with a name is Python's to refuse
    found = [(g, n, text, a) for g, n, text in formulas(d) for a in uses(text, kinds) if whole[a].search(text)]
    chosen = one(rng, found)
    if chosen is None:
        return None
    group, name, text, a = chosen
    b = one(rng, [n for n in kinds if kinds[n] != kinds[a] and _stands_before(d, group, name, n)])
    return b and rewritten(d, group, name, whole[a].sub(b, text, count=1))


def _kind(d: Draft, name: str) -> str:
    text = d.places.get(name, "")
    if name in d.places:
        return "point" if ".at(" in text or "fixed_in" in text else "joint" if "kn." in text else "frame"
    groups = {"parameters": "scalar", "coordinates": "scalar", "speeds": "scalar", "bodies": "body"}
    return next(
        (kind for g, kind in groups.items() if name in getattr(d, g)), {"N": "frame", "O": "point"}.get(name, "")
    )


def _stands_before(d: Draft, group: str, name: str, other: str) -> bool:
    """Whether the other name is known where this formula is read."""
    order = [*d.places, *d.bodies]
    return group not in ("places", "bodies") or other not in order or order.index(other) < order.index(name)


def speed_left_out(d: Draft, rng: Rng) -> Draft | None:
    """A speed not defined, where those that are left are not the independent ones, which may stand alone."""
    left = len(d.speeds) - 1
    if not left or (d.constraints and left == len(d.coordinates) - len(built(d).constraints)):
        return None
    return without(d, "speeds", one(rng, d.speeds))


def rate_forgotten(d: Draft, rng: Rng) -> Draft | None:
    """A coordinate for its rate."""
    name = one(rng, [u for u, (_, text) in d.speeds.items() if ".dt" in text])
    return None if name is None else rewritten(d, "speeds", name, d.speeds[name][1].replace(".dt", "", 1))


def rate_of_another(d: Draft, rng: Rng) -> Draft | None:
    """One definition written twice."""
    if len(d.speeds) < 2:
        return None
    a, b = rng.permutation(list(d.speeds))[:2]
    return (
        with_entry(d, "speeds", str(a), (d.speeds[a][0], d.speeds[b][1])) if d.speeds[a][1] != d.speeds[b][1] else None
    )


def _misspelled(name: str, rng: Rng) -> str:
    return str(one(rng, (name + "_", name.upper() + "00", name + "11", "my_" + name)))


def unknown_name(d: Draft, rng: Rng) -> Draft | None:
    """A misspelled name among the start values, the values of parameters or inputs."""
    group = one(rng, [g for g in ("q", "u", "values", "forces") if getattr(d, g)] + ["values"])
    given = dict(getattr(d, group)) or {one(rng, d.parameters): 1.0}
    name = one(rng, given)
    given[_misspelled(name, rng)] = given.pop(name)
    return replace(d, **{group: given})


def exchanged_values(d: Draft, rng: Rng) -> Draft | None:
    """The values of coordinates and speeds exchanged."""
    return replace(d, q=d.u, u=d.q) if d.u else None


def value_in_the_wrong_place(d: Draft, rng: Rng) -> Draft | None:
    """A value for a parameter among the coordinates, or for a coordinate among the parameters."""
    if rng.random() < 0.5:
        return with_entry(d, "q", one(rng, d.parameters), 0.5)
    return with_entry(d, "values", one(rng, d.q), 0.5)


def value_missing(d: Draft, rng: Rng) -> Draft | None:
    """A start value left out, where nothing gives it."""
    if d.constraints:
        return None
    group = one(rng, ("q", "u"))
    return without(d, group, one(rng, getattr(d, group)))


def default_missing(d: Draft, rng: Rng) -> Draft | None:
    """A parameter without a value."""
    name = one(rng, [n for n in d.parameters if any(uses(text, [n]) for *_, text in formulas(d))])
    return with_entry(d, "parameters", name, (None, d.parameters[name][1]))


def wrong_particle(d: Draft, rng: Rng) -> Draft | None:
    """A geometric point, or a particle of a frame that does not spin, in the place of the wheel's particle in contact."""
    if "K" not in d.places:
        return None
    frames = [n for n in ("L", "Y", "A0", "N") if n in d.places or n == "N"]
    text = one(rng, ["at", *frames])
    own = d.places["K"]
    return with_entry(
        d, "places", "K", own.replace("fixed_in(A, ", "at(") if text == "at" else own.replace("(A,", f"({text},")
    )


def particle_made_on_another_body(d: Draft, rng: Rng) -> Draft | None:
    """The plate's particle in contact made on the ball's centre, which does not move with the plate."""
    if "plate" not in d.bodies:
        return None
    r = next(n for n in d.parameters if n.startswith("r"))
    return with_entry(d, "places", "K0", f'C.fixed_in(A0, "K0", -{r}*N.z)')


def wrong_side(d: Draft, rng: Rng) -> Draft | None:
    """The top of the wheel in the place of its lowest particle."""
    if "K" not in d.places or "no_slip" in d.nonholonomic["contact"]:  # which does not say where the ground is
        return None
    return with_entry(d, "places", "K", re.sub(r'"K", -', '"K", ', d.places["K"]))


def turning_gravity(d: Draft, rng: Rng) -> Draft | None:
    """Gravity along an axis of a body."""
    axis = re.search(r"N\.(\w)", d.loads.get("gravity", ""))
    if axis is None:
        return None
    frames = [n for n, text in d.places.items() if "rotate" in text and _turns(d, n, axis[1])]
    frame = one(rng, frames)
    return frame and with_entry(d, "loads", "gravity", d.loads["gravity"].replace(axis[0], f"{frame}.{axis[1]}"))


def _turns(d: Draft, frame: str, axis: str) -> bool:
    """Whether coordinates turn the axis of that frame."""
    text = d.places.get(frame) or d.places.get(frame.removesuffix(".frame")) or ""
    if not text:
        return False
    own = bool(uses(text, d.coordinates)) and f".{axis})" not in text and f".{axis}, coordinates" not in text
    base = re.match(r"(?:kn\.pin\(\"\w+\", \w+, )?([\w.]+?)(?:\.rotate|,)", text)
    return own or (base is not None and _turns(d, base[1], axis))


def start_off_the_constraints(d: Draft, rng: Rng) -> Draft | None:
    """A start value that contradicts the constraints."""
    if not d.holonomic:
        return _speeds_off(d, rng)
    name = one(rng, [n for n in d.q if n in ("q1", "q2", "q3", "z") and ("contact" not in d.places or n == "z")])
    return with_entry(d, "q", name, d.q[name] + float(rng.choice([-1, 1])) * float(rng.uniform(0.01, 0.2)))


def _speeds_off(d: Draft, rng: Rng) -> Draft | None:
    if not d.nonholonomic:
        return None
    return replace(d, u={u: float(rng.uniform(0.5, 1.5)) for u in d.speeds})


def contradictory_constraint(d: Draft, rng: Rng) -> Draft | None:
    """A second constraint that cannot hold beside the first."""
    if "closing" in d.holonomic:
        text = d.holonomic["closing"]
        end = "E2" if "E2" in text else "E3"
        extra = one(
            rng,
            [f'kn.coincident({end}, O, along=(N.x, N.y), name="second")', f'kn.distance({end}, H, l1, name="second")'],
        )
        if "distance" in text:
            extra = 'kn.distance(E2, H, l3 + l1, name="second")'
        return with_entry(d, "holonomic", "second", extra)
    if "height" in d.holonomic:
        return with_entry(d, "holonomic", "second", "z + 0*C.position(O).dot(N.z)")
    if d.nonholonomic:  # what stands still must move
        name = one(rng, d.nonholonomic)
        place = re.search(r"\((\w+), (?:along|normal)=(?:\(|)([\w.]+)", d.nonholonomic[name])
        if place is None:
            return None
        e = "N.x" if place[2] == "N.z" else place[2]
        return with_entry(d, "nonholonomic", "second", f"{place[1]}.velocity(N).dot({e}) - {_length(d)}")
    return None


def _length(d: Draft) -> str:
    return next(n for n, (_, unit) in d.parameters.items() if unit == "m") + "/kn.time"


def dropped_constraint(d: Draft, rng: Rng) -> Draft | None:
    """A constraint left out where dependent speeds are named, or start values are left to it."""
    group = one(rng, [g for g in ("holonomic", "nonholonomic") if getattr(d, g)])
    return None if group is None else without(d, group, one(rng, getattr(d, group)))


def direction_left_out(d: Draft, rng: Rng) -> Draft | None:
    """One of the directions of a closure or of rolling left out, where its speeds or start values are left to it."""
    name = one(rng, [n for n, text in d.constraints.items() if "(N.x, N.y)" in text or "kn.rolling" in text])
    if name is None:
        return None
    group = "holonomic" if name in d.holonomic else "nonholonomic"
    text = getattr(d, group)[name]
    e = one(rng, ("N.x", "N.y"))
    return with_entry(
        d, group, name, text.replace("(N.x, N.y)", e).replace("rolling", "no_slip").replace("normal=N.z", f"along={e}")
    )


def start_values_exchanged(d: Draft, rng: Rng) -> Draft | None:
    """The start values of two coordinates of a closed loop exchanged."""
    if "closing" not in d.holonomic:
        return None
    a, b = (str(n) for n in rng.permutation(list(d.q))[:2])
    return replace(d, q={**d.q, a: d.q[b], b: d.q[a]})


def negative_mass(d: Draft, rng: Rng) -> Draft | None:
    """A mass or moment of inertia below zero by value."""
    name = one(rng, [n for n, (_, unit) in d.parameters.items() if unit in ("kg", "kg*m^2")])
    if rng.random() < 0.5:
        return with_entry(d, "values", name, -d.parameters[name][0])
    return with_entry(d, "parameters", name, (-d.parameters[name][0], d.parameters[name][1]))


def body_left_out(d: Draft, rng: Rng) -> Draft | None:
    """A body declared, but not listed."""
    return None if d.constraints else without(d, "bodies", list(d.bodies)[-1])  # loops may have links without mass


def scalar_for_vector(d: Draft, rng: Rng) -> Draft | None:
    """An axis left out of a sum or product."""
    found = []
    for group, name, text in formulas(d):
        found += [(group, name, text, m) for m in re.finditer(r"\*[NA]\d?\.[xyz]", text)]
    chosen = one(rng, found)
    if chosen is None:
        return None
    group, name, text, m = chosen
    return rewritten(d, group, name, text[: m.start()] + text[m.end() :])


def axis_not_unit(d: Draft, rng: Rng) -> Draft | None:
    """An axis or direction that is no unit vector."""
    found = []
    for group, name, text in formulas(d):
        found += [
            (group, name, text, m)
            for m in re.finditer(r"(?<=[=,] )[NA]\d?\.[xyz](?=[,)])|(?<==)[NAL]\d?\.[xyz](?=[,)])", text)
        ]
    chosen = one(rng, found)
    if chosen is None:
        return None
    group, name, text, m = chosen
    return rewritten(d, group, name, f"{text[: m.start()]}2*{m[0]}{text[m.end() :]}")


SEEN: Mapping[str, Slip] = {
    f.__name__.replace("_", " "): f
    for f in (
        unit_of_a_parameter, unit_of_a_coordinate, unit_of_a_speed, factor_left_out, force_for_torque, exchanged_parameters,
        another_parameter, name_of_another_kind, speed_left_out, rate_forgotten, rate_of_another, unknown_name, exchanged_values,
        value_in_the_wrong_place,
        value_missing, default_missing, wrong_particle, particle_made_on_another_body, wrong_side, turning_gravity,
        start_off_the_constraints,
        contradictory_constraint, dropped_constraint, direction_left_out, start_values_exchanged,
        negative_mass, body_left_out, scalar_for_vector, axis_not_unit,
    )
}  # fmt: skip
"""Slips that a machine can see."""


def slipped(d: Draft, rng: Rng, table: Mapping[str, Slip] = SEEN) -> tuple[str, Draft]:
    """A random slip of those that there is an occasion for, and the draft with it."""
    for name in rng.permutation(list(table)):
        made = table[str(name)](d, rng)
        if made is not None and made != d:
            return str(name), made
    raise AssertionError(f"Expected a slip of the table in {d}.")

# SPDX-License-Identifier: BSD-3-Clause
"""Slips of the pen that leave another sound model."""

from __future__ import annotations

import re
from collections.abc import Mapping

from tests.systems.drafts import Draft
from tests.systems.slip_edits import Rng, Slip, formulas, one, rewritten, uses, with_entry, without


def sign_of_a_force(d: Draft, rng: Rng) -> Draft | None:
    """A spring written by hand that pushes away, a drag or a drive to the other side."""
    name = one(rng, [n for n, text in d.loads.items() if re.match(r"kn\.(Force|Torque)\(", text)])
    if name is None:
        return None
    head, _, rest = d.loads[name].partition(", ")
    return with_entry(d, "loads", name, f"{head}, {rest[1:] if rest.startswith('-') else '-' + rest}")


def sign_of_a_value(d: Draft, rng: Rng) -> Draft | None:
    """A stiffness or damping below zero."""
    stems = {"N/m", "N*s/m", "N*m/rad", "N*m*s/rad"}
    name = one(rng, [n for n, (_, unit) in d.parameters.items() if unit in stems])
    return name and with_entry(d, "values", name, -d.parameters[name][0])


def value_of_a_length(d: Draft, rng: Rng) -> Draft | None:
    """A length ten times as long."""
    if d.holonomic:
        return None
    name = one(rng, [n for n, (_, unit) in d.parameters.items() if unit == "m"])
    return name and with_entry(d, "values", name, 10 * d.parameters[name][0])


def parameters_of_one_unit(d: Draft, rng: Rng) -> Draft | None:
    """A parameter in the place of another of its unit."""
    found = [(g, n, text, a) for g, n, text in formulas(d) if g != "nonholonomic" for a in uses(text, d.parameters)]
    chosen = one(rng, found)
    if chosen is None or d.holonomic:
        return None
    group, name, text, a = chosen
    b = one(rng, [n for n, (_, unit) in d.parameters.items() if n != a and unit == d.parameters[a][1]])
    return b and rewritten(d, group, name, re.sub(rf"(?<![\w\".]){a}(?![\w\"=])", b, text, count=1))


def gravity_upwards(d: Draft, rng: Rng) -> Draft | None:
    """Gravity of the wrong sign."""
    return with_entry(d, "loads", "gravity", d.loads["gravity"].replace("(-", "(")) if "gravity" in d.loads else None


def load_left_out(d: Draft, rng: Rng) -> Draft | None:
    """A load forgotten."""
    name = one(rng, d.loads)
    return name and without(d, "loads", name)


UNSEEN: Mapping[str, Slip] = {
    f.__name__.replace("_", " "): f
    for f in (
        sign_of_a_force,
        sign_of_a_value,
        value_of_a_length,
        parameters_of_one_unit,
        gravity_upwards,
        load_left_out,
    )
}
"""Slips that leave another sound model."""

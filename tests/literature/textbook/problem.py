# SPDX-License-Identifier: BSD-3-Clause
"""A problem of the literature: its model, and what is published of its equations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import kane as kn

READ: dict[str, Callable[[kn.Equations], Sequence[Any]]] = {
    "u̇": lambda eom: [
        u_dot for u, u_dot in zip(eom.speeds, eom.accelerations, strict=True) if u in eom.independent_speeds
    ],
    "F̃": lambda eom: eom.Fr_nh[: len(eom.independent_speeds)],
    "F̃*": lambda eom: eom.Fr_star_nh[: len(eom.independent_speeds)],
    "K": lambda eom: [eom.kinetic_energy_nh],
    "M̃": lambda eom: [x for row in eom.mass_matrix_nh for x in row],
    "f̃": lambda eom: eom.forcing_nh,
}
"""What can be published, in the independent speeds."""


@dataclass(frozen=True)
class Problem:
    """A system, the published expressions by what they are, and the symbols of forces that contribute nothing."""

    system: kn.System
    published: Mapping[str, Sequence[Any]]
    noncontributing: Sequence[kn.Expr] = field(default=())

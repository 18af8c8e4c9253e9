# SPDX-License-Identifier: BSD-3-Clause
"""What random drafts are written with: parameters with units, coordinates and speeds with starts, bodies."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.systems.drafts import FORMULAS, Draft

UNITS = {"m": "kg", "l": "m", "a": "m", "r": "m", "g": "m/s^2", "k": "N/m", "c": "N*s/m", "F": "N", "T": "N*m", "w": "rad/s",
         "kt": "N*m/rad", "ct": "N*m*s/rad", "I": "kg*m^2", "b": "rad", "h": "m"}  # fmt: skip
RANGES = {
    "g": (9.5, 9.9),
    "k": (5.0, 50.0),
    "kt": (1.0, 10.0),
    "F": (-3.0, 3.0),
    "T": (-2.0, 2.0),
    "r": (0.1, 0.4),
    "b": (-1.0, 1.0),
}


@dataclass
class Pen:
    """What a draft is written with: the groups of its formulas, and random numbers."""

    rng: np.random.Generator
    groups: dict[str, dict[str, Any]] = field(default_factory=dict)

    def put(self, group: str, name: str, value: Any) -> str:
        """Enter one name."""
        self.groups.setdefault(group, {})[name] = value
        return name

    def parameter(self, stem: str, number: Any = "", value: float | None = None) -> str:
        """A parameter with the unit of its stem, and some value, or this one."""
        low, high = RANGES.get(stem, (0.3, 1.5))
        own = round(float(self.rng.uniform(low, high)), 3) if value is None else value
        return self.put("parameters", f"{stem}{number}", (own, UNITS[stem]))

    def coordinate(self, name: str, unit: str, start: float | None = None) -> str:
        """A coordinate with its start."""
        own = round(float(self.rng.uniform(0.2, 1.0)), 3) if start is None else start
        self.put("q", name, own)
        return self.put("coordinates", name, unit)

    def speed(self, name: str, unit: str, definition: str, start: bool = True) -> str:
        """A speed with its start."""
        if start:
            self.put("u", name, round(float(self.rng.uniform(-1.0, 1.0)), 3))
        return self.put("speeds", name, (unit, definition))

    def chance(self, share: float) -> bool:
        """True so often."""
        return bool(self.rng.random() < share)

    def one_of(self, *items: Any) -> Any:
        """Any of these."""
        return items[int(self.rng.integers(len(items)))]

    def gravity(self, along: str = "N.y") -> None:
        """Gravity against a direction."""
        self.put("loads", "gravity", f"kn.gravity(-{self.parameter('g')}*{along})")

    def rigid(self, name: str, frame: str, center: str, inertia: str, i: Any = "") -> str:
        """A rigid body; `inertia` is a call with the frame and the mass left open."""
        m = self.parameter("m", i)
        tensor = inertia.format(A=frame, m=m)
        return self.put(
            "bodies", name, f'kn.RigidBody("{name}", frame={frame}, mass_center={center}, mass={m}, inertia={tensor})'
        )

    def draft(self, kind: str) -> Draft:
        """What was written, without points and parameters that nothing uses."""
        for group in ("places", "parameters"):
            own = self.groups[group]
            for name in reversed(list(own)):
                texts = (str(x) for g in FORMULAS for n, x in self.groups.get(g, {}).items() if n != name)
                if not any(re.search(rf"(?<![\w\".]){name}(?![\w\"])", text) for text in texts):
                    del own[name]
        return Draft(kind, **self.groups)

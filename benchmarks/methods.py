# SPDX-License-Identifier: BSD-3-Clause
"""Operations of worked systems by Kane's method and by others: `python -m benchmarks.methods [--write]`.

Counts are deterministic: `methods.md` holds them, and a test that they are what the code gives.
"""

import sys
from pathlib import Path

import kane as kn
from kane.dynamics.formalisms import METHODS
from kane.gallery import load

TABLE = Path(__file__).parent / "methods.md"
SYSTEMS = {
    "pendulum on a cart": "pendulum_on_cart",
    "double pendulum, absolute angles": "double_pendulum",
    "spherical pendulum": "spherical_pendulum",
    "Furuta's pendulum": "furuta_pendulum",
    "spinning top": "spinning_top",
    "gyroscope in gimbals": "gimbal_gyroscope",
    "free body, Euler parameters": "free_body",
    "flyball governor": "flyball_governor",
    "slider-crank": "slider_crank",
    "four-bar": "four_bar",
    "Andrews' squeezer": "andrews_squeezer",
    "skate on an incline": "knife_edge",
    "Chaplygin's sleigh": "chaplygin_sleigh",
    "snakeboard": "snakeboard",
    "car with a trailer": "car_with_trailer",
    "sphere on a turntable, Euler parameters": "sphere_on_turntable",
    "purely rolling disk": "pure_rolling_disk",
    "rattleback": "rattleback",
    "Whipple bicycle": "whipple_bicycle",
    "flexible pendulum": "flexible_pendulum",
    "four-bar with a flexible coupler": "flexible_four_bar",
}
"""Modules of the gallery."""

_HEAD = """\
# Methods

Operations of one evaluation of a method's own right-hand side, of worked systems: (q̇, u̇) by Kane's and by Boltzmann and Hamel's,
q̈ by Lagrange's and by virtual work and power, q̈ and λ by Lagrange's of the first kind, (q̇, ṗ) by Hamilton's, q̈ and all forces of
constraints by Newton and Euler's. The results agree (`tests/laws/test_methods.py`). All are derived on one expression graph and solved
by one elimination; those by Kane's are taken by the shortest of its ways and finished as by hand. `python -m benchmarks.methods`
counts anew. A dash means that the method does not take the system: the theory page on other methods says why.
"""


def table() -> str:
    """The text of `methods.md`."""
    rows = []
    for name, module in SYSTEMS.items():
        found = kn.analysis.compare_methods(load(module).system())
        counts = [str(found[m].operations.total) if m in found.formulations else "–" for m in METHODS]
        rows.append(f"| {name} | {' | '.join(counts)} |")
    head = [f"| system | {' | '.join(METHODS)} |", f"|---|{'---|' * len(METHODS)}"]
    return "\n".join([_HEAD, *head, *rows, ""])


def main() -> None:
    """Print the table; with --write, commit it to methods.md."""
    text = table()
    if "--write" in sys.argv[1:]:
        TABLE.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: BSD-3-Clause
"""Operations of each counted right-hand side, solution and reactions included: `python -m benchmarks.counts [--write]`.

"jacobian" is all of ∂(q̇, u̇)/∂(q, u), "inverse dynamics" M u̇ − f. "total" counts the
expressions, "emitted" the instructions of the compiled program, which trade divisions for multiplications.
`counts.json` holds what the code gives now, `limits.json` what it may give at most: total and emitted, or what is named after a
colon; a test holds both.
"""

import json
import sys
from pathlib import Path

import kane as kn
from benchmarks.systems import COUNTED
from kane.equations.compiled import program
from kane.expr.evaluation import price
from kane.program.from_expressions import receipt

HERE = Path(__file__).parent
_SHORT = 3_000
"""Operations up to which derivatives are counted, too."""
COUNTS, LIMITS = HERE / "counts.json", HERE / "limits.json"


def counts() -> dict[str, dict[str, int]]:
    """State tier, parameter tier, their sum, and the sum in the compiled program, of every counted system."""
    found = {}
    for name, make in COUNTED.items():
        eom = kn.derive(make())
        operations = eom.operations
        found[name] = {
            "state": operations.state,
            "parameter": operations.parameter,
            "total": operations.total,
            "emitted": receipt(program(eom.solved, ("rhs",)))["rhs"].total,
        }
        if operations.total <= _SHORT:
            found[name] |= {
                "jacobian": eom.jacobian().operations.total,
                "inverse dynamics": price(eom.inverse_dynamics),
            }
    return found


def main() -> None:
    """Print the counts beside their limits; with --write, commit them to counts.json."""
    found = counts()
    if "--write" in sys.argv[1:]:
        COUNTS.write_text(json.dumps(found, indent=1) + "\n")
    limits = json.loads(LIMITS.read_text())
    for name, tiers in found.items():
        limit = limits.get(name, "none")
        print(
            f"{name:45} state {tiers['state']:5}  parameter {tiers['parameter']:4}  total {tiers['total']:5}  "
            f"emitted {tiers['emitted']:5}  limit {limit}"
        )


if __name__ == "__main__":
    main()

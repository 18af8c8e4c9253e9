# SPDX-License-Identifier: BSD-3-Clause
"""Run by `test_sanitized.py` under the sanitizers' libraries: integrators in C that checks each access and each operation."""

import sys
from pathlib import Path

import numpy as np

import kane as kn
from kane.gallery import pendulums
from kane.motion import INTEGRATORS, ReturnCode
from tests.motion.steppers.runs import arguments, languages
from tests.program.kernel.kernels import EXACT, in_c

NAMES = tuple(INTEGRATORS)
OPTIONS = ("-std=c99", "-O0", "-ffp-contract=off", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def main(folder: Path) -> None:
    """A second of a double pendulum with samples, by each."""
    eom = kn.derive(pendulums.system(2))
    for name in NAMES:
        integrator = INTEGRATORS[name]
        longest = 0.02 if integrator.fixed else 0.3
        given, routine = arguments(eom, EXACT, name, [1.0, 2.0, 0.5, 0.0], 1.0, longest, 1e-9, np.linspace(0.1, 1, 20))
        in_language = languages(given, routine)
        own = {a: v["c"] if isinstance(v, dict) else v for a, v in in_language.items()}
        assert in_c(integrator.kernel(), folder / f"{name}.c", *OPTIONS)(own) == ReturnCode.END
        print(name)


if __name__ == "__main__":
    main(Path(sys.argv[1]))

# SPDX-License-Identifier: BSD-3-Clause
"""Every integrator gives the same bits through the interpreter, machine code and C."""

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulums
from kane.motion.steppers.outline import Back
from kane.motion.steppers.table import INTEGRATORS
from tests.motion.steppers.runs import arguments, languages
from tests.program.kernel.kernels import EXACT, agree


@pytest.fixture(scope="module")
def pendulum():
    return kn.derive(pendulums.system(2))


@pytest.mark.parametrize("name", INTEGRATORS)
def test_every_language_gives_the_same_bits(name, pendulum, tmp_path):
    """A double pendulum for a few steps and what is taken again, sampled."""
    given, routine = arguments(pendulum, EXACT, name, [1.0, 2.0, 0.5, 0.0], 9.0, 0.3, 1e-9, np.linspace(0.1, 9, 120))
    limit = 6 if INTEGRATORS[name].width == 1 else 3
    kernel = INTEGRATORS[name].kernel()
    assert agree(kernel, languages(given, routine) | {"limit": limit}, tmp_path / "k.c") == Back.LIMIT

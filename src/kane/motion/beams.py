# SPDX-License-Identifier: BSD-3-Clause
"""Beams along a motion: how fast each spins, and what is doubtful then."""

import warnings

import numpy as np

from kane.model.beams.beam import Beam
from kane.model.beams.doubts import doubts
from kane.motion.solution import Solution


def warn_of_beams(solution: Solution) -> None:
    """Warn of beams that spin faster than what they are declared with has it."""
    for beam in solution.equations.system.bodies:
        if isinstance(beam, Beam):
            for said, category in doubts(beam, _spin(solution, beam), solution.parameters):
                warnings.warn(said, category, stacklevel=4)


def _spin(solution: Solution, beam: Beam) -> float:
    """The largest angular speed of the beam's frame across its axis (rad/s)."""
    root = beam.frame.root()
    if root is beam.frame:
        return 0.0
    w = beam.frame.angular_velocity(root)
    along = w.dot(beam.deformation.axis)
    across = np.asarray(solution[w.dot(w)] - solution[along] ** 2)
    return float(np.sqrt(np.max(across, initial=0.0, where=np.isfinite(across))))

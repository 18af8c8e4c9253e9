# SPDX-License-Identifier: BSD-3-Clause
"""Beams along a motion: how fast each spins, how far it bends, and what is doubtful then."""

import warnings

import numpy as np

from kane.errors import KaneWarning
from kane.expr.evaluation import evaluate
from kane.model.beams.beam import Beam, doubts
from kane.motion.solution import Solution

_STEEPEST = 0.4
"""Slopes up to which beams are followed. The strain energy is quadratic in v'' in both forms: a force at the tip that makes this slope
bends a cantilever 7 % further than the elastica, with an error that grows as the square of the slope."""


def warn_of_beams(solution: Solution) -> None:
    """Warn of beams that spin faster, or bend further, than what they are declared with has it."""
    for beam in solution.equations.system.bodies:
        if isinstance(beam, Beam):
            for said, category in doubts(beam, _spin(solution, beam), solution.parameters):
                warnings.warn(said, category, stacklevel=4)
            slope = _slope(solution, beam)
            if beam.deformation.stiffening and slope > _STEEPEST:
                warnings.warn(
                    f"Expected deflections of {beam.name} with slopes below {_STEEPEST:g}, as its strain energy has it, got "
                    f"{slope:.3g}: the motion is that of another beam from about there on. Divide the beam into several.",
                    KaneWarning,
                    stacklevel=4,
                )


def _spin(solution: Solution, beam: Beam) -> float:
    """The largest angular speed of the beam's frame across its axis (rad/s)."""
    root = beam.frame.root()
    if root is beam.frame:
        return 0.0
    w = beam.frame.angular_velocity(root)
    along = w.dot(beam.deformation.axis)
    whole, axial = (np.asarray(x) for x in solution[[w.dot(w), along]])
    across = whole - axial**2
    return float(np.sqrt(np.max(across, initial=0.0, where=np.isfinite(across))))


def _slope(solution: Solution, beam: Beam) -> float:
    """The largest slope dv/dx of the deflections."""
    length, steepest = float(evaluate(beam.length, solution.parameters)), 0.0
    for f in beam.deformation.bending:
        slopes = f.shapes.evaluate(np.linspace(0, 1, 17), 1) @ np.array(solution[list(f.coordinates)]) / length
        steepest = max(steepest, float(np.max(np.abs(slopes), initial=0.0, where=np.isfinite(slopes))))
    return steepest

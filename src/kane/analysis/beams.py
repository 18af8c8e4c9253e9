# SPDX-License-Identifier: BSD-3-Clause
"""Beams in a steady motion: what is doubtful of those that spin there."""

import warnings
from collections.abc import Sequence

import numpy as np

from kane.analysis.point import OperatingPoint
from kane.equations.equations import Equations
from kane.expr.node import Expr
from kane.model.beams.beam import Beam, across, doubts


def warn_of_beams(eom: Equations, points: Sequence[OperatingPoint], stacklevel: int) -> None:
    """Warn once of each beam that spins faster, in some of these states, than what it is declared with has it."""
    for beam in eom.system.bodies:
        square = across(beam) if isinstance(beam, Beam) else None
        if square is None or not isinstance(beam, Beam):
            continue
        spins = [float(np.sqrt(max(float(eom.evaluate(square, **p.arguments)), 0.0))) for p in points]
        fastest = int(np.argmax(spins))
        values = dict[Expr, float](points[fastest].parameters.items())
        for said, category in doubts(beam, spins[fastest], values):
            warnings.warn(said, category, stacklevel=stacklevel + 1)

# SPDX-License-Identifier: BSD-3-Clause
"""A rotation in a notebook: its direction cosines."""

from kane.expr.matrix import Matrix
from kane.present.notebook.typeset import matrix
from kane.space.attitude import Rotation


def rotation_latex(r: Rotation) -> str:
    """The matrix of direction cosines; of an array of rotations how many there are."""
    if r.shape:
        return repr(r)
    return matrix(Matrix(r.direction_cosines)).dollars("A rotation")

# SPDX-License-Identifier: BSD-3-Clause
"""The double pendulum: two uniform rods, or two point masses on massless rods."""

import kane as kn
from kane.gallery import pendulums

TITLE = "double pendulum"
SOURCES = ("Landau, L. D. and Lifshitz, E. M. (1976), Mechanics, 3rd ed., Pergamon, § 5.", *pendulums.SOURCES)
SPEEDS = pendulums.SPEEDS


def system(*, relative: bool = False, bobs: bool = False, speeds: str = "rates") -> kn.System:
    """The chain of two links; options and speeds are those of `pendulums.system`."""
    return pendulums.system(2, relative=relative, bobs=bobs, speeds=speeds)

# SPDX-License-Identifier: BSD-3-Clause
"""Where in the user's own code a warning belongs."""

import sys
from pathlib import Path

_HERE = str(Path(__file__).resolve().parents[2])


def outside() -> int:
    """The `stacklevel` for `warnings.warn` in the calling function that names the first line outside of kane."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_HERE):
        frame, level = frame.f_back, level + 1
    return level

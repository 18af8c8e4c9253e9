# SPDX-License-Identifier: BSD-3-Clause
"""Warnings that belong to the user's own code."""

import sys
import warnings
from pathlib import Path

from kane.errors import KaneWarning

_HERE = str(Path(__file__).resolve().parents[2])


def warn(message: str) -> None:
    """A `KaneWarning` at the innermost line outside of kane."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_HERE):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, KaneWarning, stacklevel=level)

# SPDX-License-Identifier: BSD-3-Clause
"""Equations of motion as users hold them: derived, read, compiled."""

from kane.lazy_imports import offered

__getattr__ = offered(__name__, {"equations": "repartition", "compiled": "program"})

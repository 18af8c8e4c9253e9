# SPDX-License-Identifier: BSD-3-Clause
"""Layer 1: frames, points, vectors and dyadics; positions, velocities and accelerations in the rates q̇."""

from kane.lazy_imports import offered

__getattr__ = offered(__name__, {"rotation": "common_base connected cost enter express leave path single"})

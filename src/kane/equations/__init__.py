# SPDX-License-Identifier: BSD-3-Clause
"""Layer 5: `Equations`, the result of a derivation: its readings, compiled routines, instances, and modes of contacts."""

from kane.lazy_imports import offered

__getattr__ = offered(__name__, {"equations": "repartition", "compiled": "program"})

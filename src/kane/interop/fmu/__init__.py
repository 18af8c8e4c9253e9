# SPDX-License-Identifier: BSD-3-Clause
"""Functional mock-up units: simulation code in C with the interface of FMI 3.0 or 2.0, the model description, and the archive."""

from kane.lazy_imports import offered

__getattr__ = offered(__name__, {"archive": "FMU to_fmu unit_name"})

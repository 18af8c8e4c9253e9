# SPDX-License-Identifier: BSD-3-Clause
"""Functional mock-up units: the motion in C behind the interface of FMI 3.0 or 2.0, its description, and the archive of both."""

from kane.lazy_imports import offered

__getattr__ = offered(__name__, {"archive": "FMU to_fmu unit_name"})

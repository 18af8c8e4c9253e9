# SPDX-License-Identifier: BSD-3-Clause
"""Integrators, one per file, as kernels that integrate a whole motion in machine code."""

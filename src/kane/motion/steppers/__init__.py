# SPDX-License-Identifier: BSD-3-Clause
"""Integrators, one a file, as kernels that run a whole motion in machine code."""

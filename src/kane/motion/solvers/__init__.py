# SPDX-License-Identifier: BSD-3-Clause
"""Solvers of SciPy and SUNDIALS."""

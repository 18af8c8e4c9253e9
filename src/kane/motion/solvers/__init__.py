# SPDX-License-Identifier: BSD-3-Clause
"""Integrators of SciPy and SUNDIALS, stepped from Python."""

# SPDX-License-Identifier: BSD-3-Clause
"""Exact derivatives of hybrid motions with respect to initial values and parameters (sensitivity analysis across events)."""

# SPDX-License-Identifier: BSD-3-Clause
"""Limit cycles of hybrid motions: shooting with exact derivatives, branches of cycles over a parameter, Poincaré sections."""

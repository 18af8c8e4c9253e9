# SPDX-License-Identifier: BSD-3-Clause
"""Exact derivatives of motions by their start and by parameters, across events."""

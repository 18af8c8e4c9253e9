# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of what is solved for."""

# SPDX-License-Identifier: BSD-3-Clause
"""Equations of motion as users hold them: derived, read, compiled."""

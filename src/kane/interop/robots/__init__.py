# SPDX-License-Identifier: BSD-3-Clause
"""Robots as other tools describe them, URDF and MJCF: read as one record of numbers, from which one builder makes a system."""

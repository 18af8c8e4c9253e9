# SPDX-License-Identifier: BSD-3-Clause
"""Import of robots from URDF and MJCF: each reader makes the same record of numbers, from which `build` makes a system."""

# SPDX-License-Identifier: BSD-3-Clause
"""Layer 1: frames, points, vectors; positions, velocities and accelerations in the rates q̇."""

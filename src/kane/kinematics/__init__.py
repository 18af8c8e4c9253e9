# SPDX-License-Identifier: BSD-3-Clause
"""Layer 3: generalized speeds, velocities in them, partial velocities, auxiliary speeds."""

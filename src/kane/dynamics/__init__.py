# SPDX-License-Identifier: BSD-3-Clause
"""Layer 4: generalized forces, equations of motion, energies."""

# SPDX-License-Identifier: BSD-3-Clause
"""Results read from a derivation: energies, contributions of forces, integrals, joint reactions, the seven steps."""

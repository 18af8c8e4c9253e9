# SPDX-License-Identifier: BSD-3-Clause
"""What is read off a derivation: energies, forces, steps, reactions."""

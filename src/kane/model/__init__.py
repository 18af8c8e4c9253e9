# SPDX-License-Identifier: BSD-3-Clause
"""Layer 2: what the engineer declares. Checks here are local; what needs derivation is checked in `dynamics`."""

# SPDX-License-Identifier: BSD-3-Clause
"""Layer 0: the scalar expression graph."""

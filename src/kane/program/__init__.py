# SPDX-License-Identifier: BSD-3-Clause
"""Layer 5: equations as Programs, and Programs as machine code, C and NumPy."""

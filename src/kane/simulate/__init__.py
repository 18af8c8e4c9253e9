# SPDX-License-Identifier: BSD-3-Clause
"""Layer 6: motion as numbers."""

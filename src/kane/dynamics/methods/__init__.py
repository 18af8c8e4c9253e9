# SPDX-License-Identifier: BSD-3-Clause
"""Other methods than Kane's, for the same system: one a file, and what they have in common."""

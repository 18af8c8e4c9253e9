# SPDX-License-Identifier: BSD-3-Clause
"""Beams: modes, forms, what is refused."""

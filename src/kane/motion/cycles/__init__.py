# SPDX-License-Identifier: BSD-3-Clause
"""Limit cycles: the exact derivative of a motion that events change, shooting, branches of cycles, sections."""

# SPDX-License-Identifier: BSD-3-Clause
"""Sourced results: what was published, against what is derived."""

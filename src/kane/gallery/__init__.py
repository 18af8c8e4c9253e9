# SPDX-License-Identifier: BSD-3-Clause
"""Worked systems, each a short module with `system()` and its sources."""

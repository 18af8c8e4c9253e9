# SPDX-License-Identifier: BSD-3-Clause
"""Joints of trees, closures of loops, contacts and gears."""

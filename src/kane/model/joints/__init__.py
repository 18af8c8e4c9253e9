# SPDX-License-Identifier: BSD-3-Clause
"""Joints: functions over frames and points, one a file, each with the constraints that close a loop by it."""

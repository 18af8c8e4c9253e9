# SPDX-License-Identifier: BSD-3-Clause
"""Joints: functions over frames and points; what closes a loop by them; contacts and gears."""

# SPDX-License-Identifier: BSD-3-Clause
"""Inputs of a motion: functions of time and state, expressions, sampled controllers, and the times at which they jump or bend."""

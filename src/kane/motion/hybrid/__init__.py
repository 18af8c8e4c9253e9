# SPDX-License-Identifier: BSD-3-Clause
"""The hybrid automaton of a motion: events, switching surfaces, modes, location of crossings, actions."""

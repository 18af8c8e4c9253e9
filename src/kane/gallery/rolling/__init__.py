# SPDX-License-Identifier: BSD-3-Clause
"""Systems that roll or slide without slip: velocities that constraints hold."""

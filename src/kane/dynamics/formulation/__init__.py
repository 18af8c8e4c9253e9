# SPDX-License-Identifier: BSD-3-Clause
"""Routes from a derived system to its accelerations."""

# SPDX-License-Identifier: BSD-3-Clause
"""Independent numerical routes to the same accelerations; none of the oracles imports kane."""

# SPDX-License-Identifier: BSD-3-Clause
"""What `kn.plot` draws: motions as runs, their quantities as traces in panels, and the lines."""

# SPDX-License-Identifier: BSD-3-Clause
"""Many motions at once: instances and designs, tiles of them on threads, their results as one Dataset."""

# SPDX-License-Identifier: BSD-3-Clause
"""The same right-hand sides written for other tools, one file a tool; nothing here is timed."""

# SPDX-License-Identifier: BSD-3-Clause
"""Parameter estimation from measured motions, and optimal control by shooting."""

# SPDX-License-Identifier: BSD-3-Clause
"""Models and motions that are found: parameters from measured motions, inputs that lead somewhere."""

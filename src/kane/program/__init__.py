# SPDX-License-Identifier: BSD-3-Clause
"""Layer 5: equations as code. Empty so far: the reference evaluator of `expr` runs the equations."""

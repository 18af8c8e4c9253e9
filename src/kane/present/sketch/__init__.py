# SPDX-License-Identifier: BSD-3-Clause
"""The labelled sketch of a system: pose and camera are searched, labels are placed at the width at which they are read."""

from kane.lazy_imports import offered

__getattr__ = offered(__name__, {"draw": "Sketch sketch", "labels": "Label placed", "typeset": "spans width_of"})

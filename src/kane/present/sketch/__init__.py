# SPDX-License-Identifier: BSD-3-Clause
"""The labelled sketch of a system: pose and camera are optimized, labels are placed for the width at which the sketch is read."""

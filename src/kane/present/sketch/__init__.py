# SPDX-License-Identifier: BSD-3-Clause
"""The labelled sketch of a system: pose and camera are searched, labels are placed at the width at which they are read."""

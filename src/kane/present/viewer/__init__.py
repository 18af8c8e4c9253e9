# SPDX-License-Identifier: BSD-3-Clause
"""A scene in motion: meshes of its shapes, their placement at each instant, and output as a page, glTF or pictures."""

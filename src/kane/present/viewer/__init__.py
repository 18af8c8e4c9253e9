# SPDX-License-Identifier: BSD-3-Clause
"""A scene in motion: meshes of its shapes, where they are at each instant, and what draws them (a page, glTF, pictures)."""

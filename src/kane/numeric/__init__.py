# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of linear algebra that all layers share: rank, balance, projection, samples."""

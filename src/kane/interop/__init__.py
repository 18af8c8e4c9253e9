# SPDX-License-Identifier: BSD-3-Clause
"""Layer 7, beside the presentation: exchange with other tools, each module imported only when it is used."""

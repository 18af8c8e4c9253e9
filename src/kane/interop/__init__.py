# SPDX-License-Identifier: BSD-3-Clause
"""Layer 7: exchange with other tools. Each importer or exporter is imported only when it is used."""

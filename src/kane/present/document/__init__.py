# SPDX-License-Identifier: BSD-3-Clause
"""Reports as LaTeX and as Markdown: a list of pieces, and a writer for each format."""

# SPDX-License-Identifier: BSD-3-Clause
"""`python -m kane`: the command, where its script is not on the path."""

from kane.cli import main

main()

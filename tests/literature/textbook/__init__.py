# SPDX-License-Identifier: BSD-3-Clause
"""Nonholonomic problems with the forms of their equations that are published, one problem a file."""

# SPDX-License-Identifier: BSD-3-Clause
"""Languages of reports: a catalogue a file, and what takes a text from it."""

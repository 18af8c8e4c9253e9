# SPDX-License-Identifier: BSD-3-Clause
"""Languages of reports: a catalogue file for each, and functions that translate texts."""

# SPDX-License-Identifier: BSD-3-Clause
"""Ensembles of motions: instances and designs of experiments, tiles of instances on threads, results as one Dataset."""

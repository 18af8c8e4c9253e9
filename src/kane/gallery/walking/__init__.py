# SPDX-License-Identifier: BSD-3-Clause
"""Systems that walk by impacts of their legs."""

# SPDX-License-Identifier: BSD-3-Clause
"""What a report says of a steady motion and of small motions beside it, and of branches of them."""

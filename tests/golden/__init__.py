# SPDX-License-Identifier: BSD-3-Clause
"""What the library makes of the gallery, of all counted systems and of random ones, as a file to compare with another one."""

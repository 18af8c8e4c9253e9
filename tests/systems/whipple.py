# SPDX-License-Identifier: BSD-3-Clause
"""The Whipple bicycle's linearized equations as published (Meijaard et al. 2007)."""

import numpy as np

BIKE_M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
BIKE_K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
BIKE_K2 = np.array([[0, 76.59734589573222], [0, 2.65431523794604]])
BIKE_C1 = np.array([[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])

# SPDX-License-Identifier: BSD-3-Clause
"""The types of arrays."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Mask = npt.NDArray[np.bool_]
Entries = npt.NDArray[Any]
"""Numbers or expressions."""

# SPDX-License-Identifier: BSD-3-Clause
"""All benchmarks: `make bench`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks import counts, derivation, evaluation

if __name__ == "__main__":
    counts.main()
    derivation.main()
    evaluation.main()

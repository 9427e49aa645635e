"""Names for the array types that cross module borders."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

#: (H, W) uint8: 0 unknown, 1 free, 2 occupied.
Belief: TypeAlias = NDArray[np.uint8]
#: (H, W) bool.
Mask: TypeAlias = NDArray[np.bool_]
#: (H, W) int32, steps.
Distances: TypeAlias = NDArray[np.int32]
#: (row, column).
Cell: TypeAlias = tuple[int, int]

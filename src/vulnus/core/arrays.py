"""Names for the array types that travel between rooms; the shape stands in the docstring."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Float32Array = NDArray[np.float32]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
IndexArray = NDArray[np.int64]
LabelArray = NDArray[np.uint8]
BoolArray = NDArray[np.bool_]
AnyArray = NDArray[Any]
Vector3 = tuple[float, float, float]
"""A point [m] or a direction in the patient frame, LPS (x left, y posterior, z superior)."""

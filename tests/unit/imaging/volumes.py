"""Small label volumes for the tests of the readers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nrrd
import numpy as np

SHAPE = (11, 9, 7)
SPACING_MM = (1.5, 0.8, 3.0)


def asymmetric_labels() -> np.ndarray:
    """Five labels with no symmetry at all, so that any flip or swap of axes shows."""
    labels = np.zeros(SHAPE, dtype=np.uint8)
    labels[1:9, 1:8, :] = 1
    labels[2:8, 2:7, :] = 2
    labels[3:5, 2:4, 1:] = 3
    labels[6, 5, 2:] = 4
    labels[7, 2, 0] = 4
    return labels


def oblique_axes_mm() -> np.ndarray:
    """Columns: steps along i, j, k [mm], turned by 20, -15 and 30 degrees about x, y and z."""
    a, b, c = np.radians([20.0, -15.0, 30.0])
    rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    ry = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    rz = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return rz @ ry @ rx * np.array(SPACING_MM)


ORIGIN_MM = np.array([-37.0, 112.5, 260.25])


def header(**changes: Any) -> dict[str, Any]:
    """The header of a NRRD volume in LPS; a change to None removes the field."""
    fields: dict[str, Any] = {
        "space": "left-posterior-superior",
        "space directions": oblique_axes_mm().T,
        "space origin": ORIGIN_MM,
        "kinds": ["domain"] * 3,
        "encoding": "gzip",
    }
    fields |= changes
    return {key: value for key, value in fields.items() if value is not None}


def write_nrrd(path: Path, labels: np.ndarray | None = None, **changes: Any) -> Path:
    """A NRRD file of `labels` (default: the asymmetric ones)."""
    nrrd.write(str(path), asymmetric_labels() if labels is None else labels, header(**changes))
    return path


def points_by_label_mm(labels: np.ndarray, axes: np.ndarray, origin: np.ndarray) -> dict[int, Any]:
    """Centres of each label's voxels (n, 3), sorted."""
    result = {}
    for value in np.unique(labels[labels > 0]):
        index = np.argwhere(labels == value)
        points = np.round(origin + index @ axes.T, 6)
        result[int(value)] = points[np.lexsort(points.T)]
    return result

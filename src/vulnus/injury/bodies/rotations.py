"""Rotations of solids and rigid bodies as matrices (3, 3) from own axes to the world's."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from ..checked_values import finite, numbers, one_of, unit_vector

Axis = Literal["x", "y", "z", "-x", "-y", "-z"] | Vector3
"""The name of a coordinate axis, with "-" against it, or any vector along the wanted one."""

UNIT_AXES: dict[str, Vector3] = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}
ORTHONORMAL_WITHIN = 1e-6  # [chosen: above the round-off of float32, below what matters]


def axis_vector(name: str, axis: Axis) -> FloatArray:
    """Unit vector (3,) of an axis given by its name or by any vector along it."""
    given = UNIT_AXES[one_of(name, axis, UNIT_AXES)] if isinstance(axis, str) else axis
    return np.array(unit_vector(name, given), dtype=np.float64)


def axis_frame(axis: Axis) -> FloatArray:
    """Rotation (3, 3) that turns z to `axis`; along a coordinate axis it permutes the axes."""
    third = axis_vector("axis", axis)
    if np.max(np.abs(third)) == 1.0:
        first = np.roll(third, 1)
    else:
        helper = np.eye(3)[int(np.argmin(np.abs(third)))]
        first = np.cross(helper, third)
        first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(third, first), third])


def rotation_about(axis: Axis, angle: float) -> FloatArray:
    """Rotation matrix (3, 3) by `angle` [rad] about `axis`, by the right hand (Rodrigues)."""
    x, y, z = axis_vector("axis", axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = finite("angle", angle)
    rotation: FloatArray = np.eye(3) + np.sin(turn) * cross + (1.0 - np.cos(turn)) * (cross @ cross)
    return rotation


def rotation_matrix(rotation: AnyArray | Any) -> FloatArray:
    """A matrix (3, 3) or a `scipy.spatial.transform.Rotation` as a checked rotation matrix."""
    matrix = numbers(rotation.as_matrix() if hasattr(rotation, "as_matrix") else rotation)
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
        raise ScenarioError(
            "rotation", f"has the shape {matrix.shape}, must be (3, 3)", "Use rotation_about."
        )
    error = float(np.max(np.abs(matrix @ matrix.T - np.eye(3))))
    if error > ORTHONORMAL_WITHIN or np.linalg.det(matrix) < 0.0:
        raise ScenarioError(
            "rotation",
            f"is not a rotation (R R^T differs from the identity by {error:.1e})",
            "Use rotation_about(axis, angle) or a scipy Rotation.",
        )
    return matrix

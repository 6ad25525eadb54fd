"""What stands for a whole of which a half, or a quarter, was computed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from ..bodies.rotations import Axis, axis_vector
from ..checked_values import shown, vector

Plane = tuple[Vector3, Axis]
"""A plane of symmetry: a point on it [m], and its normal."""


class Mirror:
    """The reflection at a plane through `point` [m]."""

    def __init__(self, point: Vector3, normal: Axis) -> None:
        self._point = np.asarray(vector("point of the mirror", point))
        across = axis_vector("normal of the mirror", normal)
        self.matrix: FloatArray = np.eye(3) - 2.0 * np.outer(across, across)

    def places(self, position: FloatArray) -> FloatArray:
        """Mirror images of positions (n, 3) [m]."""
        mirrored: FloatArray = (position - self._point) @ self.matrix + self._point
        return mirrored

    def vectors(self, vectors: FloatArray) -> FloatArray:
        """Mirror images of vectors (n, 3) such as velocities."""
        mirrored: FloatArray = vectors @ self.matrix
        return mirrored

    def tensors(self, tensors: FloatArray) -> FloatArray:
        """Mirror images of tensors (n, 3, 3) such as stresses."""
        mirrored: FloatArray = self.matrix @ tensors @ self.matrix
        return mirrored


def mirrored_at_all(position: FloatArray, planes: Sequence[Plane]) -> FloatArray:
    """Positions (n, 3) [m] with their mirror images at one plane after the other."""
    for plane in planes:
        if isinstance(plane, str) or not isinstance(plane, Sequence) or len(plane) != 2:
            raise ScenarioError(
                "symmetry",
                f"holds {shown(plane)}, must hold planes",
                'Give a tuple of planes, each a point and a normal: (((0, 0, 0), "y"),).',
            )
        point, normal = plane
        position = np.concatenate([position, Mirror(point, normal).places(position)])
    return position

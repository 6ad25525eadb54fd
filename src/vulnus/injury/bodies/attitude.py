"""How a body lies on its way: nose ahead, turned by yaw, pitch and roll."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3

from ..checked_values import finite
from .rotations import Axis, axis_vector, rotation_about

UP: Vector3 = (0.0, 0.0, 1.0)
"""Proximal in the patient frame: up for a standing patient."""


def attitude(
    direction: Axis,
    *,
    yaw: float = 0.0,
    pitch: float = 0.0,
    roll: float = 0.0,
    up: Axis = UP,
) -> FloatArray:
    """Rotation (3, 3) of the body's frame into the world's for a flight along `direction`.

    Without angles [rad] the body's +x (its nose) lies along the flight and its +z (the width of a
    blade) as near to `up` as can be. Then it is turned as a flier sees it: `yaw` moves the nose to
    the right, `pitch` upwards, and `roll` turns it about its long axis, clockwise from behind.
    """
    nose = axis_vector("direction", direction)
    above = axis_vector("up", up)
    if abs(float(nose @ above)) > 1.0 - 1e-9:  # straight up or down: the next axis is up
        above = np.roll(above, 1)
    left = np.cross(above, nose)
    left /= np.linalg.norm(left)
    level = np.column_stack([nose, left, np.cross(nose, left)])
    turned: FloatArray = (
        level
        @ rotation_about("z", -finite("yaw", yaw))
        @ rotation_about("y", -finite("pitch", pitch))
        @ rotation_about("x", finite("roll", roll))
    )
    return turned

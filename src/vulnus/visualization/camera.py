"""Cameras that hold what they shall show: closed-form framing of a set of points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.arrays import AnyArray, FloatArray, Vector3


def unit(vector: AnyArray | Vector3) -> FloatArray:
    """The vector at length one, (3,); a zero vector stays zero."""
    array = np.asarray(vector, dtype=np.float64)
    length = float(np.linalg.norm(array))
    return array / length if length > 0.0 else array


@dataclass(frozen=True, slots=True)
class Camera:
    """A perspective camera.

    `origin`, `target` [m]; `up` unit vector; `field_of_view` [rad] across the width; `width`,
    `height` [px].
    """

    origin: Vector3
    target: Vector3
    up: Vector3
    field_of_view: float
    width: int
    height: int

    @property
    def axes(self) -> FloatArray:
        """Rows: right, up and backward (towards the viewer) unit vectors, (3, 3)."""
        backward = unit(np.subtract(self.origin, self.target))
        right = unit(np.cross(self.up, backward))
        return np.stack([right, np.cross(backward, right), backward])

    def project(self, points: AnyArray) -> FloatArray:
        """Pixel coordinates (n, 2) of `points` (n, 3) [m]; x to the right, y downwards."""
        right, up, backward = ((np.asarray(points, np.float64) - self.origin) @ self.axes.T).T
        focal = 0.5 * self.width / np.tan(0.5 * self.field_of_view)
        x = 0.5 * self.width - focal * right / backward
        y = 0.5 * self.height + focal * up / backward
        return np.stack([x, y], axis=-1)


def frame_points(
    points: AnyArray,
    *,
    toward_camera: AnyArray | Vector3,
    up: AnyArray | Vector3,
    width: int,
    height: int,
    field_of_view: float = np.deg2rad(24.0),
    margin: float = 0.06,
) -> Camera:
    """The nearest camera in a direction that sees all `points` (n, 3) [m].

    `margin` is the free fraction at each border. The field of view (chosen: 24°, a portrait lens)
    is that of the longer side. In camera axes a point (u, v, w) is inside the frame of a camera at
    distance D and offset c when |u - c| <= (D - w) tan(a); the least D has a closed form.
    """
    backward = unit(toward_camera)
    right = unit(np.cross(up, backward))
    upward = np.cross(backward, right)
    tangent_long = np.tan(0.5 * field_of_view)
    tangent_x = tangent_long * min(1.0, width / height)
    tangent_y = tangent_x * height / width
    u, v, w = (np.asarray(points, np.float64) @ np.stack([right, upward, backward]).T).T
    t_x, t_y = (1.0 - 2.0 * margin) * tangent_x, (1.0 - 2.0 * margin) * tangent_y
    u_high, u_low = np.max(u + w * t_x), np.min(u - w * t_x)
    v_high, v_low = np.max(v + w * t_y), np.min(v - w * t_y)
    distance = max((u_high - u_low) / (2.0 * t_x), (v_high - v_low) / (2.0 * t_y))
    nearest = float(np.max(w))
    distance = max(distance, nearest + 1e-3)  # a single point still needs a camera before it
    offset_u, offset_v = 0.5 * (u_high + u_low), 0.5 * (v_high + v_low)
    origin = offset_u * right + offset_v * upward + distance * backward
    target = origin - (distance - float(np.mean(w))) * backward
    return Camera(
        origin=_triple(origin),
        target=_triple(target),
        up=_triple(upward),
        field_of_view=float(2.0 * np.arctan(tangent_x)),
        width=width,
        height=height,
    )


def frame_sphere(
    centre: AnyArray | Vector3,
    radius: float,
    *,
    toward_camera: AnyArray | Vector3,
    up: AnyArray | Vector3,
    width: int,
    height: int,
) -> Camera:
    """A close view: a camera whose picture holds a disk of `radius` [m] about `centre` [m]."""
    backward = unit(toward_camera)
    right = unit(np.cross(up, backward))
    spokes = radius * np.stack([right, np.cross(backward, right)])
    points = np.asarray(centre, np.float64) + np.concatenate([spokes, -spokes])
    return frame_points(
        points, toward_camera=toward_camera, up=up, width=width, height=height, margin=0.0
    )


def side_direction(
    up: AnyArray | Vector3,
    *,
    long_axis: AnyArray | Vector3,
    facing: AnyArray | Vector3,
    elevation: float = np.deg2rad(14.0),
) -> FloatArray:
    """The direction from the scene to a viewer who stands beside it, a unit vector (3,).

    The viewer looks down by `elevation` [rad], across the limb's `long_axis` where it lies, and
    has the `facing` direction (of the jet) towards him but well to one side, where a parabola
    shows. Chosen from 72 azimuths by a smooth score; equal input gives an equal view.
    """
    upward = unit(up)
    first = np.cross(upward, unit(long_axis))  # a lying limb is seen exactly across its axis
    if float(np.linalg.norm(first)) < 0.1:
        first = np.cross(upward, np.eye(3)[int(np.argmin(np.abs(upward)))])
    first = unit(first)
    second = np.cross(upward, first)
    angles = np.deg2rad(5.0) * np.arange(72)
    horizontal = np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second
    along = np.abs(horizontal @ unit(long_axis))
    sideways = horizontal @ unit(facing)
    score = -2.0 * along**2 - (sideways - 0.55) ** 2
    best = horizontal[int(np.argmax(np.round(score, 9)))]
    return unit(np.cos(elevation) * best + np.sin(elevation) * upward)


def _triple(vector: FloatArray) -> Vector3:
    x, y, z = (float(component) for component in vector)
    return x, y, z

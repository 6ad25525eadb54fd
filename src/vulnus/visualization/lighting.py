"""A soft photographic studio that moves with the camera: sky, key, fill and rim light."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.arrays import FloatArray, Vector3
from .camera import Camera, unit

# name, direction from the scene in camera axes (right, up, towards the viewer), half size and
# distance in scene radii, radiance; chosen by eye: key/fill 4:1, warm key, cool rim.
_AREA_LIGHTS: tuple[tuple[str, Vector3, float, float, Vector3], ...] = (
    ("key", (-0.80, 0.95, 0.95), 1.6, 4.0, (6.4, 6.0, 5.5)),
    ("fill", (1.00, 0.25, 0.70), 1.8, 4.5, (1.0, 1.02, 1.08)),
    ("rim", (0.65, 0.75, -0.95), 1.2, 4.0, (2.6, 2.7, 2.9)),
)


def sky_image(top: float = 0.50, bottom: float = 0.22, rows: int = 32) -> FloatArray:
    """A neutral vertical gradient (rows, 2 rows, 3) of radiance, from zenith to nadir."""
    height = 0.5 + 0.5 * np.cos(np.pi * (np.arange(rows) + 0.5) / rows)
    level = bottom + (top - bottom) * height
    column = level[:, None] * np.array([0.97, 1.0, 1.04])
    return np.ascontiguousarray(np.repeat(column[:, None, :], 2 * rows, axis=1))


def studio_lights(
    mitsuba: Any,
    camera: Camera,
    centre: FloatArray,
    radius: float,
    up: FloatArray,
    *,
    lamp: float = 0.0,
) -> dict[str, Any]:
    """Mitsuba's emitters around a scene of `radius` [m] about `centre` [m], with `up` upwards.

    `lamp` is the radiance of a lamp beside the camera, as wounds are photographed with.
    """
    transform = mitsuba.ScalarTransform4f
    first = unit(np.cross([0.0, 1.0, 0.0] if abs(up[1]) < 0.9 else [1.0, 0.0, 0.0], up))
    turn = np.eye(4)
    turn[:3, :3] = np.stack([first, up, np.cross(first, up)], axis=1)
    bitmap = mitsuba.Bitmap(sky_image().astype(np.float32))
    lights: dict[str, Any] = {
        "sky": {"type": "envmap", "bitmap": bitmap, "to_world": transform(turn.tolist())}
    }
    right, upward, backward = camera.axes
    # The studio stands upright, also for a camera that looks down.
    above = up if abs(float(up @ upward)) > 0.3 else upward
    forward = unit(backward - float(backward @ above) * above)
    for name, direction, half_size, distance, radiance in _AREA_LIGHTS:
        toward = unit(direction[0] * right + direction[1] * above + direction[2] * forward)
        origin = centre + distance * radius * toward
        pose = transform().look_at(
            origin=origin.tolist(),
            target=centre.tolist(),
            up=unit(np.cross(toward, right)).tolist(),
        )
        lights[name] = {
            "type": "rectangle",
            "to_world": pose @ transform().scale(half_size * radius),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(radiance)}},
        }
    if lamp > 0.0:
        lights["lamp"] = _lamp(mitsuba, camera, lamp)
    return lights


def _lamp(mitsuba: Any, camera: Camera, radiance: float) -> dict[str, Any]:
    """A small square lamp just above the camera, that shines where it looks."""
    transform = mitsuba.ScalarTransform4f
    distance = float(np.linalg.norm(np.subtract(camera.origin, camera.target)))
    origin = np.asarray(camera.origin) + 0.06 * distance * camera.axes[1]
    pose = transform().look_at(
        origin=origin.tolist(), target=list(camera.target), up=camera.axes[0].tolist()
    )
    return {
        "type": "rectangle",
        "to_world": pose @ transform().scale(0.05 * distance),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 3 * [radiance]}},
    }

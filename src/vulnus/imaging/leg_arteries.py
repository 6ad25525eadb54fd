"""The built-in leg's arteries: courses from the table kept clear of the bones; their voxels."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from vulnus.core.arrays import FloatArray, LabelArray
from vulnus.core.handoff import ArteryCentreline, Tissue

from .leg_shape import HIGHEST_LEVEL, LOWEST_LEVEL, LegShape
from .leg_tables import artery_rows

PARENTS: dict[str, str | None] = {
    "popliteal": None,
    "anterior_tibial": "popliteal",
    "posterior_tibial": "popliteal",
    "fibular": "popliteal",
}
_STEP = 2.0e-3
"""Distance of two points of a centre-line [m]; chosen: below an artery's diameter."""

_CLEARANCE = 1.5e-3
"""Least tissue between lumen and bone [m]; chosen: wall (0.5 mm) and sheath."""

_ROUNDS = 4
"""Times that a point is moved off both bones in turn; where they meet, two rounds are needed."""


def leg_arteries(shape: LegShape) -> tuple[ArteryCentreline, ...]:
    """The four arteries, proximal to distal, about 2 mm from point to point."""
    radii = {
        "popliteal": shape.leg.popliteal_radius,
        "anterior_tibial": shape.leg.anterior_tibial_radius,
        "posterior_tibial": shape.leg.posterior_tibial_radius,
        "fibular": shape.leg.fibular_radius,
    }
    return tuple(_course(shape, name, radii[name], parent) for name, parent in PARENTS.items())


def _course(shape: LegShape, name: str, radius: float, parent: str | None) -> ArteryCentreline:
    rows = artery_rows(name)
    level = rows[:, 0]
    scale = np.array([shape.scale(value) for value in level])
    knots = np.column_stack([rows[:, 1] * scale, rows[:, 2] * scale, level, rows[:, 3] * radius])
    length = np.column_stack([knots[:, :2], level * shape.leg.tibia_length])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(length, axis=0), axis=1))])
    course = PchipInterpolator(arc, knots)(np.linspace(0.0, arc[-1], round(arc[-1] / _STEP) + 1))
    course = course[(course[:, 2] <= HIGHEST_LEVEL) & (course[:, 2] >= LOWEST_LEVEL)]
    for row in course:
        row[:2] = _clear_of_bones(shape, row[:2], row[2], row[3] + _CLEARANCE)
    points = np.column_stack([course[:, :2], course[:, 2] * shape.leg.tibia_length])
    return ArteryCentreline(name, np.ascontiguousarray(points), course[:, 3].copy(), parent)


def _clear_of_bones(
    shape: LegShape, place: FloatArray, level: float, distance: float
) -> FloatArray:
    """Move a point of a section out of both bones' neighbourhood."""
    scale = shape.scale(level)
    bones = [shape.bone(name, level, scale) for name in ("tibia", "fibula")]
    zones = [bone.offset(distance) for bone in bones if bone is not None]
    for _ in range(_ROUNDS):
        moved = False
        for zone in zones:
            away, radius = zone.radius_at(place[:1], place[1:])
            if away[0] < radius[0]:
                place = zone.centre + (place - zone.centre) * (radius[0] / away[0])
                moved = True
        if not moved:
            break
    return place


def paint_arteries(
    labels: LabelArray,
    arteries: tuple[ArteryCentreline, ...],
    origin: FloatArray,
    voxel: float,
) -> None:
    """Label the voxels whose centres lie in a lumen, and those that its centre-line passes.

    So an artery stays in one piece where it is thinner than a voxel. Bone, skin and air keep
    their labels.
    """
    soft = np.isin(np.arange(256), [Tissue.MUSCLE, Tissue.FAT, Tissue.ARTERY])
    for artery in arteries:
        for point, radius in zip(*_dense(artery, 0.25 * voxel), strict=True):
            reach = max(float(radius), 0.5 * voxel)
            low = np.maximum(np.ceil((point - reach - origin) / voxel).astype(int), 0)
            high = np.floor((point + reach - origin) / voxel).astype(int) + 1
            block = labels[tuple(slice(a, b) for a, b in zip(low, high, strict=True))]
            index = np.indices(block.shape).reshape(3, -1).T + low
            offset = np.abs(origin + voxel * index - point)
            near = (np.linalg.norm(offset, axis=1) < radius) | (offset <= 0.5 * voxel).all(axis=1)
            hit = near.reshape(block.shape) & soft[block]
            block[hit] = Tissue.ARTERY


def _dense(artery: ArteryCentreline, step: float) -> tuple[FloatArray, FloatArray]:
    edges = np.linalg.norm(np.diff(artery.points, axis=0), axis=1)
    arc = np.concatenate([[0.0], np.cumsum(edges)])
    fine = np.linspace(0.0, arc[-1], max(2, round(arc[-1] / step)))
    points = np.column_stack([np.interp(fine, arc, artery.points[:, i]) for i in range(3)])
    return points, np.interp(fine, arc, artery.radius)

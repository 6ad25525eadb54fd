"""The leg that vulnus brings with it: a lower leg from under the knee to the ankle, any voxel size.

Origin: the middle of the ankle (the tibia's distal joint face), z up along the tibia, x to the
patient's left, y posterior. The volume ends are plane cuts through the leg.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from vulnus.core.arrays import BoolArray, FloatArray, LabelArray
from vulnus.core.errors import InputFileError
from vulnus.core.handoff import ArteryCentreline, LabelVolume, Tissue
from vulnus.core.progress import Progress
from vulnus.core.units import MILLIMETRE

from .leg_arteries import leg_arteries, paint_arteries
from .leg_shape import HIGHEST_LEVEL, LOWEST_LEVEL, LegSection, LegShape
from .leg_tables import muscle_tables
from .measurements import measurement
from .parameters import ImagingParameters

_COMPARTMENTS = {
    "tibialis_anterior": "anterior",
    "extensor_digitorum_longus": "anterior",
    "extensor_hallucis_longus": "anterior",
    "peroneus_longus": "lateral",
    "tibialis_posterior": "deep posterior",
    "flexor_digitorum_longus": "deep posterior",
    "flexor_hallucis_longus": "deep posterior",
    "popliteus": "deep posterior",
    "soleus": "soleus",
    "soleus_medial": "soleus",
    "soleus_lateral": "soleus",
    "achilles": "soleus",
    "gastrocnemius_lateral": "lateral head",
    "gastrocnemius_medial_anterior": "medial head",
    "gastrocnemius_medial_posterior": "medial head",
}
"""What septa part: the four compartments (Gray's Anatomy), the superficial posterior one in its
soleus and the two heads of gastrocnemius."""

_SEPTUM = 1.6e-3
"""Thickness of fascia and fat between two compartments [m]; chosen: 1-2 mm on MR images, and
still seen at the default voxel."""

_GAP_LEVELS = (0.12, 0.30)
_GAPS = (3.0e-3, 6.0e-3)
"""Distance to its muscle's ellipse up to which tissue is muscle [m]; chosen: tendons lie apart in
fat at the ankle, bellies fill the fascia above it."""

_MARGIN = 3
"""Voxels of air round the leg."""

_VOXEL_LIMITS = (0.2e-3, 6.0e-3)
"""Voxel sizes [m]; chosen: 4 GB of labels, and a tibia of four voxels."""

_MEASUREMENT_LIMITS = (0.5, 1.8)
"""What a measurement may be as a multiple of the table's; chosen: from a child to an obese man."""


def generate_leg(parameters: ImagingParameters, progress: Progress) -> LabelVolume:
    """The built-in leg as labelled voxels with its arteries as centre-lines.

    The same shape at every voxel size; a right leg is the left one mirrored.
    """
    _check(parameters)
    shape = LegShape(parameters.leg)
    voxel = parameters.voxel
    bottom = shape.height(LOWEST_LEVEL)
    count = round((shape.height(HIGHEST_LEVEL) - bottom) / voxel)
    heights = bottom + (np.arange(count) + 0.5) * voxel
    sections = [shape.section(height / parameters.leg.tibia_length) for height in heights]
    x, y = _grid(sections, voxel)
    labels = np.zeros((x.size, y.size, count), dtype=np.uint8)
    progress.begin("imaging", float(count), "slices")
    for k, section in enumerate(sections):
        labels[:, :, k] = _paint_section(section, x, y)
        progress.update(k + 1.0)
    progress.end()
    arteries = leg_arteries(shape)
    origin = np.array([x[0], y[0], heights[0]])
    paint_arteries(labels, arteries, origin, voxel)
    return _finish(parameters, labels, origin, arteries)


def _check(parameters: ImagingParameters) -> None:
    low, high = (limit / MILLIMETRE for limit in _VOXEL_LIMITS)
    if not _VOXEL_LIMITS[0] <= parameters.voxel <= _VOXEL_LIMITS[1]:
        raise InputFileError(
            "imaging.voxel_mm",
            f"{parameters.voxel / MILLIMETRE:g} mm is outside {low:g} to {high:g} mm",
            "Give the built-in leg a voxel size in this range",
        )
    for entry in fields(parameters.leg):
        value, usual = getattr(parameters.leg, entry.name), measurement(entry.name)
        if not _MEASUREMENT_LIMITS[0] * usual <= value <= _MEASUREMENT_LIMITS[1] * usual:
            low, high = (limit * usual / MILLIMETRE for limit in _MEASUREMENT_LIMITS)
            raise InputFileError(
                f"imaging.leg.{entry.name}",
                f"{value / MILLIMETRE:g} mm is outside {low:g} to {high:g} mm",
                f"An average man's is {usual / MILLIMETRE:g} mm",
            )


def _grid(sections: list[LegSection], voxel: float) -> tuple[FloatArray, FloatArray]:
    """Voxel centres along x and y, at odd multiples of half a voxel, with a margin of air."""
    points = np.concatenate([section.skin.points for section in sections])
    low = np.floor(points.min(axis=0) / voxel).astype(int) - _MARGIN
    high = np.ceil(points.max(axis=0) / voxel).astype(int) + _MARGIN
    axes = [(np.arange(a, b) + 0.5) * voxel for a, b in zip(low, high, strict=True)]
    return axes[0], axes[1]


def _paint_section(section: LegSection, x: FloatArray, y: FloatArray) -> LabelArray:
    """Labels (nx, ny) of one slice."""
    labels = np.zeros((x.size, y.size), dtype=np.uint8)
    gx, gy = (axis.ravel() for axis in np.meshgrid(x, y, indexing="ij"))
    flat = labels.ravel()
    distance, radius = section.skin.radius_at(gx, gy)
    inside = np.flatnonzero(distance < radius)
    flat[inside] = Tissue.SKIN
    gx, gy = gx[inside], gy[inside]
    distance, radius = section.fat.radius_at(gx, gy)
    tissue = np.where(distance < radius, Tissue.FAT, Tissue.SKIN).astype(np.uint8)
    distance, radius = section.fascia.radius_at(gx, gy)
    within = distance < radius
    tissue[within & _is_muscle(section, gx, gy)] = Tissue.MUSCLE
    for bone in section.bones:
        for contour, code in (
            (bone.outer, Tissue.BONE),
            (bone.inner, Tissue.CANCELLOUS),
            (bone.canal, Tissue.MARROW),
        ):
            distance, radius = contour.radius_at(gx, gy)
            tissue[distance < radius] = code
    flat[inside] = tissue
    return labels


def _is_muscle(section: LegSection, x: FloatArray, y: FloatArray) -> BoolArray:
    """Whether points belong to a muscle: near its ellipse, and off the septa of compartments."""
    nearest: dict[str, FloatArray] = {}
    for muscle in muscle_tables():
        if not muscle.lowest <= section.level <= muscle.highest:
            continue
        middle, matrix = muscle.at(section.level)
        middle, matrix = middle * section.scale, matrix * section.scale
        dx, dy = x - middle[0], y - middle[1]
        inverse = np.linalg.inv(matrix)
        size = np.hypot(
            inverse[0, 0] * dx + inverse[0, 1] * dy, inverse[1, 0] * dx + inverse[1, 1] * dy
        )
        # Distance to the ellipse along the ray from its middle.
        away = np.hypot(dx, dy) * (1.0 - 1.0 / np.maximum(size, 1e-3))
        name = _COMPARTMENTS[muscle.name]
        nearest[name] = np.minimum(nearest[name], away) if name in nearest else away
    if not nearest:
        return np.zeros(x.shape, dtype=bool)
    ordered = np.sort(np.stack(list(nearest.values())), axis=0)
    second = ordered[1] if len(ordered) > 1 else np.inf
    gap = np.interp(section.level, _GAP_LEVELS, _GAPS)
    belly: BoolArray = (ordered[0] < gap) & (second - ordered[0] > _SEPTUM)
    return belly


def _finish(
    parameters: ImagingParameters,
    labels: LabelArray,
    origin: FloatArray,
    arteries: tuple[ArteryCentreline, ...],
) -> LabelVolume:
    if parameters.side == "right":
        labels = np.ascontiguousarray(labels[::-1])
        origin = origin * np.array([-1.0, 1.0, 1.0])
        origin[0] -= (labels.shape[0] - 1) * parameters.voxel
        mirror = np.array([-1.0, 1.0, 1.0])
        arteries = tuple(
            ArteryCentreline(a.name, a.points * mirror, a.radius, a.parent) for a in arteries
        )
    return LabelVolume(
        labels=labels,
        origin=origin,
        spacing=np.full(3, parameters.voxel),
        direction=np.eye(3),
        arteries=arteries,
        source=f"built-in leg, {parameters.voxel / MILLIMETRE:g} mm voxels",
        side=parameters.side,
    )

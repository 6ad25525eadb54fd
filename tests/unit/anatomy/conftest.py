"""A small synthetic limb: a tapered cylinder with skin, bone with marrow and one artery."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from vulnus.core.handoff import ArteryCentreline, LabelVolume, Tissue

LENGTH, RADIUS, SKIN, BONE_RADIUS, MARROW_RADIUS = 60e-3, 24e-3, 2e-3, 7e-3, 4e-3
ARTERY_RADIUS, ARTERY_PLACE = 1.2e-3, np.array([-9e-3, -8e-3])


def rotation(axis: list[float], angle: float) -> np.ndarray:
    axis = np.asarray(axis) / np.linalg.norm(axis)
    k = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * k.T + (1 - np.cos(angle)) * (k.T @ k.T)


@pytest.fixture(scope="session")
def make_limb() -> Callable[..., LabelVolume]:
    """Labels of a limb along the grid's third axis, cut by the image at both ends.

    `direction` and `origin` place the grid; `spacing` [m] of its voxels.
    """

    def make(
        spacing=(1e-3, 1e-3, 1e-3),
        direction=None,
        origin=(0.0, 0.0, 0.0),
        *,
        fat=False,
        arteries=True,
    ) -> LabelVolume:
        direction = np.eye(3) if direction is None else direction
        spacing, origin = np.asarray(spacing), np.asarray(origin)
        half = RADIUS + 4e-3
        shape = np.rint(np.array([2 * half, 2 * half, LENGTH]) / spacing).astype(int)
        x, y, z = (s * (np.arange(n) - (n - 1) / 2) for n, s in zip(shape, spacing, strict=True))
        x, y, z = np.meshgrid(x, y, z, indexing="ij", sparse=True)
        depth = RADIUS - np.hypot(x, y) + 0 * z
        labels = np.zeros(shape, dtype=np.uint8)
        labels[depth > 0] = Tissue.SKIN
        labels[depth > SKIN] = Tissue.FAT if fat else Tissue.MUSCLE
        labels[depth > SKIN + 4e-3] = Tissue.MUSCLE
        bone = np.hypot(x - 5e-3, y) + 0 * z
        labels[bone < BONE_RADIUS] = Tissue.BONE
        labels[bone < MARROW_RADIUS] = Tissue.MARROW
        a, b = ARTERY_PLACE
        labels[np.hypot(x - a, y - b) + 0 * z < ARTERY_RADIUS] = Tissue.ARTERY
        middle = spacing * (shape - 1) / 2
        along = np.linspace(LENGTH / 2, -LENGTH / 2, 31)
        local = np.column_stack([np.full(31, a), np.full(31, b), along]) + middle
        artery = ArteryCentreline(
            name="anterior_tibial",
            points=origin + local @ direction.T,
            radius=np.full(31, ARTERY_RADIUS),
        )
        return LabelVolume(
            labels=labels,
            origin=origin.astype(float),
            spacing=spacing.astype(float),
            direction=np.asarray(direction, dtype=float),
            arteries=(artery,) if arteries else (),
            source="synthetic limb",
        )

    return make

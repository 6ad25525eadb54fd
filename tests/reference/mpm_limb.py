"""A small synthetic limb: a cylinder of muscle with a skin shell, a bone rod and an artery."""

from __future__ import annotations

import numpy as np

from vulnus.core.handoff import ArteryCentreline, LimbModel, Tissue, TriangleSurface


def cylinder_surface(radius: float, length: float, *, sides: int = 96) -> TriangleSurface:
    """Closed cylinder along z, centred at the origin, outward triangles."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    rings = int(np.ceil(length / (2.0 * np.pi * radius / sides)))
    height = np.linspace(-0.5 * length, 0.5 * length, rings + 1)
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.concatenate(
        [np.column_stack([ring, np.full(sides, z)]) for z in height]
        + [[[0.0, 0.0, height[0]], [0.0, 0.0, height[-1]]]]
    )
    triangles = []
    bottom, top = len(vertices) - 2, len(vertices) - 1
    for k in range(sides):
        n = (k + 1) % sides
        for r in range(rings):
            a, b = r * sides + k, r * sides + n
            c, d = a + sides, b + sides
            triangles += [(a, b, d), (a, d, c)]
        triangles += [(bottom, n, k), (top, rings * sides + k, rings * sides + n)]
    return TriangleSurface(vertices.astype(np.float32), np.array(triangles, np.int32))


def synthetic_limb(
    *,
    spacing: float = 0.002,
    radius: float = 0.02,
    length: float = 0.08,
    skin: float = 0.003,
    bone_radius: float = 0.005,
    bone_at: tuple[float, float] = (0.008, 0.008),
    artery_at: tuple[float, float] = (-0.003, 0.0),
    seed: int = 1,
) -> LimbModel:
    """The limb on a jittered lattice; every point stands for spacing³ of tissue."""
    rng = np.random.default_rng(seed)
    half = int(np.ceil(radius / spacing))
    layers = round(length / spacing)
    axis = (np.arange(-half, half) + 0.5) * spacing
    height = (np.arange(layers) + 0.5) * spacing - 0.5 * length
    grid = np.stack(np.meshgrid(axis, axis, height, indexing="ij"), axis=-1).reshape(-1, 3)
    distance = np.hypot(grid[:, 0], grid[:, 1])
    grid = grid[distance < radius]
    distance = np.hypot(grid[:, 0], grid[:, 1])
    tissue = np.full(len(grid), Tissue.MUSCLE, np.uint8)
    from_bone = np.hypot(grid[:, 0] - bone_at[0], grid[:, 1] - bone_at[1])
    tissue[from_bone < bone_radius] = Tissue.BONE
    tissue[distance > radius - skin] = Tissue.SKIN
    grid += rng.uniform(-0.2, 0.2, grid.shape) * spacing
    line = np.linspace(0.5 * length, -0.5 * length, 21)
    points = np.column_stack([np.full(21, artery_at[0]), np.full(21, artery_at[1]), line])
    artery = ArteryCentreline("anterior_tibial", points, np.full(21, 0.0013))
    return LimbModel(
        position=grid.astype(np.float32),
        tissue=tissue,
        volume=np.full(len(grid), spacing**3, np.float32),
        spacing=0.6 * spacing,
        arteries=(artery,),
        surfaces={"skin": cylinder_surface(radius, length)},
        side="left",
        source="synthetic cylinder",
    )

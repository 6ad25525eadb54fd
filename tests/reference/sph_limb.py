"""A cylinder of muscle with skin, a bone and an open tract across it, cut artery in the middle."""

from __future__ import annotations

import numpy as np

from vulnus.core.handoff import InjuredArtery, InjuredLimb, ShotLine, Tissue, VesselInjury
from vulnus.hemorrhage import _native

RADIUS = 0.03
HALF_LENGTH = 0.04
BONE_RADIUS = 0.007
BONE_CENTER = (0.0, 0.012)


def wounded_limb(
    *,
    spacing: float = 2e-3,
    tract_radius: float = 5e-3,
    entry_open: bool = True,
    exit_open: bool = True,
    skin_thickness: float = 2e-3,
    seed: int = 3,
) -> InjuredLimb:
    """A limb along z with its tract along y = -8 mm from -x (entry) to +x (exit)."""
    rng = np.random.default_rng(seed)
    high = np.array([RADIUS, RADIUS, HALF_LENGTH])
    darts = rng.uniform(-high, high, (int(30 * 8 * high.prod() / spacing**3), 3))
    points = darts[_native.thin_points(darts, spacing)]
    r = np.hypot(points[:, 0], points[:, 1])
    points, r = points[r < RADIUS], r[r < RADIUS]
    tissue = np.full(len(points), Tissue.MUSCLE, dtype=np.uint8)
    to_bone = np.hypot(points[:, 0] - BONE_CENTER[0], points[:, 1] - BONE_CENTER[1])
    tissue[to_bone < BONE_RADIUS] = Tissue.BONE
    tissue[r > RADIUS - skin_thickness] = Tissue.SKIN
    volume = np.full(len(points), np.pi * RADIUS**2 * 2 * HALF_LENGTH / len(points), np.float32)
    to_line = np.hypot(points[:, 1] + 8e-3, points[:, 2])
    deformed = points.copy()
    tract = to_line < tract_radius
    skin = tissue == Tissue.SKIN
    if not entry_open:
        tract &= ~(skin & (points[:, 0] < 0.0))
    if not exit_open:
        tract &= ~(skin & (points[:, 0] > 0.0))
    # Tissue of the tract is pressed into its wall.
    outward = points[:, 1:] - np.array([-8e-3, 0.0])
    norm = np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-9)
    moved = np.array([-8e-3, 0.0]) + outward / norm * tract_radius
    deformed[tract, 1:] = moved[tract]
    damage = np.clip((1.6 * tract_radius - to_line) / (0.6 * tract_radius), 0.0, 1.0)
    damage[skin & ~tract] = 0.0
    line = np.linspace(-HALF_LENGTH, HALF_LENGTH, 41)
    artery = np.stack([np.full(41, 0.0), np.full(41, -8e-3), line], axis=1)
    artery_damage = np.clip((1.5 * tract_radius - np.abs(line)) / tract_radius, 0.0, 1.0)
    injury = VesselInjury(
        artery="anterior_tibial",
        arc_length=HALF_LENGTH,
        arc_fraction=0.5,
        gap=2 * tract_radius,
        lumen_radius=1.3e-3,
        position=(0.0, -8e-3, 0.0),
        position_proximal=(0.0, -8e-3, tract_radius),
        position_distal=(0.0, -8e-3, -tract_radius),
        axis_proximal=(0.0, 0.0, -1.0),
        axis_distal=(0.0, 0.0, 1.0),
    )
    shot = ShotLine(
        entry_point=(-RADIUS, -8e-3, 0.0),
        exit_point=(RADIUS, -8e-3, 0.0),
        direction=(1.0, 0.0, 0.0),
        diameter=2 * tract_radius,
        speed=300.0,
    )
    return InjuredLimb(
        position=deformed.astype(np.float32),
        reference_position=points.astype(np.float32),
        tissue=tissue,
        volume=volume,
        damage=damage.astype(np.float32),
        spacing=spacing,
        arteries=(
            InjuredArtery("anterior_tibial", artery, artery, np.full(41, 1.3e-3), artery_damage),
        ),
        injuries=(injury,),
        shot=shot,
        entry_area=np.pi * tract_radius**2,
        exit_area=np.pi * tract_radius**2,
        time=1e-3,
        steps=100,
        particle_steps_per_second=1e6,
        surfaces={},
        side="left",
    )

"""How a labelled limb becomes material points: the frozen, SI-valued parameters of the stage."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class AnatomyParameters:
    """Resolution and smoothing of the limb.

    `particle_spacing` [m]: smallest distance of two material points (the Poisson-disk radius).
    1.5 mm, chosen because two layers of points then fill the skin and the leg has about half a
    million of them (design note on imaging, §1).

    `level_set_voxel` [m]: voxel of the outer, bone and muscle level sets; None = half the particle
    spacing, within half the labels' smallest voxel (finer ones carry no information) and half the
    skin's thickness (coarser ones do not resolve its shell).

    `smoothing_iterations`: mean-curvature steps on the outer, bone and muscle surfaces. 5, as for
    the blood's surface in Chong2017 §2.3; at 0.75 mm they change the volumes by less than 0.1 %
    (design note on imaging, smoothing test).

    `skin_thickness` [m]: depth of the skin's shell under the smoothed outer surface. 2 mm, the
    thickness of the example legs; skin of the human leg measures 1.5-2.5 mm with its dermis.

    `seed`: of the Poisson-disk sampling.
    """

    particle_spacing: float = 1.5e-3
    level_set_voxel: float | None = None
    smoothing_iterations: int = 5
    skin_thickness: float = 2.0e-3
    seed: int = 1

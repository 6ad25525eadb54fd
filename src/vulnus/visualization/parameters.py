"""What pictures, film and the surface of the blood depend on; SI, with the reason of each."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ..core.arrays import Vector3
from ..core.constants import STANDARD_GRAVITY

Renderer = Literal["auto", "llvm", "scalar"]


@dataclass(frozen=True, slots=True, kw_only=True)
class BloodSurfaceParameters:
    """How the blood's particles become one surface (the paper's post-processing, §2.3).

    The paper names the sequence but neither voxel nor radius; both are chosen here and written
    under the pictures' provenance, because five iterations at a coarse voxel eat droplets.
    """

    voxel_ratio: float = 0.5
    """Voxel over particle spacing; chosen: particles stay 4 voxels wide (VISUALIZATION.md §1.2)."""

    radius_ratio: float = 1.0
    """Sphere radius over particle spacing; chosen: neighbouring spheres overlap by half."""

    iterations: int = 5
    """Mean-curvature iterations (Chong et al. 2017, §2.3)."""

    keep_droplets: bool = True
    """Draw drops that the smoothing would eat as small spheres of their own volume."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmParameters:
    """The short film of passage and bleeding."""

    enabled: bool = True
    """Make `film.mp4`."""

    width: int = 640
    """Width [px], even (H.264 4:2:0); chosen: about 1 s of rendering a frame on two cores."""

    height: int = 360
    """Height [px], even."""

    samples: int = 6
    """Paths a pixel before denoising; chosen: the same seed in all frames keeps noise still."""

    frames_per_second: float = 24.0
    """Frame rate [1/s] of the film (cinema standard)."""

    duration: float = 3.0
    """Length [s] of the bleeding part of the film; run frames are spread over it."""

    passage_duration: float = 1.5
    """Length [s] of the slow-motion passage of the projectile before it; 0 leaves it out."""

    frame_limit: int = 36
    """Most rendered frames of each part; more run frames than this are thinned out evenly."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VisualizationParameters:
    """Pictures, film and figures of one run."""

    enabled: bool = True
    """Draw anything at all."""

    stills: bool = True
    """Make the ray-traced stills (figures are made in any case)."""

    renderer: Renderer = "auto"
    """Mitsuba variant: `llvm` (fast), `scalar` (always works); `auto` probes and takes llvm."""

    width: int = 960
    """Width [px] of a still."""

    height: int = 540
    """Height [px] of a still."""

    samples: int = 16
    """Paths a pixel of a still before denoising; chosen by eye, about 15 s on two cores."""

    denoise: bool = True
    """Run Open Image Denoise with albedo and normals where it is installed."""

    seed: int = 0
    """Seed of the renderer's sampler, the same for every frame."""

    leg_opacity: float = 0.17
    """Weight of the opaque leg where the leg is drawn translucent; chosen: bones stay crisp."""

    background: Vector3 = (0.80, 0.83, 0.86)
    """Linear RGB of the studio background; chosen: neutral, a little cool against skin."""

    blood_surface: BloodSurfaceParameters = field(default_factory=BloodSurfaceParameters)
    """The blood's surface."""

    film: FilmParameters = field(default_factory=FilmParameters)
    """The film."""

    figure_dots_per_inch: int = 150
    """Resolution of the matplotlib figures [1/inch]; chosen: sharp on a lecture slide."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """What stands around the limb in a run: where down is, and a platform if there is one."""

    gravity: Vector3 = (0.0, 0.0, -STANDARD_GRAVITY)
    """Acceleration of gravity [m/s²], LPS; by default along the leg, towards the foot."""

    platform_gap: float | None = None
    """Distance [m] of a platform below the limb's lowest point; None: no platform there."""

    platform_point: Vector3 | None = None
    """The middle [m] of the platform's upper face, which lies across gravity, where given."""

    platform_half_extent: float | None = None
    """Half the side [m] of the square platform; None: a floor without end."""

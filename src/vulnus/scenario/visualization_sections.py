"""The scenario's tables about pictures: stills, figures, film and the blood's surface."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Len
from pydantic import Field

from vulnus.visualization.parameters import (
    BloodSurfaceParameters,
    FilmParameters,
    Renderer,
    VisualizationParameters,
)

from .quantity import Section, quantity, to_parameters

Brightness = Annotated[float, Field(ge=0, le=10)]


class BloodSurfaceSection(Section):
    """[visualization.blood_surface]: how blood particles become one surface."""

    voxel_ratio: float = quantity(
        BloodSurfaceParameters, "voxel_ratio", "", "voxel over particle spacing", ge=0.1, le=1
    )
    radius_ratio: float = quantity(
        BloodSurfaceParameters,
        "radius_ratio",
        "",
        "sphere radius over particle spacing",
        ge=0.3,
        le=3,
    )
    iterations: int = quantity(
        BloodSurfaceParameters, "iterations", "", "mean-curvature iterations", ge=0, le=100
    )
    keep_droplets: bool = quantity(
        BloodSurfaceParameters, "keep_droplets", "", "draw drops that the smoothing would eat"
    )


class FilmSection(Section):
    """[visualization.film]: the short film of passage and bleeding."""

    enabled: bool = quantity(FilmParameters, "enabled", "", "make film.mp4")
    width_px: int = quantity(FilmParameters, "width", "px", "even", ge=64, le=3840, multiple_of=2)
    height_px: int = quantity(FilmParameters, "height", "px", "even", ge=64, le=2160, multiple_of=2)
    samples: int = quantity(
        FilmParameters, "samples", "", "paths a pixel before denoising", ge=1, le=4096
    )
    frames_per_second: float = quantity(
        FilmParameters, "frames_per_second", "1/s", "frame rate", ge=1, le=120
    )
    duration_s: float = quantity(
        FilmParameters, "duration", "s", "length of the bleeding part", gt=0, le=600
    )
    passage_duration_s: float = quantity(
        FilmParameters,
        "passage_duration",
        "s",
        "length of the slow-motion passage before it; 0 leaves it out",
        ge=0,
        le=60,
    )
    frame_limit: int = quantity(
        FilmParameters, "frame_limit", "", "most rendered frames", ge=2, le=10000
    )


class VisualizationSection(Section):
    """[visualization]: pictures, film and figures; they change no number of the run."""

    enabled: bool = quantity(VisualizationParameters, "enabled", "", "draw anything at all")
    stills: bool = quantity(
        VisualizationParameters, "stills", "", "make the ray-traced stills (figures come anyway)"
    )
    renderer: Renderer = quantity(
        VisualizationParameters,
        "renderer",
        "",
        'Mitsuba\'s variant: "llvm" (fast), "scalar" (always works), "auto" (llvm if it works)',
    )
    width_px: int = quantity(VisualizationParameters, "width", "px", "of a still", ge=64, le=8192)
    height_px: int = quantity(VisualizationParameters, "height", "px", "of a still", ge=64, le=8192)
    samples: int = quantity(
        VisualizationParameters,
        "samples",
        "",
        "paths a pixel of a still before denoising",
        ge=1,
        le=65536,
    )
    denoise: bool = quantity(
        VisualizationParameters, "denoise", "", "use Open Image Denoise where it is installed"
    )
    leg_opacity: float = quantity(
        VisualizationParameters, "leg_opacity", "", "of the translucent leg", ge=0, le=1
    )
    background: Annotated[list[Brightness], Len(3, 3)] = quantity(
        VisualizationParameters, "background", "", "linear red, green and blue of the studio"
    )
    figure_dots_per_inch: int = quantity(
        VisualizationParameters,
        "figure_dots_per_inch",
        "",
        "resolution of the figures",
        ge=30,
        le=1200,
    )
    blood_surface: BloodSurfaceSection = BloodSurfaceSection()
    film: FilmSection = FilmSection()

    def parameters(self, seed: int) -> VisualizationParameters:
        """The stage's parameters."""
        return to_parameters(
            self,
            VisualizationParameters,
            blood_surface=to_parameters(self.blood_surface, BloodSurfaceParameters),
            film=to_parameters(self.film, FilmParameters),
            seed=seed,
        )

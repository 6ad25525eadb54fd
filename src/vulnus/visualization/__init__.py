"""Surface of the blood, ray-traced pictures, film and figures of a run.

`draw_all` writes everything that a run's results allow; the other modules hold the single steps.
"""

from .draw import Drawn, RunToDraw, draw_all
from .frames import Frames, FramesOnDemand
from .injury_gallery import InjuryToDraw, draw_injury_gallery
from .parameters import (
    BloodSurfaceParameters,
    FilmParameters,
    Surroundings,
    VisualizationParameters,
)
from .surface import blood_surface

__all__ = [
    "BloodSurfaceParameters",
    "Drawn",
    "FilmParameters",
    "Frames",
    "FramesOnDemand",
    "InjuryToDraw",
    "RunToDraw",
    "Surroundings",
    "VisualizationParameters",
    "blood_surface",
    "draw_all",
    "draw_injury_gallery",
]

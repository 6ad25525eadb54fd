"""The injury for a page: the passage (the paper's Fig. 2), the wound (Fig. 3) and its report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..core.handoff import InjuryOutcome, TriangleSurface
from ..core.progress import Progress, SilentProgress
from .figure_style import save_figure
from .frames import Frames
from .impact_view import impact_picture, instants
from .injured_view import injured_picture
from .parameters import Surroundings, VisualizationParameters
from .render import Renderer
from .sheet import write_jpeg
from .wound_figures import wound_figure

_DOTS_PER_INCH = 110  # chosen: as wide on a page as the pictures


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InjuryToDraw:
    """One shot's result and its `frames` at `times` [s]; `projectiles` as in `RunToDraw`."""

    outcome: InjuryOutcome
    frames: Frames
    times: Sequence[float]
    projectiles: tuple[TriangleSurface, ...] = ()


def draw_injury_gallery(
    shown: InjuryToDraw,
    parameters: VisualizationParameters,
    *,
    directory: Path,
    name: str,
    progress: Progress | None = None,
) -> tuple[Path, ...]:
    """Draw `passage_NAME.jpg`, `wound_NAME.jpg` and `report_NAME.png` into `directory`; the files.

    Raises `RenderError` where the ray tracer is missing.
    """
    bar = progress or SilentProgress()
    outcome, frames = shown.outcome, shown.frames
    report = directory / f"report_{name}.png"
    files = [save_figure(wound_figure(outcome.report), report, _DOTS_PER_INCH)]
    renderer = Renderer(parameters)
    bar.begin("gallery", 2.0, "pictures")
    renderer.on_pass = lambda: bar.update(0.0)
    turning = outcome.temporary.time
    chosen = [
        frames[index] for index in instants(shown.times, outcome.permanent.shot, turning=turning)
    ]
    passage = impact_picture(renderer, outcome.permanent, chosen, shown.projectiles)
    files.append(write_jpeg(directory / f"passage_{name}.jpg", passage))
    renderer.on_pass = lambda: bar.update(1.0)
    wound = injured_picture(renderer, outcome.states, Surroundings())
    files.append(write_jpeg(directory / f"wound_{name}.jpg", wound))
    bar.end()
    return tuple(files)

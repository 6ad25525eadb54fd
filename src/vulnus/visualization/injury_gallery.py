"""The injury for a page: the passage (the paper's Fig. 2) and the wound (Fig. 3) as JPEG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ..core.handoff import InjuredLimb
from ..core.progress import Progress, SilentProgress
from .frames import Frames
from .impact_view import impact_picture, instants
from .injured_view import injured_picture
from .parameters import Surroundings, VisualizationParameters
from .render import Renderer
from .sheet import write_jpeg


def draw_injury_gallery(
    states: Mapping[str, InjuredLimb],
    frames: Frames,
    times: Sequence[float],
    parameters: VisualizationParameters,
    *,
    directory: Path,
    name: str,
    surroundings: Surroundings | None = None,
    progress: Progress | None = None,
) -> tuple[Path, ...]:
    """Draw `passage_NAME.jpg` and `wound_NAME.jpg` into `directory`; the files.

    `states` are the wound's, by name, the last one permanent; `frames` those of the passage at
    `times` [s]. Raises `RenderError` where the ray tracer is missing.
    """
    bar = progress or SilentProgress()
    renderer = Renderer(parameters)
    bar.begin("gallery", 2.0, "pictures")
    renderer.on_pass = lambda: bar.update(0.0)
    wounds = list(states.values())
    chosen = instants(times, wounds[-1].shot, turning=wounds[0].time)
    passage = impact_picture(renderer, wounds[-1], [frames[index] for index in chosen])
    files = [write_jpeg(directory / f"passage_{name}.jpg", passage)]
    renderer.on_pass = lambda: bar.update(1.0)
    wound = injured_picture(renderer, states, surroundings or Surroundings())
    files.append(write_jpeg(directory / f"wound_{name}.jpg", wound))
    bar.end()
    return tuple(files)

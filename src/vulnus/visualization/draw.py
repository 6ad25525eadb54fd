"""Everything that is drawn of a run, from its results alone: `figures/*.png` and `film.mp4`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.errors import RenderError
from ..core.handoff import (
    BleedOutcome,
    BleedWaveforms,
    InjuredLimb,
    LabelVolume,
    TriangleSurface,
    WoundReport,
)
from ..core.progress import Progress, SilentProgress
from .figure_style import save_figure
from .figures import cycle_figure, flow_figure, ledger_figure, pressure_figure
from .film import make_film, spread_indices
from .frames import Frames
from .limb_view import view_limb
from .parameters import Surroundings, VisualizationParameters
from .particle_figures import passage_figure, slices_figure
from .picture import Picture, to_srgb, write_png
from .pipeline_figure import PipelineStations, pipeline_figure
from .render import Renderer
from .stills import bleed_view, wound_view
from .surface import blood_surface, empty_surface
from .wound_figures import wound_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PASSAGE_ROWS = 4  # chosen: as many instants as the paper's Fig. 2 shows
_FILM_VOXEL_RATIO = 0.9  # chosen: at 640 px a coarser mesh cannot be told from a fine one


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RunToDraw:
    """The results of a run that can be drawn; what a run did not reach stays None or empty.

    `beat` is one heartbeat of the tree (Fig. 4), `blood_spacing` [m] the blood particles' own;
    `projectiles` are the surfaces of what flew, in their own frames, mass centre at 0.
    """

    wound: InjuredLimb
    report: WoundReport | None = None
    projectiles: tuple[TriangleSurface, ...] = ()
    surroundings: Surroundings = field(default_factory=Surroundings)
    labels: LabelVolume | None = None
    beat: BleedWaveforms | None = None
    outcome: BleedOutcome | None = None
    injury_frames: Frames = ()
    bleed_frames: Frames = ()
    blood_spacing: float = 0.0


@dataclass(frozen=True, slots=True)
class Drawn:
    """The files that were written, and what could not be drawn and why."""

    files: tuple[Path, ...]
    complaints: tuple[str, ...]


def draw_all(
    run: RunToDraw,
    parameters: VisualizationParameters,
    directory: Path,
    progress: Progress | None = None,
) -> Drawn:
    """Write `figures/*.png` and `film.mp4` into `directory`.

    The figures need matplotlib alone. Where the ray tracer or the encoder is missing, the rest is
    drawn and the complaint says what to install; no run fails for want of a picture.
    """
    if not parameters.enabled:
        return Drawn((), ())
    bar = progress or SilentProgress()
    files: list[Path] = []
    complaints: list[str] = []
    figures = directory / "figures"
    files += draw_figures(run, parameters, figures, bar)
    picture: Picture | None = None
    blood = last_blood(run, parameters)
    if parameters.stills or parameters.film.enabled:
        try:
            renderer = Renderer(parameters)
            if parameters.stills:
                stills, picture = _draw_stills(run, renderer, blood, figures, bar)
                files += stills
            if parameters.film.enabled:
                files.append(_draw_film(run, renderer, directory, bar))
        except RenderError as error:
            complaints.append(str(error))
    stations = PipelineStations(
        wound=run.wound,
        labels=run.labels,
        beat=run.beat,
        outcome=run.outcome,
        blood=blood,
        picture=picture,
    )
    figure = pipeline_figure(stations)
    files.append(save_figure(figure, figures / "pipeline.png", parameters.figure_dots_per_inch))
    return Drawn(tuple(files), tuple(complaints))


def draw_figures(
    run: RunToDraw, parameters: VisualizationParameters, directory: Path, bar: Progress
) -> list[Path]:
    """The curves, slices and point views that this run has the results for; their files."""
    wanted = _possible_figures(run)
    written = []
    bar.begin("figures", len(wanted), "figures")
    for name, make in wanted.items():
        dots = parameters.figure_dots_per_inch
        written.append(save_figure(make(), directory / f"{name}.png", dots))
        bar.update(len(written))
    bar.end()
    return written


def _possible_figures(run: RunToDraw) -> dict[str, Callable[[], Figure]]:
    artery = run.wound.severed_segment or "anterior_tibial"
    beat, outcome, labels, report = run.beat, run.outcome, run.labels, run.report
    figures: dict[str, Callable[[], Figure]] = {}
    if beat is not None:
        figures["cycle"] = lambda: cycle_figure(beat, artery=artery)
    if outcome is not None:
        figures["flow"] = lambda: flow_figure(outcome)
        figures["pressure"] = lambda: pressure_figure(outcome, artery=artery)
        figures["blood_loss"] = lambda: ledger_figure(outcome.ledger)
    if len(run.injury_frames) > 0:
        chosen = spread_indices(len(run.injury_frames), _PASSAGE_ROWS)
        figures["passage"] = lambda: passage_figure(
            run.wound, [run.injury_frames[index] for index in chosen], run.projectiles
        )
    if report is not None:
        figures["wound_report"] = lambda: wound_figure(report)
    if labels is not None:
        figures["slices"] = lambda: slices_figure(labels)
    return figures


def last_blood(run: RunToDraw, parameters: VisualizationParameters) -> TriangleSurface:
    """The blood's surface in the last frame; empty where nothing bleeds."""
    if len(run.bleed_frames) == 0:
        return empty_surface()
    frame = run.bleed_frames[len(run.bleed_frames) - 1]
    return blood_surface(frame.position, run.blood_spacing, parameters.blood_surface)


def _draw_stills(
    run: RunToDraw,
    renderer: Renderer,
    blood: TriangleSurface,
    directory: Path,
    bar: Progress,
) -> tuple[list[Path], Picture]:
    bleeds = blood.triangles.shape[0] > 0
    bar.begin("stills", 2.0 if bleeds else 1.0, "pictures")
    renderer.on_pass = lambda: bar.update(0.0)
    view = view_limb(run.wound, run.surroundings)
    picture = to_srgb(wound_view(renderer, view))
    files = [write_png(directory / "wound.png", picture)]
    if bleeds:
        renderer.on_pass = lambda: bar.update(1.0)
        picture = to_srgb(bleed_view(renderer, view, blood))
        files.append(write_png(directory / "bleeding.png", picture))
    bar.end()
    return files, picture


def _draw_film(run: RunToDraw, renderer: Renderer, directory: Path, bar: Progress) -> Path:
    view = view_limb(
        run.wound,
        run.surroundings,
        voxel_ratio=_FILM_VOXEL_RATIO,
        projectiles=run.projectiles,
    )
    return make_film(
        directory / "film.mp4",
        renderer,
        view,
        injury_frames=run.injury_frames,
        bleed_frames=run.bleed_frames,
        outcome=run.outcome,
        blood_spacing=run.blood_spacing,
        progress=bar,
    )

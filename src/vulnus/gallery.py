"""Pictures for a page, made from nothing by one command: the paper's Figs. 2 and 3."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from vulnus.core.errors import StorageError
from vulnus.core.handoff import InjuryOutcome
from vulnus.core.progress import Progress
from vulnus.core.units import MILLIMETRE
from vulnus.injury import projectile_surfaces
from vulnus.pipeline import Say, frames_on_demand, run_scenario, use_threads
from vulnus.scenario import Scenario, scenario_from_text
from vulnus.scenario.toml_text import value_as_toml
from vulnus.storage import RunStore
from vulnus.visualization import InjuryToDraw, draw_injury_gallery

PRESET = "tibial_impact"
_SAMPLES = 24  # paths a pixel; chosen by eye: no grain is left after denoising


@dataclass(frozen=True, slots=True, kw_only=True)
class GalleryWishes:
    """Which limbs to shoot, and how.

    `labels` is a label volume to shoot beside the built-in leg; `mode` and `grid_spacing` [m]
    replace the preset's where given.
    """

    labels: Path | None = None
    mode: str | None = None
    grid_spacing: float | None = None


def injury_gallery(
    directory: Path, wishes: GalleryWishes, progress: Progress, say: Say
) -> Iterator[Path]:
    """Shoot each limb up to its injury and draw it; the pictures, as they are finished.

    The runs stay in `directory/runs`; what is finished there is not computed again.
    """
    limbs: dict[str, Path | None] = {"builtin_leg": None}
    if wishes.labels is not None:
        limbs["labelled_leg"] = wishes.labels
    for name, labels in limbs.items():
        scenario = gallery_scenario(wishes, labels)
        use_threads(scenario.threads)
        with RunStore.create(
            directory / "runs" / name,
            scenario.text,
            resume=True,
            checkpoint_interval=scenario.checkpoint_interval,
        ) as store:
            say(f"{name.replace('_', ' ')}: {store.path}")
            run_scenario(scenario, store, progress, until="injury", say=say)
            yield from _draw(scenario, store, directory, name, progress)


def gallery_scenario(wishes: GalleryWishes, labels: Path | None) -> Scenario:
    """The gallery's preset with what is wished, for the built-in leg or for `labels`."""
    lines = [f"preset = {value_as_toml(PRESET)}"]
    if labels is not None:
        lines += ["[imaging]", f"source = {value_as_toml(str(labels.absolute()))}"]
    if wishes.grid_spacing is not None:
        half = 0.5 * wishes.grid_spacing / MILLIMETRE  # eight points a cell
        lines += ["[anatomy]", f"particle_spacing_mm = {half!r}"]
    lines.append("[injury]")
    if wishes.mode is not None:
        lines.append(f"mode = {value_as_toml(wishes.mode)}")
    if wishes.grid_spacing is not None:
        lines.append(f"grid_spacing_mm = {wishes.grid_spacing / MILLIMETRE!r}")
    return scenario_from_text("\n".join(lines), file="the gallery", folder=Path())


def _draw(
    scenario: Scenario, store: RunStore, directory: Path, name: str, progress: Progress
) -> tuple[Path, ...]:
    outcome = store.load_stage("injury", InjuryOutcome)
    if outcome is None:
        raise StorageError(
            str(store.path), "the run has no finished injury to draw", "Delete it and begin again"
        )
    return draw_injury_gallery(
        InjuryToDraw(
            outcome=outcome,
            frames=frames_on_demand(store.wound_frames),
            times=list(store.wound_frames.times().values()),
            projectiles=projectile_surfaces(scenario.injury),
        ),
        replace(scenario.visualization, samples=_SAMPLES),
        directory=directory,
        name=name,
        progress=progress,
    )

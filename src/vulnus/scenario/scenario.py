"""A scenario as the stages take it: frozen parameters in SI, and the text that gives them again."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vulnus.anatomy.parameters import AnatomyParameters
from vulnus.circulation.parameters import CirculationParameters
from vulnus.core.errors import InputFileError, ScenarioError
from vulnus.coupling.parameters import CouplingParameters
from vulnus.hemorrhage.parameters import HemorrhageParameters
from vulnus.imaging.parameters import ImagingParameters
from vulnus.injury.parameters import InjuryParameters
from vulnus.visualization.parameters import VisualizationParameters

from .config import ScenarioConfig
from .presets import preset_texts, purpose
from .quantity import Section, tables_of
from .reading import parse_config, read_config
from .toml_text import as_toml, value_as_toml

_FREE_KEYS = frozenset({"title", "run.threads", "run.checkpoint_interval_s"})
"""Keys that change no number of a run, so that a run may go on with other values."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """Everything a run depends on.

    `text` is the complete scenario as TOML; `inputs` the files that it reads; `checkpoint_interval`
    [s] of wall time; `threads` of the native loops, at least 1.
    """

    title: str
    seed: int
    threads: int
    checkpoint_interval: float
    inputs: tuple[Path, ...]
    text: str
    imaging: ImagingParameters
    anatomy: AnatomyParameters
    injury: InjuryParameters
    circulation: CirculationParameters
    hemorrhage: HemorrhageParameters
    coupling: CouplingParameters
    visualization: VisualizationParameters


def load_scenario(source: str | Path) -> Scenario:
    """The scenario of a TOML file or of a preset; ScenarioError where it cannot be used."""
    scenario = _in_si(read_config(source))
    for path in scenario.inputs:
        _require_file(path, str(source))
    return scenario


def _require_file(path: Path, scenario: str) -> None:
    """Raise `InputFileError` with the nearest name unless `path` is a file."""
    if path.is_file():
        return
    if path.is_dir():
        raise InputFileError(
            str(path),
            f"it is a directory, not a file (named in {scenario})",
            "Name a file in it",
        )
    try:
        names = [item.name for item in path.parent.iterdir()]
    except OSError:
        names = []
    close = difflib.get_close_matches(path.name, names, n=1, cutoff=0.6)
    raise InputFileError(
        str(path),
        f"there is no such file (named in {scenario}, relative to its folder)",
        f"Did you mean {path.with_name(close[0])}?" if close else "Correct the path",
    )


def scenario_from_text(text: str, *, file: str, folder: Path | None = None) -> Scenario:
    """The scenario in `text`, for example a run's own `scenario.toml`."""
    return _in_si(parse_config(text, file=file, folder=folder))


def scenario_text(source: str | Path) -> str:
    """The complete scenario of a file or preset, every default visible, as TOML."""
    return _text(read_config(source))


def preset_purposes() -> Mapping[str, str]:
    """Name of each preset to what it is for."""
    return {name: purpose(text) for name, text in preset_texts().items()}


def differences(kept: str, given: str) -> list[str]:
    """What a run's resolved text and another say differently, key by key."""
    before = dict(_flat(parse_config(kept, file="the run's scenario.toml", folder=None)))
    after = dict(_flat(parse_config(given, file="the scenario", folder=None)))
    return [
        f"{key} was {value_as_toml(before[key])}, now {value_as_toml(after[key])}"
        for key in before
        if key not in _FREE_KEYS and before[key] != after[key]
    ]


def _flat(section: Section, path: str = "") -> Iterator[tuple[str, Any]]:
    for name, field in type(section).model_fields.items():
        value = getattr(section, name)
        key = f"{path}.{name}" if path else name
        if isinstance(value, Section):
            yield from _flat(value, key)
        elif tables_of(field):
            yield key, [item.model_dump() for item in value]
        else:
            yield key, value


def _text(config: ScenarioConfig) -> str:
    return as_toml(
        config,
        "A complete vulnus scenario: every key with its meaning, unit and limits.\n"
        "Run it with: vulnus run FILE.toml -o DIRECTORY. A file may hold only keys that differ,\n"
        'with preset = "NAME" on top to take another scenario\'s values for the rest.\n',
    )


def _refuse_fine_cells(config: ScenarioConfig) -> None:
    cell, points = config.injury.grid_spacing_mm, config.anatomy.particle_spacing_mm
    if cell < points:
        raise ScenarioError(
            "injury.grid_spacing_mm",
            f"is {cell:g} mm, less than anatomy.particle_spacing_mm, {points:g} mm",
            "Use about twice the particles' spacing, or the tissue falls apart between cells",
        )


def _in_si(config: ScenarioConfig) -> Scenario:
    _refuse_fine_cells(config)
    run = config.run
    threads = run.threads or len(os.sched_getaffinity(0))
    imaging = config.imaging.parameters()
    meshes = (Path(one.stl) for one in config.injury.shots if one.stl is not None)
    files = (imaging.source, imaging.centrelines, *meshes)
    return Scenario(
        title=config.title,
        seed=run.seed,
        threads=threads,
        checkpoint_interval=run.checkpoint_interval_s,
        inputs=tuple(file for file in files if isinstance(file, Path)),
        text=_text(config),
        imaging=imaging,
        anatomy=config.anatomy.parameters(run.seed),
        injury=config.injury.parameters(
            seed=run.seed, threads=threads, gravity=config.hemorrhage.gravity()
        ),
        circulation=config.circulation.parameters(),
        hemorrhage=config.hemorrhage.parameters(seed=run.seed, threads=threads),
        coupling=config.coupling.parameters(),
        visualization=config.visualization.parameters(run.seed),
    )

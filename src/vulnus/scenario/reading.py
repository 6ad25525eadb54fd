"""From a scenario file or a preset's name to validated tables; every trouble is a ScenarioError."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from vulnus.core.errors import ScenarioError
from vulnus.imaging.parameters import BUILTIN_LEG

from .complaints import scenario_error
from .config import ScenarioConfig
from .presets import preset_texts
from .quantity import AUTO

_LARGEST_FILE = 1 << 20
_ALTERNATIVES = (
    (("artery", "target_mm"), ("artery", "target_mm")),
    (("projectiles",), ("projectile", "aim")),
    (("projectile", "aim"), ("projectiles",)),
)
"""Keys of a scenario, and which of its preset's they replace: one way to say it for another."""

_ANOTHER_PROJECTILE = ("name", "shape", "stl")
"""Keys of [injury.projectile] that begin a new one: nothing of the preset's table is kept, lest a
knife inherit a bullet's calibre and speed."""


def read_config(source: str | Path) -> ScenarioConfig:
    """The tables of the scenario file or preset `source`, complete with every default.

    A file's `preset = "NAME"` takes that preset as the base in place of the defaults. Paths in the
    file are taken relative to the file's folder and come out absolute.
    """
    texts = preset_texts()
    path = Path(source).expanduser()
    if str(source) in texts and not path.is_file():
        return parse_config(texts[str(source)], file=f"preset {source}", folder=None)
    return parse_config(_text_of(path), file=str(path), folder=path.absolute().parent)


def parse_config(text: str, *, file: str, folder: Path | None) -> ScenarioConfig:
    """The tables in `text`; `file` is what errors call it, `folder` the base of its paths."""
    tables = _parse(text, file)
    base = tables.pop("preset", None)
    if base is not None:
        known = preset_texts()
        if not isinstance(base, str) or base not in known:
            raise ScenarioError(
                f"{file}: preset = {base!r}", "there is no such preset", _nearest_preset(str(base))
            )
        below = _parse(known[base], f"preset {base}")
        if _tells_what_flies(tables):
            below.get("injury", {}).pop("projectile", None)
        tables = _over(below, tables)
    if folder is not None:
        _resolve_paths(tables, folder)
    try:
        return ScenarioConfig.model_validate(tables)
    except ValidationError as trouble:
        raise scenario_error(trouble, ScenarioConfig, file=file, text=text) from None


def _text_of(path: Path) -> str:
    try:
        if path.is_dir():
            inside = path / "scenario.toml"
            hint = f"; is {inside} meant" if inside.is_file() else ""
            raise ScenarioError(
                str(path), f"it is a directory, not a scenario file{hint}", "Give a .toml file"
            )
        if path.stat().st_size > _LARGEST_FILE:
            raise ScenarioError(
                str(path), "it is larger than 1 MiB, which no scenario is", "Give a .toml file"
            )
        return path.read_bytes().decode("utf-8-sig")  # some editors put a mark in front
    except FileNotFoundError:
        raise ScenarioError(
            str(path), "there is no such file or preset", _nearest_source(path)
        ) from None
    except UnicodeDecodeError as trouble:
        raise ScenarioError(
            str(path),
            f"it is not UTF-8 text (byte {trouble.start})",
            "Save it as UTF-8; a scenario is a TOML text file",
        ) from None
    except (OSError, ValueError) as trouble:
        reason = getattr(trouble, "strerror", None) or trouble
        raise ScenarioError(
            str(path), f"it cannot be read ({reason})", "Check the path and its permissions"
        ) from trouble


def _parse(text: str, file: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as trouble:
        end = f"at line {len(text.splitlines())}, the end of the file"
        raise ScenarioError(
            file,
            f"it is not valid TOML: {trouble}".replace("at end of document", end),
            "Correct that line; text stands in quotes, tables in [brackets]",
        ) from None
    except (ValueError, RecursionError) as trouble:
        raise ScenarioError(
            file,
            f"it cannot be read as TOML ({trouble})",
            "A number or a nesting in it is absurdly long; remove it",
        ) from None


def _tells_what_flies(tables: dict[str, Any]) -> bool:
    """Whether the file describes a projectile of its own, of which its preset's says nothing."""
    injury = tables.get("injury")
    projectile = injury.get("projectile") if isinstance(injury, dict) else None
    return isinstance(projectile, dict) and any(key in projectile for key in _ANOTHER_PROJECTILE)


def _over(base: dict[str, Any], top: dict[str, Any]) -> dict[str, Any]:
    """`base` with what `top` says instead; tables are merged key by key."""
    merged = dict(base)
    for keys, replaced in _ALTERNATIVES:
        if any(key in top for key in keys):
            merged = {key: value for key, value in merged.items() if key not in replaced}
    for key, value in top.items():
        below = merged.get(key)
        both = isinstance(below, dict) and isinstance(value, dict)
        merged[key] = _over(below, value) if both else value  # type: ignore[arg-type]
    return merged


def _resolve_paths(tables: dict[str, Any], folder: Path) -> None:
    for table, key, words in _paths(tables):
        value = table.get(key)
        if isinstance(value, str) and value not in words and "\0" not in value:
            # Not resolve(): a link stays a link, as the user named it.
            table[key] = str((folder / Path(value).expanduser()).absolute())


def _paths(tables: dict[str, Any]) -> Iterator[tuple[dict[str, Any], str, tuple[str, ...]]]:
    """Tables and their keys that hold a path, and the words that are none."""
    imaging, injury = tables.get("imaging"), tables.get("injury")
    if isinstance(imaging, dict):
        yield imaging, "source", (BUILTIN_LEG, "")
        yield imaging, "centrelines", (AUTO, "")
    if isinstance(injury, dict):
        several = injury.get("projectiles")
        for one in (injury.get("projectile"), *(several if isinstance(several, list) else ())):
            if isinstance(one, dict):
                yield one, "stl", (AUTO, "")


def _nearest_preset(name: str) -> str:
    known = list(preset_texts())
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return (f"Did you mean {close[0]}? " if close else "") + f"Presets: {', '.join(known)}"


def _nearest_source(path: Path) -> str:
    try:
        names = [item.name for item in path.parent.iterdir() if item.suffix == ".toml"]
    except OSError:
        names = []
    close = difflib.get_close_matches(path.name, names, n=1, cutoff=0.6)
    if close:
        return f"Did you mean {path.parent / close[0]}? Presets: {', '.join(preset_texts())}"
    return _nearest_preset(path.name)

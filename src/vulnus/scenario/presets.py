"""The scenarios that come with vulnus: what each is for stands in its first comment."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources


def preset_texts() -> Mapping[str, str]:
    """Name of each preset to its TOML text, which holds what differs from the defaults."""
    folder = resources.files(__package__) / "presets"
    return {
        item.name.removesuffix(".toml"): item.read_text(encoding="utf-8")
        for item in sorted(folder.iterdir(), key=lambda item: item.name)
        if item.name.endswith(".toml")
    }


def purpose(text: str) -> str:
    """The comment at the head of a preset: what it is for."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# ").rstrip())
    return " ".join(lines)

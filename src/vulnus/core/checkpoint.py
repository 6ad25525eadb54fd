"""How a long stage keeps what it cannot derive, so that a killed run goes on from there.

A checkpoint is a flat mapping from names to arrays, numbers and strings. Writing one replaces the
one before it, whole or not at all; `storage.RunStore` keeps it in the run directory.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from .arrays import AnyArray

CheckpointValue = AnyArray | float | int | str
CheckpointData = Mapping[str, CheckpointValue]


class Checkpoint(Protocol):
    """The place of one stage's newest checkpoint."""

    def load(self) -> CheckpointData | None:
        """The newest checkpoint, or None where the stage starts anew."""

    def save(self, data: CheckpointData) -> None:
        """Replace the checkpoint by `data`, atomically."""

    def due(self) -> bool:
        """Whether enough wall time has passed since the last save to write one now."""


class NoCheckpoint:
    """Keeps nothing; the default of every stage function."""

    def load(self) -> CheckpointData | None:
        """Nothing was kept."""
        return None

    def save(self, data: CheckpointData) -> None:
        """Keep nothing."""

    def due(self) -> bool:
        """Never due."""
        return False

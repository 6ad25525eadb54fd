"""What a long stage tells its caller: how far it is, so that a bar can show the time left."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Receives the progress of one stage at a time; the command line draws it as a bar."""

    def begin(self, stage: str, total: float, unit: str) -> None:
        """Start a stage that is complete at `total` [unit]."""

    def update(self, completed: float, note: str = "") -> None:
        """Report that `completed` of the total is done; called at least once a second."""

    def end(self) -> None:
        """Finish the stage begun last."""


class SilentProgress:
    """Shows nothing; the default of every stage function."""

    def begin(self, stage: str, total: float, unit: str) -> None:
        """Ignore the start of a stage."""

    def update(self, completed: float, note: str = "") -> None:
        """Ignore the report."""

    def end(self) -> None:
        """Ignore the end of a stage."""
